"""Where a function crosses zero, and where a condition begins to hold."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microimpact.core.arrays import FloatArray
from microimpact.core.computable import NotComputable

Place = TypeVar("Place", float, FloatArray)

IntArray = NDArray[np.intp]

# Relative error to which a root is sought where none is asked for: the least there is.
ROUNDING = 4.0 * float(np.finfo(float).eps)
# Numbers closer to zero than this lose digits, and pass for it.
TINY = float(np.finfo(float).tiny)
# Steps after which a search has failed: halving takes 53 down to rounding, and 1100 down to zero.
MOST_STEPS = 2000


class NoRootError(NotComputable):
    """There is no root, or none was found, between the ends given."""


def root(
    function: Callable[[float], Any],
    low: float,
    high: float,
    *,
    absolute: float = 0.0,
    relative: float = ROUNDING,
) -> float:
    """Return where a function of one number is zero, by Brent's method (SciPy's).

    Parameters
    ----------
    function
        Continuous; takes and returns one number.
    low, high
        Ends, between which it changes its sign.
    absolute, relative
        The root is known to ``absolute + relative * abs(root)``.

    Raises
    ------
    NoRootError
        If the sign is the same at both ends, or the search does not end.
    """
    from scipy.optimize import brentq

    value = cache(lambda x: float(function(x)))
    ends = value(low), value(high)
    if not min(ends) <= 0.0 <= max(ends):
        raise NoRootError(
            f"no change of sign between {low:g}, with {ends[0]:g}, and {high:g}, with {ends[1]:g}"
        )
    ends_at: dict[str, Any] = {"xtol": max(absolute, TINY), "rtol": relative, "maxiter": MOST_STEPS}
    zero, report = brentq(value, low, high, **ends_at, full_output=True, disp=False)
    if not report.converged:
        raise NoRootError(f"no root found between {low:g} and {high:g} in {MOST_STEPS} steps")
    return float(zero)


def roots(
    function: Callable[..., FloatArray],
    low: ArrayLike,
    high: ArrayLike,
    *arguments: ArrayLike,
    absolute: float = 0.0,
    relative: float = ROUNDING,
    residual: float = 0.0,
) -> FloatArray:
    """Return where each of many functions is zero, by Chandrupatla's method.

    SciPy's `find_root` gives the same roots, but spends two milliseconds more on each of some
    thousand calls, and a third of a second on import in jobs that need nothing else of it.

    Parameters
    ----------
    function
        Takes ``x`` and ``arguments`` of one shape (m,) each, those of the roots still sought, and
        returns the values (m,).
    low, high
        Ends, any shape, between which each function changes its sign.
    arguments
        What tells the functions apart, of shapes that broadcast with the ends.
    absolute, relative
        A root is known to ``absolute + relative * abs(root)``.
    residual
        A value so close to zero passes for zero, at an end too.

    Raises
    ------
    NoRootError
        If the sign is the same at both ends, or a search does not end; the first is named.

    References
    ----------
    T. R. Chandrupatla, Advances in Engineering Software 28 (1997) 145-149.
    """
    every = np.broadcast_arrays(np.asarray(low, float), np.asarray(high, float), *arguments)
    x_1, x_2, *parameters = (each.ravel() for each in every)
    f_1, f_2 = function(x_1, *parameters), function(x_2, *parameters)
    x_3, f_3 = x_2, f_2
    zeros, sought = np.empty(x_1.size), np.arange(x_1.size)
    for _ in range(MOST_STEPS):
        nearer = np.abs(f_1) < np.abs(f_2)
        best, width = np.where(nearer, x_1, x_2), np.abs(x_2 - x_1)
        error = np.abs(best) * relative + absolute
        done = np.abs(np.where(nearer, f_1, f_2)) <= residual
        if np.any(wrong := ~done & ~(np.sign(f_1) * np.sign(f_2) < 0.0)):
            raise _no_root(int(np.argmax(wrong)), sought, (x_1, x_2), (f_1, f_2))
        done |= width < error
        if np.any(done):
            zeros[sought[done]] = best[done]
            kept = (sought, x_1, x_2, x_3, f_1, f_2, f_3, width, error, *parameters)
            sought, x_1, x_2, x_3, f_1, f_2, f_3, width, error, *parameters = (
                k[~done] for k in kept
            )
        if not sought.size:
            break
        with np.errstate(all="ignore"):
            # Inverse quadratic interpolation where the three points are even enough, else halving.
            xi, phi = (x_1 - x_2) / (x_3 - x_2), (f_1 - f_2) / (f_3 - f_2)
            even = (1.0 - np.sqrt(1.0 - xi) < phi) & (phi < np.sqrt(xi))
            alpha = (x_3 - x_1) / (x_2 - x_1)
            quadratic = f_1 / (f_1 - f_2) * f_3 / (f_3 - f_2)
            quadratic -= alpha * f_1 / (f_3 - f_1) * f_2 / (f_2 - f_3)
        least = 0.5 * error / width
        x = x_1 + np.clip(np.where(even, quadratic, 0.5), least, 1.0 - least) * (x_2 - x_1)
        f = function(x, *parameters)
        same = np.sign(f) == np.sign(f_1)
        x_3, f_3 = np.where(same, x_1, x_2), np.where(same, f_1, f_2)
        x_2, f_2 = np.where(same, x_2, x_1), np.where(same, f_2, f_1)
        x_1, f_1 = x, f
    else:
        raise _no_root(0, sought, (x_1, x_2), (f_1, f_2))
    return zeros.reshape(every[0].shape)[()]


def _no_root(
    index: int, sought: IntArray, ends: tuple[FloatArray, ...], values: tuple[FloatArray, ...]
) -> NoRootError:
    (low, f_low), (high, f_high) = sorted(
        (float(end[index]), float(value[index])) for end, value in zip(ends, values, strict=True)
    )
    return NoRootError(
        f"root {sought[index]}: none found between {low:g}, with {f_low:g}, and {high:g}, "
        f"with {f_high:g}"
    )


def threshold(
    holds: Callable[[Any], Any],
    low: Place,
    high: Place,
    *,
    absolute: float = 0.0,
    relative: float = ROUNDING,
) -> Place:
    """Return where a condition begins to hold, by halving.

    Parameters
    ----------
    holds
        False at ``low``, true at ``high``, with one change between them; takes numbers of the shape
        of the ends.
    low, high
        Ends, numbers or arrays of one shape, in either order.
    absolute, relative
        A place is known to ``absolute + relative * abs(place)``; it is one at which the condition
        holds.

    Raises
    ------
    NoRootError
        If the condition holds at ``low`` or does not at ``high``.
    """
    for end, wanted in ((low, False), (high, True)):
        wrong = np.asarray(holds(end)) != wanted
        if np.any(wrong):
            end_value = float(np.asarray(end)[wrong].flat[0])
            raise NoRootError(f"the condition must {'' if wanted else 'not '}hold at {end_value:g}")
    least = max(absolute, TINY)
    below: Any = low
    above: Any = high
    while np.any(np.abs(np.subtract(above, below)) > least + relative * np.abs(above)):
        middle = 0.5 * (below + above)
        if np.ndim(middle):
            true = holds(middle)
            below, above = np.where(true, below, middle), np.where(true, middle, above)
        else:
            below, above = (below, middle) if holds(middle) else (middle, above)
    least_true: Place = above
    return least_true
