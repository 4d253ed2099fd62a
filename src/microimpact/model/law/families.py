"""Contacts whose normal impacts are one function of the speed and, at most, of one number more.

Similarity: with speeds in velocity scales V, C_H = c_H V and C_A = c_A (v_N/v)^n V determine an
impact. Where c_H, c_A, n and v_N are one for all contacts, V alone is left; where even the groups
are one (c_H = 0 and n = 1; the same zeta by Eqs. 23, 24 at the same diameter), nothing is.
Without adhesion c_H v is the one number.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from microimpact.core.arrays import BoolArray, FloatArray, Real
from microimpact.core.computable import NotComputable
from microimpact.model import passes
from microimpact.model.contact import Contact
from microimpact.model.dynamics import kernel
from microimpact.model.dynamics.capture import capture_velocity, scaled_capture_velocity
from microimpact.model.dynamics.normal import (
    ALWAYS_CAPTURED_ADHESION_GROUP,
    ALWAYS_CAPTURED_HERTZ_GROUP,
    integrate,
    normal_impact,
)

# Relative difference of numbers computed in another order.
SAME = 1e-14
# Places stay this far inside [-1, 1] of a family made for them.
MARGIN = 1e-6


class NoTableError(NotComputable):
    """These impacts cannot be interpolated."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Family:
    """Contacts that differ in their velocity scale V alone."""

    # With rho = V over ``velocity_scale``: ``C_H = hertz rho`` and ``C_A = adhesion rho^(1-n)
    # (v/V)^-n``, n the exponent. Without adhesion damping of the material counts as c_H v, and
    # ``hertz`` is 1 (0 where there is none).
    hertz: float
    adhesion: float
    exponent: float
    damped_attachment: bool  # As in `Contact`
    adhesive: bool  # Whether there is adhesion
    velocity_scale: float  # The middle of the velocity scales, m/s
    # Half the width of ln V; zero where the damping groups are the same for all V.
    half_width: float

    @property
    def alike(self) -> bool:
        """Whether the speed in velocity scales alone determines an impact."""
        return self.half_width == 0.0

    @classmethod
    def of(cls, contact: Contact) -> Family:
        """Return the smallest family that holds all contacts of an array.

        Raises NoTableError if they share neither their damping nor their damping groups, or only
        some adhere.
        """
        scale, c_h, c_a, n = (
            np.asarray(value)
            for value in (
                contact.velocity_scale,
                contact.hertz_damping,
                contact.adhesion_damping,
                contact.adhesion_rate_exponent,
            )
        )
        if not np.any(scale > 0.0):
            return cls._bare(c_h, contact.damped_attachment)
        if not np.all(scale > 0.0):
            raise NoTableError("work_of_adhesion must be positive, or zero, for all impacts")
        rate = np.asarray(1.0 if contact.reference_velocity is None else contact.reference_velocity)
        hertz, adhesion = c_h * scale, c_a * scale * np.power(rate / scale, n)
        if _same(hertz) and _same(adhesion) and _same(n):
            half_width = 0.0
        elif _same(c_h) and _same(c_a * np.power(rate, n)) and _same(n):
            half_width = 0.5 * math.log(scale.max() / scale.min()) * (1.0 + MARGIN)
        else:
            raise NoTableError(
                "hertz_damping, adhesion_damping, adhesion_rate_exponent and reference_velocity "
                "(or the damping groups C_H, C_A) must be the same for all impacts"
            )
        middle = math.sqrt(float(scale.min()) * float(scale.max()))
        first = (float(np.ravel(value)[0]) for value in (c_h, c_a, rate, n))
        c_h1, c_a1, rate1, n1 = first
        if half_width == 0.0:
            hertz1, adhesion1 = float(np.ravel(hertz)[0]), float(np.ravel(adhesion)[0])
        else:
            hertz1, adhesion1 = c_h1 * middle, c_a1 * middle * (rate1 / middle) ** n1
        return cls(
            hertz=hertz1,
            adhesion=adhesion1,
            exponent=n1,
            damped_attachment=contact.damped_attachment,
            adhesive=True,
            velocity_scale=middle,
            half_width=half_width,
        )

    @classmethod
    def _bare(cls, hertz_damping: FloatArray, damped_attachment: bool) -> Family:
        if np.any(hertz_damping > 0.0) and not np.all(hertz_damping > 0.0):
            raise NoTableError("hertz_damping must be positive, or zero, for all impacts")
        return cls(
            hertz=float(np.any(hertz_damping > 0.0)),
            adhesion=0.0,
            exponent=0.0,
            damped_attachment=damped_attachment,
            adhesive=False,
            velocity_scale=1.0,
            half_width=0.0,
        )

    def coordinates(self, contact: Contact, speed: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Scaled speed, and position of V in the family, in [-1, 1] within it.

        Both together determine an impact.
        """
        if not self.adhesive:
            return np.asarray(speed * (contact.hertz_damping if self.hertz else 1.0)), np.zeros(1)
        scale = np.asarray(contact.velocity_scale)
        w = np.asarray(speed / scale)
        if self.alike:
            return w, np.zeros(1)
        position = np.log(scale / self.velocity_scale) / self.half_width
        return w, np.full(w.shape, position)

    def columns(self, contact: Contact, shape: tuple[int, ...]) -> FloatArray:
        """Columns of contacts (n, columns) for a compiled pass, see `model.passes`.

        One contact is one row.
        """
        fields: dict[int, Real] = {passes.RADIUS: contact.radius, passes.FRICTION: contact.friction}
        if not self.adhesive:
            hertz = np.sqrt(contact.hertz_radius) * contact.stiffness
            fields[passes.UNIT] = 1.0 / contact.hertz_damping if self.hertz else 1.0
            fields[passes.LENGTH] = (contact.mass / hertz) ** 0.4
            return _stacked(fields, shape if contact.shape else (1,))
        scale, length = np.asarray(contact.velocity_scale), contact.equilibrium_compression
        fields |= {passes.UNIT: scale, passes.VELOCITY: scale}
        fields |= {passes.LENGTH: length, passes.TIME: length / scale}
        if not self.alike:
            fields[passes.PLACE] = np.log(scale / self.velocity_scale) / self.half_width
        return _stacked(fields, shape if contact.shape else (1,))

    def groups(self, w: FloatArray, position: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Damping groups C_H and, at the scaled speed w, C_A."""
        rho = np.exp(self.half_width * position)
        with np.errstate(over="ignore"):
            rate = np.power(rho, 1.0 - self.exponent) * np.power(w, -self.exponent)
        return np.asarray(self.hertz * rho), np.asarray(self.adhesion * rate)

    def capture_speed(self, position: FloatArray) -> FloatArray:
        """Capture velocity in velocity scales."""
        if not self.adhesive:
            return np.zeros_like(position)
        hertz, adhesion = self.groups(np.ones_like(position), position)
        return scaled_capture_velocity(
            hertz,
            adhesion,
            np.full_like(position, self.exponent),
            np.ones_like(position),
            damped_attachment=self.damped_attachment,
        )

    def problems(self, w: FloatArray, position: FloatArray) -> FloatArray:
        """Write impacts as problems of the kernel, in the adhesive scale (in their own without)."""
        problems = np.zeros((w.size, kernel.PROBLEM_COLUMNS))
        if not self.adhesive:
            problems[:, kernel.START_U] = 1.0
            problems[:, kernel.HERTZ_DAMPING] = self.hertz * w
            return problems
        hertz, adhesion = self.groups(w, position)
        always_captured = hertz > ALWAYS_CAPTURED_HERTZ_GROUP
        always_captured |= adhesion > ALWAYS_CAPTURED_ADHESION_GROUP
        problems[:, kernel.START_U] = w
        problems[:, kernel.ADHESION] = 1.0
        problems[:, kernel.HERTZ_DAMPING] = hertz
        problems[:, kernel.DAMPING_2] = np.where(always_captured, 0.0, adhesion)
        if self.damped_attachment:
            problems[:, kernel.DAMPING_1] = adhesion
        problems[:, kernel.ALWAYS_CAPTURED] = always_captured
        return problems

    def impacts(
        self, w: FloatArray, position: FloatArray, *, ledger: bool, captured: bool = False
    ) -> tuple[FloatArray, BoolArray]:
        """Integrate impacts: quantities (WIDTH, n), and the captured ones (n,).

        Parameters
        ----------
        w, position
            Coordinates, see `coordinates`.
        ledger
            Whether the impulse of the Hertz term is wanted, too.
        captured
            Whether none is to be followed beyond its turning point.
        """
        problems = self.problems(w, position)
        if captured:
            problems[:, kernel.ALWAYS_CAPTURED] = 1.0
        results = integrate(problems, ledger=ledger)
        return quantities(problems, results), results[:, kernel.STATUS] == kernel.CAPTURED


@dataclass(frozen=True, slots=True, eq=False)
class Sizes:
    """Contacts, by any law, that differ in their diameters alone; see `Family`.

    Their scales are the unit of speed, the radius of the sphere and its mass.
    """

    middle: Contact
    half_width: float  # of the logarithm of the diameter; 0 for a single size
    adhesive = True  # as a family: its scales do not go with the speed

    @classmethod
    def of(cls, contact: Contact) -> Sizes:
        """Return all sizes between the smallest and the largest of a contact.

        Raises NoTableError if it holds contacts that differ otherwise.
        """
        smallest, largest = (float(end(contact.diameter)) for end in (np.min, np.max))
        half_width = 0.5 * math.log(largest / smallest)
        middle = contact.replace(diameter=math.sqrt(smallest * largest) if half_width else smallest)
        if middle.shape:
            raise NoTableError(
                "contacts of a table must differ in diameter alone; take one at a time"
            )
        return cls(middle, half_width)

    @property
    def ends(self) -> tuple[float, float]:
        """Smallest and largest diameter, m."""
        factor = math.exp(self.half_width)
        return float(self.middle.diameter) / factor, float(self.middle.diameter) * factor

    @property
    def captures(self) -> bool:
        """Whether slow spheres are captured."""
        return float(capture_velocity(self.middle)) > 0.0

    def position(self, diameter: Real, *, beyond: bool = False) -> FloatArray:
        """Return the position of diameters, in [-1, 1]; other sizes are at the nearest end.

        Parameters
        ----------
        diameter
            m.
        beyond
            Whether other sizes are where they are, beyond the ends.
        """
        position = np.log(np.asarray(diameter) / self.middle.diameter) / (self.half_width or 1.0)
        return position if beyond else np.clip(position, -1.0, 1.0)

    def contact(self, position: FloatArray) -> Contact:
        """Return the contacts at positions."""
        if not self.half_width:
            return self.middle
        return self.middle.replace(
            diameter=self.middle.diameter * np.exp(self.half_width * position)
        )

    def units(self, position: FloatArray) -> FloatArray:
        """Unit of speed at positions, m/s: the capture velocity where there is one."""
        contact = self.contact(position)
        speeds: Real = 1.0 / (float(self.middle.hertz_damping) or 1.0)
        if self.captures:
            speeds = capture_velocity(contact)
        elif self.middle.velocity_scale:
            speeds = contact.velocity_scale
        return np.broadcast_to(speeds, position.shape)

    @property
    def velocity_scale(self) -> float:
        """Unit of speed of the middle size, m/s."""
        return float(self.units(np.zeros(1))[0])

    @property
    def alike(self) -> bool:
        """Whether there is one size only."""
        return self.half_width == 0.0

    def coordinates(self, contact: Contact, speed: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Speed in its unit, and position; see `Family.coordinates`."""
        position = self.position(contact.diameter, beyond=True)
        w = np.asarray(speed / self.units(position))
        return w, np.zeros(1) if self.alike else np.broadcast_to(position, w.shape)

    def columns(self, contact: Contact, shape: tuple[int, ...]) -> FloatArray:
        """Columns of contacts (n, columns); see `Family.columns`."""
        radius, velocity = contact.radius, self.units(self.position(contact.diameter, beyond=True))
        fields: dict[int, Real] = {passes.RADIUS: radius, passes.FRICTION: contact.friction}
        fields |= {passes.UNIT: velocity, passes.VELOCITY: velocity}
        fields |= {passes.LENGTH: radius, passes.TIME: radius / velocity}
        if not self.alike:
            fields[passes.PLACE] = self.position(contact.diameter, beyond=True)
        return _stacked(fields, shape if contact.shape else (1,))

    def capture_speed(self, position: FloatArray) -> FloatArray:
        """Capture velocity in units of speed."""
        return np.full(position.shape, float(self.captures))

    def impacts(
        self, w: FloatArray, position: FloatArray, **_: bool
    ) -> tuple[FloatArray, BoolArray]:
        """Impacts at coordinates; see `Family.impacts`."""
        contact = self.contact(position)
        length, velocity = contact.radius, self.units(self.position(contact.diameter, beyond=True))
        impact = normal_impact(contact, w * velocity)
        impulse = contact.mass * velocity
        values = np.zeros((passes.WIDTH, w.size))
        values[passes.RESTITUTION] = impact.coefficient_of_restitution
        values[passes.CONTACT_TIME] = impact.contact_time * velocity / length
        values[passes.COMPRESSION_TIME] = impact.compression_time * velocity / length
        values[passes.COMPRESSION] = impact.maximum_compression / length
        values[passes.COMPRESSIVE] = impact.compressive_impulse / impulse
        values[passes.PEAK] = impact.peak_net_impulse / impulse
        stays = np.asarray(impact.captured)
        values[passes.COMPRESSIVE :, stays] = 0.0
        return values, stays


def _stacked(fields: dict[int, Real], shape: tuple[int, ...]) -> FloatArray:
    """Columns for a compiled pass, (n, columns)."""
    columns = np.zeros((*shape, len(passes.CONTACT_COLUMNS)))
    for column, values in fields.items():
        columns[..., column] = values
    return columns.reshape(-1, columns.shape[-1])


def quantities(problems: FloatArray, results: FloatArray) -> FloatArray:
    """Quantities of a table (WIDTH, n) from the kernel's results."""
    values, unit = np.empty((passes.WIDTH, len(problems))), np.ones(1)
    kernel.outcomes(problems, results, unit, unit, unit, values)
    captured = results[:, kernel.STATUS] == kernel.CAPTURED
    values[passes.COMPRESSIVE :, captured] = 0.0
    return values


def _same(values: FloatArray) -> bool:
    low, high = float(np.min(values)), float(np.max(values))
    return high - low <= SAME * abs(high)
