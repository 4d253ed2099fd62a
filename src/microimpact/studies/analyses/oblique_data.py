"""Oblique impacts measured by others, against a rigid and a compliant contact.

Kharaz, Gorham and Salman (2001) dropped spheres of 5 mm onto glass and measured velocity and spin
after impact. Nothing is fitted here: friction and restitution are those that others use with the
data, and may rest on the part where the sphere slides. Their angle is counted from the normal; here
it is turned into the article's, from the surface.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray, Real, choice
from microimpact.core.materials import materials_from_rows
from microimpact.core.tables import Row, Tables, points_series, series_frame
from microimpact.declared.parameters import (
    AngleDegrees,
    CaseName,
    ExternalName,
    Fraction,
    MaterialName,
    NonNegative,
    Positive,
)
from microimpact.lab.contacts import PrintedPair, calibrated_contact
from microimpact.model.calibration import hertz_damping_for
from microimpact.model.choices import TANGENTIAL_LAWS
from microimpact.model.contact import Contact
from microimpact.model.dynamics.impact import Impact, simulate
from microimpact.model.rigid_body.algebra import INERTIA, SLIP_PER_IMPULSE

NEEDS = {"calibration": ("calibration",)}

QUANTITIES = {"tangential_restitution": "-", "spin": "rad/s", "rebound_angle_centre": "deg"}
SLIDING, STICKING = "sliding", "sticking"
# A column beside those of the laws: the spin that the measured velocity asks for.
FROM_VELOCITY = "spin of the measured velocity"


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
    printed_for: PrintedPair  # Another pair has neither mark nor row of the article


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """The measured impacts, numbers that others use with them, and the article's spheres."""

    external: ExternalName
    particle: MaterialName
    surface: MaterialName
    diameter_um: Positive
    speed_m_per_s: Positive
    friction: Positive
    restitution: Fraction
    points: Annotated[int, Field(ge=10)]
    largest_slip: Positive
    microspheres: Microspheres


def run(params: Params, inputs: Tables) -> Tables:
    """Compare measured oblique impacts with every law along the surface.

    ``oblique_velocity``, ``oblique_spin``, ``contact_point``: data of the figure.
    ``oblique_comparison``: every measured point beside the laws. ``oblique_residuals``: rms by
    quantity, branch, reading and law. A point is of the branch in which a rigid sphere would be.
    ``tangential_bounds``: restitution of the contact point along the surface where sliding
    throughout begins, by the article's angle, the data and the laws. `inputs`: ``external``: the
    measured points; ``materials``, and ``calibration`` for the microspheres.
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
    contact = hertz_damping_for(bare, params.speed_m_per_s, params.restitution)
    own = params.microspheres
    small = calibrated_contact(inputs, own.case, friction=own.friction)
    points = inputs["external"]
    compared = comparison(points, contact, params.speed_m_per_s)
    figures = [*curves(params, contact, small), *marks(compared, params, contact)]
    is_printed = own.printed_for.is_of(inputs, own.case)
    if is_printed:
        figures.append(printed_mark(own))
    shown = [f for f in figures if f["panel"].iloc[0] != "contact point"]
    slips = [f[f["x_1"] <= params.largest_slip] for f in figures if "x_1" in f]
    figures = [f for f in (*shown, *slips) if len(f)]
    return {
        name: pd.concat([f for f in figures if set(f["panel"]) == {panel}], ignore_index=True)
        for name, panel in (
            ("oblique_velocity", "velocity"),
            ("oblique_spin", "spin"),
            ("contact_point", "contact point"),
        )
    } | {
        "oblique_comparison": compared,
        "oblique_residuals": residuals(compared),
        "tangential_bounds": pd.concat(
            [
                *([printed_bound(own)] if is_printed else []),
                bounds(params, compared, contact, small),
            ],
            ignore_index=True,
        ),
    }


def values(impact: Impact, speed: float, angle: FloatArray) -> dict[str, FloatArray]:
    """Return what was measured, by quantity, of impacts at angles from the surface in degrees."""
    along = speed * np.cos(np.radians(angle))
    return {
        "tangential_restitution": impact.tangential_velocity / along,
        "spin": impact.spin,
        "rebound_angle_centre": np.degrees(
            np.arctan2(impact.tangential_velocity, impact.normal_velocity)
        ),
    }


def comparison(points: pd.DataFrame, contact: Contact, speed: float) -> pd.DataFrame:
    """Return every measured point beside what each law gives there.

    Raises ValueError if a quantity is none that was measured, or an angle is not counted from the
    normal.
    """
    for column, known in (("quantity", tuple(QUANTITIES)), ("at_unit", ("deg from normal",))):
        for text in points[column].unique():
            choice(f"external evidence, {column}", text, known)
    table = points[["quantity", "reading", "unit", "value", "reading_error"]].copy()
    angle = 90.0 - points["at"].to_numpy(float)
    table.insert(2, "angle_deg", angle)
    impacts = {law: simulate(contact, speed, angle, tangential=law) for law in TANGENTIAL_LAWS}
    table["branch"] = np.where(impacts["rigid"].rolling, STICKING, SLIDING)
    for law, impact in impacts.items():
        found = values(impact, speed, angle)
        table[law] = np.choose(
            [list(QUANTITIES).index(q) for q in table["quantity"]], [found[q] for q in QUANTITIES]
        )
    along = table[table["quantity"] == "tangential_restitution"].sort_values("angle_deg")
    # Without a moment but that of friction, the spin follows from the loss of velocity.
    lost = 1.0 - np.interp(angle, along["angle_deg"], along["value"], np.nan, np.nan)
    spin = lost * speed * np.cos(np.radians(angle)) / (INERTIA * contact.radius)
    table[FROM_VELOCITY] = np.where(table["quantity"] == "spin", spin, np.nan)
    return table.rename(columns={"value": "measured"}).reset_index(drop=True)


def residuals(compared: pd.DataFrame) -> pd.DataFrame:
    """Return the rms of each law by quantity, branch and reading, as it is and relative."""
    rows = []
    for law in (*TANGENTIAL_LAWS, FROM_VELOCITY):
        for reading in ("all", *sorted(set(compared["reading"]))):
            some = compared if reading == "all" else compared[compared["reading"] == reading]
            for (quantity, branch), part in some.groupby(["quantity", "branch"], sort=False):
                known = part[part[law].notna()]
                if known.empty:
                    continue
                off = known[law] - known["measured"]
                rows.append(
                    {
                        "quantity": quantity,
                        "branch": branch,
                        "reading": reading,
                        "law": law,
                        "points": len(known),
                        "rms": np.sqrt(np.mean(off**2)),
                        "unit": QUANTITIES[str(quantity)],
                        "relative_rms": np.sqrt(np.mean((off / known["measured"]) ** 2)),
                        "mean_relative": np.mean(off / known["measured"]),
                        "reading_error": known["reading_error"].max(),
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


def _frame(panel: str, series: str, x: Real, y: Real, **more: object) -> pd.DataFrame:
    units = {"velocity": ("deg", "1"), "spin": ("deg", "rad_per_s"), "contact point": ("1", "1")}
    x_unit, y_unit = units[panel]
    return series_frame(panel, series, x, y, x_unit=x_unit, y_unit=y_unit, **more)  # type: ignore[arg-type]


def curves(params: Params, contact: Contact, small: Contact) -> list[pd.DataFrame]:
    """Return what the laws give against the angle, and for the contact point against slip."""
    angle = np.linspace(0.0, 90.0, params.points + 1)[1:-1]
    frames = []
    for law in TANGENTIAL_LAWS:
        impact = simulate(contact, params.speed_m_per_s, angle, tangential=law)
        found = values(impact, params.speed_m_per_s, angle)
        e = impact.coefficient_of_restitution
        frames += [
            _frame("velocity", law, angle, found["tangential_restitution"]),
            _frame("spin", law, angle, found["spin"]),
            _frame(
                "contact point",
                law,
                relative_slip(params.friction, e, angle),
                contact_point(impact, contact, params.speed_m_per_s, angle),
            ),
        ]
    own = params.microspheres
    impact = simulate(small, own.speed_m_per_s, angle, tangential="mindlin")
    e = impact.coefficient_of_restitution
    place = relative_slip(own.friction, e, angle)
    left = contact_point(impact, small, own.speed_m_per_s, angle)
    free = ~impact.captured
    return [*frames, _frame("contact point", "microspheres", place[free], left[free])]


def marks(compared: pd.DataFrame, params: Params, contact: Contact) -> list[pd.DataFrame]:
    """Return the measured points."""
    frames = []
    for (quantity, reading), part in compared.groupby(["quantity", "reading"], sort=False):
        series = points_series("measured", f"Kharaz et al. 2001, reading {reading}")
        angle, y = part["angle_deg"].to_numpy(float), part["measured"].to_numpy(float)
        if quantity == "spin":
            frames.append(_frame("spin", series, angle, y, evidence="measured"))
        elif quantity == "tangential_restitution":
            frames.append(_frame("velocity", series, angle, y, evidence="measured"))
            e = simulate(contact, params.speed_m_per_s, angle).coefficient_of_restitution
            place = relative_slip(params.friction, e, angle)
            turned = SLIP_PER_IMPULSE * (1.0 - y) - 1.0
            frames.append(_frame("contact point", series, place, turned, evidence="measured"))
    return frames


def printed_mark(own: Microspheres) -> pd.DataFrame:
    """Return the article's angle as a mark with its range."""
    low, middle, high = transition(own)
    mark = {"evidence": "printed", "y_low": low, "y_high": high}
    return _frame("contact point", "article", 1.0 / (1.0 + middle), middle, **mark)


def transition(own: Microspheres) -> FloatArray:
    """Return the contact point's restitution where sliding ends: at most, printed, at least angle.

    There the impulse that friction gives, f (1 + e) v_n, is the one that leaves -e_t times the
    slip, 2/7 (1 + e_t) v_t.
    """
    within = own.transition_within_deg * np.array([-1.0, 0.0, 1.0])
    slip = relative_slip(own.friction, own.restitution, own.transition_deg + within)
    return np.asarray(1.0 / slip - 1.0)


def printed_bound(own: Microspheres) -> pd.DataFrame:
    """Return the row of `bounds` that the article's angle gives."""
    low, middle, high = transition(own)
    row = {
        "spheres": f"article, sliding from {own.transition_deg:g} deg",
        "quantity": "at the transition",
        "angle_deg": own.transition_deg,
        "value": middle,
        "low": low,
        "high": high,
        "evidence": "printed",
    }
    return pd.DataFrame([row])


def bounds(
    params: Params, compared: pd.DataFrame, contact: Contact, small: Contact
) -> pd.DataFrame:
    """Return the contact point's restitution where sliding throughout begins, and its greatest."""
    own = params.microspheres
    rows: list[Row] = []
    angle = np.linspace(0.0, 90.0, 20 * params.points + 1)[1:-1]
    for name, which, speed in (
        (own.case, small, own.speed_m_per_s),
        (f"{params.particle} on {params.surface}", contact, params.speed_m_per_s),
    ):
        for law in TANGENTIAL_LAWS:
            impact = simulate(which, speed, angle, tangential=law)
            turned = contact_point(impact, which, speed, angle)
            # None slides where friction is high or all are captured: then nothing is said of it.
            places = [("at the transition", i) for i in np.flatnonzero(~impact.rolling)[-1:]]
            for quantity, i in [*places, ("greatest", int(np.argmax(turned)))]:
                place = {"spheres": f"{name}, {law}", "quantity": quantity}
                found = {"angle_deg": angle[i], "value": turned[i], "evidence": "computed"}
                rows.append(place | found)
    seen = compared[compared["quantity"] == "tangential_restitution"]
    turned = SLIP_PER_IMPULSE * (1.0 - seen["measured"].to_numpy(float)) - 1.0
    top = int(np.argmax(turned))
    rows.append(
        {
            "spheres": params.external,
            "quantity": "greatest",
            "angle_deg": float(seen["angle_deg"].iloc[top]),
            "value": turned[top],
            "evidence": "measured",
        }
    )
    columns = ["spheres", "quantity", "angle_deg", "value", "low", "high", "evidence"]
    return pd.DataFrame(rows, columns=columns)
