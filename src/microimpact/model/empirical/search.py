"""Search for the least squares fit of Eq. (34), to one data set or to many at once.

Two things keep a plain search from the minimum. The slope of Eq. (34) in v_c is infinite at a
point where v = v_c (for q < 1), and the clip bends the sum of squares at every captured speed. So
v_c is sought piece by piece between those speeds, through the logarithm of its distance from the
upper end of the piece, the gap: in that variable the sum of squares is smooth. The other parameters
are searched as logarithms, too, and speeds are in units of the smallest one that rebounds.

The searches are compiled damped Gauss-Newton ones (Levenberg and Marquardt). What one data set
gives does not depend on the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from microimpact.core.arrays import BoolArray, Columns, FloatArray
from microimpact.model.empirical.data import DataSets, Places
from microimpact.model.empirical.kernel import V_C, VARIABLES, Q, descend_all

# Bounds of k and kappa over the smallest and the largest speed, and of the exponents.
K_BOUNDS = (1e-3, 1e6)
KAPPA_BOUNDS = (1e-6, 1e3)
EXPONENT_BOUNDS = (0.02, 20.0)
# Distances from the end of a piece below this share of it count as none.
CLOSEST = 1e-9
# Logarithms closer than this to a bound count as lying on it.
ON_BOUND = 1e-3
# Sums of squares that differ by less than this share of the least, or of the data, are the same.
SAME_MINIMUM, SAME_AS_NONE = 1e-4, 1e-12
# Tolerance of a search among many; further steps change v_c by a part in 10 million or less.
TOLERANCE = 1e-9
# Largest change of a logarithm in one step: beyond it the quadratic model says nothing.
STRIDE = np.full(5, 2.0)
NO_TABLE = np.empty((0, 0, 0, 0))
# Starts, those first that most often lead to the minimum: k over the largest speed, p, q, and the
# distance of v_c from the end of its piece as a share of the piece.
STARTS = (
    (10.0, 1.0, 0.5, 0.01),
    (1.0, 2.0, 0.5, 0.1),
    (10.0, 0.5, 0.5, 0.1),
    (10.0, 1.0, 1.0, 0.5),
    (0.1, 1.0, 2.0, 0.9),
)


def model(v: FloatArray, logs: FloatArray, end: float, gap: float) -> tuple[FloatArray, FloatArray]:
    """Eq. (34) at v_c = end - gap, and its slopes in ln(k, p, kappa, q) and ln(gap).

    Parameters
    ----------
    v
        Speeds, (n,), positive.
    logs
        ln k, ln p, ln kappa, ln q.
    end, gap
        v_c is their difference; no speed above v_c may lie below ``end``, or the slope in ln(gap)
        is unbounded.

    Returns
    -------
    e, slopes
        Shapes (n,) and (n, 5).
    """
    p, q = np.exp(logs[1]), np.exp(logs[Q])
    excess = (v - end) + gap
    rebounds = excess > 0.0
    excess = np.where(rebounds, excess, 1.0)
    fall = np.log(v) - logs[0]
    rise = np.log(excess) - logs[2]
    with np.errstate(over="ignore"):
        body = 1.0 / (1.0 + np.exp(p * fall))
        kept = np.where(rebounds, 1.0 / (1.0 + np.exp(-q * rise)), 0.0)
    e = body * kept
    loss, taken = e * (1.0 - body) * p, e * (1.0 - kept) * q
    return e, np.stack([loss, -loss * fall, -taken, taken * rise, taken * gap / excess], axis=-1)


class Search(NamedTuple):
    """Data, and box of d variables, of each of m searches.

    A search ends where it lowers chi-square by less than the share ``tolerance`` of it.
    """

    table: FloatArray  # A law's, over three parameters and v/v_c; Eq. (34) where it is empty
    points: FloatArray  # v or places of v/v_c, ln v, e and 1/sigma (r, 4, n)
    owner: Places  # Data set of each search (m,)
    end: FloatArray  # Upper end of v_c (m,)
    low: FloatArray  # Bounds (m, d)
    high: FloatArray
    stride: FloatArray  # Largest changes in one step (d,)
    tolerance: float


class Minima(NamedTuple):
    """Of m searches the lowest minima (m,), their variables (m, d), and whether they converged.

    The last field is the chi-square (s, m) that each of s starts led to.
    """

    chi_square: FloatArray
    x: FloatArray
    converged: BoolArray
    each: FloatArray


def lowest(search: Search, starts: Sequence[FloatArray]) -> Minima:
    """Lower the sums of squares from several starts (m, d) each as far as possible within the box.

    A variable whose bounds are equal is fixed.
    """
    x = np.concatenate([np.clip(start, search.low, search.high) for start in starts])
    chi_square, converged = np.empty(len(x)), np.zeros(len(x), bool)
    descend_all(*search, x, chi_square, converged)
    each = chi_square.reshape(len(starts), -1)
    rows = np.arange(len(search.end))
    best = rows + len(rows) * np.argmin(each, axis=0)
    return Minima(chi_square[best], x[best], converged[best], each)


def ranges(sets: DataSets) -> tuple[Places, FloatArray, FloatArray]:
    """Ranges of v_c between captured speeds: the clip bends the sum of squares at each.

    The data set that each belongs to, and its ends, in units of the slowest rebound.
    """
    captured = (sets.e == 0.0) & (sets.weight > 0.0) & (sets.v < 1.0 - CLOSEST)
    several = captured.any(axis=1)
    split, whole = np.flatnonzero(several), np.flatnonzero(~several)
    owner, lower, upper = [whole], [np.zeros(len(whole))], [np.ones(len(whole))]
    for row in split:
        edges = np.concatenate([[0.0], np.unique(sets.v[row][captured[row]]), [1.0]])
        owner.append(np.full(len(edges) - 1, row))
        lower.append(edges[:-1])
        upper.append(edges[1:])
    return np.concatenate(owner), np.concatenate(lower), np.concatenate(upper)


def searches(
    sets: DataSets,
    owner: Places,
    end: FloatArray,
    least_gap: FloatArray,
    largest_gap: FloatArray,
    tolerance: float = TOLERANCE,
) -> Search:
    """One search per owner, with v_c below an end by a gap.

    Parameters
    ----------
    sets
        Data sets.
    owner
        Number of the data set of each search, (m,).
    end
        End of the range of v_c, in units of the slowest rebound, (m,).
    least_gap, largest_gap
        Bounds of the logarithm of the gap, (m,).
    tolerance
        Share of chi-square by which a last step lowers it.
    """
    top, (low, high) = sets.top[owner], np.empty((2, owner.size, VARIABLES))
    for side, bounds, scale, gap in ((0, low, 1.0, least_gap), (1, high, top, largest_gap)):
        q = EXPONENT_BOUNDS[side] if sets.q is None else sets.q
        sides = (K_BOUNDS[side] * scale, EXPONENT_BOUNDS[side], KAPPA_BOUNDS[side] * scale, q)
        for variable, value in enumerate((*map(np.log, sides), gap)):
            bounds[:, variable] = value
    return Search(NO_TABLE, sets.points, owner, end, low, high, STRIDE, tolerance)


def start_points(sets: DataSets, owner: Places, number: int, width: FloatArray) -> FloatArray:
    """Start of each search: ln(k, p, kappa, q, gap), (m, 5).

    Parameters
    ----------
    sets
        Data sets.
    owner
        Number of the data set of each search, (m,).
    number
        Which of ``STARTS``.
    width
        Width of the range of v_c, (m,).
    """
    k, p, q, share = STARTS[number]
    natural = (k * sets.top[owner], p, 0.3, sets.q or q, share * width)
    points: FloatArray = np.log(np.stack(np.broadcast_arrays(*natural), axis=1))
    return points


@dataclass(frozen=True, slots=True, kw_only=True)
class BatchFit(Columns):
    """Fits of r data sets."""

    parameters: FloatArray  # k, p, kappa, q, v_c (r, 5); speeds in m/s
    chi_square: FloatArray  # Weighted sum of squares (r,)
    # Which of them are free and ended on a bound (r, 5): v_c at 0, at the slowest rebounding speed
    # or at a captured one.
    at_bound: BoolArray
    # Whether the search ended by its tolerance, or at a misfit that is rounding (r,).
    converged: BoolArray
    agreeing: Places  # Number of starts that led to the minimum (r,)

    @property
    def v_c(self) -> FloatArray:
        """Capture velocities (r,), m/s."""
        return self.parameters[:, V_C]

    @property
    def capture_on_bound(self) -> BoolArray:
        """Whether v_c ended on a bound (r,)."""
        return self.at_bound[:, V_C]

    @property
    def on_bound(self) -> BoolArray:
        """Whether any free parameter ended on a bound (r,)."""
        return np.asarray(self.at_bound.any(axis=1))

    def logs(self, sets: DataSets) -> FloatArray:
        """Return ln(k, p, kappa, q, v_c) (r, 5) in units of the slowest rebounds of its data."""
        natural = self.parameters.copy()
        natural[:, [0, 2, V_C]] /= sets.unit[:, None]
        natural[:, V_C] = np.maximum(natural[:, V_C], CLOSEST)
        logs: FloatArray = np.log(natural)
        return logs


def fit_batch(
    sets: DataSets, starts: int = 2, guess: FloatArray | None = None, tolerance: float = TOLERANCE
) -> BatchFit:
    """Fit Eq. (34) to every data set by weighted least squares.

    Parameters
    ----------
    sets
        From `data_sets`.
    starts
        Number of searches for each data set, 1 to 5; the lowest minimum counts.
    guess
        One more start, ln(k, p, kappa, q, v_c) (r, 5) in units of the slowest rebounds.
    tolerance
        Share of chi-square by which the last step of a search may still lower it.

    Raises
    ------
    ValueError
        If ``starts`` is out of range.
    """
    if not 1 <= starts <= len(STARTS):
        raise ValueError(f"starts must be 1 to {len(STARTS)}, got {starts}")
    owner, lower, upper = ranges(sets)
    width = upper - lower
    gaps = np.log(CLOSEST * width), np.log(width)
    search = searches(sets, owner, upper, *gaps, tolerance)
    points = [start_points(sets, owner, i, width) for i in range(starts)]
    if guess is not None:
        gap = np.clip(upper - np.exp(guess[owner, V_C]), CLOSEST * width, width)
        points.append(np.column_stack([guess[owner, :V_C], np.log(gap)]))
    minima = lowest(search, points)
    # The lowest of all pieces of each data set.
    order = np.lexsort((minima.chi_square, owner))
    piece = order[np.unique(owner[order], return_index=True)[1]]
    x, chi_square = minima.x[piece], minima.chi_square[piece]
    near = (x - search.low[piece] < ON_BOUND) | (search.high[piece] - x < ON_BOUND)
    gap, span = np.exp(x[:, V_C]), width[piece]
    # v_c is held to be on a bound much closer to it than the others.
    near[:, V_C] = (gap < (1.0 + ON_BOUND) * CLOSEST * span) | (gap > (1.0 - CLOSEST) * span)
    near[:, Q] &= sets.q is None
    parameters = np.exp(x)
    if sets.q is not None:
        parameters[:, Q] = sets.q
    parameters[:, V_C] = np.maximum(upper[piece] - gap, lower[piece])
    parameters[:, [0, 2, V_C]] *= sets.unit[:, None]
    data = np.sum(np.square(sets.weight * sets.e), axis=1)
    same = chi_square * (1.0 + SAME_MINIMUM) + SAME_AS_NONE * data
    return BatchFit(
        parameters=parameters,
        chi_square=chi_square,
        at_bound=near,
        converged=minima.converged[piece] | (chi_square <= SAME_AS_NONE * data),
        agreeing=np.sum(minima.each[:, piece] <= same, axis=0),
    )


def profile(
    sets: DataSets,
    owner: Places,
    gap: FloatArray,
    *starts: FloatArray,
    fresh: int = 0,
) -> Minima:
    """Search with v_c held, for ln(k, p, kappa, q).

    Parameters
    ----------
    sets, owner
        The data, and the data set of each search (m,).
    gap
        v_c is 1 - gap (m,), in units of the slowest rebounds.
    starts
        Starts (m, 4 or more), of which what follows ln q does not count.
    fresh
        Number of starts tried that depend on no other search.
    """
    fixed = np.log(gap)
    search = searches(sets, owner, np.ones(len(gap)), fixed, fixed)
    points = [np.column_stack([start[:, :V_C], fixed]) for start in starts]
    points += [start_points(sets, owner, number, gap) for number in range(fresh)]
    return lowest(search, points)
