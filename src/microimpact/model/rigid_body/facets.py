"""Rigid body rebound in three dimensions from a facet of a rough surface.

The nominal surface is the plane z = 0. In the frame of the facet the impact is the planar one along
the slip: its direction does not change during contact, and spin about the normal is inert.
"""

from __future__ import annotations

import math

import numpy as np

from microimpact.core.arrays import NON_NEGATIVE, FloatArray, checked
from microimpact.core.compiled import jit
from microimpact.model.rigid_body.algebra import APPROACHING, INERTIA, UNIT_INTERVAL

_jit = jit()


def facet_rebound(
    velocity: FloatArray,
    spin_speed: FloatArray,
    normal: FloatArray,
    e: FloatArray,
    friction: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return velocity and spin after impacts on facets, Eqs. (6)-(8), (11)-(13) in the local frame.

    Parameters
    ----------
    velocity, spin_speed
        v and r omega before impact, m/s, shape (n, 3); v must have a component into the facet.
    normal
        Unit normals, shape (n, 3).
    e, friction
        Coefficient of restitution about the facet's normal and Coulomb coefficient, shape (n,).

    Raises
    ------
    ValueError
        If a sphere does not approach its facet, or e or friction is out of range.
    """
    checked("v_n", np.vecdot(velocity, normal), APPROACHING)
    checked("e", e, UNIT_INTERVAL)
    checked("friction", friction, NON_NEGATIVE)
    after, spin_after = np.empty(velocity.shape), np.empty(velocity.shape)
    _rebounds(velocity, spin_speed, normal, e, friction, after, spin_after)
    return after, spin_after


@_jit
def _rebounds(velocity, spin_speed, normal, e, friction, after, spin_after):  # type: ignore[no-untyped-def]
    """Slip at the contact point is v_t + r omega x (-n); mu = min(f, mu_0) along it."""
    for i in range(velocity.shape[0]):
        vx, vy, vz = velocity[i, 0], velocity[i, 1], velocity[i, 2]
        wx, wy, wz = spin_speed[i, 0], spin_speed[i, 1], spin_speed[i, 2]
        nx, ny, nz = normal[i, 0], normal[i, 1], normal[i, 2]
        into = vx * nx + vy * ny + vz * nz
        sx = vx - into * nx - (wy * nz - wz * ny)
        sy = vy - into * ny - (wz * nx - wx * nz)
        sz = vz - into * nz - (wx * ny - wy * nx)
        slip = math.sqrt(sx * sx + sy * sy + sz * sz)
        normal_impulse = -(1.0 + e[i]) * into
        stopping = slip / ((1.0 + 1.0 / INERTIA) * normal_impulse)
        ratio = min(friction[i], stopping) / slip if slip > 0.0 else 0.0
        px = normal_impulse * (nx - ratio * sx)
        py = normal_impulse * (ny - ratio * sy)
        pz = normal_impulse * (nz - ratio * sz)
        after[i, 0], after[i, 1], after[i, 2] = vx + px, vy + py, vz + pz
        spin_after[i, 0] = wx - (ny * pz - nz * py) / INERTIA
        spin_after[i, 1] = wy - (nz * px - nx * pz) / INERTIA
        spin_after[i, 2] = wz - (nx * py - ny * px) / INERTIA
