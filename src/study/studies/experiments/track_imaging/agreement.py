"""The error model of imaging held against rendered frames, event by event, over experiments."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.random import Generator

from microimpact.core.arrays import FloatArray
from microimpact.lab.events import Impacts
from microimpact.lab.ptis.exposure import MEASURED
from microimpact.lab.ptis.observation import ImagedEvents, modelled, observe
from microimpact.lab.ptis.system import Setup, draw_systematics
from microimpact.lab.reduction import quantities
from microimpact.model.dynamics.impact import velocity_components
from microimpact.model.rigid_body.algebra import rigid_body_rebound
from study.declared.parameters import Fraction, NonNegative, Positive

LEGS = ("incident", "rebound")


@dataclass(frozen=True, slots=True, kw_only=True)
class RigidSpheres:
    """Spheres of one size that rebound by the rigid body rule, so that the truth is simple."""

    diameter_um: Positive  # Of all of them
    # Of the rigid body rule.
    restitution: Fraction
    friction: NonNegative
    # Standard deviations per horizontal axis.
    lateral_speed_m_per_s: NonNegative
    lateral_position_mm: NonNegative


def impacts(
    particles: RigidSpheres, n: int, speed: float, angle: float, rng: np.random.Generator
) -> Impacts:
    """Return n impacts at a speed in m/s and an angle of incidence in degrees."""
    alpha = np.radians(angle)
    v_n, v_t = velocity_components(speed, angle)
    lateral = particles.lateral_speed_m_per_s * rng.standard_normal((n, 2))
    position = 1e-3 * particles.lateral_position_mm * rng.standard_normal((n, 2))
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
        position=position / [np.sin(alpha), 1.0],
        velocity=velocity,
        spin=np.zeros((n, 3)),
        rebound_velocity=after,
        rebound_spin=np.zeros((n, 3)),
        captured=np.zeros(n, dtype=bool),
        contacts=np.ones(n, dtype=np.int64),
    )


def speed_and_angle_errors(measured: FloatArray, true: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return relative errors of the speed and errors of its direction (degrees), each (k, 2)."""
    speed = np.linalg.norm(measured, axis=2) / np.linalg.norm(true, axis=2) - 1.0
    turned = measured[..., 0] * true[..., 1] - measured[..., 1] * true[..., 0]
    angle = np.degrees(np.arctan2(turned, np.sum(measured * true, axis=2)))
    return speed, angle


# An experiment with fewer events in frames or model has no mean to compare.
FEWEST_EVENTS = 5
# A value is decided when it is farther from its bound than so many of its standard errors.
DECIDED = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerances:
    """How far frames and error model may differ and still agree."""

    speed: Positive  # Mean deviation of the speed of a leg, relative
    direction_deg: Positive  # Mean deviation of the direction of a leg
    # Scatter of frames about the model over that which the model gives, or its inverse.
    scatter: Positive
    share_measured: Fraction  # Difference of the shares of the events that are measured
    other_outcome: Fraction  # Share of the events of which one is measured and the other is not
    # Difference of the means of restitution, impulse ratio and energy loss of an experiment.
    means: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Compared:
    """One experiment of n events as frames and as the error model have it."""

    # What is measured.
    frames: ImagedEvents
    model: ImagedEvents
    # Frame minus mean of the model, and its standard deviation by the model, of the k events that
    # both measure: legs, along and across the track, m/s, shape (k, 2, 2).
    residual: FloatArray
    spread: FloatArray
    # Deviation of the frames from the truth, relative to the speed, shape (k, 2, 2).
    error: FloatArray
    speed: FloatArray  # True speed of the legs, m/s, shape (k, 2)


def compared(impacts: Impacts, setup: Setup, rng: Generator) -> Compared:
    """Observe one experiment both ways, with the same errors of the experiment.

    Parameters
    ----------
    impacts
        Which all rebound.
    setup
        The instrument as set.
    rng
        Of the experiment.
    """
    errors = draw_systematics(setup.instrument, rng)
    frames, model = (of(impacts, setup, errors, rng) for of in (observe, modelled))
    expected = model.expected
    assert expected is not None
    both, of_frames, of_model = np.intersect1d(
        frames.measured.event, model.measured.event, return_indices=True
    )
    seen, mean = frames.measured.velocities[of_frames], expected.velocities[of_model]
    true = impacts.in_plane.velocities[both]
    along = mean / np.linalg.norm(mean, axis=-1, keepdims=True)
    axes = np.stack([along, np.stack([-along[..., 1], along[..., 0]], axis=-1)], axis=-2)
    turned = axes @ expected.covariance[of_model] @ np.swapaxes(axes, -1, -2)
    speed = np.linalg.norm(true, axis=-1)
    return Compared(
        frames=frames,
        model=model,
        residual=(axes @ (seen - mean)[..., None])[..., 0],
        spread=np.sqrt(np.diagonal(turned, axis1=-2, axis2=-1)),
        error=(axes @ (seen - true)[..., None])[..., 0] / speed[..., None],
        speed=speed,
    )


def residual_rows(setup: Setup, experiments: Sequence[Compared]) -> Iterator[dict[str, Any]]:
    """Yield a row per component: how frames scatter about the error model, if they can."""
    if sum(len(one.residual) for one in experiments) < FEWEST_EVENTS:
        return
    residual, spread, error, speed = (
        np.concatenate([getattr(one, name) for one in experiments])
        for name in ("residual", "spread", "error", "speed")
    )
    for leg, name in enumerate(LEGS):
        for k, component in enumerate(("along", "across")):
            normalised = residual[:, leg, k] / spread[:, leg, k]
            yield {
                "speed_m_per_s": setup.speed,
                "angle_deg": setup.angle,
                "component": f"{name}, {component}",
                "events": len(normalised),
                "mean_relative_error": float(error[:, leg, k].mean()),
                "mean_relative_residual": float((residual[:, leg, k] / speed[:, leg]).mean()),
                "modelled_relative_sd": float(
                    np.sqrt(np.mean((spread[:, leg, k] / speed[:, leg]) ** 2))
                ),
                "normalised_mean": float(normalised.mean()),
                "normalised_sd": float(normalised.std(ddof=1)),
            }


def verdicts(
    cases: Sequence[tuple[Setup, Sequence[Compared]]], tolerances: Tolerances
) -> Iterator[dict[str, Any]]:
    """Yield a row per quantity: value, standard error, tolerance, and whether it is met.

    Biases are the largest over legs and cases, means over experiments; scatter and shares are of
    all events. What too few events leave open is not a number, and undecided.
    """
    experiments = [one for _, of in cases for one in of]
    pooled = [
        np.concatenate([one.residual / one.speed[..., None] for one in of]) for _, of in cases
    ]
    speed, direction = (
        [_mean(off[:, leg, k]) for off in pooled for leg in range(len(LEGS))] for k in range(2)
    )
    degrees = [(float(np.degrees(value)), float(np.degrees(error))) for value, error in direction]
    yield verdict("largest bias of speed", "1", speed, tolerances.speed)
    yield verdict("largest bias of direction", "deg", degrees, tolerances.direction_deg)

    normalised = np.concatenate([(one.residual / one.spread).ravel() for one in experiments])
    n = normalised.size
    scatter = np.log(np.linalg.norm(normalised) / np.sqrt(n)) if n else np.nan
    ratio = abs(scatter), (2 * n or np.nan) ** -0.5
    name = "scatter of frames over model, logarithm"
    yield verdict(name, "1", [ratio], np.log(tolerances.scatter))

    frames, model = (
        np.concatenate([np.array(of.fates) == MEASURED for of in observed])
        for observed in zip(*((one.frames, one.model) for one in experiments), strict=True)
    )
    more = frames.astype(float) - model
    name = "share measured, frames less model"
    yield verdict(name, "1", [_mean(more)], tolerances.share_measured)
    name = "share with another outcome"
    yield verdict(name, "1", [_mean(np.abs(more))], tolerances.other_outcome)

    for name in quantities(experiments[0].frames.measured):
        apart = [_means_apart(one, name) for one in experiments]
        words = f"largest difference of means of {name.replace('_', ' ')}"
        yield verdict(words, "1", apart, tolerances.means)


def _mean(values: FloatArray) -> tuple[float, float]:
    """Return the size of a mean and its standard error; not numbers for too few values."""
    if len(values) < FEWEST_EVENTS:
        return np.nan, np.nan
    return float(abs(values.mean())), float(values.std(ddof=1) / np.sqrt(len(values)))


def _means_apart(sample: Compared, name: str) -> tuple[float, float]:
    """Return how far the means of frames and model are apart, and the noise of the difference."""
    frames, model = (quantities(of.measured)[name] for of in (sample.frames, sample.model))
    events = sample.frames.measured.event, sample.model.measured.event
    _, of_frames, of_model = np.intersect1d(*events, return_indices=True)
    _, noise = _mean(frames[of_frames] - model[of_model])
    return (np.nan if np.isnan(noise) else float(abs(frames.mean() - model.mean()))), noise


def verdict(
    quantity: str, unit: str, ratio: Sequence[tuple[float, float]], tolerance: float
) -> dict[str, Any]:
    """Return a row that says whether a size is below its tolerance, as far as it is known.

    Of sizes with their standard errors, the largest.
    """
    value, error = max((of for of in ratio if np.isfinite(of[0])), default=(np.nan, np.nan))
    decided = abs(tolerance - value) >= DECIDED * error
    return {
        "quantity": quantity,
        "value": value,
        "unit": unit,
        "standard_error": error,
        "tolerance": tolerance,
        "verdict": ("agrees" if value <= tolerance else "differs") if decided else "undecided",
        "evidence": "virtual experiment",
    }
