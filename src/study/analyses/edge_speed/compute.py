"""Whether the loss at a contact's edge, which goes with the edge's speed, explains the article.

The law has a work of adhesion w_0 that real surfaces have, and two numbers for the edge; the bulk
may lose energy, too. For every exponent m and capture velocity the speed c of the edge and the time
A of the bulk are solved for, so that v_c and the printed restitution at the high speed hold: what
is left to judge are the plateau and the exponent of the diameter.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.bounds import Positive
from microimpact.core.solve import roots, threshold
from microimpact.model.contact import Contact, resized
from microimpact.model.contact_laws import MaugisBarquins
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.normal import normal_impact
from study.contacts import calibrated_contact
from study.declared.parameters import Ascending, CaseName, Fraction, Points
from study.tables import Row, Tables, series_frame

NEEDS = {"calibration": ("calibration",)}

# Logarithms of c, m/s, and of A, s, between which they are sought, and their error.
LOG_C, LOG_A, ERROR = (-55.0, 13.0), (-30.0, -18.0), {"absolute": 1e-9}
# Relative step of a diameter, and speeds of a curve.
STEP, SPEEDS = 1e-2, 60
PRINTED, ALLOWED = "as printed", "roughly constant"


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Printed numbers of a contact, and the edges tried."""

    case: CaseName
    work_of_adhesion_J_per_m2: Positive  # noqa: N815 (the unit)
    edge_exponents: Annotated[tuple[Positive, ...], Field(min_length=2), Ascending]
    speed_m_per_s: Positive
    restitution: Fraction
    plateau_from_m_per_s: Positive
    plateau_within: Positive  # Fall of e that passes for none
    capture_velocity_m_per_s: Positive  # As printed
    lowest_capture_velocity_m_per_s: Positive
    points: Points


def run(params: Params, inputs: Tables) -> Tables:
    """Solve for edge and bulk, and judge plateau and size.

    ``edge_speed``: by exponent m, at the printed capture velocity and at the greatest at which the
    plateau holds. ``edge_speed_plateau``, ``edge_speed_curves``: data of the figure.

    Parameters
    ----------
    inputs
        ``calibration``; ``materials``, declared rows.
    """
    bare = calibrated_contact(inputs, params.case)
    limits = np.geomspace(
        params.lowest_capture_velocity_m_per_s, params.capture_velocity_m_per_s, params.points
    )
    ends = params.plateau_from_m_per_s, params.speed_m_per_s
    speeds = np.geomspace(params.capture_velocity_m_per_s / 2, 2 * params.speed_m_per_s, SPEEDS)
    fall_frame = partial(series_frame, "plateau", x_unit="m_per_s", y_unit="1")
    curve_frame = partial(series_frame, "restitution", x_unit="m_per_s", y_unit="1")
    rows = []
    falls = [fall_frame(ALLOWED, limits[[0, -1]], [params.plateau_within] * 2, "computed")]
    curves = [curve_frame(PRINTED, ends, [params.restitution] * 2, "printed")]
    for exponent in params.edge_exponents:
        contact = solved(params, bare, exponent, limits)
        slow, e = (normal_impact(contact, v).coefficient_of_restitution for v in ends)
        fall = e - slow
        falls.append(fall_frame(f"m = {exponent:g}", limits, fall, "computed"))
        printed = contact.at((-1,))
        last = np.interp(params.plateau_within, np.maximum.accumulate(fall), limits)
        flat = solved(params, bare, exponent, np.array([last])).at((0,))
        rows += [row(params, flat, "plateau", exponent), row(params, printed, "printed", exponent)]
        curve = normal_impact(printed, speeds).coefficient_of_restitution
        curves.append(curve_frame(f"m = {exponent:g}", speeds, curve, "computed"))
    return {
        "edge_speed": pd.DataFrame(rows),
        "edge_speed_plateau": pd.concat(falls, ignore_index=True),
        "edge_speed_curves": pd.concat(curves, ignore_index=True),
    }


def edge(params: Params, bare: Contact, exponent: float, c: FloatArray, a: FloatArray) -> Contact:
    """Contacts of an edge of speeds c, m/s, and exponent m, with times a of the bulk, s."""
    law = MaugisBarquins(edge_speed=c, edge_exponent=exponent, viscous_time=a)
    return bare.by_law(law, params.work_of_adhesion_J_per_m2)


def solved(params: Params, bare: Contact, exponent: float, limits: FloatArray) -> Contact:
    """Contacts with capture velocities (n,), m/s, and e as printed at the high speed, or above.

    Where the edge alone loses more than is printed, without loss in the bulk.
    """

    def holds(log_a: FloatArray, limit: FloatArray) -> Contact:
        def rebounds(log_c: FloatArray) -> BoolArray:
            contact = edge(params, bare, exponent, np.exp(log_c), np.exp(log_a))
            return ~normal_impact(contact, limit).captured

        low, high = (np.full_like(limit, end) for end in LOG_C)
        c = np.exp(threshold(rebounds, low, high, **ERROR))
        return edge(params, bare, exponent, c, np.exp(log_a))

    def left(log_a: FloatArray, limit: FloatArray) -> FloatArray:
        impact = normal_impact(holds(log_a, limit), params.speed_m_per_s)
        return impact.coefficient_of_restitution - params.restitution

    low, high = (np.full_like(limits, end) for end in LOG_A)
    lossy = left(low, limits) > 0.0
    log_a = low.copy()
    log_a[lossy] = roots(left, low[lossy], high[lossy], limits[lossy], **ERROR)
    return holds(log_a, limits)


def row(params: Params, contact: Contact, kind: str, exponent: float) -> Row:
    """Describe one contact: the edge, its plateau and its exponent of the diameter."""
    law = contact.law
    assert isinstance(law, MaugisBarquins)
    limit = float(capture_velocity(contact))
    larger = float(capture_velocity(resized(contact, contact.diameter * (1.0 + STEP))))
    slow = normal_impact(contact, params.plateau_from_m_per_s)
    impact = normal_impact(contact, params.speed_m_per_s)
    e = float(impact.coefficient_of_restitution)
    assert impact.losses is not None
    power = float(np.log(larger / limit) / np.log1p(STEP))
    return {
        "capture_velocity": kind,
        "edge_exponent": exponent,
        "v_c_m_per_s": limit,
        "edge_speed_m_per_s": float(law.edge_speed),
        "viscous_time_ns": float(law.viscous_time) * 1e9,
        "size_exponent": power,
        "similar_size_exponent": -1.0 / (1.2 - 0.6 * exponent),
        "restitution": e,
        "fall_of_restitution": e - float(slow.coefficient_of_restitution),
        "adhesion_share": float(impact.losses.adhesion_share),
        "evidence": "computed",
    }
