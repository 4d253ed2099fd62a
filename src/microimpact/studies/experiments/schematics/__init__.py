"""Geometry and example states of the schematic figures (Figs. 1, 2, 3, 13, 19 and 22)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.declared.parameters import AngleDegrees, Finite, Fraction, NonNegative, Positive
from microimpact.model.dynamics.impact import velocity_components
from microimpact.model.rigid_body.algebra import rigid_body_rebound
from microimpact.studies.experiments.schematics import layout
from microimpact.studies.experiments.schematics.states import (
    ContactState,
    WavySurface,
    contact_state,
    parts_frame,
    wavy_surface,
)

# Tracks of Fig. 1 on the drawing: length and distance in mm of the dashes of a sphere that
# moves as fast as the incident one, and the numbers of dashes before and after the impact.
DASH_MM, PITCH_MM, INCIDENT, REBOUND = 3.0, 5.0, 3, 6

# A vector's components along t and n by name; none is zero.
Components = tuple[str | None, str | None]

FIG03: Mapping[str, Components] = {
    "incident velocity": ("v_t", "v_n"),
    "incident tangential": ("v_t", None),
    "incident normal": (None, "v_n"),
    "incident spin": ("r omega", None),
    "rebound velocity": ("V_t", "V_n"),
    "rebound tangential": ("V_t", None),
    "rebound normal": (None, "V_n"),
    "rebound spin": ("r Omega", None),
}

FIG13: Mapping[str, Mapping[str, Components]] = {
    "before": {"tangential": ("v_t", None), "normal": (None, "v_n"), "spin": ("r omega", None)},
    "impulse": {"tangential": ("P_t", None), "normal": (None, "P_n")},
    "after": {"tangential": ("V_t", None), "normal": (None, "V_n"), "spin": ("r Omega", None)},
}


NEEDS = {"calibration": ("calibration",)}


@dataclass(frozen=True, slots=True, kw_only=True)
class SetUps:
    """What Section 2.1 states of the two set-ups, and the angle of the target drawn in Fig. 1."""

    log10_pressure_torr: Finite
    least_drop_height_m: Positive
    greatest_drop_height_m: Positive
    disk_slots: Annotated[int, Field(ge=1, le=24)]
    camera_angle_deg: AngleDegrees
    probe_height_mm: Positive
    receiver_angle_deg: AngleDegrees
    detectors: Annotated[int, Field(ge=1, le=3)]
    shortest_wavelength_nm: Positive
    longest_wavelength_nm: Positive
    target_angle_deg: AngleDegrees


@dataclass(frozen=True, slots=True, kw_only=True)
class Rebound:
    """Rigid body impact of Figs. 1, 3 and 13; the spin ratio is r omega / v before it."""

    speed_m_per_s: Positive
    angle_deg: AngleDegrees
    restitution: Fraction
    friction: NonNegative
    spin_ratio: Finite


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Everything that the schematics show, by theme."""

    set_ups: SetUps
    rebound: Rebound
    contact: ContactState
    wavy_surface: WavySurface


def run(params: Params, inputs: Mapping[str, pd.DataFrame]) -> Mapping[str, pd.DataFrame]:
    """Return the geometry of every schematic.

    Parameters
    ----------
    params
        Parameters of the study.
    inputs
        ``materials``, ``contacts``: the declared rows of the contact's pair.

    Returns
    -------
    mapping
        ``fig01``, ``fig02``: parts of the set-ups, mm on the drawing. ``fig03``, ``fig13``:
        velocities, and impulses over the mass, m/s; a spin is the speed of the rim. ``fig19``:
        section of the sphere, um; ``fig19_pressure``: Hertz pressure, GPa, over the radius;
        ``fig19_ring``: force per length of the edge, N/m. ``fig22``: surface and axes, um.
        ``schematic_values``: the numbers behind Figs. 3, 13, 19 and 22.

    Raises
    ------
    ValueError
        If the sphere of Fig. 22 cannot touch the surface at its place.
    """
    motion = velocities(params.rebound, params.rebound.angle_deg, params.rebound.spin_ratio)
    contact, contact_tables = contact_state(params.contact, inputs)
    geometry, surface = wavy_surface(params.wavy_surface)
    units = {(name, "-" if name == "mu" else "m/s"): value for name, value in motion.items()}
    groups = {"fig03 fig13": units, "fig19": contact, "fig22": geometry}
    rows = [
        (figures, quantity, value, unit)
        for figures, numbers in groups.items()
        for (quantity, unit), value in numbers.items()
    ]
    return {
        "fig01": imaging_system(params.set_ups, params.rebound),
        "fig02": doppler_analyser(params.set_ups),
        "fig03": _vectors("impact", motion, FIG03),
        "fig13": pd.concat(
            [_vectors(panel, motion, names) for panel, names in FIG13.items()], ignore_index=True
        ),
        **contact_tables,
        "fig22": surface,
        "schematic_values": pd.DataFrame(rows, columns=["figures", "quantity", "value", "unit"]),
    }


def imaging_system(set_ups: SetUps, rebound: Rebound) -> pd.DataFrame:
    """Return the parts of Fig. 1; the dashes of both tracks are as far apart as the speeds say."""
    angle = set_ups.target_angle_deg
    motion = velocities(rebound, angle, 0.0)
    # The sphere falls straight down, at the angle alpha to the target's tangent.
    alpha = np.radians(angle)
    tangent = np.array([np.sin(alpha), -np.cos(alpha)])
    normal = np.array([np.cos(alpha), np.sin(alpha)])
    velocity = motion["V_t"] * tangent + motion["V_n"] * normal
    begins = PITCH_MM * (np.arange(max(INCIDENT, REBOUND)) + 0.5)
    dashes = np.stack([begins, begins + DASH_MM], axis=1).reshape(-1, 1)
    tracks = layout.tracks(
        dashes[: 2 * INCIDENT] * np.array([0.0, 1.0]),
        dashes[: 2 * REBOUND] * velocity / rebound.speed_m_per_s,
    )
    side = layout.imaging_side(set_ups.disk_slots, angle)
    return pd.concat(
        [
            parts_frame("side", side, "printed"),
            parts_frame("side", tracks, "computed"),
            parts_frame("top", layout.imaging_top(set_ups.camera_angle_deg), "printed"),
        ],
        ignore_index=True,
    )


def doppler_analyser(set_ups: SetUps) -> pd.DataFrame:
    """Return the parts of Fig. 2; usual ones that the article leaves out are assumed."""
    named, usual = layout.analyser_top(set_ups.receiver_angle_deg, set_ups.detectors)
    return pd.concat(
        [
            parts_frame("top", named, "printed"),
            parts_frame("top", usual, "assumed"),
            parts_frame("side", layout.analyser_side(), "printed"),
        ],
        ignore_index=True,
    )


def velocities(rebound: Rebound, angle: float, spin_ratio: float) -> dict[str, float]:
    """Return velocities before (lower case) and after a rigid body impact, and its impulses.

    Spins are given as the speed of the rim, impulses over the mass: all in m/s; ``mu`` is the
    signed impulse ratio.
    """
    speed = rebound.speed_m_per_s
    v_n, v_t = (float(v) for v in velocity_components(np.asarray(speed), np.asarray(angle)))
    # The outcome depends on no length; on a unit radius the spin is the speed of the rim.
    spin = spin_ratio * speed
    after = rigid_body_rebound(v_n, v_t, spin, 1.0, rebound.restitution, rebound.friction)
    V_n, V_t = float(after.V_n), float(after.V_t)
    return {
        "v_n": v_n,
        "v_t": v_t,
        "r omega": spin,
        "V_n": V_n,
        "V_t": V_t,
        "r Omega": float(after.Omega),
        "P_n": V_n - v_n,
        "P_t": V_t - v_t,
        "mu": float(after.mu),
    }


def _vectors(
    panel: str, values: Mapping[str, float], names: Mapping[str, Components]
) -> pd.DataFrame:
    """Return one vector from the origin per series, m/s along t and n."""
    arrows = {
        series: np.array([[0.0, 0.0], [values[part] if part else 0.0 for part in parts]])
        for series, parts in names.items()
    }
    return parts_frame(panel, arrows, "computed", "m_per_s")
