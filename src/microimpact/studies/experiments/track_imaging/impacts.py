"""Impacts for tests of the imaging system, and its reports set against the truth."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import scipy

from microimpact.core.arrays import FloatArray
from microimpact.declared.parameters import Fraction, NonNegative, Positive
from microimpact.lab.events import Impacts, Measured
from microimpact.lab.ptis.errors import Expected
from microimpact.lab.ptis.observation import Observation
from microimpact.lab.ptis.system import Setup
from microimpact.model.dynamics.impact import velocity_components
from microimpact.model.rigid_body.algebra import rigid_body_rebound

LEGS = ("incident", "rebound")
COMPONENTS = tuple(f"{leg}, {part}" for leg in LEGS for part in ("along", "across"))


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


def residuals(seen: Observation, theory: list[Expected | str], true: FloatArray) -> pd.DataFrame:
    """Return frame minus model along and across the track, in m/s and in its spread.

    Rows: events that both report; columns: component, residual, its spread by the model, and
    the relative deviation from the truth (or the angle, in radians).
    """
    rows = []
    for event, found in zip(seen.measured.event, velocities(seen.measured), strict=True):
        model = theory[event]
        if isinstance(model, str):
            continue
        for leg in range(2):
            speed = float(np.linalg.norm(true[event, leg]))
            along = model.velocities[leg] / np.linalg.norm(model.velocities[leg])
            axes = np.array([along, [-along[1], along[0]]])
            off = axes @ (found[leg] - model.velocities[leg])
            spread = np.sqrt(np.diag(axes @ model.covariance[leg] @ axes.T))
            error = axes @ (found[leg] - true[event, leg]) / speed
            rows += [
                (COMPONENTS[2 * leg + k], off[k], spread[k], error[k], spread[k] / speed)
                for k in range(2)
            ]
    columns = ["component", "residual", "spread", "relative_error", "relative_spread"]
    return pd.DataFrame(rows, columns=columns)


def residual_rows(setup: Setup, found: pd.DataFrame, agree: float) -> Iterator[dict[str, Any]]:
    """Yield a row per component: how frames scatter about the error model, and how normally."""
    for component in COMPONENTS:
        own = found[found["component"] == component]
        normalised = (own["residual"] / own["spread"]).to_numpy()
        test = scipy.stats.kstest(normalised, scipy.stats.norm.cdf)
        yield {
            "speed_m_per_s": setup.speed,
            "angle_deg": setup.angle,
            "component": component,
            "events": len(own),
            "mean_relative_error": float(own["relative_error"].mean()),
            "modelled_relative_sd": float(np.sqrt(np.mean(own["relative_spread"] ** 2))),
            "normalised_mean": float(normalised.mean()),
            "normalised_sd": float(normalised.std(ddof=1)),
            "ks_statistic": float(test.statistic),
            "ks_p_value": float(test.pvalue),
            "selection_agrees": agree,
        }
