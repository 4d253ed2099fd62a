"""Many data sets for Eq. (34), and the searches that fit them: data, ranges, starts, bounds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microimpact.arrays import NON_NEGATIVE, POSITIVE, FloatArray, checked
from microimpact.model.restitution_descent import Places, Search
from microimpact.model.restitution_search import (
    CLOSEST,
    EXPONENT_BOUNDS,
    K_BOUNDS,
    KAPPA_BOUNDS,
    STARTS,
)

# Of the starts of the single fit those that most often lead to its minimum, the best first.
BEST_STARTS = (3, 2, 0, 1, 4)
ARRAYS = ("v", "e", "weight", "unit", "top")


@dataclass(frozen=True, slots=True, kw_only=True)
class DataSets:
    """Data sets (r, n), checked, in units of the slowest rebounding speed of each.

    Attributes
    ----------
    v, e, weight
        Speeds, coefficients of restitution and 1/sigma; weight 0 for a datum that is not there.
    unit, top
        The slowest rebounding speed (r,), m/s, and the largest speed in its units.
    q
        Exponent of Eq. (33), or None where it is free.
    """

    v: FloatArray
    e: FloatArray
    weight: FloatArray
    unit: FloatArray
    top: FloatArray
    q: float | None

    def take(self, rows: slice) -> DataSets:
        """Return some of the data sets."""
        return DataSets(**{name: getattr(self, name)[rows] for name in ARRAYS}, q=self.q)

    @property
    def free(self) -> int:
        """Number of free parameters."""
        return 5 if self.q is None else 4


class Ranges(NamedTuple):
    """Ranges of v_c in units of the slowest rebound, and the data set that each belongs to."""

    owner: Places
    lower: FloatArray
    upper: FloatArray


def data_sets(v: ArrayLike, e: ArrayLike, weight: ArrayLike, q: float | None = None) -> DataSets:
    """Return data sets ready to be fitted.

    Parameters
    ----------
    v
        Normal impact speeds, (n,) or (r, n), m/s; positive.
    e
        Coefficients of restitution (r, n), 0 or more; 0 for a captured sphere.
    weight
        1/sigma, of a shape that broadcasts to (r, n); 0 leaves a datum out.
    q
        Exponent of Eq. (33), positive; None: free.

    Raises
    ------
    TypeError
        If an argument does not hold real numbers.
    ValueError
        If a number is out of range, or a data set has too few points from its smallest rebounding
        speed upwards: fewer than free parameters and one more.
    """
    measured = np.array(checked("e", e, NON_NEGATIVE), ndmin=2)
    speed = np.broadcast_to(checked("v", v, POSITIVE), measured.shape)
    weights = np.array(np.broadcast_to(checked("weight", weight, NON_NEGATIVE), measured.shape))
    if q is not None:
        checked("q", q, POSITIVE)
    unit = np.where((weights > 0.0) & (measured > 0.0), speed, np.inf).min(axis=1)
    ratio = speed / unit[:, None]
    top = np.where(weights > 0.0, ratio, 0.0).max(axis=1)
    sets = DataSets(v=ratio, e=measured, weight=weights, unit=unit, top=top, q=q)
    telling = np.sum((weights > 0.0) & (sets.v >= 1.0), axis=1)
    if np.any(telling <= sets.free):
        few = int(np.argmin(telling))
        raise ValueError(
            f"e: data set {few} must hold at least {sets.free + 1} points from the smallest "
            f"rebounding speed upwards, one more than free parameters, got {telling[few]}"
        )
    return sets


def stacked_sets(parts: Sequence[DataSets]) -> DataSets:
    """Return data sets of one number of points and one q as those of one batch."""
    arrays = {name: np.concatenate([getattr(part, name) for part in parts]) for name in ARRAYS}
    return DataSets(**arrays, q=parts[0].q)


def ranges(sets: DataSets) -> Ranges:
    """Ranges of v_c between captured speeds: the clip bends the sum of squares at each."""
    captured = (sets.e == 0.0) & (sets.weight > 0.0) & (sets.v < 1.0 - CLOSEST)
    several = captured.any(axis=1)
    split, whole = np.flatnonzero(several), np.flatnonzero(~several)
    owner, lower, upper = [whole], [np.zeros(len(whole))], [np.ones(len(whole))]
    for row in split:
        edges = np.concatenate([[0.0], np.unique(sets.v[row][captured[row]]), [1.0]])
        owner.append(np.full(len(edges) - 1, row))
        lower.append(edges[:-1])
        upper.append(edges[1:])
    return Ranges(np.concatenate(owner), np.concatenate(lower), np.concatenate(upper))


def searches(
    sets: DataSets, owner: Places, end: FloatArray, least_gap: FloatArray, largest_gap: FloatArray
) -> Search:
    """One search per owner, with v_c below an end by a gap whose logarithm has these bounds."""
    low, high = _bounds(sets, owner, least_gap, largest_gap)
    return Search(sets.v, sets.e, sets.weight, owner, end, low, high)


def start_points(sets: DataSets, owner: Places, number: int, width: FloatArray) -> FloatArray:
    """Start (m, 5) ln(k, p, kappa, q, gap) of that number in a range of v_c of that width."""
    k, p, q, share = STARTS[number]
    natural = (k * sets.top[owner], p, 0.3, sets.q or q, share * width)
    points: FloatArray = np.log(np.stack(np.broadcast_arrays(*natural), axis=1))
    return points


def _bounds(
    sets: DataSets, owner: Places, least_gap: FloatArray, largest_gap: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Bounds (m, 5) of ln(k, p, kappa, q, gap), equal where a variable is fixed."""
    top = sets.top[owner]
    ends = []
    for side, scale, gap in ((0, np.ones_like(top), least_gap), (1, top, largest_gap)):
        q = EXPONENT_BOUNDS[side] if sets.q is None else sets.q
        sides = (K_BOUNDS[side] * scale, EXPONENT_BOUNDS[side], KAPPA_BOUNDS[side] * scale, q)
        ends.append(np.stack(np.broadcast_arrays(*np.log(np.broadcast_arrays(*sides)), gap), 1))
    return ends[0], ends[1]
