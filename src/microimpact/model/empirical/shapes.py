"""Restitution by the laws of contact as tables over v/v_c, and their search with v_c held.

In units of its capture velocity a law of contact has one to three parameters left, whatever the
materials. Each is tabulated at places evenly spaced in the logarithms of the parameters, in the
rate exponent n, and in the square root of ln(v/v_c), in which e is smooth through capture. Between
them e is that of the cubic through the four nearest places of each axis.

The tables stand in ``shapes.npz``, so that a first fit compiles no integration;
``python -m microimpact.model.empirical.shapes`` computes them anew.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from microimpact.core.arrays import FloatArray, Real
from microimpact.core.materials import Material
from microimpact.model.contact import Contact
from microimpact.model.contact_laws import (
    EDGE_SPEEDS,
    JKR,
    Hysteresis,
    MaugisBarquins,
    ThorntonNing,
)
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.empirical.data import DataSets, Places
from microimpact.model.empirical.kernel import DAMPING_AXIS, PARAMETERS, curves
from microimpact.model.empirical.search import NEARLY, Box, Minima, lowest, misfits

FILE = Path(__file__).with_suffix(".npz")

# Places over v/v_c, up to a ratio of 10,000, and over each parameter of a law with two, or one; a
# law that begins to yield has a kink.
RATIOS, LARGEST_RATIO, TWO, ONE, KINKED = 56, 1e4, 28, 48, 100
# One place stands for a parameter that a law has not.
NONE = (1.0, 1.0, 1)
# Exponent of v_c in 1/d beyond which small spheres do not leave at all.
STEEPEST = 3.0
# Exponent in d of the speed that the materials and d make.
SPEED_BY_SIZE = -5.0 / 6.0
# Starts that a search is made from: the lowest. With v_c held nearly all lead to one minimum, and
# where neighbours in v_c found another, a profile begins there next time.
TRIED = 3
# No step is longer than this share of an axis; a search ends where one lowers chi-square by less
# than the next.
LONGEST, SHORTEST = 0.3, 1e-6

# Materials and size set units alone.
_BODY = Material(name="any", youngs_modulus=1e11, poissons_ratio=0.25, density=2500.0)
WORK = 0.1
_ANY = Contact(particle=_BODY, surface=_BODY, diameter=20e-6, work_of_adhesion=WORK)
_SPEED = float(np.asarray(_ANY.velocity_scale))
Axis = tuple[float, float, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class Law:
    """A family of e(v/v_c).

    Attributes
    ----------
    axes
        First and last value and number of places of two parameters.
    contact
        Contact (m, 1) of two parameters (m, 1) and of the exponent n; None: e is the first
        parameter times sqrt(1 - (v_c/v)^2).
    exponent_of_size
        Exponent in d of the first parameter in units of the contact, of given materials, by n: E*,
        w_A and density alone make a speed ~ d^(-5/6), a time ~ d^(7/6), a pressure ~ d^(-1/3).
    growth
        The same of the second parameter; that of a damping by rate follows from the exponents.
    exponents
        The same of n, by which the adhesion damping falls with speed, and which is given at v_c; or
        of the edge.
    starts
        Where searches begin, as shares of the axes of n and the two parameters.
    """

    axes: tuple[Axis, Axis]
    contact: Callable[[Real, Real, Real], Contact] | None
    exponent_of_size: Callable[[FloatArray], FloatArray | float] = lambda _: 0.0
    growth: float = 0.0
    exponents: Axis = (0.0, 0.0, 1)
    starts: tuple[tuple[float, ...], ...] = ((0.0, 0.2, 0.0), (0.0, 0.5, 0.0), (0.0, 0.8, 0.0))

    @property
    def values(self) -> tuple[FloatArray, ...]:
        """Values of n and of the two parameters."""
        return np.linspace(*self.exponents), *(np.geomspace(*axis) for axis in self.axes)

    @property
    def free(self) -> int:
        """Number of parameters, without v_c."""
        return sum(axis.size > 1 for axis in self.values)


# C_A from which on nothing leaves.
_OVERDAMPED = 1.15


def _ring(hertz: Real, adhesion: Real, _: Real) -> Contact:
    """Contact of C_H and of C_A at v_c, the latter over its distance from overdamping."""
    group = _OVERDAMPED * adhesion / (1.0 + adhesion)
    return _ANY.replace(hertz_damping=hertz / _SPEED, adhesion_damping=group / _SPEED)


# A viscous time from which on hardly anything leaves, s.
_OVERVISCOUS = 2e-8
EDGE = "edge JKR"


def _edge(strength: Real, bulk: Real, exponent: Real) -> Contact:
    """Contact of v_c ~ ``strength`` where that is large, and of a viscous time like `_ring`."""
    speed = _SPEED * np.asarray(strength) ** (-(1.2 - 0.6 * exponent) / exponent)
    time = _OVERVISCOUS * np.asarray(bulk) / (1.0 + np.asarray(bulk))
    speed = np.clip(speed, *EDGE_SPEEDS)
    law = MaugisBarquins(edge_speed=speed, edge_exponent=exponent, viscous_time=time)
    return _ANY.replace(law=law)


LAWS = {
    "ring force": Law(
        axes=((1e-5, 0.4, TWO), DAMPING_AXIS),
        contact=_ring,
        exponent_of_size=lambda _: SPEED_BY_SIZE,
        exponents=(0.0, 2.0, 9),
        starts=tuple(
            (n, *shares)
            for n in (0.25, 0.75)
            for shares in ((0.8, 0.8), (0.5, 0.5), (0.6, 0.05), (0.05, 0.7))
        ),
    ),
    "viscous JKR": Law(
        axes=((1e-11, 2e-8, ONE), NONE),
        contact=lambda time, *_: _ANY.replace(law=JKR(viscous_time=time)),
        exponent_of_size=lambda _: -7.0 / 6.0,
    ),
    "Thornton-Ning": Law(
        axes=((5e7, 2e10, KINKED), NONE),
        contact=lambda pressure, *_: _ANY.replace(law=ThorntonNing(yield_pressure=pressure)),
        exponent_of_size=lambda _: 1.0 / 3.0,
    ),
    "hysteresis": Law(
        axes=((0.1, 1e3, ONE), NONE),
        contact=lambda work, *_: _ANY.replace(law=Hysteresis(unloading_work=work)),
    ),
    "fixed loss": Law(axes=((0.01, 1.0, ONE), NONE), contact=None),
    # The speed c of the edge has a unit ~ d^(-1/2), which is a power of the strength.
    EDGE: Law(
        axes=((0.03, 30.0, 20), DAMPING_AXIS),
        contact=_edge,
        exponent_of_size=lambda m: -0.5 * m / (1.2 - 0.6 * m),
        growth=-7.0 / 6.0,
        exponents=(0.25, 1.25, 11),
        starts=tuple(
            (n, *shares)
            for n in (0.2, 0.7)
            for shares in ((0.8, 0.3), (0.5, 0.5), (0.3, 0.7), (0.8, 0.7))
        ),
    ),
}


def contact(
    name: str, first: FloatArray, second: FloatArray, exponent: FloatArray | float = 0.0
) -> Contact:
    """Contact of the tables by two parameters of a law other than a fixed loss, and its exponent.

    Parameters
    ----------
    name
        One of ``LAWS``.
    first, second, exponent
        Its two parameters, in the units of the tables, and n; the rate of a ring force is apart.

    Raises
    ------
    ValueError
        If it is a fixed loss.
    """
    law = LAWS[name].contact
    if law is None:
        raise ValueError(f"{name} is no law of contact")
    return law(first, second, exponent)


@cache
def table(name: str) -> FloatArray:
    """Table of e of a law, (rate exponents, first parameter, second, v/v_c).

    The last ``BY_SIZE`` columns are those of the average over diameters.
    """
    with np.load(FILE) as tables:
        return np.asarray(tables[name], float)


def main() -> None:
    """Compute all tables, and write them in single precision."""
    tables = {
        name: np.concatenate([restitutions(name), by_size(name)], axis=-1, dtype=np.float32)
        for name in LAWS
    }
    np.savez_compressed(FILE, **tables)  # type: ignore[arg-type]


def restitutions(name: str) -> FloatArray:
    """Table of e by integration, (rate exponents, first parameter, second, v/v_c)."""
    law = LAWS[name]
    rates, firsts, seconds = law.values
    ratio = np.exp(np.linspace(0.0, np.sqrt(np.log(LARGEST_RATIO)), RATIOS) ** 2)
    if law.contact is None:
        return (firsts[:, None] * np.sqrt(1.0 - ratio**-2))[None, :, None]
    first, second = (axis.reshape(-1, 1) for axis in np.meshgrid(firsts, seconds, indexing="ij"))
    e = np.zeros((rates.size, first.size, ratio.size))
    for n, rate in enumerate(rates):
        limit = capture_velocity(law.contact(first, second, rate))
        leaves = np.isfinite(limit).ravel()
        contact = law.contact(first[leaves], second[leaves], rate)
        if contact.law is None:
            contact = contact.replace(adhesion_rate_exponent=rate, reference_velocity=limit[leaves])
        faster = normal_impact(contact, limit[leaves] * ratio[1:])
        e[n, leaves, 1:] = faster.coefficient_of_restitution
        # Beyond the last contact that anything leaves, all are like it.
        e[n] = e[n, np.maximum.accumulate(np.where(leaves, np.arange(leaves.size), 0))]
    return np.asarray(e.reshape(rates.size, firsts.size, seconds.size, -1))


def exponents(name: str) -> FloatArray:
    """Exponents of v_c in 1/d of a law (rate exponents, first parameter, second)."""
    law = LAWS[name]
    rates, firsts, seconds = law.values
    shape = (rates.size, firsts.size, seconds.size)
    if law.contact is None:
        return np.full(shape, -SPEED_BY_SIZE)
    first, second = (axis.reshape(-1, 1) for axis in np.meshgrid(firsts, seconds, indexing="ij"))
    step, exponent = 1.01, np.zeros((rates.size, first.size))
    for n, rate in enumerate(rates):
        contact = law.contact(first, second, rate)
        changes = [{}, {"diameter": step * _ANY.diameter}]
        if contact.law is None:
            changes.append({"adhesion_damping": step * contact.adhesion_damping})
        limits = [np.ravel(capture_velocity(contact.replace(**change))) for change in changes]
        with np.errstate(invalid="ignore", divide="ignore"):
            by_size, *by_damping = (
                np.log(limit / limits[0]) / np.log(step) for limit in limits[1:]
            )
            # Of a smaller sphere, whose v_c is higher, damping at v_c is less.
            slowed = 1.0 + rate * by_damping[0] if by_damping else 1.0
            exponent[n] = np.minimum(-by_size / slowed, STEEPEST)
        leaves = np.isfinite(limits).all(axis=0)
        kept = np.maximum.accumulate(np.where(leaves, np.arange(leaves.size), 0))
        exponent[n] = exponent[n, kept]
    return exponent.reshape(shape)


def by_size(name: str) -> FloatArray:
    """Columns ``BY_SIZE`` of the average over diameters (rate exponents, first, second, 3)."""
    law = LAWS[name]
    low, high, count = law.axes[0]
    exponent = exponents(name)
    rates = law.values[0][:, None, None]
    shift = law.exponent_of_size(rates) * (count - 1) / np.log(high / low) if count > 1 else 0.0
    # The adhesion damping falls with v_c^n, and its unit with the speed of the contact.
    growth = SPEED_BY_SIZE + rates * exponent if law.contact is _ring else law.growth
    columns = (np.broadcast_to(x, exponent.shape) for x in (exponent, shift, growth))
    return np.stack([*columns], axis=-1)


def places(ratio: FloatArray) -> FloatArray:
    """Positions of speeds in units of v_c along a table's last axis; negative if captured."""
    logs = np.log(np.minimum(ratio, LARGEST_RATIO))
    positions = np.sqrt(np.maximum(logs, 0.0) / np.log(LARGEST_RATIO)) * (RATIOS - 1)
    return np.where(ratio > 1.0, positions, -1.0)


def restitution(name: str, at: FloatArray, ratio: FloatArray) -> FloatArray:
    """Coefficients of restitution (n,) of a law by its table.

    Parameters
    ----------
    name
        One of ``LAWS``.
    at
        Positions along the axes of its parameters, (3 or more,).
    ratio
        v/v_c, (n,).
    """
    return curve(name, at[None], places(ratio)[None])[0, :, PARAMETERS]


def curve(name: str, at: FloatArray, position: FloatArray) -> FloatArray:
    """Slopes of e along three axes, and e, of a law by its table (m, n, 4).

    Parameters
    ----------
    name
        One of ``LAWS``.
    at
        Positions along the axes of its parameters, (m, 3 or more).
    position
        Those along the axis of v/v_c, as of `places`, (m, n).
    """
    rows = np.empty((*position.shape, PARAMETERS + 1))
    curves(table(name), position, np.ascontiguousarray(at), rows)
    return rows


def profile(
    name: str, sets: DataSets, owner: Places, v_c: FloatArray, starts: FloatArray
) -> Minima:
    """Search for a law's parameters with v_c held.

    Parameters
    ----------
    name
        One of `LAWS`.
    sets, owner
        The data, and the data set of each search (m,).
    v_c
        Capture velocities held (m,), in units of the slowest rebounds.
    starts
        Places (s, m, 3) to start from; empty: from those of the law.
    """
    at = places(sets.v[owner] / v_c[:, None])
    e, weight = sets.e[owner], sets.weight[owner]
    last = np.array(table(name).shape[:PARAMETERS]) - 1.0

    def objective(x: FloatArray, rows: Places) -> tuple[FloatArray, FloatArray, FloatArray]:
        weighted = curve(name, x, at[rows]) * weight[rows, :, None]
        missed = weighted[..., PARAMETERS] - (weight * e)[rows]
        return misfits(missed, weighted[..., :PARAMETERS], sets, owner[rows])

    begun = starts
    if not len(starts):
        begun = np.repeat((np.array(LAWS[name].starts) * last)[:, None], v_c.size, axis=1)
    high = np.tile(last, (v_c.size, 1))
    box, small = Box(0.0 * high, high, LONGEST * last), NEARLY if sets.tails else 0.0
    return lowest(objective, begun, box, SHORTEST, small, TRIED)


if __name__ == "__main__":
    main()
