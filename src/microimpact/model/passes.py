"""Compiled passes over ensembles: an impact is read once, and its outcome is written once.

The law of normal impacts is looked up in tables of polynomials, see `law.pieces`; friction and spin
are algebra. All compiled functions are in this one module, see `core.compiled`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from microimpact.core.arrays import BoolArray, FloatArray, Real
from microimpact.core.compiled import jit

# Moment of inertia of a solid sphere: I = INERTIA m r^2. Slip lost per unit of tangential impulse
# and mass. They stand here as compiled code may rest on its own file alone, see `core.compiled`.
INERTIA = 0.4
SLIP_PER_IMPULSE = 1.0 + 1.0 / INERTIA

DEGREE = 12
# Quantities of a normal impact in its scales, the rows of what a table gives.
WIDTH = 7
RESTITUTION, CONTACT_TIME, COMPRESSION_TIME, COMPRESSION, COMPRESSIVE, PEAK, HERTZ = range(WIDTH)

# Relative error of e that rounding of the speed makes, times the relative distance from capture.
ROUNDING = 2e-14

# Columns of what contacts give to a pass: radius and friction; the unit of the variable of the
# tables, and coordinate in their family; units of velocity, length and time. Without adhesion the
# speed itself is the unit of velocity, which is then 0 here, and that of length goes with its 0.8th
# power.
CONTACT_COLUMNS = RADIUS, FRICTION, UNIT, PLACE, VELOCITY, LENGTH, TIME = range(7)
# Rows of outcomes: numbers, then flags.
(
    OUT_RESTITUTION,
    OUT_IMPULSE_RATIO,
    OUT_CONTACT_TIME,
    OUT_NORMAL,
    OUT_TANGENTIAL,
    OUT_SPIN,
    OUT_LOSS,
    OUT_LINEAR_LOSS,
    OUT_COMPRESSION,
    OUT_ERROR,
) = range(10)
OUT_CAPTURED, OUT_ROLLING = range(2)
# Which facets are hit, see `lab.surface.Rules`.
FACETS = ("seen", "facing", "every")
SEEN, _, EVERY = range(3)
# Beyond this the motion is so steep that all facets are hit alike, to rounding.
STEEPEST = 1e8
TINY = float(np.finfo(float).tiny)
# Rows of outcomes begin this many numbers further apart than they are long: in the same place of
# every page of memory they would push each other out of the processor's first cache.
APART = 24
# Quantities that friction may rest on, by the names of the forces.
SUPPORT = {"compressive": COMPRESSIVE, "hertz": HERTZ, "net": PEAK}


def flat(values: Real, shape: tuple[int, ...]) -> FloatArray:
    """Flatten values that broadcast to a shape: (n,), or (1,) for a single value.

    Read-only, so that Numba compiles a single signature.
    """
    array = np.asarray(values, dtype=np.float64)
    if array.size != 1 and array.shape != shape:
        array = np.broadcast_to(array, shape)
    array = array.reshape(-1)
    array.setflags(write=False)
    return array


def flats(columns: Sequence[Real], shape: tuple[int, ...]) -> Iterable[FloatArray]:
    """Flatten several values, see `flat`; those of a single impact in one array, which is fast."""
    if shape:
        return (flat(values, shape) for values in columns)
    numbers = np.array(columns, dtype=np.float64).reshape(-1, 1)
    numbers.setflags(write=False)
    return numbers


def outcomes(shape: tuple[int, ...]) -> tuple[FloatArray, BoolArray]:
    """Return empty rows for the outcomes of impacts: numbers, flags."""
    size = math.prod(shape)
    numbers = np.empty((OUT_ERROR + 1, size + APART))[:, :size]
    return numbers, np.empty((OUT_ROLLING + 1, size + APART), dtype=np.bool_)[:, :size]


_jit_inline = jit(inline="always")
_jit = jit()
# Sums of polynomials are faster so. How a compiler contracts depends on what it compiled
# before, and with it the last bit: passes that ask no table go without.
_jit_contract = jit(fastmath={"contract"})


@_jit_inline
def _ratio(w, coordinate, slowness):  # type: ignore[no-untyped-def]
    """Return w over the threshold, by Clenshaw's sum of its reciprocal."""
    b1, b2 = 0.0, 0.0
    for k in range(slowness.size - 1, 0, -1):
        b1, b2 = 2.0 * coordinate * b1 + (slowness[k] - b2), b1
    return w * (coordinate * b1 - b2 + slowness[0])


@_jit_inline
def _find(w, coordinate, law):  # type: ignore[no-untyped-def]
    """Return w over the threshold, whether the impact is captured, and where its polynomials are.

    That is their row (-1: there are none), and the places along and across its piece.
    """
    slowness, _, captures, rebounds, gap, _ = law
    ratio = _ratio(w, coordinate, slowness) if slowness.size else math.inf
    captured = ratio <= 1.0 - gap
    x = ratio if captured else ratio - 1.0 if slowness.size else w
    first, bands, pieces, lowest, split = captures if captured else rebounds
    mantissa, exponent = math.frexp(x)
    along = (2.0 * mantissa - 1.0) * split
    part = int(along)
    piece = (exponent - lowest) * split + part
    across = 0.5 * (coordinate + 1.0) * bands
    band = min(max(int(across), 0), bands - 1)
    row = first + band * pieces + piece
    # Beyond the family a table means nothing.
    if not (0.0 < x < math.inf and 0 <= piece < pieces and abs(coordinate) <= 1.0):
        row = -1
    return ratio, captured, (row, 2.0 * (along - part) - 1.0, 2.0 * (across - band) - 1.0)


@_jit_inline
def _value(quantity, coefficients, where):  # type: ignore[no-untyped-def]
    """Return a quantity: a polynomial in ``across`` whose coefficients are polynomials in t."""
    row, t, across = where
    if row < 0:
        return math.nan
    total = 0.0
    for j in range(coefficients.shape[1] - 1, -1, -1):
        value = coefficients[row, j, quantity, DEGREE]
        for k in range(DEGREE):
            value = value * t + coefficients[row, j, quantity, DEGREE - 1 - k]
        total = total * across + value
    return total


@_jit_inline
def _fits(coefficients):  # type: ignore[no-untyped-def]
    """Tell whether a table has the shape of all: gives the compiler the distance of rows."""
    return coefficients.shape[2] == WIDTH and coefficients.shape[3] == DEGREE + 1


@_jit_contract
def look_up(w, coordinate, law, out, start):  # type: ignore[no-untyped-def]
    """Write the quantities of normal impacts by the table of a law.

    Parameters
    ----------
    w
        Variable of the law, (n,).
    coordinate
        Place in its family, (n,) or (1,).
    law
        Tables and thresholds, see `law.table.Law.compiled`.
    out
        Room for the quantities, (``WIDTH``, columns).
    start
        First column.
    """
    if not _fits(law[1]):
        return  # never
    for i in range(w.size):
        _, captured, where = _find(w[i], _broadcast_item(coordinate, i), law)
        for quantity in range(WIDTH):
            out[quantity, start + i] = _value(quantity, law[1], where)
        if captured:
            out[CONTACT_TIME, start + i] = math.inf


@_jit_inline
def _restitution(w, coordinate, law):  # type: ignore[no-untyped-def]
    _, captured, where = _find(w, coordinate, law)
    e = _value(RESTITUTION, law[1], where)  # asked in any case: no branch, a third faster
    # Captured impacts below the table need none.
    return 0.0 if captured and abs(coordinate) <= 1.0 else e


@_jit_contract
def restitution(w, coordinate, law, out):  # type: ignore[no-untyped-def]
    """Write coefficients of restitution by the table of a law.

    Parameters
    ----------
    w, coordinate, law
        As of `look_up`.
    out
        Room for e, (n,).
    """
    if not _fits(law[1]):
        return  # never
    for i in range(w.size):
        out[i] = _restitution(w[i], _broadcast_item(coordinate, i), law)


@_jit_inline
def _broadcast_item(values, i):  # type: ignore[no-untyped-def]
    """Return the value for an impact; a single value holds for all."""
    return values[i] if values.size > 1 else values[0]


@_jit_inline
def _components(degrees):  # type: ignore[no-untyped-def]
    """Return sine and cosine of an angle in [0, 90] degrees; at both ends they are exact."""
    nearer = math.radians(min(degrees, 90.0 - degrees))
    small, large = math.sin(nearer), math.cos(nearer)
    return (small, large) if degrees < 45.0 else (large, small)


@_jit_inline
def _friction(slip, friction, sliding, available, captured):  # type: ignore[no-untyped-def]
    """Return the impulse of friction per mass, and whether slip ends: `impact.friction_impulse`."""
    size = abs(slip)
    if SLIP_PER_IMPULSE * friction * available >= size or (captured and friction > 0.0):
        return slip * (1.0 / SLIP_PER_IMPULSE), True
    return math.copysign(friction * sliding, slip), False


@_jit_inline
def _planar(i, v_n, v_t, spin, radius, e, change, out):  # type: ignore[no-untyped-def]
    """Write the outcome of a planar impact with an impulse of friction into column ``i``."""
    after_n, after_t, after_spin = e * v_n, v_t - change, spin + change / (INERTIA * radius)
    energy = v_n * v_n + v_t * v_t
    linear = energy - after_n * after_n - after_t * after_t
    share = 1.0 / energy
    # Rotational energy lost, from the change itself: exact where the spin hardly changes.
    rotational = -change * radius * (spin + after_spin)
    out[OUT_RESTITUTION, i] = e
    out[OUT_IMPULSE_RATIO, i] = change / (v_n + after_n)
    out[OUT_NORMAL, i] = after_n
    out[OUT_TANGENTIAL, i] = after_t
    out[OUT_SPIN, i] = after_spin
    out[OUT_LOSS, i] = (linear + rotational) * share
    out[OUT_LINEAR_LOSS, i] = linear * share


@_jit
def planar(v_n, v_t, spin, radius, e, change, out):  # type: ignore[no-untyped-def]
    """Write outcomes of planar impacts at normal speeds v_n.

    Parameters
    ----------
    v_n, v_t
        Components of the velocity, m/s, v_n positive towards the surface; here and below (n,), or
        (1,) for all.
    spin
        rad/s.
    radius
        m.
    e
        Coefficients of restitution.
    change
        Impulses of friction per mass, m/s.
    out
        Room for the outcomes, (rows, n).
    """
    for i in range(out.shape[1]):
        slow, along, turn = (
            _broadcast_item(v_n, i),
            _broadcast_item(v_t, i),
            _broadcast_item(spin, i),
        )
        _planar(
            i,
            slow,
            along,
            turn,
            _broadcast_item(radius, i),
            _broadcast_item(e, i),
            _broadcast_item(change, i),
            out,
        )


@_jit_contract
def tabulated(  # type: ignore[no-untyped-def]
    indices, integrated, law, speed, angle, spin, contacts, support, out, flags
):
    """Write the outcome of planar impacts by a law of normal impacts.

    Parameters
    ----------
    indices
        Of the impacts, (m,), as integers.
    integrated
        Their quantities (``WIDTH``, m), if they were integrated; if empty, the law is looked up.
    law
        Tables and thresholds, see `law.table.Law.compiled`.
    speed, angle, spin
        m/s, degrees, rad/s; of all impacts, (n,), or one for all, (1,).
    contacts
        (n, columns) or (1, columns).
    support
        Quantity that friction rests on.
    out, flags
        Outcomes of all impacts, (rows, n), numbers and flags; NaN for e where the law has none.
    """
    if not _fits(law[1]):
        return  # never
    error = law[-1]
    sine = cosine = math.nan
    for j in range(indices.size):
        i = indices[j]
        if j == 0 or angle.size > 1:
            sine, cosine = _components(_broadcast_item(angle, i))
        v_n, v_t, omega = (
            sine * _broadcast_item(speed, i),
            cosine * _broadcast_item(speed, i),
            _broadcast_item(spin, i),
        )
        row = i if contacts.shape[0] > 1 else 0
        radius, friction = contacts[row, RADIUS], contacts[row, FRICTION]
        ratio, captured, where = _find(v_n / contacts[row, UNIT], contacts[row, PLACE], law)
        if integrated.size:
            e, captured = integrated[RESTITUTION, j], integrated[CONTACT_TIME, j] == math.inf
            duration, depth, impulse = (
                integrated[CONTACT_TIME, j],
                integrated[COMPRESSION, j],
                integrated[support, j],
            )
        else:
            e, duration = _value(RESTITUTION, law[1], where), _value(CONTACT_TIME, law[1], where)
            depth, impulse = _value(COMPRESSION, law[1], where), _value(support, law[1], where)
        velocity, length, time = (
            contacts[row, VELOCITY],
            contacts[row, LENGTH],
            contacts[row, TIME],
        )
        if velocity == 0.0:
            velocity, length = v_n, length * v_n**0.8
            time = length / v_n
        available = sliding = impulse * velocity
        if support == PEAK:
            sliding = (1.0 + e) * v_n
        slip = v_t - radius * omega
        change, rolling = _friction(slip, friction, sliding, available, captured)
        _planar(i, v_n, v_t, omega, radius, e, change, out)
        out[OUT_CONTACT_TIME, i] = math.inf if captured else duration * time
        out[OUT_COMPRESSION, i] = depth * length
        out[OUT_ERROR, i] = error + ROUNDING / (abs(ratio - 1.0) if ratio < math.inf else 1.0)
        flags[OUT_CAPTURED, i], flags[OUT_ROLLING, i] = captured, rolling


# Rough surfaces: facets, and what they make of velocity and r omega, both as (x, y, z)


@_jit_inline
def _normal(velocity, along, across):  # type: ignore[no-untyped-def]
    """Return the normal of the plane z = along s + across q, s along the motion, q to its left."""
    x, y = 1.0, 0.0
    speed = math.sqrt(velocity[0] ** 2 + velocity[1] ** 2)
    if speed > 0.0:
        share = 1.0 / speed
        x, y = velocity[0] * share, velocity[1] * share
    size = 1.0 / math.sqrt(1.0 + along**2 + across**2)
    return size * (y * across - x * along), size * (-x * across - y * along), size


@_jit_inline
def _hits(cell, slope, c, slopes):  # type: ignore[no-untyped-def]
    """Integral of c + x over the facets up to a slope within a cell."""
    edges, mass, below, moment = slopes
    left, right = edges[cell], edges[cell + 1]
    share = (slope - left) / (right - left) if right > left else 0.0
    within = mass[cell] * share * (c + 0.5 * (left + slope))
    return c * below[cell] + moment[cell] + within


@_jit_inline
def _further(weight, rest):  # type: ignore[no-untyped-def]
    """Root of weight x + x^2/2 = rest; without cancellation where the weight is large."""
    weight, rest = max(weight, 0.0), max(rest, 0.0)
    divisor = weight + math.sqrt(weight * weight + 2.0 * rest)
    return 2.0 * rest / divisor if divisor > 0.0 else 0.0


@_jit_inline
def _hit_slope(u, c, slopes):  # type: ignore[no-untyped-def]
    """Invert the integral of (c + x)+ over the facets up to a slope x, see `lab.surface`."""
    edges, mass, below, moment = slopes
    end = last = mass.size
    if c + edges[end] <= 0.0:
        return -math.inf
    cell = min(max(np.searchsorted(edges, -c, side="right") - 1, 0), end - 1)
    start = min(max(-c, edges[cell]), edges[cell + 1])
    reached = _hits(cell, start, c, slopes)
    target = reached + u * (c * below[end] + moment[end] - reached)
    # From the cell of -c on the integral ascends: halve the cells until one is left.
    while last - cell > 1:
        middle = (cell + last) // 2
        if c * below[middle] + moment[middle] > target:
            last = middle
        else:
            cell = middle
    start = max(start, edges[cell])
    # Far out a cell may hold less than rounding.
    rate = (edges[cell + 1] - edges[cell]) / max(mass[cell], TINY)
    rest = (target - _hits(cell, start, c, slopes)) * rate
    return min(start + _further(c + start, rest), edges[cell + 1])


@_jit_inline
def _rebound(velocity, turn, normal, into, e, friction):  # type: ignore[no-untyped-def]
    """Return velocity and r omega after a rigid body's rebound, Eqs. (6)-(8), (11)-(13)."""
    vx, vy, vz = velocity
    wx, wy, wz = turn
    nx, ny, nz = normal
    sx = vx - into * nx - (wy * nz - wz * ny)
    sy = vy - into * ny - (wz * nx - wx * nz)
    sz = vz - into * nz - (wx * ny - wy * nx)
    slip = math.sqrt(sx * sx + sy * sy + sz * sz)
    impulse = -(1.0 + e) * into
    stopping = slip / (SLIP_PER_IMPULSE * impulse)
    ratio = min(friction, stopping) / slip if slip > 0.0 else 0.0
    px = impulse * (nx - ratio * sx)
    py = impulse * (ny - ratio * sy)
    pz = impulse * (nz - ratio * sz)
    ax = wx - (ny * pz - nz * py) * (1.0 / INERTIA)
    ay = wy - (nz * px - nx * pz) * (1.0 / INERTIA)
    az = wz - (nx * py - ny * px) * (1.0 / INERTIA)
    return (vx + px, vy + py, vz + pz), (ax, ay, az)


@_jit
def rebounds(velocity, turn, normal, e, friction, after, turned):  # type: ignore[no-untyped-def]
    """Write velocities and r omega after rebounds from facets.

    Parameters
    ----------
    velocity, turn
        Velocities before, m/s, and r omega, m/s, (n, 3).
    normal
        Normals of the facets, (n, 3).
    e, friction
        Coefficients of restitution and friction, (n,).
    after, turned
        Room for velocities and r omega after, (n, 3).
    """
    for i in range(velocity.shape[0]):
        v = velocity[i, 0], velocity[i, 1], velocity[i, 2]
        w = turn[i, 0], turn[i, 1], turn[i, 2]
        n = normal[i, 0], normal[i, 1], normal[i, 2]
        into = v[0] * n[0] + v[1] * n[1] + v[2] * n[2]
        v, w = _rebound(v, w, n, into, e[i], friction[i])
        after[i, 0], after[i, 1], after[i, 2] = v
        turned[i, 0], turned[i, 1], turned[i, 2] = w


@_jit_inline
def _met(velocity, slope, sideways, slopes, facets):  # type: ignore[no-untyped-def]
    """Return the normal of the facet met, and the velocity along it."""
    if facets == SEEN:
        level = math.sqrt(velocity[0] ** 2 + velocity[1] ** 2)
        # Upright motion meets all facets alike.
        tangent = min(-velocity[2] / max(level, TINY), STEEPEST)
        # No slope can be hit where none faces the sphere.
        slope = max(_hit_slope(slope, tangent, slopes), -STEEPEST)
    normal = _normal(velocity, slope, sideways)
    into = velocity[0] * normal[0] + velocity[1] * normal[1] + velocity[2] * normal[2]
    if facets == EVERY and into > 0.0:
        return (-normal[0], -normal[1], -normal[2]), -into
    return normal, into


@_jit
def normals(velocity, along, across, slopes, facets, normal):  # type: ignore[no-untyped-def]
    """Write the normals of the facets met.

    Parameters
    ----------
    velocity
        Velocities, m/s, (n, 3).
    along, across
        Slopes along and across the motion, of facets that are seen shares in their place, (n,).
    slopes
        Table of slopes by `lab.surface.hit_slopes`.
    facets
        Number of the facets in ``FACETS``.
    normal
        Room for the normals, (n, 3).
    """
    for i in range(velocity.shape[0]):
        v = velocity[i, 0], velocity[i, 1], velocity[i, 2]
        direction, _ = _met(v, along[i], across[i], slopes, facets)
        normal[i, 0], normal[i, 1], normal[i, 2] = direction
