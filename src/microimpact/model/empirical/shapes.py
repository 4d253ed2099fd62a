"""Restitution by the laws of contact as tables over v/v_c, and their search with v_c held.

In units of its capture velocity a law of contact has one to three parameters left, whatever the
materials. Each is tabulated once a process, at places evenly spaced in the logarithms of the
parameters, in the rate exponent n, and in the square root of ln(v/v_c), in which e is smooth
through capture. Between them e is that of the cubic through the four nearest places of each axis.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np

from microimpact.core.arrays import FloatArray, Real
from microimpact.core.compiled import jit
from microimpact.core.materials import Material
from microimpact.model.contact import Contact
from microimpact.model.contact_laws import JKR, Hysteresis, ThorntonNing
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.normal import normal_impact

# Places over v/v_c, up to a ratio of 10,000, and over each parameter of a law with two, or one; a
# law that begins to yield has a kink.
RATIOS, LARGEST_RATIO, TWO, ONE, KINKED = 56, 1e4, 28, 48, 100
# One place stands for a parameter that a law has not.
NONE = (1.0, 1.0, 1)
PARAMETERS = 3
# Starts that a search is made from: the lowest. With v_c held nearly all lead to one minimum, and
# where neighbours in v_c found another, a profile begins there next time.
TRIED = 3
# A search begins with this damping of its steps and ends at the next, at a step that lowers
# chi-square by less than this share, or after so many steps; none is longer than this share.
DAMPED, OVERDAMPED, SHORTEST, STEPS, LONGEST = 1e-2, 1e6, 1e-6, 60, 0.3

# Materials and size set units alone.
_BODY = Material(name="any", youngs_modulus=1e11, poissons_ratio=0.25, density=2500.0)
_ANY = Contact(particle=_BODY, surface=_BODY, diameter=20e-6, work_of_adhesion=0.1)
_SPEED = float(np.asarray(_ANY.velocity_scale))
Axis = tuple[float, float, int]

_jit = jit()
_jit_contract = jit(fastmath={"contract"})


@dataclass(frozen=True, slots=True, kw_only=True)
class Law:
    """A family of e(v/v_c).

    Attributes
    ----------
    axes
        First and last value and number of places of two parameters.
    contact
        Contact (m, 1) of two parameters (m, 1); None: e is the first parameter times
        sqrt(1 - (v_c/v)^2).
    exponents
        The same of n, by which the adhesion damping falls with speed; it is given at v_c.
    starts
        Where searches begin, as shares of the axes of n and the two parameters.
    """

    axes: tuple[Axis, Axis]
    contact: Callable[[Real, Real], Contact] | None
    exponents: Axis = (0.0, 0.0, 1)
    starts: tuple[tuple[float, ...], ...] = ((0.0, 0.2, 0.0), (0.0, 0.5, 0.0), (0.0, 0.8, 0.0))

    @property
    def values(self) -> tuple[FloatArray, ...]:
        """Values of n and of the two parameters."""
        return np.linspace(*self.exponents), *(np.geomspace(*axis) for axis in self.axes)

    @property
    def free(self) -> int:
        """Number of parameters, without v_c."""
        return sum(of.size > 1 for of in self.values)


# C_A from which on nothing leaves.
_OVERDAMPED = 1.15


def _ring(hertz: Real, adhesion: Real) -> Contact:
    """Contact of C_H and of C_A at v_c, the latter over what it lacks to overdamping."""
    group = _OVERDAMPED * adhesion / (1.0 + adhesion)
    return _ANY.replace(hertz_damping=hertz / _SPEED, adhesion_damping=group / _SPEED)


LAWS = {
    "ring force": Law(
        axes=((1e-5, 0.4, TWO), (1e-3, 30.0, TWO)),
        contact=_ring,
        exponents=(0.0, 2.0, 9),
        starts=tuple(
            (n, *shares)
            for n in (0.25, 0.75)
            for shares in ((0.8, 0.8), (0.5, 0.5), (0.6, 0.05), (0.05, 0.7))
        ),
    ),
    "viscous JKR": Law(
        axes=((1e-11, 2e-8, ONE), NONE),
        contact=lambda time, _: _ANY.replace(law=JKR(viscous_time=time)),
    ),
    "Thornton-Ning": Law(
        axes=((5e7, 2e10, KINKED), NONE),
        contact=lambda pressure, _: _ANY.replace(law=ThorntonNing(yield_pressure=pressure)),
    ),
    "hysteresis": Law(
        axes=((0.1, 1e3, ONE), NONE),
        contact=lambda work, _: _ANY.replace(law=Hysteresis(unloading_work=work)),
    ),
    "fixed loss": Law(axes=((0.01, 1.0, ONE), NONE), contact=None),
}


class Held(NamedTuple):
    """Searches with v_c held: chi-square (m,) and the other parameters (m, k)."""

    chi_square: FloatArray
    others: FloatArray


@cache
def table(name: str) -> FloatArray:
    """Return e at all places of a law, (n, first parameter, second, v/v_c)."""
    law = LAWS[name]
    rates, one, two = law.values
    ratio = np.exp(np.linspace(0.0, np.sqrt(np.log(LARGEST_RATIO)), RATIOS) ** 2)
    if law.contact is None:
        return (one[:, None] * np.sqrt(1.0 - ratio**-2))[None, :, None]
    first, second = (of.reshape(-1, 1) for of in np.meshgrid(one, two, indexing="ij"))
    limit = capture_velocity(law.contact(first, second))
    leaves = np.isfinite(limit).ravel()
    contact = law.contact(first[leaves], second[leaves])
    e = np.zeros((rates.size, leaves.size, ratio.size))
    for n, rate in enumerate(rates):
        slowed = contact.replace(adhesion_rate_exponent=rate, reference_velocity=limit[leaves])
        faster = normal_impact(slowed, limit[leaves] * ratio[1:])
        e[n, leaves, 1:] = faster.coefficient_of_restitution
    # Beyond the last contact that anything leaves, all are like it.
    kept = np.maximum.accumulate(np.where(leaves, np.arange(leaves.size), 0))
    # In order in memory, as all tables are: the search is compiled once.
    return np.ascontiguousarray(e[:, kept]).reshape(rates.size, one.size, two.size, -1)


def places(ratio: FloatArray) -> FloatArray:
    """Return where speeds in units of v_c are in a table; below 0 where captured."""
    logs = np.log(np.minimum(ratio, LARGEST_RATIO))
    found = np.sqrt(np.maximum(logs, 0.0) / np.log(LARGEST_RATIO)) * (RATIOS - 1)
    return np.where(ratio > 1.0, found, -1.0)


def restitution(name: str, at: FloatArray, ratio: FloatArray) -> FloatArray:
    """Return e (n,) of a law at the places of its parameters (3,), by its table."""
    e = np.empty(ratio.size)
    _curve(table(name), places(ratio), at, e)
    return e


def profile(
    name: str,
    v: FloatArray,
    e: FloatArray,
    weight: FloatArray,
    v_c: FloatArray,
    *starts: FloatArray,
) -> Held:
    """Search for a law's parameters by damped Gauss-Newton steps (Marquardt 1963).

    Parameters
    ----------
    name
        One of `LAWS`.
    v, e, weight
        Speeds, restitutions and 1/sigma, (n,).
    v_c
        Capture velocities held (m,), in units of v.
    starts
        Places (m, 3) to start from; none: from those of the law.
    """
    grid = table(name)
    if not starts:
        ends = np.array(grid.shape[:PARAMETERS]) - 1.0
        starts = tuple(
            np.tile(share * ends, (v_c.size, 1)) for share in np.array(LAWS[name].starts)
        )
    chi_square, at = np.full(v_c.size, np.inf), np.zeros((v_c.size, PARAMETERS))
    _search(grid, places(v / v_c[:, None]), e, weight, np.stack(starts), chi_square, at)
    return Held(chi_square, at)


@_jit
def _cubic(x, size, value, slope):  # type: ignore[no-untyped-def]
    """Weights of four places from the first, returned, on, for a value and for its slope."""
    if size == 1:
        value[0], slope[0] = 1.0, 0.0
        return 0
    first = min(max(int(x) - 1, 0), size - 4)
    t = x - first
    a, b, c = t - 1.0, t - 2.0, t - 3.0
    value[0], value[1] = -a * b * c / 6.0, t * b * c / 2.0
    value[2], value[3] = -t * a * c / 2.0, t * a * b / 6.0
    slope[0] = -(a * b + a * c + b * c) / 6.0
    slope[1] = (t * b + t * c + b * c) / 2.0
    slope[2] = -(t * a + t * c + a * c) / 2.0
    slope[3] = (t * a + t * b + a * b) / 6.0
    return first


@_jit
def _ratios(places, size, first, weights, unused):  # type: ignore[no-untyped-def]
    """Put the first of the four places about every speed, and their weights (n, 4).

    Returns the ends of all such places.
    """
    low, high = size, 0
    for n in range(places.size):
        first[n] = -1
        if places[n] >= 0.0:
            first[n] = _cubic(places[n], size, weights[n], unused)
            low, high = min(low, first[n]), max(high, first[n] + 4)
    return low, high


@_jit_contract
def _lines(grid, at, low, high, weights, lines) -> None:  # type: ignore[no-untyped-def]
    """Put slopes along the parameters' axes, and e, at places of v/v_c (4, ratios).

    ``weights`` (3, 2, 4) is room for those of values and slopes, zeros where an axis has one place.
    """
    i = _cubic(at[0], grid.shape[0], weights[0, 0], weights[0, 1])
    j = _cubic(at[1], grid.shape[1], weights[1, 0], weights[1, 1])
    k = _cubic(at[2], grid.shape[2], weights[2, 0], weights[2, 1])
    last = grid.shape[2] - 1
    a, b, c, d = weights[2, 0]
    a_slope, b_slope, c_slope, d_slope = weights[2, 1]
    # Slices from their own zero on, for compilers cannot tell that others are never negative.
    by_rate, by_one, by_two, value = lines[:, low:high]
    lines[:, low:high] = 0.0
    for n in range(min(4, grid.shape[0])):
        for p in range(min(4, grid.shape[1])):
            rows = grid[i + n, j + p, :, low:high]
            first, second = rows[k], rows[min(k + 1, last)]
            third, fourth = rows[min(k + 2, last)], rows[min(k + 3, last)]
            rate, along = weights[0, 1, n] * weights[1, 0, p], weights[0, 0, n] * weights[1, 1, p]
            own = weights[0, 0, n] * weights[1, 0, p]
            for m in range(high - low):
                e = a * first[m] + b * second[m] + c * third[m] + d * fourth[m]
                across = a_slope * first[m] + b_slope * second[m]
                across += c_slope * third[m] + d_slope * fourth[m]
                by_rate[m] += rate * e
                by_one[m] += along * e
                by_two[m] += own * across
                value[m] += own * e


@_jit
def _curve(grid, places, at, e) -> None:  # type: ignore[no-untyped-def]
    size = grid.shape[PARAMETERS]
    near, ratios, lines = np.empty(e.size, np.int64), np.empty((e.size, 4)), np.empty((4, size))
    low, high = _ratios(places, size, near, ratios, lines[0])
    _lines(grid, at, low, high, np.zeros((PARAMETERS, 2, 4)), lines)
    for n in range(e.size):
        e[n] = 0.0
        if near[n] >= 0:
            for k in range(4):
                e[n] += ratios[n, k] * lines[3, near[n] + k]


@_jit
def _sums(grid, near, ratios, ends, e, weight, at, weights, lines, sums) -> None:  # type: ignore[no-untyped-def]
    """Put sums of products of slopes and misfit, the lower half; their last row (5, 4) is room."""
    _lines(grid, at, ends[0], ends[1], weights, lines)
    found = sums[4]
    sums[:] = 0.0
    for n in range(near.size):
        found[:] = 0.0
        if near[n] >= 0:
            for k in range(4):
                for i in range(4):
                    found[i] += ratios[n, k] * lines[i, near[n] + k]
        found[3] -= e[n]
        for i in range(4):
            for j in range(i + 1):
                sums[i, j] += weight[n] ** 2 * found[i] * found[j]


@_jit
def _step(at, high, sums, damping, factor, new) -> None:  # type: ignore[no-untyped-def]
    """Put the place to which a damped step leads into ``new``; ``factor`` (3, 3) is room."""
    for i in range(PARAMETERS):
        new[i] = -sums[3, i]
        # A parameter at its bound that wants beyond it is held there.
        held = at[i] <= 0.0 if new[i] < 0.0 else at[i] >= high[i]
        factor[i, i] = np.inf if held else sums[i, i] * (1.0 + damping) + 1e-300
        for j in range(i):
            factor[i, j] = sums[i, j]
    for k in range(PARAMETERS):
        for i in range(k + 1, PARAMETERS):
            share = factor[i, k] / factor[k, k]
            new[i] -= share * new[k]
            for j in range(k + 1, i + 1):
                factor[i, j] -= share * factor[j, k]
    for k in range(PARAMETERS - 1, -1, -1):
        new[k] /= factor[k, k]
        for i in range(k):
            new[i] -= factor[k, i] * new[k]
    for i in range(PARAMETERS):
        step = min(max(new[i], -LONGEST * high[i]), LONGEST * high[i])
        new[i] = min(max(at[i] + step, 0.0), high[i])


@_jit
def _search(grid, places, e, weight, starts, chi_square, found) -> None:  # type: ignore[no-untyped-def]  # noqa: C901
    """Search from the lowest of the starts (s, m, 3) of each row of places (m, n)."""
    size = grid.shape[PARAMETERS]
    weights, lines = np.zeros((PARAMETERS, 2, 4)), np.empty((4, size))
    near, ratios = np.empty(e.size, np.int64), np.empty((e.size, 4))
    sums, trial, factor = np.empty((5, 4)), np.empty((5, 4)), np.empty((PARAMETERS, PARAMETERS))
    new, high = np.empty(PARAMETERS), np.empty(PARAMETERS)
    begun = np.empty(starts.shape[0])
    for axis in range(PARAMETERS):
        high[axis] = grid.shape[axis] - 1.0
    for row in range(places.shape[0]):
        ends = _ratios(places[row], size, near, ratios, trial[0])
        for start in range(starts.shape[0]):
            _sums(grid, near, ratios, ends, e, weight, starts[start, row], weights, lines, sums)
            begun[start] = sums[3, 3]
        for _ in range(min(TRIED, starts.shape[0])):
            lowest = np.argmin(begun)
            begun[lowest] = np.inf
            at = starts[lowest, row].copy()
            _sums(grid, near, ratios, ends, e, weight, at, weights, lines, sums)
            damping = DAMPED
            for _ in range(STEPS):
                _step(at, high, sums, damping, factor, new)
                _sums(grid, near, ratios, ends, e, weight, new, weights, lines, trial)
                gain = sums[3, 3] - trial[3, 3]
                damping *= 0.2 if gain > 0.0 else 8.0
                if gain > 0.0:
                    at, new, sums, trial = new, at, trial, sums
                    if gain < SHORTEST * (1.0 + sums[3, 3]):
                        break
                elif damping > OVERDAMPED:
                    break
            if sums[3, 3] < chi_square[row]:
                chi_square[row] = sums[3, 3]
                for axis in range(PARAMETERS):
                    found[row, axis] = at[axis]
