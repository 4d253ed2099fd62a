"""Oblique impacts measured by others, against a rigid and a compliant contact.

Kharaz, Gorham and Salman (2001) dropped spheres of 5 mm onto glass and measured velocity and spin
after impact. Nothing is fitted here: friction and restitution are those that others use with the
data, and may rest on the part where the sphere slides. Their angle is counted from the normal; here
it is turned into the article's, from the surface.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from microimpact.core.arrays import FloatArray, Real, choice
from microimpact.core.materials import materials_from_rows
from microimpact.model.calibration import hertz_damping_for
from microimpact.model.choices import TANGENTIAL_LAWS
from microimpact.model.contact import Contact
from microimpact.model.dynamics.impact import Impact, simulate
from microimpact.model.rigid_body.algebra import INERTIA, SLIP_PER_IMPULSE
from study.contacts import calibrated_contact, pair_of, printed_values_for
from study.declared.parameters import (
    AngleDegrees,
    CaseName,
    ExternalName,
    Fraction,
    MaterialName,
    NonNegative,
    Positive,
)
from study.tables import Tables, points_series, series_frame

NEEDS = {"calibration": ("calibration",)}
PRINTED_VALUES = ("rolling_to_sliding_angle",)

QUANTITIES = {"tangential_restitution": "-", "spin": "rad/s", "rebound_angle_centre": "deg"}
# Panels of the figure, and the units of their axes.
UNITS = {"velocity": ("deg", "1"), "spin": ("deg", "rad_per_s"), "contact point": ("1", "1")}
SLIDING, STICKING = "sliding", "sticking"
# A column beside those of the laws: the spin that the measured velocity asks for.
FROM_VELOCITY = "spin of the measured velocity"

# Steps of a quarter degree.
POINTS = 360
# Range of the axis, in units of the slip that friction just stops.
LARGEST_SLIP = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Microspheres:
    """The article's spheres, and the angle at which they cease to slide throughout.

    `case`, `friction`, `restitution`, `speed_m_per_s`: the contact, and the numbers that the
    article goes with it; `transition_deg`, `transition_within_deg`: angle from the surface, and
    what "about" may mean.
    """

    case: CaseName
    friction: Positive
    restitution: Fraction
    speed_m_per_s: Positive
    transition_deg: AngleDegrees
    transition_within_deg: NonNegative


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """The measured impacts, numbers that others use with them, and the article's spheres."""

    external: ExternalName
    particle: MaterialName
    surface: MaterialName
    diameter_um: Positive
    speed_m_per_s: Positive
    friction: Positive
    friction_error: NonNegative
    restitution: Fraction
    restitution_error: NonNegative
    microspheres: Microspheres


def run(params: Params, inputs: Tables) -> Tables:
    """Compare measured oblique impacts with every law along the surface.

    ``oblique_velocity``, ``oblique_spin``, ``contact_point``: data of the figure.
    ``oblique_comparison``: every measured point beside the laws. ``oblique_residuals``: rms by
    quantity, branch and law. A point is of the branch in which a rigid sphere would be.

    Parameters
    ----------
    inputs
        ``external``: the measured points; ``materials``, and ``calibration`` for the microspheres.
    """
    rows: Any = inputs["materials"].to_dict("records")
    bodies = materials_from_rows(rows)
    bare = Contact(
        particle=bodies[params.particle],
        surface=bodies[params.surface],
        diameter=1e-6 * params.diameter_um,
        work_of_adhesion=0.0,
        friction=params.friction,
    )

    def with_numbers(friction: float, restitution: float) -> Contact:
        rough = bare.replace(friction=friction)
        return hertz_damping_for(rough, params.speed_m_per_s, restitution)

    f, e = params.friction, params.restitution
    contact = with_numbers(f, e)
    varied = (
        with_numbers(f + params.friction_error, e),
        with_numbers(f, e - params.restitution_error),
    )
    spheres = params.microspheres
    small = calibrated_contact(inputs, spheres.case, friction=spheres.friction)
    compared = comparison(inputs["external"], contact, params.speed_m_per_s, varied)
    figures = [*curves(params, contact, small), *marks(compared, params, contact)]
    pair = pair_of(inputs, spheres.case)
    if len(printed_values_for(inputs, *pair, speed_m_per_s=spheres.speed_m_per_s)):
        figures.append(printed_transition(spheres))
    panels = {
        panel: pd.concat([f for f in figures if (f["panel"] == panel).any()], ignore_index=True)
        for panel in UNITS
    }
    slips = panels["contact point"]
    return {
        "oblique_velocity": panels["velocity"],
        "oblique_spin": panels["spin"],
        "contact_point": slips[slips["x_1"] <= LARGEST_SLIP].reset_index(drop=True),
        "oblique_comparison": compared,
        "oblique_residuals": residuals(compared),
    }


def values(impact: Impact, speed: float, angle: FloatArray) -> dict[str, FloatArray]:
    """Return the measured quantities of impacts at angles from the surface in degrees."""
    along = speed * np.cos(np.radians(angle))
    return {
        "tangential_restitution": impact.tangential_velocity / along,
        "spin": impact.spin,
        "rebound_angle_centre": np.degrees(
            np.arctan2(impact.tangential_velocity, impact.normal_velocity)
        ),
    }


def comparison(
    points: pd.DataFrame, contact: Contact, speed: float, varied: tuple[Contact, ...]
) -> pd.DataFrame:
    """Return every measured point beside the prediction of each law, and its error.

    `varied`: the contact with one of its numbers an error away. Raises ValueError if a quantity is
    none that was measured, or an angle is not counted from the normal.
    """
    for column, known in (("quantity", tuple(QUANTITIES)), ("at_unit", ("deg from normal",))):
        for text in points[column].unique():
            choice(f"external evidence, {column}", text, known)
    table = points[["quantity", "reading", "unit", "value", "reading_error"]].copy()
    angle = 90.0 - points["at"].to_numpy(float)
    table.insert(2, "angle_deg", angle)
    quantity = [list(QUANTITIES).index(q) for q in table["quantity"]]
    table["branch"] = np.where(simulate(contact, speed, angle).rolling, STICKING, SLIDING)
    for law in TANGENTIAL_LAWS:
        impacts = [simulate(each, speed, angle, tangential=law) for each in (contact, *varied)]
        predicted = [np.choose(quantity, [*values(i, speed, angle).values()]) for i in impacts]
        table[law] = predicted[0]
        table[f"{law}_error"] = np.linalg.norm(np.array(predicted[1:]) - predicted[0], axis=0)
    along = table[table["quantity"] == "tangential_restitution"].sort_values("angle_deg")
    # Without a moment but that of friction, the spin follows from the loss of velocity.
    lost = 1.0 - np.interp(angle, along["angle_deg"], along["value"], np.nan, np.nan)
    spin = lost * speed * np.cos(np.radians(angle)) / (INERTIA * contact.radius)
    table[FROM_VELOCITY] = np.where(table["quantity"] == "spin", spin, np.nan)
    return table.rename(columns={"value": "measured"}).reset_index(drop=True)


def residuals(compared: pd.DataFrame) -> pd.DataFrame:
    """Return the rms of each law by quantity and branch, as it is and relative."""
    rows = []
    for law in (*TANGENTIAL_LAWS, FROM_VELOCITY):
        known = compared[compared[law].notna()]
        for (quantity, branch), part in known.groupby(["quantity", "branch"], sort=False):
            off = part[law] - part["measured"]
            error = part.get(f"{law}_error", 0.0) / part["measured"]
            rows.append(
                {
                    "quantity": quantity,
                    "branch": branch,
                    "law": law,
                    "rms": np.sqrt(np.mean(off**2)),
                    "unit": QUANTITIES[str(quantity)],
                    "relative_rms": np.sqrt(np.mean((off / part["measured"]) ** 2)),
                    "reading_error": part["reading_error"].max(),
                    "input_error": np.sqrt(np.mean(error**2)),
                    "evidence": "computed",
                }
            )
    return pd.DataFrame(rows)


def contact_point(impact: Impact, contact: Contact, speed: float, angle: FloatArray) -> FloatArray:
    """Return the restitution of the contact point along the surface: 0 rolling, 1 turned round."""
    left = impact.tangential_velocity - contact.radius * impact.spin
    return np.asarray(-left / (speed * np.cos(np.radians(angle))))


def relative_slip(friction: float, e: Real, angle: FloatArray) -> FloatArray:
    """Return slip before impact over that which friction just stops in a rigid contact."""
    return np.asarray(1.0 / (SLIP_PER_IMPULSE * friction * (1.0 + e) * np.tan(np.radians(angle))))


def turned(tangential_restitution: FloatArray) -> FloatArray:
    """Tangential restitution of the contact point from the centre's, by friction alone."""
    return SLIP_PER_IMPULSE * (1.0 - tangential_restitution) - 1.0


def _frame(panel: str, series: str, x: Real, y: Real, **more: object) -> pd.DataFrame:
    x_unit, y_unit = UNITS[panel]
    return series_frame(panel, series, x, y, x_unit=x_unit, y_unit=y_unit, **more)  # type: ignore[arg-type]


def curves(params: Params, contact: Contact, small: Contact) -> list[pd.DataFrame]:
    """Return the laws' curves against the angle, and for the contact point against slip."""
    angle = np.linspace(0.0, 90.0, POINTS + 1)[1:-1]
    frames = []
    for law in TANGENTIAL_LAWS:
        impact = simulate(contact, params.speed_m_per_s, angle, tangential=law)
        predicted = values(impact, params.speed_m_per_s, angle)
        slip = relative_slip(params.friction, impact.coefficient_of_restitution, angle)
        left = contact_point(impact, contact, params.speed_m_per_s, angle)
        frames += [
            _frame("velocity", law, angle, predicted["tangential_restitution"]),
            _frame("spin", law, angle, predicted["spin"]),
            _frame("contact point", law, slip, left),
        ]
    spheres = params.microspheres
    impact = simulate(small, spheres.speed_m_per_s, angle, tangential="mindlin")
    slip = relative_slip(spheres.friction, impact.coefficient_of_restitution, angle)
    left, free = contact_point(impact, small, spheres.speed_m_per_s, angle), ~impact.captured
    return [*frames, _frame("contact point", "microspheres", slip[free], left[free])]


def marks(compared: pd.DataFrame, params: Params, contact: Contact) -> list[pd.DataFrame]:
    """Return the measured points."""
    frames = []
    for (quantity, reading), part in compared.groupby(["quantity", "reading"], sort=False):
        series = points_series("measured", f"Kharaz et al. 2001, reading {reading}")
        angle, y = part["angle_deg"].to_numpy(float), part["measured"].to_numpy(float)
        panel = {"spin": "spin", "tangential_restitution": "velocity"}.get(str(quantity))
        if panel:
            frames.append(_frame(panel, series, angle, y, evidence="measured"))
        if panel == "velocity":
            e = simulate(contact, params.speed_m_per_s, angle).coefficient_of_restitution
            slip = relative_slip(params.friction, e, angle)
            frames.append(_frame("contact point", series, slip, turned(y), evidence="measured"))
    return frames


def printed_transition(spheres: Microspheres) -> pd.DataFrame:
    """Return the mark of the article's angle with its range.

    Where sliding ends the impulse that friction gives, f (1 + e) v_n, is the one that leaves -e_t
    times the slip, 2/7 (1 + e_t) v_t.
    """
    within = spheres.transition_within_deg * np.array([-1.0, 0.0, 1.0])
    slip = relative_slip(spheres.friction, spheres.restitution, spheres.transition_deg + within)
    low, middle, high = 1.0 / slip - 1.0
    ends: dict[str, object] = {"evidence": "printed", "y_low": low, "y_high": high}
    return _frame("contact point", "article", 1.0 / (1.0 + middle), middle, **ends)
