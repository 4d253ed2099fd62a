"""Moments of rolling that the models neglect, against the moment of friction (Section 3.2.3).

The article neglects them because the contact radius is small. Compared are what no distribution of
forces in the contact can exceed, and what can arise in an impact, during which the sphere rolls
through a small part of its own contact radius: from hysteresis, and from the model's damping.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.core.computable import NotComputable
from microimpact.model.contact import Contact, require_contact, resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.rolling import RollingImpulses, rolling_impulses
from study.contacts import calibrated_contact
from study.declared.parameters import (
    Ascending,
    CaseName,
    Fraction,
    ObliqueDegrees,
    Points,
    Positive,
)
from study.tables import NotComputedError, Row, Tables, reason, series_frame

NEEDS = {"calibration": ("calibration",)}

_frame = partial(series_frame, x_unit="deg", y_unit="1")

# Grades of the neglected moment, and the impulse of each.
GRADES = {"bound": "bound", "impact": "hysteresis", "damping": "damping"}

# Curves begin so much above the normal speed of capture.
ABOVE_CAPTURE = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Calibrated cases, and the impacts over which moments are compared.

    A moment is negligible if its impulse is below ``negligible`` of that of friction.
    """

    cases: Annotated[tuple[CaseName, ...], Field(min_length=1)]
    diameters_um: Annotated[tuple[Positive, ...], Field(min_length=1)]
    speeds_m_per_s: Annotated[tuple[Positive, ...], Field(min_length=1)]
    # No friction is left at 90 degrees.
    angles_deg: Annotated[tuple[ObliqueDegrees, ...], Field(min_length=2), Ascending]
    negligible: Annotated[Fraction, Field(gt=0)]
    drawn_diameter_um: Positive
    drawn_speeds_m_per_s: Annotated[tuple[Positive, ...], Field(min_length=1)]
    points: Points


def run(params: Params, inputs: Tables) -> Tables:
    """Compare the neglected moments with the moment of friction.

    ``rolling_dissipation``: per case, diameter, speed and angle the impulse of each moment over
    that of friction; empty where the sphere is captured. A case of another law than the ring force
    has one row that says so.
    ``rolling``: data of the figure.
    """
    contacts, rows = dict[str, Contact](), list[Row]()
    for case in params.cases:
        try:
            require_contact(contact := calibrated_contact(inputs, case))
            contacts[case] = contact
        except NotComputable as error:
            problem = reason(f"rolling_dissipation.cases.{case}", error)
            rows.append({"case": case, "problem": problem})
    if not contacts:
        raise NotComputedError(rows[0]["problem"])
    for case, diameter, speed in product(contacts, params.diameters_um, params.speeds_m_per_s):
        contact = resized(contacts[case], diameter * 1e-6)
        start = {"case": case, "diameter_um": diameter, "speed_m_per_s": speed}
        rebounds = _rebounding(contact, speed, np.array(params.angles_deg))
        for angle in params.angles_deg:
            moments = rolling_impulses(contact, speed, angle) if angle in rebounds else None
            rows.append({**start, "angle_deg": angle, **_row(contact, speed, moments)})
    return {
        "rolling_dissipation": pd.DataFrame(rows).assign(evidence="computed"),
        "rolling": curves(params, contacts),
    }


def _ratios(moments: RollingImpulses) -> dict[str, float]:
    """Return the impulse of every grade over the impulse of friction."""
    return {grade: getattr(moments, name) / moments.friction for grade, name in GRADES.items()}


def _rebounding(contact: Contact, speed: float, angles: FloatArray) -> FloatArray:
    """Return the angles at which a sphere rebounds."""
    least = capture_velocity(contact) * (1.0 + ABOVE_CAPTURE)
    return angles[speed * np.sin(np.radians(angles)) > least]


def _row(contact: Contact, speed: float, moments: RollingImpulses | None) -> Row:
    if moments is None:
        return {"captured": True}
    scale = float(contact.radius) * float(contact.mass) * speed
    return {
        "captured": False,
        "friction_over_r_m_v": moments.friction / scale,
        "contact_radius_over_r": moments.contact_radius / float(contact.radius),
        "rolled_nm": moments.rolled * 1e9,
        "rolled_over_contact_radius": moments.rolled / moments.contact_radius,
        **{f"{grade}_over_friction": ratio for grade, ratio in _ratios(moments).items()},
    }


def curves(params: Params, contacts: Mapping[str, Contact]) -> pd.DataFrame:
    """Return the data of the figure: each grade against the angle, per case and speed."""
    frames = []
    angles = np.linspace(params.angles_deg[0], params.angles_deg[-1], params.points)
    for case, speed in product(contacts, params.drawn_speeds_m_per_s):
        contact = resized(contacts[case], params.drawn_diameter_um * 1e-6)
        rebounding = _rebounding(contact, speed, angles)
        impacts = [rolling_impulses(contact, speed, angle) for angle in rebounding.tolist()]
        ratios = pd.DataFrame([_ratios(moments) for moments in impacts], columns=list(GRADES))
        for grade, y in ratios.items():
            frames.append(_frame(str(grade), f"{case}, {speed:g} m/s", rebounding, y))
    ends = np.array(params.angles_deg)[[0, -1]]
    frames += [_frame(grade, "negligible", ends, np.full(2, params.negligible)) for grade in GRADES]
    return pd.concat(frames, ignore_index=True)
