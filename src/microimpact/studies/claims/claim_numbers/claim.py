"""How the numbers of a claim come about: a function of the context, registered by `claim`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from microimpact.core.tables import Row
from microimpact.studies.claims.claim_numbers.context import Context, Estimate, Numbers

VIRTUAL, CALIBRATED = "virtual experiment", "calibrated"

# The quantity of the row that stands for numbers that cannot be computed.
NOT_COMPUTED = "not computed"
# What the settings or the physics forbid. Errors of the program are none of these and end the run.
UNCOMPUTABLE = (ValueError, ArithmeticError, RuntimeError)


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """How the numbers of one claim come about."""

    of: Callable[[Context], Numbers]  # Numbers from the context
    by_case: bool  # Whether there are numbers for every case of steel on silicon
    evidence: str  # Their evidence
    units: str | Mapping[str, str]  # Unit of all quantities, or of those that have one

    def unit(self, quantity: str) -> str:
        """Return the unit of a quantity, ``-`` for none."""
        return self.units if isinstance(self.units, str) else self.units.get(quantity, "-")


class Read(dict[str, Any]):
    """Declared rows and tables, and the names of those that were read."""

    def __init__(self, tables: Mapping[str, Any]) -> None:
        super().__init__()
        self.tables, self.names = tables, set[str]()

    def __missing__(self, name: str) -> Any:
        """Return a table and note its name."""
        self.names.add(name)
        return self.tables[name]


CLAIMS: dict[str, Claim] = {}


def claim(
    name: str,
    *,
    by_case: bool = False,
    evidence: str = "computed",
    units: str | Mapping[str, str] = "-",
) -> Callable[[Callable[[Context], Numbers]], Callable[[Context], Numbers]]:
    """Register the function that computes the numbers of a claim; fields as in `Claim`.

    Raises ValueError if the claim has a function already.
    """

    def register(of: Callable[[Context], Numbers]) -> Callable[[Context], Numbers]:
        if name in CLAIMS:
            raise ValueError(f"claim {name!r} has a function already, {CLAIMS[name].of.__name__}")
        CLAIMS[name] = Claim(of=of, by_case=by_case, evidence=evidence, units=units)
        return of

    return register


def rows(name: str, context: Context) -> Iterator[Row]:
    """Yield the rows of a claim, with `COLUMNS`: numbers, or why there are none in a case."""
    own = CLAIMS[name]
    code = f"{own.of.__module__}.{own.of.__qualname__}"
    row = {"claim": name, "evidence": own.evidence, "code": code}
    read = Read(context.inputs)
    context = replace(context, inputs=read)
    for each in context.cases() if own.by_case else (context,):
        try:
            found = list(flat(own.of(each), each.case))
        except UNCOMPUTABLE as error:
            why = " ".join(f"{type(error).__name__}: {error}".split())
            found = [(each.case, NOT_COMPUTED, Estimate(math.nan, math.nan), why)]
        for case, quantity, number, problem in found:
            unit = own.unit(quantity) if not problem else "-"
            yield row | {
                "case": case,
                "quantity": quantity,
                "value": number.value,
                "error": number.error,
                "unit": unit,
                "inputs": " ".join(sorted(read.names)),
                "problem": problem,
            }


def flat(numbers: Numbers, case: str) -> Iterator[tuple[str, str, Estimate, str]]:
    """Yield case, quantity, number and problem (none); alternatives are named after the case."""
    for name, number in numbers.items():
        if isinstance(number, Mapping):
            yield from flat(number, f"{case}, {name}" if case else name)
            continue
        value, error = number if isinstance(number, Estimate) else (number, math.nan)
        if not math.isfinite(value):
            raise ArithmeticError(f"{name} = {value} is not a finite number")
        yield case, name, Estimate(float(value), float(error)), ""
