"""Geometry and example states of the schematic figures (Figs. 1, 2, 3, 13, 19 and 22)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.core.computable import NotComputable
from microimpact.model.dynamics.impact import velocity_components
from microimpact.model.dynamics.trajectory import trajectory
from microimpact.model.rigid_body.algebra import rigid_body_rebound
from study.analyses.fig01_03_13_19_22_schematics import layout
from study.contacts import calibrated_contact
from study.declared.parameters import (
    AngleDegrees,
    CaseName,
    Finite,
    Fraction,
    NonNegative,
    Positive,
)
from study.tables import Tables, series_frame

Parts = Mapping[str, FloatArray]

# Reach of the axes of Fig. 22 and of the path of incidence, in wavelengths.
AXIS, PATH = 0.42, 0.62
# Instants that find the greatest compression to a millionth; points of smooth outlines.
INSTANTS, POINTS = 2001, 121


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactState:
    """Impact whose greatest compression Fig. 19 shows."""

    case: CaseName
    diameter_um: Positive
    speed_m_per_s: Positive
    angle_deg: AngleDegrees


@dataclass(frozen=True, slots=True, kw_only=True)
class WavySurface:
    """Sinusoidal surface of Fig. 22, and the sphere that strikes it so far beyond a crest."""

    wavelength_um: Positive
    amplitude_um: Positive
    place_um: Finite
    diameter_um: Positive
    angle_deg: AngleDegrees


def parts_frame(panel: str, parts: Parts, evidence: str, unit: str = "mm") -> pd.DataFrame:
    """Return points of several parts of one panel, a series each, as figure data."""
    frame = partial(series_frame, panel, evidence=evidence, x_unit=unit, y_unit=unit)
    return pd.concat([frame(name, *of.T) for name, of in parts.items()], ignore_index=True)


def whole(*groups: tuple[Any, ...]) -> pd.DataFrame:
    """Return the rows of `parts_frame` for several panels or kinds of evidence, in one."""
    return pd.concat([parts_frame(*of) for of in groups], ignore_index=True)


def contact_state(params: ContactState, inputs: Tables) -> dict[str, pd.DataFrame]:
    """Return the tables of Fig. 19: the contact at its greatest compression.

    The contact radius is ``a = sqrt(r |n|)``, the pressure ``p_0 sqrt(1 - (rho/a)^2)`` with
    ``p_0 = 3 F / (2 pi a^2)`` of the Hertz force F; the ring force f_0 pulls along the edge.
    """
    contact = calibrated_contact(inputs, params.case, diameter=params.diameter_um * 1e-6)
    path = trajectory(contact, params.speed_m_per_s, params.angle_deg, points=INSTANTS)
    turn = int(np.argmax(path.compression))
    force, compression = float(path.hertz_force[turn]), float(path.compression[turn])
    a = float(np.sqrt(contact.hertz_radius * compression))
    peak = 1.5 * force / (np.pi * a**2)
    ring = float(np.asarray(contact.ring_force))
    share = np.sin(np.linspace(-0.5 * np.pi, 0.5 * np.pi, POINTS))
    section = _section(float(contact.radius) * 1e6, a * 1e6)
    frame = partial(series_frame, "stresses", x_unit="um")
    pressure = peak * np.sqrt(np.maximum(1.0 - share**2, 0.0)) * 1e-9
    edge = np.array([-a, a]) * 1e6
    return {
        "fig19": parts_frame("section", section, "computed", "um"),
        "fig19_pressure": frame("pressure", a * share * 1e6, pressure, y_unit="GPa"),
        "fig19_ring": frame("ring tension", edge, -ring, y_unit="N_per_m"),
    }


def _section(radius: float, a: float) -> dict[str, FloatArray]:
    """Return a sphere pressed on a plane that is hard beside it, and its free shape.

    Outside the contact its surface moves by Hertz's
    ``u = ((2 a^2 - rho^2) asin(a / rho) + a sqrt(rho^2 - a^2)) / (pi r)``.
    """
    centre = np.array([0.0, radius - a**2 / radius])
    down = np.linspace(np.arcsin(a / radius), 0.5 * np.pi, POINTS)
    rho = radius * np.sin(down)
    moved = (2.0 * a**2 - rho**2) * np.arcsin(np.minimum(a / rho, 1.0))
    moved += a * np.sqrt(np.maximum(rho**2 - a**2, 0.0))
    lower = np.stack([rho, centre[1] - radius * np.cos(down) + moved / (np.pi * radius)], axis=-1)
    turn = np.linspace(0.0, np.pi, 2 * POINTS)
    upper = centre + radius * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    whole = np.linspace(0.0, 2.0 * np.pi, 4 * POINTS)
    return {
        "sphere": np.vstack([lower, upper, lower[::-1] * [-1.0, 1.0]]),
        "contact": np.array([[-a, 0.0], [a, 0.0]]),
        "free shape": centre + radius * np.stack([np.cos(whole), np.sin(whole)], axis=-1),
        "centre": centre[None],
    }


def wavy_surface(params: WavySurface) -> pd.DataFrame:
    """Return the table of Fig. 22, with the point of impact at the origin.

    A slope that faces the sphere, which moves towards +t, has phi > 0: the local angle of
    incidence is alpha + phi (Eqs. 35, 36).

    Raises NotComputable if the surface does not face the sphere there, or the sphere would touch it
    elsewhere too.
    """
    k = 2.0 * np.pi / params.wavelength_um
    crest = params.amplitude_um * np.cos(k * params.place_um)
    slope = -params.amplitude_um * k * np.sin(k * params.place_um)
    alpha, phi = float(np.radians(params.angle_deg)), float(np.arctan(slope))
    if alpha + phi <= 0.0:
        raise NotComputable(
            f"wavy_surface.place_um: {params.place_um} has a slope of {np.degrees(phi):.1f} deg, "
            f"away from a sphere that comes at {params.angle_deg} deg; the sum must be positive"
        )

    def height(x: FloatArray) -> FloatArray:
        return np.asarray(params.amplitude_um * np.cos(k * (x + params.place_um)) - crest)

    radius, origin = params.diameter_um / 2.0, np.zeros(2)
    (t, n), (t_local, n_local) = _axes(0.0), _axes(phi)
    centre = radius * n_local
    near = np.linspace(-2.0 * radius, 2.0 * radius, 4001)
    if np.hypot(near - centre[0], height(near) - centre[1]).min() < radius * (1.0 - 1e-6):
        raise NotComputable(
            f"wavy_surface.diameter_um: a sphere of {params.diameter_um} um would touch the "
            "surface elsewhere too; it must fit into the trough"
        )
    x = np.linspace(-1.0, 1.0, 401) * params.wavelength_um
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    axis, incoming = AXIS * params.wavelength_um, _axes(-alpha)[0]
    assumed = {
        "surface": np.stack([x, height(x)], axis=-1),
        "mean plane": np.stack([x[[0, -1]], np.full(2, -crest)], axis=-1),
    }
    computed = {
        "sphere": centre + radius * np.stack([np.cos(turn), np.sin(turn)], axis=-1),
        "incident velocity": np.array([-PATH * params.wavelength_um * incoming, origin]),
        "nominal tangent": np.array([origin, axis * t]),
        "nominal normal": np.array([origin, axis * n]),
        "local tangent": np.array([origin, axis * t_local]),
        "local normal": np.array([origin, axis * n_local]),
    }
    kinds = ("geometry", assumed, "assumed", "um"), ("geometry", computed, "computed", "um")
    return whole(*kinds)


def _axes(turn: float) -> tuple[FloatArray, FloatArray]:
    """Return the axes t and n turned by an angle in radians, towards the approaching sphere."""
    c, s = np.cos(turn), np.sin(turn)
    return np.array([c, s]), np.array([-s, c])


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
    """Numbers of Section 2.1 on the two set-ups, and the angle of the target of Fig. 1."""

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
class DrawnRebound:
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
    rebound: DrawnRebound
    contact: ContactState
    wavy_surface: WavySurface


def run(params: Params, inputs: Tables) -> Tables:
    """Return the geometry of every schematic.

    ``fig01``, ``fig02``: parts of the set-ups, mm on the drawing. ``fig03``, ``fig13``: velocities,
    and impulses over the mass, m/s; a spin is the speed of the rim. ``fig19``: section of the
    sphere, um; ``fig19_pressure``: Hertz pressure, GPa, over the radius; ``fig19_ring``: force per
    length of the edge, N/m. ``fig22``: surface and axes, um. Raises NotComputable
    if the sphere of Fig. 22 cannot touch the surface at its place.
    """
    motion = velocities(params.rebound, params.rebound.angle_deg, params.rebound.spin_ratio)
    return {
        "fig01": imaging_system(params.set_ups, params.rebound),
        "fig02": doppler_analyser(params.set_ups),
        "fig03": _vectors("impact", motion, FIG03),
        "fig13": pd.concat(
            [_vectors(panel, motion, names) for panel, names in FIG13.items()], ignore_index=True
        ),
        **contact_state(params.contact, inputs),
        "fig22": wavy_surface(params.wavy_surface),
    }


def imaging_system(set_ups: SetUps, rebound: DrawnRebound) -> pd.DataFrame:
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
    top = layout.imaging_top(set_ups.camera_angle_deg)
    return whole(("side", side, "printed"), ("side", tracks, "computed"), ("top", top, "printed"))


def doppler_analyser(set_ups: SetUps) -> pd.DataFrame:
    """Return the parts of Fig. 2; usual ones that the article leaves out are assumed."""
    named, usual = layout.analyser_top(set_ups.receiver_angle_deg, set_ups.detectors)
    side = layout.analyser_side()
    return whole(("top", named, "printed"), ("top", usual, "assumed"), ("side", side, "printed"))


def velocities(rebound: DrawnRebound, angle: float, spin_ratio: float) -> dict[str, float]:
    """Return velocities before (lower case) and after a rigid body impact, and its impulses.

    Spins are given as the speed of the rim, impulses over the mass: all in m/s.
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
