"""From the dashes of a track to the velocities at the surface (Section 2.1).

Each leg is fitted, in the laboratory's horizontal and vertical, by a path under known gravity, and
followed to the instant at which the centre of the sphere is half a diameter from the known line of
the surface. Dash k of a leg is taken to be lit at k over the nominal rate of the chopper.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.constants import gravity
from microimpact.lab.ptis.system import Setup

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
    """One leg of a track, or of each of many: dashes in order of time, and the path fitted to them.

    Attributes
    ----------
    points
        Centroids, horizontal and vertical (up), m from the image of the target's origin,
        shape (..., m, 2).
    weights
        Of the points in the fitted velocity, 1/s, shape (..., m).
    origin, velocity
        Of the path at the first dash, m and m/s, shape (..., 2).
    gravity
        Downward acceleration of the path, m/s2.
    residual
        Root mean square distance of the points from the path, m, shape (...).
    contact
        Time of contact with the surface, s after the first dash (negative on the rebound),
        shape (...).
    """

    points: FloatArray
    weights: FloatArray
    origin: FloatArray
    velocity: FloatArray
    gravity: float
    residual: FloatArray
    contact: FloatArray

    def at(self, time: FloatArray) -> FloatArray:
        """Return points of the path, m, shape (..., 2), at times s after the first dash."""
        t = np.asarray(time)[..., None]
        return self.origin + self.velocity * t - 0.5 * np.array([0.0, self.gravity]) * t**2

    def single(self, i: int, number: int) -> Leg:
        """Return one of many legs, of which so many points count."""
        return Leg(
            points=self.points[i, :number],
            weights=self.weights[i, :number],
            origin=self.origin[i],
            velocity=self.velocity[i],
            gravity=self.gravity,
            residual=self.residual[i],
            contact=self.contact[i],
        )

    @property
    def contact_velocity(self) -> FloatArray:
        """Horizontal and vertical velocity at the surface, m/s, shape (..., 2)."""
        return self.velocity - self.contact[..., None] * [0.0, self.gravity]


@dataclass(frozen=True, slots=True, kw_only=True)
class Track:
    """A measured track, or many.

    Attributes
    ----------
    incident, rebound
        The two legs.
    velocities
        At the surface, in its frame: incident and rebound (rows), tangential and normal, m/s,
        shape (..., 2, 2).
    """

    incident: Leg
    rebound: Leg
    velocities: FloatArray

    def single(self, i: int, incident: int, rebound: int) -> Track:
        """Return one of many tracks, of which so many points of each leg count."""
        return Track(
            incident=self.incident.single(i, incident),
            rebound=self.rebound.single(i, rebound),
            velocities=self.velocities[i],
        )

    @property
    def meets_surface(self) -> BoolArray:
        """True where one leg comes to the surface and the other leaves it."""
        normal = self.velocities[..., 1]
        meets: BoolArray = (normal[..., 0] < 0.0) & (normal[..., 1] > 0.0)
        return meets


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
    return reduce_tracks([(incident, rebound)], setup, with_gravity=with_gravity)[0]


def reduce_tracks(
    legs: Sequence[tuple[FloatArray, FloatArray]], setup: Setup, *, with_gravity: bool = True
) -> list[Track | Rejection]:
    """Return, as `reduce_legs`, what comes of the incident and the rebound leg of every track."""
    if not legs:
        return []
    before, first = _side_by_side([incident for incident, _ in legs])
    after, last = _side_by_side([rebound for _, rebound in legs])
    tracks = fit_track(before, after, setup, used=(first, last), with_gravity=with_gravity)
    fallen, risen = (
        smooth(leg, setup) | (not with_gravity) for leg in (tracks.incident, tracks.rebound)
    )
    meets, found = tracks.meets_surface, list[Track | Rejection]()
    for i, (incident, rebound) in enumerate(legs):
        if not fallen[i]:
            found.append(IRREGULAR)
        elif not risen[i]:
            found.append(_second_bounce(tracks.rebound.points[i, : len(rebound)], setup))
        else:
            numbers = len(incident), len(rebound)
            found.append(tracks.single(i, *numbers) if meets[i] else NO_VERTEX)
    return found


def _side_by_side(legs: Sequence[FloatArray]) -> tuple[FloatArray, BoolArray]:
    """Return the places of legs, zero beyond their ends, (k, m, 2), and which of them count."""
    used = np.arange(max(map(len, legs))) < np.array([len(leg) for leg in legs])[:, None]
    places = np.zeros((*used.shape, 2))
    places[used] = np.concatenate(legs)
    return places, used


def fit_track(
    incident: FloatArray,
    rebound: FloatArray,
    setup: Setup,
    *,
    used: tuple[BoolArray | None, BoolArray | None] = (None, None),
    with_gravity: bool = True,
) -> Track:
    """Fit both legs and follow them to the surface, whether or not they make a track.

    Parameters
    ----------
    incident, rebound, setup, with_gravity
        As in `reduce_legs`; any number of tracks, shape (..., m, 2).
    used
        Which of the places of each leg count, shape (..., m): the first ones; all if not given.
    """
    pull = gravity if with_gravity else 0.0
    legs = []
    for places, count, outward in ((incident, used[0], False), (rebound, used[1], True)):
        points = (places - setup.centre) * [setup.pixel, -setup.pixel]
        leg = fit_path(points, setup.chop_rate, pull, count)
        legs.append(to_surface(leg, setup, outward=outward))
    velocities = np.stack([to_target(leg.contact_velocity, setup) for leg in legs], axis=-2)
    return Track(incident=legs[0], rebound=legs[1], velocities=velocities)


def fit_path(points: FloatArray, rate: float, pull: float, used: BoolArray | None = None) -> Leg:
    """Fit a leg, by least squares, with constant horizontal velocity and vertical acceleration."""
    used = np.ones(points.shape[:-1], dtype=bool) if used is None else used
    # Sums run over the last axis but one, point by point: points that do not count change nothing.
    number = np.sum(used, axis=-1, keepdims=True)
    time, middle = np.arange(points.shape[-2]) / rate, 0.5 * (number - 1) / rate
    share = used / number
    weights = used * (time - middle) * 12.0 * rate**2 / (number * (number**2 - 1.0))
    level = points + 0.5 * np.array([0.0, pull]) * time[:, None] ** 2
    velocity = np.sum(weights[..., None] * level, axis=-2)
    origin = np.sum(share[..., None] * level, axis=-2) - velocity * middle
    off = level - origin[..., None, :] - velocity[..., None, :] * time[:, None]
    return Leg(
        points=points,
        weights=weights,
        origin=origin,
        velocity=velocity,
        gravity=pull,
        residual=np.sqrt(np.sum(np.sum(share[..., None] * off**2, axis=-2), axis=-1)),
        contact=np.full(points.shape[:-2], np.nan),
    )


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
    height = to_target(leg.origin, setup)[..., 1] - 0.5 * setup.diameter
    normal = to_target(leg.velocity, setup)[..., 1] * (1.0 if outward else -1.0)
    square = normal**2 + 2.0 * leg.gravity * np.sin(np.radians(setup.angle)) * height
    away = normal + np.sqrt(np.where(square >= 0.0, square, np.nan))
    contact = 2.0 * height / np.where(away > 0.0, away, np.nan)
    return replace(leg, contact=-contact if outward else contact)


def smooth(leg: Leg, setup: Setup) -> BoolArray:
    """Tell whether blur, noise and jitter explain how far the dashes lie off the path."""
    jitter = 3.0 * setup.instrument.jitter * setup.speed / setup.chop_rate
    close: BoolArray = leg.residual <= RESIDUAL_PX * setup.pixel + jitter
    return close


def _second_bounce(points: FloatArray, setup: Setup) -> Rejection:
    """Tell whether the sphere came back to the surface, by the first dashes of its rebound."""
    first = points[: setup.instrument.least_dashes]
    leg = to_surface(fit_path(first, setup.chop_rate, gravity), setup, outward=True)
    normal = to_target(leg.contact_velocity, setup)[1]
    back = leg.contact + 2.0 * normal / (gravity * np.sin(np.radians(setup.angle)))
    return SECOND_BOUNCE if back * setup.chop_rate < len(points) else IRREGULAR
