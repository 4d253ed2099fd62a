"""Results over ranges of their inputs: all combinations of low, middle and high, and what they say.

Every input has an axis of its own, of length three, with the middle in the middle; a further, last
axis is what a curve runs along.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from microimpact.arrays import FloatArray
from microimpact.parameters import Positive

Span = tuple[Positive, Positive]


def check_spans(spans: Mapping[str, Span]) -> None:
    """Raise a ValueError for a range whose ends do not ascend."""
    for name, (low, high) in spans.items():
        if low > high:
            raise ValueError(f"{name}: [{low:g}, {high:g}] must ascend")


def open_mesh(spans: Mapping[str, Span], axes: int) -> dict[str, FloatArray]:
    """Return low, geometric middle and high of each range along an axis of its own.

    Parameters
    ----------
    spans
        Ranges by name; their axes are the first, in this order.
    axes
        Number of all axes.
    """
    mesh = {}
    for axis, (name, (low, high)) in enumerate(spans.items()):
        shape = [3 if i == axis else 1 for i in range(axes)]
        mesh[name] = np.array([low, np.sqrt(low * high), high]).reshape(shape)
    return mesh


def middle(values: FloatArray, axes: int) -> FloatArray:
    """Return values where every range is at its middle, given the number of ranges."""
    return np.asarray(values[(1,) * axes])


def first_crossing(x: FloatArray, ratio: FloatArray) -> FloatArray:
    """Return x at which a ratio first falls to one, along its last axis; NaN if it never does."""
    below = ratio <= 1.0
    found = np.where(below[..., 0], x[0], np.nan)
    crosses = below.any(axis=-1) & ~below[..., 0]
    after = below[crosses].argmax(axis=-1)
    row = np.arange(after.size)
    above, at = (np.log(ratio[crosses][row, after - i]) for i in (1, 0))
    found[crosses] = x[after - 1] + above / (above - at) * (x[after] - x[after - 1])
    return found


def distance_from_equality(*values: FloatArray) -> FloatArray:
    """Return the factor by which the farthest of some values misses their geometric mean."""
    logarithms = np.log(np.stack(np.broadcast_arrays(*values)))
    return np.asarray(np.exp(np.abs(logarithms - logarithms.mean(axis=0)).max(axis=0)))


def band_row(
    quantity: str,
    values: FloatArray,
    unit: str = "-",
    *,
    low: float = np.nan,
    high: float = np.nan,
) -> dict[str, object]:
    """Return a row of a table: middle, band, and how often given bounds hold.

    Parameters
    ----------
    quantity, unit
        What it is.
    values
        At every combination, shape (3, ..., 3); NaN where it does not exist.
    low, high
        Bounds of a statement; one that is not given excludes nothing.

    Returns
    -------
    dict
        ``holds`` is for the middle, ``share`` for all combinations, alike in weight. Without
        bounds the share is that of the combinations in which the quantity exists.
    """
    bounded = np.isfinite(low) or np.isfinite(high)
    exists = np.isfinite(values)
    inside = exists & ~((values < low) | (values > high))
    found = values[exists] if exists.any() else np.array([np.nan])
    centre = (1,) * values.ndim
    return {
        "quantity": quantity,
        "middle": float(values[centre]),
        "low": float(found.min()),
        "high": float(found.max()),
        "unit": unit,
        "bound_low": low,
        "bound_high": high,
        "holds": ("yes" if inside[centre] else "no") if bounded else "",
        "share": float(inside.mean()),
        "evidence": "computed",
    }
