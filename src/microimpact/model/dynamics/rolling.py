"""Moments that oppose rolling: during an impact (Section 3.2.3), and on a captured sphere.

The equations of motion leave out the moment M of the contact area (Fig. 13). It is bounded and
estimated here, a the contact radius, F the compressive force, f_0 the ring force. A moment is
positive where it opposes the spin.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from microimpact.core.arrays import NON_NEGATIVE, POSITIVE, FloatArray, Range, Real, checked
from microimpact.core.constants import gravity
from microimpact.model.contact import Contact, require_contact
from microimpact.model.dynamics.trajectory import Trajectory, trajectory
from microimpact.model.rigid_body.algebra import INERTIA

TILT = Range(lower=0.0, upper=90.0, lower_closed=True, upper_closed=True)

# Times added about the instant at which the centre of the contact is at rest.
NEAR_REST = 301


@dataclass(frozen=True, slots=True)
class RollingImpulses:
    """Time integrals of moments over one impact, N m s, and how far it rolled.

    Attributes
    ----------
    friction
        r times the impulse of friction, which spins the sphere up.
    bound
        What no pressure without tension, and no ring force between zero and its greatest, exceeds.
    hysteresis
        Of deformation and of the whole ring force, where and while one part of the contact closes
        and another opens.
    damping
        From this model's own damping, applied at each point of the contact.
    rolled
        Distance rolled during contact, r times the angle turned, m.
    contact_radius
        Greatest contact radius, m.
    """

    friction: float
    bound: float
    hysteresis: float
    damping: float
    rolled: float
    contact_radius: float


def opening_level(contact_radius: Real, separation_speed: Real, spin: Real) -> Real:
    """Return ``h = u / (spin a)``, between -1 and 1.

    A point at x behind the centre opens at u + spin x. With h = 0 the leading half closes and the
    trailing half opens, as in steady rolling; at -1 the whole contact closes, at 1 it all opens.

    Parameters
    ----------
    contact_radius
        Contact radius a, m.
    separation_speed
        Speed u of the centre away from the surface, m/s.
    spin
        Spin, rad/s.
    """
    edge = np.abs(np.asarray(spin * contact_radius, dtype=np.float64))
    at_rest = np.asarray(np.sign(separation_speed) * np.ones_like(edge))
    level: Real = np.divide(separation_speed, edge, out=at_rest, where=edge > 0.0)
    return np.clip(level, -1.0, 1.0)


def deformation_moment(contact_radius: Real, force: Real, loss: Real, level: Real) -> Real:
    """Moment of hysteresis of deformation, N m: ``(3/16) loss a F (1 - h^2)^2``.

    Where the contact opens, Hertz's pressure is less by the share `loss`. On the part x > x_0 its
    moment about the centre is (3/16) a F (1 - (x_0/a)^2)^2; the boundary lies where `opening_level`
    says. With h = 0 this is rolling friction by Greenwood, Minshall and Tabor (1961).

    Parameters
    ----------
    contact_radius
        Contact radius a, m.
    force
        Hertz force F, N.
    loss
        Share by which the pressure is less where the contact opens.
    level
        h of `opening_level`.
    """
    return 3.0 / 16.0 * loss * contact_radius * force * np.square(1.0 - np.square(level))


def adhesion_moment(contact_radius: Real, ring_force: Real, level: Real = 0.0) -> Real:
    """Greatest moment of a ring force that holds only where the contact opens, N m.

    ``2 f a^2 sqrt(1 - h^2)``: f a^2 times the integral of cos(theta) over the part of the edge that
    opens (`opening_level`). With h = 0, all on the trailing half, it is the greatest moment of any
    ring force between zero and `ring_force`.

    Parameters
    ----------
    contact_radius
        Contact radius a, m.
    ring_force
        Ring force f, N/m.
    level
        h of `opening_level`.
    """
    return 2.0 * ring_force * np.square(contact_radius) * np.sqrt(1.0 - np.square(level))


def damping_moment(
    contact: Contact, contact_radius: Real, force: Real, rate: Real, spin: Real, level: Real
) -> Real:
    """Moment of the damping of Eq. (19) where rolling adds to the rate, N m.

    At x ahead of the centre the compression grows faster by spin x and the pressure p by ``c_H spin
    x p``, of moment ``c_H spin F a^2/5``, as x^2 averages a^2/5 over Hertz's pressure. A point of
    the edge at theta from the trailing end opens at ``spin a (h + cos(theta))``; its ring force is
    greater by c_A f_0 times that while positive, the moment ``c_A f_0 spin a^3 (arccos(-h) + h
    sqrt(1 - h^2))``.

    Parameters
    ----------
    contact
        Contact with c_H and f_0.
    contact_radius
        Contact radius a, m.
    force
        Hertz force F, N.
    rate
        c_A at the speed of the impact, s/m.
    spin
        Spin, rad/s.
    level
        h of `opening_level`.
    """
    bulk = 0.2 * contact.hertz_damping * force * np.square(contact_radius)
    share = np.arccos(-level) + level * np.sqrt(1.0 - np.square(level))
    edge = rate * np.asarray(contact.ring_force) * np.power(contact_radius, 3) * share
    return (bulk + edge) * spin


def rolling_impulses(
    contact: Contact, speed: float, angle: float, points: int = 400
) -> RollingImpulses:
    """Integrate the bound and estimates of the neglected moment over one impact without spin.

    The bound allows pressures without tension that sum to the compressive force, and a ring force
    between zero and what it is at the trailing end, ``f_0 (1 + c_A (u + spin a))``. Hysteresis is
    given all that the impact loses, 1 - e^2.

    Parameters
    ----------
    contact
        One contact (no arrays).
    speed, angle
        Speed before impact, m/s, and angle of incidence from the surface, degrees.
    points
        Times at which the impact is sampled.

    Raises
    ------
    ValueError
        If the sphere is captured, or an argument is not admissible.
    """
    require_contact(contact)
    path = trajectory(contact, speed, angle, points=points)
    if path.captured:
        raise ValueError(f"no rebound at speed {speed:g} m/s and angle {angle:g} deg")
    radius, ring_force = float(contact.radius), float(np.asarray(contact.ring_force))
    c_a = float(contact.adhesion_damping_at(-path.velocity[0]))
    time = _times(path, float(contact.hertz_radius))
    compression, velocity, spin, hertz, damped = (
        np.interp(time, path.time, values)
        for values in (
            path.compression,
            path.velocity,
            path.spin,
            path.hertz_force,
            path.hertz_damping_force,
        )
    )
    a = np.sqrt(contact.hertz_radius * compression)
    level = opening_level(a, velocity, spin)
    trailing = ring_force * (1.0 + c_a * np.maximum(velocity + spin * a, 0.0))
    loss = 1.0 - (path.velocity[-1] / path.velocity[0]) ** 2
    pressed = np.maximum(hertz + damped, 0.0)
    hysteresis = deformation_moment(a, hertz, loss, level) + adhesion_moment(a, trailing, level)
    return RollingImpulses(
        friction=radius * float(contact.mass) * float(np.ptp(path.tangential_velocity)),
        bound=float(np.trapezoid(a * pressed + adhesion_moment(a, trailing), time)),
        hysteresis=float(np.trapezoid(hysteresis, time)),
        damping=float(np.trapezoid(damping_moment(contact, a, hertz, c_a, spin, level), time)),
        rolled=float(np.trapezoid(radius * spin, time)),
        contact_radius=float(np.max(a)),
    )


def _times(path: Trajectory, hertz_radius: float) -> FloatArray:
    """Times of a path, closer where one part of the contact closes and another opens."""
    turn = int(np.argmax(path.compression))
    near = slice(max(turn - 1, 0), turn + 2)
    rest = np.interp(0.0, path.velocity[near], path.time[near])
    rate = np.ptp(path.velocity[near]) / np.ptp(path.time[near])
    edge = np.max(path.spin) * np.sqrt(hertz_radius * np.max(path.compression))
    window = rest + edge / rate * np.linspace(-1.5, 1.5, NEAR_REST)
    return np.union1d(path.time, np.clip(window, 0.0, path.time[-1]))


def peeling_moment(contact: Contact, shift: Real) -> Real:
    """Moment of adhesion that a rolling sphere has to overcome, N m: ``6 pi w_A r shift``.

    That is ``4 F_c shift`` with JKR's pull-off force F_c = 3/2 pi w_A r.

    Parameters
    ----------
    contact
        Contact with a work of adhesion.
    shift
        How far the contact area lags before its edge moves on, m (Dominik and Tielens 1995).
    """
    return 6.0 * math.pi * np.asarray(contact.work_of_adhesion) * contact.hertz_radius * shift


def rolling_distance(
    contact: Contact, tangential_velocity: object, shift: object, tilt: object = 0.0
) -> Real:
    """Distance that a captured sphere rolls, m; infinite where gravity keeps it rolling.

    It starts rolling with V_t, so with the energy (7/10) m V_t^2, and is held back by the force M/r
    of `peeling_moment`, less the weight along a target tilted downhill: ``(7/10) m V_t^2 / (M/r - m
    g sin(tilt))``. A sphere that struck without spin starts with V_t = (5/7) v_t.

    Parameters
    ----------
    contact
        The contact; its fields broadcast with the other arguments.
    tangential_velocity
        V_t after capture, m/s.
    shift
        Of `peeling_moment`, m.
    tilt
        Angle of the target from the horizontal, degrees, in [0, 90]; 0 leaves gravity out.
    """
    require_contact(contact)
    velocity = checked("tangential_velocity", tangential_velocity, NON_NEGATIVE)
    shift = checked("shift", shift, NON_NEGATIVE)
    tilt = checked("tilt", tilt, TILT)
    weight = contact.mass * gravity * np.sin(np.radians(tilt))
    hold = np.asarray(peeling_moment(contact, shift) / contact.radius - weight)
    energy = 0.5 * (1.0 + INERTIA) * contact.mass * np.square(velocity)
    shape = np.broadcast_shapes(hold.shape, np.shape(energy))
    distance = np.full(shape, np.inf)
    stop: Real = np.divide(energy, hold, out=distance, where=hold > 0.0)[()]
    return stop


def gravity_ratio(contact: Contact, shift: object, tilt: object) -> Real:
    """Ratio of the moments of weight and adhesion, ``m g r sin(tilt) / M``: above 1 it rolls.

    Parameters
    ----------
    contact
        Contact with a work of adhesion.
    shift
        How far the contact area lags, m, as of `peeling_moment`.
    tilt
        Slope of the surface, degrees.
    """
    require_contact(contact)
    shift, tilt = checked("shift", shift, POSITIVE), checked("tilt", tilt, TILT)
    weight = contact.mass * gravity * np.sin(np.radians(tilt))
    return weight * contact.radius / peeling_moment(contact, shift)
