"""Compiled integration of the way back of a contact whose edge opens by its own speed.

Contact radius a and compression d are independent, as for a flat punch on the sphere's profile, in
the units of `microimpact.model.dynamics.force_laws`, with the speed v of separation::

    y = a^2 - d,   force f = a (a^2 - 3/2 y - drag v),   energy release rate G/w_0 = y^2/(16 b^2 a)

JKR is y = 4 b a^(1/2). The edge opens with ``-da/dt = c (G/w_0 - 1)^(1/m)`` (Maugis and Barquins
1978), and y = 4 b a^(1/2) (1 + z) defines z, so that ``G/w_0 - 1 = z (2 + z)`` without cancellation
however fast the edge, and z is linear in d however slow. The motion begins at the turning point
with z = 0 and ends with a = 0, smooth in a time ``dtau = (1 + p) dt`` with p = -T da/dt / a.

A fast edge makes the equations stiff: they are extrapolated from linearly implicit Euler steps
(Deuflhard 1985; Hairer and Wanner 1996, SEULEX), with a harmonic sequence of their numbers.
"""

from __future__ import annotations

import math

import numpy as np

from microimpact.core.arrays import FloatArray
from microimpact.core.compiled import jit

# Columns of a problem and of a result; impulses and energies per unit mass.
BETA, DRAG, EDGE_SPEED, EXPONENT, TOP = range(5)
STATUS, SPEED, TIME, RISE, HIGHEST_V, BULK = range(6)
RESULT_COLUMNS = 6

PARTED, TURNED, FAILED = 0.0, 1.0, 2.0

# Most Euler steps in one of the integration, the number aimed at, and the error of one step in a
# and v; that of z, which errors of a and v follow, may be this much larger.
COLUMNS, AIM, TOLERANCE, LOOSER = 12, 9, 1e-10, 1e3
# A step that changes the sign of the force ends where it is this small: v is level there.
LEVEL = 1e-5
# Beginning, in units of the time T, and end, as a share of the first radius: their neglected terms
# are below the tolerance.
BEGINNING, END = 1e-6, 3e-3
MAX_STEPS = 20_000
# Share of its typical value to which z falls only where the contact closes again, and that of the
# greatest speed which is none.
CLOSING, STILL = 1e-3, 1e-10

_jit = jit()
_jit_inline = jit(inline="always")


@_jit_inline
def _rates(a, z, v, beta, quarter, drag, pace, power, inverse):  # type: ignore[no-untyped-def]
    """Stretch y, dt/dtau, its complement, and da/dtau, dz/dtau, dv/dtau."""
    wide, root = 1.0 + z, math.sqrt(a)
    shared = 1.0 / (a * wide)  # a division less
    y = 4.0 * beta * root * wide
    p = pace * wide * shared * math.exp(power * math.log(z * (2.0 + z)))
    share = 1.0 / (1.0 + p)
    rest = p * share if p < 1.0 else 1.0 - share
    opening = rest * inverse
    dz = root * quarter * wide * shared * (share * v - 2.0 * a * a * opening) + 0.5 * wide * opening
    return y, share, rest, -a * opening, dz, share * a * (a * a - 1.5 * y - drag * v)


@_jit
def _extrapolate(a0, z0, v0, step, problem, pace, inverse, scale, table):  # type: ignore[no-untyped-def]
    """Number of the column that meets the tolerance (negative: none does), and its error.

    The first row of ``table`` (columns, 5) has a, z, v, time and loss in the bulk after the step.
    """
    beta, drag, power = problem[BETA], problem[DRAG], 1.0 / problem[EXPONENT]
    quarter = 0.25 / beta
    y, share, rest, da0, dz0, dv0 = _rates(a0, z0, v0, beta, quarter, drag, pace, power, inverse)
    # Derivatives of dt/dtau by a and z, and the Jacobian.
    product, force, wide = share * rest, dv0 / share, 1.0 + z0
    by_a, by_z = -product / a0, product * power * 2.0 * wide / (z0 * (2.0 + z0))
    turn = (0.5 - 2.0 * a0 * a0 / y) * inverse - v0 / y
    drive = (share * v0 - 2.0 * a0 * a0 * rest * inverse) / y
    j_aa, j_az = -inverse * (rest + a0 * by_a), -inverse * a0 * by_z
    j_za = wide * (turn * by_a - 0.5 * share * v0 / (y * a0) - 3.0 * a0 * rest * inverse / y)
    j_zz, j_zv = dz0 / wide + wide * turn * by_z - drive, wide * share / y
    j_va = share * (3.0 * a0 * a0 - 2.25 * y - drag * v0) - force * by_a
    j_vz, j_vv = -share * 1.5 * a0 * y / wide - force * by_z, -share * drag * a0
    error = math.inf
    for column in range(1, COLUMNS + 1):
        h = step / column
        # h times the inverse of 1 - h J, with J_av = 0.
        m_aa, m_zz, m_vv = 1.0 - h * j_aa, 1.0 - h * j_zz, 1.0 - h * j_vv
        c_a = m_zz * m_vv - h * h * j_zv * j_vz
        c_z, c_v = h * j_za * m_vv + h * h * j_zv * j_va, h * h * j_za * j_vz + m_zz * h * j_va
        unit = h / (m_aa * c_a - h * j_az * c_z)
        i_aa, i_za, i_va = c_a * unit, c_z * unit, c_v * unit
        i_az, i_zz = h * j_az * m_vv * unit, m_aa * m_vv * unit
        i_vz = (h * j_vz * m_aa + h * h * j_az * j_va) * unit
        i_av, i_zv = h * h * j_az * j_zv * unit, m_aa * h * j_zv * unit
        i_vv = (m_aa * m_zz - h * h * j_az * j_za) * unit
        a, z, v, da, dz, dv, part = a0, z0, v0, da0, dz0, dv0, share
        time = bulk = 0.0
        for k in range(column):
            if k > 0:
                if not (a > 0.0 and z > 0.0):
                    return -column, math.inf
                _, part, _, da, dz, dv = _rates(a, z, v, beta, quarter, drag, pace, power, inverse)
            time += h * part
            bulk += h * part * drag * a * v * v
            a += i_aa * da + i_az * dz + i_av * dv
            z += i_za * da + i_zz * dz + i_zv * dv
            v += i_va * da + i_vz * dz + i_vv * dv
        table[column - 1, 0], table[column - 1, 1], table[column - 1, 2] = a, z, v
        table[column - 1, 3], table[column - 1, 4] = time, bulk
        for k in range(column - 1, 0, -1):
            weight = k / (column - k)
            for i in range(5):
                table[k - 1, i] = table[k, i] + (table[k, i] - table[k - 1, i]) * weight
        if column < 3:
            continue
        error = 0.0
        for i in range(3):
            error = max(error, abs(table[0, i] - table[1, i]) / (TOLERANCE * scale[i]))
        if not error < math.inf:
            return -column, math.inf
        if error < 1.0 and table[0, 0] > 0.0 and table[0, 1] > 0.0:
            return column, error
    return -COLUMNS, error


@_jit_inline
def _energy(a, y, v, beta):  # type: ignore[no-untyped-def]
    """Kinetic, elastic and surface energy; negative only where the sphere stays."""
    flat = 2.0 / 3.0 * a * a - y
    return 0.5 * v * v + 0.75 * a * flat * flat + a**5 / 15.0 - 6.0 * beta * beta * a * a


@_jit
def integrate(problems: FloatArray, through: bool, results: FloatArray) -> None:
    """Follow every row of ``problems`` into the same row of ``results``.

    To the break, or to where the sphere turns again; or ``through`` that, to the break, to where
    the contact closes again or the sphere turns once more: then the speed at the break, negative,
    tells how far a rebound is.
    """
    table, scale = np.zeros((COLUMNS, 5)), np.zeros(3)
    for row in range(problems.shape[0]):
        problem, result = problems[row], results[row]
        beta, drag, edge, exponent, top = problem
        result[:] = 0.0
        y, a = 4.0 * beta * math.sqrt(top), top
        unit = 1.0 / math.sqrt(1.5 * top)
        force = top * (top * top - 1.5 * y)
        if force <= 0.0 or _energy(top, y, 0.0, beta) < 0.0:
            result[STATUS] = TURNED
            continue
        scale[0], scale[2] = top, top * top / unit
        typical = (top / (unit * edge)) ** exponent
        typical /= 1.0 + math.sqrt(1.0 + typical)
        # At first the radius stays, or follows as that of a JKR contact, whichever is the earlier.
        time, smallest = BEGINNING * unit, LEVEL * force
        v = force * time
        steady = (v / ((2.0 * top - 0.5 * y / top) * edge)) ** exponent
        z = min(0.5 * force * time * time / y, steady / (1.0 + math.sqrt(1.0 + steady)))
        step, status = 1e2 * time, FAILED
        before, beyond, tried, tried_force = 0.0, math.inf, 0.0, force
        result[RISE] = result[HIGHEST_V] = v
        for _ in range(MAX_STEPS):
            # As the radius falls, so does what z does to v.
            scale[1] = LOOSER * max(z, typical) * top / a
            column, error = _extrapolate(
                a, z, v, step, problem, unit * edge, 1.0 / unit, scale, table
            )
            if column < 0:
                # Without an error a or z had left the positive numbers.
                step *= max(0.1, 0.7 * error ** (1.0 / column)) if 1.0 < error < math.inf else 0.25
                before, beyond, tried, tried_force = 0.0, math.inf, 0.0, force
                continue
            new_a, new_z, new_v = table[0, 0], table[0, 1], table[0, 2]
            y = 4.0 * beta * math.sqrt(new_a) * (1.0 + new_z)
            new_force = new_a * (new_a * new_a - 1.5 * y - drag * new_v)
            crosses = (new_force > 0.0) != (force > 0.0)
            if (crosses or beyond < math.inf) and abs(new_force) > smallest:
                before, beyond = (before, step) if crosses else (step, beyond)
                secant = step - new_force * (step - tried) / (new_force - tried_force)
                tried, tried_force = step, new_force
                step = secant if before < secant < beyond else 0.5 * (before + beyond)
                continue
            turns = v < 0.0 <= new_v
            result[RISE] += max(new_v - v, 0.0)
            a, z, v, force = new_a, new_z, new_v, new_force
            before, beyond, tried, tried_force = 0.0, math.inf, 0.0, force
            time += table[0, 3]
            result[BULK] += table[0, 4]
            result[HIGHEST_V] = max(result[HIGHEST_V], v)
            growth = 0.9 * max(error, 1e-30) ** (-1.0 / column) * 1.5 ** max(AIM - column, 0)
            step *= min(5.0, max(0.2, growth))
            if a < END * top:
                status = PARTED
                break
            still = STILL * result[HIGHEST_V]
            turns |= v < still and (v > -still or z < CLOSING * typical or not through)
            if turns or _energy(a, y, v, beta) < 0.0:
                status = TURNED
                break
        if status == PARTED:
            # What is left is a power of a, with the compression and the speed as they are.
            speed = edge * (z * (2.0 + z)) ** (1.0 / exponent)
            time += a / (speed * (1.0 + 1.0 / exponent))
            weight = a * a / (speed * (2.0 + 1.0 / exponent))
            result[BULK] += drag * v * v * weight
            v -= (1.5 * y + drag * v) * weight
            status = PARTED if v > 0.0 or through else TURNED
        result[STATUS], result[SPEED], result[TIME] = status, v, time
