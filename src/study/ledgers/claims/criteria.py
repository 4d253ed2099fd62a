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
# The key of a file of claims that is no claim.
DIGITISED = "digitised"

Kind = Literal["model", "virtual experiment", "arithmetic", "contradiction", "finding"]
Test = Literal["within", "at_least", "at_most", "between", "outside"]
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

# Kinds that are listed but not counted among the statements of the article.
UNCOUNTED: tuple[Kind, ...] = ("arithmetic", "finding")

# What a claim gets if all its criteria hold: a property of the claim, not of the result.
Positive = Literal["reproduced", "reproduced with a correction", "calibrated"]

# Bounds that each test takes.
BOUNDS: Mapping[Test, tuple[str, ...]] = {
    "within": ("value", "tolerance"),
    "at_least": ("value",),
    "at_most": ("value",),
    "between": ("low", "high"),
    "outside": ("low", "high"),
}


class ClaimsError(ValueError):
    """A file of claims with problems: one line each, beginning with the dotted key."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Criterion:
    """A test of one quantity; which bounds it takes is laid down in `BOUNDS`."""

    quantity: QuantityName
    test: Test
    value: Finite | None = None
    tolerance: NonNegative | None = None
    low: Finite | None = None
    high: Finite | None = None

    def __post_init__(self) -> None:
        """Refuse bounds that the test lacks or does not take, and an empty range."""
        wanted = BOUNDS[self.test]
        for name in ("value", "tolerance", "low", "high"):
            present = getattr(self, name) is not None
            if present != (name in wanted):
                has = "does not take" if present else "needs"
                raise ValueError(f"{self.test} {has} '{name}' (it takes {' and '.join(wanted)})")
        if self.low is not None and self.high is not None and self.low >= self.high:
            raise ValueError(f"low {self.low} must be below high {self.high}")

    @property
    def interval(self) -> tuple[float, float]:
        """Ends of the interval that is accepted, or by `outside` refused, maybe infinite."""
        if self.low is not None and self.high is not None:
            return self.low, self.high
        centre = Decimal(repr(self.value))
        if self.test == "within":
            # Decimal, so that 0.705 lies on the boundary of 0.70 +- 0.005.
            reach = Decimal(repr(self.tolerance))
            return float(centre - reach), float(centre + reach)
        bound = float(centre)
        return (bound, math.inf) if self.test == "at_least" else (-math.inf, bound)

    @property
    def row(self) -> dict[str, object]:
        """Test and ends in the columns of the table of results, nan for an infinite end."""
        ends = (end if math.isfinite(end) else math.nan for end in self.interval)
        return {"test": self.test, **dict(zip(("low", "high"), ends, strict=True))}

    def distance(self, value: Real) -> FloatArray:
        """Return the distance of numbers to the nearest bound, negative where they fail.

        Boundaries belong to the accepted side, and are those of the decimal numbers as written:
        `within` accepts ``value - tolerance <= x <= value + tolerance``, `at_least` ``x >= value``,
        `at_most` ``x <= value``, `between` ``low <= x <= high``, and `outside` ``x <= low`` or
        ``x >= high``.
        """
        low, high = self.interval
        inside = np.minimum(value - low, high - value)
        return np.asarray(-inside if self.test == "outside" else inside)


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """A number to compute: its unit, ``-`` for none, and its label."""

    unit: Name
    label: Name


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
        Sections and figures, first the one of the quote; and a few words of the article, none for
        a finding.
    statement
        What is claimed, in our words.
    kind
        What the test is; rows `arithmetic` (an identity, or what a model assumes) and `finding`
        (of this study, not of the article) are listed but not counted.
    article_value, unit
        The printed number, or the shape, sign or order claimed; its unit, ``-`` for none.
    quantities
        Numbers to compute: units, or units and labels where the name does not say all.
    criteria
        All must hold; none if nothing was published to test.
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
    quote: str = ""
    statement: Name
    kind: Kind = "model"
    article_value: Name
    unit: Name = "-"
    quantities: dict[QuantityName, Name | Quantity] = field(default_factory=dict)
    criteria: tuple[Criterion, ...] = ()
    reason: Name
    if_met: Positive = "reproduced"
    cases: tuple[Name, ...] = ()
    identified_if: tuple[Criterion, ...] = ()
    with_: Annotated[dict[str, Any], Field(alias="with")] = field(default_factory=dict)
    figures: tuple[FigureName, ...] = ()
    equations: tuple[EquationNumber, ...] = ()
    external: tuple[Name, ...] = ()
    break_: Annotated[Break | None, Field(alias="break")] = None
    amendments: tuple[Amendment, ...] = ()

    def __post_init__(self) -> None:
        """Refuse a claim whose parts do not fit together."""
        for criterion in (*self.criteria, *self.identified_if):
            if (name := criterion.quantity) not in self.quantities:
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
        if key == DIGITISED:
            continue
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
