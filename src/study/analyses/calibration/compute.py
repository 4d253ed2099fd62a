"""Parameters estimated from printed numbers (3.2.1), and how far the printed numbers fix them.

Steel on silicon by the two-stage method, over the family of works of adhesion and rate exponents
that the article leaves open; ammonium fluorescein on molybdenum from the force ratios of Fig. 20,
as an interval; other pairs by their work of adhesion or by their damping alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, partial
from itertools import product

import numpy as np
import pandas as pd

from microimpact.core.arrays import UNIT_OF
from microimpact.core.computable import NotComputable
from microimpact.model.calibration import (
    NoSolutionError,
    damping_factor_for,
    dissipation_ratio_for,
    hertz_damping_for_adhesion_ratio,
    law_for,
    peak_ratios,
    two_stage,
    work_of_adhesion_for,
)
from microimpact.model.choices import FittedLaw
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from study.contacts import (
    CAPTURE_VELOCITIES,
    declared_contact,
    printed_capture_velocity,
)
from study.declared.parameters import (
    CaseName,
    CounterpartName,
    Fraction,
    MaterialName,
    NonNegative,
    Positive,
)
from study.tables import (
    NOT_COMPUTED,
    NotComputedError,
    Row,
    Tables,
    not_computed,
    reason,
    series_frame,
)

PRINTED_VALUES = CAPTURE_VELOCITIES


@dataclass(frozen=True, slots=True, kw_only=True)
class Member:
    """A case of the family: one work of adhesion and one rate exponent.

    The damping is fitted at another work of adhesion if one is named, and stays what it is, as in
    other air. Another law takes the place of the ring force; its work of adhesion and its loss are
    fitted to the same targets.
    """

    rate_exponent: NonNegative
    work_of_adhesion_J_per_m2: Positive  # noqa: N815
    damping_fitted_at_J_per_m2: Positive | None = None  # noqa: N815
    law: FittedLaw | None = None

    def __post_init__(self) -> None:
        """Refuse a work of adhesion beside a law that has its own."""
        if self.law and self.damping_fitted_at_J_per_m2:
            raise ValueError("law: has its own work of adhesion: leave damping_fitted_at_J_per_m2")


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoStageTargets:
    """Steel on silicon: targets, the family looked through, and the members others use.

    Restitution is printed as constant from ``flat_from_m_per_s`` on, here to ``flat_within``.
    """

    particle: MaterialName
    surface: CounterpartName
    diameter_um: Positive
    speed_m_per_s: Positive
    restitution: Fraction
    capture_velocity_m_per_s: Positive
    rate_exponents: tuple[NonNegative, ...]
    works_of_adhesion_J_per_m2: tuple[Positive, ...]  # noqa: N815
    members: dict[CaseName, Member]
    flat_from_m_per_s: Positive
    flat_within: Positive

    @property
    def aims(self) -> tuple[float, float, float]:
        """Speed (m/s), restitution there, and capture velocity (m/s)."""
        return self.speed_m_per_s, self.restitution, self.capture_velocity_m_per_s


def bare_contact(targets: TwoStageTargets, inputs: Tables) -> Contact:
    """Return the steel-silicon contact, normalised at the speed of the high target."""
    return declared_contact(
        inputs,
        targets.particle,
        targets.surface,
        diameter=targets.diameter_um * 1e-6,
        reference_velocity=targets.speed_m_per_s,
    )


@cache
def solved(
    contact: Contact, aims: tuple[float, float, float], exponent: float, work: float
) -> Contact:
    """Return the member of the family at one rate exponent and work of adhesion (J/m2).

    Parameters
    ----------
    aims
        Speed (m/s), restitution there, and capture velocity (m/s).
    """
    changed = contact.replace(adhesion_rate_exponent=exponent, work_of_adhesion=work)
    return two_stage(changed, *aims).contact


def family(targets: TwoStageTargets, inputs: Tables) -> pd.DataFrame:
    """Return every member looked for: its parameters and plateau, or why there is none."""
    contact = bare_contact(targets, inputs)
    rows: list[Row] = []
    for exponent, work in product(targets.rate_exponents, targets.works_of_adhesion_J_per_m2):
        row: Row = {"rate_exponent": exponent, "work_of_adhesion_J_per_m2": work}
        try:
            member = solved(contact, targets.aims, exponent, work)
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
        deviation = deviation_from_plateau(member, targets)
        fact = {
            "deviation_from_plateau": deviation,
            "plateau_of_e_holds": deviation <= targets.flat_within,
        }
        rows.append(row | {"solved": True} | parameters | fact)
    return pd.DataFrame(rows)


def deviation_from_plateau(member: Contact, targets: TwoStageTargets) -> float:
    """Return the largest difference of e from its plateau, which was not fitted."""
    speed = np.geomspace(targets.flat_from_m_per_s, targets.speed_m_per_s, 20)
    e = simulate(member, speed).coefficient_of_restitution
    return float(np.abs(e - targets.restitution).max())


def ridge(members: pd.DataFrame, flat_within: float) -> pd.DataFrame:
    """Return how far e leaves its plateau, against the work of adhesion, per exponent."""
    if not members["solved"].any():
        return not_computed("calibration.two_stage: no member of the family has a solution")
    frame = partial(series_frame, "ridge", x_unit="J_per_m2", y_unit="1")
    x, y = "work_of_adhesion_J_per_m2", "deviation_from_plateau"
    frames = [
        frame(f"n = {exponent:g}", rows[x], rows[y], "calibrated")
        for exponent, rows in members[members["solved"]].groupby("rate_exponent")
    ]
    frames.append(frame("criterion", members[x].agg(["min", "max"]), flat_within))
    return pd.concat(frames, ignore_index=True)


def curves(
    targets: TwoStageTargets, members: Mapping[str, Contact], inputs: Tables
) -> pd.DataFrame:
    """Return e against speed for the members that others use, by case, with the targets."""
    frames = []
    speed = np.geomspace(targets.capture_velocity_m_per_s, 3.0, 200)
    frame = partial(series_frame, "curves", x_unit="m_per_s", y_unit="1")
    for case, member in members.items():
        e = simulate(member, speed).coefficient_of_restitution
        # At the capture velocity itself rounding decides between none and hardly any.
        e = np.where(speed > targets.capture_velocity_m_per_s, e, 0.0)
        frames.append(frame(case, speed, e, "calibrated"))
    # Of normal impact only the capture velocity is printed.
    limit = targets.capture_velocity_m_per_s
    is_printed = limit == printed_capture_velocity(inputs, bare_contact(targets, inputs))
    frames.append(frame("targets", limit, 0.0, "printed" if is_printed else "assumed"))
    frames.append(frame("targets", targets.speed_m_per_s, targets.restitution, "assumed"))
    return pd.concat(frames, ignore_index=True)


PARAMETERS = {
    "diameter": "m",
    "work_of_adhesion": "J/m2",
    "hertz_damping": "s/m",
    "adhesion_damping": "s/m",
    "adhesion_rate_exponent": "-",
    "reference_velocity": "m/s",
}


CORNERS = tuple(f"fluorescein-molybdenum, {name}" for name in ("least", "nominal", "greatest"))

# Of the table of cases; where one has no solution, there is a ``problem`` as well.
COLUMNS = ["case", "particle", "surface", "role", "quantity", "value", "target", "unit", "evidence"]

# Contacts with the least, the nominal and the greatest capture velocity that two ratios allow.
Corners = tuple[Contact, Contact, Contact]
# Of each quantity of a contact: the value met, its target, and the unit.
Met = dict[str, tuple[float, float, str]]


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceRatios:
    """Ammonium fluorescein on molybdenum: ratios of peaks, as bands, and the sizes to look at."""

    particle: MaterialName
    surface: CounterpartName
    diameter_um: Positive
    speed_m_per_s: Positive
    adhesion_over_hertz: Positive
    dissipation_over_adhesion: Positive
    band: Fraction
    other_diameters_um: tuple[Positive, ...]
    capture_velocity_m_per_s: Positive  # As printed


@dataclass(frozen=True, slots=True, kw_only=True)
class WorkTarget:
    """A pair whose work of adhesion follows from its capture velocity, damped as another case."""

    damped_as: CaseName
    particle: MaterialName
    surface: CounterpartName
    diameter_um: Positive
    capture_velocity_m_per_s: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class RestitutionTarget:
    """A pair of which one restitution is known: one factor on both coefficients of another case."""

    damped_as: CaseName
    particle: MaterialName
    surface: CounterpartName
    speed_m_per_s: Positive
    restitution: Fraction


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Cases that are calibrated, and their printed targets."""

    two_stage: TwoStageTargets
    force_ratios: ForceRatios
    by_work_of_adhesion: dict[CaseName, WorkTarget]
    by_restitution: dict[CaseName, RestitutionTarget]

    def __post_init__(self) -> None:
        """Refuse the damping of a case that is itself damped as another."""
        allowed = (*self.two_stage.members, *CORNERS)
        for key in ("by_work_of_adhesion", "by_restitution"):
            for case, target in getattr(self, key).items():
                if (name := target.damped_as) not in allowed:
                    names = "; ".join(allowed)
                    raise ValueError(f"{key}: {case}.damped_as: {name!r} must be one of {names}")

    @property
    def calibrated(self) -> set[str]:
        """Names of all cases whose contact the study finds."""
        members = self.two_stage.members
        return {*CORNERS, *members, *self.by_work_of_adhesion, *self.by_restitution}


def lacking(params: Params, cases: Iterable[str]) -> Iterator[str]:
    """Yield a line for each case that an analysis names and that is not calibrated."""
    for case in cases:
        if case not in params.calibrated:
            yield f"cases.{case}: is named, but calibration does not calibrate it"


# The contact of every case so far, or why there is none.
Known = dict[str, Contact | NotComputedError]
Solution = tuple[Contact, Met]
# Key of a case, its name, whose pair it is, and what solves it.
Attempt = tuple[
    str,
    str,
    TwoStageTargets | ForceRatios | WorkTarget | RestitutionTarget,
    Callable[[], Solution],
]


def run(params: Params, inputs: Tables) -> Tables:
    """Calibrate every case.

    ``calibration``: per case its targets, as met, and the parameters found, or why there are none.
    ``calibration_family``: steel on silicon over works of adhesion and exponents, each member
    judged by the plateau of e. ``molybdenum_capture``: capture velocities in m/s as intervals.
    ``ridge`` and ``ridge_curves``: the family drawn.
    """
    targets = params.two_stage
    known: Known = {}
    rows: list[Row] = []
    for key, case, pair, solve in _cases(params, known, inputs):
        try:
            contact, met = solve()
        except NotComputable as error:
            known[case] = NotComputedError(reason(f"calibration.{key}", error))
            bodies = {"particle": pair.particle, "surface": pair.surface}
            why = {"role": NOT_COMPUTED, "problem": str(known[case]), "evidence": "calibrated"}
            rows.append({"case": case, **bodies, **why})
        else:
            known[case] = contact
            rows += _case_rows(case, contact, met)
    family_table = family(targets, inputs)
    try:
        least, nominal, greatest = (_contact(known, case) for case in CORNERS)
        intervals = capture_intervals(params.force_ratios, (least, nominal, greatest))
    except NotComputable as error:
        intervals = not_computed(reason("calibration.force_ratios", error))
    members = {
        case: member for case in targets.members if isinstance(member := known[case], Contact)
    }
    columns = COLUMNS + ["problem"] * any("problem" in row for row in rows)
    return {
        "calibration": pd.DataFrame(rows, columns=columns),
        "calibration_family": family_table,
        "molybdenum_capture": intervals,
        "ridge": ridge(family_table, targets.flat_within),
        "ridge_curves": curves(targets, members, inputs),
    }


def capture_intervals(ratios: ForceRatios, corners: Corners) -> pd.DataFrame:
    """Return capture velocities over the contacts that the ratios allow, at every size.

    Both ratios are bands. The adhesion ratio grows with c_H >= 0, so c_H runs from zero to where
    the band's end is met; the capture velocity grows with c_H and with the dissipation ratio, so
    the corners of the set give the interval. Material parameters are the same at every size.
    """
    diameter = np.array(sorted({ratios.diameter_um, *ratios.other_diameters_um}))
    low, nominal, high = (capture_velocity(resized(c, diameter * 1e-6)) for c in corners)
    printed = ratios.capture_velocity_m_per_s
    return pd.DataFrame(
        {
            "diameter_um": diameter,
            "capture_velocity_m_per_s": nominal,
            "low_m_per_s": low,
            "high_m_per_s": high,
            "printed_m_per_s": printed,
            "printed_inside": (low <= printed) & (printed <= high),
            "evidence": "computed",
        }
    )


def _cases(params: Params, known: Known, inputs: Tables) -> Iterator[Attempt]:
    """Yield the cases; those damped as another one ask for it when they are solved."""
    targets, ratios = params.two_stage, params.force_ratios
    bare = bare_contact(targets, inputs)

    def member(each: Member) -> Solution:
        work = each.work_of_adhesion_J_per_m2
        if each.law:
            contact = law_for(bare, each.law, *targets.aims)
        else:
            fitted_at = each.damping_fitted_at_J_per_m2 or work
            contact = solved(bare, targets.aims, each.rate_exponent, fitted_at)
            contact = contact.replace(work_of_adhesion=work)
        e = _restitution(contact, targets.speed_m_per_s, targets.restitution)
        return contact, e | _capture(contact, targets.capture_velocity_m_per_s)

    for case, each in targets.members.items():
        yield f"two_stage.members.{case}", case, targets, partial(member, each)
    for case, corner in zip(CORNERS, _corners(ratios, inputs), strict=True):
        yield "force_ratios", case, ratios, partial(_at_corner, ratios, corner)

    def by_work(target: WorkTarget) -> Solution:
        contact = _damped_as(target, known, inputs).replace(diameter=target.diameter_um * 1e-6)
        contact = work_of_adhesion_for(contact, target.capture_velocity_m_per_s)
        return contact, _capture(contact, target.capture_velocity_m_per_s)

    def by_restitution(target: RestitutionTarget) -> Solution:
        aim = target.speed_m_per_s, target.restitution
        contact = damping_factor_for(_damped_as(target, known, inputs), *aim)
        return contact, _restitution(contact, *aim)

    for case, work in params.by_work_of_adhesion.items():
        yield f"by_work_of_adhesion.{case}", case, work, partial(by_work, work)
    for case, target in params.by_restitution.items():
        yield f"by_restitution.{case}", case, target, partial(by_restitution, target)


def _corners(ratios: ForceRatios, inputs: Tables) -> tuple[Callable[[], Contact], ...]:
    """Contacts with the least, the nominal and the greatest capture velocity, to be solved."""
    contact = declared_contact(
        inputs, ratios.particle, ratios.surface, diameter=ratios.diameter_um * 1e-6
    )
    elastic = contact.replace(hertz_damping=0.0)
    speed, wanted, band = ratios.speed_m_per_s, ratios.dissipation_over_adhesion, ratios.band
    most = ratios.adhesion_over_hertz * (1 + band), wanted * (1 + band)
    return (
        partial(dissipation_ratio_for, elastic, speed, wanted * (1 - band)),
        partial(dissipation_ratio_for, elastic, speed, wanted),
        partial(hertz_damping_for_adhesion_ratio, elastic, speed, *most),
    )


def _at_corner(ratios: ForceRatios, corner: Callable[[], Contact]) -> Solution:
    contact = corner()
    wanted = {
        "adhesion_over_hertz": ratios.adhesion_over_hertz,
        "dissipation_over_adhesion": ratios.dissipation_over_adhesion,
    }
    peaks = peak_ratios(contact, ratios.speed_m_per_s)
    return contact, {n: (of, wanted[n], "-") for n, of in zip(wanted, peaks, strict=True)}


def _case_rows(case: str, contact: Contact, targets: Met) -> Iterator[Row]:
    """Yield the rows of one case: targets, then parameters."""
    numbers = [("target", name, *of) for name, of in targets.items()]
    fields = {name: getattr(contact, name) for name in PARAMETERS}
    fields |= contact.law.parameters if contact.law else {}
    numbers += [
        ("parameter", name, float(value), np.nan, PARAMETERS.get(name) or UNIT_OF[f"law.{name}"])
        for name, value in fields.items()
        if value is not None
    ]
    for role, name, value, target, unit in numbers:
        bodies = {"particle": contact.particle.name, "surface": contact.surface.name}
        columns = {"role": role, "quantity": name, "value": value, "target": target, "unit": unit}
        yield {"case": case, **bodies, **columns, "evidence": "calibrated"}


def _restitution(contact: Contact, speed: float, target: float) -> Met:
    e = float(simulate(contact, speed).coefficient_of_restitution)
    return {"coefficient_of_restitution": (e, target, "-")}


def _capture(contact: Contact, target: float) -> Met:
    return {"capture_velocity": (float(capture_velocity(contact)), target, "m/s")}


def _damped_as(target: WorkTarget | RestitutionTarget, known: Known, inputs: Tables) -> Contact:
    """Return the declared contact of a pair with the damping of another case."""
    damped = _contact(known, target.damped_as)
    names = "hertz_damping", "adhesion_damping", "adhesion_rate_exponent", "reference_velocity"
    damping = {name: getattr(damped, name) for name in names}
    return declared_contact(inputs, target.particle, target.surface).replace(**damping)


def _contact(known: Known, case: str) -> Contact:
    """Return the contact of a case, or raise why there is none."""
    contact = known[case]
    if isinstance(contact, NotComputedError):
        raise contact
    return contact
