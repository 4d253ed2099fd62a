"""Claims of the article and the criteria fixed for them beforehand, read from one file.

``config/claims.yaml`` says what the article states, which numbers decide it and within which
bounds; it contains no result.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, ValidationError

from microimpact.core.arrays import FloatArray, Real
from microimpact.core.nearest import nearest
from microimpact.model.choices import FrictionBasis
from study import studies
from study.declared.documents import filled, load
from study.declared.parameters import Finite, Name, NonNegative, build, explain

CLAIM_NAME = r"^C\d{2,3}$"

Kind = Literal["model", "virtual experiment", "contradiction"]
Verdict = Literal[
    "reproduced",
    "reproduced with a correction",
    "calibrated",
    "not reproduced",
    "not identified",
    "not testable",
]
# What a claim gets if the error of a number covers the bound that decides; none can declare it, nor
# that it was not computed.
UNDECIDED: Literal["undecided"] = "undecided"
Finding = Literal[Verdict, "not computed", "undecided"]
# Without numbers, but those of equations: settings that it hangs on are told by its label.
QuantityName = Annotated[str, Field(pattern=r"^[a-z]+(_[a-z]+|_eq_\d+)*$")]
# A figure of the article, 01 to 25, or one of the project's own.
FigureName = Annotated[str, Field(pattern=r"^(fig(0[1-9]|1\d|2[0-5])|[a-z]+(_[a-z]+)*)$")]
EquationNumber = Annotated[str, Field(pattern=r"^([1-9]|[1-3]\d|4[01])$")]

ContactProperty = Literal[
    "work_of_adhesion", "hertz_damping", "adhesion_damping", "friction", "friction_basis"
]

# What a claim gets if all its criteria hold: a property of the claim, not of the result.
Positive = Literal["reproduced", "reproduced with a correction", "calibrated"]


class ClaimsError(ValueError):
    """A file of claims with problems: one line each, beginning with the dotted key."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Criterion:
    """Bounds of a number, which are accepted themselves: one end or both, or a tolerance."""

    at_least: Finite | None = None
    at_most: Finite | None = None
    within: tuple[Finite, NonNegative] | None = None  # A value, and how far from it

    def __post_init__(self) -> None:
        """Refuse no bound, an empty range, and ends beside a tolerance."""
        ends = [end for end in (self.at_least, self.at_most) if end is not None]
        if bool(ends) == bool(self.within):
            raise ValueError("needs at_least, at_most or both, or within alone")
        if len(ends) == 2 and ends[0] >= ends[1]:
            raise ValueError(f"at_least {ends[0]} must be below at_most {ends[1]}")

    @property
    def interval(self) -> tuple[float, float]:
        """Ends of the interval that is accepted, maybe infinite."""
        if self.within:
            # Decimal, so that 0.705 lies on the boundary of 0.70 +- 0.005.
            centre, reach = (Decimal(repr(number)) for number in self.within)
            return float(centre - reach), float(centre + reach)
        low, high = self.at_least, self.at_most
        return -math.inf if low is None else low, math.inf if high is None else high

    @property
    def row(self) -> dict[str, object]:
        """Test and ends in the columns of the table of results, nan for an infinite end."""
        low, high = (end if math.isfinite(end) else math.nan for end in self.interval)
        one_end = "at_most" if math.isnan(low) else "at_least"
        both = "within" if self.within else "between"
        return {"test": one_end if math.isnan(low + high) else both, "low": low, "high": high}

    def distance(self, value: Real) -> FloatArray:
        """Return the distance of numbers to the nearest bound, negative where they fail."""
        low, high = self.interval
        return np.minimum(value - low, high - value)


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """A number to compute: its label, and its unit, ``-`` for none."""

    label: Name
    unit: Name = "-"


@dataclass(frozen=True, slots=True, kw_only=True)
class Break:
    """One changed input or misprinted equation, and the verdict that must then come out."""

    change: Name  # In words
    expect: Verdict = "not reproduced"
    # The change as data, if it is one: an overlay of the configuration, and factors on properties
    # of all contacts, or another basis of their friction. A wrong form of the code is tried by a
    # test alone.
    set: dict[str, Any] = field(default_factory=dict)
    contacts: dict[ContactProperty, Finite | FrictionBasis] = field(default_factory=dict)

    @property
    def is_data(self) -> bool:
        """Whether the change can be made without other code."""
        return bool(self.set or self.contacts)


@dataclass(frozen=True, slots=True, kw_only=True)
class Amendment:
    """A part of a claim that was changed after the claim had first been judged."""

    part: Literal["statement", "kind", "criteria", "cases", "quantities", "verdicts", "break"]
    was: Name  # In words, before and after
    now: Name
    reason: Name  # In terms that do not depend on the verdict


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """A testable statement of the article and its criteria, fixed before the results.

    Attributes
    ----------
    id
        ``C`` and a number.
    where, quote
        Sections and figures, first the one of the quote; and a few words of the article.
    statement
        What is claimed, in our words.
    kind
        What the test is.
    article_value, unit
        The printed number, or the shape, sign or order claimed; its unit, ``-`` for none.
    quantities
        Numbers to compute: units, or units and labels where the name does not say all.
    criteria
        By quantity. All must hold; none if nothing was published to test.
    reason
        Why these bounds decide.
    if_met
        What comes out if all criteria hold.
    cases
        Alternatives that the published facts leave open. The criteria are judged in each;
        if some cases meet them and others do not, the claim is `not identified`.
    identified_if
        Criteria without which the published facts cannot decide: if one fails in any case, the
        claim is `not identified`.
    with_
        Settings of its function; ``with`` in the file. The configuration reads and checks them.
    figures, equations
        What it concerns.
    external
        Facts found by others that speak about it, by their words in the table of these.
    break_
        The control of the test; ``break`` in the file.
    amendments
        What was changed after the claim had first been judged, oldest first.
    """

    id: Annotated[str, Field(pattern=CLAIM_NAME)]
    where: Name
    quote: Name
    statement: Name
    kind: Kind = "model"
    article_value: Name
    unit: Name = "-"
    quantities: dict[QuantityName, Name | Quantity] = field(default_factory=dict)
    criteria: dict[QuantityName, Criterion] = field(default_factory=dict)
    reason: Name
    if_met: Positive = "reproduced"
    cases: tuple[Name, ...] = ()
    identified_if: dict[QuantityName, Criterion] = field(default_factory=dict)
    with_: Annotated[dict[str, Any], Field(alias="with")] = field(default_factory=dict)
    figures: tuple[FigureName, ...] = ()
    equations: tuple[EquationNumber, ...] = ()
    external: tuple[Name, ...] = ()
    break_: Annotated[Break | None, Field(alias="break")] = None
    amendments: tuple[Amendment, ...] = ()

    def __post_init__(self) -> None:
        """Refuse a claim whose parts do not fit together."""
        for name in self.tests:
            if name not in self.quantities:
                known = nearest(name, self.quantities)
                raise ValueError(f"'{name}' is not among the quantities{known}")
        if len(self.cases) == 1:
            raise ValueError("cases: one alone is no alternative")
        if self.testable != (self.break_ is not None):
            raise ValueError("a claim with criteria needs a break, one without has none")
        if self.break_ and self.break_.expect not in self.verdicts:
            expected = f"'{self.break_.expect}', which is not among the verdicts"
            raise ValueError(f"break expects {expected}: {', '.join(self.verdicts)}")

    @property
    def tests(self) -> dict[str, Criterion]:
        """All criteria by quantity, those first without which nothing is identified."""
        return {**self.identified_if, **self.criteria}

    @property
    def testable(self) -> bool:
        """Whether there are criteria."""
        return bool(self.criteria)

    @property
    def units(self) -> dict[str, str]:
        """Units by quantity."""
        return {
            name: quantity if isinstance(quantity, str) else quantity.unit
            for name, quantity in self.quantities.items()
        }

    @property
    def labels(self) -> dict[str, str]:
        """Labels by quantity."""
        return {
            name: name.replace("_", " ") if isinstance(quantity, str) else quantity.label
            for name, quantity in self.quantities.items()
        }

    @property
    def evidence(self) -> str:
        """Class of evidence of its numbers."""
        if not self.testable:
            return ""
        if self.if_met == "calibrated":
            return self.if_met
        return self.kind if self.kind == "virtual experiment" else "computed"

    @property
    def verdicts(self) -> tuple[Verdict, ...]:
        """Verdicts that are possible."""
        if not self.testable:
            return ("not testable",)
        is_open: tuple[Verdict, ...] = ("not identified",)
        return (self.if_met, "not reproduced", *is_open * bool(self.cases or self.identified_if))


def read_claims(path: Path | str, values: Mapping[str, Any] | None = None) -> dict[str, Claim]:
    """Read and check a file of claims.

    Parameters
    ----------
    values
        Parameters of ``claim_numbers``, to be put into the words, a claim's own by their names
        alone; without them the words keep the names, and numbers are not asked for.

    Raises
    ------
    ClaimsError
        Naming the dotted key of every problem in any claim, one line each, or a claim without
        numbers, or numbers without a claim.
    ConfigError
        If the words name a parameter that there is not.
    """
    claims, problems = {}, []
    for key, entry in load(path).items():
        if not isinstance(entry, Mapping):
            problems.append(f"{key}: {entry!r} must be a mapping")
            continue
        try:
            known = values and {**values, **values.get(key, {})}
            words = filled(entry, known, str(key)) if known else entry
            claims[key] = build(Claim, {"id": str(key), **words})
        except ValidationError as error:
            # The field cannot bear the name of its key, a word of the language.
            problems += [
                line.replace("'break_'", "'break'") for line in explain(error, Claim, str(key))
            ]
    if values is not None and not problems:
        computed = studies.study("claim_numbers").CLAIMS
        judged = {name for name, claim in claims.items() if claim.testable}
        for name in sorted(judged ^ {*computed}):
            lacking = "function" if name in judged else "claim"
            problems.append(f"{name}: claim_numbers: there is no {lacking} of this name")
    if problems:
        raise ClaimsError("\n".join(problems))
    return dict(sorted(claims.items(), key=lambda item: int(item[0][1:])))
