"""How a verdict follows from criteria and numbers.

A claim is evaluated for alternatives that the published facts leave open: calibrated cases, or, in
each scenario, draws of the contacts that the printed statements admit. The share of them that meets
all criteria decides.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from microimpact.core.arrays import FloatArray
from study.claims.claim import Number
from study.judge.criteria import UNDECIDED, Finding, Verdict
from study.tables import Row

if TYPE_CHECKING:
    import pandas as pd

# Columns of the table of results: every number with the test that it must pass, if there is one.
RESULT_COLUMNS = (
    *("id", "case", "quantity", "label", "value", "error", "unit", "test", "low", "high"),
    "passed",
)
NUMBER = ("case", "quantity", "value", "error")
UNTESTED: Row = {"test": "", "low": math.nan, "high": math.nan, "passed": None}
# A claim is decided if its criteria hold in at least, or at most, these shares of the alternatives.
MOST, FEWEST = 0.95, 0.05
# Standard errors that a 95 % interval extends to either side.
COVERED = 1.96


def margins(
    criteria: Mapping[str, Number], values: pd.DataFrame, errors: pd.DataFrame | None = None
) -> FloatArray:
    """Return the distance of the worst number of each alternative from its bound.

    Parameters
    ----------
    criteria
        By quantity; at least one.
    values, errors
        Numbers, and the standard errors of those that have some: a row per alternative, a column
        per quantity.

    Returns
    -------
    numpy.ndarray
        Shape (alternatives,), in standard errors; negative where a criterion fails, and infinite
        where the number that decides has no error.
    """
    each = []
    for name, criterion in criteria.items():
        distance = criterion.distance(values[name].to_numpy(float))
        margin = np.where(distance >= 0.0, np.inf, -np.inf)
        if errors is not None:
            error = errors[name].to_numpy(float)
            np.divide(distance, error, out=margin, where=error > 0.0)
        each.append(margin)
    return np.asarray(np.min(each, axis=0))


def verdict(positive: Verdict, margin: FloatArray) -> Finding:
    """Return the verdict by the share of cases whose margins meet the criteria.

    The 95 % intervals of numbers may cover their bounds: such cases meet them possibly.
    """
    return judged(positive, [(np.mean(margin >= COVERED), np.mean(margin > -COVERED))])


def judged(positive: Verdict, shares: Iterable[tuple[float | np.floating[Any], ...]]) -> Finding:
    """Return the verdict by shares that meet the criteria, one for each scenario.

    `positive` if all are at least `MOST`, ``not reproduced`` if all are at most `FEWEST`, ``not
    identified`` if some are less than the one and some more than the other; ``undecided`` where
    the intervals of the shares, their lower and upper ends, cover what would decide.
    """
    lows, highs = zip(*shares, strict=True)
    if min(lows) >= MOST:
        return positive
    if max(highs) <= FEWEST:
        return "not reproduced"
    return "not identified" if min(highs) < MOST and max(lows) > FEWEST else UNDECIDED


def nearest_margin(margin: FloatArray) -> float:
    """Return the finite margin nearest to its bound, nan without one."""
    finite = margin[np.isfinite(margin)]
    return float(finite[np.argmin(np.abs(finite))]) if finite.size else math.nan


def results(
    numbers: pd.DataFrame,
    criteria: Mapping[str, Number],
    labels: Mapping[str, str],
    units: Mapping[str, str],
) -> list[Row]:
    """Return the rows of the table of results for one claim, without its id.

    Parameters
    ----------
    numbers
        Table with `NUMBER`, columns of a number.
    criteria, labels, units
        By quantity; not all are tested.
    """
    rows = []
    for number in numbers[[*NUMBER]].itertuples(index=False):
        row: dict[str, Any] = dict(zip(NUMBER, number, strict=True))
        name = row["quantity"]
        row |= {"label": labels[name], "unit": units[name]} | UNTESTED
        if criterion := criteria.get(name):
            row |= criterion.row | {"passed": bool(criterion.distance(row["value"]) >= 0.0)}
        rows.append(row)
    return rows
