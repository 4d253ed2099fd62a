"""Impacts of particles, and the records of an instrument."""

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
        """Report of an instrument without errors on all impacts; captured ones at rest."""
        after = np.where(self.captured[:, None], 0.0, self.rebound_velocity)
        legs = self.velocity[:, ::2], after[:, ::2]
        return Measured(event=np.arange(len(self)), velocities=np.stack(legs, axis=1))


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured(Columns):
    """Report of an instrument: k events of which both tracks or both records were found.

    Attributes
    ----------
    event
        Which impact each was, shape (k,); -1 where the two records are of different impacts. An
        experimenter does not know this: it serves to judge the instrument.
    velocities
        At the surface, m/s, shape (k, 2, 2), with the signs of `Impacts`: incident and rebound
        velocity are rows, their tangential and normal components columns.
    """

    event: IntArray
    velocities: FloatArray

    @classmethod
    def of_normal(cls, event: IntArray, normal: FloatArray) -> Measured:
        """Return events by their normal velocities before and after impact, m/s, shape (k, 2)."""
        return cls(event=event, velocities=np.stack([np.zeros(normal.shape), normal], axis=-1))

    @property
    def tangential(self) -> tuple[FloatArray, FloatArray]:
        """Before and after impact, m/s, shape (k,)."""
        return self.velocities[..., 0, 0], self.velocities[..., 1, 0]

    @property
    def normal(self) -> tuple[FloatArray, FloatArray]:
        """Before and after impact, m/s, shape (k,)."""
        return self.velocities[..., 0, 1], self.velocities[..., 1, 1]

    @property
    def coefficient_of_restitution(self) -> FloatArray:
        """Ratio e of Eq. (1)."""
        before, after = self.normal
        return np.asarray(-after / before)

    @property
    def impulse_ratio(self) -> FloatArray:
        """-mu of Eq. (2), positive where friction acts against the motion."""
        change = self.velocities[..., 1, :] - self.velocities[..., 0, :]
        return np.asarray(-change[..., 0] / change[..., 1])

    @property
    def translational_energy_loss(self) -> FloatArray:
        """T_L of Eq. (3)."""
        squares = np.square(self.velocities)
        energy = squares[..., 0] + squares[..., 1]
        return np.asarray(1.0 - energy[..., 1] / energy[..., 0])

    @property
    def speed(self) -> FloatArray:
        """Speed before impact in the plane of measurement, m/s."""
        return np.asarray(np.hypot(self.normal[0], self.tangential[0]))
