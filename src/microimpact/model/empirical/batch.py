"""Fits of Eq. (34) to many data sets at once.

The minimum that `microimpact.model.empirical.fit.fit_restitution` seeks, in the same variables
and within the same bounds, for studies that need very many fits: by compiled damped Gauss-Newton
searches (Levenberg and Marquardt). What one data set gives does not depend on the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.typing import ArrayLike

from microimpact.core.arrays import NON_NEGATIVE, POSITIVE, BoolArray, FloatArray, checked
from microimpact.model.empirical.kernel import descend_all
from microimpact.model.empirical.search import (
    AT_REBOUND,
    CLOSEST,
    EXPONENT_BOUNDS,
    K_BOUNDS,
    KAPPA_BOUNDS,
    ON_BOUND,
    STARTS,
    V_C,
    Q,
)

Places = npt.NDArray[np.intp]


class Search(NamedTuple):
    """Data (r, n); of m searches the data set (m,), upper end of v_c (m,), and the box (m, 5)."""

    v: FloatArray
    e: FloatArray
    weight: FloatArray
    owner: Places
    end: FloatArray
    low: FloatArray
    high: FloatArray


class Found(NamedTuple):
    """Variables ln(k, p, kappa, q, gap) (m, 5), chi-square (m,), whether the searches converged."""

    x: FloatArray
    chi_square: FloatArray
    converged: BoolArray


def descend(search: Search, x: FloatArray) -> Found:
    """Lower the sums of squares from x as far as possible within the box.

    Parameters
    ----------
    search
        The data, and the box of ln(k, p, kappa, q, gap); a variable whose bounds are equal is
        fixed.
    x
        Starts ln(k, p, kappa, q, gap), (s, 5), s a multiple of m: those of all searches once, then
        again.
    """
    start = np.resize(np.arange(len(search.end)), len(x))
    x = np.clip(x, search.low[start], search.high[start])
    found = Found(x, np.empty(len(x)), np.zeros(len(x), bool))
    descend_all(*search, start, *found)
    return found


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


__all__ = [
    "BatchFit",
    "DataSets",
    "data_sets",
    "fit_batch",
    "interval_batch",
    "profile_batch",
    "stacked_fits",
    "stacked_sets",
]

# Steps in which an end of an interval is sought.
STEPS = 8


@dataclass(frozen=True, slots=True, kw_only=True)
class BatchFit:
    """Fits of r data sets.

    Attributes
    ----------
    parameters
        k, p, kappa, q, v_c (r, 5); speeds in m/s.
    chi_square
        Weighted sum of squares (r,).
    capture_on_bound
        Whether v_c ended at 0, at the slowest rebounding speed or at a captured one (r,).
    on_bound
        Whether any free parameter ended on a bound (r,).
    converged
        Whether the search ended by its tolerance (r,).
    """

    parameters: FloatArray
    chi_square: FloatArray
    capture_on_bound: BoolArray
    on_bound: BoolArray
    converged: BoolArray

    def take(self, rows: slice) -> BatchFit:
        """Return some of the fits."""
        return BatchFit(**{field.name: getattr(self, field.name)[rows] for field in fields(self)})

    @property
    def v_c(self) -> FloatArray:
        """Capture velocities (r,), m/s."""
        return self.parameters[:, V_C]


def fit_batch(sets: DataSets, starts: int = 2) -> BatchFit:
    """Fit Eq. (34) to every data set by weighted least squares.

    Parameters
    ----------
    sets
        From `data_sets`.
    starts
        Number of searches for each data set, 1 to 5; the lowest counts.

    Raises
    ------
    ValueError
        If ``starts`` is out of range.
    """
    if not 1 <= starts <= len(BEST_STARTS):
        raise ValueError(f"starts must be 1 to {len(BEST_STARTS)}, got {starts}")
    pieces = ranges(sets)
    width = pieces.upper - pieces.lower
    gaps = np.log(CLOSEST * width), np.log(width)
    search = searches(sets, pieces.owner, pieces.upper, *gaps)
    points = [start_points(sets, pieces.owner, i, width) for i in BEST_STARTS[:starts]]
    found = _lowest(search, points)
    # The lowest of all pieces of each data set.
    order = np.lexsort((found.chi_square, pieces.owner))
    piece = order[np.unique(pieces.owner[order], return_index=True)[1]]
    x = found.x[piece]
    near = (x - search.low[piece] < ON_BOUND) | (search.high[piece] - x < ON_BOUND)
    gap, span = np.exp(x[:, V_C]), width[piece]
    # As in the single fit: v_c is held to be on a bound much closer to it than the others.
    near[:, V_C] = (gap < (1.0 + ON_BOUND) * CLOSEST * span) | (gap > (1.0 - CLOSEST) * span)
    near[:, Q] &= sets.q is None
    parameters = np.exp(x)
    parameters[:, V_C] = np.maximum(pieces.upper[piece] - gap, pieces.lower[piece])
    parameters[:, [0, 2, V_C]] *= sets.unit[:, None]
    return BatchFit(
        parameters=parameters,
        chi_square=found.chi_square[piece],
        capture_on_bound=near[:, V_C],
        on_bound=np.asarray(near.any(axis=1)),
        converged=found.converged[piece],
    )


def stacked_fits(fits: Sequence[BatchFit]) -> BatchFit:
    """Return the fits of several batches as those of one."""
    names = [field.name for field in fields(BatchFit)]
    return BatchFit(
        **{name: np.concatenate([getattr(fit, name) for fit in fits]) for name in names}
    )


def profile_batch(sets: DataSets, fit: BatchFit, v_c: ArrayLike) -> FloatArray:
    """Return the least chi-square (r,) of every data set for a given v_c.

    Parameters
    ----------
    sets, fit
        The data and their fit, from which the search starts, beside one start of its own.
    v_c
        Capture velocity, one number or (r,), m/s; infinite chi-square where it is above the
        slowest rebound.
    """
    given = np.broadcast_to(checked("v_c", v_c, NON_NEGATIVE), sets.unit.shape) / sets.unit
    logs, gap = _logs(sets, fit), np.maximum(1.0 - given, CLOSEST)
    chi_square, _ = _profile(sets, gap, logs, restart=True)
    return np.where(given > 1.0, np.inf, chi_square)


def interval_batch(sets: DataSets, fit: BatchFit, rise: ArrayLike) -> FloatArray:
    """Return ends (r, 2) of the profile intervals of v_c, m/s.

    An end is sought between the fit and the end of the admissible range, so a profile is taken to
    rise on either side. An end that the range sets is 0 or the slowest rebound.

    Parameters
    ----------
    sets, fit
        The data and their fit.
    rise
        Admissible rise of chi-square above the minimum, positive, of a shape that broadcasts to
        (r,).
    """
    limit = np.broadcast_to(np.sqrt(checked("rise", rise, POSITIVE)), sets.unit.shape)
    best = np.maximum(1.0 - fit.v_c / sets.unit, CLOSEST)
    # Both ends at once: the lower ones of all data sets, then the upper ones.
    twice = (stacked_sets([sets, sets]), stacked_fits([fit, fit]), np.tile(best, 2))
    outermost = np.concatenate([np.ones_like(best), np.minimum(best, AT_REBOUND)])
    gap, held = _crossing(*twice, outermost, np.tile(limit, 2))
    ends = np.where(held, np.repeat([0.0, 1.0], len(best)), 1.0 - gap)
    return ends.reshape(2, -1).T * sets.unit[:, None]


def _crossing(
    sets: DataSets, fit: BatchFit, inside: FloatArray, outside: FloatArray, limit: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Gap (r,) at which the root of the rise of chi-square is the limit; whether it never is.

    The root is nearly linear in v_c. False position, which halves the value at an end that stays
    (Illinois), does not get caught where it is not.
    """

    def excess(
        gap: FloatArray, logs: FloatArray, *, restart: bool
    ) -> tuple[FloatArray, FloatArray]:
        chi_square, found = _profile(sets, gap, logs, restart=restart)
        return np.sqrt(np.maximum(chi_square - fit.chi_square, 0.0)) - limit, found

    logs = _logs(sets, fit)
    low, (high, _) = -limit, excess(outside, logs, restart=True)
    held = high <= 0.0
    high = np.maximum(high, np.finfo(float).tiny)
    last = np.zeros(len(limit))
    gap = inside
    for _ in range(STEPS):
        gap = (inside * high - outside * low) / (high - low)
        value, found = excess(gap, logs, restart=False)
        within = value <= 0.0
        side = np.where(within, 1.0, -1.0)
        high = np.where(within, np.where(last == side, 0.5 * high, high), value)
        low = np.where(within, value, np.where(last == side, 0.5 * low, low))
        inside, outside = np.where(within, gap, inside), np.where(within, outside, gap)
        logs, last = np.where(within[:, None], found, logs), side
    return gap, held


def _profile(
    sets: DataSets, gap: FloatArray, logs: FloatArray, *, restart: bool = False
) -> tuple[FloatArray, FloatArray]:
    """Least chi-square (r,) at v_c = 1 - gap, and ln(k, p, kappa, q) (r, 4) there."""
    owner, fixed = np.arange(len(sets.unit)), np.log(gap)
    search = searches(sets, owner, np.ones(len(owner)), fixed, fixed)
    points = [np.column_stack([logs, fixed])]
    points += [start_points(sets, owner, BEST_STARTS[0], np.exp(fixed))] if restart else []
    found = _lowest(search, points)
    return found.chi_square, found.x[:, :V_C]


def _lowest(search: Search, starts: list[FloatArray]) -> Found:
    """Of searches from several starts each, what the lowest found."""
    rows = np.arange(len(search.end))
    found = descend(search, np.concatenate(starts))
    best = rows + len(rows) * np.argmin(found.chi_square.reshape(len(starts), -1), axis=0)
    return Found(*(field[best] for field in found))


def _logs(sets: DataSets, fit: BatchFit) -> FloatArray:
    """ln(k, p, kappa, q) (r, 4) in units of the slowest rebound."""
    parameters = fit.parameters[:, :V_C].copy()
    parameters[:, [0, 2]] /= sets.unit[:, None]
    logs: FloatArray = np.log(parameters)
    return logs
