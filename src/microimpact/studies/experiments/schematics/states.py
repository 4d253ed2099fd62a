"""States drawn to scale in Figs. 19 and 22: a pressed contact, a sphere on a wavy surface."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.core.tables import series_frame
from microimpact.declared.parameters import (
    AngleDegrees,
    CaseName,
    Finite,
    Positive,
)
from microimpact.lab.contacts import calibrated_contact
from microimpact.model.dynamics.trajectory import trajectory

Numbers = dict[tuple[str, str], float]
Parts = Mapping[str, FloatArray]

# Reach of the axes of Fig. 22 and of the path of incidence, in wavelengths.
AXIS, PATH = 0.42, 0.62


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactState:
    """Impact whose greatest compression Fig. 19 shows."""

    case: CaseName
    diameter_um: Positive
    speed_m_per_s: Positive
    angle_deg: AngleDegrees
    instants: Annotated[int, Field(ge=20)]
    points: Annotated[int, Field(ge=21)]


@dataclass(frozen=True, slots=True, kw_only=True)
class WavySurface:
    """Sinusoidal surface of Fig. 22, and the sphere that strikes it so far beyond a crest."""

    wavelength_um: Positive
    amplitude_um: Positive
    place_um: Finite
    diameter_um: Positive
    angle_deg: AngleDegrees
    points: Annotated[int, Field(ge=20)]


def parts_frame(panel: str, parts: Parts, evidence: str, unit: str = "mm") -> pd.DataFrame:
    """Return points of several parts of one panel, a series each, as figure data."""
    frames = [
        series_frame(
            panel=panel,
            series=series,
            evidence=evidence,
            x=points[:, 0],
            y=points[:, 1],
            x_unit=unit,
            y_unit=unit,
        )
        for series, points in parts.items()
    ]
    return pd.concat(frames, ignore_index=True)


def contact_state(
    params: ContactState, inputs: Mapping[str, pd.DataFrame]
) -> tuple[Numbers, dict[str, pd.DataFrame]]:
    """Return numbers and tables of Fig. 19: the contact at its greatest compression.

    The contact radius is ``a = sqrt(r |n|)``, the pressure ``p_0 sqrt(1 - (rho/a)^2)`` with
    ``p_0 = 3 F / (2 pi a^2)`` of the Hertz force F; the ring force f_0 pulls along the edge.
    """
    contact = calibrated_contact(inputs, params.case, diameter=params.diameter_um * 1e-6)
    path = trajectory(contact, params.speed_m_per_s, params.angle_deg, points=params.instants)
    turn = int(np.argmax(path.compression))
    force, compression = float(path.hertz_force[turn]), float(path.compression[turn])
    a = float(np.sqrt(contact.hertz_radius * compression))
    peak = 1.5 * force / (np.pi * a**2)
    ring = float(np.asarray(contact.ring_force))
    share = np.sin(np.linspace(-0.5 * np.pi, 0.5 * np.pi, params.points))
    numbers = {
        ("time", "ns"): float(path.time[turn]) * 1e9,
        ("contact_radius", "um"): a * 1e6,
        ("compression", "nm"): compression * 1e9,
        ("peak_pressure", "GPa"): peak * 1e-9,
        ("hertz_force", "uN"): force * 1e6,
        ("adhesion_force", "uN"): float(path.adhesion_force[turn]) * 1e6,
        ("ring_force", "N/m"): ring,
    }
    section = _section(float(contact.radius) * 1e6, a * 1e6, params.points)
    stresses = {"panel": "stresses", "evidence": "computed", "x_unit": "um"}
    return numbers, {
        "fig19": parts_frame("section", section, "computed", "um"),
        "fig19_pressure": series_frame(
            **stresses,
            series="pressure",
            x=a * share * 1e6,
            y=peak * np.sqrt(np.maximum(1.0 - share**2, 0.0)) * 1e-9,
            y_unit="GPa",
        ),
        "fig19_ring": series_frame(
            **stresses,
            series="ring tension",
            x=np.array([-a, a]) * 1e6,
            y=-ring,
            y_unit="N_per_m",
        ),
    }


def _section(radius: float, a: float, points: int) -> dict[str, FloatArray]:
    """Return a sphere pressed on a plane that is hard beside it, and its free shape.

    Outside the contact its surface moves by Hertz's
    ``u = ((2 a^2 - rho^2) asin(a / rho) + a sqrt(rho^2 - a^2)) / (pi r)``.
    """
    centre = np.array([0.0, radius - a**2 / radius])
    down = np.linspace(np.arcsin(a / radius), 0.5 * np.pi, points)
    rho = radius * np.sin(down)
    moved = (2.0 * a**2 - rho**2) * np.arcsin(np.minimum(a / rho, 1.0))
    moved += a * np.sqrt(np.maximum(rho**2 - a**2, 0.0))
    lower = np.stack([rho, centre[1] - radius * np.cos(down) + moved / (np.pi * radius)], axis=-1)
    turn = np.linspace(0.0, np.pi, 2 * points)
    upper = centre + radius * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    whole = np.linspace(0.0, 2.0 * np.pi, 4 * points)
    return {
        "sphere": np.vstack([lower, upper, lower[::-1] * [-1.0, 1.0]]),
        "contact": np.array([[-a, 0.0], [a, 0.0]]),
        "free shape": centre + radius * np.stack([np.cos(whole), np.sin(whole)], axis=-1),
        "centre": centre[None],
    }


def wavy_surface(params: WavySurface) -> tuple[Numbers, pd.DataFrame]:
    """Return numbers and table of Fig. 22, with the point of impact at the origin.

    A slope that faces the sphere, which moves towards +t, has phi > 0: the local angle of
    incidence is alpha + phi (Eqs. 35, 36).

    Raises
    ------
    ValueError
        If the surface does not face the sphere there, or the sphere would touch it elsewhere too.
    """
    k = 2.0 * np.pi / params.wavelength_um
    crest = params.amplitude_um * np.cos(k * params.place_um)
    slope = -params.amplitude_um * k * np.sin(k * params.place_um)
    alpha, phi = float(np.radians(params.angle_deg)), float(np.arctan(slope))
    if alpha + phi <= 0.0:
        raise ValueError(
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
        raise ValueError(
            f"wavy_surface.diameter_um: a sphere of {params.diameter_um} um would touch the "
            "surface elsewhere too; it must fit into the trough"
        )
    x = np.linspace(-1.0, 1.0, params.points) * params.wavelength_um
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
    numbers = {
        ("slope_angle", "deg"): float(np.degrees(phi)),
        ("local_angle_of_incidence", "deg"): float(np.degrees(alpha + phi)),
    }
    frames = [
        parts_frame("geometry", assumed, "assumed", "um"),
        parts_frame("geometry", computed, "computed", "um"),
    ]
    return numbers, pd.concat(frames, ignore_index=True)


def _axes(turn: float) -> tuple[FloatArray, FloatArray]:
    """Return the axes t and n turned by an angle in radians, towards the approaching sphere."""
    c, s = np.cos(turn), np.sin(turn)
    return np.array([c, s]), np.array([-s, c])
