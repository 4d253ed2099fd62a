"""A claim of the article: its statement, the numbers that decide it, and their function.

Rules from which every criterion follows
  - A printed number holds within half a unit of its last digit plus the uncertainty of its inputs.
    "About", "roughly", "approximately" mean +-10 %. A printed power of ten holds within half a
    decade. Anything else is a shape, a sign or an inequality.
  - An inequality or sign of computed numbers holds if it exceeds numerical error: by 0.001 of the
    quantity (a ratio beyond 0.999 or 1.001, a difference beyond 0.001).
  - An inequality or sign of measured means must be one that experiments of 40 events could have
    seen. Its quantity, whose name ends in ``_over_half_width``, is the difference of the means of a
    large virtual sample over the half-width of the 95 % interval of that difference; its bound is 1.
  - The impulse ratio is positive where friction retards, as in the article's plots, unless a
    quantity is called signed (Eq. 2, negative where friction retards a positive speed).
  - Steel on silicon: the mean sphere of SST76 at the nominal speed, without initial spin, unless
    the claim says otherwise.

Criteria were fixed first; changes after the first judgement stand in ``config/amendments.csv`` with
their reason. How a verdict follows from criteria and numbers: `study.judge`.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass, field, fields, make_dataclass, replace
from decimal import Decimal
from string import Formatter
from typing import Any, Literal, get_type_hints

import numpy as np

from microimpact.core.arrays import FloatArray, Real
from microimpact.core.computable import NotComputable
from study.claims.context import Common, Context, Estimate, Numbers, Read
from study.declared.documents import filled
from study.tables import NOT_COMPUTED, Row

Kind = Literal["model", "virtual experiment", "contradiction"]
# What a claim gets if all its criteria hold: a property of the claim, not of the result.
Positive = Literal["reproduced", "reproduced with a correction", "calibrated"]
Function = Callable[..., Numbers]

# Columns of the table of numbers. A row with a problem stands for numbers that could not be
# computed; the case is empty where nothing is left open.
NUMBER_COLUMNS = ("claim", "case", "quantity", "value", "error", "code", "inputs", "problem")
# The calibrated contacts of steel on silicon, of which nothing printed prefers one.
RIDGE = ("steel-silicon, n = 0", "steel-silicon, n = 1")


@dataclass(frozen=True, slots=True)
class Number:
    """A number of a claim: label (its name, if empty) and unit; and the bounds that it must meet.

    Bounds are accepted themselves: one end or both, or a value and how far from it. Settings that a
    number hangs on stand in its label, not in its name. Without the bounds of one that `identifies`
    the published facts cannot decide.
    """

    label: str = ""
    unit: str = "-"
    _: KW_ONLY
    at_least: float | None = None
    at_most: float | None = None
    within: tuple[float, float] | None = None
    identifies: bool = False

    def __post_init__(self) -> None:
        """Refuse an empty range, and ends beside a tolerance."""
        low, high = self.at_least, self.at_most
        if self.within and (low, high) != (None, None):
            raise ValueError("within stands alone")
        if low is not None and high is not None and low >= high:
            raise ValueError(f"at_least {low} must be below at_most {high}")

    @property
    def is_tested(self) -> bool:
        """Whether there are bounds."""
        return (self.at_least, self.at_most, self.within) != (None, None, None)

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


@dataclass(frozen=True, slots=True)
class Claim:
    """A testable statement of the article, its criteria, and the function of its numbers.

    As a decorator it declares the claim that a function computes the numbers of: from the context,
    and from settings by name, the function's keyword arguments, which the analysis ``claim_numbers``
    declares under the name of the claim. ``[[name]]`` in any text is such a setting.

    Attributes
    ----------
    id
        ``C`` and a number.
    statement
        What is claimed, in our words.
    where, quote
        Sections and figures, first the one of the quote; and a few words of the article.
    article, unit
        The printed number, or the shape, sign or order claimed; its unit, ``-`` for none.
    says
        What the numbers say, as a sentence with their names for ``{places}``, see `words.outcome`.
    numbers
        By name, in the order of the results; none if nothing was published to test.
    reason
        Why these bounds decide.
    kind
        What the test is.
    if_met
        What comes out if all criteria hold.
    cases
        Alternatives that the published facts leave open. The criteria are judged in each; if some
        cases meet them and others do not, the claim is `not identified`.
    figures, equations
        What it concerns, separated by blanks.
    external
        Facts found by others that speak about it, by their words in the table of these.
    by_case
        Whether there are numbers for every case of steel on silicon.
    assumed
        Inputs that are not published and decide: criteria that fail with them refute nothing.
    by_contact
        Whether it takes steel as a contact of arrays (n,), and has numbers for each; by case, too.
    """

    id: str
    statement: str
    _: KW_ONLY
    where: str
    article: str
    reason: str
    says: str = ""
    numbers: Mapping[str, Number] = field(default_factory=dict)
    quote: str = ""
    kind: Kind = "model"
    unit: str = "-"
    if_met: Positive = "reproduced"
    cases: tuple[str, ...] = ()
    figures: str = ""
    equations: str = ""
    external: tuple[str, ...] = ()
    assumed: str = ""
    by_case: bool = False
    by_contact: bool = False
    function: Function | None = None

    def __post_init__(self) -> None:
        """Refuse a sentence that leaves out a number that is tested, or names an unknown one."""
        named = {name for _, name, _, _ in Formatter().parse(self.says) if name}
        if self.says and (named - {*self.numbers} or {*self.tests} - named):
            raise ValueError(f"claim {self.id!r}: says must tell all of {', '.join(self.tests)}")

    def __call__(self, function: Function) -> Function:
        """Register the function that computes the numbers.

        Raises ValueError if the claim has a function already.
        """
        if self.id in CLAIMS:
            raise ValueError(f"claim {self.id!r} has a function already")
        CLAIMS[self.id] = replace(self, function=function)
        return function

    @property
    def tests(self) -> dict[str, Number]:
        """All numbers with bounds, those first without which nothing is identified."""
        return {n: each for n, each in self.numbers.items() if each.identifies} | self.criteria

    @property
    def criteria(self) -> dict[str, Number]:
        """Numbers whose bounds must all hold."""
        return {n: e for n, e in self.numbers.items() if e.is_tested and not e.identifies}

    @property
    def identified_if(self) -> dict[str, Number]:
        """Numbers without whose bounds, in any case, the published facts cannot decide."""
        return {name: each for name, each in self.numbers.items() if each.identifies}

    @property
    def testable(self) -> bool:
        """Whether there are criteria."""
        return bool(self.criteria)

    @property
    def units(self) -> dict[str, str]:
        """Units by number."""
        return {name: number.unit for name, number in self.numbers.items()}

    @property
    def labels(self) -> dict[str, str]:
        """Labels by number."""
        return {n: each.label or n.replace("_", " ") for n, each in self.numbers.items()}

    @property
    def evidence(self) -> str:
        """Class of evidence of its numbers."""
        if not self.testable:
            return ""
        if self.if_met == "calibrated":
            return self.if_met
        return self.kind if self.kind == "virtual experiment" else "computed"

    @property
    def code(self) -> str:
        """Full name of its function."""
        named = self.function
        return f"{named.__module__}.{named.__qualname__}" if named else ""

    def filled(self, values: Mapping[str, Any]) -> Claim:
        """Return the claim with parameters of ``claim_numbers`` in its words, its own first.

        Raises ConfigError if the words name a parameter that there is not.
        """
        known = {**values, **values.get(self.id, {})}
        texts = {key: getattr(self, key) for key in ("statement", "says", "article", "reason")}
        labels = {name: number.label for name, number in self.numbers.items()}
        words = filled({**texts, "numbers": labels, "cases": [*self.cases]}, known, self.id)
        labels, cases = words.pop("numbers"), tuple(words.pop("cases"))
        numbers = {n: replace(each, label=labels[n]) for n, each in self.numbers.items()}
        return replace(self, **words, numbers=numbers, cases=cases)

    def settings(self) -> type | None:
        """Return the dataclass of its settings, the keyword arguments of its function, if any."""
        named = inspect.signature(self.function).parameters.values() if self.function else ()
        names = [each.name for each in named if each.kind is each.KEYWORD_ONLY]
        hints = get_type_hints(self.function, include_extras=True) if names else {}
        parts = [(name, hints[name]) for name in names]
        kind = make_dataclass(self.id, parts, frozen=True, slots=True, kw_only=True)
        return kind if names else None

    def computed(self, context: Context) -> Numbers:
        """Return its numbers in a context."""
        settings = getattr(context.params, self.id, None)
        named = {f.name: getattr(settings, f.name) for f in fields(settings)} if settings else {}
        if self.function is None:
            raise ValueError(f"{self.id}: nothing was published to test")
        return self.function(context, **named)


# Every claim by its id, as the modules of the sections are imported.
CLAIMS: dict[str, Claim] = {}


def untestable(claim: Claim) -> None:
    """Register a claim that has no numbers."""
    CLAIMS[claim.id] = claim


def ascending(*, testable: bool = True) -> list[str]:
    """Return the ids of all claims in their order, or of those with numbers."""
    names = [name for name, claim in CLAIMS.items() if claim.testable or not testable]
    return sorted(names, key=lambda name: int(name[1:]))


def params() -> type:
    """Return the dataclass of all settings: those of each claim in a field of its name."""
    kinds = {name: CLAIMS[name].settings() for name in ascending()}
    parts = [(name, kind) for name, kind in kinds.items() if kind]
    return make_dataclass("Params", parts, bases=(Common,), frozen=True, kw_only=True)


def rows(name: str, context: Context) -> Iterator[Row]:
    """Yield the rows of a claim, with `COLUMNS`: numbers, or why there are none in a case."""
    entry = CLAIMS[name]
    row = {"claim": name, "code": entry.code}
    read = Read(context.inputs)
    context = replace(context, inputs=read)
    for each in context.cases() if entry.by_case or entry.by_contact else (context,):
        try:
            numbers = entry.computed(each.stacked() if entry.by_contact else each)
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
