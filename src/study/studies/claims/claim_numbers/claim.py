"""How the numbers of a claim come about: a function of the context, registered by `claim`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from study.studies.claims.claim_numbers.context import Context, Estimate, Numbers
from study.tables import NOT_COMPUTED, UNCOMPUTABLE, Row, reason


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """How the numbers of one claim come about."""

    function: Callable[[Context], Numbers]  # Numbers from the context
    by_case: bool  # Whether there are numbers for every case of steel on silicon


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
    name: str, *, by_case: bool = False
) -> Callable[[Callable[[Context], Numbers]], Callable[[Context], Numbers]]:
    """Register the function that computes the numbers of a claim.

    Parameters
    ----------
    name
        The claim's, as in ``config/claims.yaml``.
    by_case
        As in `Claim`.

    Raises
    ------
    ValueError
        If the claim has a function already.
    """

    def register(function: Callable[[Context], Numbers]) -> Callable[[Context], Numbers]:
        if name in CLAIMS:
            raise ValueError(f"claim {name!r} has a function already")
        CLAIMS[name] = Claim(function=function, by_case=by_case)
        return function

    return register


def rows(name: str, context: Context) -> Iterator[Row]:
    """Yield the rows of a claim, with `COLUMNS`: numbers, or why there are none in a case."""
    entry = CLAIMS[name]
    code = f"{entry.function.__module__}.{entry.function.__qualname__}"
    row = {"claim": name, "code": code}
    read = Read(context.inputs)
    context = replace(context, inputs=read)
    for each in context.cases() if entry.by_case else (context,):
        try:
            numbers = list(flat(entry.function(each), each.case))
        except UNCOMPUTABLE as error:
            why = reason(type(error).__name__, error)
            numbers = [(each.case, NOT_COMPUTED, Estimate(math.nan, math.nan), why)]
        for case, quantity, number, problem in numbers:
            yield row | {
                "case": case,
                "quantity": quantity,
                "value": number.value,
                "error": number.error,
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
