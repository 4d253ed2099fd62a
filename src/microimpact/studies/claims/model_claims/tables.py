"""Numbers behind the claims that tables of earlier studies hold."""

from __future__ import annotations

import pandas as pd

from microimpact.lab.contacts import calibrated_contact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.studies.claim_numbers import Numbers
from microimpact.studies.claims.model_claims.context import Context

# Columns of the couples that can arise during an impact, over the couple of friction: from all that
# the impact loses, and from the model's own damping. Those of steady rolling and the bound are none
# of these: an impact rolls through an eighth of the contact radius at most.
COUPLES = ("impact_over_friction", "damping_over_friction")


def force_ratio(context: Context, quantity: str) -> float:
    """Return a number of the force history of Fig. 20."""
    table = context.inputs["force_ratios"].set_index("quantity")["value"]
    return float(table[quantity])


def c30(context: Context) -> dict[str, float]:
    """Least normal force before and after the greatest compression, over the greatest force."""
    peak = force_ratio(context, "peak_normal_force")
    first = force_ratio(context, "dip_on_approach")
    second = force_ratio(context, "dip_on_rebound")
    return {
        "first_dip_over_peak_force": first / peak,
        "second_dip_over_peak_force": second / peak,
        "ratio_of_second_to_first_dip": second / first,
    }


def c31(context: Context) -> dict[str, float]:
    """Work of adhesion that gives the printed ring force by Eq. (30)."""
    work = context.fluorescein.work_of_adhesion
    assert work is not None
    return {"work_of_adhesion_by_eq_30": float(work)}


def c32(context: Context) -> dict[str, float]:
    """Greatest ring force over greatest Hertz force."""
    ratio = force_ratio(context, "peak_adhesion_over_peak_hertz")
    return {"peak_adhesion_over_peak_hertz": ratio}


def c33(context: Context) -> dict[str, float]:
    """Greatest damping force of adhesion over greatest ring force."""
    ratio = force_ratio(context, "peak_adhesion_dissipation_over_adhesion")
    return {"peak_adhesion_dissipation_over_adhesion": ratio}


def c34(context: Context) -> dict[str, float]:
    """Ends of the interval of capture velocities over the contacts that both ratios admit."""
    table = context.inputs["molybdenum_capture"]
    rows = table[table["diameter_um"] == context.params.fluorescein.diameter_um]
    if len(rows) != 1:
        raise ValueError(
            f"fluorescein.diameter_um: {context.params.fluorescein.diameter_um:g} is not among"
            f" the diameters of molybdenum_capture, {sorted(table['diameter_um'])}"
        )
    low, high = float(rows["low_m_per_s"].iloc[0]), float(rows["high_m_per_s"].iloc[0])
    return {
        "least_capture_velocity": low,
        "greatest_capture_velocity": high,
        "greatest_over_least_capture_velocity": high / low,
    }


def c35(context: Context) -> dict[str, float]:
    """Capture velocity of the calibrated contact on mica, and its work over that on molybdenum."""
    mica = calibrated_contact(context.inputs, context.params.fluorescein.on_mica.case)
    work, other = mica.work_of_adhesion, context.fluorescein.work_of_adhesion
    assert work is not None
    assert other is not None
    return {
        "capture_velocity": float(capture_velocity(mica)),
        "work_of_adhesion_over_that_on_molybdenum": float(work / other),
    }


def c42(context: Context) -> dict[str, float]:
    """Greatest impulse of the couples that can arise in an impact over that of friction.

    Over all rebounds of the table; beside it what steady rolling would give and what no couple
    exceeds, the greatest contact radius over the radius, and the distance rolled over it.
    """
    table = context.inputs["rolling_dissipation"]
    rebounds = table["captured"].astype(str) == "False"
    rows = table[(table["case"] == context.case) & rebounds]
    return {
        "largest_rolling_couple_over_friction_couple": _largest(rows[list(COUPLES)]),
        "largest_contact_radius_over_radius": _largest(rows[["contact_radius_over_r"]]),
        "largest_couple_of_steady_rolling_over_friction_couple": _largest(
            rows[["steady_over_friction"]]
        ),
        "largest_bound_of_couple_over_friction_couple": _largest(rows[["bound_over_friction"]]),
        "largest_distance_rolled_over_contact_radius": _largest(
            rows[["rolled_over_contact_radius"]]
        ),
    }


def _largest(rows: pd.DataFrame) -> float:
    return float(rows.to_numpy(float).max())


_CAPTURES = ("least_capture_velocity", "greatest_capture_velocity")

CLAIMS = {
    "C30": Numbers(of=c30),
    "C31": Numbers(of=c31, evidence="calibrated", units={"work_of_adhesion_by_eq_30": "J/m2"}),
    "C32": Numbers(of=c32, evidence="calibrated"),
    "C33": Numbers(of=c33, evidence="calibrated"),
    "C34": Numbers(of=c34, units=dict.fromkeys(_CAPTURES, "m/s")),
    "C35": Numbers(of=c35, evidence="calibrated", units={"capture_velocity": "m/s"}),
    "C42": Numbers(of=c42, by_case=True),
}
