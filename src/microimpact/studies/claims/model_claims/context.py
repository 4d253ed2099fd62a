"""What the numbers behind the claims on the models share: settings, contacts, tables."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from microimpact.core.arrays import FloatArray, Real
from microimpact.declared.parameters import (
    AngleDegrees,
    Finite,
    Fraction,
    Name,
    NonNegative,
    Positive,
)
from microimpact.lab.contacts import declared_contact
from microimpact.lab.samples import Dropped, Sampling
from microimpact.model.contact import Contact
from microimpact.model.dynamics.impact import Impact, simulate
from microimpact.studies.claim_numbers import CaseContext

# Halvings that narrow any interval of numbers down to rounding.
HALVINGS = 60


@dataclass(frozen=True, slots=True, kw_only=True)
class Steel:
    """Steel on silicon, and the impact that a claim means unless it says otherwise.

    Attributes
    ----------
    particle, surface, cases
        The pair and its calibrated cases.
    diameter_um, speed_m_per_s, friction, spin_ratio
        Spin as r omega over v.
    friction_basis
        Force that supports friction.
    angles_deg
        Declared angles of incidence.
    angle_step_deg
        Of sweeps over all angles.
    """

    particle: Name
    surface: Name
    cases: Annotated[tuple[Name, ...], Field(min_length=1)]
    diameter_um: Positive
    speed_m_per_s: Positive
    friction: NonNegative
    spin_ratio: Finite
    friction_basis: Literal["compressive", "hertz", "net"]
    angles_deg: Annotated[tuple[AngleDegrees, ...], Field(min_length=2)]
    angle_step_deg: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Normal:
    """Speeds and diameters of the claims on normal impact; intervals as their two ends."""

    flat_from_m_per_s: Positive
    slow_speed_m_per_s: Positive
    rest_speed_m_per_s: Positive
    above_capture: Positive
    capture_velocities: tuple[Positive, Positive, Positive]
    compared_diameters_um: tuple[Positive, Positive]
    adhesion_size_exponent: Finite
    plateau_share: Annotated[Fraction, Field(gt=0)]
    lasting_diameters_um: tuple[Positive, Positive]
    lasting_speeds_m_per_s: tuple[Positive, Positive]
    fitted_from: Annotated[float, Field(gt=1)]
    fitted_to: Annotated[float, Field(gt=1)]
    fitted_points: Annotated[int, Field(ge=8)]
    points: Annotated[int, Field(ge=5)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Oblique:
    """Angles and speeds of the claims on oblique impact; intervals from steep to shallow."""

    loss_speed_m_per_s: Positive
    level_loss_deg: tuple[AngleDegrees, AngleDegrees]
    falling_loss_deg: tuple[AngleDegrees, AngleDegrees]
    plateau_deg: AngleDegrees
    spin_angle_deg: AngleDegrees
    normal_spin_ratio: Finite
    captured_at_deg: tuple[AngleDegrees, AngleDegrees]
    facet_slope_deg: Finite
    rough_angles_deg: tuple[AngleDegrees, AngleDegrees]
    points: Annotated[int, Field(ge=5)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Algebra:
    """Numbers at which identities are tried."""

    restitutions: tuple[Fraction, ...]
    adhesion_coefficients: tuple[Fraction, ...]
    slopes_deg: tuple[Finite, ...]
    spore_angles_deg: tuple[AngleDegrees, AngleDegrees]


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibrated:
    """A calibrated case and its pair."""

    particle: Name
    surface: Name
    case: Name


@dataclass(frozen=True, slots=True, kw_only=True)
class Fluorescein:
    """Ammonium fluorescein on molybdenum, as declared, and on mica, as calibrated."""

    particle: Name
    surface: Name
    diameter_um: Positive
    on_mica: Calibrated


@dataclass(frozen=True, slots=True, kw_only=True)
class Slow:
    """Slow oblique impacts, of which those below a normal speed are looked at."""

    dropped: Dropped
    normal_speed_below_m_per_s: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Which claims are computed, and with what; the case of what is dropped is each in turn."""

    claims: Annotated[tuple[Name, ...], Field(min_length=1)]
    steel: Steel
    normal: Normal
    oblique: Oblique
    algebra: Algebra
    fluorescein: Fluorescein
    slow: Slow
    fast: Dropped
    sampling: Sampling
    anchors: tuple[Name, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Context(CaseContext):
    """A case with the settings of these claims."""

    params: Params

    @property
    def speed(self) -> float:
        """Speed of the impact meant, m/s."""
        return self.params.steel.speed_m_per_s

    @property
    def calibrated_capture_velocity(self) -> float:
        """Capture velocity that the calibration met, m/s."""
        table = self.inputs["calibration"]
        own = (table["case"] == self.case) & (table["role"] == "target")
        rows = table[own & (table["quantity"] == "capture_velocity")]
        if rows.empty:
            raise ValueError(f"calibration: no capture velocity was met in case {self.case!r}")
        return float(rows["value"].iloc[0])

    @property
    def fluorescein(self) -> Contact:
        """Declared contact of ammonium fluorescein on molybdenum."""
        pair = self.params.fluorescein
        return declared_contact(
            self.inputs, pair.particle, pair.surface, diameter=pair.diameter_um * 1e-6
        )

    def hit(self, contact: Contact, speed: Real, angle: Real = 90.0) -> Impact:
        """Simulate impacts with the initial spin and the friction meant."""
        steel = self.params.steel
        spin = steel.spin_ratio * np.asarray(speed) / contact.radius
        return simulate(contact, speed, angle, spin, steel.friction_basis)

    def all_angles(self, high: float = 90.0, low: float = 0.0) -> FloatArray:
        """Return all steps of the angle from high to low, without 0, in degrees."""
        step = self.params.steel.angle_step_deg
        angles = step * np.arange(1, int(90.0 / step) + 1)
        inside = angles[(angles >= low) & (angles <= high)][::-1]
        return inside.astype(np.float64)

    def rebounds(
        self, contact: Contact, angles: FloatArray | None = None
    ) -> tuple[FloatArray, Impact]:
        """Return the angles (all steps, if none given) at which it rebounds, and the impacts."""
        wanted = self.all_angles() if angles is None else angles
        free = wanted[~self.hit(contact, self.speed, wanted).captured]
        return free, self.hit(contact, self.speed, free)


def without_adhesion(contact: Contact) -> Contact:
    """Return the contact with the same damping and no ring force."""
    return contact.replace(work_of_adhesion=0.0)


def between(ends: tuple[float, float], points: int) -> FloatArray:
    """Return speeds or sizes between two ends, in equal ratios."""
    return np.geomspace(*ends, points)


def boundary(holds: Callable[[float], bool], low: float, high: float) -> float:
    """Return where a condition begins to hold, which does not hold below and does above."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high
