"""Rigid body rebound in three dimensions from a facet of a rough surface.

The nominal surface is the plane z = 0. In the frame of the facet the impact is the planar one along
the slip: its direction does not change during contact, and spin about the normal is inert.
"""

from __future__ import annotations

import numpy as np

from microimpact.core.arrays import NON_NEGATIVE, FloatArray, checked
from microimpact.model import passes
from microimpact.model.rigid_body.algebra import APPROACHING, UNIT_INTERVAL


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
    passes.rebounds(velocity, spin_speed, normal, e, friction, after, spin_after)
    return after, spin_after
