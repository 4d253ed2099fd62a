"""How the numbers of a claim come about: a function of the context, registered by `claim`."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, make_dataclass, replace
from typing import Any, get_type_hints

from microimpact.core.computable import NotComputable
from study.studies.claims.claim_numbers.context import Common, Context, Estimate, Numbers
from study.tables import NOT_COMPUTED, Row

Function = Callable[..., Numbers]


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """How the numbers of one claim come about."""

    name: str
    function: Function  # Numbers from the context, and from settings by name
    by_case: bool  # Whether there are numbers for every case of steel on silicon
    by_contact: bool  # Whether it takes steel as a contact of arrays (n,), and has numbers for each

    def settings(self) -> type | None:
        """Return the dataclass of its settings, the keyword arguments of its function, if any."""
        named = inspect.signature(self.function).parameters.values()
        names = [each.name for each in named if each.kind is each.KEYWORD_ONLY]
        hints = get_type_hints(self.function, include_extras=True) if names else {}
        parts = [(name, hints[name]) for name in names]
        kind = make_dataclass(self.name, parts, frozen=True, slots=True, kw_only=True)
        return kind if names else None

    def numbers(self, context: Context) -> Numbers:
        """Return its numbers in a context."""
        settings = getattr(context.params, self.name, None)
        named = {f.name: getattr(settings, f.name) for f in fields(settings)} if settings else {}
        return self.function(context, **named)


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
    name: str, *, by_case: bool = False, by_contact: bool = False
) -> Callable[[Function], Function]:
    """Register the function that computes the numbers of a claim.

    Parameters
    ----------
    name
        The claim's, as in ``config/claims.yaml``.
    by_case, by_contact
        As in `Claim`; the latter has the former with it.

    Raises
    ------
    ValueError
        If the claim has a function already.
    """

    def register(function: Function) -> Function:
        if name in CLAIMS:
            raise ValueError(f"claim {name!r} has a function already")
        CLAIMS[name] = Claim(
            name=name, function=function, by_case=by_case or by_contact, by_contact=by_contact
        )
        return function

    return register


def ascending() -> list[str]:
    """Return the names of all claims in their order."""
    return sorted(CLAIMS, key=lambda name: int(name[1:]))


def params() -> type:
    """Return the dataclass of all settings: those of each claim in a field of its name."""
    kinds = {name: CLAIMS[name].settings() for name in ascending()}
    parts = [(name, kind) for name, kind in kinds.items() if kind]
    return make_dataclass("Params", parts, bases=(Common,), frozen=True, kw_only=True)


def rows(name: str, context: Context) -> Iterator[Row]:
    """Yield the rows of a claim, with `COLUMNS`: numbers, or why there are none in a case."""
    entry = CLAIMS[name]
    code = f"{entry.function.__module__}.{entry.function.__qualname__}"
    row = {"claim": name, "code": code}
    read = Read(context.inputs)
    context = replace(context, inputs=read)
    for each in context.cases() if entry.by_case else (context,):
        try:
            numbers = entry.numbers(each.stacked() if entry.by_contact else each)
            results = [
                {"case": case, "quantity": name, **finite(name, number)._asdict(), "problem": ""}
                for case, name, number in flat(numbers, each.case)
            ]
        except NotComputable as error:
            why = " ".join(str(error).split())
            results = [{"case": each.case, "quantity": NOT_COMPUTED, "problem": why}]
        for result in results:
            yield row | result | {"inputs": " ".join(sorted(read.names))}


def flat(numbers: Numbers, case: str) -> Iterator[tuple[str, str, Any]]:
    """Yield case, quantity and number or `Estimate`; alternatives are named after the case."""
    for name, number in numbers.items():
        if isinstance(number, Mapping):
            yield from flat(number, f"{case}, {name}" if case else name)
        else:
            yield case, name, number


def finite(quantity: str, number: Any) -> Estimate:
    """Return a number and its error, nan if there is none.

    Raises NotComputable if the number is not finite.
    """
    value, error = number if isinstance(number, Estimate) else (number, math.nan)
    value = float(value.item()) if hasattr(value, "item") else float(value)
    if not math.isfinite(value):
        raise NotComputable(f"{quantity} = {value} is not a finite number")
    return Estimate(value, float(error))
