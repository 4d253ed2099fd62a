"""Least squares search of many curves of Eq. (34) at once, by Levenberg and Marquardt."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from microimpact.arrays import BoolArray, FloatArray
from microimpact.model.restitution_search import V_C, Q

Rows = npt.NDArray[Any]

# A search ends where the quadratic model and the step taken lower chi-square by less than this
# share of it, or where no damping finds a lower point.
TOLERANCE = 1e-9
STUCK = 1e10
ITERATIONS = 300
# Damping at the start and the least, as shares of the diagonal of the normal matrix.
FIRST_DAMPING = 1e-2
LEAST_DAMPING = 1e-9
# The damping at which a small decrease means a minimum and not a small step.
LIGHT_DAMPING = 0.1
# Largest change of a logarithm in one step: beyond it the quadratic model says nothing.
STRIDE = 2.0
# Keeps a normal matrix of full rank in directions that the data do not determine.
RIDGE = 1e-14
# Searches that are advanced together, so that their arrays stay in the cache; and how many of
# them have ended when others take their places.
TOGETHER = 512
ENDED = 24


class Search(NamedTuple):
    """Data (m, n) of m searches, and the upper end (m,) of the range of v_c of each."""

    v: FloatArray
    log_v: FloatArray
    e: FloatArray
    weight: FloatArray
    end: FloatArray

    def take(self, rows: Rows) -> Search:
        """Return some of the searches."""
        return Search(*(field[rows] for field in self))


class Found(NamedTuple):
    """Variables ln(k, p, kappa, q, gap) (m, 5), chi-square (m,), whether the searches converged."""

    x: FloatArray
    chi_square: FloatArray
    converged: BoolArray


class _State(NamedTuple):
    """Where the searches stand: steps left, variables, box, damping, local quadratic model."""

    left: Rows
    x: FloatArray
    low: FloatArray
    high: FloatArray
    damping: FloatArray
    chi_square: FloatArray
    matrix: FloatArray
    gradient: FloatArray

    def take(self, rows: Rows) -> _State:
        """Return some of the searches."""
        return _State(*(field[rows] for field in self))


def descend(search: Search, x: FloatArray, low: FloatArray, high: FloatArray) -> Found:
    """Lower the sums of squares from x as far as possible within the box.

    Some searches advance together; where enough of them have ended, the next ones take their
    places. What one finds does not depend on the others.

    Parameters
    ----------
    search
        The data of m searches.
    x
        Starts ln(k, p, kappa, q, gap), (m, 5).
    low, high
        Box (m, 5); a variable whose bounds are equal is fixed.
    """
    x = np.clip(x, low, high)
    found = Found(x.copy(), np.empty(len(x)), np.zeros(len(x), bool))
    row, begun = np.arange(0), 0
    data, state = search.take(row), _begin(search.take(row), x[row], low[row], high[row])
    running = np.zeros(0, bool)
    while True:
        if np.count_nonzero(running) <= len(running) - ENDED or not running.any():
            room = TOGETHER - int(np.count_nonzero(running))
            fresh = np.arange(begun, min(begun + room, len(x)))
            begun += len(fresh)
            row = np.concatenate([row[running], fresh])
            if not len(row):
                return found
            entry = search.take(fresh)
            data = Search(*_joined(data.take(running), entry))
            start = _begin(entry, x[fresh], low[fresh], high[fresh])
            state = _State(*_joined(state.take(running), start))
            running = np.ones(len(row), bool)
        state, converged, stuck = _step(data, state)
        ended = running & (converged | stuck | (state.left == 0))
        found.x[row[ended]], found.chi_square[row[ended]] = state.x[ended], state.chi_square[ended]
        found.converged[row[ended]] = (converged | stuck)[ended]
        running &= ~ended


def _joined(some: tuple[Any, ...], more: tuple[Any, ...]) -> Iterator[Any]:
    """Join the arrays of two tuples, one by one."""
    return (np.concatenate(pair) for pair in zip(some, more, strict=True))


def _begin(data: Search, x: FloatArray, low: FloatArray, high: FloatArray) -> _State:
    """Return the state of searches at their starts."""
    left, damping = np.full(len(x), ITERATIONS), np.full(len(x), FIRST_DAMPING)
    return _State(left, x, low, high, damping, *_local(data, x))


def curves(search: Search, x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Eq. (34) at v_c = end - gap, as `microimpact.model.restitution_search.model` for one curve.

    Parameters
    ----------
    search
        The data.
    x
        ln(k, p, kappa, q, gap), (m, 5).

    Returns
    -------
    tuple
        e (m, n) and its slopes in the variables (m, 5, n).
    """
    p, q, gap = (np.exp(x[:, i, None]) for i in (1, Q, V_C))
    excess = (search.v - search.end[:, None]) + gap
    rebounds = excess > 0.0
    excess = np.where(rebounds, excess, 1.0)
    fall = search.log_v - x[:, 0, None]
    rise = np.log(excess) - x[:, 2, None]
    with np.errstate(over="ignore"):
        body = 1.0 / (1.0 + np.exp(p * fall))
        kept = np.where(rebounds, 1.0 / (1.0 + np.exp(-q * rise)), 0.0)
    e = body * kept
    slopes = np.empty((len(x), x.shape[1], search.v.shape[1]))
    loss, taken = slopes[:, 0], e * (1.0 - kept) * q
    np.multiply(e * (1.0 - body), p, out=loss)
    np.multiply(-loss, fall, out=slopes[:, 1])
    np.negative(taken, out=slopes[:, 2])
    np.multiply(taken, rise, out=slopes[:, Q])
    np.divide(taken * gap, excess, out=slopes[:, V_C])
    return e, slopes


def _local(search: Search, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Sum of squares (m,), its Gauss-Newton matrix (m, 5, 5) and half its gradient (m, 5)."""
    e, slopes = curves(search, x)
    misfit = (e - search.e) * search.weight
    slopes *= search.weight[:, None, :]
    matrix = slopes @ slopes.transpose(0, 2, 1)
    gradient = (slopes @ misfit[:, :, None])[:, :, 0]
    return np.sum(misfit * misfit, axis=1), matrix, gradient


def _step(search: Search, state: _State) -> tuple[_State, BoolArray, BoolArray]:
    """Try one damped step; return the new state, which have converged, and which are stuck."""
    _, x, low, high, damping, chi_square, matrix, gradient = state
    held = (low == high) | ((x <= low) & (gradient > 0.0)) | ((x >= high) & (gradient < 0.0))
    downhill = np.where(held, 0.0, gradient)
    damped = np.where(held[:, :, None] | held[:, None, :], 0.0, matrix)
    diagonal = np.where(held, 1.0, np.diagonal(matrix, axis1=1, axis2=2))
    places = np.arange(x.shape[1])
    damped[:, places, places] = diagonal * (1.0 + damping[:, None])
    damped[:, places, places] += RIDGE * diagonal.max(axis=1, keepdims=True)
    step = -np.linalg.solve(damped, downhill[:, :, None])[:, :, 0]
    trial = np.clip(x + np.clip(step, -STRIDE, STRIDE), low, high)
    step = trial - x
    curvature = np.sum(step * (matrix @ step[:, :, None])[:, :, 0], axis=1)
    expected = -2.0 * np.sum(downhill * step, axis=1) - curvature
    there = _local(search, trial)
    decrease = chi_square - there[0]
    lower = decrease >= 0.0
    small = TOLERANCE * there[0]
    converged = lower & (decrease <= small) & (expected <= small) & (damping < LIGHT_DAMPING)
    stuck = damping > STUCK
    lighter = np.where(
        decrease > 0.5 * expected, 0.1, np.where(decrease > 0.1 * expected, 0.5, 2.0)
    )
    damping = np.maximum(damping * np.where(lower, lighter, 8.0), LEAST_DAMPING)
    new = state._replace(
        left=state.left - 1,
        x=np.where(lower[:, None], trial, x),
        damping=damping,
        chi_square=np.where(lower, there[0], chi_square),
        matrix=np.where(lower[:, None, None], there[1], matrix),
        gradient=np.where(lower[:, None], there[2], gradient),
    )
    return new, converged, stuck
