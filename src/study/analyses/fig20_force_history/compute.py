"""Normal force against time and its four terms (Fig. 20, Eq. 25)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
import pandas as pd

from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.dynamics.trajectory import Trajectory, trajectory
from study.contacts import calibrated_contact, fitted_to, pair_of, printed_values_for
from study.declared.parameters import AngleDegrees, CaseName, Points, Positive
from study.tables import Tables, result_evidence, series_frame

TERMS = {
    "total": "normal_force",
    "hertz": "hertz_force",
    "adhesion": "adhesion_force",
    "adhesion damping": "adhesion_damping_force",
    "hertz damping": "hertz_damping_force",
}

NEEDS = {"calibration": ("calibration",)}
# Ratios of peaks. The damping is fitted to the second.
PRINTED_VALUES = ("peak_adhesion_over_peak_hertz", "peak_adhesion_dissipation_over_adhesion")


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """One impact, how finely its path is sampled, and which printed numbers fixed its inputs."""

    case: CaseName
    diameter_um: Positive
    speed_m_per_s: Positive
    angle_deg: AngleDegrees
    points: Points


def run(params: Params, inputs: Tables) -> Tables:
    """Return the data of Fig. 20 and the ratios of its peaks.

    ``fig20``: the normal force and its terms in uN against time in ns. ``force_ratios``: peak
    ratios, dips, contact time and restitution beside printed values.
    """
    contact = calibrated_contact(inputs, params.case, diameter=params.diameter_um * 1e-6)
    path = trajectory(contact, params.speed_m_per_s, params.angle_deg, points=params.points)
    # A force that contains a fitted parameter is no prediction.
    case = inputs["calibration"].query("case == @params.case and role == 'target'")
    evidence = "computed" if case.empty else "calibrated"
    frame = partial(series_frame, "force", evidence=evidence, x_unit="ns", y_unit="uN")
    frames = [
        frame(series, path.time * 1e9, getattr(path, name) * 1e6) for series, name in TERMS.items()
    ]
    outcome = simulate(contact, params.speed_m_per_s, params.angle_deg)
    numbers = peak_ratios(path) | {
        ("contact_time", "ns"): float(outcome.contact_time) * 1e9,
        ("coefficient_of_restitution", "-"): float(outcome.coefficient_of_restitution),
        ("capture_velocity", "m/s"): float(capture_velocity(contact)),
    }
    printed = printed_values_for(
        inputs,
        *pair_of(inputs, params.case),
        diameter_um=params.diameter_um,
        speed_m_per_s=params.speed_m_per_s,
        angle_deg=params.angle_deg,
    )["value"]
    fitted = (
        PRINTED_VALUES[1:] if fitted_to(inputs, params.case, "dissipation_over_adhesion") else ()
    )
    table = pd.DataFrame(
        {
            "quantity": quantity,
            "value": value,
            "unit": unit,
            "printed": printed.get(quantity, np.nan),
            "evidence": result_evidence(quantity, fitted),
        }
        for (quantity, unit), value in numbers.items()
    )
    return {"fig20": pd.concat(frames, ignore_index=True), "force_ratios": table}


def peak_ratios(path: Trajectory) -> dict[tuple[str, str], float]:
    """Return ratios of the peaks of the terms, and the dips of the total near both ends in uN."""
    hertz = float(np.max(path.hertz_force))
    adhesion = float(np.max(-path.adhesion_force))
    damping = path.adhesion_damping_force, path.hertz_damping_force
    lost = [float(np.max(np.abs(force))) for force in damping]
    turn = int(np.argmax(path.compression))
    return {
        ("peak_adhesion_over_peak_hertz", "-"): adhesion / hertz,
        ("peak_adhesion_dissipation_over_adhesion", "-"): lost[0] / adhesion,
        ("peak_hertz_dissipation_over_hertz", "-"): lost[1] / hertz,
        ("dip_on_approach", "uN"): float(np.min(path.normal_force[: turn + 1])) * 1e6,
        ("dip_on_rebound", "uN"): float(np.min(path.normal_force[turn:])) * 1e6,
        ("peak_normal_force", "uN"): float(np.max(path.normal_force)) * 1e6,
    }
