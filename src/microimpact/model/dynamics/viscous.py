"""Compiled integration of an impact on a JKR contact with viscous loss, in its regular form.

With s the square root of the contact radius and v the speed of approach, both scaled as in
`microimpact.model.dynamics.laws`, and ``dt = 4 (s^3 - beta) dtau``, the motion is polynomial and
smooth through the snap-off at ``s^3 = beta``, where the contact radius changes without limit::

    ds/dtau = v,    dv/dtau = -4 (s^3 - beta) (s^6 - 6 beta s^3 + drag s^2 v)

Each step is a Taylor expansion of order ``ORDER``. A motion goes to its turning point and back to a
given s; with a negative drag it is an impact backwards in time.
"""

from __future__ import annotations

import numpy as np

from microimpact.core.arrays import FloatArray
from microimpact.core.compiled import jit

ORDER = 20
TOLERANCE = 1e-16
MAX_STEPS = 100_000

# Columns of a problem and of a result. Works per mass, impulses per mass.
BETA, DRAG, START_S, START_V, END_S = range(5)
STATUS, SPEED, TIME, TURNING_TIME, TURNING_S, COMPRESSIVE_IMPULSE, LOWEST_V, WORK = range(8)
RESULT_COLUMNS = 8

REBOUND, CAPTURED, ESCAPED, FAILED = 0.0, 1.0, 2.0, 3.0

# Drag, in units with beta = 1, that is overdamped: above 0.650 no speed rebounds. It is followed to
# its turning point only, or to where it creeps and will not turn.
OVERDAMPED = 10.0

_jit = jit()


@_jit
def _value(series, x):  # type: ignore[no-untyped-def]
    value = series[ORDER]
    for k in range(ORDER - 1, -1, -1):
        value = value * x + series[k]
    return value


@_jit
def _integral(series, x):  # type: ignore[no-untyped-def]
    value = series[ORDER] / (ORDER + 1)
    for k in range(ORDER - 1, -1, -1):
        value = value * x + series[k] / (k + 1)
    return value * x


@_jit
def _crossing(series, level, upper):  # type: ignore[no-untyped-def]
    """Place in (0, upper] where a series crosses a level: Newton within a bracket."""
    lower, x = 0.0, upper
    sign = _value(series, upper) - level
    for _ in range(80):
        value, slope = series[ORDER], 0.0
        for k in range(ORDER - 1, -1, -1):
            slope = slope * x + value
            value = value * x + series[k]
        value -= level
        if value * sign > 0.0:
            upper = x
        else:
            lower = x
        new = x - value / slope if slope != 0.0 else lower
        if not lower < new < upper:
            new = 0.5 * (lower + upper)
        if abs(new - x) <= 1e-15 * abs(new):
            return new
        x = new
    return x


@_jit
def _well(s, beta):  # type: ignore[no-untyped-def]
    """Elastic and surface energy of a JKR contact."""
    return s**4 * (0.4 * s**6 - 4.0 * beta * s**3 + 6.0 * beta * beta)


@_jit
def integrate(problems: FloatArray, results: FloatArray) -> None:
    """Follow every row of ``problems`` into the same row of ``results``."""
    series = np.zeros((10, ORDER + 2))
    s, v, q, c, cc, qv, g, h, loss, qvv = series
    for row in range(problems.shape[0]):
        beta, drag, end_s = problems[row, BETA], problems[row, DRAG], problems[row, END_S]
        s[0], v[0] = problems[row, START_S], problems[row, START_V]
        time = work = impulse = turning_time = turning_s = 0.0
        mark = lowest = v[0]
        approaching, status = True, FAILED
        overdamped = drag * beta ** (1.0 / 3.0) > OVERDAMPED
        force = s[0] ** 6 - 6.0 * beta * s[0] ** 3 + drag * s[0] ** 2 * v[0]
        pushing = force > 0.0
        last = _well(end_s, beta)
        for _ in range(MAX_STEPS):
            for k in range(ORDER + 1):
                # Cauchy products, as many in a loop as may be: that doubles the pace.
                q_k = c_k = qv_k = 0.0
                for j in range(k + 1):
                    q_k += s[j] * s[k - j]
                q[k] = q_k
                for j in range(k + 1):
                    c_k += q[j] * s[k - j]
                    qv_k += q[j] * v[k - j]
                c[k] = c_k
                qv[k] = qv_k
                cc_k = qvv_k = 0.0
                for j in range(k + 1):
                    cc_k += c[j] * c[k - j]
                    qvv_k += qv[j] * v[k - j]
                cc[k] = cc_k
                qvv[k] = qvv_k
                g[k] = 4.0 * c[k]
                if k == 0:
                    g[0] -= 4.0 * beta
                h[k] = cc[k] - 6.0 * beta * c[k] + drag * qv[k]
                gh_k = loss_k = 0.0
                for j in range(k + 1):
                    gh_k += g[j] * h[k - j]
                    loss_k += g[j] * qvv[k - j]
                loss[k] = drag * loss_k
                s[k + 1] = v[k] / (k + 1)
                v[k + 1] = -gh_k / (k + 1)
            size = TOLERANCE * max(abs(s[0]), abs(v[0]))
            step = 1e300
            for k in range(ORDER - 1, ORDER + 1):
                largest = max(abs(s[k]), abs(v[k]))
                if largest > 0.0:
                    step = min(step, (size / largest) ** (1.0 / k))
            new_s, new_v = _value(s, step), _value(v, step)
            turned = approaching and new_v <= 0.0
            ended = not approaching and new_s <= end_s
            if not approaching and not ended and new_v >= 0.0:
                # Short of the break it may pass the end and turn back within one step.
                turning = _crossing(v, 0.0, step)
                if _value(s, turning) <= end_s:
                    ended, step = True, turning
            if turned:
                step = _crossing(v, 0.0, step)
            elif ended:
                step = _crossing(s, end_s, step)
            new_s, new_v = _value(s, step), _value(v, step)
            if (_value(h, step) > 0.0) != pushing:
                extremum = _value(v, _crossing(h, 0.0, step))
                if pushing:
                    impulse += mark - extremum
                    lowest = min(lowest, extremum)
                mark, pushing = extremum, not pushing
            time += _integral(g, step)
            work += _integral(loss, step)
            s[0], v[0] = new_s, new_v
            if not (np.isfinite(new_s) and np.isfinite(new_v)):
                break
            if turned:
                approaching, turning_time, turning_s = False, time, new_s
                v[0] = 0.0
                if overdamped:
                    status = CAPTURED
                    break
            elif ended:
                status = REBOUND
                break
            elif approaching:
                # Backwards in time, and beyond what the elastic force can turn.
                pace = -drag * new_v
                if drag < 0.0 and pace > 2.0 * new_s**4 and drag * drag * new_s**2 > 8.0:
                    status = ESCAPED
                    break
                pull = new_s**3 * (6.0 * beta - new_s**3)
                rest = abs(new_s**3 - 6.0 * beta) < 1e-9 * beta and new_v < 1e-9 * new_s**4
                if rest or (overdamped and drag * new_s**2 * new_v < 2.0 * pull):
                    status, turning_time, turning_s = CAPTURED, np.inf, (6.0 * beta) ** (1.0 / 3.0)
                    break
            elif drag >= 0.0:
                left = 0.5 * new_v * new_v + _well(new_s, beta) - last
                if new_v >= 0.0 or left < 0.0:
                    status = CAPTURED
                    break
                if new_s - end_s < 1e-12 * end_s:  # the threshold: it stops there for ever
                    status = REBOUND
                    break
        if pushing:
            impulse += mark - v[0]
        lowest = min(lowest, v[0])
        results[row, STATUS] = status
        results[row, SPEED] = -v[0]
        results[row, TIME] = time
        results[row, TURNING_TIME] = turning_time
        results[row, TURNING_S] = turning_s
        results[row, COMPRESSIVE_IMPULSE] = impulse
        results[row, LOWEST_V] = lowest
        results[row, WORK] = work
