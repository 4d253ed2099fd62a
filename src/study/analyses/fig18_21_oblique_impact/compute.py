"""Impulse ratio and energy loss against angle, steel on silicon (Figs. 18 and 21)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
import pandas as pd

from microimpact.core.arrays import FloatArray
from microimpact.core.computable import NotComputable
from microimpact.model.choices import FRICTION_BASES, INTERVAL
from microimpact.model.contact import Contact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate, velocity_components
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.rigid_body.algebra import rigid_body_rebound
from study.contacts import (
    DIGITS,
    Posterior,
    calibrated_contact,
    pair_of,
    posterior_contacts_at,
    printed_values_for,
)
from study.declared.parameters import CaseName, Finite, Fraction, Points, Positive
from study.tables import Tables, series_frame

NEEDS = {
    "calibration": ("calibration",),
    "inference": ("posterior_contacts",),
    "fig06_12_oblique_experiments": ("oblique_experiments",),
}
# Ends and height of the friction plateau.
PRINTED_VALUES = ("plateau_end_angle", "rolling_to_sliding_angle", "impulse_ratio_plateau")
# The share that must rebound where a band is drawn, and the step in which it takes the angles.
REBOUNDING, STEP = 0.5, 4

FRICTION_BASES_OF_LAWS = tuple(each for each in FRICTION_BASES if each != "hertz")

# What experiments measure, by panel.
QUANTITIES = {"adhesion": "impulse_ratio", "loss": "energy_loss"}

_frame = partial(series_frame, x_unit="deg", y_unit="1")


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """One pair at one speed, over angles of incidence from the surface up to the normal."""

    case: CaseName
    diameter_um: Positive
    friction: Fraction
    speed_m_per_s: Positive
    spin_rad_per_s: Finite
    points: Points
    posterior: Posterior


def run(params: Params, inputs: Tables) -> Tables:
    """Return the data of Figs. 18 and 21.

    ``fig18``: impulse ratio against the angle in degrees; panel ``adhesion`` compares the rigid
    body with the simulation, panel ``basis`` the normal forces that Coulomb's law may take.
    ``fig21``: energy loss, total and translational. Captured impacts are left out. The series
    ``posterior`` is the band of the posterior contacts, if they are of the
    pair; ``virtual experiment`` has the means of experiments on this very impact, if any.
    """
    changes = {"diameter": params.diameter_um * 1e-6, "friction": params.friction}
    contact = calibrated_contact(inputs, params.case, **changes)
    if capture_angle(params, contact) >= 90.0:
        raise NotComputable(
            f"oblique_impact: at {params.speed_m_per_s:g} m/s the sphere is captured at every angle"
            f" (capture velocity {float(capture_velocity(contact)):.4g} m/s)"
        )
    angle = np.linspace(0.0, 90.0, params.points + 1)[1:]
    figures = {
        "fig18": impulse_ratios(params, contact, angle, inputs),
        "fig21": energy_losses(params, contact, angle),
    }
    beside = pd.concat(
        [
            experiments(params, inputs["oblique_experiments"]),
            posterior_bands(params, inputs, angle[STEP - 1 :: STEP]),
        ]
    )
    return {
        name: pd.concat([table, beside[beside["panel"].isin(table["panel"])]], ignore_index=True)
        for name, table in figures.items()
    }


def impulse_ratios(
    params: Params, contact: Contact, angle: FloatArray, inputs: Tables
) -> pd.DataFrame:
    """Return the data of Fig. 18; the rigid body has the restitution of a normal impact."""
    v_n, v_t = velocity_components(params.speed_m_per_s, angle)
    e = normal_impact(contact, params.speed_m_per_s).coefficient_of_restitution
    rigid = rigid_body_rebound(v_n, v_t, params.spin_rad_per_s, contact.radius, e, contact.friction)
    frames = [_frame("adhesion", "rigid body", angle, 0.0 - rigid.mu)]
    # Other laws do not tell Hertz's force from adhesion.
    for basis in FRICTION_BASES if contact.law is None else FRICTION_BASES_OF_LAWS:
        outcome = simulate(contact, params.speed_m_per_s, angle, params.spin_rad_per_s, basis)
        rebound = ~outcome.captured
        ratio = outcome.impulse_ratio[rebound]
        frames.append(_frame("basis", basis, angle[rebound], ratio))
        if basis == "compressive":
            frames.append(_frame("adhesion", "simulation", angle[rebound], ratio))
    size, speed = params.diameter_um, params.speed_m_per_s
    pair = pair_of(inputs, params.case)
    printed = printed_values_for(inputs, *pair, diameter_um=size, speed_m_per_s=speed)["value"]
    if set(PRINTED_VALUES) <= set(printed.index):
        *ends, plateau = printed[list(PRINTED_VALUES)]
        frames.append(_frame("adhesion", "printed plateau", ends, plateau, "printed"))
    frames.append(_capture_line("adhesion", params, contact))
    frames.append(_capture_line("basis", params, contact))
    return pd.concat(frames, ignore_index=True)


def energy_losses(params: Params, contact: Contact, angle: FloatArray) -> pd.DataFrame:
    """Return the data of Fig. 21."""
    outcome = simulate(contact, params.speed_m_per_s, angle, params.spin_rad_per_s)
    rebound = ~outcome.captured
    frames = [
        _frame("loss", series, angle[rebound], loss[rebound])
        for series, loss in (
            ("total", outcome.energy_loss),
            ("translational", outcome.translational_energy_loss),
        )
    ]
    frames.append(_capture_line("loss", params, contact))
    return pd.concat(frames, ignore_index=True)


def experiments(params: Params, table: pd.DataFrame) -> pd.DataFrame:
    """Return the means of the experiments with this contact, size, speed and friction.

    They are on smooth surfaces and without spin. Empty if there are none.
    """
    smooth = (table[["slope_sd", "spin_mean", "spin_sd"]] == 0.0).all(axis=1)
    same = smooth & (table["case"] == params.case) & (params.spin_rad_per_s == 0.0)
    for name in ("diameter_um", "speed_m_per_s", "friction"):
        same &= np.isclose(table[name], getattr(params, name), rtol=DIGITS)
    # One experiment stands in every series that it belongs to.
    once = table[same].drop_duplicates("angle_deg")
    frames = []
    for panel, quantity in QUANTITIES.items():
        rows = once.dropna(subset=quantity)
        ends = rows[f"{quantity}_low"], rows[f"{quantity}_high"]
        at = rows["angle_deg"], rows[quantity]
        frames.append(_frame(panel, "virtual experiment", *at, "virtual experiment", *ends))
    return pd.concat(frames, ignore_index=True)


def posterior_bands(params: Params, inputs: Tables, angle: FloatArray) -> pd.DataFrame:
    """Return the bands of impulse ratio and translational loss over the contacts drawn.

    Each contact has the force in Coulomb's law that it was drawn with. Only those that rebound
    count, at angles where at least half do. Empty if the contacts are of another pair.
    """
    diameter = params.diameter_um * 1e-6
    contacts = posterior_contacts_at(inputs, params.posterior, params.case, diameter)
    if not contacts:
        return pd.DataFrame({"panel": []})
    at = params.speed_m_per_s, angle[:, None], params.spin_rad_per_s
    outcomes = [simulate(contact, *at, basis) for basis, contact in contacts.items()]
    captured = np.hstack([outcome.captured for outcome in outcomes])
    rebound = np.mean(~captured, axis=1) >= REBOUNDING
    frames = []
    for panel, quantity in (("adhesion", "impulse_ratio"), ("loss", "translational_energy_loss")):
        values = np.hstack([getattr(outcome, quantity) for outcome in outcomes])
        values = np.where(captured, np.nan, values)[rebound]
        low, middle, high = np.nanquantile(values, INTERVAL, axis=1)
        frames.append(_frame(panel, "posterior", angle[rebound], middle, "calibrated", low, high))
    return pd.concat(frames, ignore_index=True)


def capture_angle(params: Params, contact: Contact) -> float:
    """Return the angle in degrees at and below which the sphere is captured; 90 if always."""
    ratio = float(capture_velocity(contact)) / params.speed_m_per_s
    return float(np.degrees(np.arcsin(min(ratio, 1.0))))


def _capture_line(panel: str, params: Params, contact: Contact) -> pd.DataFrame:
    return _frame(panel, "capture", capture_angle(params, contact), [0.0])
