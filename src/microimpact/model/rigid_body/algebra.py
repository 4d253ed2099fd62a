"""The rigid body model of planar impact, Eqs. (1)-(18): algebra of impulses and momentum.

Signs are the article's: the normal n points away from the surface, so an approaching sphere has
v_n < 0; a sphere that rolls along t has ``v_t = r omega``; the signed impulse ratio mu of Eq. (2)
is negative where friction opposes v_t > 0.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from microimpact.core.arrays import (
    FINITE,
    NON_NEGATIVE,
    POSITIVE,
    FloatArray,
    Range,
    Real,
    checked,
    common_shape,
)
from microimpact.model import passes

# Squares of faster spheres' energies would leave double precision long after physics is left.
SPEED_OF_LIGHT = 299_792_458.0
APPROACHING = Range(lower=-SPEED_OF_LIGHT, upper=0.0)
VELOCITY = Range(lower=-SPEED_OF_LIGHT, upper=SPEED_OF_LIGHT)
# rad/s: at these the surface of a sphere of a nanometre has the speed of light.
SPIN = Range(lower=-6e17, upper=6e17)
UNIT_INTERVAL = Range(lower=0.0, upper=1.0, lower_closed=True, upper_closed=True)
# What the arguments of the rigid body model may be, by their names.
ADMISSIBLE: Mapping[str, Range] = {
    "v_n": APPROACHING,
    "radius": POSITIVE,
    "friction": NON_NEGATIVE,
    **dict.fromkeys(("e", "R", "rho"), UNIT_INTERVAL),
    "v_t": VELOCITY,
    "omega": SPIN,
    "mu": FINITE,
    "spin_ratio": FINITE,
    "angle": Range(lower=0.0, upper=np.pi / 2, upper_closed=True),
    "slope": Range(lower=-np.pi / 2, upper=np.pi / 2),
}

INERTIA, SLIP_PER_IMPULSE = passes.INERTIA, passes.SLIP_PER_IMPULSE


class RigidBodyRebound(NamedTuple):
    """Velocities after impact (m/s, rad/s) and the signed impulse ratio."""

    V_n: FloatArray
    V_t: FloatArray
    Omega: FloatArray
    mu: FloatArray


class EnergyLoss(NamedTuple):
    """Losses as fractions of the initial translational kinetic energy."""

    translational: FloatArray
    total: FloatArray


def admitted(**arguments: object) -> list[Real]:
    """Return arguments of the rigid body model, each checked by its name in `ADMISSIBLE`.

    Raises TypeError, ValueError if one is not a number or out of range, or the shapes do not
    broadcast.
    """
    values = {name: checked(name, value, ADMISSIBLE[name]) for name, value in arguments.items()}
    common_shape(values)
    return list(values.values())


def rolling_impulse_ratio(v_n: Real, slip: Real, e: Real) -> Real:
    """Signed impulse ratio mu_0 that just stops the slip ``v_t - r omega``, Eqs. (12), (13).

    Parameters
    ----------
    v_n
        Normal velocity, m/s, negative.
    slip
        Slip v_t - r omega, m/s.
    e
        Coefficient of restitution.
    """
    return 2.0 * slip / (7.0 * (1.0 + e) * v_n)


def rigid_body_rebound(
    v_n: object, v_t: object, omega: object, radius: object, e: object, friction: object
) -> RigidBodyRebound:
    """Rebound of a sphere with given restitution and Coulomb friction, Eqs. (6)-(8), (11)-(13).

    The impulse ratio is ``mu = sign(mu_0) min(f, |mu_0|)``. Eq. (8) is used with r in place of the
    printed k^2, which would not be a velocity over a length.

    Parameters
    ----------
    v_n, v_t
        Normal (negative) and tangential velocity before impact, m/s.
    omega
        Spin before impact, rad/s.
    radius
        Radius of the sphere, m.
    e
        Coefficient of restitution, in [0, 1].
    friction
        Coulomb coefficient f.

    Returns
    -------
    RigidBodyRebound
        V_n, V_t, Omega, mu; the arguments broadcast.

    Raises
    ------
    TypeError, ValueError
        If an argument is not a number or out of range, or the shapes do not broadcast.
    """
    v_n, v_t, omega, radius, e, friction = admitted(
        v_n=v_n, v_t=v_t, omega=omega, radius=radius, e=e, friction=friction
    )
    mu_0 = rolling_impulse_ratio(v_n, v_t - radius * omega, e)
    mu = np.sign(mu_0) * np.minimum(friction, np.abs(mu_0))
    change = mu * (1.0 + e) * v_n
    spin = omega + change / (INERTIA * radius)
    values = np.broadcast_arrays(-e * v_n, v_t - change, spin, mu)
    return RigidBodyRebound(*(value[()] for value in values))


def energy_loss(
    v_n: object, v_t: object, omega: object, radius: object, e: object, mu: object
) -> EnergyLoss:
    """Energy lost in a rebound, translational (Eq. 3) and total, from the impulse ratio.

    The total loss is Eq. (14) with 7/2 in front of ``mu^2 (1+e)^2``. Eq. (14) as printed is the
    translational loss of a sphere without initial spin; here it holds for any spin, with v_t/v_n in
    place of eta. Errors as of `rigid_body_rebound`.

    Parameters
    ----------
    v_n, v_t
        Velocity before, m/s, v_n negative.
    omega
        Spin before, rad/s.
    radius
        Radius of the sphere, m.
    e
        Coefficient of restitution.
    mu
        Signed impulse ratio.
    """
    v_n, v_t, omega, radius, e, mu = admitted(
        v_n=v_n, v_t=v_t, omega=omega, radius=radius, e=e, mu=mu
    )
    impulse = mu * (1.0 + e)
    tangent = v_t / v_n
    eta = (v_t - radius * omega) / v_n
    scale = 1.0 + np.square(tangent)
    normal = 1.0 - np.square(e)
    return EnergyLoss(
        (normal + 2.0 * impulse * tangent - np.square(impulse)) / scale,
        (normal + 2.0 * impulse * eta - 3.5 * np.square(impulse)) / scale,
    )


def adhesion_work(v_n: object, R: object, rho: object) -> Real:
    """Energy lost to adhesion per unit mass, Eq. (18): ``v_n^2 R^2 rho (2 - rho) / 2``, m2/s2.

    Parameters
    ----------
    v_n
        Normal velocity before impact, m/s.
    R
        Coefficient of restitution in the absence of adhesion.
    rho
        Adhesion coefficient of Eq. (10).
    """
    v_n = checked("v_n", v_n, FINITE)
    R, rho = admitted(R=R, rho=rho)
    return 0.5 * np.square(v_n) * np.square(R) * rho * (2.0 - rho)


def deformation_impulse(v_n: object, R: object) -> Real:
    """Total impulse of deformation per unit mass, Eq. (9): ``-(1 + R) v_n``, m/s."""
    v_n, R = admitted(v_n=v_n, R=R)
    return -(1.0 + R) * v_n


def adhesion_impulse(v_n: object, R: object, rho: object) -> Real:
    """Rebound impulse of adhesion per unit mass, Eq. (10): ``rho R v_n``, m/s (negative).

    Parameters
    ----------
    v_n
        Normal velocity before, m/s, negative.
    R
        Coefficient of restitution without adhesion.
    rho
        Part of the rebound impulse that adhesion takes back.
    """
    v_n, R, rho = admitted(v_n=v_n, R=R, rho=rho)
    return rho * R * v_n


def restitution_with_adhesion(R: object, rho: object) -> Real:
    """Coefficient of restitution, root of Eq. (16): ``e = R (1 - rho)``."""
    R, rho = admitted(R=R, rho=rho)
    return R * (1.0 - rho)
