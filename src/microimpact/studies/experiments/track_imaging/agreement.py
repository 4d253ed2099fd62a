"""The error model of imaging held against rendered frames, event by event, over experiments."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.random import Generator

from microimpact.core.arrays import FloatArray
from microimpact.declared.parameters import Fraction, Positive
from microimpact.lab.events import Impacts
from microimpact.lab.ptis.errors import theory
from microimpact.lab.ptis.experiment import quantities
from microimpact.lab.ptis.exposure import MEASURED
from microimpact.lab.ptis.observation import Observation, modelled, observe
from microimpact.lab.ptis.system import Setup, draw_systematics, event_generator
from microimpact.studies.experiments.track_imaging.impacts import (
    LEGS,
    true_velocities,
    velocities,
)

# An experiment with fewer events in frames or model has no mean to compare.
FEWEST_EVENTS = 5
# A value is decided when it is farther from its bound than so many of its standard errors.
DECIDED = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerances:
    """How far frames and error model may differ and still agree.

    Attributes
    ----------
    speed
        Mean deviation of the speed of a leg, relative.
    direction_deg
        Mean deviation of the direction of a leg.
    scatter
        Scatter of frames about the model over that which the model gives, or its inverse.
    share_measured
        Difference of the shares of the events that are measured.
    other_outcome
        Share of the events of which one is measured and the other is not.
    means
        Difference of the means of restitution, impulse ratio and energy loss of an experiment.
    """

    speed: Positive
    direction_deg: Positive
    scatter: Positive
    share_measured: Fraction
    other_outcome: Fraction
    means: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Compared:
    """One experiment of n events as frames and as the error model have it.

    Attributes
    ----------
    frames, model
        What is measured.
    residual, spread
        Frame minus mean of the model, and its standard deviation by the model, of the k events
        that both measure: legs, along and across the track, m/s, shape (k, 2, 2).
    error
        Deviation of the frames from the truth, relative to the speed, shape (k, 2, 2).
    speed
        True speed of the legs, m/s, shape (k, 2).
    """

    frames: Observation
    model: Observation
    residual: FloatArray
    spread: FloatArray
    error: FloatArray
    speed: FloatArray


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
    frames, model = observe(impacts, setup, rng), modelled(impacts, setup, rng)
    errors = draw_systematics(setup.instrument, rng)
    draws = [event_generator(rng, i) for i in range(len(impacts))]
    fates, expected = theory(impacts, setup, errors, draws)
    both, of_frames, of_model = np.intersect1d(
        frames.measured.event, np.flatnonzero(fates == MEASURED), return_indices=True
    )
    seen, mean = velocities(frames.measured)[of_frames], expected.velocities[of_model]
    true = true_velocities(impacts)[both]
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
    """Yield a row per component: how frames scatter about the error model."""
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

    Biases and means are the largest over legs and cases, scatter and shares are of all events.
    """
    experiments = [one for _, of in cases for one in of]
    for k, (name, unit, scale, tolerance) in enumerate(
        (
            ("largest bias of speed", "1", 1.0, tolerances.speed),
            ("largest bias of direction", "deg", np.degrees(1.0), tolerances.direction_deg),
        )
    ):
        biases = []
        for _, of in cases:
            off = np.concatenate([scale * one.residual[..., k] / one.speed for one in of])
            mean, sd = np.abs(off.mean(axis=0)), off.std(axis=0, ddof=1)
            biases += zip(mean.tolist(), (sd / np.sqrt(len(off))).tolist(), strict=True)
        yield verdict(name, unit, *max(biases), tolerance)
    normalised = np.concatenate([(one.residual / one.spread).ravel() for one in experiments])
    scatter = np.abs(np.log(np.sqrt(np.mean(normalised**2))))
    yield verdict(
        "scatter of frames over model, logarithm",
        "1",
        scatter,
        1.0 / np.sqrt(2.0 * normalised.size),
        np.log(tolerances.scatter),
    )
    seen = [
        np.concatenate([np.array(getattr(one, by).fates) == MEASURED for one in experiments])
        for by in ("frames", "model")
    ]
    apart = seen[0].astype(float) - seen[1]
    for name, share, tolerance in (
        ("share measured, frames less model", apart, tolerances.share_measured),
        ("share with another outcome", np.abs(apart), tolerances.other_outcome),
    ):
        error = share.std(ddof=1) / np.sqrt(share.size)
        yield verdict(name, "1", abs(share.mean()), error, tolerance)
    for name, of in _means_apart(experiments).items():
        yield verdict(f"largest difference of means of {name}", "1", *max(of), tolerances.means)


def _means_apart(experiments: Sequence[Compared]) -> dict[str, list[tuple[float, float]]]:
    """Return differences of means between frames and model, with their standard errors."""
    apart: dict[str, list[tuple[float, float]]] = {}
    for one in experiments:
        frames, model = one.frames.measured, one.model.measured
        _, of_frames, of_model = np.intersect1d(frames.event, model.event, return_indices=True)
        if len(of_frames) < FEWEST_EVENTS:
            continue
        both = quantities(frames), quantities(model)
        for name, seen in both[0].items():
            off = abs(seen.mean() - both[1][name].mean())
            noise = (seen[of_frames] - both[1][name][of_model]).std(ddof=1)
            error = noise / np.sqrt(len(of_frames))
            apart.setdefault(name.replace("_", " "), []).append((float(off), float(error)))
    return apart


def verdict(
    quantity: str, unit: str, value: float, standard_error: float, tolerance: float
) -> dict[str, Any]:
    """Return a row that says whether a size is below its tolerance, as far as it is known."""
    room = tolerance - value
    decided = abs(room) >= DECIDED * standard_error
    return {
        "quantity": quantity,
        "value": float(value),
        "unit": unit,
        "standard_error": float(standard_error),
        "tolerance": float(tolerance),
        "verdict": ("agrees" if room >= 0.0 else "differs") if decided else "undecided",
        "evidence": "virtual experiment",
    }
