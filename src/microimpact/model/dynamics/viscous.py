"""Compiled integration of an impact on a JKR contact with viscous loss, in its regular form.

With s the square root of the contact radius and v the speed of approach, both scaled as in
`microimpact.model.dynamics.force_laws`, and ``dt = 4 (s^3 - beta) dtau``, the motion is polynomial
and smooth through the snap-off at ``s^3 = beta``, where the contact radius changes without limit::

    ds/dtau = v,    dv/dtau = -4 (c - beta) h,    h = c^2 - 6 beta c + drag p

with ``p = s^2 v``, and ``c = s^3``, whose derivative is 3 p: three products of series make a term.
Each step is a Taylor expansion of order ``ORDER``; as in `microimpact.model.dynamics.kernel`,
``LANES`` impacts advance side by side. A motion goes to its turning point and back to a given s,
or no further if that is infinite; with a negative drag it is an impact backwards in time.
"""

from __future__ import annotations

import math

import numpy as np

from microimpact.core.arrays import FloatArray
from microimpact.core.compiled import jit

ORDER = 20
LANES = 32
TOLERANCE = 1e-14
# As in `kernel`: parts with sums of one length, and the rows of zeros that make them so.
THIRD = 2 * -(-ORDER // 6)
PAD = THIRD - 1
ROOT_TOLERANCE = 1e-9
MAX_STEPS = 100_000

# Columns of a problem and of a result. Impulses per mass.
BETA, DRAG, START_S, START_V, END_S = range(5)
STATUS, SPEED, TIME, TURNING_TIME, TURNING_S, COMPRESSIVE_IMPULSE, LOWEST_V, STEPS = range(8)
RESULT_COLUMNS = 8

REBOUND, CAPTURED, ESCAPED, FAILED = 0.0, 1.0, 2.0, 3.0

# Drag, in units with beta = 1, that is overdamped: above 0.650 no speed rebounds. It is followed to
# its turning point only, or to where it creeps and will not turn.
OVERDAMPED = 10.0

_BITS_OF_ONE = (1023.0 - 0.0861) * 2.0**52

_ONES, _INVERSE = np.ones(ORDER + 1), 1.0 / np.arange(1.0, ORDER + 2.0)

_jit = jit()
_jit_inline = jit(inline="always")
_jit_contract = jit(fastmath={"contract", "nsz"})


@_jit_inline
def _coefficients(first, stop, beta, drag, s, v, q, c, h):  # type: ignore[no-untyped-def]
    """Coefficients ``first`` to ``stop`` of q = s^2 and h, and the next of s, v and c, all lanes.

    Sums are all as long as the longest: rows of zeros in front of each series end them. Squares are
    summed from the middle outwards.
    """
    for k in range(first, stop):
        row, middle, inverse = PAD + k, PAD + k // 2, 1.0 / (k + 1)
        odd = k % 2
        for lane in range(LANES):
            s[row + 1, lane] = inverse * v[row, lane]
        for lane in range(LANES):
            q_k = c_k = 0.0
            for j in range(stop // 2):
                q_k += s[middle - 1 - j + odd, lane] * s[middle + 1 + j, lane]
                c_k += c[middle - 1 - j + odd, lane] * c[middle + 1 + j, lane]
            q[k, lane], h[row, lane] = 2.0 * q_k, 2.0 * c_k
        if not odd:
            for lane in range(LANES):
                q[k, lane] += s[middle, lane] * s[middle, lane]
                h[row, lane] += c[middle, lane] * c[middle, lane]
        for lane in range(LANES):
            p_k = 0.0
            for j in range(stop):
                p_k += q[j, lane] * v[row - j, lane]
            c[row + 1, lane] = 3.0 * inverse * p_k
            h[row, lane] += drag[lane] * p_k - 6.0 * beta[lane] * c[row, lane]
        for lane in range(LANES):
            v_k = beta[lane] * h[row, lane]
            for j in range(stop):
                v_k -= c[PAD + j, lane] * h[row - j, lane]
            v[row + 1, lane] = 4.0 * inverse * v_k


@_jit_contract
def _expand(beta, drag, s, v, q, c, h):  # type: ignore[no-untyped-def]
    """Taylor coefficients from the values of s, v and c = s^3 in row PAD."""
    if not (s.shape[1] == v.shape[1] == q.shape[1] == c.shape[1] == h.shape[1] == LANES):
        return  # never: gives the compiler the distance of rows
    _coefficients(0, THIRD, beta, drag, s, v, q, c, h)
    _coefficients(THIRD, 2 * THIRD, beta, drag, s, v, q, c, h)
    _coefficients(2 * THIRD, ORDER, beta, drag, s, v, q, c, h)


@_jit_contract
def _evaluate(series, x, weights, out):  # type: ignore[no-untyped-def]
    """Value of each lane's series, its terms weighted, at x."""
    if series.shape[1] != LANES or weights.size != ORDER + 1:
        return
    for lane in range(LANES):
        value = series[ORDER, lane] * weights[ORDER]
        for k in range(ORDER):
            value = value * x[lane] + series[ORDER - 1 - k, lane] * weights[ORDER - 1 - k]
        out[lane] = value


@_jit
def _value(series, lane, x):  # type: ignore[no-untyped-def]
    """Value of a lane's series at x; even and odd powers are summed side by side."""
    even, odd, square = series[ORDER, lane], 0.0, x * x
    for k in range(ORDER - 2, -1, -2):
        even = even * square + series[k, lane]
        odd = odd * square + series[k + 1, lane]
    return even + x * odd


@_jit_contract
def _step_sizes(s, v, last, before, step):  # type: ignore[no-untyped-def]
    """Step of each lane at which the last two terms of both series fall to the tolerance."""
    for lane in range(LANES):
        scale = 1.0 / (TOLERANCE * max(abs(s[0, lane]), abs(v[0, lane])))
        last[lane] = scale * max(abs(s[ORDER, lane]), abs(v[ORDER, lane]))
        before[lane] = scale * max(abs(s[ORDER - 1, lane]), abs(v[ORDER - 1, lane]))
    # As in `kernel`: the bits of numbers serve as their logarithms, rounded towards short steps.
    last_bits, before_bits, bits = last.view(np.int64), before.view(np.int64), step.view(np.int64)
    for lane in range(LANES):
        log_step = min(
            (_BITS_OF_ONE - last_bits[lane]) * (1.0 / ORDER),
            (_BITS_OF_ONE - before_bits[lane]) * (1.0 / (ORDER - 1)),
        )
        bits[lane] = int(_BITS_OF_ONE + log_step)


@_jit
def _mean(series, lane, x):  # type: ignore[no-untyped-def]
    """Mean of a lane's series from 0 to x."""
    value = series[ORDER, lane] * _INVERSE[ORDER]
    for k in range(ORDER - 1, -1, -1):
        value = value * x + series[k, lane] * _INVERSE[k]
    return value


@_jit
def _root(series, lane, level, upper, end):  # type: ignore[no-untyped-def]
    """Place in (0, upper] where a lane's series crosses a level, from which it ends so far.

    Newton's method within a bracket, from the zero of the parabola of both values and first slope.
    """
    start, slope = series[0, lane] - level, series[1, lane]
    bend = (end - start - slope * upper) / (upper * upper)
    root = math.sqrt(max(slope * slope - 4.0 * bend * start, 0.0))
    x = 2.0 * start / (math.copysign(root, start) - slope)
    lower, x = 0.0, x if 0.0 < x < upper else upper
    for _ in range(80):
        even, odd, even_slope, odd_slope, square = series[ORDER, lane], 0.0, 0.0, 0.0, x * x
        for k in range(ORDER - 2, -1, -2):
            even_slope = even_slope * square + even
            odd_slope = odd_slope * square + odd
            even = even * square + series[k, lane]
            odd = odd * square + series[k + 1, lane]
        value, slope = even - level + x * odd, odd + 2.0 * x * (even_slope + x * odd_slope)
        if (value > 0.0) == (end > 0.0):
            upper = x
        else:
            lower = x
        new = x - value / slope if slope != 0.0 else lower
        if abs(new - x) <= ROOT_TOLERANCE * abs(new):
            return new
        x = new if lower < new < upper else 0.5 * (lower + upper)
    return x


@_jit
def _force(s, v, beta, drag):  # type: ignore[no-untyped-def]
    """Force of the contact, h."""
    return s**3 * (s**3 - 6.0 * beta) + drag * s * s * v


@_jit
def _well(s, beta):  # type: ignore[no-untyped-def]
    """Elastic and surface energy of a JKR contact."""
    return s**4 * (0.4 * s**6 - 4.0 * beta * s**3 + 6.0 * beta * beta)


@_jit
def _fate(s, v, beta, drag):  # type: ignore[no-untyped-def]
    """Status of an approach that is known never to turn, else -1."""
    # Backwards in time, and beyond what the elastic force can turn.
    if drag < 0.0 and -drag * v > 2.0 * s**4 and drag * drag * s**2 > 8.0:
        return ESCAPED
    pull = s**3 * (6.0 * beta - s**3)
    rests = abs(s**3 - 6.0 * beta) < 1e-9 * beta and v < 1e-9 * s**4
    overdamped = drag * beta ** (1.0 / 3.0) > OVERDAMPED
    return CAPTURED if rests or (overdamped and drag * s**2 * v < 2.0 * pull) else -1.0


@_jit
def integrate(problems: FloatArray, results: FloatArray) -> None:
    """Follow every row of ``problems`` into the same row of ``results``."""
    count = problems.shape[0]
    rows = PAD + ORDER + 1
    padded_s, padded_v, q = (
        np.zeros((rows, LANES)),
        np.zeros((rows, LANES)),
        np.zeros((rows, LANES)),
    )
    padded_c, padded_h = np.zeros((rows, LANES)), np.zeros((rows, LANES))
    s, v, c, h = padded_s[PAD:], padded_v[PAD:], padded_c[PAD:], padded_h[PAD:]
    beta, drag, step, time = np.zeros(LANES), np.zeros(LANES), np.zeros(LANES), np.zeros(LANES)
    new_s, new_v, mark = np.zeros(LANES), np.ones(LANES), np.zeros(LANES)
    total = np.zeros((RESULT_COLUMNS, LANES))
    owner = np.full(LANES, -1, dtype=np.int64)
    pushing, approaching = np.zeros(LANES, dtype=np.bool_), np.zeros(LANES, dtype=np.bool_)
    waiting, active = 0, 0
    for _ in range(MAX_STEPS * (count + 1)):
        for lane in range(LANES):
            if owner[lane] < 0 and waiting < count:
                beta[lane], drag[lane] = problems[waiting, BETA], problems[waiting, DRAG]
                new_s[lane], new_v[lane] = problems[waiting, START_S], problems[waiting, START_V]
                total[:, lane] = 0.0
                for k in range(ORDER + 1):  # what is left there must be finite
                    s[k, lane] = v[k, lane] = q[k, lane] = c[k, lane] = h[k, lane] = 0.0
                mark[lane] = total[LOWEST_V, lane] = new_v[lane]
                force = _force(new_s[lane], new_v[lane], beta[lane], drag[lane])
                pushing[lane], approaching[lane] = force > 0.0, True
                owner[lane] = waiting
                waiting += 1
                active += 1
            elif owner[lane] < 0:
                beta[lane], drag[lane], new_s[lane], new_v[lane] = 0.0, 0.0, 0.0, 1.0
            s[0, lane], v[0, lane], c[0, lane] = new_s[lane], new_v[lane], new_s[lane] ** 3
        if active == 0:
            break
        _expand(beta, drag, padded_s, padded_v, q, padded_c, padded_h)
        _step_sizes(s, v, new_s, new_v, step)
        _evaluate(s, step, _ONES, new_s)
        _evaluate(v, step, _ONES, new_v)
        _evaluate(c, step, _INVERSE, time)
        for lane in range(LANES):
            if owner[lane] < 0:
                continue
            b, d, length = beta[lane], drag[lane], step[lane]
            last = problems[owner[lane], END_S]
            turned = ended = False
            if approaching[lane]:
                turned = new_v[lane] <= 0.0
            else:
                ended = new_s[lane] <= last
                if not ended and new_v[lane] >= 0.0:
                    # Short of the break it may pass the end and turn back within one step.
                    turning = _root(v, lane, 0.0, length, new_v[lane])
                    nearest = _value(s, lane, turning)
                    if nearest <= last:
                        ended, length, new_s[lane] = True, turning, nearest
            if turned or ended:
                if turned:
                    length = _root(v, lane, 0.0, length, new_v[lane])
                else:
                    length = _root(s, lane, last, length, new_s[lane] - last)
                new_s[lane], new_v[lane] = _value(s, lane, length), _value(v, lane, length)
                time[lane] = _mean(c, lane, length)
            total[TIME, lane] += 4.0 * length * (time[lane] - b)
            total[STEPS, lane] += 1.0
            if turned:
                new_v[lane] = 0.0
            end_s, end_v = new_s[lane], new_v[lane]
            force = _force(end_s, end_v, b, d)
            if (force > 0.0) != pushing[lane]:
                extremum = _value(v, lane, _root(h, lane, 0.0, length, force))
                if pushing[lane]:
                    total[COMPRESSIVE_IMPULSE, lane] += mark[lane] - extremum
                    total[LOWEST_V, lane] = min(total[LOWEST_V, lane], extremum)
                mark[lane], pushing[lane] = extremum, not pushing[lane]
            status = -1.0
            if turned:
                approaching[lane] = False
                total[TURNING_TIME, lane], total[TURNING_S, lane] = total[TIME, lane], end_s
                if d * b ** (1.0 / 3.0) > OVERDAMPED:
                    status = CAPTURED
                elif last == math.inf:
                    status = REBOUND
            elif ended:
                status = REBOUND
            elif approaching[lane]:
                status = _fate(end_s, end_v, b, d)
                if status == CAPTURED:
                    total[TURNING_TIME, lane] = math.inf
                    total[TURNING_S, lane] = (6.0 * b) ** (1.0 / 3.0)
            elif d >= 0.0:
                left = 0.5 * end_v * end_v + _well(end_s, b) - _well(last, b)
                if end_v >= 0.0 or left < 0.0:
                    status = CAPTURED
                elif end_s - last < 1e-12 * last:  # the threshold: it stops there for ever
                    status = REBOUND
            if status < 0.0 and not (
                total[STEPS, lane] < MAX_STEPS and math.isfinite(end_s) and math.isfinite(end_v)
            ):
                status = FAILED
            if status >= 0.0:
                if pushing[lane]:
                    total[COMPRESSIVE_IMPULSE, lane] += mark[lane] - end_v
                total[LOWEST_V, lane] = min(total[LOWEST_V, lane], end_v)
                total[STATUS, lane], total[SPEED, lane] = status, -end_v
                for column in range(RESULT_COLUMNS):
                    results[owner[lane], column] = total[column, lane]
                owner[lane] = -1
                active -= 1
