"""Steel on silicon: the family of parameters that the printed numbers leave open.

Two numbers are fitted, restitution at a high speed and the capture velocity; the work of adhesion
and the rate exponent of the adhesion damping stay free, and are judged by facts that were not
fitted.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from microimpact.model.calibration import NoSolutionError, two_stage
from microimpact.model.contact import Contact
from microimpact.model.impact import simulate
from microimpact.model.normal import normal_impact
from microimpact.parameters import Finite, Fraction, Name, NonNegative, Positive
from microimpact.studies._pairs import declared_contact
from microimpact.tables import series_frame


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """Printed facts that were not fitted, and how well a member of the family must meet them."""

    flat_from_m_per_s: Positive
    flat_within: Positive
    shallow_angle_deg: Positive
    shallow_speed_m_per_s: Positive
    shallow_restitution: Fraction
    shallow_within: Positive
    grazing_angle_deg: Positive
    grazing_restitution: Fraction
    plateau_angles_deg: tuple[Finite, Finite]
    rise_angles_deg: tuple[Finite, Finite]
    about: Positive
    contact_times_ns: tuple[Finite, Finite]


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoStageTargets:
    """Steel on silicon: targets, the family looked through, and the members others use."""

    particle: Name
    surface: Name
    diameter_um: Positive
    high_speed_m_per_s: Positive
    restitution: Fraction
    capture_velocity_m_per_s: Positive
    rate_exponents: tuple[NonNegative, ...]
    works_of_adhesion_J_per_m2: tuple[Positive, ...]  # noqa: N815
    member_exponents: tuple[NonNegative, ...]
    member_works_J_per_m2: tuple[Positive, ...]  # noqa: N815
    facts: Facts

    def __post_init__(self) -> None:
        """Refuse members that do not pair up."""
        if len(self.member_exponents) != len(self.member_works_J_per_m2):
            raise ValueError("member_exponents and member_works_J_per_m2 must have the same length")


def bare_contact(targets: TwoStageTargets, inputs: Mapping[str, pd.DataFrame]) -> Contact:
    """Return the steel-silicon contact, normalised at the speed of the high target."""
    return declared_contact(
        inputs,
        targets.particle,
        targets.surface,
        diameter=targets.diameter_um * 1e-6,
        reference_velocity=targets.high_speed_m_per_s,
    )


def solved(contact: Contact, targets: TwoStageTargets, exponent: float, work: float) -> Contact:
    """Return the member of the family at one rate exponent and work of adhesion."""
    changed = contact.replace(adhesion_rate_exponent=exponent, work_of_adhesion=work)
    return two_stage(
        changed, targets.high_speed_m_per_s, targets.restitution, targets.capture_velocity_m_per_s
    ).contact


def family(targets: TwoStageTargets, inputs: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Return every member looked for: its parameters and facts, or why there is none."""
    contact = bare_contact(targets, inputs)
    rows: list[dict[str, object]] = []
    for exponent in targets.rate_exponents:
        for work in targets.works_of_adhesion_J_per_m2:
            row: dict[str, object] = {"rate_exponent": exponent, "work_of_adhesion_J_per_m2": work}
            try:
                member = solved(contact, targets, exponent, work)
            except NoSolutionError as reason:
                rows.append(row | {"solved": False, "reason": str(reason)})
                continue
            unit = member.damping_unit
            parameters = {
                "hertz_damping_s_per_m": float(member.hertz_damping),
                "adhesion_damping_s_per_m": float(member.adhesion_damping),
                "zeta_hertz": float(member.hertz_damping / unit),
                "zeta_adhesion": float(member.adhesion_damping / unit),
            }
            rows.append(row | {"solved": True} | parameters | facts(member, targets))
    return pd.DataFrame(rows)


def facts(member: Contact, targets: TwoStageTargets) -> dict[str, object]:
    """Return the printed facts that were not fitted, as this member has them, and the verdicts."""
    wanted, speed = targets.facts, targets.high_speed_m_per_s
    between = np.geomspace(wanted.flat_from_m_per_s, speed, 20)
    e = simulate(member, between).coefficient_of_restitution
    deviation = float(np.abs(e - targets.restitution).max())
    shallow = simulate(member, wanted.shallow_speed_m_per_s, wanted.shallow_angle_deg)
    grazing = simulate(member, speed, wanted.grazing_angle_deg)
    plateau = simulate(member, speed, np.array(wanted.plateau_angles_deg)).impulse_ratio
    rise = simulate(member, speed, np.array(wanted.rise_angles_deg)).impulse_ratio
    ledger = normal_impact(member, speed, ledger=True).ledger
    assert ledger is not None
    share = float(ledger.adhesion_work / (ledger.adhesion_work + ledger.hertz_work))
    times = simulate(member, np.array([1.2 * targets.capture_velocity_m_per_s, speed])).contact_time
    shortest, longest = float(times.min()) * 1e9, float(times.max()) * 1e9
    low, high = wanted.contact_times_ns
    e_shallow = float(shallow.coefficient_of_restitution)
    e_grazing = float(grazing.coefficient_of_restitution)
    flat, raised = float(plateau[0] / plateau[1]), float(rise[0] / rise[1])
    return {
        "deviation_from_plateau": deviation,
        "plateau_of_e_holds": deviation <= wanted.flat_within,
        "e_shallow": e_shallow,
        "e_shallow_holds": abs(e_shallow - wanted.shallow_restitution) <= wanted.shallow_within,
        "e_grazing": e_grazing,
        "e_grazing_holds": abs(e_grazing / wanted.grazing_restitution - 1.0) <= wanted.about,
        "plateau_of_impulse_ratio": flat,
        "plateau_of_impulse_ratio_holds": abs(flat - 1.0) <= wanted.about,
        "rise_of_impulse_ratio": raised,
        "rise_of_impulse_ratio_holds": raised > 1.0 + wanted.about,
        "adhesion_share_of_loss": share,
        "most_loss_by_adhesion_holds": share > 0.5,
        "shortest_contact_ns": shortest,
        "longest_contact_ns": longest,
        "contact_times_hold": shortest >= low * (1 - wanted.about)
        and longest <= high * (1 + wanted.about),
    }


def ridge(members: pd.DataFrame, flat_within: float) -> pd.DataFrame:
    """Return how far e leaves its plateau, against the work of adhesion, per exponent."""
    frames = []
    for exponent, rows in members[members["solved"]].groupby("rate_exponent"):
        frames.append(
            series_frame(
                panel="ridge",
                series=f"n = {exponent:g}",
                evidence="calibrated",
                x=rows["work_of_adhesion_J_per_m2"].to_numpy(float),
                y=rows["deviation_from_plateau"].to_numpy(float),
                x_unit="J_per_m2",
                y_unit="1",
            )
        )
    works = members["work_of_adhesion_J_per_m2"].to_numpy(float)
    frames.append(
        series_frame(
            panel="ridge",
            series="criterion",
            evidence="computed",
            x=[works.min(), works.max()],
            y=flat_within,
            x_unit="J_per_m2",
            y_unit="1",
        )
    )
    return pd.concat(frames, ignore_index=True)


def curves(targets: TwoStageTargets, inputs: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Return e against speed for the members that others use, with the printed targets."""
    contact, frames = bare_contact(targets, inputs), []
    speed = np.geomspace(targets.capture_velocity_m_per_s, 3.0, 200)
    common = {"panel": "curves", "x_unit": "m_per_s", "y_unit": "1"}
    for exponent, work in zip(targets.member_exponents, targets.member_works_J_per_m2, strict=True):
        e = simulate(solved(contact, targets, exponent, work), speed).coefficient_of_restitution
        # At the capture velocity itself rounding decides between none and hardly any.
        e = np.where(speed > targets.capture_velocity_m_per_s, e, 0.0)
        name = f"n = {exponent:g}, w = {work:g} J/m2"
        frames.append(series_frame(series=name, evidence="calibrated", x=speed, y=e, **common))
    x = [targets.capture_velocity_m_per_s, targets.high_speed_m_per_s]
    y = [0.0, targets.restitution]
    frames.append(series_frame(series="targets", evidence="printed", x=x, y=y, **common))
    return pd.concat(frames, ignore_index=True)
