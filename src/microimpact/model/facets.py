"""Rigid body rebound in three dimensions from a facet of a rough surface.

The nominal surface is the plane z = 0. In the frame of the facet the impact is the planar one along
the slip: its direction does not change during contact, and spin about the normal is inert.
"""

from __future__ import annotations

import numpy as np

from microimpact.arrays import FloatArray
from microimpact.model.rigid_body import INERTIA, rigid_body_rebound


def facet_normals(velocity: FloatArray, along: FloatArray, across: FloatArray) -> FloatArray:
    """Return unit normals of facets, shape (n, 3).

    Parameters
    ----------
    velocity
        Before impact, shape (n, 3); only its direction along the nominal surface counts (x, if it
        is normal).
    along, across
        Slopes of the facet along the motion and to its left, tangents, shape (n,). A facet whose
        slope along the motion is positive faces the sphere.
    """
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    moving = speed > 0.0
    scale = np.where(moving, speed, 1.0)
    x, y = np.where(moving, velocity[:, 0] / scale, 1.0), velocity[:, 1] / scale
    normal = np.stack([y * across - x * along, -x * across - y * along, np.ones_like(x)], axis=1)
    return np.asarray(normal / np.sqrt(1.0 + np.square(along) + np.square(across))[:, None])


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
    into = np.vecdot(velocity, normal)
    # Velocity of the point of contact along the facet: v_t + r omega x (-n).
    slip = velocity - into[:, None] * normal - np.cross(spin_speed, normal)
    size = np.linalg.norm(slip, axis=1)
    mu = rigid_body_rebound(into, size, 0.0, 1.0, e, friction).mu
    direction = slip / np.where(size > 0.0, size, 1.0)[:, None]
    impulse = -((1.0 + e) * into)[:, None] * (normal + mu[:, None] * direction)
    return velocity + impulse, spin_speed - np.cross(normal, impulse) / INERTIA
