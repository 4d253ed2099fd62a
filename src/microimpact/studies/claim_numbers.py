"""Numbers behind claims: how those of one claim come about, and those of many as a table."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from inspect import unwrap
from typing import Any, Self

import pandas as pd

from microimpact.core.nearest import nearest
from microimpact.lab.contacts import calibrated_contact
from microimpact.model.contact import Contact, resized


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CaseContext:
    """One case of steel on silicon, or none (""), with all settings and tables.

    Settings have a part ``steel``: its cases, and diameter and friction of the sphere that a claim
    means unless it says otherwise.
    """

    params: Any
    inputs: Mapping[str, pd.DataFrame]
    case: str = ""

    def cases(self) -> Iterator[Self]:
        """Yield the context of every case."""
        return (replace(self, case=case) for case in self.params.steel.cases)

    @property
    def steel(self) -> Contact:
        """Contact of the case, as large and with such friction as is meant."""
        contact = calibrated_contact(self.inputs, self.case)
        friction = self.params.steel.friction
        return resized(contact, self.params.steel.diameter_um * 1e-6).replace(friction=friction)

    def printed(self, key: str) -> float:
        """Return a printed value."""
        rows = self.inputs["anchors"].set_index("key")["value"].astype(float)
        if key not in rows:
            raise ValueError(f"anchors: {key!r} is not named")
        return float(rows[key])


@dataclass(frozen=True, slots=True, kw_only=True)
class Numbers:
    """How the numbers of one claim come about.

    Attributes
    ----------
    of
        Values by quantity, from the context.
    by_case
        Whether there are numbers for every case.
    evidence
        What they rest on.
    units
        Of the quantities that have one.
    """

    of: Callable[[Any], Mapping[str, float]]
    by_case: bool = False
    evidence: str = "computed"
    units: Mapping[str, str] = field(default_factory=dict)


def numbers_table(
    study: str, claims: Mapping[str, Numbers], wanted: Iterable[str], context: CaseContext
) -> pd.DataFrame:
    """Return the numbers of the claims wanted: per claim, case and quantity value, unit and code.

    Raises
    ------
    ValueError
        If a claim is not among those of the study.
    """
    for name in wanted:
        if name not in claims:
            raise ValueError(f"{study}.claims: no claim {name!r} here{nearest(name, claims)}")
    return pd.DataFrame([row for name in wanted for row in _rows(name, claims[name], context)])


def _rows(name: str, claim: Numbers, context: CaseContext) -> Iterator[dict[str, object]]:
    for each in context.cases() if claim.by_case else (context,):
        for quantity, value in claim.of(each).items():
            yield {
                "claim": name,
                "case": each.case,
                "quantity": quantity,
                "value": float(value),
                "unit": claim.units.get(quantity, "-"),
                "evidence": claim.evidence,
                "code": code_of(claim.of),
            }


def code_of(function: Callable[..., Any]) -> str:
    """Return module and name of a function, of the innermost if it wraps another."""
    innermost = unwrap(function)
    return f"{innermost.__module__}.{innermost.__qualname__}"
