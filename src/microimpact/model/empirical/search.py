"""Search for the least squares fit of Eq. (34): global minimum and profile in v_c.

Two things keep a plain search from the minimum. The slope of Eq. (34) in v_c is infinite at a
point where v = v_c (for q < 1), and the clip bends the sum of squares at every captured speed. So
v_c is sought piece by piece between those speeds, through the logarithm of its distance from the
upper end of the piece: in that variable the sum of squares is smooth. The other parameters are
searched as logarithms, too, and speeds are in units of the smallest one that rebounds.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from microimpact.core.arrays import BoolArray, FloatArray

# Places in a vector of all five parameters.
Q, V_C = 3, 4
# Bounds of k and kappa over the smallest and the largest speed, and of the exponents.
K_BOUNDS = (1e-3, 1e6)
KAPPA_BOUNDS = (1e-6, 1e3)
EXPONENT_BOUNDS = (0.02, 20.0)
# Distances from the end of a piece below this share of it count as none.
CLOSEST = 1e-9
# Logarithms closer than this to a bound count as lying on it.
ON_BOUND = 1e-3
# Relative changes of chi-square and of the variables at which a search ends.
TOLERANCE = 1e-13
PROFILE_TOLERANCE = 1e-9
# An upper end of v_c nearer than this to the smallest rebounding speed is set by that speed.
AT_REBOUND = 1e-3
# Starts: k over the largest speed, p, q, and the distance of v_c from the end of its piece as a
# share of the piece.
STARTS = (
    (10.0, 0.5, 0.5, 0.1),
    (10.0, 1.0, 1.0, 0.5),
    (1.0, 2.0, 0.5, 0.1),
    (10.0, 1.0, 0.5, 0.01),
    (0.1, 1.0, 2.0, 0.9),
)


@dataclass(frozen=True, slots=True)
class Problem:
    """Data in units of the smallest rebounding speed, and bounds of ln(k, p, kappa, q).

    ``weight`` is proportional to 1/sigma, at most 1; ``q`` is None where it is free.
    """

    v: FloatArray
    e: FloatArray
    weight: FloatArray
    q: float | None

    @property
    def free(self) -> BoolArray:
        """Which of k, p, kappa, q are sought."""
        return np.array([True, True, True, self.q is None])

    @property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper bounds of ln(k, p, kappa, q)."""
        ends = (1.0, self.v.max())
        k, kappa = np.multiply(K_BOUNDS, ends), np.multiply(KAPPA_BOUNDS, ends)
        exponent = np.array(EXPONENT_BOUNDS)
        pairs = np.log(np.stack([k, exponent, kappa, exponent]))
        return pairs[:, 0], pairs[:, 1]

    @property
    def edges(self) -> FloatArray:
        """Ends of the pieces of v_c: 0, the captured speeds below 1, and 1."""
        captured = self.v[(self.e == 0.0) & (self.v < 1.0 - CLOSEST)]
        edges = np.unique(np.concatenate([[0.0], captured, [1.0]]))
        apart: FloatArray = edges[np.concatenate([[True], np.diff(edges) > CLOSEST])]
        return apart


@dataclass(frozen=True, slots=True)
class Optimum:
    """Logarithms of k, p, kappa, q; v_c; sum of squares; and how the search ended."""

    logs: FloatArray
    v_c: float
    chi_square: float
    converged: bool
    on_edge: bool = False
    agreeing: int = 1
    starts: int = 1


def model(v: FloatArray, logs: FloatArray, end: float, gap: float) -> tuple[FloatArray, FloatArray]:
    """Eq. (34) at v_c = end - gap, and its slopes in ln(k, p, kappa, q) and ln(gap).

    Parameters
    ----------
    v
        Speeds (n,), positive.
    logs
        ln k, ln p, ln kappa, ln q.
    end, gap
        No speed above v_c may lie below ``end``, or the slope in ln(gap) is unbounded.

    Returns
    -------
    tuple
        e (n,) and slopes (n, 5).
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


def _minimise(
    problem: Problem,
    start: FloatArray,
    free: BoolArray,
    bounds: tuple[FloatArray, FloatArray],
    place: Callable[[FloatArray], tuple[float, float]],
    tolerance: float = TOLERANCE,
) -> tuple[FloatArray, float, bool]:
    """Least squares over the free ones of five variables; ``place`` gives end and gap."""
    from scipy.optimize import least_squares

    def full(x: FloatArray) -> FloatArray:
        every = start.copy()
        every[free] = x
        return every

    def misfit(x: FloatArray) -> FloatArray:
        every = full(x)
        return (model(problem.v, every[:V_C], *place(every))[0] - problem.e) * problem.weight

    def slopes(x: FloatArray) -> FloatArray:
        every = full(x)
        return model(problem.v, every[:V_C], *place(every))[1][:, free] * problem.weight[:, None]

    low, high = bounds[0][free], bounds[1][free]
    x = np.clip(start[free], low + 1e-6 * (high - low), high - 1e-6 * (high - low))
    box = (low, high)
    # ftol, xtol, gtol; the last is absolute, and near-perfect fits have small slopes.
    ends = (tolerance, tolerance, 1e-15)
    # "trf" finds the right valley; "dogbox" is much faster along one that is long and flat.
    found = least_squares(misfit, x, slopes, box, "trf", *ends, max_nfev=80)
    if found.status == 0:
        found = least_squares(misfit, found.x, slopes, box, "dogbox", *ends, max_nfev=400)
    return full(found.x), 2.0 * float(found.cost), bool(found.status > 0)


def solve_at(
    problem: Problem, v_c: float, *starts: FloatArray, tolerance: float = TOLERANCE
) -> Optimum:
    """Best k, p, kappa, q for a given v_c, from starts ln(k, p, kappa, q)."""
    free = np.append(problem.free, False)
    bounds = tuple(np.append(bound, 0.0) for bound in problem.bounds)
    found = []
    for start in starts:
        x, chi_square, converged = _minimise(
            problem,
            np.append(start, 0.0),
            free,
            (bounds[0], bounds[1]),
            lambda _: (v_c, 0.0),
            tolerance,
        )
        found.append(Optimum(x[:V_C], v_c, chi_square, converged))
    return min(found, key=lambda optimum: optimum.chi_square)


def _solve_within(problem: Problem, lower: float, upper: float, start: FloatArray) -> Optimum:
    """Best parameters with v_c between two neighbouring edges, from ln(k, p, kappa, q, gap)."""
    width = upper - lower
    low, high = problem.bounds
    bounds = (np.append(low, np.log(CLOSEST * width)), np.append(high, np.log(width)))
    x, chi_square, converged = _minimise(
        problem,
        start,
        np.append(problem.free, True),
        bounds,
        lambda x: (upper, float(np.exp(x[V_C]))),
    )
    gap = math.exp(x[V_C])
    on_edge = gap < (1.0 + ON_BOUND) * CLOSEST * width or gap > (1.0 - CLOSEST) * width
    return Optimum(x[:V_C], max(upper - gap, lower), chi_square, converged, on_edge)


def minimum(problem: Problem, logs: FloatArray | None = None) -> Optimum:
    """Global minimum.

    Parameters
    ----------
    problem
        The data.
    logs
        A start ln(k, p, kappa, q, v_c) believed to be good; then one other start is tried.

    Returns
    -------
    Optimum
        ``agreeing`` of ``starts`` searches in its piece ended there.
    """
    edges, found = problem.edges, []
    for lower, upper in pairwise(edges.tolist()):
        starts = _starts(problem, upper - lower)
        if logs is not None:
            gap = np.clip(upper - np.exp(logs[V_C]), 0.01 * (upper - lower), upper - lower)
            starts = [np.append(logs[:V_C], np.log(gap)), starts[0]]
        runs = [_solve_within(problem, lower, upper, start) for start in starts]
        best = min(runs, key=lambda run: run.chi_square)
        near = sum(_as_good(run.chi_square, best.chi_square, problem) for run in runs)
        found.append((best, lower, near, len(runs)))
    best, lower, near, tried = min(found, key=lambda each: each[0].chi_square)
    edge = solve_at(problem, lower, best.logs)
    if edge.chi_square <= best.chi_square * (1.0 + 1e-9):
        best = Optimum(edge.logs, lower, edge.chi_square, edge.converged, on_edge=True)
    return Optimum(best.logs, best.v_c, best.chi_square, best.converged, best.on_edge, near, tried)


def _as_good(chi_square: float, best: float, problem: Problem) -> bool:
    scale = float(np.sum(np.square(problem.weight * problem.e)))
    return chi_square <= best * (1.0 + 1e-4) + 1e-12 * scale


def _starts(problem: Problem, width: float) -> list[FloatArray]:
    top = float(problem.v.max())
    return [
        np.log([k * top, p, 0.3, q if problem.q is None else problem.q, share * width])
        for k, p, q, share in STARTS
    ]


def profile_interval(
    problem: Problem, best: Optimum, threshold: float
) -> tuple[tuple[float, float], tuple[bool, bool], Optimum]:
    """Range of v_c in which the profiled sum of squares stays below minimum + threshold.

    Parameters
    ----------
    problem, best
        The data and the minimum.
    threshold
        Admissible rise of the sum of squares, positive.

    Returns
    -------
    tuple
        The two ends; whether each is set by the admissible range, 0 to 1, and not by the values
        of e; and the lowest point met, a better minimum if one was overlooked.
    """
    ends, open_ends, lowest = [], [], best
    for outwards in (2.0, 0.5):
        inside, last = 1.0 - best.v_c, best
        while True:
            gap = min(max(inside, CLOSEST) * outwards, 1.0)
            stop = gap == 1.0 if outwards > 1.0 else gap < CLOSEST
            gap = gap if gap >= CLOSEST else 0.0
            point = solve_at(problem, 1.0 - gap, last.logs, best.logs, tolerance=PROFILE_TOLERANCE)
            lowest = min(lowest, point, key=lambda each: each.chi_square)
            if point.chi_square > best.chi_square + threshold or stop:
                break
            inside, last = gap, point
        held = point.chi_square <= best.chi_square + threshold
        open_ends.append(held)
        ends.append(1.0 - gap if held else _crossing(problem, best, last, threshold, inside, gap))
    return (ends[0], ends[1]), (open_ends[0], ends[1] > 1.0 - AT_REBOUND), lowest


def _crossing(
    problem: Problem, best: Optimum, last: Optimum, threshold: float, inside: float, outside: float
) -> float:
    """v_c at which the profile crosses the threshold, between two distances from 1."""
    from scipy.optimize import brentq

    def rise(log_gap: float) -> float:
        v_c = 1.0 - math.exp(log_gap)
        point = solve_at(problem, v_c, last.logs, tolerance=PROFILE_TOLERANCE)
        return point.chi_square - best.chi_square - threshold

    low, high = (math.log(max(gap, 0.1 * CLOSEST)) for gap in (inside, outside))
    if rise(high) * rise(low) >= 0.0:
        return 1.0 - outside
    return 1.0 - math.exp(float(brentq(rise, low, high, xtol=1e-5)))
