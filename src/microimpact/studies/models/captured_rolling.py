"""How far a sphere rolls after an oblique impact has captured it, on the tilted target (Section 6).

The article sees no deposit grow under oblique impact, and says captured spheres roll away. Spheres
fall vertically, so that the target is tilted by 90 degrees less the angle of incidence.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.tables import Row, Tables, series_frame
from microimpact.declared.parameters import AngleDegrees, CaseName, Positive
from microimpact.lab.contacts import calibrated_contact
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import velocity_components
from microimpact.model.dynamics.rolling import gravity_ratio, peeling_moment, rolling_distance
from microimpact.model.rigid_body.algebra import INERTIA

NEEDS = {"calibration": ("calibration",)}

_frame = partial(series_frame, x_unit="nm", y_unit="mm")

# Tangential velocity of a captured sphere that came without spin, over the one before: 5/7.
KEPT = 1.0 / (1.0 + INERTIA)


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Captured spheres, how far adhesion lags behind rolling, and lengths of the target.

    Each sphere is the fastest that is captured at its angle, but not above ``largest_speed``.
    """

    cases: Annotated[tuple[CaseName, ...], Field(min_length=1)]
    diameters_um: Annotated[tuple[Positive, ...], Field(min_length=1)]
    angles_deg: Annotated[tuple[AngleDegrees, ...], Field(min_length=1)]
    largest_speed_m_per_s: Positive
    rolling_shifts_nm: Annotated[tuple[Positive, ...], Field(min_length=2)]
    spot_mm: Positive
    edge_mm: Positive
    drawn_diameter_um: Positive
    drawn_angles_deg: Annotated[tuple[AngleDegrees, ...], Field(min_length=1)]
    points: Annotated[int, Field(ge=5)]


def run(params: Params, inputs: Tables) -> Tables:
    """Compute the distances rolled.

    ``roll_away``: per case, diameter, angle and shift the speed of the fastest captured sphere, the
    distance it rolls without and with gravity (infinite: it does not stop), whether it leaves the
    spot it hit and the target, and the moment of its weight over that of adhesion, above 1 where
    gravity alone rolls it. ``roll_away_curves``: data of the figure, the distance in mm against the
    shift in nm.
    """
    rows = []
    for case, diameter in product(params.cases, params.diameters_um):
        contact = resized(calibrated_contact(inputs, case), diameter * 1e-6)
        limit = float(capture_velocity(contact))
        for angle, shift in product(params.angles_deg, params.rolling_shifts_nm):
            row = {"case": case, "diameter_um": diameter, "angle_deg": angle, "shift_nm": shift}
            rows.append(row | distances(params, contact, limit, angle, shift))
    return {
        "roll_away": pd.DataFrame(rows).assign(evidence="computed"),
        "roll_away_curves": curves(params, inputs),
    }


def fastest_captured(params: Params, limit: float, angle: float) -> tuple[float, float]:
    """Return the greatest speed at which a sphere is captured, as far as looked at, and it rolls.

    In m/s; `limit`: the capture velocity, m/s; `angle`: of incidence, degrees.
    """
    speed = float(min(limit / np.sin(np.radians(angle)), params.largest_speed_m_per_s))
    return speed, KEPT * float(velocity_components(speed, angle)[1])


def distances(params: Params, contact: Contact, limit: float, angle: float, shift: float) -> Row:
    """Return one row of the table of distances, for a contact of that capture velocity."""
    speed, along = fastest_captured(params, limit, angle)
    tilt, lag = 90.0 - angle, shift * 1e-9
    level = float(rolling_distance(contact, along, lag)) * 1e3
    tilted = float(rolling_distance(contact, along, lag, tilt)) * 1e3
    return {
        "capture_velocity_m_per_s": limit,
        "speed_m_per_s": speed,
        "rolling_velocity_m_per_s": along,
        "adhesive_moment_N_m": float(peeling_moment(contact, lag)),
        "gravity_over_adhesion": float(gravity_ratio(contact, lag, tilt)),
        "distance_mm": level,
        "distance_with_gravity_mm": tilted,
        "leaves_spot": tilted > params.spot_mm,
        "leaves_target": tilted > params.edge_mm,
    }


def curves(params: Params, inputs: Tables) -> pd.DataFrame:
    """Return the data of the figure; a curve begins where gravity lets the sphere stop."""
    low, high = min(params.rolling_shifts_nm), max(params.rolling_shifts_nm)
    frames = []
    for case in params.cases:
        contact = resized(calibrated_contact(inputs, case), params.drawn_diameter_um * 1e-6)
        limit = float(capture_velocity(contact))
        for angle in params.drawn_angles_deg:
            _, along = fastest_captured(params, limit, angle)
            stops = float(gravity_ratio(contact, low * 1e-9, 90.0 - angle)) * low
            # nearly vertical where the curve comes down from infinity
            start = max(low, stops)
            shift = start + np.geomspace(1e-6 * low, max(high - start, low), params.points)
            distance = rolling_distance(contact, along, shift * 1e-9, 90.0 - angle)
            frames.append(_frame(case, f"{angle:g} deg", shift, np.asarray(distance) * 1e3))
        for name, length in (("spot", params.spot_mm), ("edge", params.edge_mm)):
            frames.append(_frame(case, name, np.array([low, high]), np.full(2, length)))
    return pd.concat(frames, ignore_index=True)
