"""Numbers behind the claims on instruments, intervals and piles, from tables of other studies."""

from __future__ import annotations

import numpy as np

from microimpact.studies.claims.laboratory_claims.context import Context, Numbers
from microimpact.studies.experiments.pile_up import onset

# An interval that is said to hold the mean so often does, if it does so within the tolerance.
LEVEL, LEVEL_TOLERANCE = 0.95, 0.015


def c61(context: Context) -> dict[str, float]:
    """Speeds that the best field of view serves at its best angle, and the disk that they need.

    The disk speed is the greatest over the speeds served.
    """
    table = context.table("ptis_range", method="model")
    pulses = context.params.instruments.most_pulses_per_s
    served = table[table["covered"] & (table["chop_per_s"] <= pulses)]
    views = [
        (
            own["speed_m_per_s"].nunique(),
            float(own["view_width_mm"].iloc[0]),
            float(own["disk_rev_per_min"].max()),
        )
        for _, own in served.groupby(["view_width_mm", "angle_deg"])
    ]
    count, width, disk = max(views, default=(0, 0.0, 0.0))
    return {
        "speeds_served_by_best_field_of_view": count,
        "disk_speed_needed": disk,
        "best_field_of_view": width,
    }


def c62(context: Context) -> dict[str, float]:
    """Largest change of precision and recall with the height of the probe, at any of the speeds.

    Heights at which no pair is recorded have neither.
    """
    table = context.inputs["pairing_quality"]
    speeds = context.params.instruments.pair_speeds_m_per_s
    chosen = table[table["speed_m_per_s"].isin(speeds)].groupby("speed_m_per_s")
    change = chosen[["precision", "recall"]].max() - chosen[["precision", "recall"]].min()
    return {f"largest_change_of_{name}": float(change[name].max()) for name in change}


def c63(context: Context) -> dict[str, float]:
    """Share of intervals of restitution that hold either mean: the extremes over experiments."""
    table = context.table("interval_coverage", quantity="restitution")
    coverage = table["coverage_observable"]
    least = table.iloc[int(coverage.argmin())]
    return {
        "least_coverage_of_mean_of_observable_events": float(coverage.min()),
        "greatest_coverage_of_mean_of_observable_events": float(coverage.max()),
        "speed_at_least_coverage": float(least["speed_m_per_s"]),
        "angle_at_least_coverage": float(least["angle_deg"]),
        "share_of_experiments_within_0p015": float(
            ((coverage - LEVEL).abs() <= LEVEL_TOLERANCE).mean()
        ),
        "least_coverage_of_mean_of_all_impacts": float(table["coverage_all"].min()),
    }


def c66(context: Context) -> dict[str, float]:
    """Speeds below which a target piles up, for strong and weak capture.

    Their difference, the largest and the least, over all targets and scatters.
    """
    params = context.params.instruments
    table = context.inputs["pile_up"]
    found = {
        (radius, slope): [
            first_pile(context, radius, slope, velocity)
            for velocity in (params.strong_capture_m_per_s, params.weak_capture_m_per_s)
        ]
        for radius, slope in table[["target_radius_mm", "slope_deg"]]
        .drop_duplicates()
        .itertuples(index=False)
    }
    near = min(
        found,
        key=lambda one: (
            abs(one[0] - params.pile_radius_mm),
            abs(one[1] - params.pile_slope_deg),
        ),
    )
    difference = [abs(strong - weak) for strong, weak in found.values()]
    return {
        "onset_speed_at_capture_velocity_0p18": found[near][0],
        "onset_speed_at_capture_velocity_0p02": found[near][1],
        "largest_difference_of_onset_speeds": max(difference),
        "least_difference_of_onset_speeds": min(difference),
    }


def first_pile(context: Context, radius: float, slope: float, velocity: float) -> float:
    """Return the highest speed (m/s) at which the share that counts as a pile rests on a target.

    The slowest of the speeds tried, if there is no pile at any of them.
    """
    rows = context.table("pile_up", target_radius_mm=radius, slope_deg=slope)
    rows = rows[np.isclose(rows["capture_velocity_m_per_s"], velocity)]
    speed, share = (rows[name].to_numpy(float) for name in ("speed_m_per_s", "share_on_target"))
    wanted = context.params.instruments.pile_share
    return float(speed[0]) if np.all(share < wanted) else onset(speed, share, wanted)


_ONSETS = (
    "onset_speed_at_capture_velocity_0p18",
    "onset_speed_at_capture_velocity_0p02",
    "largest_difference_of_onset_speeds",
    "least_difference_of_onset_speeds",
)

CLAIMS = {
    "C61": Numbers(of=c61, units={"disk_speed_needed": "rev/min", "best_field_of_view": "mm"}),
    "C62": Numbers(of=c62),
    "C63": Numbers(
        of=c63, units={"speed_at_least_coverage": "m/s", "angle_at_least_coverage": "deg"}
    ),
    "C66": Numbers(of=c66, units=dict.fromkeys(_ONSETS, "m/s")),
}
