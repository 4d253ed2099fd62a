"""Rivals of adhesion that lower restitution, and the capture velocity of steel (2.3.1)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray, Real
from microimpact.core.computable import NotComputable
from microimpact.core.constants import epsilon_0, gravity
from microimpact.model.closed_forms import jkr_sticking_velocity
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from study.contacts import (
    CAPTURE_VELOCITIES,
    calibrated_contact,
    pair_of,
    printed_capture_velocity,
    printed_values_for,
)
from study.declared.parameters import (
    AngleDegrees,
    CaseName,
    Fraction,
    NonNegative,
    Positive,
    PrintedName,
)
from study.tables import Tables, series_frame

NEEDS = {"calibration": ("calibration",), "pile_up": ("pile_up", "pile_up_onsets")}

RIVAL = "probe alone"
PILES_BEGIN = "pile_up_speed_sst_silicon"
MARKS = ("speed_oblique_sst76", "restitution_sst76_silicon", PILES_BEGIN)
PRINTED_VALUES = (*CAPTURE_VELOCITIES, *MARKS, "plateau_speed_sst_silicon")
_frame = partial(series_frame, panel="restitution", x_unit="m_per_s", y_unit="1")

# Smooth curves.
POINTS = 200
# Of the plateau, where restitution has visibly fallen.
PLATEAU_SHARE = 0.9
# Molar gas constant (J/mol/K), room temperature (K); air, and water there, in SI units.
GAS, ROOM = 8.314462618, 293.15
AIR = {"molar_mass": 0.028965, "viscosity": 1.81e-5}
WATER = {"tension": 0.0727, "volume": 1.805e-5, "saturation_Pa": 2339.0}


@dataclass(frozen=True, slots=True, kw_only=True)
class Oblique:
    """An oblique impact."""

    angle_deg: AngleDegrees
    speed_m_per_s: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """The rival: spheres of one restitution without adhesion, seen above the surface."""

    # Calibrated contacts of steel on silicon: the explanation by adhesion.
    cases: Annotated[tuple[CaseName, ...], Field(min_length=1)]
    diameters_um: tuple[Positive, Positive]  # Mean spheres of two classes, the smaller first
    probe_height_mm: Positive  # Of the probe; speeds are not corrected for it
    restitution: Annotated[Fraction, Field(gt=0)]  # Of the rival, and of the plateau
    seen_from_m_per_s: Positive  # Fastest speed of the plateau
    # Of the figure: ends, and points of a curve.
    speeds_m_per_s: tuple[Positive, Positive]
    # Oblique impacts, by the printed value of their restitution: angle and total speed. These are
    # seen by a camera at the surface.
    oblique: dict[PrintedName, Oblique]
    # Target whose piles are compared, and the normal speed at which oblique rebounds are seen.
    pile_radius_mm: Positive
    pile_slope_deg: NonNegative
    slow_speed_m_per_s: Positive
    # Of the contact of JKR that gives the scale of energy.
    compared_work_of_adhesion_J_per_m2: Positive  # noqa: N815 (the unit)
    captured: tuple[CaseName, ...]  # Contacts of other particles
    pressure_Pa: Positive  # noqa: N815 (the unit)


# What is asked of piles, and where the study of piles has all that it computes.
PILES = {
    "pile_radius_mm": "radii_mm",
    "pile_slope_deg": "slopes_deg",
    "slow_speed_m_per_s": "speeds_m_per_s",
}


def disagreements(params: Params, others: Mapping[str, Any], _: object = None) -> Iterator[str]:
    """Yield a line for each number asked of piles that is not computed.

    Parameters
    ----------
    others
        Parameters of the analyses whose tables it takes, None for a faulty one.
    """
    piles = others.get("pile_up")
    for key, known in PILES.items() if piles else ():
        if (asked := getattr(params, key)) not in (computed := getattr(piles, known)):
            yield f"{key}: {asked:g} must be one of pile_up.{known} {list(computed)}"


def run(params: Params, inputs: Tables) -> Tables:
    """Hold both explanations against the printed facts, and three capture velocities.

    ``rival_restitution``: data of the figure. ``rival_explanations``: per printed observation what
    each explanation gives, and whether it tells them apart. ``capture_evidence``: what piles, slow
    rebounds and energies give for capture velocities. ``rival_forces``: what other forces would
    need, and what excludes them.

    Parameters
    ----------
    inputs
        ``calibration``, ``pile_up``, ``pile_up_onsets``: tables of these studies; ``materials``:
        declared rows; ``printed``: printed values.
    """
    contacts = {case: calibrated_contact(inputs, case) for case in params.cases}
    printed = printed_values_for(inputs)
    pairs = {pair_of(inputs, case) for case in params.cases}
    is_marked = all(set(MARKS) <= set(printed_values_for(inputs, *pair).index) for pair in pairs)
    marks = printed if is_marked else printed.iloc[:0]
    first = next(iter(contacts.values()))
    needed = forces(params, first, printed_capture_velocity(inputs, first))
    return {
        "rival_restitution": figure_data(params, contacts, marks),
        "rival_explanations": pd.DataFrame(observations(params, contacts, printed)),
        "capture_evidence": pd.DataFrame(evidence(params, contacts, inputs, printed)),
        "rival_forces": pd.DataFrame(needed),
    }


def ends_of(printed: pd.DataFrame, key: str) -> tuple[float, float]:
    """Return the ends of a printed range."""
    return float(printed["low"][key]), float(printed["high"][key])


def uncorrected(speed: Real, restitution: Real, height: float) -> tuple[FloatArray, FloatArray]:
    """Return the incident speed and the restitution of uncorrected speeds at a height.

    Incident speed, m/s, and restitution; nan where the sphere does not reach the probe.

    Parameters
    ----------
    speed
        At the surface, m/s.
    restitution
        True coefficients of restitution at these speeds.
    height
        Of the probe, m.
    """
    fall = 2.0 * gravity * height
    squares = np.square(speed) - fall, np.square(restitution * np.asarray(speed)) - fall
    before, after = (np.sqrt(np.where(square > 0.0, square, np.nan)) for square in squares)
    return before, after / before


def figure_data(
    params: Params, contacts: Mapping[str, Contact], printed: pd.DataFrame
) -> pd.DataFrame:
    """Return restitution against the incident speed by both explanations, and as printed."""
    speed = np.geomspace(*params.speeds_m_per_s, POINTS)
    frames = []
    for diameter in params.diameters_um:
        for case, contact in contacts.items():
            impact = simulate(resized(contact, diameter * 1e-6), speed)
            e = np.where(impact.captured, 0.0, impact.coefficient_of_restitution)
            frames.append(
                _frame(series=f"{case}, {diameter:g} um", evidence="calibrated", x=speed, y=e)
            )
    before, e = uncorrected(speed, params.restitution, params.probe_height_mm * 1e-3)
    seen = np.isfinite(e)
    frames.append(_frame(series=RIVAL, evidence="computed", x=before[seen], y=e[seen]))
    if len(printed):
        speed, e = printed["value"][list(MARKS[:2])]
        frames.append(_frame(series="printed, oblique impact", evidence="printed", x=speed, y=e))
        band = ends_of(printed, PILES_BEGIN)
        frames.append(_frame(series="printed pile-up", evidence="printed", x=band, y=0.0))
    return pd.concat(frames, ignore_index=True)


def observations(
    params: Params, contacts: Mapping[str, Contact], printed: pd.DataFrame
) -> Iterator[dict[str, Any]]:
    """Yield the prediction of each explanation for each printed observation.

    An observation tells them apart if what is printed, or its sign, is compatible with one alone.
    The speed below which no rebound is seen, alike by both, is none: a pile is no missing rebound.
    """
    height, speed = params.probe_height_mm * 1e-3, params.seen_from_m_per_s
    both = np.array([printed["value"]["plateau_speed_sst_silicon"], speed])
    _, seen = uncorrected(both, params.restitution, height)
    small, large = (
        [resized(contact, diameter * 1e-6) for contact in contacts.values()]
        for diameter in params.diameters_um
    )
    e = [simulate(one, both).coefficient_of_restitution for one in small]
    falls = [1.0 - float(np.divide(*of)) for of in e]
    fall = 1.0 - float(np.divide(*seen))
    name = "fall of restitution from the fastest to the end of the plateau"
    yield row(name, fall, falls, (-0.1, 0.1))
    fallen = ([fallen_speed(params, one) for one in of] for of in (large, small))
    ratios = [of / other for of, other in zip(*fallen, strict=True)]
    name = "speed at which restitution has fallen, larger over smaller class"
    yield row(name, 1.0, ratios, (0.0, 0.999))
    for key, impact in params.oblique.items():
        aim, angle, total = printed["value"][key], impact.angle_deg, impact.speed_m_per_s
        impacts = [simulate(one, total, angle) for one in contacts.values()]
        each = [float(of.coefficient_of_restitution) for of in impacts]
        name = f"restitution at {angle:g} deg and {total:g} m/s"
        yield row(name, params.restitution, each, (0.9 * aim, 1.1 * aim))


def row(
    observation: str, rival: float, adhesion: list[float], printed: tuple[float, float]
) -> dict[str, Any]:
    """Return both predictions of an observation, beside the printed range."""
    low, high = printed
    rival_agrees, adhesion_agrees = (
        any(low <= value <= high for value in values) for values in ([rival], adhesion)
    )
    return {
        "observation": observation,
        "unit": "1",
        "printed_low": low,
        "printed_high": high,
        "probe_alone": float(rival),
        "adhesion_low": min(adhesion),
        "adhesion_high": max(adhesion),
        "tells_apart": rival_agrees != adhesion_agrees,
        "evidence": "computed",
    }


def fallen_speed(params: Params, contact: Contact) -> float:
    """Return the fastest speed of the figure at which restitution is down to its share, m/s."""
    speed = np.geomspace(*params.speeds_m_per_s, 20 * POINTS)
    e = simulate(contact, speed).coefficient_of_restitution
    plateau = float(simulate(contact, params.seen_from_m_per_s).coefficient_of_restitution)
    below = speed[(e < PLATEAU_SHARE * plateau) & (speed < params.seen_from_m_per_s)]
    if below.size == 0:
        raise NotComputable("speeds_m_per_s: restitution does not fall at any of them")
    return float(below.max())


def evidence(
    params: Params, contacts: Mapping[str, Contact], inputs: Tables, printed: pd.DataFrame
) -> Iterator[dict[str, Any]]:
    """Yield piles, slow rebounds and energies for the capture velocities of the piles."""
    target = {"target_radius_mm": params.pile_radius_mm, "slope_deg": params.pile_slope_deg}
    onsets = chosen(inputs["pile_up_onsets"], **target)
    # One simulation is one line, whatever share of the spheres is called a pile.
    share = float(onsets["share"].astype(float).max())
    onsets = chosen(onsets, share=share).set_index("contact")
    name = f"speed below which {100 * share:.0f} % of the spheres stay"
    yield weighed(name, "m/s", onsets["onset_m_per_s"], ends_of(printed, PILES_BEGIN))
    rows = chosen(inputs["pile_up"], **target, speed_m_per_s=params.slow_speed_m_per_s)
    at = rows.set_index("contact")["share_captured_at_first_impact"]
    name = f"share captured at once at {params.slow_speed_m_per_s:g} m/s, where rebounds are seen"
    yield weighed(name, "1", at, (0.0, 0.025))
    others = [
        energy_ratio(params, contact, printed_capture_velocity(inputs, contact))
        for contact in (calibrated_contact(inputs, case) for case in params.captured)
    ]
    steel = resized(next(iter(contacts.values())), params.diameters_um[0] * 1e-6)
    at = onsets["capture_velocity_m_per_s"].map(partial(energy_ratio, params, steel))
    name = "kinetic energy at capture over the loss of JKR, beside that of other particles"
    yield weighed(name, "1", at, (min(others), max(others)))


def forces(params: Params, contact: Contact, v_c: float) -> Iterator[dict[str, Any]]:
    """Yield a number for each other force that could hold or slow a sphere, and its exclusion."""
    e, radius = params.restitution, 0.5e-6 * params.diameters_um[0]
    density = float(contact.particle.density)
    vacuum = "vacuum (Section 2.1)"

    def of(
        force: str, quantity: str, value: float, unit: str, excluded_by: str, source: str
    ) -> dict[str, Any]:
        named = {"force": force, "quantity": quantity, "value": value, "unit": unit}
        return named | {"excluded_by": excluded_by, "source": source, "evidence": "computed"}

    # Radius of Kelvin: twice the surface tension times the molar volume, over R T ln(p/p_0).
    saturation = np.log(params.pressure_Pa / WATER["saturation_Pa"])
    meniscus = -2.0 * WATER["tension"] * WATER["volume"] / (GAS * ROOM * saturation)
    kelvin = "radius of a meniscus of water, at most"
    yield of("capillary bridges", kelvin, meniscus * 1e9, "nm", vacuum, "Kelvin: below a molecule")
    # Epstein's drag on a diffusely reflecting sphere, over the way from the probe and back.
    speed = np.sqrt(8.0 * GAS * ROOM / (np.pi * AIR["molar_mass"]))
    gas = params.pressure_Pa * AIR["molar_mass"] / (GAS * ROOM)
    rate = (1.0 + np.pi / 8.0) * gas * speed / (density * radius)
    slowed = rate * 2e-3 * params.probe_height_mm / v_c
    name = "share of the speed lost between probe and surface"
    yield of("drag of the air", name, slowed, "1", vacuum, "Epstein 1924")
    stokes = 2.0 * density * radius * v_c / (9.0 * AIR["viscosity"])
    name = "Stokes number, if the cell were full of air"
    yield of("squeeze film", name, stokes, "1", vacuum, "Davis et al. 1986: far above 10")
    # Capture where e^2 of the energy at contact is the work against the image charge.
    charge = v_c * e * np.sqrt(density * epsilon_0 / (1.5 * (1.0 - e**2)))
    name = f"charge per surface for a capture velocity of {v_c:g} m/s, at any size"
    excluded = (
        "charge-free surfaces (Section 6); larger spheres are captured at lower speeds (2.3.1)"
    )
    yield of("image charge", name, float(charge) * 1e6, "uC/m2", excluded, "image in a conductor")
    rough = contact.replace(work_of_adhesion=0.1 * np.asarray(contact.work_of_adhesion))
    ratio = float(capture_velocity(rough) / capture_velocity(contact))
    name = "capture velocity with a tenth of the work of adhesion, over that with all"
    excluded = "not excluded: the spheres are rough, but it only lowers the capture velocity"
    yield of("roughness of the sphere", name, ratio, "1", excluded, "ring force, calibrated")


def energy_ratio(params: Params, contact: Contact, velocity: float) -> float:
    """Return ``m v_c^2/2`` over the loss of a contact of JKR with the work of adhesion compared."""
    compared = contact.replace(work_of_adhesion=params.compared_work_of_adhesion_J_per_m2)
    return float(np.square(velocity / jkr_sticking_velocity(compared)))


def chosen(table: pd.DataFrame, **where: float) -> pd.DataFrame:
    """Return the rows of a table with these numbers.

    Raises NotComputable if there is none.
    """
    for column, value in where.items():
        known = table
        table = known[np.isclose(known[column].astype(float), value)]
        if table.empty:
            raise NotComputable(f"{column}: {value:g} is not among {sorted(set(known[column]))}")
    return table


def weighed(line: str, unit: str, at: pd.Series, ends: tuple[float, float]) -> dict[str, Any]:
    """Return a line of evidence: its numbers, the range seen, and which are nearest to it."""
    low, high = ends
    away = np.maximum(np.maximum(low - at, at - high), 0.0)
    if unit == "1" and low > 0.0:
        away = np.maximum(np.maximum(np.log(low / at), np.log(at / high)), 0.0)
    return {
        "line": line,
        "unit": unit,
        "seen_low": low,
        "seen_high": high,
        **{f"at_{name}_capture_velocity": value for name, value in at.astype(float).items()},
        "prefers": " and ".join(map(str, at.index[away == away.min()])),
        "evidence": "virtual experiment" if unit == "m/s" else "computed",
    }
