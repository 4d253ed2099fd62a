"""Numbers of the claims of Sections 2.4.3 and 2.4.4: spores on silicon, and on Formica."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from microimpact.core.arrays import FloatArray
from microimpact.core.computable import NotComputable
from microimpact.statistics.intervals import ERROR_BAR
from study.declared.parameters import AngleDegrees, Name
from study.studies.claims.claim_numbers.claim import claim
from study.studies.claims.claim_numbers.context import (
    AngleRange,
    Context,
    Estimate,
    Numbers,
    SteepToShallow,
)
from study.studies.samples import Dropped


@claim("C17")
def c17(context: Context, *, angles_deg: AngleRange) -> Numbers:
    """Total speeds that the two printed normal speeds of the spores mean."""
    angles = np.radians(angles_deg)
    keys = ("normal_speed_lycopodium_48deg", "normal_speed_lycopodium_38deg")
    speeds = np.array([context.printed(key) for key in keys]) / np.sin(angles)
    return {"difference_of_total_speeds": speeds[0] - speeds[1], "total_speed": speeds.mean()}


@claim("C81", by_case=True)
def c81(context: Context, *, angles_deg: tuple[AngleDegrees, ...]) -> Numbers:
    """Largest difference of restitution, steel less spores, each calibrated at 85 deg alone."""
    name = "restitution_difference_over_half_width"
    difference = context.column("spore_comparison", name, angles_deg)
    return {"largest_difference_over_half_width": difference.abs().max()}


@claim("C82")
def c82(context: Context, *, angles_deg: SteepToShallow) -> Numbers:
    """Printed normal speed over the quoted capture velocity; the smooth spore's fall of e below."""
    first = context.table("smooth_spore").iloc[0]
    quoted = first["normal_speed_m_per_s"] / first["normal_speed_over_quoted_capture_velocity"]
    printed = context.printed("normal_speed_lycopodium_38deg")
    restitution = context.column("smooth_spore", "restitution", angles_deg).to_numpy()
    return {
        "normal_speed_over_quoted_capture_velocity": printed / quoted,
        "fall_of_restitution_of_smooth_spore": restitution[0] - restitution[1],
        "angle_of_quoted_capture_velocity": first["angle_of_quoted_capture_velocity_deg"],
    }


@claim("C83")
def c83(context: Context, *, angles_deg: SteepToShallow, off_centre: Name) -> Numbers:
    """Rise of restitution from 38 to 15 deg by each cause alone, and the greatest."""
    causes = {
        "slopes": "slopes, first contacts",
        "second_contacts": "second contacts, added to slopes",
        "collisions_off_centre": off_centre,
    }
    rises = {
        words: trend(context, name, "restitution_rise", angles_deg)
        for words, name in causes.items()
    }
    return {"greatest_rise_over_half_width": max(rises.values())} | {
        f"rise_by_{words}_over_half_width": rise.value for words, rise in rises.items()
    }


def trend(context: Context, mechanism: str, quantity: str, angles: tuple[float, float]) -> Estimate:
    """Return a trend that a supposed cause gives, over its half-width.

    The sample is large: its error is about that of means of as many events as rebound at 15 deg.

    Raises NotComputable if the table has no trend between these angles, or so few rebound at one of
    them that there is none to see.
    """
    row = context.table("spore_trends", mechanism=mechanism).iloc[0]
    column = "{}_{:g}_to_{:g}".format(quantity, *angles)
    if f"{column}_over_half_width" not in row:
        raise ValueError(f"spore_trends: no column {column}_over_half_width")
    value, rebounds = row[f"{column}_over_half_width"], row["rebounds_at_15_deg"]
    if not np.isfinite(value):
        raise NotComputable(f"spore_trends: too few rebounds for {column}, {mechanism}")
    return Estimate(value, np.sqrt(context.params.sampling.events / rebounds) / ERROR_BAR)


@claim("C84")
def c84(
    context: Context,
    *,
    rise_deg: SteepToShallow,
    later_rise_deg: SteepToShallow,
    fall_deg: SteepToShallow,
) -> Numbers:
    """Rises and fall of the impulse ratio as the camera sees them."""
    trends = {"rise": rise_deg, "later_rise": later_rise_deg, "fall": fall_deg}
    return {
        f"{name}_over_half_width": trend(
            context,
            "slopes, seen by the camera",
            f"impulse_ratio_{name.removeprefix('later_')}",
            angles,
        )
        for name, angles in trends.items()
    }


@claim("C85")
def c85(context: Context) -> Numbers:
    """Ratio of the difference of the losses at 40 deg to the difference of printed restitutions."""
    row = context.table("loss_resolution").iloc[0]
    endings = {"error bars of the virtual laboratory": "_over_half_width", "equal error bars": ""}
    return {
        name: {
            "resolution_by_losses_over_that_by_restitutions": abs(
                row[f"difference_of_losses{ending}"] / row[f"difference_of_restitutions{ending}"]
            )
        }
        for name, ending in endings.items()
    }


@claim("C86")
def c86(
    context: Context,
    *,
    steel: Dropped,
    spore: Dropped,
    trend_deg: AngleRange,
    from_deg: AngleDegrees,
    steel_deg: AngleRange,
) -> Numbers:
    """Restitution of steel less the spores', rises of both, and restitution of steel.

    With the slopes that are supposed of the spores, and without any.
    """
    alternatives = {
        "slopes of spores as supposed": spore,
        "spores without slopes": replace(spore, particle_slope=0.0),
    }
    measured, below = formica(context, "steel_restitution", steel_deg)
    return {
        name: {
            "least_difference_steel_less_spore_over_half_width": min(
                compared(context, "restitution", steel, each, from_deg)
            ),
            "lesser_rise_over_half_width": lesser_rise(
                context, "restitution", (steel, each), trend_deg
            ),
            "measured_restitution_of_steel": measured,
            "measured_restitution_of_steel_below": below,
        }
        for name, each in alternatives.items()
    }


def rise(context: Context, quantity: str, dropped: Dropped, trend: tuple[float, float]) -> Estimate:
    """Return the rise of a mean on Formica from steep to shallow, over its half-width."""
    steep, shallow = trend
    return context.over_half_width(quantity, (dropped, shallow), (dropped, steep))


def lesser_rise(
    context: Context, quantity: str, samples: tuple[Dropped, Dropped], trend: tuple[float, float]
) -> Estimate:
    """Return the lesser rise of a mean, of steel and of one sort of spores."""
    return min(rise(context.series, quantity, sample, trend) for sample in samples)


def formica(context: Context, column: str, angles: ArrayLike | None = None) -> pd.Series:
    """Return a column of steel and spores on Formica, by angle."""
    return context.column("formica_mechanism", column, angles)


def compared(
    context: Context, quantity: str, steel: Dropped, spore: Dropped, least: float
) -> list[Estimate]:
    """Return differences of a mean from an angle up, steel less spores, over half-widths."""
    angles = formica(context, f"{quantity}_difference").index
    return [
        context.series.over_half_width(quantity, (steel, angle), (spore, angle))
        for angle in angles[angles >= least]
    ]


@claim("C87")
def c87(
    context: Context,
    *,
    steel: Dropped,
    spore: Dropped,
    trend_deg: AngleRange,
    from_deg: AngleDegrees,
) -> Numbers:
    """Largest difference of the impulse ratios over its half-width, and the lesser rise."""
    both = steel, spore
    return {
        "largest_difference_of_impulse_ratios_over_half_width": max(
            map(abs, compared(context, "impulse_ratio", *both, from_deg))
        ),
        "lesser_rise_over_half_width": lesser_rise(context, "impulse_ratio", both, trend_deg),
    }


@claim("C88")
def c88(context: Context, *, angles_deg: AngleRange) -> Numbers:
    """How far the difference of the losses shrinks from 80 to 30 deg, over its half-width.

    Beside it the ratio of both, and the difference of the restitutions at 30 deg.
    """
    angles = list(angles_deg)
    losses, widths, errors = differences(context, "energy_loss", angles)
    apart, width, error = (values[0] for values in differences(context, "restitution", angles[:1]))
    change = Estimate(abs(losses[1]) - abs(losses[0]), np.hypot(*errors))
    return {
        "shrinking_of_difference_of_losses_over_half_width": change / np.hypot(*widths),
        "ratio_of_differences_of_losses": losses[0] / losses[1],
        "difference_of_restitutions_over_half_width": Estimate(apart, error) / width,
    }


def differences(context: Context, quantity: str, angles: list[float]) -> list[FloatArray]:
    """Return differences of means on Formica by angle, their half-widths, and their errors."""

    def column(name: str) -> FloatArray:
        return formica(context, name, angles).to_numpy(float)

    difference = column(f"{quantity}_difference")
    width = np.abs(difference / column(f"{quantity}_difference_over_half_width"))
    errors = (
        column(f"{who}_{quantity}_sd") / np.sqrt(column(f"{who}_rebounds"))
        for who in ("steel", "spore")
    )
    return [difference, width, np.hypot(*errors)]


@claim("C89")
def c89(context: Context, *, spore: Dropped, trend_deg: AngleRange) -> Numbers:
    """Share of spores captured while restitution rises."""
    shallow = trend_deg[1]
    captured, bias = (
        formica(context, f"spore_{name}", shallow)[shallow]
        for name in ("captured_share", "bias_of_conditional_mean")
    )
    return {
        "captured_share": captured,
        "rise_over_half_width": rise(context.series, "restitution", spore, trend_deg),
        "bias_of_conditional_mean": bias,
    }
