"""How a verdict follows from criteria and numbers, for claims and for digitised points alike."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from microimpact.ledgers.claims.criteria import Criterion, Verdict, holds

# Begins the bound that a number fails, in the words of a verdict.
REQUIRED = " (required: "

# By case, then by quantity; the only case of what has no alternatives is "".
Numbers = Mapping[str, Mapping[str, float]]


def judged(
    positive: Verdict, criteria: Iterable[Criterion], values: Numbers
) -> tuple[Verdict, list[str]]:
    """Return the verdict, and which criteria failed, in words.

    Parameters
    ----------
    positive
        The verdict if all criteria hold in every case.
    criteria
        Must all hold. If they do in some cases and not in others, it is `not identified`.
    values
        The numbers.
    """
    of = tuple(criteria)
    failed = {case: failures(of, {case: own}) for case, own in values.items()}
    words = [line for lines in failed.values() for line in lines]
    if not words:
        return positive, []
    met = any(not lines for lines in failed.values())
    return ("not identified" if met else "not reproduced"), words


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
