"""Planar impact of a rough body that touches a plane beside the line below its centre.

A plane has one normal, however rough the body that falls on it: what the slope of the body does is
to move the point of contact, by the offset b along t, and to give the normal impulse a lever arm.
With the impulses p_n, p_t per mass, k = `INERTIA` and h^2 = r^2 - b^2, momentum gives

    V_n = v_n + p_n,   V_t = v_t + p_t,   k r^2 (Omega - omega) = -(h p_t + b p_n),

and the velocity of the point of contact, ``c_n = v_n - b omega``, ``c_t = v_t - h omega``, changes
by ``A p_n + C p_t`` and ``C p_n + B p_t`` with

    A = 1 + b^2/(k r^2),   B = 1 + h^2/(k r^2),   C = b h/(k r^2).

Coulomb friction holds at every instant: slip is used up or not, and what follows is sticking if
``|C/B| <= f``, else slip in the sense in which the lever arm drives it. So p_t is piecewise linear
in p_n. Restitution is that of energy, the work of the normal impulse regained over that spent: it
alone never gains energy when slip changes during contact (Stronge, Impact Mechanics). Without
offset the sphere of Eqs. (6)-(8), (11)-(13) is left. Without friction and spin
``1 + V_n/|v_n| = (1 + e)/A``: an offset alone only lowers the measured restitution.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from microimpact.core.arrays import FINITE, POSITIVE, FloatArray, Range, checked, common_shape
from microimpact.model.rigid_body.algebra import INERTIA, UNIT_INTERVAL

# From this friction on a point of contact may jam: A = f |C| at b^2 = k / (1 + 2 k), the least.
JAMMING = 2.0 * math.sqrt(INERTIA * (1.0 + INERTIA))
FRICTION = Range(lower=0.0, upper=JAMMING, lower_closed=True)
OFFSET = Range(lower=-1.0, upper=1.0)


class EccentricRebound(NamedTuple):
    """Velocities of the centre and spin after impact, and the energy lost.

    V_n, V_t (m/s) and Omega (rad/s) with the signs of `rigid_body`; V_n may be negative where the
    offset is large: the body then still moves towards the plane. ``energy_loss`` is the total, per
    mass, m2/s2, never negative.
    """

    V_n: FloatArray
    V_t: FloatArray
    Omega: FloatArray
    energy_loss: FloatArray


def eccentric_rebound(
    v_n: object,
    v_t: object,
    omega: object,
    radius: object,
    offset: object,
    e: object,
    friction: object,
) -> EccentricRebound:
    """Rebound of a body that touches the plane off its centre.

    Parameters
    ----------
    v_n, v_t
        Velocity of the centre before impact, m/s; normal away from the plane.
    omega
        Spin before impact, rad/s, positive in the sense of rolling along t.
    radius
        Distance of the point of contact from the centre, m.
    offset
        ``b/r``, position of that point along t over the radius, in (-1, 1).
    e
        Coefficient of restitution at the point of contact (of energy), in [0, 1].
    friction
        Coulomb coefficient f, in [0, 1.4967): beyond, a point of contact could jam.

    Returns
    -------
    EccentricRebound
        The arguments broadcast.

    Raises
    ------
    TypeError, ValueError
        If an argument is not a number or out of range, the shapes do not broadcast, or a point of
        contact does not approach the plane.
    """
    arguments = {
        "v_n": checked("v_n", v_n, FINITE),
        "v_t": checked("v_t", v_t, FINITE),
        "omega": checked("omega", omega, FINITE),
        "radius": checked("radius", radius, POSITIVE),
        "offset": checked("offset", offset, OFFSET),
        "e": checked("e", e, UNIT_INTERVAL),
        "friction": checked("friction", friction, FRICTION),
    }
    shape = common_shape(arguments)
    vn, vt, w, r, b, e_, f = (np.broadcast_to(np.asarray(x), shape) for x in arguments.values())
    h = np.sqrt(1.0 - np.square(b))
    c_n, c_t = vn - b * r * w, vt - h * r * w
    if np.any(c_n >= 0.0):
        raise ValueError(f"v_n: the point of contact must approach, got {c_n[c_n >= 0.0][0]:g} m/s")
    p_n, p_t = _impulses(c_n, c_t, b, h, e_, f)
    change_n = (1.0 + np.square(b) / INERTIA) * p_n + b * h / INERTIA * p_t
    change_t = b * h / INERTIA * p_n + (1.0 + np.square(h) / INERTIA) * p_t
    loss = -p_n * (c_n + 0.5 * change_n) - p_t * (c_t + 0.5 * change_t)
    spin = w - (h * p_t + b * p_n) / (INERTIA * r)
    values = (vn + p_n, vt + p_t, spin, loss)
    return EccentricRebound(*(np.asarray(value)[()] for value in values))


def _impulses(
    c_n: FloatArray,
    c_t: FloatArray,
    b: FloatArray,
    h: FloatArray,
    e: FloatArray,
    friction: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Normal and tangential impulse per mass, m/s; lengths over the radius."""
    A, B, C = 1.0 + b**2 / INERTIA, 1.0 + h**2 / INERTIA, b * h / INERTIA
    # Ratio p_t/p_n while it slips as it came, and after that slip has ended at p_n = end.
    after = np.clip(-C / B, -friction, friction)
    before = np.where(c_t == 0.0, after, -friction * np.sign(c_t))
    slowing = -(C + B * before) * np.sign(c_t)
    stiff_before, stiff_after = A + C * before, A + C * after
    # An impact that slips throughout is over after at most twice the impulse of compression.
    ends = slowing * (-2.0 * c_n / stiff_before) >= np.abs(c_t)
    end = np.where(ends, np.abs(c_t) / np.where(ends & (slowing > 0.0), slowing, 1.0), np.inf)
    early = -c_n <= stiff_before * end  # compression is over before the slip
    finite = np.where(np.isfinite(end), end, 0.0)
    left = -c_n - stiff_before * finite  # speed of approach when the slip ends
    middle = np.where(early, -c_n / stiff_before, finite + left / stiff_after)
    spent = np.where(
        early,
        0.5 * c_n**2 / stiff_before,
        0.5 * (-c_n + left) * finite + 0.5 * left**2 / stiff_after,
    )
    wanted = np.square(e) * spent
    # Regained before slip ends, and the speed away then; both zero where it ended in compression.
    apart = np.where(early & np.isfinite(end), stiff_before * (finite - middle), 0.0)
    whole = early & (0.5 * apart**2 / stiff_before >= wanted) | (early & np.isinf(end))
    rest = np.maximum(wanted - 0.5 * apart**2 / stiff_before, 0.0)
    further = (np.sqrt(apart**2 + 2.0 * stiff_after * rest) - apart) / stiff_after
    total = np.where(
        whole,
        middle + np.sqrt(2.0 * wanted / stiff_before),
        np.where(early, finite, middle) + further,
    )
    return total, before * np.minimum(total, end) + after * np.maximum(total - end, 0.0)
