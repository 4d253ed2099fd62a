"""From the dashes of a track to the velocities at the surface (Section 2.1).

Each leg is fitted, in the laboratory's horizontal and vertical, by a path under known gravity, and
followed to the instant at which the centre of the sphere is half a diameter from the known line of
the surface. Dash k of a leg is taken to be lit at k over the nominal rate of the chopper.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.constants import g as gravity

from microimpact.arrays import FloatArray
from microimpact.lab.ptis import Setup

# A leg whose dashes lie off a path under gravity by more than this (rms) is no single flight.
RESIDUAL_PX = 0.5


@dataclass(frozen=True, slots=True)
class Rejection:
    """Why a frame was not measured."""

    reason: str


OVERLAP = Rejection("tracks overlap")
TOUCHING = Rejection("dashes touch")
SATURATED = Rejection("dashes saturated")
FEW = Rejection("too few dashes")
NO_VERTEX = Rejection("track misses the surface")
IRREGULAR = Rejection("dashes off one path")
SECOND_BOUNCE = Rejection("second bounce in view")


@dataclass(frozen=True, slots=True, kw_only=True)
class Leg:
    """One leg of a track: m dashes in order of time, and the path fitted to them.

    Attributes
    ----------
    points
        Centroids, horizontal and vertical (up), m from the image of the target's origin, (m, 2).
    origin, velocity
        Of the path at the first dash, m and m/s, shape (2,).
    gravity
        Downward acceleration of the path, m/s2.
    residual
        Root mean square distance of the points from the path, m.
    contact
        Time of contact with the surface, s after the first dash (negative on the rebound).
    """

    points: FloatArray
    origin: FloatArray
    velocity: FloatArray
    gravity: float
    residual: float
    contact: float = np.nan

    def at(self, time: FloatArray) -> FloatArray:
        """Return points of the path, m, shape (..., 2), at times s after the first dash."""
        t = np.asarray(time)[..., None]
        return self.origin + self.velocity * t - 0.5 * np.array([0.0, self.gravity]) * t**2

    @property
    def contact_velocity(self) -> FloatArray:
        """Horizontal and vertical velocity at the surface, m/s, shape (2,)."""
        return self.velocity - [0.0, self.gravity * self.contact]


@dataclass(frozen=True, slots=True, kw_only=True)
class Track:
    """A measured track.

    Attributes
    ----------
    incident, rebound
        The two legs.
    velocities
        At the surface, in its frame: incident and rebound (rows), tangential and normal, m/s.
    """

    incident: Leg
    rebound: Leg
    velocities: FloatArray


def reduce_legs(
    incident: FloatArray, rebound: FloatArray, setup: Setup, *, with_gravity: bool = True
) -> Track | Rejection:
    """Return the velocities at the surface from the centroids of both legs.

    Parameters
    ----------
    incident, rebound
        Columns and rows, shape (m, 2), of consecutive dashes in order of time.
    setup
        What is known of the instrument.
    with_gravity
        As in `measure`.
    """
    pull = gravity if with_gravity else 0.0
    legs = []
    for places, outward in ((incident, False), (rebound, True)):
        points = (places - setup.centre) * [setup.pixel, -setup.pixel]
        leg = to_surface(fit_path(points, setup.chop_rate, pull), setup, outward=outward)
        if with_gravity and leg.residual > _tolerated(setup):
            return _second_bounce(points, setup) if outward else IRREGULAR
        legs.append(leg)
    velocities = np.stack([to_target(leg.contact_velocity, setup) for leg in legs])
    if not (velocities[0, 1] < 0.0 < velocities[1, 1]):
        return NO_VERTEX
    return Track(incident=legs[0], rebound=legs[1], velocities=velocities)


def fit_path(points: FloatArray, rate: float, pull: float) -> Leg:
    """Fit a leg, by least squares, with constant horizontal velocity and vertical acceleration."""
    time = np.arange(len(points)) / rate
    level = points + 0.5 * np.array([0.0, pull]) * time[:, None] ** 2
    velocity = velocity_weights(len(points), rate) @ level
    origin = level.mean(axis=0) - velocity * time.mean()
    off = level - origin - velocity * time[:, None]
    residual = float(np.sqrt(np.mean(np.sum(off**2, axis=1))))
    return Leg(points=points, origin=origin, velocity=velocity, gravity=pull, residual=residual)


def velocity_weights(n: int, rate: float) -> FloatArray:
    """Weights of n equidistant positions in the fitted velocity, 1/s, shape (n,)."""
    time = (np.arange(n) - 0.5 * (n - 1)) / rate
    weights: FloatArray = time / np.sum(time**2)
    return weights


def to_target(vectors: FloatArray, setup: Setup) -> FloatArray:
    """Return tangential and normal components of horizontal and vertical ones, (..., 2)."""
    alpha = np.radians(setup.angle)
    across, up = np.moveaxis(vectors, -1, 0)
    return np.stack(
        [
            across * np.sin(alpha) - up * np.cos(alpha),
            across * np.cos(alpha) + up * np.sin(alpha),
        ],
        axis=-1,
    )


def to_surface(leg: Leg, setup: Setup, *, outward: bool) -> Leg:
    """Return a leg with the time of contact; not a number where its path misses the surface.

    Of the two roots of the height above the surface, the one at which the sphere comes (or leaves,
    if `outward`), in the form that does not cancel.
    """
    height = to_target(leg.origin, setup)[1] - 0.5 * setup.diameter
    normal = to_target(leg.velocity, setup)[1] * (1.0 if outward else -1.0)
    square = normal**2 + 2.0 * leg.gravity * np.sin(np.radians(setup.angle)) * height
    root = np.sqrt(square) if square >= 0.0 else np.nan
    away = normal + root
    contact = 2.0 * height / away if away > 0.0 else np.nan
    return replace(leg, contact=-contact if outward else contact)


def _tolerated(setup: Setup) -> float:
    """Residual of a leg that blur, noise and jitter explain, m."""
    jitter = 3.0 * setup.instrument.jitter * setup.speed / setup.chop_rate
    return RESIDUAL_PX * setup.pixel + jitter


def _second_bounce(points: FloatArray, setup: Setup) -> Rejection:
    """Tell whether the sphere came back to the surface, by the first dashes of its rebound."""
    first = points[: setup.instrument.least_dashes]
    leg = to_surface(fit_path(first, setup.chop_rate, gravity), setup, outward=True)
    normal = to_target(leg.contact_velocity, setup)[1]
    back = leg.contact + 2.0 * normal / (gravity * np.sin(np.radians(setup.angle)))
    return SECOND_BOUNCE if back * setup.chop_rate < len(points) else IRREGULAR
