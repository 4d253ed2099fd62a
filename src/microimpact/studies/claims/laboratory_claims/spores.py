"""Numbers behind the claims on spores, beside steel and below 38 deg."""

from __future__ import annotations

import numpy as np

from microimpact.studies.claims.laboratory_claims.context import Context, Numbers


def trend(context: Context, mechanism: str, column: str) -> float:
    """Return a trend that a supposed cause gives, over its half-width.

    It is 0 where so few rebound at one of the angles that there is no trend to see.
    """
    rows = context.table("spore_trends", mechanism=mechanism)
    return float(np.nan_to_num(rows[f"{column}_over_half_width"].iloc[0]))


def c81(context: Context) -> dict[str, float]:
    """Largest difference of restitution, steel less spores, each calibrated at 85 deg alone."""
    found = context.column("spore_comparison", "restitution_difference_over_half_width")
    compared = found.loc[list(context.params.mechanisms.compared_deg)]
    return {"largest_difference_at_70_and_55_deg_over_half_width": compared.abs().max()}


def c82(context: Context) -> dict[str, float]:
    """Printed normal speed over the quoted capture velocity; what the smooth spore does below."""
    first = context.table("smooth_spore").iloc[0]
    quoted = first["normal_speed_m_per_s"] / first["normal_speed_over_quoted_capture_velocity"]
    restitution = context.column("smooth_spore", "restitution")
    return {
        "normal_speed_at_38_deg_over_quoted_capture_velocity": (
            context.printed("normal_speed_lycopodium_38deg") / quoted
        ),
        "fall_of_restitution_of_smooth_spore_38_to_10_deg": restitution[38.0] - restitution[10.0],
        "angle_of_quoted_capture_velocity": first["angle_of_quoted_capture_velocity_deg"],
    }


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


def c84(context: Context) -> dict[str, float]:
    """Rises and fall of the impulse ratio as the camera sees them."""
    seen = context.params.mechanisms.spore_seen
    return {
        "rise_85_to_20_deg_over_half_width": trend(context, seen, "impulse_ratio_rise_85_to_20"),
        "rise_45_to_20_deg_over_half_width": trend(context, seen, "impulse_ratio_rise_45_to_20"),
        "fall_15_to_5_deg_over_half_width": trend(context, seen, "impulse_ratio_fall_15_to_5"),
    }


def c85(context: Context) -> dict[str, float]:
    """Differences of the losses and of the printed restitutions at 40 deg."""
    row = context.inputs["loss_resolution"].iloc[0]
    return {
        f"difference_of_{name}_at_40_deg_over_half_width": float(
            abs(row[f"difference_of_{name}_over_half_width"])
        )
        for name in ("losses", "restitutions")
    }


CLAIMS = {
    "C81": Numbers(of=c81, by_case=True),
    "C82": Numbers(of=c82, evidence="computed", units={"angle_of_quoted_capture_velocity": "deg"}),
    "C83": Numbers(of=c83),
    "C84": Numbers(of=c84),
    "C85": Numbers(of=c85, evidence="computed"),
}
