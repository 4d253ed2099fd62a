"""Numbers of the claims of Sections 2.4.3 and 2.4.4: spores on silicon, and on Formica."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from microimpact.lab.samples import Dropped, Seen
from microimpact.studies.claims.claim_numbers.claim import CALIBRATED, VIRTUAL, claim
from microimpact.studies.claims.claim_numbers.context import Context, Estimate
from microimpact.studies.experiments.mechanisms.spore import as_imaged

# Half-width of a 95 % interval over its standard error.
ERROR_BAR = 1.96


@claim("C17", units="m/s")
def c17(context: Context) -> dict[str, float]:
    """Total speeds that the two printed normal speeds of the spores mean."""
    angles = np.radians(context.params.formica.spore_angles_deg)
    keys = ("normal_speed_lycopodium_48deg", "normal_speed_lycopodium_38deg")
    speeds = np.array([context.printed(key) for key in keys]) / np.sin(angles)
    return {"difference_of_total_speeds": speeds[0] - speeds[1], "total_speed": speeds.mean()}


@claim("C81", by_case=True, evidence=CALIBRATED)
def c81(context: Context) -> dict[str, float]:
    """Largest difference of restitution, steel less spores, each calibrated at 85 deg alone."""
    found = context.column(
        "spore_comparison",
        "restitution_difference_over_half_width",
        context.params.mechanisms.compared_deg,
    )
    return {"largest_difference_at_70_and_55_deg_over_half_width": found.abs().max()}


@claim("C82", units={"angle_of_quoted_capture_velocity": "deg"})
def c82(context: Context) -> dict[str, float]:
    """Printed normal speed over the quoted capture velocity; what the smooth spore does below."""
    first = context.table("smooth_spore").iloc[0]
    quoted = first["normal_speed_m_per_s"] / first["normal_speed_over_quoted_capture_velocity"]
    restitution = context.column("smooth_spore", "restitution", (38.0, 10.0))
    return {
        "normal_speed_at_38_deg_over_quoted_capture_velocity": (
            context.printed("normal_speed_lycopodium_38deg") / quoted
        ),
        "fall_of_restitution_of_smooth_spore_38_to_10_deg": restitution[38.0] - restitution[10.0],
        "angle_of_quoted_capture_velocity": first["angle_of_quoted_capture_velocity_deg"],
    }


@claim("C83", evidence=VIRTUAL)
def c83(context: Context) -> dict[str, float | Estimate]:
    """Rise of restitution from 38 to 15 deg by each cause alone, and the greatest."""
    named = context.params.mechanisms
    rises = {
        words: trend(context, name, "restitution_rise_38_to_15")
        for words, name in (
            ("slopes", named.spore_slopes),
            ("second_contacts", named.spore_second_contacts),
            ("collisions_off_centre", named.spore_off_centre),
        )
    }
    return {"greatest_rise_38_to_15_deg_over_half_width": max(rises.values())} | {
        f"rise_38_to_15_deg_by_{words}_over_half_width": rise.value for words, rise in rises.items()
    }


def trend(context: Context, mechanism: str, column: str) -> Estimate:
    """Return a trend that a supposed cause gives, over its half-width.

    The sample is large: its error is about that of means of as many events as rebound at 15 deg.

    Raises ValueError if so few rebound at one of the angles that there is no trend to see.
    """
    row = context.table("spore_trends", mechanism=mechanism).iloc[0]
    found, rebounds = row[f"{column}_over_half_width"], row["rebounds_at_15_deg"]
    if not np.isfinite(found):
        raise ValueError(f"spore_trends: too few rebounds for {column}, {mechanism}")
    return Estimate(
        float(found), float(np.sqrt(context.params.sampling.events / rebounds) / ERROR_BAR)
    )


@claim("C84", evidence=VIRTUAL)
def c84(context: Context) -> dict[str, Estimate]:
    """Rises and fall of the impulse ratio as the camera sees them."""
    seen = context.params.mechanisms.spore_seen
    return {
        "rise_85_to_20_deg_over_half_width": trend(context, seen, "impulse_ratio_rise_85_to_20"),
        "rise_45_to_20_deg_over_half_width": trend(context, seen, "impulse_ratio_rise_45_to_20"),
        "fall_15_to_5_deg_over_half_width": trend(context, seen, "impulse_ratio_fall_15_to_5"),
    }


@claim("C85")
def c85(context: Context) -> dict[str, float]:
    """Differences of the losses and of the printed restitutions at 40 deg, and their ratio."""
    row = context.table("loss_resolution").iloc[0]
    losses, restitutions = (
        float(abs(row[f"difference_of_{name}_over_half_width"]))
        for name in ("losses", "restitutions")
    )
    return {
        "resolution_by_losses_over_that_by_restitutions_at_40_deg": losses / restitutions,
        "difference_of_losses_at_40_deg_over_half_width": losses,
        "difference_of_restitutions_at_40_deg_over_half_width": restitutions,
    }


@claim("C86", evidence=CALIBRATED, units={"slope_deviation_of_formica": "rad"})
def c86(context: Context) -> dict[str, dict[str, float | Estimate]]:
    """Restitution of steel less that of spores, rises of both, and that of steel itself.

    With the slopes that are supposed of the spores, and without any.
    """
    spore = context.params.formica.spore
    alternatives = {
        "slopes of spores as supposed": spore,
        "spores without slopes": replace(spore, particle_slope=0.0),
    }
    return {name: on_formica(context, each) for name, each in alternatives.items()}


def on_formica(context: Context, spore: Dropped) -> dict[str, float | Estimate]:
    """Return the numbers of C86 for one sort of spores."""
    sample, series = context.params.formica.steel, context.series
    angles = compared(context, "restitution_difference").index
    steel = formica(context, "steel_restitution", (20.0, 15.0))
    return {
        "least_difference_steel_less_spore_over_half_width": min(
            context.over_half_width("restitution", (sample, angle), (spore, angle), series)
            for angle in angles
        ),
        "lesser_rise_45_to_15_deg_over_half_width": min(
            rise_of_restitution(context, one) for one in (sample, spore)
        ),
        "measured_restitution_of_steel_at_20_deg": steel[20.0],
        "measured_restitution_of_steel_at_15_deg": steel[15.0],
        "slope_deviation_of_formica": sample.surface_slope,
    }


def rise_of_restitution(context: Context, dropped: Dropped) -> Estimate:
    """Return the rise from the steep to the shallow angle on Formica, over its half-width."""
    steep, shallow = context.params.formica.trend_deg
    ends = (dropped, shallow), (dropped, steep)
    return context.over_half_width("restitution", *ends, context.series)


def formica(context: Context, column: str, angles: ArrayLike | None = None) -> pd.Series:
    """Return a column of steel and spores on Formica, by angle."""
    return context.column("formica_mechanism", column, angles)


def compared(context: Context, column: str) -> pd.Series:
    """Return a column of steel and spores on Formica at the angles that are compared."""
    found = formica(context, column)
    return found[found.index >= context.params.mechanisms.formica_from_deg]


@claim("C87", evidence=VIRTUAL)
def c87(context: Context) -> dict[str, dict[str, Estimate]]:
    """Largest difference of the impulse ratios over its half-width, and the lesser rise.

    With the friction of steel for the spores, and with less.
    """
    samples = context.params.formica
    less = replace(samples.spore, friction=samples.least_spore_friction)
    alternatives = {"friction of spores as of steel": samples.spore, "less friction": less}
    return {name: compared_ratios(context, spore) for name, spore in alternatives.items()}


def compared_ratios(context: Context, spore: Dropped) -> dict[str, Estimate]:
    """Return the numbers of C87 for one sort of spores."""
    steel, series, quantity = context.params.formica.steel, context.series, "impulse_ratio"
    steep, shallow = context.params.formica.trend_deg
    apart = [
        context.over_half_width(quantity, (steel, angle), (spore, angle), series)
        for angle in compared(context, "impulse_ratio_difference").index
    ]
    return {
        "largest_difference_of_impulse_ratios_over_half_width": max(
            Estimate(abs(one.value), one.error) for one in apart
        ),
        "lesser_rise_45_to_15_deg_over_half_width": min(
            context.over_half_width(quantity, (one, shallow), (one, steep), series)
            for one in (steel, spore)
        ),
    }


@claim("C88", evidence=VIRTUAL)
def c88(context: Context) -> dict[str, float | Estimate]:
    """How far the difference of the losses shrinks from 80 to 30 deg, over its half-width.

    Beside it the ratio of both, and the difference of the restitutions at 30 deg.
    """
    losses, over = (
        formica(context, f"energy_loss_difference{ending}", (30.0, 80.0))
        for ending in ("", "_over_half_width")
    )
    restitution = formica(context, "restitution_difference_over_half_width", 30.0)
    sines = np.sin(np.radians([30.0, 80.0]))
    width = float(np.hypot(*(losses / over)))
    spread = [
        formica(context, f"{name}_energy_loss_sd", (30.0, 80.0))
        / np.sqrt(formica(context, f"{name}_rebounds", (30.0, 80.0)))
        for name in ("steel", "spore")
    ]
    error = float(np.sqrt(sum(np.sum(np.square(of)) for of in spread)))
    return {
        "shrinking_of_difference_of_losses_80_to_30_deg_over_half_width": Estimate(
            float(losses.abs()[80.0] - losses.abs()[30.0]) / width, error / width
        ),
        "difference_of_losses_30_over_80_deg": losses[30.0] / losses[80.0],
        "difference_of_restitutions_at_30_deg_over_half_width": Estimate(
            restitution[30.0], resolved(context, "restitution", 30.0)
        ),
        "squared_ratio_of_sines": float((sines[0] / sines[1]) ** 2),
    }


def resolved(context: Context, quantity: str, angle: float) -> float:
    """Return the error of a difference of means on Formica over its half-width."""
    sd, n = (
        np.array([formica(context, f"{who}_{what}", angle).iloc[0] for who in ("steel", "spore")])
        for what in (f"{quantity}_sd", "rebounds")
    )
    difference, over = (
        formica(context, f"{quantity}_difference{ending}", angle).iloc[0]
        for ending in ("", "_over_half_width")
    )
    return float(np.sqrt(np.sum(np.square(sd) / n)) / abs(difference / over))


@claim("C89", evidence=VIRTUAL)
def c89(context: Context) -> dict[str, float | Estimate]:
    """Share of spores captured, or not seen by the camera, while restitution rises."""
    spore, (_, shallow) = context.params.formica.spore, context.params.formica.trend_deg
    at_shallow = {
        column: float(formica(context, column, shallow).iloc[0])
        for column in ("spore_captured_share", "spore_bias_of_conditional_mean")
    }
    return {
        "captured_share_at_15_deg": at_shallow["spore_captured_share"],
        "rise_45_to_15_deg_over_half_width": rise_of_restitution(context, spore),
        "share_not_observed_at_15_deg": watched(context).captured_share,
        "bias_of_conditional_mean_at_15_deg": at_shallow["spore_bias_of_conditional_mean"],
    }


def watched(context: Context) -> Seen:
    """Return the spores on Formica at the shallow angle, as the camera sees them."""
    params = context.params.formica
    return as_imaged(
        params.spore,
        context.contact(params.spore),
        params.trend_deg[1],
        context.series,
        context.params.camera,
        events=params.seen_events,
        most_dropped=params.seen_dropped,
    )
