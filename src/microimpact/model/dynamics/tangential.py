"""Tangential compliance: sticking and slip of an elastic contact along the surface.

Two laws. ``mindlin`` is the contact of Cattaneo, Mindlin and Deresiewicz, with an annulus of
partial slip, whose impact Maw, Barber and Fawcett solved (Wear 38, 1976). It is computed by the
method of dimensionality reduction (Popov and Hess 2015), which is exact for it: a row of
independent springs at distances y < a from the middle. Each has the stiffness ``4 G*`` per length,
holds at most its share ``3/4 (1 - y^2/a^2)/a`` of friction times the force that supports it, and
lets go where it leaves the contact. ``spring`` is the law of discrete element codes, in LAMMPS
``mindlin_rescale/force``: one spring, ``dF = -8 G* a dx``, under Coulomb's limit, whose force
shrinks with the contact radius. Neither law makes energy.

In the scaled form of `dynamics.kernel`, where ``s`` is the contact radius, ``k = 8 G*/K`` is the
only new number. Slip may turn round but keeps to its line: in three dimensions, too, it is planar.

The normal path is followed once more, in steps that end where a spring enters or leaves the
contact; the error is of second order in the length of the springs, about 1e-5 of friction's limit.
The compiled functions are in a module of their own for the reason given in `kernel`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from microimpact.core.compiled import jit
from microimpact.model.dynamics import kernel
from microimpact.model.dynamics.normal import NormalImpact, scaled_problems
from microimpact.model.rigid_body.algebra import SLIP_PER_IMPULSE

if TYPE_CHECKING:
    from microimpact.core.arrays import BoolArray, FloatArray, Real
    from microimpact.core.materials import Material
    from microimpact.model.contact import Contact

# Parts into which contact radius and velocity are divided, each.
PARTS = 64
# Stable and exact enough for the method of Runge and Kutta: step times rate of damping.
DAMPED = 0.5
MAX_STEPS = 1_000_000
# Longest step in time, in units of the tangential oscillator's.
_STROKE = 0.2
_MAX_SPRINGS = 64 * PARTS

# Columns of a problem, in the scaled units of the normal motion: its start and groups, the
# tangential stiffness k, friction, slip (positive), whether friction rests on the Hertz term alone
# in place of the whole compressive force, and whether the contact is one spring.
(
    START_U,
    ADHESION,
    HERTZ_DAMPING,
    DAMPING_1,
    DAMPING_2,
    TURNING_S,
    STIFFNESS,
    FRICTION,
    START_SLIP,
    ON_HERTZ,
    ONE_SPRING,
) = range(11)
PROBLEM_COLUMNS = 11

# Columns of a result: impulse of the tangential force per mass, positive against the slip; whether
# the contact stuck, in part, for some time; whether the steps sufficed.
IMPULSE, STUCK, ENDED = range(3)
RESULT_COLUMNS = 3

_jit = jit()


def contact_shear_modulus(particle: Material, surface: Material) -> Real:
    """Effective shear modulus G* of a contact, Pa: ``1/G* = sum of 2 (1 + nu)(2 - nu)/E``."""
    compliance = [
        2.0 * (1.0 + np.asarray(m.poissons_ratio)) * (2.0 - m.poissons_ratio) / m.youngs_modulus
        for m in (particle, surface)
    ]
    return 1.0 / (compliance[0] + compliance[1])


def compliant_impulse(
    contact: Contact, normal: NormalImpact, slip: FloatArray, speed: Real, law: str, basis: str
) -> tuple[FloatArray, BoolArray]:
    """Impulse of the tangential force per mass, m/s, and whether the contact stuck for some time.

    Parameters
    ----------
    normal
        The normal impacts; what is said of captured ones means nothing.
    slip
        Magnitude of the slip before impact, m/s.
    speed
        Normal speed of approach, m/s.
    law
        ``"mindlin"`` or ``"spring"``.
    basis
        Normal force in Coulomb's law: ``"compressive"`` or ``"hertz"``.

    Raises
    ------
    RuntimeError
        If the rebound is so heavily damped that the steps do not suffice.
    """
    shape = np.broadcast_shapes(contact.shape, np.shape(slip), np.shape(speed))

    def flat(value: object) -> FloatArray:
        return np.broadcast_to(np.asarray(value, dtype=np.float64), shape).ravel()

    scaled, scales, _ = scaled_problems(contact, np.broadcast_to(speed, shape))
    problems = np.empty((slip.size, PROBLEM_COLUMNS))
    for own, column in {
        START_U: kernel.START_U,
        ADHESION: kernel.ADHESION,
        HERTZ_DAMPING: kernel.HERTZ_DAMPING,
        DAMPING_1: kernel.DAMPING_1,
        DAMPING_2: kernel.DAMPING_2,
    }.items():
        problems[:, own] = scaled[:, column]
    problems[:, TURNING_S] = np.sqrt(flat(normal.maximum_compression) / scales.length)
    shear = contact_shear_modulus(contact.particle, contact.surface)
    problems[:, STIFFNESS] = flat(8.0 * shear / contact.stiffness)
    problems[:, FRICTION] = flat(contact.friction)
    problems[:, START_SLIP] = flat(slip) / scales.velocity
    problems[:, ON_HERTZ], problems[:, ONE_SPRING] = basis == "hertz", law == "spring"
    results = np.zeros((len(problems), RESULT_COLUMNS))
    free = ~flat(normal.captured).astype(bool)
    part = np.zeros((int(free.sum()), RESULT_COLUMNS))
    integrate(problems[free], part)
    if not np.all(part[:, ENDED]):
        heaviest = np.max((problems[:, HERTZ_DAMPING] * problems[:, START_U])[free])
        raise RuntimeError(
            f"the tangential force of {np.sum(part[:, ENDED] == 0.0)} impact(s) was not found: "
            f"c_H v is {heaviest:.3g} at most, too much damping for tangential {law!r}"
        )
    results[free] = part
    impulse = (results[:, IMPULSE] * scales.velocity).reshape(shape)
    return impulse, (results[:, STUCK] > 0.0).reshape(shape)


@_jit
def _normal(s, u, own):  # type: ignore[no-untyped-def]
    """Normal force over the contact radius, and the rate at which it damps the velocity."""
    p = s * s
    drag = p * own[HERTZ_DAMPING] + own[ADHESION] * own[DAMPING_1]
    return p - own[ADHESION] + drag * u, p * drag


@_jit
def _advance(s, u, h, own):  # type: ignore[no-untyped-def]
    """Contact radius, velocity and contact time after h, by Runge and Kutta's method."""
    parts = max(math.ceil(h * _normal(s, u, own)[1] / DAMPED), 1)
    time, h = 0.0, h / parts
    for _ in range(parts):
        force = _normal(s, u, own)[0]
        s_1, u_1 = s + 0.25 * h * u, u - 0.5 * h * s * s * force
        f_1 = _normal(s_1, u_1, own)[0]
        s_2, u_2 = s + 0.25 * h * u_1, u - 0.5 * h * s_1 * s_1 * f_1
        f_2 = _normal(s_2, u_2, own)[0]
        s_3, u_3 = s + 0.5 * h * u_2, u - h * s_2 * s_2 * f_2
        f_3 = _normal(s_3, u_3, own)[0]
        kick = s * s * force + 2.0 * (s_1 * s_1 * f_1 + s_2 * s_2 * f_2) + s_3 * s_3 * f_3
        time += h / 6.0 * (s + 2.0 * (s_1 + s_2) + s_3)
        s, u = s + h / 12.0 * (u + 2.0 * (u_1 + u_2) + u_3), u - h / 6.0 * kick
    return s, u, time, parts


@_jit
def _grow(own, edge):  # type: ignore[no-untyped-def]
    """Follow the approach; each step's contact radius, velocity and time into a row of ``edge``.

    The first row is the touch. Returns the number of rows, or 0 where they did not suffice.
    """
    fastest = math.sqrt(own[START_U] ** 2 + 8.0 / 15.0 * own[ADHESION] ** 2.5)
    wide, kick = own[TURNING_S] / PARTS, fastest / PARTS
    s, u = 0.0, own[START_U]
    edge[0, 0], edge[0, 1], edge[0, 2] = s, u, 0.0
    for row in range(1, edge.shape[0]):
        force, rate = _normal(s, u, own)
        h = min(2.0 * wide / u, kick / (s * s * abs(force)), DAMPED / rate)
        new_s, new_u, time, _ = _advance(s, u, h, own)
        if new_u <= 0.0:
            for _ in range(4):  # of Newton's steps
                h += new_u / (new_s * new_s * _normal(new_s, new_u, own)[0])
                new_s, new_u, time, _ = _advance(s, u, h, own)
            new_u = 0.0
        edge[row, 0], edge[row, 1], edge[row, 2] = new_s, new_u, time
        if new_u == 0.0:
            return row + 1
        s, u = new_s, new_u
    return 0


@_jit
def _fall(s, u, target, own):  # type: ignore[no-untyped-def]
    """Velocity and contact time when the contact has shrunk to a radius, and steps used.

    Where it does not get there, as capture is near, the velocity is not negative.
    """
    rate = s * s * _normal(s, u, own)[0]
    way = s - target
    root = math.sqrt(max(0.25 * u * u + rate * way, 0.0))
    h, parts = 2.0 * way / (root - 0.5 * u), 0
    new_u, time = u, 0.0
    for _ in range(4):  # of Newton's steps
        new_s, new_u, time, used = _advance(s, u, h, own)
        parts += used
        if not new_u < 0.0 or parts > MAX_STEPS or abs(new_s - target) <= 1e-9 * way:
            break
        h = max(h + 2.0 * (target - new_s) / new_u, 0.0)
    return new_u, time, parts


@_jit
def _drive(s, u, before, time, entering, count, own, springs, state):  # type: ignore[no-untyped-def]
    """Move the contact point for a step that ends at s, u with so many springs in contact.

    Rows of ``springs``: squared distance, length, displacement. ``state``: force, impulse, stuck.
    """
    impulse = state[1] + 0.5 * state[0] * time
    way = (own[START_SLIP] - SLIP_PER_IMPULSE * impulse) * time
    support = max(_normal(s, u, own)[0], 0.0)
    if own[ON_HERTZ] != 0.0:
        support = s * s
    limit = own[FRICTION] * support / own[STIFFNESS]
    force, stuck = 0.0, False
    if own[ONE_SPRING] != 0.0:
        x = springs[2, 0] + way
        if entering:  # what joins the contact is not strained yet
            x = (springs[2, 0] * before + 0.5 * (before + s) * way) / s
        springs[2, 0] = min(max(x, -limit), limit)
        force, stuck = s * springs[2, 0], abs(x) < limit
    elif count > 0:
        density = 1.5 * limit / (s * s)
        for i in range(count):
            most = density * max(s * s - springs[0, i], 0.0)
            x = springs[2, i] + (0.5 * way if entering and i == count - 1 else way)
            springs[2, i] = min(max(x, -most), most)
            force += springs[1, i] * springs[2, i]
        stuck = abs(springs[2, 0]) < density * (s * s - springs[0, 0])
    state[0] = own[STIFFNESS] * force
    state[1] = impulse + 0.5 * state[0] * time
    if stuck:
        state[2] = 1.0


@_jit
def integrate(problems: FloatArray, results: FloatArray) -> None:
    """Integrate every row of ``problems``, all rebounds, into the same row of ``results``."""
    edge, springs, state = np.zeros((_MAX_SPRINGS, 3)), np.zeros((3, _MAX_SPRINGS)), np.zeros(3)
    for row in range(problems.shape[0]):
        own = problems[row].copy()
        results[row, :] = 0.0
        rows = _grow(own, edge)
        if rows == 0:
            continue
        state[:] = 0.0
        springs[2, 0] = 0.0
        for i in range(1, rows):
            inner, outer = edge[i - 1, 0], edge[i, 0]
            springs[0, i - 1] = (inner * inner + inner * outer + outer * outer) / 3.0
            springs[1, i - 1], springs[2, i - 1] = outer - inner, 0.0
            _drive(outer, edge[i, 1], inner, edge[i, 2], True, i, own, springs, state)
        own[DAMPING_1] = own[DAMPING_2]
        s, u, parts, ended = edge[rows - 1, 0], 0.0, 0, True
        for i in range(rows - 2, -1, -1):
            target = edge[i, 0]
            if target == s:
                continue
            new_u, time, used = _fall(s, u, target, own)
            strokes = math.ceil(time * math.sqrt(SLIP_PER_IMPULSE * own[STIFFNESS] * s) / _STROKE)
            parts += used + strokes
            if not new_u < 0.0 or not parts <= MAX_STEPS:
                # capture was near, and adhesion holds what is left; or there was no path
                ended = own[ADHESION] > 0.0 and new_u >= 0.0
                break
            for stroke in range(1, strokes + 1):
                done = stroke / strokes
                between, count = s + (target - s) * done, i if stroke == strokes else i + 1
                swift = u + (new_u - u) * done
                _drive(between, swift, s, time / strokes, False, count, own, springs, state)
            s, u = target, new_u
        results[row, IMPULSE], results[row, STUCK] = state[1], state[2]
        results[row, ENDED] = 1.0 if ended else 0.0
