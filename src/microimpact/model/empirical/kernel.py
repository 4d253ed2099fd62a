"""Compiled curves of the laws of contact, by their tables, and likelihoods under scatter.

A table has e over three parameters and v/v_c; between its places e is the cubic through the four
nearest of each axis.
"""

from __future__ import annotations

import math

import numpy as np

from microimpact.core.compiled import jit

# Places of q among the variables ln(k, p, kappa, q, gap) of Eq. (34), and of the last, which stands
# for v_c.
Q, V_C, VARIABLES = 3, 4, 5
# Axes of a table before that of v/v_c, and its columns after those of v/v_c: the exponent of v_c in
# 1/d; places along the first axis per ln d; exponent in d of the adhesion damping at v_c, in units
# of the contact.
PARAMETERS = 3
BY_SIZE, SHIFT, GROWTH = 3, 1, 2

_jit = jit()
_jit_contract = jit(fastmath={"contract", "nsz"})


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
def curves(grid, places, at, rows) -> None:  # type: ignore[no-untyped-def]
    """Put restitutions by the table of a law, and their slopes along the axes of parameters.

    Parameters
    ----------
    grid
        Table, (three axes of parameters, v/v_c and ``BY_SIZE`` more columns).
    places
        Positions along the axis of v/v_c, (m, n); negative if captured.
    at
        Positions along the axes of parameters, (m, 3 or more).
    rows
        Room for three slopes and e, (m, n, 4).
    """
    size, many = grid.shape[PARAMETERS] - BY_SIZE, places.shape[1]
    near, ratios, unused = np.empty(many, np.intp), np.empty((many, 4)), np.empty(4)
    lines, weights = np.empty((PARAMETERS + 1, size)), np.zeros((PARAMETERS, 2, 4))
    rows[:] = 0.0
    for row in range(len(places)):
        low, high = size, 0
        for n in range(many):
            if places[row, n] >= 0.0:
                near[n] = _cubic(places[row, n], size, ratios[n], unused)
                low, high = min(low, near[n]), max(high, near[n] + 4)
        _lines(grid, at[row], low, high, weights, lines)
        for n in range(many):
            if places[row, n] >= 0.0:
                for k in range(4):
                    for line in range(PARAMETERS + 1):
                        rows[row, n, line] += ratios[n, k] * lines[line, near[n] + k]


@_jit
def _log_variance(missed, count, nu, least):  # type: ignore[no-untyped-def]
    """Logarithm of the likeliest squared scale of Student's t, at least ``least`` squared."""
    total = 0.0
    for each in missed:
        total += each**2
    # The sum of weighted squares falls as the scale grows: Newton's method between bounds.
    low = u = 2.0 * math.log(least)
    high = max(math.log(max((nu + 1.0) * total / (nu * count), 1e-300)), low)
    for _ in range(100):
        excess, slope = -count, 0.0
        for each in missed:
            z = each**2 * math.exp(-u)
            excess += (nu + 1.0) * z / (nu + z)
            slope += (nu + 1.0) * nu * z / (nu + z) ** 2
        if excess <= 0.0 and u == low:
            return u
        low, high = (u, high) if excess > 0.0 else (low, u)
        new = u + excess / max(slope, 1e-300)
        new = new if low < new < high else 0.5 * (low + high)
        if abs(new - u) < 1e-10:
            return new
        u = new
    return u


@_jit
def heavy_tails(missed, count, freedoms, least, student, weights):  # type: ignore[no-untyped-def]
    """Put the likeliest scale and freedom of Student's t of residuals, and their weights.

    Parameters
    ----------
    missed
        Residuals over sigma, (m, n).
    count
        Number of rebounds among them, (m,): captured spheres have no density of e.
    freedoms
        Degrees of freedom to choose from, and what -2 ln of the density has beside that of a
        normal one, by datum, (k, 2).
    least
        Least scale.
    student
        Room for the deviance, the scale and its freedom, (m, 3).
    weights
        Room for the weights of the squares of residuals, (m, n).
    """
    for m in range(len(missed)):
        student[m, 0] = np.inf
        for k in range(len(freedoms)):
            nu = freedoms[k, 0]
            u = _log_variance(missed[m], count[m], nu, least)
            deviance = count[m] * (u + freedoms[k, 1])
            for each in missed[m]:
                deviance += (nu + 1.0) * math.log1p(each**2 * math.exp(-u) / nu)
            if deviance < student[m, 0]:
                student[m, 0], student[m, 1], student[m, 2] = deviance, math.exp(0.5 * u), nu
        for i in range(missed.shape[1]):
            square = student[m, 2] * student[m, 1] ** 2 + missed[m, i] ** 2
            weights[m, i] = (student[m, 2] + 1.0) / square


# Variables of a search under scatter: four of the curve, logarithms of factors of the standard
# deviations of e and of the diameter, and degrees of freedom of e, 0 if it is normal. Rows of its
# data: ln v, ln of the diameter over the reference, standard deviations of both, number of
# measurements, e and its standard deviation.
LN_SIGMA, LN_SIZE, FREEDOM, SCATTERED = 4, 5, 6, 7
LN_V, LN_D, SPEED_SD, SIZE_SD, NUMBER, REBOUND, E_SD = range(7)
# Standard deviations that nodes reach; nodes of sqrt(ln v/v_c), with which e grows at most about as
# fast, per standard deviation of e; their numbers; and the scatter below which there is none.
REACH, DENSITY, FEWEST_NODES, MOST_NODES, LEAST_SCATTER = 4.0, 0.75, 8, 400, 1e-3
# Second axis of a law with adhesion damping: the damping over its distance from overdamping.
DAMPING_AXIS = (1e-3, 30.0, 28)
# Diameters at which a table is read for a class; e is the cubic in ln d through them. The steps by
# which ln d reaches farther.
SIZES, STEP_OF_SIZE = 4, 0.1
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
def _steepest(lines, size, scale, v_c, log_v_c, z, p, q, low, high, slopes):  # type: ignore[no-untyped-def]
    """Largest slope of e in y = sqrt(ln v/v_c), from one y to another; 1 at most, and at capture.

    Of Eq. (34) it is that of three values.
    """
    if low <= 0.0:
        return 1.0
    steepest = 0.0
    if size:
        first, last = min(int(low * scale), size - 1), min(int(high * scale) + 1, size - 1)
        for m in range(first, last):
            steepest = max(steepest, abs(lines[PARAMETERS, m + 1] - lines[PARAMETERS, m]))
        return min(steepest * scale, 1.0)
    for n in range(3):
        y = low + 0.5 * n * (high - low)
        _curve(lines, size, scale, v_c, log_v_c, z, p, q, y, slopes, 0)
        gained = 2.0 * y * slopes[0, 2] / math.expm1(-y * y)
        steepest = max(steepest, gained, 2.0 * y * slopes[0, 0])
    return min(steepest, 1.0)


@_jit
def deviance(grid, scale, data, v_c, z, gradient, information, expected):  # type: ignore[no-untyped-def]  # noqa: C901, PLR0912, PLR0915
    """Minus twice the logarithm of the likelihood of one data set (7, n) under scatter.

    The density of e of a rebound, normal or Student's, is averaged over ln(v/v_c), normal about the
    measured one and above 0, with the damping groups of the mean diameter at that v/v_c; what
    diameters scatter about that mean widens the scale of e. Without captured spheres all rebounds
    are taken given that they are; else captures count as well.

    Parameters
    ----------
    grid
        Table with the columns ``BY_SIZE`` after those of v/v_c; for Eq. (34) these are all.
    scale
        Places of the table per square root of ln(v/v_c).
    data
        Rows of one data set, (7, n).
    v_c
        Capture velocity of the median sphere, in the unit of the speeds.
    z
        Variables, (7,); there is no slope in the degrees of freedom.
    gradient, information
        Room for the slopes, (7,), and Fisher's information by the first two moments, (7, 7).
    expected
        Room for mean and variance of e, (n, 2); Student's t counts by its scale.
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
    away, prior, fit = np.empty(MOST_NODES), np.empty(MOST_NODES), np.empty(MOST_NODES)
    mean, by_curve = np.empty(Q + 1), np.empty(Q + 1)
    moved, spread = np.empty(SCATTERED), np.empty(SCATTERED)
    exponent, log_v_c = lines[PARAMETERS, size], math.log(v_c)
    p, q = math.exp(z[1]), math.exp(z[Q])
    joint = False
    for i in range(count):
        joint |= data[REBOUND, i] == 0.0
    # Of Student's t: -2 ln of its factor over that of a normal density; the variance that its
    # information is the inverse of; and its peak is sharper.
    nu, factor, loose, density = z[FREEDOM], 0.0, 1.0, DENSITY
    if nu > 0.0:
        factor = 2.0 * (math.lgamma(0.5 * nu) - math.lgamma(0.5 * nu + 0.5)) + math.log(0.5 * nu)
        loose, density = (nu + 3.0) / (nu + 1.0), DENSITY * (1.0 + 2.0 / nu)
    total = 0.0
    gradient[:], information[:], expected[:] = 0.0, 0.0, 0.0
    for i in range(count):
        number, relative = data[NUMBER, i], data[SIZE_SD, i] * size_factor
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
            total -= 2.0 * number * log
            for k in range(SCATTERED):
                gradient[k] += 2.0 * number * slope * (moved[k] / s - x * spread[k] / s**2)
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
        steepest = _steepest(sphere, size, scale, v_c, log_v_c, z, p, q, low, high, slopes)
        # So that the product of both densities is resolved.
        wanted = math.hypot(FEWEST_NODES, density * steepest * (high - low) / sigma)
        nodes = min(int(wanted), MOST_NODES)
        step = (high - low) / nodes
        top = least = -np.inf
        for j in range(nodes):
            y = low + (j + 0.5) * step
            e[j] = _curve(sphere, size, scale, v_c, log_v_c, z, p, q, y, slopes, j)
            away[j] = (y * y - x) / s
            prior[j] = math.log(2.0 * y) - 0.5 * away[j] ** 2
            least = max(least, prior[j])
            square = ((data[REBOUND, i] - e[j]) / sigma) ** 2
            log = 0.5 * (nu + 1.0) * math.log1p(square / nu) if nu > 0.0 else 0.5 * square
            fit[j] = prior[j] - log
            top = max(top, fit[j])
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
            share = math.exp(fit[j] - top)
            likely += share
            middle += share * away[j]
            square += share * away[j] ** 2
            share *= missed * ((nu + 1.0) / (nu + missed**2) if nu > 0.0 else 1.0)
            misfit += share * missed
            share /= sigma
            for k in range(Q + 1):
                by_curve[k] += share * slopes[j, k]
        log = math.log(likely * step / s) + top - _LN_ROOT_TWO_PI - z[LN_SIGMA]
        total -= number * (2.0 * log - factor + math.log(of_e))
        along, across = middle / likely / s, (square / likely - 1.0) / s
        if not joint:
            log, slope = _below(x / s)
            total += 2.0 * number * log
            along -= slope / s
            across += slope * x / s**2
        for k in range(Q + 1):
            gradient[LN_SIZE if size and k == Q else k] -= 2.0 * number * by_curve[k] / likely
        misfit = 2.0 * number * (misfit / likely - 1.0)
        gradient[LN_SIGMA] -= of_e * misfit
        gradient[LN_SIZE] -= (1.0 - of_e) * (1.0 - of_size) * misfit
        for k in range(SCATTERED):
            gradient[k] -= 2.0 * number * (along * moved[k] + across * spread[k])
        first /= all_prior
        wide = max(second / all_prior - first**2, 0.0)
        variance = wide + sigma**2
        expected[i, 0], expected[i, 1] = first, variance
        variance += (loose - 1.0) * sigma**2
        by_sigma, by_size = 2.0 * of_e * sigma**2 / variance, 2.0 * wide * spread[LN_SIZE] / s
        by_size /= variance
        for k in range(Q + 1):
            for m in range(Q + 1):
                information[k, m] += number * mean[k] * mean[m] / all_prior**2 / variance
        information[LN_SIGMA, LN_SIGMA] += 0.5 * number * by_sigma**2
        information[LN_SIZE, LN_SIZE] += 0.5 * number * by_size**2
        information[LN_SIGMA, LN_SIZE] += 0.5 * number * by_sigma * by_size
        information[LN_SIZE, LN_SIGMA] += 0.5 * number * by_sigma * by_size
    return total


@_jit
def deviances(grid, scale, data, owner, v_c, z, total, gradient, information) -> None:  # type: ignore[no-untyped-def]
    """Put `deviance` of many searches, half its slopes, and the information.

    Parameters
    ----------
    grid, scale
        As of `deviance`.
    data
        Rows of the data sets, (r, 7, n).
    owner, v_c, z
        Of each search the number of its data set, the capture velocity held, and the variables,
        (m,), (m,), (m, 7).
    total, gradient, information
        Room, (m,), (m, 7), (m, 7, 7).
    """
    moments = np.empty((data.shape[2], 2))
    for m in range(len(owner)):
        total[m] = deviance(
            grid, scale, data[owner[m]], v_c[m], z[m], gradient[m], information[m], moments
        )
    gradient *= 0.5
