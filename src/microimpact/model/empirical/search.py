"""Search for the least squares fit of Eq. (34), to one data set or to many at once.

Two things keep a plain search from the minimum. The slope of Eq. (34) in v_c is infinite at a
point where v = v_c (for q < 1), and the clip bends the sum of squares at every captured speed. So
v_c is sought piece by piece between those speeds, through the logarithm of its distance from the
upper end of the piece, the gap: in that variable the sum of squares is smooth. The other parameters
are searched as logarithms, too, and speeds are in units of the smallest one that rebounds.

The searches are damped Gauss-Newton ones (Levenberg and Marquardt), many side by side. What one
data set gives does not depend on the others.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from microimpact.core.arrays import BoolArray, Columns, FloatArray
from microimpact.model.empirical.data import DataSets, Places
from microimpact.model.empirical.kernel import V_C, VARIABLES, Q

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
# A deviance, which may be 0, is known to this.
NEARLY = 1e-6
# Largest change of a logarithm in one step: beyond it the quadratic model says nothing.
STRIDE = np.full(5, 2.0)
# Damping at the start and the least, as shares of the diagonal of the normal matrix, and the
# largest decrease after one step. A search ends, too, where no damping finds a lower point.
FIRST_DAMPING, LEAST_DAMPING, LIGHTEN, STUCK = 1e-3, 1e-9, 1.0 / 3.0, 1e10
# The damping at which a small decrease means a minimum and not a small step.
LIGHT_DAMPING = 0.1
# Keeps a normal matrix of full rank in directions that the data do not determine.
RIDGE = 1e-14
ITERATIONS = 300
# Starts, those first that most often lead to the minimum: k over the largest speed, p, q, and the
# distance of v_c from the end of its piece as a share of the piece.
STARTS = (
    (10.0, 1.0, 0.5, 0.01),
    (1.0, 2.0, 0.5, 0.1),
    (10.0, 0.5, 0.5, 0.1),
    (10.0, 1.0, 1.0, 0.5),
    (0.1, 1.0, 2.0, 0.9),
)


def model(
    v: FloatArray, logs: FloatArray, end: FloatArray | float, gap: FloatArray | float
) -> tuple[FloatArray, FloatArray]:
    """Eq. (34) at v_c = end - gap, and its slopes in ln(k, p, kappa, q) and ln(gap).

    Parameters
    ----------
    v
        Speeds, (..., n), positive.
    logs
        ln k, ln p, ln kappa, ln q, (..., 4).
    end, gap
        v_c is their difference, (...); no speed above v_c may lie below ``end``, or the slope in
        ln(gap) is unbounded.

    Returns
    -------
    e, slopes
        Shapes (..., n) and (..., n, 5).
    """
    end, gap = np.asarray(end)[..., None], np.asarray(gap)[..., None]
    p, q = np.exp(logs[..., 1, None]), np.exp(logs[..., Q, None])
    excess = (v - end) + gap
    rebounds = excess > 0.0
    excess = np.where(rebounds, excess, 1.0)
    fall, rise = np.log(v) - logs[..., 0, None], np.log(excess) - logs[..., 2, None]
    with np.errstate(over="ignore"):
        body = 1.0 / (1.0 + np.exp(p * fall))
        kept = np.where(rebounds, 1.0 / (1.0 + np.exp(-q * rise)), 0.0)
    e = body * kept
    loss, taken = e * (1.0 - body) * p, e * (1.0 - kept) * q
    return e, np.stack([loss, -loss * fall, -taken, taken * rise, taken * gap / excess], axis=-1)


# Value of each of m functions, half its slopes and half its second derivatives, (m,), (m, d) and
# (m, d, d), at variables (m, d) of the functions of these numbers (m,).
Objective = Callable[[FloatArray, Places], tuple[FloatArray, FloatArray, FloatArray]]


class Box(NamedTuple):
    """Bounds of the variables of m searches, and the largest changes in one step.

    A variable whose bounds are equal is fixed.
    """

    low: FloatArray  # (m, d)
    high: FloatArray
    stride: FloatArray  # (d,)


class Minima(NamedTuple):
    """Of m searches the lowest minima (m,), their variables (m, d), and whether they converged.

    The last field is the value (s, m) that each of s starts led to.
    """

    value: FloatArray
    x: FloatArray
    converged: BoolArray
    each: FloatArray


def squares(missed: FloatArray, slopes: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Sums of squares of misfits (m, n), half their slopes, and half their curvatures (Gauss).

    Parameters
    ----------
    missed
        Misfits over sigma, (m, n).
    slopes
        Their slopes in the variables, (m, n, d).
    """
    across = np.swapaxes(slopes, 1, 2)
    slope = np.matmul(across, missed[..., None])[..., 0]
    return np.sum(missed**2, axis=1), slope, np.matmul(across, slopes)


def misfits(
    missed: FloatArray, slopes: FloatArray, sets: DataSets, owner: Places
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Sums of squares as of `squares`, or with heavy tails the deviance with its own.

    Parameters
    ----------
    missed, slopes
        As of `squares`.
    sets, owner
        The data, and the data set of each row, (m,).
    """
    if sets.tails is None:
        return squares(missed, slopes)
    student, weights = sets.tails.likeliest(missed, np.sum(sets.v[owner] >= 1.0, axis=1))
    root = np.sqrt(weights)
    return (student[:, 0], *squares(missed * root, slopes * root[..., None])[1:])


def lowest(
    objective: Objective,
    starts: FloatArray,
    box: Box,
    tolerance: float,
    absolute: float = 0.0,
    most: int | None = None,
) -> Minima:
    """Lower m functions within their boxes as far as possible, from several starts each.

    Parameters
    ----------
    objective
        The functions.
    starts
        Starts (s, m, d).
    box
        Bounds.
    tolerance, absolute
        A search ends where a step and the quadratic model lower the function by less than this
        share of it, or where a step changes it by less than the second number: with that go
        functions that are not smooth to rounding.
    most
        Number of starts that are followed, those with the lowest values; None: all.
    """
    starts = np.clip(starts, box.low, box.high)
    count = len(box.low)

    def repeated(x: FloatArray, rows: Places) -> tuple[FloatArray, FloatArray, FloatArray]:
        return objective(x, rows % count)

    if most is not None and most < len(starts):
        flat = starts.reshape(-1, starts.shape[2])
        values = repeated(flat, np.arange(len(flat)))[0].reshape(starts.shape[:2])
        chosen = np.argsort(values, axis=0, kind="stable")[:most]
        starts = np.take_along_axis(starts, chosen[..., None], axis=0)
    many = len(starts)
    wide = Box(np.tile(box.low, (many, 1)), np.tile(box.high, (many, 1)), box.stride)
    value, x, converged = _descend(
        repeated, starts.reshape(-1, starts.shape[2]), wide, tolerance, absolute
    )
    each = value.reshape(many, count)
    best = np.argmin(each, axis=0) * count + np.arange(count)
    return Minima(value[best], x[best], converged[best], each)


def _descend(
    objective: Objective, x: FloatArray, box: Box, tolerance: float, absolute: float
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Least values (m,), where they are (m, d), and whether the searches have ended by tolerance.

    Damped Gauss-Newton steps (Levenberg and Marquardt), the damping by Nielsen's rule.
    """
    running = np.arange(len(x))
    value, slope, curvature = objective(x, running)
    x, converged = x.copy(), np.zeros(len(x), bool)
    damping, heavier = np.full(len(x), FIRST_DAMPING), np.full(len(x), 2.0)
    for _ in range(ITERATIONS):
        low, high = box.low[running], box.high[running]
        now, step = x[running], _step(slope, curvature, damping, x[running], low, high)
        trial = np.clip(now + np.clip(step, -box.stride, box.stride), low, high)
        step = trial - now
        bent = np.matmul(curvature, step[..., None])[..., 0]
        expected = -np.sum((2.0 * slope + bent) * step, axis=1)
        tried = objective(trial, running)
        decrease = value[running] - tried[0]
        # Of either sign, so that rounding does not keep a search at its minimum from ending.
        small = tolerance * np.abs(tried[0])
        flat = (np.abs(decrease) <= small) & (np.abs(expected) <= small) & (damping < LIGHT_DAMPING)
        ended = flat | (np.abs(decrease) < absolute) | (damping > STUCK) | (tried[0] == 0.0)
        lower = decrease >= 0.0
        x[running[lower]], value[running[lower]] = trial[lower], tried[0][lower]
        slope = np.where(lower[:, None], tried[1], slope)
        curvature = np.where(lower[:, None, None], tried[2], curvature)
        gain = np.divide(decrease, expected, out=np.ones_like(decrease), where=expected > 0.0)
        lighter = np.maximum(1.0 - (2.0 * gain - 1.0) ** 3, LIGHTEN)
        damping = np.maximum(damping * np.where(lower, lighter, heavier), LEAST_DAMPING)
        heavier = np.where(lower, 2.0, 2.0 * heavier)
        converged[running[ended]] = True
        on = ~ended
        running, damping, heavier = running[on], damping[on], heavier[on]
        slope, curvature = slope[on], curvature[on]
        if not running.size:
            break
    return value, x, converged


def _step(
    slope: FloatArray,
    curvature: FloatArray,
    damping: FloatArray,
    x: FloatArray,
    low: FloatArray,
    high: FloatArray,
) -> FloatArray:
    """Damped step (m, d); variables that would leave the box stay."""
    free = ~(((x <= low) & (slope >= 0.0)) | ((x >= high) & (slope <= 0.0)))
    matrix = curvature * (free[:, :, None] & free[:, None, :])
    diagonal = np.einsum("mkk->mk", matrix)
    ridge = RIDGE * np.maximum(diagonal.max(axis=1, keepdims=True), 1.0)
    diagonal += damping[:, None] * diagonal + ridge + ~free
    return np.asarray(-np.linalg.solve(matrix, (slope * free)[..., None])[..., 0])


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


def misfit(sets: DataSets, owner: Places, end: FloatArray) -> Objective:
    """Sum of squares of Eq. (34), in logarithms of k, p, kappa, q and of the gap of v_c to an end.

    Parameters
    ----------
    sets
        Data sets.
    owner
        Number of the data set of each search, (m,).
    end
        End of the range of v_c, in units of the slowest rebound, (m,).
    """
    v, e, weight = (rows[owner] for rows in (sets.v, sets.e, sets.weight))

    def objective(x: FloatArray, rows: Places) -> tuple[FloatArray, FloatArray, FloatArray]:
        curve, slopes = model(v[rows], x[:, :V_C], end[rows], np.exp(x[:, V_C]))
        missed = (curve - e[rows]) * weight[rows]
        return misfits(missed, slopes * weight[rows, :, None], sets, owner[rows])

    return objective


def box_of(sets: DataSets, owner: Places, least_gap: FloatArray, largest_gap: FloatArray) -> Box:
    """Bounds of the variables of Eq. (34); the last two arguments are those of ln(gap), (m,)."""
    top, (low, high) = sets.top[owner], np.empty((2, owner.size, VARIABLES))
    for side, bounds, scale, gap in ((0, low, 1.0, least_gap), (1, high, top, largest_gap)):
        q = EXPONENT_BOUNDS[side] if sets.q is None else sets.q
        sides = (K_BOUNDS[side] * scale, EXPONENT_BOUNDS[side], KAPPA_BOUNDS[side] * scale, q)
        for variable, value in enumerate((*map(np.log, sides), gap)):
            bounds[:, variable] = value
    return Box(low, high, STRIDE)


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
    box = box_of(sets, owner, *gaps)
    points = [start_points(sets, owner, i, width) for i in range(starts)]
    if guess is not None:
        gap = np.clip(upper - np.exp(guess[owner, V_C]), CLOSEST * width, width)
        points.append(np.column_stack([guess[owner, :V_C], np.log(gap)]))
    minima = lowest(misfit(sets, owner, upper), np.stack(points), box, tolerance)
    # The lowest of all pieces of each data set.
    order = np.lexsort((minima.value, owner))
    piece = order[np.unique(owner[order], return_index=True)[1]]
    x, chi_square = minima.x[piece], minima.value[piece]
    near = (x - box.low[piece] < ON_BOUND) | (box.high[piece] - x < ON_BOUND)
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
    points = [np.column_stack([start[:, :V_C], fixed]) for start in starts]
    points += [start_points(sets, owner, number, gap) for number in range(fresh)]
    objective = misfit(sets, owner, np.ones(len(gap)))
    box, small = box_of(sets, owner, fixed, fixed), NEARLY if sets.tails else 0.0
    return lowest(objective, np.stack(points), box, TOLERANCE, small)
