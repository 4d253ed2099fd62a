"""How a verdict follows from criteria and numbers, for claims and for digitised points alike."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from microimpact.ledgers.claims.criteria import UNDECIDED, Criterion, Finding, Verdict, holds

# Begins the bound that a number fails, in the words of a verdict.
REQUIRED = " (required: "

# Standard errors that a 95 % interval extends to either side.
COVERED = 1.96

# By case, then by quantity; the only case of what has no alternatives is "".
Numbers = Mapping[str, Mapping[str, float]]
NO_ERRORS: Numbers = {}


def judged(
    positive: Verdict, criteria: Iterable[Criterion], values: Numbers, errors: Numbers = NO_ERRORS
) -> tuple[Finding, list[str]]:
    """Return the verdict, and which criteria failed, in words.

    `positive`: the verdict if all criteria hold in every case; `criteria`: must all hold. If they
    do in some cases and not in others, it is `not identified`; `values`, `errors`: the numbers, and
    the standard errors of those that have one. Where the 95 % interval of a number covers the bound
    that would decide, it is `undecided`.
    """
    of = tuple(criteria)
    words = failures(of, values)
    found = {_case(of, own, errors.get(case, {})) for case, own in values.items()}
    if found == {True}:
        return positive, []
    if {True, False} <= found:
        return "not identified", words
    if None not in found:
        return "not reproduced", words
    covered = [
        f"{f'{case}: ' if case else ''}{c.quantity} = {own[c.quantity]:.4g} ± "
        f"{COVERED * errors[case][c.quantity]:.2g} covers its bound ({described(c)})"
        for case, own in values.items()
        for c in of
        if abs(margin(c, own, errors.get(case, {}))) < COVERED
    ]
    return UNDECIDED, [*words, *covered]


def margin(criterion: Criterion, values: Mapping[str, float], errors: Mapping[str, float]) -> float:
    """Return the distance of a number to its bound in standard errors; infinite without error.

    Negative where the criterion fails.
    """
    value, error = values[criterion.quantity], errors.get(criterion.quantity, 0.0)
    if error > 0.0:
        return criterion.distance(value) / error
    return math.inf if holds(criterion, value) else -math.inf


def least_margin(criteria: Iterable[Criterion], values: Numbers, errors: Numbers) -> float:
    """Return the margin that decides: in each case the worst, of these the nearest to its bound.

    Nan where the criteria that decide have no error.
    """
    of = tuple(criteria)
    worst = [
        min(margin(criterion, own, errors.get(case, {})) for criterion in of)
        for case, own in values.items()
        if of
    ]
    return min((one for one in worst if math.isfinite(one)), key=abs, default=math.nan)


def _case(
    criteria: Iterable[Criterion], values: Mapping[str, float], errors: Mapping[str, float]
) -> bool | None:
    """Tell whether all criteria hold in a case; none if the error of a number hides it."""
    margins = [margin(criterion, values, errors) for criterion in criteria]
    if any(one <= -COVERED for one in margins):
        return False
    return None if any(one < COVERED for one in margins) else True


def failures(criteria: Iterable[Criterion], values: Numbers) -> list[str]:
    """Return in words which criteria fail in which case."""
    of = tuple(criteria)
    return [
        f"{f'{case}: ' if case else ''}{criterion.quantity} = {own[criterion.quantity]:.4g}"
        f"{REQUIRED}{described(criterion)})"
        for case, own in values.items()
        for criterion in of
        if not holds(criterion, own[criterion.quantity])
    ]


def described(criterion: Criterion) -> str:
    """Return a criterion in words and numbers."""
    low, high = criterion.interval
    if criterion.test == "within":
        return f"{criterion.value:g} ± {criterion.tolerance:g}"
    if criterion.test in {"between", "outside"}:
        return f"{criterion.test} {low:g} and {high:g}"
    return f"{criterion.test.replace('_', ' ')} {criterion.value:g}"


def place(case: str, quantity: str) -> str:
    """Return the name of a quantity, with its case if it has one."""
    return f"{quantity} ({case})" if case else quantity
