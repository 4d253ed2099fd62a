"""Impact on a slope of a rough surface, Section 4.1, Eqs. (35)-(41).

Angles are in radians here: ``angle`` is the nominal angle of incidence alpha from the surface,
``slope`` the angle phi by which the surface faces the sphere where it strikes, so that the sphere
meets the local surface at alpha + phi. Signs are those of `rigid_body`: v_n < 0 before impact, mu
negative where friction opposes v_t > 0. Spin is given as r omega / v, v the speed before impact.

The primed velocities, along the local surface, are ``v'_t = v cos(alpha + phi)`` and ``v'_n = -v
sin(alpha + phi)``; turned back by phi, ``V_n = V'_n cos(phi) + V'_t sin(phi)``, and v_n likewise.
Each expansion comes as it should be, and with ``printed=True`` as the article has it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from microimpact.core.arrays import BoolArray, FloatArray, Range, Real, checked
from microimpact.model.rigid_body.algebra import INERTIA, admitted, rigid_body_rebound

# Share of its slip that a sphere has lost in tangential velocity when it rolls: 2/7.
ROLLING_SHARE = INERTIA / (1.0 + INERTIA)


class RoughRebound(NamedTuple):
    """Impulse ratio about the local normal, and the quantities measured about the nominal one.

    `rolling` is False where the sphere slides throughout. A measured restitution below zero is a
    sphere that moves on towards the nominal surface and has to strike it again.
    """

    impulse_ratio: FloatArray
    measured_restitution: FloatArray
    measured_impulse_ratio: FloatArray
    rolling: BoolArray


def rough_rebound(
    angle: object, slope: object, e: object, friction: object, spin_ratio: object = 0.0
) -> RoughRebound:
    """Rebound from a slope by the rigid body model, and its coefficients as measured.

    Parameters
    ----------
    angle, slope
        Nominal angle of incidence, in (0, pi/2], and slope, rad; the slope must face the sphere.
    e
        Coefficient of restitution about the local normal, in [0, 1].
    friction
        Coulomb coefficient f.
    spin_ratio
        r omega / v before impact.

    Returns
    -------
    RoughRebound
        Arrays of the common shape.

    Raises
    ------
    TypeError, ValueError
        If an argument is not a number or out of range, the slope faces away from the sphere, or
        the shapes do not broadcast.
    """
    angle, slope, e, friction, spin_ratio = _facing(
        angle=angle, slope=slope, e=e, friction=friction, spin_ratio=spin_ratio
    )
    local = angle + slope
    mu = rigid_body_rebound(-np.sin(local), np.cos(local), spin_ratio, 1.0, e, friction).mu
    measured = measured_restitution(angle, slope, e, mu), measured_impulse_ratio(slope, mu)
    values = np.broadcast_arrays(mu, *measured, np.abs(mu) < friction)
    return RoughRebound(*(value[()] for value in values))


def measured_restitution(
    angle: object, slope: object, e: object, mu: object, *, printed: bool = False
) -> Real:
    """Restitution about the nominal normal, Eq. (35) with + in the denominator.

    ``e_m = (e cos phi - (V'_t/v'_n) sin phi)/(cos phi + (v'_t/v'_n) sin phi)``, where ``v'_t/v'_n``
    is ``-cot(alpha + phi)`` and ``V'_t/v'_n`` is less by mu (1 + e), of the local normal.
    The denominator is ``sin(alpha)/sin(alpha + phi)``; with the printed minus it would be
    ``sin(alpha + 2 phi)/sin(alpha + phi)``, which vanishes at phi = -alpha/2: there e_m is
    infinite.

    Parameters
    ----------
    angle
        Angle of incidence alpha from the nominal surface, rad.
    slope
        Slope phi of the facet, rad; positive if it faces the sphere.
    e
        Coefficient of restitution about the local normal.
    mu
        Signed impulse ratio about the local normal.
    printed
        Whether Eq. (35) is taken as printed.
    """
    angle, slope, e, mu = _facing(angle=angle, slope=slope, e=e, mu=mu)
    local = angle + slope
    into = mu * (1.0 + e) * np.sin(local) + np.cos(local)
    after = e * np.cos(slope) * np.sin(local) + into * np.sin(slope)
    before = np.sin(angle + 2.0 * slope) if printed else np.sin(angle)
    with np.errstate(divide="ignore"):
        ratio: Real = np.divide(after, before)
    return ratio


def measured_impulse_ratio(slope: object, mu: object) -> Real:
    """Signed impulse ratio about the nominal normal, Eq. (36): the impulse turned by phi."""
    slope, mu = admitted(slope=slope, mu=mu)
    return (mu - np.tan(slope)) / (1.0 + mu * np.tan(slope))


def shallow_restitution(
    angle: object, slope: object, e: object, mu: object, *, printed: bool = False
) -> Real:
    """Measured restitution at shallow incidence of a sliding sphere, Eq. (37).

    ``e_m = (1 + phi/alpha) (e + phi/(phi + alpha)) + mu (1 + e) phi (1 + phi/alpha)``, mu = -f: the
    last term, which is not printed, is the next order in the angles. Where phi > 0 it is less than
    ``f (1 + e) (alpha + phi)`` of the others: that must be small, not the printed f/alpha.

    Parameters
    ----------
    angle, slope, e, mu
        As of `measured_restitution`; the angles are small.
    printed
        Whether the last term is left out, as in print.
    """
    angle, slope, e, mu = _facing(angle=angle, slope=slope, e=e, mu=mu)
    steeper = 1.0 + slope / angle
    leading = e * steeper + slope / angle
    return leading if printed else leading + mu * (1.0 + e) * slope * steeper


def sloped_impulse_ratio(slope: object, mu: object, *, printed: bool = False) -> Real:
    """Measured impulse ratio on a small slope, Eq. (38): ``mu_m = mu - (1 + mu^2) phi``.

    Printed without mu^2. For v_t > 0 mu is -f, so ``|mu_m|`` is f + phi at first order: a slope
    that faces the sphere lowers the signed ratio and raises its size.

    Parameters
    ----------
    slope, mu
        As of `measured_restitution`; the slope is small.
    printed
        Whether mu^2 is left out, as in print.
    """
    slope, mu = admitted(slope=slope, mu=mu)
    return mu - slope * (1.0 if printed else 1.0 + np.square(mu))


def normal_restitution(slope: object, e: object, mu: object, *, printed: bool = False) -> Real:
    """Measured restitution at normal incidence, Eq. (39).

    ``e_m = e - (1 + e) phi^2 + (1 + e) mu phi``, from the exact ``e cos^2 phi - sin^2 phi + (1 + e)
    mu sin phi cos phi``; mu is mu_0 of Eq. (40) where the sphere rolls. Printed without the e phi^2
    that the denominator of Eq. (35) brings.

    Parameters
    ----------
    slope, e, mu
        As of `measured_restitution`; the slope is small.
    printed
        Whether the term e phi^2 is left out, as in print.
    """
    slope, e, mu = admitted(slope=slope, e=e, mu=mu)
    bend = 1.0 if printed else 1.0 + e
    return e - bend * np.square(slope) + (1.0 + e) * mu * slope


def rolling_restitution(
    slope: object, e: object, spin_ratio: object = 0.0, *, printed: bool = False
) -> Real:
    """Measured restitution at normal incidence of a sphere that ends rolling (below Eq. 40).

    ``e_m = e - (e + 5/7) phi^2 + (2/7) (r omega/v) phi``, from the exact ``e cos^2 phi - (5/7)
    sin^2 phi + (2/7) (r omega/v) sin phi``. Without spin ``v'_t/v'_n = tan phi``, so that (1 + e)
    mu_0 is +2 phi/7; the article has -2 phi/7, hence e - 9 phi^2/7, and no number for the spin.

    Parameters
    ----------
    slope, e
        As of `measured_restitution`; the slope is small.
    spin_ratio
        r omega/v.
    printed
        Whether e - 9 phi^2/7 is taken, as in print.
    """
    slope, e, spin_ratio = admitted(slope=slope, e=e, spin_ratio=spin_ratio)
    if printed:
        return e - 9.0 / 7.0 * np.square(slope)
    bend = e + 1.0 - ROLLING_SHARE
    return e - bend * np.square(slope) + ROLLING_SHARE * spin_ratio * slope


def rolling_impulse_ratio_measured(
    slope: object, e: object, spin_ratio: object = 0.0, *, printed: bool = False
) -> Real:
    """Measured impulse ratio at normal incidence of a sphere that ends rolling, Eq. (41).

    ``mu_m = -phi (1 - c + s^2) + s`` with ``c = (2/7)/(1 + e)`` and ``s = c r omega/v``, the
    impulse ratio of the spin alone. Printed are -s (v'_n < 0 makes the term positive) and no s^2.

    Parameters
    ----------
    slope, e
        As of `measured_restitution`; the slope is small.
    spin_ratio
        r omega/v.
    printed
        Whether Eq. (41) is taken as printed.
    """
    slope, e, spin_ratio = admitted(slope=slope, e=e, spin_ratio=spin_ratio)
    share = ROLLING_SHARE / (1.0 + e)
    spun = share * spin_ratio
    if printed:
        return -slope * (1.0 - share) - spun
    return -slope * (1.0 - share + np.square(spun)) + spun


def energy_bound(angle: object, spin_ratio: object = 0.0) -> Real:
    """Greatest measured restitution that energy allows.

    ``sqrt(1 + (2/5) (r omega/v)^2)/sin alpha``: all energy, that of the spin included, in the
    nominal normal velocity.
    """
    angle, spin_ratio = admitted(angle=angle, spin_ratio=spin_ratio)
    return np.sqrt(1.0 + INERTIA * np.square(spin_ratio)) / np.sin(angle)


def _facing(**arguments: object) -> list[Real]:
    """Return checked arguments, of which angle and slope, the first, let the sphere arrive."""
    angle, slope, *others = admitted(**arguments)
    checked("angle + slope", angle + slope, Range(lower=0.0, upper=np.pi))
    return [angle, slope, *others]
