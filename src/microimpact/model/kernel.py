"""Compiled integration of the normal motion, Eq. (25), in its regular form.

With the compression ``x`` in units of a length scale, ``s = sqrt(x)`` (the contact radius),
``u = dx/dt`` and ``dt = s dtau``, the equation of motion is polynomial and smooth through s = 0::

    ds/dtau = u/2,    du/dtau = b s^2 - s^4 - (b C_A s^2 + C_H s^4) u

``b`` is the strength of adhesion (1 in the adhesion scale, 0 without adhesion) and ``C_A``, ``C_H``
the damping groups. A *leg* runs at constant ``C_A``: the first ends at the turning point u = 0, the
second where contact ends, s = 0. Running the film backwards is the same problem with the signs of
the damping groups changed, so one integrator serves impacts and the backward map.

Each step is a Taylor expansion of order ``ORDER``. ``LANES`` impacts advance side by side, each
with its own step, so that the convolutions compile to SIMD code; a finished lane takes the next
impact. An impact's numbers do not depend on its neighbours.

All compiled functions stand in this one module: Numba's on-disk cache looks only at the file of the
function it loads and would keep stale callees from another one. Loops are bounded ``for`` loops on
purpose: every integration ends, with a status.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

if TYPE_CHECKING:
    from microimpact.arrays import FloatArray

ORDER = 20
LANES = 16
TOLERANCE = 1e-14
MAX_STEPS = 2_000_000

# Columns of a problem: start of the first leg, strength of adhesion, damping groups of both legs.
# An impact that is DOOMED (no speed at all rebounds) is followed to the turning point only.
START_S, START_U, ADHESION, HERTZ_DAMPING, DAMPING_1, DAMPING_2, DOOMED = range(7)
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

REBOUND, CAPTURED, ESCAPED, FAILED = 0.0, 1.0, 2.0, 3.0

# What is computed besides the path. PLAIN: contact time and compressive impulse. LEDGER: impulse
# and work of each term too. SHALLOW: as LEDGER, for speeds so small against the depth of the
# adhesive well that the energy must be taken from the works, not from a small difference.
PLAIN, LEDGER, SHALLOW = 0, 1, 2

_NODES, _WEIGHTS = (a.copy() for a in np.polynomial.legendre.leggauss(10))
_NODES = 0.5 * (_NODES + 1.0)
_WEIGHTS = 0.5 * _WEIGHTS

_jit = njit(cache=True, nogil=True, error_model="numpy")
_jit_contract = njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "nsz"})


@_jit_contract
def _square(a, k, out):  # type: ignore[no-untyped-def]
    """Coefficient ``k`` of the square of series ``a``, every lane."""
    lanes = LANES
    for lane in range(lanes):
        out[lane] = 0.0
    for j in range((k + 1) // 2):
        for lane in range(lanes):
            out[lane] += a[j, lane] * a[k - j, lane]
    for lane in range(lanes):
        out[lane] *= 2.0
    if k % 2 == 0:
        for lane in range(lanes):
            out[lane] += a[k // 2, lane] * a[k // 2, lane]


@_jit_contract
def _expand(beta, damping_h, damping_a, s, u, p, g, m, row):  # type: ignore[no-untyped-def]
    """Taylor coefficients of s and u from their values in row 0 (p = s^2, g = s^4)."""
    lanes = LANES
    for k in range(ORDER):
        _square(s, k, row)
        for lane in range(lanes):
            p[k, lane] = row[lane]
        _square(p, k, row)
        for lane in range(lanes):
            g[k, lane] = row[lane]
            m[k, lane] = beta[lane] * damping_a[lane] * p[k, lane] + damping_h[lane] * row[lane]
            row[lane] = 0.0
        for j in range(k + 1):
            for lane in range(lanes):
                row[lane] += m[j, lane] * u[k - j, lane]
        inverse = 1.0 / (k + 1)
        for lane in range(lanes):
            s[k + 1, lane] = 0.5 * inverse * u[k, lane]
            u[k + 1, lane] = inverse * (beta[lane] * p[k, lane] - g[k, lane] - row[lane])


@_jit_contract
def _evaluate(c, h, out):  # type: ignore[no-untyped-def]
    """Value of each lane's series at its step ``h``."""
    lanes = LANES
    for lane in range(lanes):
        out[lane] = c[ORDER, lane]
    for k in range(ORDER - 1, -1, -1):
        for lane in range(lanes):
            out[lane] = out[lane] * h[lane] + c[k, lane]


@_jit
def _step_size(s, u, lane):  # type: ignore[no-untyped-def]
    """Step at which the last two terms of both series fall to the tolerance."""
    scale = TOLERANCE * max(abs(s[0, lane]), abs(u[0, lane]))
    last = max(abs(s[ORDER, lane]), abs(u[ORDER, lane]))
    before = max(abs(s[ORDER - 1, lane]), abs(u[ORDER - 1, lane]))
    log_step = math.inf
    if last > 0.0:
        log_step = math.log(scale / last) / ORDER
    if before > 0.0:
        log_step = min(log_step, math.log(scale / before) / (ORDER - 1))
    return math.exp(log_step)


@_jit
def _root(c, lane, upper, derivative):  # type: ignore[no-untyped-def]
    """Zero in (0, upper] of a lane's series (or of its derivative): Newton within a bracket."""
    lower, x = 0.0, upper
    sign = c[1, lane] if derivative else c[0, lane]
    for _ in range(80):
        value, slope = 0.0, 0.0
        for k in range(ORDER, -1, -1):
            if derivative and k == 0:
                break
            slope = slope * x + value
            value = value * x + (k * c[k, lane] if derivative else c[k, lane])
        if value * sign > 0.0:
            lower = x
        else:
            upper = x
        new = x - value / slope if slope != 0.0 else 0.5 * (lower + upper)
        if not (lower <= new <= upper):
            new = 0.5 * (lower + upper)
        if abs(new - x) <= 2.3e-16 * abs(new):
            return new
        x = new
    return x


@_jit
def _value(c, lane, h):  # type: ignore[no-untyped-def]
    """Value of one lane's series at ``h``."""
    value = c[ORDER, lane]
    for k in range(ORDER - 1, -1, -1):
        value = value * h + c[k, lane]
    return value


@_jit
def _well_energy(s, beta):  # type: ignore[no-untyped-def]
    """Potential energy of Hertz and ring force; it vanishes at s = 0."""
    return s * s * s * (0.4 * s * s - 2.0 / 3.0 * beta)


@_jit
def _pulls(s, u, beta, damping_h, damping_a):  # type: ignore[no-untyped-def]
    """Whether the force attracts: du/dtau over s^2 is positive."""
    return beta * (1.0 - damping_a * u) > s * s * (1.0 + damping_h * u)


@_jit_contract
def _quadratures(s, u, h, beta, damping_h, damping_a, row_s, row_u, x, total):  # type: ignore[no-untyped-def]
    """Add each term's impulse and work over the step, by Gauss-Legendre on the series."""
    lanes = LANES
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
    """True where a film run backwards (negative damping) can no longer come to rest."""
    if 1.0 + damping_h * u <= 0.0:
        return True
    return damping_a < 0.0 and -damping_a * u > 2.0 * s * s and s > 2.0 + 4.0 / damping_a**2


@_jit
def integrate(problems: FloatArray, mode: int, results: FloatArray) -> None:
    """Integrate every row of ``problems`` into the same row of ``results``."""
    count = problems.shape[0]
    shape = (ORDER + 1, LANES)
    s, u, p, g, m = (
        np.zeros(shape),
        np.zeros(shape),
        np.zeros(shape),
        np.zeros(shape),
        np.zeros(shape),
    )
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
                row_in = problems[waiting]
                owner[lane], leg[lane] = waiting, 1
                waiting += 1
                active += 1
                beta[lane], damping_h[lane] = row_in[ADHESION], row_in[HERTZ_DAMPING]
                damping_a[lane] = row_in[DAMPING_1]
                s[0, lane], u[0, lane] = row_in[START_S], row_in[START_U]
                total[:, lane] = 0.0
                mark[lane] = u[0, lane]
                total[LOWEST_U, lane] = u[0, lane]
                pulling[lane] = _pulls(
                    s[0, lane], u[0, lane], beta[lane], damping_h[lane], damping_a[lane]
                )
                energy[lane] = 0.5 * u[0, lane] ** 2 + _well_energy(s[0, lane], beta[lane])
            else:
                s[0, lane], u[0, lane], h[lane] = 0.0, 1.0, 0.0
                beta[lane], damping_h[lane], damping_a[lane] = 0.0, 0.0, 0.0
        if active == 0:
            break

        _expand(beta, damping_h, damping_a, s, u, p, g, m, row)
        for lane in range(LANES):
            h[lane] = _step_size(s, u, lane) if owner[lane] >= 0 else 0.0
        _evaluate(s, h, new_s)
        _evaluate(u, h, new_u)
        for lane in range(LANES):
            event[lane] = False
            if owner[lane] < 0:
                continue
            if leg[lane] == 1 and new_u[lane] <= 0.0:
                h[lane] = _root(u, lane, h[lane], False)
                event[lane] = True
            elif leg[lane] == 2 and new_s[lane] <= 0.0:
                h[lane] = _root(s, lane, h[lane], False)
                event[lane] = True
        _evaluate(s, h, new_s)
        _evaluate(u, h, new_u)
        # contact time is the integral of s
        for lane in range(LANES):
            row[lane] = s[ORDER, lane] / (ORDER + 1)
        for k in range(ORDER - 1, -1, -1):
            for lane in range(LANES):
                row[lane] = row[lane] * h[lane] + s[k, lane] / (k + 1)
        for lane in range(LANES):
            total[DURATION, lane] += row[lane] * h[lane]
        if mode != PLAIN:
            _quadratures(s, u, h, beta, damping_h, damping_a, m[0], m[1], row, total)

        for lane in range(LANES):
            if owner[lane] < 0:
                continue
            end_s, end_u = new_s[lane], new_u[lane]
            if event[lane]:
                if leg[lane] == 1:
                    end_u = 0.0
                else:
                    end_s = 0.0
            now_pulling = _pulls(end_s, end_u, beta[lane], damping_h[lane], damping_a[lane])
            if now_pulling != pulling[lane]:
                extremum = _value(u, lane, _root(u, lane, h[lane], True))
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
                    if problems[owner[lane], DOOMED] != 0.0:
                        status = CAPTURED
                elif _never_turns(end_s, end_u, damping_h[lane], damping_a[lane]):
                    status = ESCAPED
            elif event[lane]:
                status = REBOUND
                if mode == SHALLOW:
                    end_u = -math.sqrt(2.0 * max(energy[lane] - lost, 0.0))
            elif end_u >= 0.0:
                status = CAPTURED
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
                results[owner[lane], :] = total[:, lane]
                owner[lane] = -1
                active -= 1


@_jit
def record(problem: FloatArray, end_time: float, series: FloatArray, ends: FloatArray) -> int:
    """Follow one problem to the end of contact or to ``end_time``, keeping every step's series.

    ``series`` (n, 2, ORDER + 1) receives the coefficients of s and u, ``ends`` (n, 3) each step's
    length in tau, its contact time and its Hertz impulse. A captured impact goes on through legs of
    approach and rebound. Returns the number of steps, or -1 where ``series`` is too short.
    """
    shape = (ORDER + 1, LANES)
    s, u, p, g, m = (
        np.zeros(shape),
        np.zeros(shape),
        np.zeros(shape),
        np.zeros(shape),
        np.zeros(shape),
    )
    beta, damping_h, damping_a = np.zeros(LANES), np.zeros(LANES), np.zeros(LANES)
    h, row, total = np.zeros(LANES), np.zeros(LANES), np.zeros((RESULT_COLUMNS, LANES))
    s[0, :], u[0, :] = 0.0, 1.0
    s[0, 0], u[0, 0] = problem[START_S], problem[START_U]
    beta[0], damping_h[0], damping_a[0] = (
        problem[ADHESION],
        problem[HERTZ_DAMPING],
        problem[DAMPING_1],
    )
    approaching = True
    pulling = _pulls(s[0, 0], u[0, 0], beta[0], damping_h[0], damping_a[0])
    for step in range(series.shape[0]):
        _expand(beta, damping_h, damping_a, s, u, p, g, m, row)
        h[0] = _step_size(s, u, 0)
        ended = False
        new_u, new_s = _value(u, 0, h[0]), _value(s, 0, h[0])
        turned = new_u <= 0.0 if approaching else new_u >= 0.0
        if not approaching and new_s <= 0.0:
            h[0] = _root(s, 0, h[0], False)
            ended, turned = True, False
        elif turned:
            h[0] = _root(u, 0, h[0], False)
        # a step ends where the force changes sign, so that within a step it has one sign
        now_pulling = _pulls(
            _value(s, 0, h[0]), _value(u, 0, h[0]), beta[0], damping_h[0], damping_a[0]
        )
        if now_pulling != pulling:
            h[0] = _root(u, 0, h[0], True)
            ended, turned, pulling = False, False, now_pulling
        series[step, 0, :], series[step, 1, :] = s[:, 0], u[:, 0]
        new_u, new_s = _value(u, 0, h[0]), _value(s, 0, h[0])
        time = s[ORDER, 0] / (ORDER + 1)
        for k in range(ORDER - 1, -1, -1):
            time = time * h[0] + s[k, 0] / (k + 1)
        total[:, 0] = 0.0
        _quadratures(s, u, h, beta, damping_h, damping_a, m[0], m[1], row, total)
        ends[step, 0], ends[step, 1], ends[step, 2] = h[0], time * h[0], total[HERTZ_IMPULSE, 0]
        end_time -= time * h[0]
        if ended or end_time <= 0.0:
            return step + 1
        s[0, 0], u[0, 0] = new_s, new_u
        if turned:
            approaching = not approaching
            u[0, 0] = 0.0
            damping_a[0] = problem[DAMPING_1] if approaching else problem[DAMPING_2]
    return -1
