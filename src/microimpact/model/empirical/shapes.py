"""Restitution by the laws of contact as tables over v/v_c, and their search with v_c held.

In units of its capture velocity a law of contact has one or two parameters left, whatever the
materials. Each is tabulated once a process, at places evenly spaced in the logarithms of the
parameters and in the square root of ln(v/v_c), in which e is smooth through capture. Between
them e is that of the cubic through the four nearest places of each axis.
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
# A search begins with this damping of its steps and ends at the next, at a step that lowers
# chi-square by less than this share, or after so many steps; none is longer than this share.
DAMPED, OVERDAMPED, SHORTEST, STEPS, LONGEST = 1e-2, 1e6, 1e-6, 60, 0.3

# Contacts (m, 1) of two parameters (m, 1). Materials and size set units alone.
_BODY = Material(name="any", youngs_modulus=1e11, poissons_ratio=0.25, density=2500.0)
_ANY = Contact(particle=_BODY, surface=_BODY, diameter=20e-6, work_of_adhesion=0.1)
_SPEED = float(np.asarray(_ANY.velocity_scale))
Axis = tuple[float, float, int]

_jit = jit()


@dataclass(frozen=True, slots=True, kw_only=True)
class Law:
    """A family of e(v/v_c).

    Attributes
    ----------
    axes
        First and last value and number of places of two parameters.
    contact
        Contact of two parameters; None: e is the first parameter times sqrt(1 - (v_c/v)^2).
    exponent
        n of the adhesion damping's rate, which is given at v_c.
    starts
        Where searches begin, as shares of the axes.
    """

    axes: tuple[Axis, Axis]
    contact: Callable[[Real, Real], Contact] | None
    exponent: float = 0.0
    starts: tuple[tuple[float, float], ...] = ((0.2, 0.0), (0.5, 0.0), (0.8, 0.0))

    @property
    def free(self) -> int:
        """Number of parameters, without v_c."""
        return sum(axis != NONE for axis in self.axes)


# C_A from which on nothing leaves.
_OVERDAMPED = 1.15


def _ring(hertz: Real, adhesion: Real) -> Contact:
    """Contact of C_H and of C_A at v_c, the latter over what it lacks to overdamping."""
    group = _OVERDAMPED * adhesion / (1.0 + adhesion)
    return _ANY.replace(hertz_damping=hertz / _SPEED, adhesion_damping=group / _SPEED)


_GROUPS = ((1e-5, 0.4, TWO), (1e-3, 30.0, TWO))
_MOST = ((0.8, 0.8), (0.5, 0.5), (0.6, 0.05), (0.05, 0.7))
LAWS = {
    f"ring force, n = {n}": Law(axes=_GROUPS, contact=_ring, exponent=n, starts=_MOST)
    for n in range(3)
} | {
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
    """Return e at all places of a law, (first parameter, second, v/v_c)."""
    law = LAWS[name]
    one, two = (np.geomspace(*axis) for axis in law.axes)
    ratio = np.exp(np.linspace(0.0, np.sqrt(np.log(LARGEST_RATIO)), RATIOS) ** 2)
    if law.contact is None:
        kept = one[:, None] * np.sqrt(1.0 - ratio**-2)
        return np.repeat(kept[:, None], two.size, axis=1)
    first, second = (of.reshape(-1, 1) for of in np.meshgrid(one, two, indexing="ij"))
    limit = capture_velocity(law.contact(first, second))
    leaves = np.isfinite(limit).ravel()
    contact = law.contact(first[leaves], second[leaves])
    if law.exponent:
        contact = contact.replace(
            adhesion_rate_exponent=law.exponent, reference_velocity=limit[leaves]
        )
    e = np.zeros((leaves.size, ratio.size))
    faster = normal_impact(contact, limit[leaves] * ratio[1:])
    e[leaves, 1:] = faster.coefficient_of_restitution
    # Beyond the last contact that anything leaves, all are like it.
    kept = np.maximum.accumulate(np.where(leaves, np.arange(leaves.size), 0))
    return np.ascontiguousarray(e[kept].reshape(one.size, two.size, -1))


def places(ratio: FloatArray) -> FloatArray:
    """Return where speeds in units of v_c are in a table; below 0 where captured."""
    logs = np.log(np.minimum(ratio, LARGEST_RATIO))
    found = np.sqrt(np.maximum(logs, 0.0) / np.log(LARGEST_RATIO)) * (RATIOS - 1)
    return np.where(ratio > 1.0, found, -1.0)


def restitution(name: str, at: FloatArray, ratio: FloatArray) -> FloatArray:
    """Return e (n,) of a law at the places of its parameters (2,), by its table."""
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
        Places (m, 2) to start from; none: from those of the law.
    """
    grid = table(name)
    if not starts:
        ends = np.array(grid.shape[:2]) - 1.0
        starts = tuple(
            np.tile(share * ends, (v_c.size, 1)) for share in np.array(LAWS[name].starts)
        )
    chi_square, at = np.full(v_c.size, np.inf), np.zeros((v_c.size, 2))
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
def _ratios(places, size, first, weights, unused) -> None:  # type: ignore[no-untyped-def]
    """Put the first of the four places about every speed, and their weights (n, 4)."""
    for n in range(places.size):
        first[n] = -1
        if places[n] >= 0.0:
            first[n] = _cubic(places[n], size, weights[n], unused)


@_jit
def _point(grid, i, j, k, one, two, three):  # type: ignore[no-untyped-def]
    """Return e and its slopes; ``one`` and ``two`` are weights (2, 4) of values and slopes."""
    e = along = across = 0.0
    for p in range(4):
        value = slope = 0.0
        if grid.shape[1] == 1:
            row = grid[i + p, 0]
            value = three[0] * row[k] + three[1] * row[k + 1]
            value += three[2] * row[k + 2] + three[3] * row[k + 3]
        else:
            for q in range(4):
                row = grid[i + p, j + q]
                here = three[0] * row[k] + three[1] * row[k + 1]
                here += three[2] * row[k + 2] + three[3] * row[k + 3]
                value += two[0, q] * here
                slope += two[1, q] * here
        e += one[0, p] * value
        along += one[1, p] * value
        across += one[0, p] * slope
    return e, along, across


@_jit
def _curve(grid, places, at, e) -> None:  # type: ignore[no-untyped-def]
    one, two, unused = np.empty((2, 4)), np.empty((2, 4)), np.empty(4)
    first, weights = np.empty(places.size, np.int64), np.empty((places.size, 4))
    i = _cubic(at[0], grid.shape[0], one[0], one[1])
    j = _cubic(at[1], grid.shape[1], two[0], two[1])
    _ratios(places, grid.shape[2], first, weights, unused)
    for n in range(places.size):
        e[n] = 0.0
        if first[n] >= 0:
            e[n] = _point(grid, i, j, first[n], one, two, weights[n])[0]


@_jit
def _sums(grid, first, weights, e, weight, at, work, sums) -> None:  # type: ignore[no-untyped-def]
    """Sums of squares and products of misfit and slopes: chi-square, gradient, normal matrix."""
    one, two = work[0], work[1]
    i = _cubic(at[0], grid.shape[0], one[0], one[1])
    j = _cubic(at[1], grid.shape[1], two[0], two[1])
    sums[:] = 0.0
    for n in range(first.size):
        model = along = across = 0.0
        if first[n] >= 0:
            model, along, across = _point(grid, i, j, first[n], one, two, weights[n])
        miss, along, across = weight[n] * (model - e[n]), weight[n] * along, weight[n] * across
        sums[0] += miss * miss
        sums[1] += along * miss
        sums[2] += across * miss
        sums[3] += along * along
        sums[4] += across * across
        sums[5] += along * across


@_jit
def _step(at, high, sums, damping, new) -> None:  # type: ignore[no-untyped-def]
    """Put the place to which a damped step leads into ``new``."""
    # A parameter at its bound that wants beyond it is held there.
    first = at[0] > 0.0 if sums[1] > 0.0 else at[0] < high[0]
    second = at[1] > 0.0 if sums[2] > 0.0 else at[1] < high[1]
    a, b = sums[3] * (1.0 + damping) + 1e-300, sums[4] * (1.0 + damping) + 1e-300
    c = sums[5] if first and second else 0.0
    d = a * b - c * c
    new[0] = (c * sums[2] - b * sums[1]) / d if first else 0.0
    new[1] = (c * sums[1] - a * sums[2]) / d if second else 0.0
    for axis in range(2):
        step = min(max(new[axis], -LONGEST * high[axis]), LONGEST * high[axis])
        new[axis] = min(max(at[axis] + step, 0.0), high[axis])


@_jit
def _search(grid, places, e, weight, starts, chi_square, found) -> None:  # type: ignore[no-untyped-def]
    """Search from all starts (s, m, 2) of each row of places (m, n); the lowest counts."""
    work, sums, trial = np.empty((2, 2, 4)), np.empty(6), np.empty(6)
    first, weights = np.empty(e.size, np.int64), np.empty((e.size, 4))
    at, new, high = np.empty(2), np.empty(2), np.empty(2)
    for axis in range(2):
        high[axis] = grid.shape[axis] - 1.0
    for row in range(places.shape[0]):
        _ratios(places[row], grid.shape[2], first, weights, trial)
        for start in range(starts.shape[0]):
            at[:] = starts[start, row]
            _sums(grid, first, weights, e, weight, at, work, sums)
            damping = DAMPED
            for _ in range(STEPS):
                _step(at, high, sums, damping, new)
                _sums(grid, first, weights, e, weight, new, work, trial)
                gain = sums[0] - trial[0]
                damping *= 0.2 if gain > 0.0 else 8.0
                if gain > 0.0:
                    at[:], sums[:] = new, trial
                    if gain < SHORTEST * (1.0 + sums[0]):
                        break
                elif damping > OVERDAMPED:
                    break
            if sums[0] < chi_square[row]:
                chi_square[row] = sums[0]
                found[row] = at
