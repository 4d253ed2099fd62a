"""Compiled search for least squares by Levenberg and Marquardt, many side by side, of two curves.

A curve is Eq. (34), of which `microimpact.model.empirical.search.model` is the plain form, or a law
of contact by its table: the cubic through the four nearest places of each axis.

``LANES`` searches advance together; one that has ended gives its lane to the next. What a search
finds does not depend on its neighbours. The loops over lanes compile to SIMD code, for they have a
length known to the compiler, the rows of an array are a known distance apart, and `_exp` and
`_log` are polynomials without branches.
"""

from __future__ import annotations

import math

import numpy as np

from microimpact.core.compiled import jit

# A search ends where the quadratic model and the step taken lower chi-square by less than a share
# of it, its tolerance, where no damping finds a lower point, or where nothing is left of it.
STUCK = 1e10
ITERATIONS = 300
# Damping at the start and the least, as shares of the diagonal of the normal matrix, and the
# largest decrease after one step.
FIRST_DAMPING = 1e-3
LIGHTEN = 1.0 / 3.0
LEAST_DAMPING = 1e-9
# The damping at which a small decrease means a minimum and not a small step.
LIGHT_DAMPING = 0.1
# Keeps a normal matrix of full rank in directions that the data do not determine.
RIDGE = 1e-14

LANES = 32
VARIABLES = 5
# Places of two of the variables ln(k, p, kappa, q, gap); the last stands for v_c.
Q, V_C = 3, 4

# Points are evaluated some at a time, so that fewer sums go through memory. Rows of the points of
# each lane, four to a point: v less the end of its range, or place in a table; ln v, e, 1/sigma.
GROUP = 4
SPEED, LOG_SPEED, MEASURED, WEIGHT = range(4)
POINT_ROWS = 4

# The slopes of a misfit in the variables are followed by the misfit itself; the sums of all their
# products are the normal equations: matrix, half the gradient as last column, sum of squares.
COLUMNS = VARIABLES + 1
PRODUCTS = COLUMNS**2

# Axes of a table before that of v/v_c, and the columns of the slopes along them and of the misfit.
PARAMETERS = 3
TABLED = (0, 1, 2, 5)

# Rows of the state of each lane.
X, LOW, HIGH, TRIAL, FREE = range(0, 5 * VARIABLES, VARIABLES)
SUMS, NEW_SUMS, FACTOR = range(25, 25 + 3 * PRODUCTS, PRODUCTS)
EXPECTED, DAMPING, HEAVIER, LEFT, CONVERGED, LOWER = range(133, 139)
P, EXPONENT, GAP, LARGEST = range(139, 143)
GRADIENT, CHI_SQUARE, NEW_CHI_SQUARE = SUMS + VARIABLES, SUMS + PRODUCTS - 1, FACTOR - 1
STATE_ROWS = LARGEST + 1
# Taylor series of exp, and that of log(m) = 2 artanh((m - 1)/(m + 1)); the highest powers first.
_EXP = tuple(1.0 / math.factorial(k) for k in range(13, -1, -1))
_LOG = tuple(2.0 / k for k in range(21, 0, -2))
# ln 2 in two parts, the first short, so that its multiples are exact.
_LN2_HIGH, _LN2_LOW = float.fromhex("0x1.62e42feep-1"), float.fromhex("0x1.a39ef35793c76p-33")
# The last bits of a number so much larger hold its integer part.
_SHIFT = 1.5 * 2.0**52
_BITS_OF_ROOT_HALF = int(np.sqrt(0.5).view(np.int64))
_LARGEST = 708.0


_jit = jit()
_jit_contract = jit(fastmath={"contract", "nsz"})
_jit_inline = jit(inline="always")


@_jit_inline
def _exp(x):  # type: ignore[no-untyped-def]
    """e^x, for an x within 708 of 0; one beyond is taken for that bound."""
    x = min(max(x, -_LARGEST), _LARGEST)
    shifted = x * (1.0 / math.log(2.0)) + _SHIFT
    power = shifted - _SHIFT
    rest = (x - power * _LN2_HIGH) - power * _LN2_LOW
    value = _EXP[0]
    for k in range(1, len(_EXP)):
        value = value * rest + _EXP[k]
    return value * np.int64((np.float64(shifted).view(np.int64) + 1023) << 52).view(np.float64)


@_jit_inline
def _log(x):  # type: ignore[no-untyped-def]
    """Ln x of a positive, normal number."""
    bits = np.float64(x).view(np.int64)
    power = (bits - _BITS_OF_ROOT_HALF) >> 52
    mantissa = np.int64(bits - (power << 52)).view(np.float64)
    ratio = (mantissa - 1.0) / (mantissa + 1.0)
    square = ratio * ratio
    value = _LOG[0]
    for k in range(1, len(_LOG)):
        value = value * square + _LOG[k]
    return (power * _LN2_LOW + ratio * value) + power * _LN2_HIGH


@_jit_contract
def enter(data, end, low, high, x, lane, points, state):  # type: ignore[no-untyped-def]
    """Put a search, without data that are missing, on a lane; return its number of points.

    Parameters
    ----------
    data
        Rows of one data set: v, ln v, e, 1/sigma, (``POINT_ROWS``, n).
    end
        End of the range of v_c, in units of v.
    low, high
        Bounds of the variables, (``VARIABLES``,).
    x
        Start, (``VARIABLES``,).
    lane
        Lane that is free.
    points, state
        Points and state of all lanes, (rows, ``LANES``).
    """
    count = 0
    for i in range(data.shape[1]):
        if data[WEIGHT, i] > 0.0:
            for row in range(POINT_ROWS):
                points[POINT_ROWS * count + row, lane] = data[row, i]
            points[POINT_ROWS * count + SPEED, lane] -= end
            count += 1
    for row in range(POINT_ROWS * count, len(points)):
        points[row, lane] = 0.0
    # Without slopes and with an endless sum of squares, the first step is to evaluate the start.
    for row in range(SUMS, SUMS + PRODUCTS):
        state[row, lane] = 0.0
    for i in range(VARIABLES):
        state[X + i, lane], state[LOW + i, lane], state[HIGH + i, lane] = x[i], low[i], high[i]
    state[CHI_SQUARE, lane], state[LEFT, lane] = np.inf, ITERATIONS + 1
    state[DAMPING, lane], state[HEAVIER, lane] = FIRST_DAMPING / LIGHTEN, 2.0
    return count


@_jit_contract
def evaluate(points, groups, state, slopes):  # type: ignore[no-untyped-def]  # noqa: C901, PLR0912
    """Sum the products of slopes and misfits of Eq. (34) at the trial of every lane.

    Parameters
    ----------
    points
        Points of the lanes, (``POINT_ROWS`` n, ``LANES``).
    groups
        Groups of ``GROUP`` points on the longest lane.
    state
        State of the lanes; its new sums are written.
    slopes
        Room for the slopes of a group, (``COLUMNS`` ``GROUP``, ``LANES``).
    """
    if not (points.shape[1] == state.shape[1] == slopes.shape[1] == LANES):
        return  # never: gives the compiler the distance of rows
    for lane in range(LANES):
        state[P, lane] = _exp(state[TRIAL + 1, lane])
        state[EXPONENT, lane] = _exp(state[TRIAL + Q, lane])
        state[GAP, lane] = _exp(state[TRIAL + V_C, lane])
    for row in range(NEW_SUMS, NEW_SUMS + PRODUCTS):
        for lane in range(LANES):
            state[row, lane] = 0.0
    for group in range(groups):
        for k in range(GROUP):
            point, row = POINT_ROWS * (GROUP * group + k), COLUMNS * k
            for lane in range(LANES):
                p, q, gap = state[P, lane], state[EXPONENT, lane], state[GAP, lane]
                excess = points[point + SPEED, lane] + gap
                rebounds = excess > 0.0
                excess = excess if rebounds else 1.0
                fall = points[point + LOG_SPEED, lane] - state[TRIAL, lane]
                rise = _log(excess) - state[TRIAL + 2, lane]
                body = 1.0 / (1.0 + _exp(p * fall))
                kept = 1.0 / (1.0 + _exp(-q * rise))
                kept = kept if rebounds else 0.0
                weight, e = points[point + WEIGHT, lane], body * kept
                loss, taken = weight * e * (1.0 - body) * p, weight * e * (1.0 - kept) * q
                slopes[row, lane], slopes[row + 1, lane] = loss, -loss * fall
                slopes[row + 2, lane], slopes[row + Q, lane] = -taken, taken * rise
                slopes[row + V_C, lane] = taken * gap / excess
                slopes[row + VARIABLES, lane] = (e - points[point + MEASURED, lane]) * weight
        for row in range(COLUMNS):
            for column in range(row, COLUMNS):
                entry = NEW_SUMS + COLUMNS * row + column
                for lane in range(LANES):
                    total = 0.0
                    for k in range(GROUP):
                        left, right = COLUMNS * k + row, COLUMNS * k + column
                        total += slopes[left, lane] * slopes[right, lane]
                    state[entry, lane] += total


@_jit_inline
def _solve(state):  # type: ignore[no-untyped-def]  # noqa: C901, PLR0912
    """Solve the damped normal equations (L D L^T) and propose the step.

    Variables that would leave the box stay. The factor has D L^T above its diagonal, L below.
    """
    for lane in range(LANES):
        state[LARGEST, lane] = 1.0
    for i in range(VARIABLES):
        for lane in range(LANES):
            slope, x = state[GRADIENT + COLUMNS * i, lane], state[X + i, lane]
            below = (x <= state[LOW + i, lane]) & (slope >= 0.0)
            above = (x >= state[HIGH + i, lane]) & (slope <= 0.0)
            free = 0.0 if below | above else 1.0
            state[FREE + i, lane], state[TRIAL + i, lane] = free, -free * slope
            diagonal = free * state[SUMS + (COLUMNS + 1) * i, lane]
            state[LARGEST, lane] = max(state[LARGEST, lane], diagonal)
    for i in range(VARIABLES):
        for j in range(i, VARIABLES):
            entry = COLUMNS * i + j
            for lane in range(LANES):
                both = state[FREE + i, lane] * state[FREE + j, lane]
                state[FACTOR + entry, lane] = both * state[SUMS + entry, lane]
        pivot = FACTOR + (COLUMNS + 1) * i
        for lane in range(LANES):
            state[pivot, lane] *= 1.0 + state[DAMPING, lane]
            state[pivot, lane] += RIDGE * state[LARGEST, lane] + (1.0 - state[FREE + i, lane])
    for k in range(VARIABLES):
        pivot = FACTOR + (COLUMNS + 1) * k
        for lane in range(LANES):
            state[pivot, lane] = 1.0 / state[pivot, lane]
        for i in range(k + 1, VARIABLES):
            above, below = FACTOR + COLUMNS * k + i, FACTOR + COLUMNS * i + k
            for lane in range(LANES):
                state[below, lane] = state[above, lane] * state[pivot, lane]
                state[TRIAL + i, lane] -= state[below, lane] * state[TRIAL + k, lane]
            for j in range(i, VARIABLES):
                entry, upper = FACTOR + COLUMNS * i + j, FACTOR + COLUMNS * k + j
                for lane in range(LANES):
                    state[entry, lane] -= state[below, lane] * state[upper, lane]
    for i in range(VARIABLES):
        for lane in range(LANES):
            state[TRIAL + i, lane] *= state[FACTOR + (COLUMNS + 1) * i, lane]
    for i in range(VARIABLES - 1, 0, -1):
        for j in range(i):
            for lane in range(LANES):
                share = state[FACTOR + COLUMNS * i + j, lane]
                state[TRIAL + j, lane] -= share * state[TRIAL + i, lane]


@_jit_contract
def _propose(state, stride):  # type: ignore[no-untyped-def]
    """Propose a damped step within the box, and write its expected decrease."""
    if state.shape[1] != LANES:
        return  # never
    _solve(state)
    for lane in range(LANES):
        state[EXPECTED, lane] = 0.0
    for i in range(VARIABLES):
        for lane in range(LANES):
            x, step = state[X + i, lane], state[TRIAL + i, lane]
            step = min(max(step, -stride[i]), stride[i])
            step = min(max(step, state[LOW + i, lane] - x), state[HIGH + i, lane] - x)
            state[TRIAL + i, lane] = step
            slope = 2.0 * state[GRADIENT + COLUMNS * i, lane]
            slope += state[SUMS + (COLUMNS + 1) * i, lane] * step
            state[EXPECTED, lane] -= slope * step
        for j in range(i):
            for lane in range(LANES):
                both = state[TRIAL + i, lane] * state[TRIAL + j, lane]
                state[EXPECTED, lane] -= 2.0 * state[SUMS + COLUMNS * j + i, lane] * both
    for i in range(VARIABLES):
        for lane in range(LANES):
            trial = state[X + i, lane] + state[TRIAL + i, lane]
            trial = min(max(trial, state[LOW + i, lane]), state[HIGH + i, lane])
            state[TRIAL + i, lane] = trial


@_jit_contract
def _judge(state, tolerance):  # type: ignore[no-untyped-def]
    """Move to the trial where it is lower, change the damping (Nielsen), see which have ended."""
    if state.shape[1] != LANES:
        return  # never
    for lane in range(LANES):
        expected, damping = state[EXPECTED, lane], state[DAMPING, lane]
        decrease = state[CHI_SQUARE, lane] - state[NEW_CHI_SQUARE, lane]
        small = tolerance * state[NEW_CHI_SQUARE, lane]
        # Of either sign, so that rounding does not keep a search at its minimum from ending.
        flat = (abs(decrease) <= small) & (abs(expected) <= small) & (damping < LIGHT_DAMPING)
        ended = flat | (damping > STUCK)
        ended |= state[NEW_CHI_SQUARE, lane] == 0.0
        state[CONVERGED, lane] = 1.0 if ended else 0.0
        state[LEFT, lane] = 0.0 if ended else state[LEFT, lane] - 1.0
        lower, heavier = decrease >= 0.0, state[HEAVIER, lane]
        state[LOWER, lane] = 1.0 if lower else 0.0
        excess = 2.0 * decrease / expected - 1.0 if expected > 0.0 else 1.0
        lighter = max(1.0 - excess * excess * excess, LIGHTEN)
        state[DAMPING, lane] = max(damping * (lighter if lower else heavier), LEAST_DAMPING)
        state[HEAVIER, lane] = 2.0 if lower else 2.0 * heavier
    for old, new, rows in ((X, TRIAL, VARIABLES), (SUMS, NEW_SUMS, PRODUCTS)):
        for i in range(rows):
            for lane in range(LANES):
                lower = state[LOWER, lane] > 0.0
                state[old + i, lane] = state[new + i, lane] if lower else state[old + i, lane]


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
            product = weights[0, 0, n] * weights[1, 0, p]
            for m in range(high - low):
                e = a * first[m] + b * second[m] + c * third[m] + d * fourth[m]
                across = a_slope * first[m] + b_slope * second[m]
                across += c_slope * third[m] + d_slope * fourth[m]
                by_rate[m] += rate * e
                by_one[m] += along * e
                by_two[m] += product * across
                value[m] += product * e


@_jit
def curves(grid, places, at, e) -> None:  # type: ignore[no-untyped-def]
    """Put restitutions by the table of a law.

    Parameters
    ----------
    grid
        Table, (three axes of parameters, v/v_c).
    places
        Positions along the axis of v/v_c, (m, n); negative if captured.
    at
        Positions along the axes of parameters, (m, 3).
    e
        Room for the restitutions, (m, n).
    """
    size, many = grid.shape[PARAMETERS], e.shape[1]
    near, ratios, lines = np.empty(many, np.intp), np.empty((many, 4)), np.empty((4, size))
    weights = np.zeros((PARAMETERS, 2, 4))
    for row in range(len(e)):
        low, high = _ratios(places[row], size, near, ratios, lines[0])
        _lines(grid, at[row], low, high, weights, lines)
        for n in range(many):
            e[row, n] = 0.0
            if near[n] >= 0:
                for k in range(4):
                    e[row, n] += ratios[n, k] * lines[3, near[n] + k]


@_jit
def _tabled(grid, points, count, lane, ends, near, ratios, lines, weights, sums, state) -> None:  # type: ignore[no-untyped-def]
    """Put sums as `evaluate` does, of a table, on one lane; ``lines`` to ``sums`` are room."""
    _lines(grid, state[TRIAL : TRIAL + PARAMETERS, lane], ends[0], ends[1], weights, lines)
    sums[:] = 0.0
    for n in range(count):
        point = POINT_ROWS * n
        weight, misfit = points[point + WEIGHT, lane], -points[point + MEASURED, lane]
        by_rate = by_one = by_two = 0.0
        if near[n] >= 0:
            for k in range(4):
                share, node = ratios[n, k], near[n] + k
                by_rate += share * lines[0, node]
                by_one += share * lines[1, node]
                by_two += share * lines[2, node]
                misfit += share * lines[3, node]
        derivatives = (weight * by_rate, weight * by_one, weight * by_two, weight * misfit)
        for i in range(PARAMETERS + 1):
            for j in range(i, PARAMETERS + 1):
                sums[i, j] += derivatives[i] * derivatives[j]
    for i in range(PARAMETERS + 1):
        for j in range(i, PARAMETERS + 1):
            state[NEW_SUMS + COLUMNS * TABLED[i] + TABLED[j], lane] = sums[i, j]


@_jit
def descend_all(  # type: ignore[no-untyped-def]  # noqa: C901, PLR0912
    grid, data, owner, end, low, high, stride, tolerance, x, chi_square, converged
):
    """Move every start to its minimum.

    Parameters
    ----------
    grid
        Table of a law of contact, or of size 0 for Eq. (34).
    data
        Points of the data sets, (r, ``POINT_ROWS``, n).
    owner
        Number of the data set of each search, (m,).
    end
        End of the range of v_c, (m,).
    low, high
        Bounds of the variables, (m, ``VARIABLES``).
    stride
        Largest change of each variable in one step, (``VARIABLES``,).
    tolerance
        Share of chi-square by which a last step lowers it.
    x
        Starts, (m, ``VARIABLES``); the minima are put there.
    chi_square, converged
        Room for the sums of squares and whether a search ended by its tolerance, (m,).
    """
    many, size = data.shape[2], grid.shape[PARAMETERS]
    points = np.zeros((POINT_ROWS * GROUP * -(-many // GROUP), LANES))
    state, slopes = np.zeros((STATE_ROWS, LANES)), np.zeros((COLUMNS * GROUP, LANES))
    running, count = np.zeros(LANES, np.intp) - 1, np.zeros(LANES, np.intp)
    ends, near = np.zeros((LANES, 2), np.intp), np.empty((LANES, many), np.intp)
    ratios, lines = np.empty((LANES, many, 4)), np.empty((PARAMETERS + 1, size))
    weights, sums = np.zeros((PARAMETERS, 2, 4)), np.empty((PARAMETERS + 1, PARAMETERS + 1))
    begun = ended = 0
    while ended < len(x):
        _propose(state, stride)
        if size:
            for lane in range(LANES):
                if running[lane] >= 0:
                    _tabled(
                        grid,
                        points,
                        count[lane],
                        lane,
                        ends[lane],
                        near[lane],
                        ratios[lane],
                        lines,
                        weights,
                        sums,
                        state,
                    )
        else:
            evaluate(points, -(-count.max() // GROUP), state, slopes)
        _judge(state, tolerance)
        for lane in range(LANES):
            if state[LEFT, lane] > 0.0:
                continue
            if running[lane] >= 0:
                done = running[lane]
                for i in range(VARIABLES):
                    x[done, i] = state[X + i, lane]
                chi_square[done], converged[done] = state[CHI_SQUARE, lane], state[CONVERGED, lane]
                ended += 1
                running[lane] = -1
            if begun < len(x):
                i = begun % owner.size
                box = low[i], high[i]
                count[lane] = enter(data[owner[i]], end[i], *box, x[begun], lane, points, state)
                if size:
                    places = points[SPEED : POINT_ROWS * count[lane] : POINT_ROWS, lane]
                    ends[lane] = _ratios(places, size, near[lane], ratios[lane], weights[0, 0])
                running[lane] = begun
                begun += 1


# Variables of a search under scatter: four of the curve, and logarithms of factors of the standard
# deviations of e and of the diameter. Rows of its data: ln v, ln of the diameter over the
# reference, standard deviations of both, e and its standard deviation.
LN_SIGMA, LN_SIZE, SCATTERED = 4, 5, 6
LN_V, LN_D, SPEED_SD, SIZE_SD, REBOUND, E_SD = range(6)
# Nodes reach so many standard deviations. Per standard deviation of e there are so many of
# sqrt(ln v/v_c), with which e grows about as fast. A scatter below the least is none.
REACH, DENSITY, FEWEST_NODES, MOST_NODES, LEAST_SCATTER = 4.0, 0.75, 8, 400, 1e-3
# Columns of a table after those of v/v_c: the exponent of v_c in 1/d; places along the first axis
# per ln d; exponent in d of the adhesion damping at v_c, in units of the contact.
BY_SIZE, SHIFT, GROWTH = 3, 1, 2
# Second axis of a law with adhesion damping: the damping over its distance from overdamping.
DAMPING_AXIS = (1e-3, 30.0, 28)
# Diameters at which a table is read for a class; e is the cubic in ln d through them. The steps by
# which ln d reaches farther.
SIZES, STEP_OF_SIZE = 4, 0.1
# A search ends where the deviance falls by less.
SMALL_FALL, SCATTERED_STEPS = 1e-2, 60
_ROOT_TWO, _LN_ROOT_TWO_PI = math.sqrt(2.0), 0.5 * math.log(2.0 * math.pi)


@_jit
def _below(u):  # type: ignore[no-untyped-def]
    """Logarithm of the normal distribution function, and its slope."""
    if u < -25.0:
        return -0.5 * u * u - math.log(-u) - _LN_ROOT_TWO_PI, -u
    log = math.log(0.5 * math.erfc(-u / _ROOT_TWO))
    return log, math.exp(-0.5 * u * u - _LN_ROOT_TWO_PI - log)


@_jit
def _damped(position, growth):  # type: ignore[no-untyped-def]
    """Position on its axis of an adhesion damping e^growth times as large, and slopes in both."""
    least, largest, count = DAMPING_AXIS
    step = math.log(largest / least) / (count - 1.0)
    ratio = least * math.exp(position * step)
    share = ratio / (1.0 + ratio) * math.exp(growth)
    if share >= largest / (1.0 + largest):
        return count - 1.0, 0.0, 0.0
    new = share / (1.0 - share)
    if new <= least:
        return 0.0, 0.0, 0.0
    return math.log(new / least) / step, (1.0 + new) / (1.0 + ratio), (1.0 + new) / step


@_jit
def _sized(grid, z, reach, weights, lines, sized) -> None:  # type: ignore[no-untyped-def]
    """Put slopes in the variables and e of four diameters, ln d within ``reach`` (4, 4, ratios).

    A smaller sphere has its own v_c, and damping groups of its own: another place in the table.
    ``lines`` are those of the median sphere.
    """
    size, at = sized.shape[2], z[:PARAMETERS].copy()
    last = grid.shape[1] - 1.0
    for n in range(SIZES):
        log_d = reach * (2.0 * n / (SIZES - 1.0) - 1.0)
        shifted = z[1] + lines[PARAMETERS, size + SHIFT] * log_d
        at[1], by_one = min(max(shifted, 0.0), last), 1.0 if 0.0 < shifted < last else 0.0
        at[2], by_two, by_growth = z[2], 1.0, 0.0
        if grid.shape[2] > 1:
            at[2], by_two, by_growth = _damped(z[2], lines[PARAMETERS, size + GROWTH] * log_d)
        _lines(grid, at, 0, size, weights, sized[n])
        for m in range(size):
            first, second = sized[n, 1, m] * by_one, sized[n, 2, m]
            sized[n, 1, m], sized[n, 2, m] = first, second * by_two
            second *= by_growth
            for k in range(PARAMETERS):
                moved = first * lines[k, size + SHIFT] + second * lines[k, size + GROWTH]
                sized[n, k, m] += log_d * moved


@_jit
def _mixed(sized, reach, scale, x, log_d, rate, share, center, low, high, weights, lines):  # type: ignore[no-untyped-def]
    """Put slopes and e where ln d goes with ln(v/v_c): ``log_d`` at x, with slope ``rate``.

    Returns the slope of e in ln d at x.

    The last row of ``lines`` is the slope in the scatter of sizes, to which ``share`` of the
    variance is due; ``center`` are the lines of the median sphere, and ``weights`` (2, 4) is room.
    """
    size, steps = sized.shape[2], SIZES - 1.0
    last = min(int(high * scale) + SIZES, size)
    exponent, middle, slope = center[PARAMETERS, size], math.sqrt(max(x, 0.0)) * scale, 0.0
    for m in range(min(max(int(low * scale) - 1, 0), size - SIZES), last):
        off = (m / scale) ** 2 - x
        t = min(max(0.5 * steps * ((log_d + rate * off) / reach + 1.0), 0.0), steps)
        _cubic(t, SIZES, weights[0], weights[1])
        by_log_d = 0.0
        lines[: PARAMETERS + 1, m] = 0.0
        for n in range(SIZES):
            by_log_d += weights[1, n] * sized[n, PARAMETERS, m]
            for k in range(PARAMETERS + 1):
                lines[k, m] += weights[0, n] * sized[n, k, m]
        by_log_d *= 0.5 * steps / reach
        slope = by_log_d if m <= middle else slope
        by_log_d *= rate
        by_exponent = by_log_d * ((1.0 - 2.0 * share) * off / exponent - log_d)
        for k in range(PARAMETERS):
            lines[k, m] += by_exponent * center[k, size]
        lines[PARAMETERS + 1, m] = 2.0 * by_log_d * (1.0 - share) * off
    return slope


@_jit
def _curve(lines, size, scale, v_c, log_v_c, z, p, q, y, slopes, j):  # type: ignore[no-untyped-def]
    """E at y = sqrt(ln v/v_c), and its slopes in the first four variables.

    Of a table the fourth is that in the scatter of sizes.
    """
    if size:
        position = min(y * scale, size - 1.0)
        first = min(max(int(position) - 1, 0), size - 4)
        t = position - first
        a, b, c = t - 1.0, t - 2.0, t - 3.0
        first_share, second_share = -a * b * c / 6.0, t * b * c / 2.0
        third_share, fourth_share = -t * a * c / 2.0, t * a * b / 6.0
        for k in range(PARAMETERS):
            line = lines[k]
            slope = first_share * line[first] + second_share * line[first + 1]
            slopes[j, k] = slope + third_share * line[first + 2] + fourth_share * line[first + 3]
        line = lines[PARAMETERS + 1]
        slope = first_share * line[first] + second_share * line[first + 1]
        slopes[j, Q] = slope + third_share * line[first + 2] + fourth_share * line[first + 3]
        line = lines[PARAMETERS]
        e = first_share * line[first] + second_share * line[first + 1]
        return e + third_share * line[first + 2] + fourth_share * line[first + 3]
    fall = log_v_c + y * y - z[0]
    rise = math.log(v_c * math.expm1(y * y)) - z[2]
    body, kept = 1.0 / (1.0 + math.exp(p * fall)), 1.0 / (1.0 + math.exp(-q * rise))
    e = body * kept
    loss, taken = e * (1.0 - body) * p, e * (1.0 - kept) * q
    slopes[j, 0], slopes[j, 1], slopes[j, 2], slopes[j, Q] = (
        loss,
        -loss * fall,
        -taken,
        taken * rise,
    )
    return e


@_jit
def deviance(grid, scale, data, v_c, z, gradient, information, expected):  # type: ignore[no-untyped-def]  # noqa: C901, PLR0912, PLR0915
    """Minus twice the logarithm of the likelihood of one data set (6, n) under scatter.

    e of a rebound is averaged over ln(v/v_c), normal about the measured one and above 0, with the
    damping groups of the mean diameter at that v/v_c; what diameters scatter about that mean widens
    the standard deviation of e. Without captured spheres all rebounds are taken given that they
    are; else captures count as well.

    Parameters
    ----------
    grid
        Table with the columns ``BY_SIZE`` after those of v/v_c; for Eq. (34) these are all.
    scale
        Places of the table per square root of ln(v/v_c).
    data
        Rows of one data set, (6, n).
    v_c
        Capture velocity of the median sphere, in the unit of the speeds.
    z
        Variables, (6,).
    gradient, information
        Room for the slopes, (6,), and Fisher's information by the first two moments, (6, 6).
    expected
        Room for mean and variance of e, (n, 2).
    """
    size, count = grid.shape[PARAMETERS] - BY_SIZE, data.shape[1]
    lines, weights = np.zeros((PARAMETERS + 2, size + BY_SIZE)), np.zeros((PARAMETERS, 2, 4))
    if size:
        _lines(grid, z[:PARAMETERS], 0, size + BY_SIZE, weights, lines[: PARAMETERS + 1])
    else:
        lines[PARAMETERS, 0] = grid[0, 0, 0, 0]
    reach, size_factor = 0.0, math.exp(z[LN_SIZE])
    for i in range(count):
        relative = data[SIZE_SD, i] * size_factor
        reach = max(reach, abs(data[LN_D, i]) + REACH * relative)
    # In steps, for the slopes are those at given diameters.
    reach = STEP_OF_SIZE * math.ceil(reach / STEP_OF_SIZE)
    shift, growth = lines[PARAMETERS, size + SHIFT], lines[PARAMETERS, size + GROWTH]
    similar = reach == 0.0 or (shift == 0.0 and growth == 0.0)
    sphere, sized = lines, np.empty((SIZES, PARAMETERS + 1, 0 if similar else size))
    if not similar:
        sphere = lines.copy()
        _sized(grid, z, reach, weights, lines, sized)
    e, slopes = np.empty(MOST_NODES), np.empty((MOST_NODES, Q + 1))
    away, prior = np.empty(MOST_NODES), np.empty(MOST_NODES)
    mean, by_curve = np.empty(Q + 1), np.empty(Q + 1)
    moved, spread = np.empty(SCATTERED), np.empty(SCATTERED)
    exponent, log_v_c = lines[PARAMETERS, size], math.log(v_c)
    p, q = math.exp(z[1]), math.exp(z[Q])
    joint = False
    for i in range(count):
        joint |= data[REBOUND, i] == 0.0
    total = 0.0
    gradient[:], information[:], expected[:] = 0.0, 0.0, 0.0
    for i in range(count):
        relative = data[SIZE_SD, i] * size_factor
        by_size = exponent * relative
        s = math.sqrt(data[SPEED_SD, i] ** 2 + by_size**2 + LEAST_SCATTER**2)
        x = data[LN_V, i] - log_v_c + exponent * data[LN_D, i]
        # How the middle and the width of ln(v/v_c) depend on the variables.
        moved[:], spread[:] = 0.0, 0.0
        for k in range(PARAMETERS):
            moved[k] = lines[k, size] * data[LN_D, i]
            spread[k] = lines[k, size] * relative * by_size / s
        spread[LN_SIZE] = by_size**2 / s
        if data[REBOUND, i] == 0.0:
            log, slope = _below(-x / s)
            total -= 2.0 * log
            for k in range(SCATTERED):
                gradient[k] += 2.0 * slope * (moved[k] / s - x * spread[k] / s**2)
            continue
        # Shares of variances: that of e alone in that of e, that of sizes in that of ln(v/v_c).
        sigma, of_e, of_size = data[E_SD, i] * math.exp(z[LN_SIGMA]), 1.0, (by_size / s) ** 2
        low = math.sqrt(max(x - REACH * s, 0.0))
        high = math.sqrt(x + math.sqrt(min(x, 0.0) ** 2 + (REACH * s) ** 2))
        if not similar:
            rate = relative * by_size / s**2
            log_d, room = data[LN_D, i], weights[0]
            slope = _mixed(
                sized, reach, scale, x, log_d, rate, of_size, lines, low, high, room, sphere
            )
            rest = (slope * relative) ** 2 * (1.0 - of_size)
            of_e = sigma**2 / (sigma**2 + rest)
            sigma = math.sqrt(sigma**2 + rest)
        nodes = min(max(int(DENSITY * (high - low) / sigma), FEWEST_NODES), MOST_NODES)
        step = (high - low) / nodes
        top = least = -np.inf
        for j in range(nodes):
            y = low + (j + 0.5) * step
            e[j] = _curve(sphere, size, scale, v_c, log_v_c, z, p, q, y, slopes, j)
            away[j] = (y * y - x) / s
            prior[j] = math.log(2.0 * y) - 0.5 * away[j] ** 2
            least = max(least, prior[j])
            top = max(top, prior[j] - 0.5 * ((data[REBOUND, i] - e[j]) / sigma) ** 2)
        likely = all_prior = first = second = misfit = middle = square = 0.0
        mean[:], by_curve[:] = 0.0, 0.0
        for j in range(nodes):
            share = math.exp(prior[j] - least)
            all_prior += share
            first += share * e[j]
            second += share * e[j] ** 2
            for k in range(Q + 1):
                mean[k] += share * slopes[j, k]
            missed = (data[REBOUND, i] - e[j]) / sigma
            share = math.exp(prior[j] - 0.5 * missed**2 - top)
            likely += share
            misfit += share * missed**2
            middle += share * away[j]
            square += share * away[j] ** 2
            share *= missed / sigma
            for k in range(Q + 1):
                by_curve[k] += share * slopes[j, k]
        total -= 2.0 * (math.log(likely * step / s) + top - _LN_ROOT_TWO_PI - z[LN_SIGMA])
        total -= math.log(of_e)
        along, across = middle / likely / s, (square / likely - 1.0) / s
        if not joint:
            log, slope = _below(x / s)
            total += 2.0 * log
            along -= slope / s
            across += slope * x / s**2
        for k in range(Q + 1):
            gradient[LN_SIZE if size and k == Q else k] -= 2.0 * by_curve[k] / likely
        gradient[LN_SIGMA] -= 2.0 * of_e * (misfit / likely - 1.0)
        gradient[LN_SIZE] -= 2.0 * (1.0 - of_e) * (1.0 - of_size) * (misfit / likely - 1.0)
        for k in range(SCATTERED):
            gradient[k] -= 2.0 * (along * moved[k] + across * spread[k])
        first /= all_prior
        wide = max(second / all_prior - first**2, 0.0)
        variance = wide + sigma**2
        expected[i, 0], expected[i, 1] = first, variance
        by_sigma, by_size = 2.0 * of_e * sigma**2, 2.0 * wide * spread[LN_SIZE] / s
        for k in range(Q + 1):
            for m in range(Q + 1):
                information[k, m] += mean[k] * mean[m] / all_prior**2 / variance
        information[LN_SIGMA, LN_SIGMA] += 0.5 * (by_sigma / variance) ** 2
        information[LN_SIZE, LN_SIZE] += 0.5 * (by_size / variance) ** 2
        information[LN_SIGMA, LN_SIZE] += 0.5 * by_sigma * by_size / variance**2
        information[LN_SIZE, LN_SIGMA] += 0.5 * by_sigma * by_size / variance**2
    return total


@_jit
def descend_scattered(grid, scale, data, owner, v_c, low, high, stride, tried, starts, least, x):  # type: ignore[no-untyped-def]  # noqa: C901, PLR0912
    """Put the least `deviance` and its variables, from the best of several starts.

    Parameters
    ----------
    grid, scale
        As of `deviance`.
    data
        Rows of the data sets, (r, 6, n).
    owner
        Number of the data set of each search, (m,).
    v_c
        Capture velocities held, in the unit of the speeds, (m,).
    low, high, stride
        Bounds of the variables and their largest change in one step, (6,).
    tried
        How many of the starts are followed.
    starts
        Starts, (s, m, 6).
    least, x
        Room for the least deviances, (m,), and their variables, (m, 6).
    """
    values, many = np.empty(len(starts)), data.shape[2]
    gradient, fresh = np.empty(SCATTERED), np.empty(SCATTERED)
    information, new = np.empty((SCATTERED, SCATTERED)), np.empty((SCATTERED, SCATTERED))
    expected = np.empty((many, 2))
    for m in range(len(owner)):
        rows, least[m] = data[owner[m]], np.inf
        for i in range(len(starts)):
            values[i] = deviance(
                grid, scale, rows, v_c[m], starts[i, m], gradient, information, expected
            )
        for _ in range(tried):
            begun = np.argmin(values)
            values[begun] = np.inf
            z = np.minimum(np.maximum(starts[begun, m], low), high)
            value = deviance(grid, scale, rows, v_c[m], z, gradient, information, expected)
            damping = FIRST_DAMPING
            for _ in range(SCATTERED_STEPS):
                matrix, right = information.copy(), -0.5 * gradient
                for k in range(SCATTERED):
                    out = (z[k] <= low[k] and gradient[k] >= 0.0) or (
                        z[k] >= high[k] and gradient[k] <= 0.0
                    )
                    if out:
                        matrix[k, :], matrix[:, k], right[k] = 0.0, 0.0, 0.0
                        matrix[k, k] = 1.0
                    matrix[k, k] = matrix[k, k] * (1.0 + damping) + 1e-9
                step = np.linalg.solve(matrix, right)
                trial = z + np.minimum(np.maximum(step, -stride), stride)
                trial = np.minimum(np.maximum(trial, low), high)
                lower = deviance(grid, scale, rows, v_c[m], trial, fresh, new, expected)
                if lower <= value:
                    fall, value = value - lower, lower
                    z[:], gradient[:], information[:] = trial, fresh, new
                    if fall < SMALL_FALL:
                        break
                    damping = max(damping * LIGHTEN, LEAST_DAMPING)
                else:
                    damping *= 4.0
                    if damping > 1e4:
                        break
            if value < least[m]:
                least[m], x[m] = value, z
