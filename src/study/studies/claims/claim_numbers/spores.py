"""Numbers of the claims of Sections 2.4.3 and 2.4.4: spores on silicon, and on Formica."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from microimpact.core.arrays import FloatArray
from study.studies.claims.claim_numbers.claim import claim
from study.studies.claims.claim_numbers.context import Context, Estimate, Numbers
from study.studies.experiments.mechanisms.spore import as_imaged
from study.studies.samples import Dropped, Sample, Sampling, Seen

# Half-width of a 95 % interval over its standard error.
ERROR_BAR = 1.96


@claim("C17")
def c17(context: Context) -> Numbers:
    """Total speeds that the two printed normal speeds of the spores mean."""
    angles = np.radians(context.params.formica.spore_angles_deg)
    keys = ("normal_speed_lycopodium_48deg", "normal_speed_lycopodium_38deg")
    speeds = np.array([context.printed(key) for key in keys]) / np.sin(angles)
    return {"difference_of_total_speeds": speeds[0] - speeds[1], "total_speed": speeds.mean()}


@claim("C81", by_case=True)
def c81(context: Context) -> Numbers:
    """Largest difference of restitution, steel less spores, each calibrated at 85 deg alone."""
    difference = context.column(
        "spore_comparison",
        "restitution_difference_over_half_width",
        context.params.mechanisms.compared_deg,
    )
    return {"largest_difference_over_half_width": difference.abs().max()}


@claim("C82")
def c82(context: Context) -> Numbers:
    """Printed normal speed over the quoted capture velocity; the smooth spore's fall of e below."""
    first = context.table("smooth_spore").iloc[0]
    quoted = first["normal_speed_m_per_s"] / first["normal_speed_over_quoted_capture_velocity"]
    printed = context.printed("normal_speed_lycopodium_38deg")
    restitution = context.column("smooth_spore", "restitution", (38.0, 10.0))
    return {
        "normal_speed_over_quoted_capture_velocity": printed / quoted,
        "fall_of_restitution_of_smooth_spore": restitution[38.0] - restitution[10.0],
        "angle_of_quoted_capture_velocity": first["angle_of_quoted_capture_velocity_deg"],
    }


@claim("C83")
def c83(context: Context) -> Numbers:
    """Rise of restitution from 38 to 15 deg by each cause alone, and the greatest."""
    named = context.params.mechanisms
    causes = {
        "slopes": named.spore_slopes,
        "second_contacts": named.spore_second_contacts,
        "collisions_off_centre": named.spore_off_centre,
    }
    rises = {w: trend(context, name, "restitution_rise_38_to_15") for w, name in causes.items()}
    return {"greatest_rise_over_half_width": max(rises.values())} | {
        f"rise_by_{words}_over_half_width": rise.value for words, rise in rises.items()
    }


def trend(context: Context, mechanism: str, column: str) -> Estimate:
    """Return a trend that a supposed cause gives, over its half-width.

    The sample is large: its error is about that of means of as many events as rebound at 15 deg.

    Raises ValueError if so few rebound at one of the angles that there is no trend to see.
    """
    row = context.table("spore_trends", mechanism=mechanism).iloc[0]
    value, rebounds = row[f"{column}_over_half_width"], row["rebounds_at_15_deg"]
    if not np.isfinite(value):
        raise ValueError(f"spore_trends: too few rebounds for {column}, {mechanism}")
    return Estimate(value, np.sqrt(context.params.sampling.events / rebounds) / ERROR_BAR)


@claim("C84")
def c84(context: Context) -> Numbers:
    """Rises and fall of the impulse ratio as the camera sees them."""
    seen = context.params.mechanisms.spore_seen
    trends = {"rise": "rise_85_to_20", "later_rise": "rise_45_to_20", "fall": "fall_15_to_5"}
    return {
        f"{name}_over_half_width": trend(context, seen, f"impulse_ratio_{column}")
        for name, column in trends.items()
    }


@claim("C85")
def c85(context: Context) -> Numbers:
    """Differences of the losses and of the printed restitutions at 40 deg, and their ratio."""
    row = context.table("loss_resolution").iloc[0]
    losses, restitutions = (
        abs(row[f"difference_of_{name}_over_half_width"]) for name in ("losses", "restitutions")
    )
    return {
        "resolution_by_losses_over_that_by_restitutions": losses / restitutions,
        "difference_of_losses_over_half_width": losses,
        "difference_of_restitutions_over_half_width": restitutions,
    }


@claim("C86")
def c86(context: Context) -> Numbers:
    """Restitution of steel less the spores', rises of both, and restitution of steel.

    With the slopes that are supposed of the spores, and without any.
    """
    spore = context.params.formica.spore
    alternatives = {
        "slopes of spores as supposed": spore,
        "spores without slopes": replace(spore, particle_slope=0.0),
    }
    return {name: on_formica(context, each) for name, each in alternatives.items()}


def on_formica(context: Context, spore: Dropped) -> Numbers:
    """Return the numbers of C86 for one sort of spores."""
    steel = formica(context, "steel_restitution", (20.0, 15.0))
    return {
        "least_difference_steel_less_spore_over_half_width": min(
            compared(context, "restitution", spore)
        ),
        "lesser_rise_over_half_width": lesser_rise(context, "restitution", spore),
        "measured_restitution_of_steel": steel[20.0],
        "measured_restitution_of_steel_below": steel[15.0],
        "slope_deviation_of_formica": context.params.formica.steel.surface_slope,
    }


def rise(
    context: Context, quantity: str, dropped: Dropped, sampling: Sampling | None = None
) -> Estimate:
    """Return the rise of a mean on Formica from steep to shallow, over its half-width."""
    steep, shallow = context.params.formica.trend_deg
    return context.over_half_width(quantity, (dropped, shallow), (dropped, steep), sampling)


def lesser_rise(context: Context, quantity: str, spore: Dropped) -> Estimate:
    """Return the lesser rise of a mean, of steel and of one sort of spores."""
    samples = context.params.formica.steel, spore
    return min(rise(context, quantity, sample, context.series) for sample in samples)


def formica(context: Context, column: str, angles: ArrayLike | None = None) -> pd.Series:
    """Return a column of steel and spores on Formica, by angle."""
    return context.column("formica_mechanism", column, angles)


def compared(context: Context, quantity: str, spore: Dropped) -> list[Estimate]:
    """Return differences of a mean at the angles compared, steel less spores, over half-widths."""
    steel, angles = context.params.formica.steel, formica(context, f"{quantity}_difference").index
    return [
        context.over_half_width(quantity, (steel, angle), (spore, angle), context.series)
        for angle in angles[angles >= context.params.mechanisms.formica_from_deg]
    ]


@claim("C87")
def c87(context: Context) -> Numbers:
    """Largest difference of the impulse ratios over its half-width, and the lesser rise.

    With the friction of steel for the spores, and with less.
    """
    samples = context.params.formica
    less = replace(samples.spore, friction=samples.least_spore_friction)
    alternatives = {"friction of spores as of steel": samples.spore, "less friction": less}
    return {
        name: {
            "largest_difference_of_impulse_ratios_over_half_width": max(
                map(abs, compared(context, "impulse_ratio", spore))
            ),
            "lesser_rise_over_half_width": lesser_rise(context, "impulse_ratio", spore),
        }
        for name, spore in alternatives.items()
    }


@claim("C88")
def c88(context: Context) -> Numbers:
    """How far the difference of the losses shrinks from 80 to 30 deg, over its half-width.

    Beside it the ratio of both, and the difference of the restitutions at 30 deg.
    """
    angles = [30.0, 80.0]
    losses, widths, errors = differences(context, "energy_loss", angles)
    apart, width, error = (values[0] for values in differences(context, "restitution", angles[:1]))
    change = Estimate(abs(losses[1]) - abs(losses[0]), np.hypot(*errors))
    sines: FloatArray = np.sin(np.radians(angles))
    return {
        "shrinking_of_difference_of_losses_over_half_width": change / np.hypot(*widths),
        "ratio_of_differences_of_losses": losses[0] / losses[1],
        "difference_of_restitutions_over_half_width": Estimate(apart, error) / width,
        "squared_ratio_of_sines": (sines[0] / sines[1]) ** 2,
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
def c89(context: Context) -> Numbers:
    """Share of spores captured, or not seen by the camera, while restitution rises."""
    spore, (_, shallow) = context.params.formica.spore, context.params.formica.trend_deg
    captured, bias = (
        formica(context, f"spore_{name}", shallow)[shallow]
        for name in ("captured_share", "bias_of_conditional_mean")
    )
    return {
        "captured_share": captured,
        "rise_over_half_width": rise(context, "restitution", spore, context.series),
        "share_not_observed": watched(context).captured_share,
        "bias_of_conditional_mean": bias,
    }


def watched(context: Context) -> Seen:
    """Return the spores on Formica at the shallow angle, as the camera sees them."""
    params = context.params.formica
    contact, camera = context.contact(params.spore), context.params.camera
    sample = Sample(dropped=params.spore, contact=contact, sampling=context.series)
    events, most = params.seen_events, params.seen_dropped
    return as_imaged(sample, params.trend_deg[1], camera, events=events, most_dropped=most)
