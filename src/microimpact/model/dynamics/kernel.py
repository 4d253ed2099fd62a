"""Compiled integration of the normal motion, Eq. (25), in its regular form.

With the compression ``x`` in units of a length scale, ``s = sqrt(x)`` (the contact radius),
``u = dx/dt`` and ``dt = s dtau``, the equation of motion is polynomial and smooth through s = 0::

    ds/dtau = u/2,    du/dtau = b s^2 - s^4 - (b C_A s^2 + C_H s^4) u

``b`` is the strength of adhesion (1 in the adhesion scale, 0 without adhesion) and ``C_A``, ``C_H``
the damping groups. A *leg* runs at constant ``C_A``: the first ends at the turning point u = 0, the
second where contact ends, s = 0. Time reversal is the same problem with the signs of
the damping groups changed, so one integrator serves impacts and the backward map.

Each step is a Taylor expansion of order ``ORDER``. ``LANES`` impacts advance side by side, each
with its own step; a finished lane takes the next impact. An impact's numbers do not depend on its
neighbours. The loops over lanes compile to SIMD code with sums kept in registers because the loops
within them have lengths known to the compiler, and because arrays that are not ``LANES`` wide are
refused, which makes the distance of rows known as well.

All compiled functions are in this one module: Numba's on-disk cache looks only at the file of the
function it loads and would keep stale callees from another one. Loops are bounded ``for`` loops on
purpose: every integration ends, with a status.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from microimpact.core.compiled import jit

if TYPE_CHECKING:
    from microimpact.core.arrays import FloatArray

ORDER = 20
LANES = 32
TOLERANCE = 1e-14
MAX_STEPS = 2_000_000

# The expansion, of even order, is done in three parts, each with sums of one length; the rows of
# zeros in front of every series take up the difference.
THIRD = 2 * -(-ORDER // 6)
PAD = THIRD - 1

# Depth of the well, relative to the energy of approach, in which a rebound may stop short of s = 0.
NOTHING_LEFT = 1e-30

# Newton's last correction, relative: the error that it leaves is about its square. Where the force
# changes its sign u has an extremum, whose value takes no more than the square of that error.
ROOT_TOLERANCE, BALANCE_TOLERANCE = 1e-9, 1e-6

# Columns of a problem: start of the first leg, strength of adhesion, damping groups of both legs.
# An impact with ALWAYS_CAPTURED (no speed rebounds) is followed to the turning point only.
START_S, START_U, ADHESION, HERTZ_DAMPING, DAMPING_1, DAMPING_2, ALWAYS_CAPTURED = range(7)
PROBLEM_COLUMNS = 7

# Columns of a result. Impulses and works are per unit mass, in the scaled units of the problem.
(
    STATUS,
    END_U,
    END_S,
    DURATION,
    TURNING_TIME,
    TURNING_S,
    COMPRESSIVE_IMPULSE,
    LOWEST_U,
    HERTZ_IMPULSE,
    ADHESION_IMPULSE,
    HERTZ_WORK,
    ADHESION_WORK,
    STEPS,
) = range(13)
RESULT_COLUMNS = 13
OUTCOMES = 7

REBOUND, CAPTURED, ESCAPED, FAILED = 0.0, 1.0, 2.0, 3.0

# What is computed besides the path. PLAIN: contact time and compressive impulse. LEDGER: impulse
# and work of each term too. SHALLOW: as LEDGER, for speeds so small against the depth of the
# adhesive well that the energy must be taken from the works, not from a small difference.
PLAIN, LEDGER, SHALLOW = 0, 1, 2

_INVERSE = 1.0 / np.arange(1.0, ORDER + 2.0)

# Bytes of a cache line.
_LINE = 64

# A float's bits, read as an integer, are nearly its logarithm to base 2, in units of 2^-52 and from
# this origin on. The largest error, 0.0861, is laid so that steps never come out too long.
_BITS_OF_ONE = (1023.0 - 0.0861) * 2.0**52

_NODES, _WEIGHTS = (a.copy() for a in np.polynomial.legendre.leggauss(10))
_NODES = 0.5 * (_NODES + 1.0)
_WEIGHTS = 0.5 * _WEIGHTS

_jit = jit()
_jit_inline = jit(inline="always")
_jit_contract = jit(fastmath={"contract", "nsz"})


@_jit_inline
def _coefficients(first, stop, beta, damping_h, damping_a, s, u, p, m):  # type: ignore[no-untyped-def]
    """Coefficients ``first`` to ``stop`` of p and m and the next ones of s and u, every lane.

    Two at a time: both sums take the same numbers from memory, which is what the time goes into.
    Every sum has as many terms as the longest, a number known to the compiler; the rows of zeros
    in front of each series make the surplus vanish. Squares are summed from the middle outwards.
    """
    for k in range(first, stop, 2):
        row, middle = PAD + k, PAD + k // 2
        inverse, second = 1.0 / (k + 1), 1.0 / (k + 2)
        for lane in range(LANES):
            s[row + 1, lane] = 0.5 * inverse * u[row, lane]
        for lane in range(LANES):
            even = odd = 0.0
            for j in range(stop // 2 - 1):
                even += s[middle - 1 - j, lane] * s[middle + 1 + j, lane]
            for j in range(stop // 2):
                odd += s[middle - j, lane] * s[middle + 1 + j, lane]
            p[row, lane] = 2.0 * even + s[middle, lane] * s[middle, lane]
            p[row + 1, lane] = 2.0 * odd
        for lane in range(LANES):
            even = odd = 0.0
            for j in range(stop // 2 - 1):
                even += p[middle - 1 - j, lane] * p[middle + 1 + j, lane]
            for j in range(stop // 2):
                odd += p[middle - j, lane] * p[middle + 1 + j, lane]
            even, odd = 2.0 * even + p[middle, lane] * p[middle, lane], 2.0 * odd
            pull, next_pull = beta[lane] * p[row, lane], beta[lane] * p[row + 1, lane]
            m[k, lane] = damping_a[lane] * pull + damping_h[lane] * even
            m[k + 1, lane] = damping_a[lane] * next_pull + damping_h[lane] * odd
            u[row + 1, lane] = pull - even
            u[row + 2, lane] = next_pull - odd
        for lane in range(LANES):
            even = odd = 0.0
            for j in range(stop):
                even += m[j, lane] * u[row - j, lane]
                odd += m[j + 1, lane] * u[row - j, lane]
            even = inverse * (u[row + 1, lane] - even)
            u[row + 1, lane] = even
            s[row + 2, lane] = 0.5 * second * even
            u[row + 2, lane] = second * (u[row + 2, lane] - odd - m[0, lane] * even)


@_jit
def _rows(number):  # type: ignore[no-untyped-def]
    """Rows of zeros, aligned to cache lines."""
    size = number * LANES
    buffer = np.zeros(size + _LINE // 8)
    start = (-buffer.ctypes.data % _LINE) // 8
    return buffer[start : start + size].reshape((number, LANES))


@_jit_contract
def _expand(beta, damping_h, damping_a, s, u, p, m):  # type: ignore[no-untyped-def]
    """Taylor coefficients of s and u from their values in row PAD (p = s^2, m = damping)."""
    if not (s.shape[1] == u.shape[1] == p.shape[1] == m.shape[1] == LANES):
        return  # never: gives the compiler the distance of rows
    _coefficients(0, THIRD, beta, damping_h, damping_a, s, u, p, m)
    _coefficients(THIRD, 2 * THIRD, beta, damping_h, damping_a, s, u, p, m)
    _coefficients(2 * THIRD, ORDER, beta, damping_h, damping_a, s, u, p, m)


@_jit_contract
def _evaluate(c, h, out):  # type: ignore[no-untyped-def]
    """Value of each lane's series at its step ``h``."""
    if c.shape[1] != LANES:
        return
    for lane in range(LANES):
        value = c[ORDER, lane]
        for k in range(ORDER):
            value = value * h[lane] + c[ORDER - 1 - k, lane]
        out[lane] = value


@_jit_contract
def _contact_times(s, h, out):  # type: ignore[no-untyped-def]
    """Contact time, the integral of s, of each lane's step ``h``."""
    if s.shape[1] != LANES:
        return
    for lane in range(LANES):
        value = s[ORDER, lane] * _INVERSE[ORDER]
        for k in range(ORDER):
            value = value * h[lane] + s[ORDER - 1 - k, lane] * _INVERSE[ORDER - 1 - k]
        out[lane] = value * h[lane]


@_jit_contract
def _step_sizes(s, u, last, before, h):  # type: ignore[no-untyped-def]
    """Step of each lane at which the last two terms of both series fall to the tolerance.

    The roots that this takes are rounded downwards by up to 6 %, for a step need not be exact:
    numbers' bits serve as their logarithms.
    """
    lanes = h.size
    for lane in range(lanes):
        scale = 1.0 / (TOLERANCE * max(abs(s[0, lane]), abs(u[0, lane])))
        last[lane] = scale * max(abs(s[ORDER, lane]), abs(u[ORDER, lane]))
        before[lane] = scale * max(abs(s[ORDER - 1, lane]), abs(u[ORDER - 1, lane]))
    last_bits, before_bits, bits = last.view(np.int64), before.view(np.int64), h.view(np.int64)
    for lane in range(lanes):
        log_step = min(
            (_BITS_OF_ONE - last_bits[lane]) * (1.0 / ORDER),
            (_BITS_OF_ONE - before_bits[lane]) * (1.0 / (ORDER - 1)),
        )
        bits[lane] = int(_BITS_OF_ONE + log_step)


@_jit
def _value(c, lane, h):  # type: ignore[no-untyped-def]
    """Value of one lane's series at ``h``; even and odd powers are summed side by side."""
    even, odd, square = c[ORDER, lane], 0.0, h * h
    for k in range(ORDER - 2, -1, -2):
        even = even * square + c[k, lane]
        odd = odd * square + c[k + 1, lane]
    return even + h * odd


@_jit
def _contact_time(s, lane, h):  # type: ignore[no-untyped-def]
    """Integral of one lane's s from 0 to ``h``."""
    even, odd, square = s[ORDER, lane] * _INVERSE[ORDER], 0.0, h * h
    for k in range(ORDER - 2, -1, -2):
        even = even * square + _INVERSE[k] * s[k, lane]
        odd = odd * square + _INVERSE[k + 1] * s[k + 1, lane]
    return (even + h * odd) * h


@_jit
def _guess(start, slope, end, upper):  # type: ignore[no-untyped-def]
    """Zero in (0, upper] of the parabola of these values at both ends, and slope at the first."""
    bend = (end - start - slope * upper) / (upper * upper)
    root = math.sqrt(max(slope * slope - 4.0 * bend * start, 0.0))
    x = 2.0 * start / (math.copysign(root, start) - slope)
    return x if 0.0 < x < upper else upper


@_jit
def _root(c, lane, upper, end):  # type: ignore[no-untyped-def]
    """Zero in (0, upper] of one lane's series, ``end`` at ``upper``: Newton within a bracket."""
    lower, x = 0.0, _guess(c[0, lane], c[1, lane], end, upper)
    sign = c[0, lane] if c[0, lane] != 0.0 else c[1, lane]
    for _ in range(80):
        even, odd, even_slope, odd_slope, square = c[ORDER, lane], 0.0, 0.0, 0.0, x * x
        for k in range(ORDER - 2, -1, -2):
            even_slope = even_slope * square + even
            odd_slope = odd_slope * square + odd
            even = even * square + c[k, lane]
            odd = odd * square + c[k + 1, lane]
        value, slope = even + x * odd, odd + 2.0 * x * (even_slope + x * odd_slope)
        if value * sign > 0.0:
            lower = x
        else:
            upper = x
        new = x - value / slope
        # Asked before the bracket, whose ends rounding may lay beyond the root.
        if abs(new - x) <= ROOT_TOLERANCE * abs(new):
            return new
        x = new if lower < new < upper else 0.5 * (lower + upper)
    return x


@_jit
def _well_energy(s, beta):  # type: ignore[no-untyped-def]
    """Potential energy of Hertz and ring force; it vanishes at s = 0."""
    return s * s * s * (0.4 * s * s - 2.0 / 3.0 * beta)


@_jit
def _pull(s, u, beta, damping_h, damping_a):  # type: ignore[no-untyped-def]
    """Return du/dtau over s^2, positive where the force attracts, and its own derivative."""
    p, hertz = s * s, 1.0 + damping_h * u
    pull = beta * (1.0 - damping_a * u) - p * hertz
    return pull, -(beta * damping_a + p * damping_h) * p * pull - s * u * hertz


@_jit
def _balance(s, u, lane, upper, end, beta, damping_h, damping_a):  # type: ignore[no-untyped-def]
    """Instant in (0, upper] at which the pull of a lane takes the sign of ``end``.

    Not a zero of du/dtau, which vanishes wherever s does, too.
    """
    start, slope = _pull(s[0, lane], u[0, lane], beta, damping_h, damping_a)
    lower, x = 0.0, _guess(start, slope, end, upper)
    for _ in range(80):
        at_s, at_u = _value(s, lane, x), _value(u, lane, x)
        pull, slope = _pull(at_s, at_u, beta, damping_h, damping_a)
        if (pull > 0.0) != (end > 0.0):
            lower = x
        else:
            upper = x
        new = x - pull / slope
        if abs(new - x) <= BALANCE_TOLERANCE * abs(new):
            return new
        x = new if lower < new < upper else 0.5 * (lower + upper)
    return x


@_jit_contract
def _quadratures(s, u, h, beta, damping_h, damping_a, row_s, row_u, x, total):  # type: ignore[no-untyped-def]
    """Add each term's impulse and work over the step, by Gauss-Legendre on the series."""
    lanes = beta.size
    for node in range(_NODES.size):
        for lane in range(lanes):
            x[lane] = _NODES[node] * h[lane]
        _evaluate(s, x, row_s)
        _evaluate(u, x, row_u)
        for lane in range(lanes):
            weight = _WEIGHTS[node] * h[lane]
            p = row_s[lane] * row_s[lane]
            kinetic = row_u[lane] * row_u[lane]
            total[HERTZ_IMPULSE, lane] += weight * p * p
            total[ADHESION_IMPULSE, lane] += weight * beta[lane] * p
            total[HERTZ_WORK, lane] += weight * damping_h[lane] * p * p * kinetic
            total[ADHESION_WORK, lane] += weight * beta[lane] * damping_a[lane] * p * kinetic


@_jit
def _never_turns(s, u, damping_h, damping_a):  # type: ignore[no-untyped-def]
    """True where the time-reversed path (negative damping) can no longer come to rest."""
    if 1.0 + damping_h * u <= 0.0:
        return True
    return damping_a < 0.0 and -damping_a * u > 2.0 * s * s and s > 2.0 + 4.0 / damping_a**2


@_jit
def _rests(s, u, beta):  # type: ignore[no-untyped-def]
    """True at equilibrium, to ten digits; steps are then still shorter than the last swing."""
    return abs(s * s - beta) <= 1e-10 * beta and abs(u) <= 1e-10 * beta**1.25


@_jit
def _settles(s, u, beta, damping_h, damping_a):  # type: ignore[no-untyped-def]
    """True where an overdamped approach creeps to equilibrium and never turns.

    In the adhesive scale the creep follows ``u = (1 - x)/D``, ``D = C_A + C_H x``. Where
    ``s D^3 > 4 (D + C_H)`` no path leaves the strip between rest and twice that speed.
    """
    unit = beta**1.25
    hertz, speed, x = damping_h * unit, u / unit, s * s / beta
    drag = damping_a * unit + hertz * x
    if _rests(s, u, beta):
        return True
    creeps = x < 1.0 and speed * drag < 2.0 * (1.0 - x)
    return creeps and math.sqrt(x) * drag**3 > 4.0 * (drag + hertz)


@_jit
def integrate(problems: FloatArray, mode: int, results: FloatArray) -> None:
    """Integrate every row of ``problems`` into the same row of ``results``.

    Parameters
    ----------
    problems
        Scaled impacts, (n, columns).
    mode
        ``PLAIN``, ``LEDGER`` or ``SHALLOW``.
    results
        Room for the results, (n, ``RESULT_COLUMNS``).
    """
    count = problems.shape[0]
    rows = PAD + ORDER + 1
    padded_s, padded_u, p, m = _rows(rows), _rows(rows), _rows(rows), _rows(rows)
    s, u = padded_s[PAD:], padded_u[PAD:]
    total = np.zeros((RESULT_COLUMNS, LANES))
    beta, damping_h, damping_a = np.zeros(LANES), np.zeros(LANES), np.zeros(LANES)
    h, new_s, new_u, row = np.zeros(LANES), np.zeros(LANES), np.zeros(LANES), np.zeros(LANES)
    mark, energy = np.zeros(LANES), np.zeros(LANES)
    pulling = np.zeros(LANES, dtype=np.bool_)
    event = np.zeros(LANES, dtype=np.bool_)
    leg = np.zeros(LANES, dtype=np.int64)
    owner = np.full(LANES, -1, dtype=np.int64)
    waiting, active = 0, 0

    for _ in range(MAX_STEPS * (count + 1)):
        for lane in range(LANES):
            if owner[lane] >= 0:
                continue
            if waiting < count:
                owner[lane], leg[lane] = waiting, 1
                beta[lane] = problems[waiting, ADHESION]
                damping_h[lane] = problems[waiting, HERTZ_DAMPING]
                damping_a[lane] = problems[waiting, DAMPING_1]
                s[0, lane], u[0, lane] = problems[waiting, START_S], problems[waiting, START_U]
                waiting += 1
                active += 1
                for column in range(RESULT_COLUMNS):
                    total[column, lane] = 0.0
                for k in range(1, ORDER + 1):  # what is left there must be finite
                    s[k, lane] = u[k, lane] = p[PAD + k, lane] = m[k, lane] = 0.0
                mark[lane] = u[0, lane]
                total[LOWEST_U, lane] = u[0, lane]
                pull, _ = _pull(
                    s[0, lane], u[0, lane], beta[lane], damping_h[lane], damping_a[lane]
                )
                pulling[lane] = pull > 0.0
                energy[lane] = 0.5 * u[0, lane] ** 2 + _well_energy(s[0, lane], beta[lane])
            else:
                s[0, lane], u[0, lane], h[lane] = 0.0, 1.0, 0.0
                beta[lane], damping_h[lane], damping_a[lane] = 0.0, 0.0, 0.0
        if active == 0:
            break

        _expand(beta, damping_h, damping_a, padded_s, padded_u, p, m)
        _step_sizes(s, u, new_s, new_u, h)
        _evaluate(s, h, new_s)
        _evaluate(u, h, new_u)
        _contact_times(s, h, row)
        for lane in range(LANES):
            event[lane] = False
            if owner[lane] < 0:
                continue
            turning = leg[lane] == 1
            end = new_u[lane] if turning else new_s[lane]
            if end <= 0.0:
                event[lane] = True
                h[lane] = _root(u if turning else s, lane, h[lane], end)
                if turning:
                    new_s[lane], new_u[lane] = _value(s, lane, h[lane]), 0.0
                else:
                    new_s[lane], new_u[lane] = 0.0, _value(u, lane, h[lane])
                row[lane] = _contact_time(s, lane, h[lane])
            total[DURATION, lane] += row[lane]
        if mode != PLAIN:
            _quadratures(s, u, h, beta, damping_h, damping_a, m[0], m[1], row, total)

        for lane in range(LANES):
            if owner[lane] < 0:
                continue
            end_s, end_u = new_s[lane], new_u[lane]
            pull, _ = _pull(end_s, end_u, beta[lane], damping_h[lane], damping_a[lane])
            now_pulling = pull > 0.0
            if now_pulling != pulling[lane]:
                instant = _balance(
                    s, u, lane, h[lane], pull, beta[lane], damping_h[lane], damping_a[lane]
                )
                extremum = _value(u, lane, instant)
                if now_pulling:
                    total[COMPRESSIVE_IMPULSE, lane] += mark[lane] - extremum
                    total[LOWEST_U, lane] = min(total[LOWEST_U, lane], extremum)
                mark[lane] = extremum
                pulling[lane] = now_pulling
            total[STEPS, lane] += 1.0
            lost = total[HERTZ_WORK, lane] + total[ADHESION_WORK, lane]
            status = -1.0
            if leg[lane] == 1:
                if event[lane]:
                    leg[lane] = 2
                    damping_a[lane] = problems[owner[lane], DAMPING_2]
                    total[TURNING_S, lane] = end_s
                    total[TURNING_TIME, lane] = total[DURATION, lane]
                    if problems[owner[lane], ALWAYS_CAPTURED] != 0.0:
                        status = CAPTURED
                elif _never_turns(end_s, end_u, damping_h[lane], damping_a[lane]):
                    status = ESCAPED
                elif problems[owner[lane], ALWAYS_CAPTURED] != 0.0 and _settles(
                    end_s, end_u, beta[lane], damping_h[lane], damping_a[lane]
                ):
                    status = CAPTURED
                    total[TURNING_S, lane] = math.sqrt(beta[lane])
                    total[TURNING_TIME, lane] = math.inf
            elif event[lane]:
                status = REBOUND
                if mode == SHALLOW:
                    end_u = -math.sqrt(2.0 * max(energy[lane] - lost, 0.0))
            elif end_u >= 0.0:
                status = CAPTURED
            elif 0.0 < beta[lane] * end_s**3 < NOTHING_LEFT * energy[lane]:
                # At the threshold s falls towards zero for ever: what is left decides.
                rest = 0.5 * end_u * end_u + _well_energy(end_s, beta[lane])
                if mode == SHALLOW:
                    rest = energy[lane] - lost
                status = REBOUND if rest >= 0.0 else CAPTURED
                end_s, end_u = 0.0, -math.sqrt(2.0 * max(rest, 0.0))
            elif mode == SHALLOW:
                if energy[lane] < lost:
                    status = CAPTURED
                elif end_s * end_s < 0.5 * beta[lane]:
                    # back onto the energy surface, where the path alone has lost it to rounding
                    end_u = -math.sqrt(
                        2.0 * (energy[lane] - lost - _well_energy(end_s, beta[lane]))
                    )
            elif 0.5 * end_u * end_u + _well_energy(end_s, beta[lane]) < 0.0:
                status = CAPTURED
            if status < 0.0 and (total[STEPS, lane] >= MAX_STEPS or not math.isfinite(end_u)):
                status = FAILED
            s[0, lane], u[0, lane] = end_s, end_u
            if status >= 0.0:
                total[END_U, lane], total[END_S, lane] = end_u, end_s
                if status == REBOUND:
                    total[LOWEST_U, lane] = min(total[LOWEST_U, lane], end_u)
                    if not pulling[lane]:
                        total[COMPRESSIVE_IMPULSE, lane] += mark[lane] - end_u
                total[STATUS, lane] = status
                for column in range(RESULT_COLUMNS):
                    results[owner[lane], column] = total[column, lane]
                owner[lane] = -1
                active -= 1


@_jit_inline
def _own(values, i):  # type: ignore[no-untyped-def]
    """Index an array with a value per impact, or with a single value for all."""
    return values[i] if values.size > 1 else values[0]


@_jit
def outcomes(
    problems: FloatArray,
    results: FloatArray,
    length: FloatArray,
    velocity: FloatArray,
    mass: FloatArray,
    out: FloatArray,
) -> None:
    """Write the outcomes of scaled impacts in SI units.

    In turn e, contact and compression time, greatest compression, compressive and greatest net
    impulse, and that of the Hertz term.

    Parameters
    ----------
    problems, results
        Scaled impacts and their results, as of `integrate`.
    length, velocity, mass
        Scales in m, m/s and kg, (n,), or (1,) for all impacts.
    out
        Room for the outcomes, (``OUTCOMES``, n).
    """
    for i in range(out.shape[1]):
        unit, speed = _own(length, i), _own(velocity, i)
        time, impulse = unit / speed, _own(mass, i) * speed
        captured = results[i, STATUS] == CAPTURED
        start = problems[i, START_U]
        out[0, i] = 0.0 if captured else -results[i, END_U] / start
        out[1, i] = math.inf if captured else results[i, DURATION] * time
        out[2, i] = results[i, TURNING_TIME] * time
        out[3, i] = results[i, TURNING_S] ** 2 * unit
        out[4, i] = results[i, COMPRESSIVE_IMPULSE] * impulse
        out[5, i] = (start - results[i, LOWEST_U]) * impulse
        out[6, i] = results[i, HERTZ_IMPULSE] * impulse


@_jit
def record(
    problem: FloatArray, shallow: bool, end_time: float, series: FloatArray, ends: FloatArray
) -> int:
    """Follow one problem to the end of contact, to ``end_time`` or to rest, step by step.

    A captured impact goes on through legs of approach and rebound. Returns the number of steps, or
    -1 where ``series`` is too short.

    Parameters
    ----------
    problem
        Scaled impact, one row of `integrate`.
    shallow
        Whether the energy of a rebound is taken from the works, as by the mode of that name.
    end_time
        Scaled time at which the record ends.
    series
        Room for the coefficients of s and u, (n, 2, ORDER + 1).
    ends
        Room for each step's length in tau, contact time and Hertz impulse, (n, 3).
    """
    energy = 0.5 * problem[START_U] ** 2
    rows = PAD + ORDER + 1
    padded_s, padded_u, p, m = _rows(rows), _rows(rows), _rows(rows), _rows(rows)
    s, u = padded_s[PAD:], padded_u[PAD:]
    beta, damping_h, damping_a = np.zeros(LANES), np.zeros(LANES), np.zeros(LANES)
    h, row, total = np.zeros(LANES), np.zeros(LANES), np.zeros((RESULT_COLUMNS, LANES))
    s[0, :], u[0, :] = 0.0, 1.0
    s[0, 0], u[0, 0] = problem[START_S], problem[START_U]
    beta[0], damping_h[0], damping_a[0] = (
        problem[ADHESION],
        problem[HERTZ_DAMPING],
        problem[DAMPING_1],
    )
    approaching, lane = True, np.int64(0)  # a plain 0 has callees compiled for it alone
    pulling = _pull(s[0, 0], u[0, 0], beta[0], damping_h[0], damping_a[0])[0] > 0.0
    for step in range(series.shape[0]):
        _expand(beta, damping_h, damping_a, padded_s, padded_u, p, m)
        _step_sizes(s, u, m[0], m[1], h)
        ended = False
        new_u, new_s = _value(u, lane, h[0]), _value(s, lane, h[0])
        turned = new_u <= 0.0 if approaching else new_u >= 0.0
        if not approaching and new_s <= 0.0:
            h[0] = _root(s, lane, h[0], new_s)
            ended, turned = True, False
        elif turned:
            h[0] = _root(u, lane, h[0], new_u)
        # a step ends where the force changes sign, so that within a step it has one sign
        pull, _ = _pull(
            _value(s, lane, h[0]), _value(u, lane, h[0]), beta[0], damping_h[0], damping_a[0]
        )
        if (pull > 0.0) != pulling:
            h[0] = _balance(s, u, lane, h[0], pull, beta[0], damping_h[0], damping_a[0])
            ended, turned, pulling = False, False, not pulling
        for k in range(ORDER + 1):  # no slices: to refuse another length costs seconds to compile
            series[step, 0, k], series[step, 1, k] = s[k, 0], u[k, 0]
        new_u, new_s = _value(u, lane, h[0]), _value(s, lane, h[0])
        time = _contact_time(s, lane, h[0])
        total[:, 0] = 0.0
        _quadratures(s, u, h, beta, damping_h, damping_a, m[0], m[1], row, total)
        ends[step, 0], ends[step, 1], ends[step, 2] = h[0], time, total[HERTZ_IMPULSE, 0]
        end_time -= time
        energy -= total[HERTZ_WORK, 0] + total[ADHESION_WORK, 0]
        if shallow and not approaching and energy >= 0.0 and new_s * new_s < 0.5 * beta[0]:
            new_u = -math.sqrt(2.0 * (energy - _well_energy(new_s, beta[0])))
        if ended or end_time <= 0.0 or _rests(new_s, new_u, beta[0]):
            return step + 1
        s[0, 0], u[0, 0] = new_s, new_u
        if turned:
            approaching = not approaching
            u[0, 0] = 0.0
            damping_a[0] = problem[DAMPING_1] if approaching else problem[DAMPING_2]
    return -1


@_jit
def instants(series, steps, which, time, tau):  # type: ignore[no-untyped-def]
    """Write ``tau`` at which so much contact time has passed in the step ``which``, each (n,).

    Contact time is the integral of s: where s vanishes, at an end, it is flat, so that Newton's
    step is taken within a bracket.

    Parameters
    ----------
    series
        Coefficients of the steps, as from `record`.
    steps
        Their lengths in tau, (steps,).
    which
        Number of the step of each instant, (n,).
    time
        Scaled contact time passed in that step, (n,).
    tau
        Room for the instants, (n,).
    """
    s = series[:, 0].T
    for i in range(time.size):
        step, lower, upper = which[i], 0.0, steps[which[i]]
        first, second = s[0, step], s[1, step]
        x = 2.0 * time[i] / (first + math.sqrt(max(first * first + 2.0 * second * time[i], 0.0)))
        x = x if lower < x < upper else 0.5 * upper
        for _ in range(80):
            off = _contact_time(s, step, x) - time[i]
            if off < 0.0:
                lower = x
            else:
                upper = x
            new = x - off / _value(s, step, x)
            if abs(new - x) <= ROOT_TOLERANCE * abs(new):
                x = new
                break
            x = new if lower < new < upper else 0.5 * (lower + upper)
        tau[i] = x
