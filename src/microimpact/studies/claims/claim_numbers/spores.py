"""Numbers of the claims of Sections 2.4.3 and 2.4.4: spores on silicon, and on Formica."""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from microimpact.lab.samples import Dropped, Seen
from microimpact.studies.claims.claim_numbers.claim import CALIBRATED, VIRTUAL, claim
from microimpact.studies.claims.claim_numbers.context import (
    Context,
)
from microimpact.studies.experiments.mechanisms.spore import as_imaged


@claim("C17", units="m/s")
def c17(context: Context) -> dict[str, float]:
    """Total speeds that the two printed normal speeds of the spores mean."""
    angles = np.radians(context.params.formica.spore_angles_deg)
    keys = ("normal_speed_lycopodium_48deg", "normal_speed_lycopodium_38deg")
    speeds = np.array([context.printed(key) for key in keys]) / np.sin(angles)
    return {
        "difference_of_total_speeds": speeds[0] - speeds[1],
        "total_speed": speeds.mean(),
    }


@claim("C81", by_case=True, evidence=VIRTUAL)
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
def c83(context: Context) -> dict[str, float]:
    """Rise of restitution from 38 to 15 deg by each cause alone."""
    named = context.params.mechanisms
    rise = "restitution_rise_38_to_15"
    return {
        "rise_38_to_15_deg_by_slopes_over_half_width": trend(context, named.spore_slopes, rise),
        "rise_38_to_15_deg_by_second_contacts_over_half_width": trend(
            context, named.spore_second_contacts, rise
        ),
        "rise_38_to_15_deg_by_collisions_off_centre_over_half_width": trend(
            context, named.spore_off_centre, rise
        ),
    }


def trend(context: Context, mechanism: str, column: str) -> float:
    """Return a trend that a supposed cause gives, over its half-width.

    It is 0 where so few rebound at one of the angles that there is no trend to see.
    """
    rows = context.table("spore_trends", mechanism=mechanism)
    return float(np.nan_to_num(rows[f"{column}_over_half_width"].iloc[0]))


@claim("C84", evidence=VIRTUAL)
def c84(context: Context) -> dict[str, float]:
    """Rises and fall of the impulse ratio as the camera sees them."""
    seen = context.params.mechanisms.spore_seen
    return {
        "rise_85_to_20_deg_over_half_width": trend(context, seen, "impulse_ratio_rise_85_to_20"),
        "rise_45_to_20_deg_over_half_width": trend(context, seen, "impulse_ratio_rise_45_to_20"),
        "fall_15_to_5_deg_over_half_width": trend(context, seen, "impulse_ratio_fall_15_to_5"),
    }


@claim("C85")
def c85(context: Context) -> dict[str, float]:
    """Differences of the losses and of the printed restitutions at 40 deg."""
    row = context.table("loss_resolution").iloc[0]
    return {
        f"difference_of_{name}_at_40_deg_over_half_width": float(
            abs(row[f"difference_of_{name}_over_half_width"])
        )
        for name in ("losses", "restitutions")
    }


@claim("C86", evidence=CALIBRATED, units={"slope_deviation_of_formica": "rad"})
def c86(context: Context) -> dict[str, float]:
    """Restitution of steel less that of spores, rises of both, and that of steel itself."""
    samples = context.params.formica
    steel = formica(context, "steel_restitution", (20.0, 15.0))
    return {
        "least_difference_steel_less_spore_over_half_width": compared(
            context, "restitution_difference_over_half_width"
        ).min(),
        "lesser_rise_45_to_15_deg_over_half_width": min(
            rise_of_restitution(context, one) for one in (samples.steel, samples.spore)
        ),
        "measured_restitution_of_steel_at_20_deg": steel[20.0],
        "measured_restitution_of_steel_at_15_deg": steel[15.0],
        "slope_deviation_of_formica": samples.steel.surface_slope,
    }


def rise_of_restitution(context: Context, dropped: Dropped) -> float:
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
def c87(context: Context) -> dict[str, float]:
    """Largest difference of the impulse ratios, and the lesser rise towards shallow angles."""
    return {
        "largest_difference_of_impulse_ratios": compared(context, "impulse_ratio_difference")
        .abs()
        .max(),
        "lesser_rise_45_to_15_deg": lesser_rise(context),
    }


def lesser_rise(context: Context) -> float:
    """Return the lesser rise of the impulse ratio of steel and of spores."""
    steep, shallow = trend = context.params.formica.trend_deg
    ratios = [formica(context, f"{name}_impulse_ratio", trend) for name in ("steel", "spore")]
    return float(min(ratio[shallow] - ratio[steep] for ratio in ratios))


@claim("C88", evidence=VIRTUAL)
def c88(context: Context) -> dict[str, float]:
    """Difference of the losses at 30 deg over that at 80 deg, and of the restitutions at 30."""
    losses = formica(context, "energy_loss_difference", (30.0, 80.0))
    restitution = formica(context, "restitution_difference_over_half_width", 30.0)
    sines = np.sin(np.radians([30.0, 80.0]))
    return {
        "difference_of_losses_30_over_80_deg": losses[30.0] / losses[80.0],
        "difference_of_restitutions_at_30_deg_over_half_width": restitution[30.0],
        "squared_ratio_of_sines": float((sines[0] / sines[1]) ** 2),
    }


@claim("C89", evidence=VIRTUAL)
def c89(context: Context) -> dict[str, float]:
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
