"""Parameters estimated from printed numbers (3.2.1), and how far the printed numbers fix them.

Steel on silicon by the two-stage method, over the family of works of adhesion and rate exponents
that the article leaves open; ammonium fluorescein on molybdenum from the force ratios of Fig. 20,
as an interval; other pairs by their work of adhesion or by their damping alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from microimpact.model.calibration import (
    damping_factor_for,
    dissipation_ratio_for,
    hertz_damping_for_adhesion_ratio,
    peak_ratios,
    work_of_adhesion_for,
)
from microimpact.model.capture import capture_velocity
from microimpact.model.contact import Contact, resized
from microimpact.model.impact import simulate
from microimpact.parameters import Fraction, Name, Positive
from microimpact.studies._family import (
    TwoStageTargets,
    bare_contact,
    curves,
    family,
    ridge,
    solved,
)
from microimpact.studies._pairs import declared_contact

PARAMETERS = {
    "diameter": "m",
    "work_of_adhesion": "J/m2",
    "hertz_damping": "s/m",
    "adhesion_damping": "s/m",
    "adhesion_rate_exponent": "-",
    "reference_velocity": "m/s",
}


# Contacts with the least, the nominal and the greatest capture velocity of an admissible set.
Corners = tuple[Contact, Contact, Contact]


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceRatios:
    """Ammonium fluorescein on molybdenum: ratios of peaks, as bands, and the sizes to look at."""

    particle: Name
    surface: Name
    diameter_um: Positive
    speed_m_per_s: Positive
    adhesion_over_hertz: Positive
    dissipation_over_adhesion: Positive
    band: Fraction
    other_diameters_um: tuple[Positive, ...]
    printed_capture_velocity_m_per_s: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class WorkTarget:
    """A pair whose work of adhesion follows from its capture velocity."""

    particle: Name
    surface: Name
    diameter_um: Positive
    capture_velocity_m_per_s: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class RestitutionTarget:
    """A pair of which one restitution is known: one factor on both its damping coefficients."""

    case: Name
    particle: Name
    surface: Name
    speed_m_per_s: Positive
    restitution: Fraction


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """What is calibrated, and on which printed numbers."""

    two_stage: TwoStageTargets
    force_ratios: ForceRatios
    by_work_of_adhesion: tuple[WorkTarget, ...]
    by_restitution: tuple[RestitutionTarget, ...]


def run(params: Params, inputs: Mapping[str, pd.DataFrame]) -> Mapping[str, pd.DataFrame]:
    """Calibrate every case.

    Parameters
    ----------
    params
        Parameters of the study.
    inputs
        ``materials``, ``contacts``: the declared rows of the pairs.

    Returns
    -------
    mapping
        ``calibration``: per case its targets, as met, and the parameters found.
        ``calibration_family``: steel on silicon over works of adhesion and exponents, each member
        judged by printed facts. ``molybdenum_capture``: capture velocities in m/s as intervals.
        ``ridge`` and ``ridge_curves``: the family drawn.
    """
    targets, ratios = params.two_stage, params.force_ratios
    corners = _corners(ratios, inputs)
    rows = [
        *_member_rows(targets, inputs),
        *_ratio_rows(ratios, corners),
        *(row for target in params.by_work_of_adhesion for row in _work_rows(target, inputs)),
        *(row for known in params.by_restitution for row in _damping_rows(known, inputs)),
    ]
    members = family(targets, inputs)
    return {
        "calibration": pd.DataFrame(rows),
        "calibration_family": members,
        "molybdenum_capture": capture_intervals(ratios, corners),
        "ridge": ridge(members, targets.facts.flat_within),
        "ridge_curves": curves(targets, inputs),
    }


def capture_intervals(ratios: ForceRatios, corners: Corners) -> pd.DataFrame:
    """Return capture velocities over the admissible set, at every size.

    Both ratios are bands. The adhesion ratio grows with c_H >= 0, so c_H runs from zero to where
    the band's end is met; the capture velocity grows with c_H and with the dissipation ratio, so
    the corners of the set give the interval. Material parameters are the same at every size.
    """
    rows = []
    for diameter in sorted({ratios.diameter_um, *ratios.other_diameters_um}):
        low, nominal, high = (
            float(capture_velocity(resized(contact, diameter * 1e-6))) for contact in corners
        )
        printed = ratios.printed_capture_velocity_m_per_s
        rows.append(
            {
                "diameter_um": diameter,
                "capture_velocity_m_per_s": nominal,
                "low_m_per_s": low,
                "high_m_per_s": high,
                "printed_m_per_s": printed,
                "printed_inside": low <= printed <= high,
                "evidence": "computed",
            }
        )
    return pd.DataFrame(rows)


def _corners(ratios: ForceRatios, inputs: Mapping[str, pd.DataFrame]) -> Corners:
    """Contacts with the least, the nominal and the greatest capture velocity."""
    contact = declared_contact(
        inputs, ratios.particle, ratios.surface, diameter=ratios.diameter_um * 1e-6
    )
    elastic = contact.replace(hertz_damping=0.0)
    speed, wanted, band = ratios.speed_m_per_s, ratios.dissipation_over_adhesion, ratios.band
    return (
        dissipation_ratio_for(elastic, speed, wanted * (1 - band)),
        dissipation_ratio_for(elastic, speed, wanted),
        hertz_damping_for_adhesion_ratio(
            elastic, speed, ratios.adhesion_over_hertz * (1 + band), wanted * (1 + band)
        ),
    )


def _rows(
    case: str, contact: Contact, targets: Mapping[str, tuple[float, float, str]]
) -> list[dict[str, object]]:
    """Return the rows of one case: targets as (value met, target, unit), then parameters."""
    names = {"case": case, "particle": contact.particle.name, "surface": contact.surface.name}
    met = [
        names
        | {"role": "target", "quantity": name, "value": value, "target": target, "unit": unit}
        | {"evidence": "calibrated"}
        for name, (value, target, unit) in targets.items()
    ]
    found = [
        names
        | {"role": "parameter", "quantity": name, "value": float(getattr(contact, name))}
        | {"target": np.nan, "unit": unit, "evidence": "calibrated"}
        for name, unit in PARAMETERS.items()
        if getattr(contact, name) is not None
    ]
    return met + found


def _member_rows(
    targets: TwoStageTargets, inputs: Mapping[str, pd.DataFrame]
) -> list[dict[str, object]]:
    contact, rows = bare_contact(targets, inputs), []
    for exponent, work in zip(targets.member_exponents, targets.member_works_J_per_m2, strict=True):
        member = solved(contact, targets, exponent, work)
        e = float(simulate(member, targets.high_speed_m_per_s).coefficient_of_restitution)
        met = {
            "coefficient_of_restitution": (e, targets.restitution, "-"),
            "capture_velocity": (
                float(capture_velocity(member)),
                targets.capture_velocity_m_per_s,
                "m/s",
            ),
        }
        rows += _rows(f"steel-silicon, n = {exponent:g}", member, met)
    return rows


def _ratio_rows(ratios: ForceRatios, corners: Corners) -> list[dict[str, object]]:
    rows: list[dict[str, object]] = []
    names = ("least", "nominal", "greatest")
    for name, contact in zip(names, corners, strict=True):
        adhesion, dissipation = peak_ratios(contact, ratios.speed_m_per_s)
        met = {
            "adhesion_over_hertz": (adhesion, ratios.adhesion_over_hertz, "-"),
            "dissipation_over_adhesion": (dissipation, ratios.dissipation_over_adhesion, "-"),
        }
        rows += _rows(f"fluorescein-molybdenum, {name}", contact, met)
    return rows


def _work_rows(target: WorkTarget, inputs: Mapping[str, pd.DataFrame]) -> list[dict[str, object]]:
    contact = declared_contact(
        inputs, target.particle, target.surface, diameter=target.diameter_um * 1e-6
    )
    found = work_of_adhesion_for(contact, target.capture_velocity_m_per_s)
    met = {
        "capture_velocity": (
            float(capture_velocity(found)),
            target.capture_velocity_m_per_s,
            "m/s",
        )
    }
    return _rows(f"{target.particle}-{target.surface}", found, met)


def _damping_rows(
    target: RestitutionTarget, inputs: Mapping[str, pd.DataFrame]
) -> list[dict[str, object]]:
    contact = declared_contact(inputs, target.particle, target.surface)
    found = damping_factor_for(contact, target.speed_m_per_s, target.restitution)
    e = float(simulate(found, target.speed_m_per_s).coefficient_of_restitution)
    return _rows(target.case, found, {"coefficient_of_restitution": (e, target.restitution, "-")})
