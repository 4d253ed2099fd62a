"""Restitution and energy loss over speed and angle, and by the normal speed alone."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from microimpact.lab.experiment import SpeedClass
from microimpact.lab.reduction import EXACT, Mean
from microimpact.model.dynamics.impact import simulate, velocity_components
from microimpact.model.rigid_body.algebra import energy_loss, rigid_body_rebound
from microimpact.statistics.intervals import ERROR_BAR
from study.declared.parameters import AngleDegrees, CaseName, Fraction, Name, NonNegative
from study.studies.experiments.mechanisms.impulse_regions import regions
from study.studies.samples import Dropped, Sample, Sampling, half_width
from study.tables import Tables

# Angles at which the slope of the rigid body's energy loss is looked at.
LOSS_ANGLES = 23
# Angles at which regions of the impulse ratio are looked for, denser than the article's 14.
REGION_ANGLES = np.array(
    [*range(87, 54, -3), *range(55, 44, -2), *range(42, 17, -3), 16, 14, *range(12, 7, -1)], float
)


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedAndAngle:
    """Speed classes of one kind of spheres, and the energy loss of the rigid body."""

    # Spheres, calibrated contacts, speed classes from the fastest.
    dropped: Dropped
    cases: tuple[CaseName, ...]
    classes: dict[Name, SpeedClass]
    # In descending order from the one with which the loss is compared.
    angles_deg: tuple[AngleDegrees, ...]
    trend_deg: tuple[AngleDegrees, AngleDegrees]  # Angles between which restitution falls
    # Grid on which the slope of the energy loss is looked at, and ends of its angles.
    loss_restitutions: tuple[Fraction, ...]
    loss_frictions: tuple[NonNegative, ...]
    loss_angles_deg: tuple[AngleDegrees, AngleDegrees]
    # Angle and restitutions of steel and spores there.
    resolved_deg: AngleDegrees
    resolved_restitutions: tuple[Fraction, Fraction]
    # Samples that give the scatter.
    resolved_steel: Dropped
    resolved_spore: Dropped
    constant_within: Fraction  # Relative change up to which the impulse ratio is constant


def speed_tables(
    params: SpeedAndAngle, sampling: Sampling, inputs: Tables
) -> dict[str, pd.DataFrame]:
    """Return the tables, by name."""
    rows, regions = [], []
    for case in params.cases:
        sample = Sample.of(replace(params.dropped, case=case), sampling, inputs)
        rows += [class_row(params, sample, each) for each in params.classes.values()]
        regions += region_rows(params, sample)
    return {
        "speed_and_angle": pd.DataFrame(rows),
        "impulse_regions": pd.DataFrame(regions),
        "loss_slopes": pd.DataFrame(loss_slopes(params)),
        "loss_resolution": pd.DataFrame([resolution(params, sampling, inputs)]),
    }


def class_row(params: SpeedAndAngle, sample: Sample, speed_class: SpeedClass) -> dict[str, Any]:
    """Restitution of the mean sphere and of the sieve class, and where the loss departs."""
    class_sample = sample.but(**asdict(speed_class))
    steep, shallow = sorted(params.trend_deg, reverse=True)
    sphere = simulate(sample.contact, speed_class.speed_m_per_s, np.array([steep, shallow]))
    e = sphere.coefficient_of_restitution
    losses = [class_sample.seen(angle).means["energy_loss"] for angle in params.angles_deg]
    departed = departures(params.angles_deg, losses, sample.sampling)
    return {
        "case": class_sample.dropped.case,
        "speed_m_per_s": speed_class.speed_m_per_s,
        "restitution_steep": e[0],
        "restitution_shallow": e[1],
        "fall_of_restitution": e[0] - e[1],
        "conditional_mean_steep": class_sample.mean("restitution", steep),
        "conditional_mean_shallow": class_sample.mean("restitution", shallow),
        "steep_deg": steep,
        "shallow_deg": shallow,
        "energy_loss_steep": losses[0].value,
        "first_departure_of_loss_deg": next(departed, np.nan),
        "evidence": "virtual experiment",
    }


def departures(
    angles: Sequence[float], losses: Sequence[Mean], sampling: Sampling
) -> Iterator[float]:
    """Yield the angles at which a loss differs from the first by more than its half-width."""
    for angle, loss in zip(angles[1:], losses[1:], strict=True):
        if abs(loss.value - losses[0].value) > half_width(loss, losses[0], sampling):
            yield angle


def region_rows(params: SpeedAndAngle, sample: Sample) -> list[dict[str, Any]]:
    """Regions of the mean impulse ratio of the fastest class."""
    class_sample = sample.but(**asdict(next(iter(params.classes.values()))))
    samples = [class_sample.seen(angle) for angle in REGION_ANGLES]
    means = np.array([s.means["impulse_ratio"].value for s in samples])
    known = np.isfinite(means)
    ratio = [s.means["impulse_ratio"] for s, k in zip(samples, known, strict=True) if k]
    counts = np.array([len(s.measured) for s in samples])[known]
    # The interval of one mean: that of its difference from an exactly known number.
    width = np.array([half_width(of, EXACT, class_sample.sampling) for of in ratio])
    scatter = np.array([of.sd for of in ratio]) / np.sqrt(counts)
    angles, means = REGION_ANGLES[known], means[known]
    return [
        {
            "case": class_sample.dropped.case,
            "speed_m_per_s": class_sample.dropped.speed_m_per_s,
            "errors": name,
        }
        | row
        | {"evidence": "virtual experiment"}
        for name, error in (("sample", scatter), ("experiment", width / ERROR_BAR))
        for row in regions(angles, means, error, params.constant_within)
    ]


def loss_slopes(params: SpeedAndAngle) -> Iterator[dict[str, Any]]:
    """Share of angles at which the rigid body's energy loss falls as the angle becomes shallow."""
    angle = np.linspace(*params.loss_angles_deg, LOSS_ANGLES)
    for e, friction in product(params.loss_restitutions, params.loss_frictions):
        falling = np.diff(rigid_loss(e, friction, angle)) / np.diff(angle) > 0.0
        rising = (0.5 * (angle[1:] + angle[:-1]))[~falling]
        yield {
            "restitution": e,
            "friction": friction,
            "share_falling": float(np.mean(falling)),
            "rising_from_deg": rising.max() if rising.size else np.nan,
            "rising_to_deg": rising.min() if rising.size else np.nan,
            "evidence": "computed",
        }


def rigid_loss(e: float, friction: float, angle: np.ndarray) -> np.ndarray:
    """Return T_L of a rigid sphere without spin at angles in degrees, Eqs. (12)-(14)."""
    v_n, v_t = velocity_components(1.0, angle)
    rebound = rigid_body_rebound(v_n, v_t, 0.0, 1.0, e, friction)
    return np.asarray(energy_loss(v_n, v_t, 0.0, 1.0, e, rebound.mu).translational)


def resolution(params: SpeedAndAngle, sampling: Sampling, inputs: Tables) -> dict[str, Any]:
    """Differences of printed restitutions and losses against the resolution of 40 events."""
    angle, both = params.resolved_deg, (params.resolved_steel, params.resolved_spore)
    smooth, rough = (Sample.of(dropped, sampling, inputs).seen(angle).means for dropped in both)
    e = params.resolved_restitutions
    losses = [
        float(rigid_loss(value, dropped.friction, np.array(angle)))
        for value, dropped in zip(e, both, strict=True)
    ]
    width, width_of_loss = (
        half_width(smooth[name], rough[name], sampling) for name in ("restitution", "energy_loss")
    )
    return {
        "angle_deg": angle,
        "difference_of_restitutions": e[0] - e[1],
        "half_width_of_restitutions": width,
        "difference_of_restitutions_over_half_width": (e[0] - e[1]) / width,
        "difference_of_losses": losses[1] - losses[0],
        "normal_part_of_difference": np.sin(np.radians(angle)) ** 2 * (e[0] ** 2 - e[1] ** 2),
        "half_width_of_losses": width_of_loss,
        "difference_of_losses_over_half_width": (losses[1] - losses[0]) / width_of_loss,
        "evidence": "virtual experiment",
    }
