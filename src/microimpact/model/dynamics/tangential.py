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

The normal path is followed once more, in steps that end where a spring enters the contact. In each
step the springs obey the trapezoidal rule, and their limits change evenly: what the slip loses is
stored, or lost to friction, however long the step is. The error is of second order in the steps,
about 1e-4 of the slip. The compiled functions are in a module of their own for the reason given in
`kernel`.
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
PARTS = 96
# Stable and exact enough for the method of Runge and Kutta: step times rate of damping.
DAMPED = 0.5
MAX_STEPS = 1_000_000
# Longest step in time, in units of the tangential oscillator's.
_STROKE = 0.2
_MAX_ROWS = 64 * PARTS
# Scaled speeds and squared radii below this are none.
_NOTHING = 1e-30

# Columns of a problem, in the scaled units of the normal motion: its start, groups and speed at the
# end; squared frequency of the tangential oscillator over the contact radius (7/2 k of a sphere);
# friction over k, slip (positive), whether friction rests on the Hertz term alone in place of the
# whole compressive force, and whether the contact is one spring.
(
    START_U,
    ADHESION,
    HERTZ_DAMPING,
    DAMPING_1,
    DAMPING_2,
    END_U,
    TURNING_S,
    OSCILLATOR,
    FRICTION,
    START_SLIP,
    ON_HERTZ,
    ONE_SPRING,
) = range(12)
PROBLEM_COLUMNS = 12

# Columns of a result: slip after the impact; whether the contact stuck, in part, for some time;
# whether the steps sufficed.
SLIP, STUCK, ENDED = range(3)
RESULT_COLUMNS = 3

# Columns of a path, at the end of each step: contact radius, velocity and normal force over the
# contact radius; and the time that the step takes.
RADIUS, VELOCITY, FORCE, TIME = range(4)
# Rows of springs: squared distance from the middle, length, displacement and limit now (negative
# where nothing presses), and the last two after the next step.
PLACE, LENGTH, STRAIN, LIMIT, NEXT, NEXT_LIMIT = range(6)

_jit = jit()


def contact_shear_modulus(particle: Material, surface: Material) -> Real:
    """Effective shear modulus G* of a contact, Pa: ``1/G* = sum of 2 (1 + nu)(2 - nu)/E``."""
    compliance = [
        2.0 * (1.0 + np.asarray(m.poissons_ratio)) * (2.0 - m.poissons_ratio) / m.youngs_modulus
        for m in (particle, surface)
    ]
    return 1.0 / (compliance[0] + compliance[1])


def compliant_impulse(
    contact: Contact, normal: NormalImpact, slip: Real, speed: Real, law: str, basis: str
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
    shear = contact_shear_modulus(contact.particle, contact.surface)
    stiffness = flat(8.0 * shear / contact.stiffness)
    end = flat(normal.coefficient_of_restitution) * scaled[:, kernel.START_U]
    problems = np.empty((math.prod(shape), PROBLEM_COLUMNS))
    columns: dict[int, FloatArray | bool] = {
        START_U: scaled[:, kernel.START_U],
        ADHESION: scaled[:, kernel.ADHESION],
        HERTZ_DAMPING: scaled[:, kernel.HERTZ_DAMPING],
        DAMPING_1: scaled[:, kernel.DAMPING_1],
        DAMPING_2: scaled[:, kernel.DAMPING_2],
        END_U: np.maximum(end, _NOTHING),
        TURNING_S: np.sqrt(flat(normal.maximum_compression) / scales.length),
        OSCILLATOR: SLIP_PER_IMPULSE * stiffness,
        FRICTION: flat(contact.friction) / stiffness,
        START_SLIP: flat(slip) / scales.velocity,
        ON_HERTZ: basis == "hertz",
        ONE_SPRING: law == "spring",
    }
    for column, values in columns.items():
        problems[:, column] = values
    free = ~flat(normal.captured).astype(bool)
    results = np.zeros((int(free.sum()), RESULT_COLUMNS))
    integrate(problems[free], results)
    if not np.all(results[:, ENDED]):
        heaviest = np.max((problems[:, HERTZ_DAMPING] * problems[:, START_U])[free])
        raise RuntimeError(
            f"the tangential force of {np.sum(results[:, ENDED] == 0.0)} impact(s) was not found: "
            f"c_H v is {heaviest:.3g} at most, too much damping for tangential {law!r}"
        )
    lost, stuck = np.zeros(len(problems)), np.zeros(len(problems), dtype=bool)
    lost[free] = problems[free, START_SLIP] - results[:, SLIP]
    stuck[free] = results[:, STUCK] > 0.0
    impulse = lost * scales.velocity / SLIP_PER_IMPULSE
    return impulse.reshape(shape), stuck.reshape(shape)


# A leg of the motion is a tuple: strength of adhesion, groups of Hertz and adhesion damping, and by
# how much a step may change s and u. Numba's cache could not load a class that was renamed since.


@_jit
def _normal(s, u, motion):  # type: ignore[no-untyped-def]
    """Normal force over the contact radius, and the rate at which it damps the velocity."""
    adhesion, hertz_damping, adhesion_damping, _, _ = motion
    p = s * s
    drag = p * hertz_damping + adhesion * adhesion_damping
    return p - adhesion + drag * u, p * drag


@_jit
def _advance(s, u, h, motion):  # type: ignore[no-untyped-def]
    """Contact radius, velocity and contact time after h, by Runge and Kutta's method; its steps."""
    rate = abs(_normal(s, u, motion)[1])
    parts = max(math.ceil(min(h * rate / DAMPED, MAX_STEPS + 1.0)), 1)
    time, h = 0.0, h / parts
    for _ in range(parts):
        force = _normal(s, u, motion)[0]
        s_1, u_1 = s + 0.25 * h * u, u - 0.5 * h * s * s * force
        f_1 = _normal(s_1, u_1, motion)[0]
        s_2, u_2 = s + 0.25 * h * u_1, u - 0.5 * h * s_1 * s_1 * f_1
        f_2 = _normal(s_2, u_2, motion)[0]
        s_3, u_3 = s + 0.5 * h * u_2, u - h * s_2 * s_2 * f_2
        f_3 = _normal(s_3, u_3, motion)[0]
        kick = s * s * force + 2.0 * (s_1 * s_1 * f_1 + s_2 * s_2 * f_2) + s_3 * s_3 * f_3
        time += h / 6.0 * (s + 2.0 * (s_1 + s_2) + s_3)
        s, u = s + h / 12.0 * (u + 2.0 * (u_1 + u_2) + u_3), u - h / 6.0 * kick
    return s, u, time, parts


@_jit
def _stride(s, u, motion):  # type: ignore[no-untyped-def]
    """Length of a step; where adhesion draws the sphere in, u may not double within it."""
    adhesion, _, _, wide, kick = motion
    force, rate = _normal(s, u, motion)
    h, steepest = 2.0 * wide / abs(u), s * s * abs(force)
    if u > 0.0:  # a turning point is found from close by
        h = min(h, DAMPED / abs(rate))
    if u > 0.0 and force < 0.0:
        kick = min(kick, u)
        h = min(h, (4.0 * kick / (adhesion * u * u)) ** (1.0 / 3.0))
        ahead = s + 0.5 * h * u
        steepest = max(steepest, ahead * ahead * abs(_normal(ahead, u, motion)[0]))
    return min(h, kick / steepest)


@_jit
def _follow(row, s, u, last, motion, path):  # type: ignore[no-untyped-def]
    """Follow the motion into rows from ``row`` on, until it turns or arrives at a contact radius.

    An approach takes its last step beyond that radius, a rebound (u <= 0) ends there. Returns the
    last row, or -1 if the steps do not suffice.
    """
    parts, rising = 0, u > 0.0
    path[row, RADIUS], path[row, VELOCITY], path[row, FORCE] = s, u, _normal(s, u, motion)[0]
    while row + 1 < path.shape[0] and parts <= MAX_STEPS:
        h = _stride(s, u, motion)
        new_s, new_u, time, used = _advance(s, u, h, motion)
        parts += used
        if new_u <= 0.0 if rising else new_s <= last:
            for _ in range(4):  # of Newton's steps
                if rising:
                    h += new_u / (new_s * new_s * _normal(new_s, new_u, motion)[0])
                else:
                    h += 2.0 * (last - new_s) / new_u
                new_s, new_u, time, _ = _advance(s, u, h, motion)
            new_s, new_u = (new_s, 0.0) if rising else (last, new_u)
        row, s, u = row + 1, new_s, new_u
        path[row, RADIUS], path[row, VELOCITY], path[row, TIME] = s, u, time
        path[row, FORCE] = _normal(s, u, motion)[0]
        if (u <= 0.0 or s >= last) if rising else s <= last:
            return row
    return -1


@_jit
def _trace(problem, path, end):  # type: ignore[no-untyped-def]
    """Write the path of a rebound; returns the rows of its turning point and its end, or -1.

    Where adhesion is stronger than the Hertz force, the end is followed back from the speed after
    impact: forwards, what is left of a slow sphere's would be lost to rounding.
    """
    beta, start = problem[ADHESION], problem[START_U]
    hertz, first, second = problem[HERTZ_DAMPING], problem[DAMPING_1], problem[DAMPING_2]
    wide = problem[TURNING_S] / PARTS
    kick = math.sqrt(start**2 + 8.0 / 15.0 * beta**2.5) / PARTS
    turn = _follow(0, 0.0, start, math.inf, (beta, hertz, first, wide, kick), path)
    rows, last = 0, 0.0
    if beta > 0.0:
        back = beta, -hertz, -second, wide, kick
        rows = _follow(0, 0.0, problem[END_U], math.sqrt(0.5 * beta), back, end)
        last = end[rows, RADIUS]
    if turn < 0 or rows < 0:
        return -1, -1
    motion = beta, hertz, second, wide, kick
    row = _follow(turn, path[turn, RADIUS], 0.0, last, motion, path)
    if row < 0 or row + rows >= path.shape[0]:
        return -1, -1
    for i in range(rows, 0, -1):
        row += 1
        path[row, TIME] = end[i, TIME]
        path[row, RADIUS], path[row, FORCE] = end[i - 1, RADIUS], end[i - 1, FORCE]
    return turn, row


@_jit
def _displace(strain, limit, way, next_limit):  # type: ignore[no-untyped-def]
    """Displacement of a spring whose end goes evenly along a way, as its limit does to the next.

    With it the mean displacement, and by how much that rises with the way. A limit below zero is
    that of a spring which nothing presses.
    """
    share = 1.0
    if limit < 0.0:  # it is pressed during the last part of the time alone
        share = next_limit / (next_limit - limit) if next_limit > 0.0 else 0.0
        limit, way = 0.0, share * way
    end = strain + way
    if abs(end) <= next_limit:
        return end, 0.5 * share * (strain + end), 0.5 * share * share
    if strain * end > 0.0 and abs(strain) >= limit and next_limit >= 0.0:  # slides as before
        end = math.copysign(next_limit, end)
        return end, 0.5 * share * (strain + end), 0.0
    pressed = limit / (limit - next_limit) if next_limit < 0.0 else 1.0
    end, bound = strain + pressed * way, max(next_limit, 0.0)
    side = 1.0 if end > 0.0 else -1.0
    room, excess = limit - side * strain, side * end - bound
    stuck = pressed * room / (room + excess) if room > 0.0 else 0.0
    edge, end = strain + stuck * way, side * bound
    mean = 0.5 * share * (stuck * (strain + edge) + (pressed - stuck) * (edge + end))
    return end, mean, 0.5 * share * share * stuck * stuck


@_jit
def _drive(slip, time, count, joins, oscillator, held, springs):  # type: ignore[no-untyped-def]
    """Slip after a step with `count` springs in contact, and the length of springs that held.

    The last spring ``joins`` the contact during the step, half of which it takes part in.
    """
    # Gives the trapezoidal rule the period of the oscillator; ``held`` is of the step before.
    time *= 1.0 + oscillator * held * time * time / 12.0
    weight, free = 0.5 * oscillator * time * time, time * slip
    way, slope, least, greatest = free, 0.0, -math.inf, math.inf
    for _ in range(100):  # of Newton's steps, within a bracket; two as a rule
        force, slope = 0.0, 0.0
        for i in range(count):
            share = 0.5 if joins and i == count - 1 else 1.0
            springs[NEXT, i], mean, rise = _displace(
                springs[STRAIN, i], springs[LIMIT, i], share * way, springs[NEXT_LIMIT, i]
            )
            force += springs[LENGTH, i] * mean
            slope += springs[LENGTH, i] * share * rise
        off = way + weight * force - free
        if abs(off) <= 1e-14 * (abs(free) + abs(weight * force)):
            break
        if off < 0.0:
            least = way
        else:
            greatest = way
        way -= off / (1.0 + weight * slope)
        if not least < way < greatest:
            way = 0.5 * (least + greatest)
    for i in range(count):
        springs[STRAIN, i], springs[LIMIT, i] = springs[NEXT, i], springs[NEXT_LIMIT, i]
    return 2.0 * way / time - slip, 2.0 * slope


@_jit
def _press_one(before, s, limit, springs):  # type: ignore[no-untyped-def]
    """Give the one spring its stiffness and its limit at the end of a step."""
    middle = 0.5 * (before + s)
    if middle > springs[LENGTH, 0]:  # what joins the contact is not strained yet
        springs[STRAIN, 0] *= springs[LENGTH, 0] / middle
        springs[LIMIT, 0] *= springs[LENGTH, 0] / middle
    springs[LENGTH, 0] = middle
    springs[NEXT_LIMIT, 0] = limit * max(s / middle, 1.0)


@_jit
def _press_row(s, limit, count, springs):  # type: ignore[no-untyped-def]
    """Give springs their limits at the end of a step."""
    highest, fall = 1.5 * limit, 1.5 * limit / max(s * s, _NOTHING)
    for i in range(count):
        bound = highest - fall * springs[PLACE, i]
        springs[NEXT_LIMIT, i] = bound if limit > 0.0 else -abs(bound)


@_jit
def _slip(problem, path, turn, last, springs):  # type: ignore[no-untyped-def]
    """Slip at the end of a path, and whether the contact stuck."""
    single, oscillator = problem[ONE_SPRING] != 0.0, problem[OSCILLATOR]
    slip, held, stuck, count = problem[START_SLIP], 0.0, 0.0, 1
    springs[:, 0] = 0.0
    for row in range(1, last + 1):
        joins = row <= turn
        start, end, time = path[row - 1, RADIUS], path[row, RADIUS], path[row, TIME]
        first, change = path[row - 1, FORCE], path[row, FORCE] - path[row - 1, FORCE]
        if joins and not single:
            count = row
            springs[PLACE, row - 1] = (start * start + start * end + end * end) / 3.0
            springs[LENGTH, row - 1] = end - start
            springs[STRAIN, row - 1] = springs[LIMIT, row - 1] = 0.0
        while count > 0 and not joins and springs[PLACE, count - 1] >= start * start:
            count -= 1
        strokes = 1 if joins else math.ceil(time * math.sqrt(oscillator * start) / _STROKE)
        before = start
        for stroke in range(1, strokes + 1):
            done = stroke / strokes
            s, force = start + (end - start) * done, first + change * done
            limit = problem[FRICTION] * (s * s if problem[ON_HERTZ] != 0.0 else force)
            if single:
                _press_one(before, s, limit, springs)
            else:
                _press_row(s, limit, count, springs)
            slip, held = _drive(
                slip, time / strokes, count, joins and not single, oscillator, held, springs
            )
            if abs(springs[STRAIN, 0]) < springs[LIMIT, 0]:
                stuck = 1.0
            before = s
    return slip, stuck


@_jit
def integrate(problems: FloatArray, results: FloatArray) -> None:
    """Integrate every row of ``problems``, all rebounds, into the same row of ``results``."""
    path, end = np.zeros((_MAX_ROWS, 4)), np.zeros((_MAX_ROWS, 4))
    springs = np.zeros((6, _MAX_ROWS))
    for row in range(problems.shape[0]):
        turn, last = _trace(problems[row], path, end)
        results[row, SLIP], results[row, STUCK] = _slip(problems[row], path, turn, last, springs)
        results[row, ENDED] = 1.0 if last > 0 else 0.0
