"""Path of one impact by a law of `microimpact.model.contact_laws` against time.

Every law is three legs, in the scaled form of `dynamics.force_laws`: the contact grows until the
sphere turns; its radius stays while adhesion grows; it shrinks until it breaks, or the sphere turns
again. Where the work of separation goes with the speed of the edge, the last two are one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from microimpact.core.arrays import FloatArray
from microimpact.model.dynamics.force_laws import Loading, Problem, Unloading

# Of one leg at most, scaled: an overdamped sphere creeps for ever.
LONGEST = 50.0
ERRORS: dict[str, Any] = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-13}
NEWTON, TINY = 20, 1e-9  # of the search for an instant: steps, and the least slope
# Share of the first radius at which a contact has parted: of times it neglects its power 3/2.
PARTED = 1e-6

# Values s, v, time, compression and compressive impulse, and what else a leg has.
Values = tuple[float, ...]
Rates = Callable[[FloatArray], FloatArray]
Forces = Callable[[FloatArray], tuple[FloatArray, FloatArray, FloatArray]]


class Path(NamedTuple):
    """Motion and forces of a scaled impact, every field (points,)."""

    time: FloatArray
    compression: FloatArray
    velocity: FloatArray  # Positive: approaching
    hertz: FloatArray  # Force without the pull of adhesion
    adhesion: FloatArray
    damping: FloatArray
    impulse: FloatArray  # Of the compressive force, so far


class Leg(NamedTuple):
    """Part of a path: how long it takes, its path at times from its beginning on, and its end."""

    duration: float
    at: Callable[[FloatArray], Path]
    turned: bool


def path(problem: Problem, points: int) -> Path:
    """Return the path of one scaled impact at evenly spaced times, to the break or the second turn.

    Parameters
    ----------
    problem
        The impact, fields (1,).
    points
        Number of times.
    """
    legs = list(_legs(problem))
    ends = np.cumsum([leg.duration for leg in legs])
    time = np.linspace(0.0, ends[-1], points)
    number = np.minimum(np.searchsorted(ends, time), len(legs) - 1)
    parts = [
        leg.at(np.clip(time[number == k] - (end - leg.duration), 0.0, leg.duration))
        for k, (leg, end) in enumerate(zip(legs, ends, strict=True))
    ]
    columns = [np.concatenate(column) for column in zip(*parts, strict=True)]
    return Path(time, *columns[1:])


def _legs(problem: Problem) -> Iterator[Leg]:
    b, opening, drag = (float(x[0]) for x in (problem.closing, problem.opening, problem.drag))
    loading = Loading.of(problem.closing, problem.pressure)

    def closes(s: FloatArray) -> FloatArray:
        return np.asarray(loading.force(s) + 6.0 * b * s**3)

    start = float(loading.closed[0]), float(problem.speed[0]), 0.0, 0.0, 0.0
    leg, (top, _, _, depth, impulse) = _moving(start, closes, b, 1.0, drag, -np.inf)
    yield leg
    if not leg.turned:  # it creeps
        return
    if problem.peels[0]:
        edge, exponent = float(problem.edge_speed[0]), float(problem.edge_exponent[0])
        yield _peeling((top**2, 0.0, 0.0, depth, impulse), b, drag, edge, exponent)
        return
    unloading = Unloading.of(loading, problem.opening, np.array([top]))
    flattening, force = float(unloading.flattening[0]), float(unloading.first_force[0])
    hertz, pace = force + 6.0 * b * top**3, np.sqrt(1.5) * top
    last = top**3 * (top**3 / flattening - 6.0 * opening)
    held = float(np.arccos(np.clip(last / force, -1.0, 1.0))) / pace

    def stays(time: FloatArray) -> Path:
        phase = pace * time
        return Path(
            time,
            depth - force / pace**2 * (1.0 - np.cos(phase)),
            -force / pace * np.sin(phase),
            np.full(time.shape, hertz),
            force * np.cos(phase) - hertz,
            np.zeros(time.shape),
            impulse + force / pace * np.sin(np.minimum(phase, 0.5 * np.pi)),
        )

    if held > 0.0:
        yield Leg(held, stays, last < -force)
    if last >= -force:  # else it turns at this radius
        after = [float(x[0]) for x in stays(np.array([held]))]
        start = top, after[2], 0.0, after[1], after[6]
        end = float(unloading.end[0])
        yield _moving(start, lambda s: s**6 / flattening, opening, flattening, drag, end)[0]


def _moving(
    start: tuple[float, ...],
    hertz: Callable[[FloatArray], FloatArray],
    b: float,
    flattening: float,
    drag: float,
    end: float,
) -> tuple[Leg, list[float]]:
    """Follow s, v, time, compression and compressive impulse until v turns or s falls to an end.

    Parameters
    ----------
    start
        Their values at first.
    hertz
        Force at s without the pull of adhesion.
    b, flattening, drag
        Strength of adhesion, radius of curvature over R, viscous loss.
    end
        Value of s.

    Returns
    -------
    leg, last
        The leg, and the last values.
    """

    def forces(y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        s = y[0]
        return hertz(s), -6.0 * b * s**3, drag * s**2 * y[1]

    def rates(y: FloatArray) -> FloatArray:
        s, v = y[:2]
        force, time = np.sum(forces(y), axis=0), 4.0 * (s**3 / flattening - b)
        return np.stack([v, -time * force, time, time * v, time * np.maximum(force, 0.0)])

    return _followed(start, rates, forces, end, ERRORS)


def _peeling(start: Values, b: float, drag: float, edge: float, exponent: float) -> Leg:
    """Follow a contact whose edge opens by its speed, as `dynamics.peeling` does.

    Parameters
    ----------
    start
        Contact radius, and the other values, at the turning point.
    b, drag, edge, exponent
        Strength of adhesion, viscous loss, speed c and exponent of the edge.
    """
    unit = 1.0 / np.sqrt(1.5 * start[0])

    def forces(y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        a, v, z = y[0], y[1], y[5]
        return a**3, -6.0 * b * a**1.5 * (1.0 + z), drag * a * v

    def rates(y: FloatArray) -> FloatArray:
        a, v, z = y[0], y[1], np.maximum(y[5], 0.0)
        force, stretch = np.sum(forces(y), axis=0), 4.0 * b * np.sqrt(a) * (1.0 + z)
        speed = edge * (z * (2.0 + z)) ** (1.0 / exponent)
        time = 1.0 / (1.0 + unit * speed / a)
        loosening = (1.0 + z) * (speed / (2.0 * a) - (v + 2.0 * a * speed) / stretch)
        columns = -speed, -force, np.ones_like(a), v, np.maximum(force, 0.0), loosening
        return np.stack([time * column for column in columns])

    return _followed((*start, 0.0), rates, forces, PARTED * start[0], ERRORS | {"method": "LSODA"})[
        0
    ]


def _followed(
    start: Values, rates: Rates, forces: Forces, end: float, errors: dict[str, Any]
) -> tuple[Leg, list[float]]:
    """Follow values until the speed turns or the first one falls to an end.

    Parameters
    ----------
    start
        Values at first.
    rates
        Their derivatives, of values (n each).
    forces
        Force without the pull of adhesion, this pull, and the viscous force.
    end
        Of the first value.
    errors
        Of the integration.

    Returns
    -------
    leg, last
        The leg, and the last values.
    """
    from scipy.integrate import solve_ivp  # slow to import

    def turns(_: float, y: FloatArray) -> float:
        return float(y[1])

    def breaks(_: float, y: FloatArray) -> float:
        return float(y[0] - end)

    def creeps(_: float, y: FloatArray) -> float:
        return float(y[2] - LONGEST)

    turns.direction = -1.0 if start[1] > 0.0 else 1.0  # type: ignore[attr-defined]
    breaks.direction = -1.0  # type: ignore[attr-defined]
    for event in (turns, breaks, creeps):
        event.terminal = True  # type: ignore[attr-defined]
    solved: Any = solve_ivp(
        lambda _, y: rates(y[:, None])[:, 0],
        (0.0, np.inf),
        start,
        events=(turns, breaks, creeps),
        dense_output=True,
        **errors,
    )
    if not solved.success:
        raise RuntimeError(f"the path of an impact was not found: {solved.message}")

    def at(time: FloatArray) -> Path:
        tau = np.interp(time, solved.y[2], solved.t)
        for _ in range(NEWTON):
            y = solved.sol(tau)
            slope = np.maximum(rates(y)[2], TINY)
            tau = np.clip(tau - (y[2] - time) / slope, 0.0, solved.t[-1])
        y = solved.sol(tau)
        return Path(time, y[3], y[1], *forces(y), y[4])

    return Leg(float(solved.y[2, -1]), at, solved.t_events[0].size > 0), solved.y[:, -1].tolist()
