"""Regions of the impulse ratio over the angle, found by change points (Section 2.4)."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np

from microimpact.core.arrays import FloatArray

MOST_KNOTS = 3
# Angles at which regions are looked for, denser than the article's 14.
REGION_ANGLES = np.array(
    [*range(87, 54, -3), *range(55, 44, -2), *range(42, 17, -3), 16, 14, *range(12, 7, -1)], float
)


def segments(x: FloatArray, y: FloatArray, error: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Fit a continuous, piecewise linear curve; return its knots and its values there.

    The first and last knot are the ends of the data, those between lie at data. How many there
    are is decided by the Bayesian information criterion, each knot counting for two parameters.

    Parameters
    ----------
    x
        Ascending, shape (n,).
    y, error
        Data and their standard errors, shape (n,).
    """
    best: tuple[float, FloatArray, FloatArray] | None = None
    for count in range(MOST_KNOTS + 1):
        inner = list(combinations(range(1, x.size - 1), count))
        chosen = np.array(inner, dtype=int).reshape(len(inner), count)
        knots = np.column_stack(
            [np.full(len(chosen), x[0]), x[chosen], np.full(len(chosen), x[-1])]
        )
        misfit, values = _fits(x, y, error, knots)
        at = int(np.argmin(misfit))
        score = misfit[at] + (2 + 2 * count) * np.log(x.size)
        if best is None or score < best[0]:
            best = float(score), knots[at], values[at]
    assert best is not None
    return best[1], best[2]


def _fits(
    x: FloatArray, y: FloatArray, error: FloatArray, knots: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Weighted sum of squares and values at the knots of many fits at once; knots (m, k)."""
    left, right = knots[:, :-1, None], knots[:, 1:, None]
    share = np.clip((x - left) / (right - left), 0.0, 1.0)
    ones = np.ones_like(share[:, :1])
    # Hat functions: what of each knot's value is at x.
    hats = np.concatenate([ones, share], axis=1) - np.concatenate([share, 0.0 * ones], axis=1)
    design = np.swapaxes(hats / error, 1, 2)
    normal = np.swapaxes(design, 1, 2) @ design
    right_side = np.swapaxes(design, 1, 2) @ (y / error)
    values = np.linalg.solve(normal, right_side[..., None])[..., 0]
    residual = (design @ values[..., None])[..., 0] - y / error
    return np.sum(residual**2, axis=1), values


def regions(
    angle: FloatArray, ratio: FloatArray, error: FloatArray, constant_within: float
) -> list[dict[str, Any]]:
    """Return kind and width of the regions of a mean impulse ratio, from steep to shallow angles.

    Piecewise linear in the cotangent: rolling spheres follow a line there, sliding ones a
    constant. Rolling is the first segment; sliding the longest of the others over which the ratio
    is constant; what lies between is transition, what lies beyond departure.

    Parameters
    ----------
    angle
        Degrees, descending, shape (n,).
    ratio, error
        Means and their standard errors, which the fit must meet, shape (n,).
    constant_within
        Relative change over a segment up to which it counts as constant.
    """
    x = 1.0 / np.tan(np.radians(angle))
    knots, values = segments(x, ratio, error)
    change, length = np.diff(values), np.diff(knots)
    relative = np.abs(change) / np.minimum(values[1:], values[:-1])
    flat = relative <= constant_within
    flat[0] = False
    sliding = int(np.argmax(np.where(flat, length, -1.0))) if flat.any() else len(change)
    ends = np.degrees(np.arctan2(1.0, knots))
    return [
        {
            "region": _kind(k, sliding),
            "width_deg": ends[k] - ends[k + 1],
        }
        for k in range(len(change))
    ]


def _kind(segment: int, sliding: int) -> str:
    if segment == 0:
        return "rolling"
    if segment < sliding:
        return "transition"
    return "sliding" if segment == sliding else "departure"
