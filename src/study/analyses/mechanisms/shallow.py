"""Rise of the impulse ratio at shallow angles: by adhesion or by slopes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from microimpact.core.arrays import FloatArray
from microimpact.core.computable import NotComputable
from microimpact.model.calibration import hertz_damping_for
from study.declared.parameters import CaseName, Count, Fraction, NonNegative, Positive
from study.samples import Dropped, Sample, Sampling
from study.tables import Tables

FEWEST_MEANS = 2
# Where more are captured, the few that rebound are no fair sample.
MOST_CAPTURED = 0.5
# Angles that count as sliding at both speeds, also with slopes, degrees.
SHALLOWEST_DEG, STEEPEST_DEG = 4.0, 40.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Shallow:
    """Adhesion and slopes, each alone, at two speeds."""

    dropped: Dropped  # Spheres and smooth surface; speed and class are those of the list
    cases: tuple[CaseName, ...]  # Calibrated contacts
    speeds_m_per_s: tuple[Positive, Positive]  # Two, the slower first
    half_width_m_per_s: Positive  # Of their classes
    # Of the surface without adhesion; its material damping gives ``restitution`` at the faster
    # speed.
    slope_sd: NonNegative
    restitution: Fraction  # At normal incidence
    # Number of normal speeds from the slowest that rebounds to where sliding ends.
    normal_speeds: Count


class Curve(NamedTuple):
    """Mean impulse ratio of one speed against normal speed (m/s), nan where too few rebound."""

    normal_speed: FloatArray
    ratio: FloatArray


def shallow_curves(
    params: Shallow, sampling: Sampling, inputs: Tables
) -> dict[tuple[str, str], tuple[Curve, Curve]]:
    """Return the curves at both speeds, by case and cause (``adhesion`` or ``slopes``)."""
    curves = {}
    for case in params.cases:
        sample = Sample.of(replace(params.dropped, case=case), sampling, inputs)
        bare = hertz_damping_for(
            sample.contact.replace(work_of_adhesion=0.0, adhesion_damping=0.0),
            max(params.speeds_m_per_s),
            params.restitution,
        )
        curves[case, "adhesion"] = _both(params, sample)
        curves[case, "slopes"] = _both(
            params, sample.with_contact(bare).with_changes(surface_slope=params.slope_sd)
        )
    return curves


def _both(params: Shallow, sample: Sample) -> tuple[Curve, Curve]:
    """Curves at the slower and the faster speed, at the same normal speeds where both slide."""
    slow, fast = params.speeds_m_per_s
    shallowest, steepest = np.radians(np.array([SHALLOWEST_DEG, STEEPEST_DEG]))
    top, number = slow * np.sin(steepest), params.normal_speeds
    below = np.linspace(fast * np.sin(shallowest), top, number)
    normal = np.union1d(below, np.linspace(top, fast * np.sin(steepest), number))
    both = (slow, normal[normal <= top]), (fast, normal)
    slower, faster = (_curve(params, sample, *one) for one in both)
    return slower, faster


def _curve(params: Shallow, sample: Sample, speed: float, normal_speed: FloatArray) -> Curve:
    width = params.half_width_m_per_s
    speed_class = sample.with_changes(
        speed_m_per_s=speed, speed_range_m_per_s=(speed - width, speed + width)
    )
    angle = np.degrees(np.arcsin(np.minimum(normal_speed / speed, 1.0)))
    samples = [speed_class.seen(float(a)) for a in angle]
    free = [one.captured_share <= MOST_CAPTURED for one in samples]
    ratio = np.where(free, [one.means["impulse_ratio"].value for one in samples], np.nan)
    if np.sum(np.isfinite(ratio)) < FEWEST_MEANS:
        raise NotComputable(
            f"shallow.speeds_m_per_s: at {speed:g} m/s nearly all spheres are captured below "
            f"{STEEPEST_DEG:g} deg; there is nothing to compare"
        )
    return Curve(normal_speed, ratio)


def adhesion_or_roughness(
    params: Shallow, curves: Mapping[tuple[str, str], tuple[Curve, Curve]]
) -> Iterator[dict[str, Any]]:
    """Yield the spread of both speeds at equal normal speed, and the rise at the shallowest angle.

    The spread is the largest difference, where both are known; both are over the friction
    coefficient.
    """
    friction = params.dropped.friction
    for (case, cause), (slow, fast) in curves.items():
        slower, faster = (
            Curve(curve.normal_speed[known], curve.ratio[known])
            for curve in (slow, fast)
            for known in [np.isfinite(curve.ratio)]
        )
        there = np.interp(slower.normal_speed, *faster, left=np.nan, right=np.nan)
        yield {
            "case": case,
            "cause": cause,
            "spread_at_equal_normal_speed": np.nanmax(np.abs(slower.ratio - there)) / friction,
            "rise_at_shallowest_rebound": faster.ratio[0] / friction,
            "evidence": "virtual experiment",
        }


def shallow_series(
    curves: Mapping[tuple[str, str], tuple[Curve, Curve]], case: str
) -> Iterator[tuple[str, str, FloatArray, FloatArray]]:
    """Yield cause, which speed (``slow`` or ``fast``), normal speed and impulse ratio of a case."""
    for (name, cause), pair in curves.items():
        if name == case:
            for which, curve in zip(("slow", "fast"), pair, strict=True):
                known = np.isfinite(curve.ratio)
                yield cause, which, curve.normal_speed[known], curve.ratio[known]
