"""Impacts with which the imaging system is tried, and its reports set against the truth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microimpact.core.arrays import FloatArray
from microimpact.declared.parameters import Fraction, NonNegative, Positive
from microimpact.lab.events import Impacts, Measured
from microimpact.model.dynamics.impact import velocity_components
from microimpact.model.rigid_body.algebra import rigid_body_rebound

LEGS = ("incident", "rebound")


@dataclass(frozen=True, slots=True, kw_only=True)
class Particles:
    """Spheres of one size that rebound by the rigid body rule, so that the truth is simple.

    Attributes
    ----------
    diameter_um
        Of all of them.
    restitution, friction
        Of the rigid body rule.
    lateral_speed_m_per_s, lateral_position_mm
        Standard deviations per horizontal axis.
    """

    diameter_um: Positive
    restitution: Fraction
    friction: NonNegative
    lateral_speed_m_per_s: NonNegative
    lateral_position_mm: NonNegative


def impacts(
    particles: Particles, n: int, speed: float, angle: float, rng: np.random.Generator
) -> Impacts:
    """Return n impacts at a speed in m/s and an angle of incidence in degrees."""
    alpha = np.radians(angle)
    v_n, v_t = velocity_components(speed, angle)
    lateral = particles.lateral_speed_m_per_s * rng.standard_normal((n, 2))
    place = 1e-3 * particles.lateral_position_mm * rng.standard_normal((n, 2))
    velocity = np.stack(
        [v_t + lateral[:, 0] * np.sin(alpha), lateral[:, 1], v_n + lateral[:, 0] * np.cos(alpha)],
        axis=1,
    )
    # Steered away from a nearly vertical target, a particle would never arrive.
    velocity[:, 2] = np.minimum(velocity[:, 2], 0.1 * v_n)
    along = np.hypot(velocity[:, 0], velocity[:, 1])
    radius = 0.5e-6 * particles.diameter_um
    rigid = rigid_body_rebound(
        velocity[:, 2], along, 0.0, radius, particles.restitution, particles.friction
    )
    after = velocity * (rigid.V_t / along)[:, None]
    after[:, 2] = rigid.V_n
    return Impacts(
        time=np.arange(n, dtype=float),
        diameter=np.full(n, 2.0 * radius),
        position=place / [np.sin(alpha), 1.0],
        velocity=velocity,
        spin=np.zeros((n, 3)),
        rebound_velocity=after,
        rebound_spin=np.zeros((n, 3)),
        captured=np.zeros(n, dtype=bool),
        contacts=np.ones(n, dtype=np.int64),
    )


def velocities(measured: Measured) -> FloatArray:
    """Return incident and rebound velocity, tangential and normal, (k, 2, 2), m/s."""
    rows = [
        [measured.incident_tangential, measured.incident_normal],
        [measured.rebound_tangential, measured.rebound_normal],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def true_velocities(events: Impacts) -> FloatArray:
    """Return what `velocities` should be of every impact, (n, 2, 2), m/s."""
    return np.stack([events.velocity[:, [0, 2]], events.rebound_velocity[:, [0, 2]]], axis=1)


def speed_and_angle_errors(found: FloatArray, true: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return relative errors of the speed and errors of its direction (degrees), each (k, 2)."""
    speed = np.linalg.norm(found, axis=2) / np.linalg.norm(true, axis=2) - 1.0
    turned = found[..., 0] * true[..., 1] - found[..., 1] * true[..., 0]
    angle = np.degrees(np.arctan2(turned, np.sum(found * true, axis=2)))
    return speed, angle
