"""Possible causes of spores' high measured restitution at shallow angles, each alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from microimpact.lab.events import Measured
from microimpact.lab.experiment import StopRule
from microimpact.lab.ptis.experiment import collect
from microimpact.lab.ptis.system import ImagingSystem
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.impact import simulate
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.rigid_body.eccentric import eccentric_rebound
from microimpact.statistics.distributions import generator
from study.declared.parameters import AngleDegrees, CaseName, Count, Fraction, NonNegative, Positive
from study.samples import (
    Dropped,
    Sample,
    Sampling,
    Seen,
    difference_columns,
    half_width,
    in_class,
    mean_columns,
    reduce_to,
    setting_for,
)
from study.tables import Tables

# Offsets are cut here: a point of contact lies on the lower half of the body.
LARGEST_OFFSET = 0.9


def off_centre(sample: Sample, angle: float, offset_sd: float) -> Seen:
    """Return a sample of bodies that touch a smooth plane off their centre, without spin.

    The offset along the motion, over the radius, is normal. Restitution at the point of contact,
    and the friction that its compressive impulse can support, are those of the sphere at its normal
    speed. Bodies that still move towards the plane count as captured.
    """
    impacts, sampling = sample.impacts(angle), sample.sampling
    inside = np.flatnonzero(in_class(sample.dropped, impacts))
    diameter, v = impacts.diameter[inside], impacts.velocity[inside]
    draws = generator(sampling.seed, 1).standard_normal(sampling.impacts)[inside]
    offset = np.clip(offset_sd * draws, -LARGEST_OFFSET, LARGEST_OFFSET)
    contact = resized(sample.contact, diameter)
    normal = normal_impact(contact, -v[:, 2])
    e = normal.coefficient_of_restitution
    pressed = normal.compressive_impulse / contact.mass
    after = eccentric_rebound(
        v[:, 2],
        v[:, 0],
        0.0,
        0.5 * diameter,
        offset,
        e,
        contact.friction * pressed / ((1.0 + e) * -v[:, 2]),
    )
    free = ~normal.captured & (after.V_n > 0.0)
    legs = v[:, ::2], np.stack([after.V_t, after.V_n], axis=1)
    measured = Measured(event=inside[free], velocities=np.stack(legs, axis=1)[free])
    return reduce_to(measured, inside.size, sampling)


def as_imaged(
    sample: Sample, angle: float, instrument: ImagingSystem, *, events: int, most_dropped: int
) -> Seen:
    """Return the sample as the camera sees it, without errors that its events share.

    Stops at `events` events or `most_dropped` particles.
    """
    exact = replace(instrument, rate_error=0.0, scale_error=0.0, angle_error_deg=0.0)
    sampling = sample.sampling
    drop = sample.dropped.drop(sample.contact, angle, sampling.dispenser)
    stop = StopRule(events=events, fewest_events=2, most_dropped=most_dropped)
    outcome = collect(drop, exact, stop, generator(sampling.seed, 2, round(10 * angle)))
    return reduce_to(outcome.measured, outcome.first, sampling)


# Angles (degrees) between which the article states trends.
TREND_DEG = (85.0, 45.0, 38.0, 20.0, 15.0, 10.0, 5.0)
# Factors on the damping between which a calibration is sought.
FACTORS = (0.3, 3.0)
# Angles at which the smooth spore is computed, over the range of Fig. 11.
SMOOTH_ANGLES = np.array([85.0, 61.0, 48.0, 38.0, 30.0, 20.0, 15.0, 10.0])
# Name of the sample of slopes that the imaging system sees.
CAMERA = "slopes, seen by the camera"


@dataclass(frozen=True, slots=True, kw_only=True)
class Spore:
    """Spores on a smooth surface, and the causes tried."""

    spore: Dropped  # Spores; each cause alone takes their slope or none
    # Spheres they are compared with.
    steel: Dropped
    steel_cases: tuple[CaseName, ...]
    angles_deg: tuple[AngleDegrees, ...]  # Of incidence, in descending order
    # Angles of the comparison with steel, and the measured restitution of both at the first.
    compared_deg: tuple[AngleDegrees, ...]
    calibrated_restitution: Fraction
    slope_sds: tuple[NonNegative, ...]  # Other slopes tried
    # Standard deviations of the offset of the point of contact over the radius.
    offset_sds: tuple[NonNegative, ...]
    # Angles, events and particles of the sample seen by the imaging system.
    seen_deg: tuple[AngleDegrees, ...]
    seen_events: Count
    seen_dropped: Count
    quoted_capture_velocity_m_per_s: Positive  # Of Paw U

    def __post_init__(self) -> None:
        """Refuse angles without those between which the article states trends."""
        missing = [angle for angle in TREND_DEG if angle not in self.angles_deg]
        if missing:
            raise ValueError(f"angles_deg: must hold {', '.join(f'{a:g}' for a in missing)}")


def spore_tables(
    params: Spore, sampling: Sampling, instrument: ImagingSystem, inputs: Tables
) -> dict[str, pd.DataFrame]:
    """Return the tables of the spore mechanisms, by name."""
    sample = Sample.of(params.spore, sampling, inputs)
    most = params.seen_dropped
    samples_by_cause = {
        name: {angle: cause(sample, angle) for angle in params.angles_deg}
        for name, cause in causes(params).items()
    }
    samples_by_cause[CAMERA] = {
        angle: as_imaged(sample, angle, instrument, events=params.seen_events, most_dropped=most)
        for angle in params.seen_deg
    }
    means = [
        {"mechanism": name, "angle_deg": angle}
        | mean_columns(one)
        | {"evidence": "virtual experiment"}
        for name, samples in samples_by_cause.items()
        for angle, one in samples.items()
    ]
    rows = [
        {"mechanism": name} | trends(samples, sampling)
        for name, samples in samples_by_cause.items()
    ]
    slopes, first = (samples_by_cause[name] for name in ("slopes", "slopes, first contacts"))
    rows.append({"mechanism": "second contacts, added to slopes"} | trends(slopes, sampling, first))
    return {
        "spore_mechanism": pd.DataFrame(means),
        "spore_trends": pd.DataFrame(rows),
        "spore_comparison": pd.DataFrame(comparison(params, sampling, inputs)),
        "smooth_spore": smooth_spore(params, sample.contact),
    }


def causes(params: Spore) -> dict[str, Callable[[Sample, float], Seen]]:
    """Return the causes by name: the rebounds of spores with their slopes, at an angle."""

    def seen_with(slopes: Sample, angle: float, **changes: Any) -> Seen:
        return slopes.with_changes(**changes).seen(angle)

    def off(slopes: Sample, angle: float, sd: float) -> Seen:
        return off_centre(slopes.with_changes(particle_slope=0.0), angle, offset_sd=sd)

    return {
        "none": partial(seen_with, particle_slope=0.0),
        "slopes, first contacts": partial(Sample.seen, most_contacts=1),
        "slopes": Sample.seen,
        **{f"slopes of {sd:g}": partial(seen_with, particle_slope=sd) for sd in params.slope_sds},
        **{f"off centre, {sd:g}": partial(off, sd=sd) for sd in params.offset_sds},
    }


def trends(
    samples: Mapping[float, Seen], sampling: Sampling, less: Mapping[float, Seen] | None = None
) -> dict[str, Any]:
    """Return the trends of samples, or of differences of samples, as columns of a table."""

    def change(quantity: str, start: float, end: float) -> float:
        if start not in samples or end not in samples:
            return np.nan
        last, first = (samples[angle].means[quantity] for angle in (end, start))
        rise = last.value - first.value
        if less:
            rise -= less[end].means[quantity].value - less[start].means[quantity].value
        return rise / half_width(last, first, sampling)

    at_15 = (less or samples).get(15.0)
    return {
        "restitution_rise_38_to_15_over_half_width": change("restitution", 38.0, 15.0),
        "impulse_ratio_rise_85_to_20_over_half_width": change("impulse_ratio", 85.0, 20.0),
        "impulse_ratio_rise_45_to_20_over_half_width": change("impulse_ratio", 45.0, 20.0),
        "impulse_ratio_fall_15_to_5_over_half_width": -change("impulse_ratio", 15.0, 5.0),
        "impulse_ratio_fall_15_to_10_over_half_width": -change("impulse_ratio", 15.0, 10.0),
        "rebounds_at_15_deg": len(at_15.measured) if at_15 else np.nan,
        "evidence": "virtual experiment",
    }


def comparison(params: Spore, sampling: Sampling, inputs: Tables) -> Iterator[dict[str, Any]]:
    """Yield steel less spore, each with its slopes and calibrated at the first angle alone."""
    # Every contact tried, and each of those found, is looked at in a few samples only.
    direct = replace(sampling, tabulated=False)

    def calibrated(dropped: Dropped) -> Sample:
        sample = Sample.of(dropped, direct, inputs)
        return met_at(params.calibrated_restitution, sample, params.compared_deg[0])

    spore = calibrated(params.spore)
    for case in params.steel_cases:
        steel = calibrated(replace(params.steel, case=case))
        for angle in params.compared_deg:
            yield (
                {"case": case, "angle_deg": angle}
                | difference_columns(steel.seen(angle), spore.seen(angle), sampling)
                | {"evidence": "virtual experiment"}
            )


def met_at(restitution: float, sample: Sample, angle: float) -> Sample:
    """Return the sample with both dampings scaled to give a measured mean restitution."""
    names = ("hertz_damping", "adhesion_damping")

    def scaled(factor: float) -> Sample:
        dampings = {name: factor * getattr(sample.contact, name) for name in names}
        return sample.with_contact(sample.contact.replace(**dampings))

    return scaled(setting_for(scaled, "restitution", angle, restitution, *FACTORS))


def smooth_spore(params: Spore, contact: Contact) -> pd.DataFrame:
    """Return rebounds of the mean spore without slopes at each angle."""
    angle = SMOOTH_ANGLES
    speed = params.spore.speed_m_per_s
    impact = simulate(contact, speed, angle)
    quoted = params.quoted_capture_velocity_m_per_s
    normal = speed * np.sin(np.radians(angle))
    return pd.DataFrame(
        {
            "angle_deg": angle,
            "normal_speed_m_per_s": normal,
            "restitution": impact.coefficient_of_restitution,
            "normal_speed_over_quoted_capture_velocity": normal / quoted,
            "angle_of_quoted_capture_velocity_deg": np.degrees(np.arcsin(quoted / speed)),
            "evidence": "computed",
        }
    )
