"""Capture velocity by competing laws, for declared and calibrated contacts and over diameter.

Codes that compute the deposition of particles in flows rely on the law of Brach and Dunn (1992) in
El-Batsh's form. It holds no energy of adhesion: its constant 0.51 is dimensional (SI). Beside it
stand JKR's quasi-static law, Dahneke's of 1971 and this model, which take the adhesion of the pair.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import Real
from microimpact.core.computable import NotComputable
from microimpact.model.closed_forms import (
    adhesion_energy,
    brach_dunn_velocity,
    dahneke_velocity,
    jkr_sticking_velocity,
    yield_velocity,
)
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from study.contacts import (
    CAPTURE_VELOCITIES,
    calibrated_contact,
    fitted_to,
    printed_capture_velocity,
)
from study.declared.parameters import CaseName, Points, Positive
from study.tables import NotComputedError, Row, Tables, result_evidence, series_frame

NEEDS = {"calibration": ("calibration",)}
PRINTED_VALUES = CAPTURE_VELOCITIES

_frame = partial(series_frame, x_unit="um", y_unit="m_per_s")

MODEL, JKR = "model", "jkr"
BRACH_DUNN, DAHNEKE = "brach_dunn_1992", "dahneke_1971"
YIELD = "thornton_ning_yield"

# Ends of the axis; the article's spheres have 1.27 to 125 um.
DIAMETERS_UM = (1.0, 125.0)
# Far above capture, in capture velocities, restitution hardly depends on adhesion.
PLATEAU = 10.0
# One per cent of the diameter to either side: errors of the exponent below 1e-5.
EXPONENT_STEP = 0.01


@dataclass(frozen=True, slots=True, kw_only=True)
class PairCase:
    """One calibrated pair; `yield_strength_MPa`: of the softer body, for the onset of yield."""

    yield_strength_MPa: Positive | None = None  # noqa: N815 (the unit)


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """The pairs, and over how many diameters they are drawn."""

    pairs: Annotated[dict[CaseName, PairCase], Field(min_length=1)]
    points: Points


# Capture velocity of a contact by a law.
CaptureLaw = Callable[[Contact], Real]


def run(params: Params, inputs: Tables) -> Tables:
    """Compare the laws.

    ``capture_laws``: per pair and law the capture velocity at the pair's diameter, its ratio to
    the printed one, and the exponent of the diameter.
    ``capture_law_curves``: capture velocity in m/s against diameter in um, one panel per pair.
    """
    rows: list[Row] = []
    frames = []
    for case, pair in params.pairs.items():
        try:
            contact = calibrated_contact(inputs, case)
        except NotComputedError as why:
            rows.append({"pair": case, "problem": str(why)})
            continue
        limit = float(capture_velocity(contact))
        if not 0.0 < limit < np.inf:
            complaint = f"a capture velocity of {limit:g} m/s has no law beside it"
            raise NotComputable(f"{case}: {complaint}")
        printed = printed_capture_velocity(inputs, contact)
        laws = laws_of(pair, contact)
        # Of these capture velocities only this model's can have been fitted.
        fitted = (MODEL,) if fitted_to(inputs, case, "capture_velocity") else ()
        evidence = {name: result_evidence(name, fitted) for name in laws}
        for name, law in laws.items():
            row = _row(contact, name, law, printed)
            rows.append({"pair": case} | row | {"evidence": evidence[name]})
        frames += _curves(params, case, contact, laws, evidence)
        if np.isfinite(printed):
            diameter = contact.diameter * 1e6
            frames.append(_frame(case, "printed", diameter, printed, "printed"))
    return {
        "capture_laws": pd.DataFrame(rows),
        "capture_law_curves": pd.concat(frames, ignore_index=True),
    }


def laws_of(pair: PairCase, contact: Contact) -> dict[str, CaptureLaw]:
    """Return the laws that apply to a pair, by name.

    Dahneke's restitution is that of this model at the pair's diameter, at `PLATEAU`.
    """
    speed = PLATEAU * float(capture_velocity(contact))
    plateau = float(simulate(contact, speed).coefficient_of_restitution)

    def dahneke(sphere: Contact) -> Real:
        return dahneke_velocity(adhesion_energy(sphere), sphere.mass, plateau)

    laws: dict[str, CaptureLaw] = {
        MODEL: capture_velocity,
        JKR: jkr_sticking_velocity,
        BRACH_DUNN: brach_dunn_velocity,
        DAHNEKE: dahneke,
    }
    if pair.yield_strength_MPa is None:
        return laws
    return laws | {YIELD: partial(yield_velocity, yield_strength=pair.yield_strength_MPa * 1e6)}


def local_exponent(velocity: Callable[[Contact], Real], contact: Contact, step: float) -> float:
    """Return d ln v_c / d ln d over a step in ln d to either side; NaN without a finite v_c."""
    ends = np.asarray(velocity(resized(contact, contact.diameter * np.exp([-step, step]))))
    if not np.all(np.isfinite(ends) & (ends > 0.0)):
        return np.nan
    return float(np.diff(np.log(ends))[0] / (2.0 * step))


def _row(contact: Contact, name: str, law: CaptureLaw, printed: float) -> Row:
    velocity = float(law(contact))
    return {
        "particle": contact.particle.name,
        "surface": contact.surface.name,
        "diameter_um": float(contact.diameter) * 1e6,
        "law": name,
        "capture_velocity_m_per_s": velocity,
        "printed_m_per_s": printed,
        "ratio_to_printed": velocity / printed,
        "exponent": local_exponent(law, contact, EXPONENT_STEP),
    }


def _curves(
    params: Params,
    case: str,
    contact: Contact,
    laws: Mapping[str, CaptureLaw],
    evidence: Mapping[str, str],
) -> list[pd.DataFrame]:
    diameter = np.geomspace(*DIAMETERS_UM, params.points)
    sized = resized(contact, diameter * 1e-6)
    frames = []
    for name, law in laws.items():
        velocity = np.broadcast_to(law(sized), diameter.shape)
        finite = np.isfinite(velocity)
        curve = diameter[finite], velocity[finite], evidence[name]
        frames.append(_frame(case, name, *curve))
    return frames
