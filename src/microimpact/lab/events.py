"""What happens to each particle, and what an instrument reports of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from microimpact.core.arrays import BoolArray, Columns, FloatArray

IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Falling(Columns):
    """Particles as they arrive at the target, in its frame; see `Impacts`."""

    time: FloatArray
    diameter: FloatArray
    position: FloatArray
    velocity: FloatArray
    spin: FloatArray

    def within(self, distance: float) -> Falling:
        """Return those that arrive no further than a distance (m) from the middle."""
        return self.select(np.hypot(self.position[:, 0], self.position[:, 1]) <= distance)


@dataclass(frozen=True, slots=True, kw_only=True)
class Impacts(Falling):
    """True impacts of n particles, in the frame of the target.

    x runs along the nominal surface, down the slope, in the plane in which the particles fall;
    z along the nominal normal, away from the surface; y completes a right-handed frame (and is
    the camera's axis).

    Attributes
    ----------
    time
        Of the impact, s, shape (n,).
    diameter
        m, shape (n,).
    position
        Where on the surface, x and y, m, shape (n, 2).
    velocity, spin
        Before impact, m/s and rad/s, shape (n, 3); velocity[:, 2] < 0.
    rebound_velocity, rebound_spin
        As it leaves for good, after all its contacts; zero normal velocity where captured.
    captured
        True where the particle stays, shape (n,).
    contacts
        Number of contacts with the surface in quick succession (rough surfaces), shape (n,).
    """

    rebound_velocity: FloatArray
    rebound_spin: FloatArray
    captured: BoolArray
    contacts: IntArray

    @property
    def in_plane(self) -> Measured:
        """What an instrument without errors would report of all; captured ones at rest."""
        after = np.where(self.captured[:, None], 0.0, self.rebound_velocity)
        return Measured(
            event=np.arange(len(self)),
            incident_normal=self.velocity[:, 2],
            incident_tangential=self.velocity[:, 0],
            rebound_normal=after[:, 2],
            rebound_tangential=after[:, 0],
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured(Columns):
    """What an instrument reports: k events of which both tracks or both records were found.

    Attributes
    ----------
    event
        Which impact each was, shape (k,); -1 where the two records are of different impacts. An
        experimenter does not know this: it serves to judge the instrument.
    incident_normal, incident_tangential, rebound_normal, rebound_tangential
        Velocity components at the surface, m/s, shape (k,), with the signs of `Impacts`.
    """

    event: IntArray
    incident_normal: FloatArray
    incident_tangential: FloatArray
    rebound_normal: FloatArray
    rebound_tangential: FloatArray

    @classmethod
    def of(cls, event: IntArray, velocities: FloatArray) -> Measured:
        """Return events by their numbers and velocities, m/s, shape (..., 2, 2).

        Incident and rebound velocity are rows, their tangential and normal components columns.
        """
        return cls(
            event=event,
            incident_normal=velocities[..., 0, 1],
            incident_tangential=velocities[..., 0, 0],
            rebound_normal=velocities[..., 1, 1],
            rebound_tangential=velocities[..., 1, 0],
        )

    @property
    def coefficient_of_restitution(self) -> FloatArray:
        """Ratio e of Eq. (1)."""
        return -self.rebound_normal / self.incident_normal

    @property
    def impulse_ratio(self) -> FloatArray:
        """-mu of Eq. (2), positive where friction acts against the motion."""
        return -(self.rebound_tangential - self.incident_tangential) / (
            self.rebound_normal - self.incident_normal
        )

    @property
    def translational_energy_loss(self) -> FloatArray:
        """T_L of Eq. (3)."""
        before = np.square(self.incident_normal) + np.square(self.incident_tangential)
        after = np.square(self.rebound_normal) + np.square(self.rebound_tangential)
        loss: FloatArray = 1.0 - after / before
        return loss

    @property
    def speed(self) -> FloatArray:
        """Speed before impact in the plane of measurement, m/s."""
        return np.asarray(np.hypot(self.incident_normal, self.incident_tangential))
