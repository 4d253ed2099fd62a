"""Measurement of a frame: spots, the two legs of a track, velocities at the surface (Section 2.1).

Dashes are found by their light, and their centroids are used, never their ends: the size of the
sphere lengthens a dash by its diameter and leaves its centroid alone.

Each leg is fitted, in the laboratory's horizontal and vertical, by a path under known gravity, and
followed to the instant at which the centre of the sphere is half a diameter from the known line of
the surface. Dash k of a leg is taken to be lit at k over the nominal rate of the chopper.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.constants import gravity
from microimpact.lab.events import IntArray
from microimpact.lab.ptis.frames import BRIGHTEST
from microimpact.lab.ptis.system import Setup

# A frame is smoothed by a Gaussian of this width (px), cut off at this many widths.
SMOOTHING_PX = 1.0
SMOOTHING_REACH = 3.0
# Light of a dash exceeds this many deviations of the smoothed noise, and this share of the
# brightest spot.
DETECTION = 6.0
LEAST_BRIGHTNESS = 0.1
# Spots are widened by this much to hold the light of their wings.
WINGS_PX = 2
# Light this close to the line of the surface (px) may be that of a dash bent by the impact.
SURFACE_PX = 2.0
# Every fourth row is enough for the levels: 77,000 pixels.
EVERY = 4
# A spot with more of its pixels than this at the end of the scale is saturated.
MOST_SATURATED = 0.2
# Relative to the median: how far the light of a whole dash may be off that of its leg, how much
# light is that of more than one dash, and how far dashes may be off that lead to the incident row.
WHOLE = 0.05
SINGLE = 1.3
ALIKE = 0.5
# Incident tracks lie within this tangent of the vertical, and their dashes on a line to this (px).
STEEP = math.tan(math.radians(5.0))
STRAIGHT_PX = 1.5
# Consecutive dashes must move on sideways by this much to be put in order.
LEAST_STEP_PX = 1.0
# A leg whose dashes lie off a path under gravity by more than this (rms) is no single flight.
RESIDUAL_PX = 0.5


def measure(frame: NDArray[np.uint8], setup: Setup) -> Track | None:
    """Return the track of one frame, or None if it cannot be measured."""
    legs = sort_legs(find_spots(frame, setup), setup)
    return reduce_legs(*legs, setup) if legs else None


@dataclass(frozen=True, slots=True, kw_only=True)
class Spots:
    """Connected patches of light in a frame, n of them.

    Attributes
    ----------
    centroid
        Centroid, column and row, shape (n, 2).
    light
        Counts above the background.
    height
        Of the centroid above the line of the surface, px.
    clear
        False where a spot touches the line of the surface or the edge of the frame.
    saturated
        True where the camera's scale ends.
    """

    centroid: FloatArray
    light: FloatArray
    height: FloatArray
    clear: BoolArray
    saturated: BoolArray


def find_spots(frame: NDArray[np.uint8], setup: Setup) -> Spots:
    """Find the patches of light in a frame."""
    levels = np.cumsum(np.bincount(frame[::EVERY].ravel()))
    # Most of a frame is dark: its median is the background, its lower half gives the noise.
    low, background = np.searchsorted(levels, levels[-1] * np.array([0.1587, 0.5])).astype(float)
    noise = max(background - low, 1.0) / (2.0 * np.sqrt(np.pi) * SMOOTHING_PX)
    row, column, patch, core = patches(frame, background, DETECTION * noise)
    # Patches anew by number, without those that the wings of others hide.
    numbers = np.cumsum(np.bincount(patch) > 0)
    spot = numbers[patch] - 1

    def total(values: NDArray[np.float64 | np.bool_]) -> FloatArray:
        sums: FloatArray = np.bincount(spot, values, numbers.max(initial=0)).astype(float)
        return sums

    # Wings below the threshold count too: cut off, they would draw centroids to pixel centres.
    grey = frame[row, column]
    weight = grey - background
    light = total(weight)
    points = np.stack([column, row], axis=-1).astype(float)
    centroid = np.stack([total(weight * of) for of in points.T], axis=-1) / light[:, None]
    height, width = frame.shape
    edge = (row == 0) | (row == height - 1) | (column == 0) | (column == width - 1)
    near = core & (edge | (setup.height(points) < SURFACE_PX))
    return Spots(
        centroid=centroid,
        light=light,
        height=setup.height(centroid),
        clear=total(near) == 0,
        saturated=total(grey == BRIGHTEST) > MOST_SATURATED * total(core),
    )


def patches(
    frame: NDArray[np.uint8], background: float, least: float
) -> tuple[IntArray, IntArray, IntArray, BoolArray]:
    """Return the pixels of patches of light: bright ones that touch, also by corners, with wings.

    Light must exceed the least, smoothed, and a share of the brightest. Of each pixel: row, column,
    number of the patch (where wings meet that of the later one), and whether it is bright itself.

    Parameters
    ----------
    frame
        Grey levels, (rows, columns).
    background
        Counts without light.
    least
        Light that bright pixels exceed, smoothed, in counts.
    """
    smooth = scipy.ndimage.gaussian_filter(
        frame, SMOOTHING_PX, output=np.float32, truncate=SMOOTHING_REACH / SMOOTHING_PX
    )
    smooth -= background
    bright = smooth > max(least, LEAST_BRIGHTNESS * float(smooth.max()))
    # The part of the frame that holds all of them.
    lit = [np.flatnonzero(bright.any(axis=axis)) for axis in (1, 0)]
    ends = [(max(of[0] - WINGS_PX, 0), of[-1] + WINGS_PX + 1) if of.size else (0, 0) for of in lit]
    box = slice(*ends[0]), slice(*ends[1])
    patch, _ = scipy.ndimage.label(bright[box], np.ones((3, 3)))
    patch = scipy.ndimage.maximum_filter(patch, 2 * WINGS_PX + 1)
    row, column = np.nonzero(patch)
    number = patch[row, column].astype(np.int64)
    return row + box[0].start, column + box[1].start, number, bright[box][row, column]


def sort_legs(spots: Spots, setup: Setup) -> tuple[FloatArray, FloatArray] | None:
    """Sort spots into the incident and the rebound leg, whole dashes alone.

    Spheres fall: the incident leg is the longest steep row of spots. The rest is the rebound,
    whose horizontal velocity is constant and gives its order. Legs are columns and rows (m, 2);
    None if either has too few.
    """
    centroid, light, clear = spots.centroid, spots.light, spots.clear
    least = setup.instrument.least_dashes
    if not np.any(clear):
        return None
    # Up to some height dashes run together, and may not be told apart.
    merged = clear & (light > SINGLE * np.median(light[clear]))
    usable = clear & ~spots.saturated & (spots.height > spots.height[merged].max(initial=-np.inf))
    if np.sum(usable) < 2 * least:
        return None
    alike = usable & (np.abs(light / np.median(light[usable]) - 1.0) < ALIKE)
    on_line = steep_row(centroid, alike)
    incident = _longest_run(centroid[:, 1], light, usable, on_line)
    if len(incident) < least:
        return None
    rebound = _longest_run(centroid[:, 0], light, usable, ~on_line)
    if len(rebound) < least or not told_apart(centroid[rebound]):
        return None
    first, last = np.abs(centroid[rebound[[0, -1]], 0] - centroid[incident[-1], 0])
    return centroid[incident], centroid[rebound if first <= last else rebound[::-1]]


def steep_row(centroid: FloatArray, alike: BoolArray) -> BoolArray:
    """Tell which spots lie on the steep line through two that passes most that are alike.

    Of lines with as many, the one they lie closest to; no spot if no two make a steep line.
    """
    pairs = np.triu_indices(int(alike.sum()), 1)
    start, end = (centroid[alike][of] for of in pairs)
    way = end - start
    start, way = start[is_steep(way)], way[is_steep(way)]
    if not len(way):
        return np.zeros(len(centroid), dtype=bool)
    slope = (way[:, 0] / way[:, 1])[:, None]
    x, y = centroid.T
    off = np.abs(x - start[:, :1] - slope * (y - start[:, 1:]))
    near = off < STRAIGHT_PX
    counted = near & alike
    best = np.lexsort((np.sum(off * counted, axis=1), -counted.sum(axis=1)))[0]
    row: BoolArray = near[best]
    return row


def _longest_run(
    along: FloatArray, light: FloatArray, usable: BoolArray, mine: BoolArray
) -> IntArray:
    """Return the longest row of dashes of a leg, in order, that have the light of a whole pulse."""
    order = np.flatnonzero(mine)
    order = order[np.argsort(along[order])]
    if not np.any(usable[order]):
        return order[:0]
    whole = np.median(light[order][usable[order]])
    good = usable[order] & (np.abs(light[order] / whole - 1.0) < WHOLE)
    start, number = longest_runs(good, np.zeros(len(good), dtype=np.int64), 1)
    return order[start[0] : start[0] + number[0]]


def is_steep(way: FloatArray) -> BoolArray:
    """Tell which ways, columns and rows (..., 2), are as steep as an incident track."""
    steep: BoolArray = np.abs(way[..., 0]) < STEEP * np.abs(way[..., 1])
    return steep


def told_apart(rebound: FloatArray, used: BoolArray | None = None) -> BoolArray:
    """Tell whether a rebound is no second incident track and its dashes have an order.

    Of columns and rows (..., m, 2) the first ones count, two or more, as ``used`` (..., m) says.
    """
    used = np.ones(rebound.shape[:-1], dtype=bool) if used is None else used
    last = (np.sum(used, axis=-1) - 1)[..., None, None]
    way = np.take_along_axis(rebound, last, axis=-2)[..., 0, :] - rebound[..., 0, :]
    step = np.where(used[..., 1:], np.abs(np.diff(rebound[..., 0], axis=-1)), np.inf)
    apart: BoolArray = ~is_steep(way) & (step.min(axis=-1) >= LEAST_STEP_PX)
    return apart


def longest_runs(good: BoolArray, group: IntArray, groups: int) -> tuple[IntArray, IntArray]:
    """Return where the longest stretch of true values within each group begins, and its length.

    Of several longest stretches the first; zeros where there is none.

    Parameters
    ----------
    good
        Values, (n,).
    group
        Group of each value, ascending, (n,).
    groups
        Number of groups.
    """
    follows = np.zeros_like(good)
    follows[1:] = good[:-1] & (group[1:] == group[:-1])
    begin = np.flatnonzero(good & ~follows)
    length = np.bincount(np.cumsum(good & ~follows)[good] - 1, minlength=len(begin))
    order = np.lexsort((begin, -length, group[begin]))
    run_groups, first = np.unique(group[begin][order], return_index=True)
    start, number = np.zeros((2, groups), dtype=np.int64)
    start[run_groups], number[run_groups] = begin[order[first]], length[order[first]]
    return start, number


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
        Of the path at the time 0, that of the first dash, m and m/s, shape (..., 2).
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

    @property
    def meets_surface(self) -> BoolArray:
        """True where one leg comes to the surface and the other leaves it."""
        normal = self.velocities[..., 1]
        meets: BoolArray = (normal[..., 0] < 0.0) & (normal[..., 1] > 0.0)
        return meets


def reduce_legs(
    incident: FloatArray, rebound: FloatArray, setup: Setup, *, with_gravity: bool = True
) -> Track | None:
    """Return the velocities at the surface from the dashes of both legs; None if they do not fit.

    Parameters
    ----------
    incident, rebound
        Columns and rows of the dashes of each leg, px, (m, 2).
    setup
        Imaging system as it is set.
    with_gravity
        Whether paths are those under gravity, not straight lines at constant speed.
    """
    track = fit_track(incident, rebound, setup, with_gravity=with_gravity)
    legs = track.incident, track.rebound
    single = not with_gravity or all(smooth(leg, setup) for leg in legs)
    return track if single and track.meets_surface else None


def fit_track(
    incident: FloatArray,
    rebound: FloatArray,
    setup: Setup,
    *,
    used: tuple[BoolArray | None, BoolArray | None] = (None, None),
    with_gravity: bool = True,
) -> Track:
    """Fit both legs and follow them to the surface, whether they make a track or not.

    Parameters
    ----------
    incident, rebound
        Columns and rows of the dashes of each leg, px, (..., m, 2).
    setup
        Imaging system as it is set.
    used
        Which dashes of each leg count, its first ones, (..., m); all if None.
    with_gravity
        Whether paths are those under gravity, not straight lines at constant speed.
    """
    pull = gravity if with_gravity else 0.0
    legs = []
    for places, count, outward in ((incident, used[0], False), (rebound, used[1], True)):
        points = (places - setup.centre) * [setup.pixel, -setup.pixel]
        leg = fit_path(points, np.arange(points.shape[-2]) / setup.chop_rate, pull, count)
        legs.append(to_surface(leg, setup, outward=outward))
    velocities = np.stack([to_target(leg.contact_velocity, setup) for leg in legs], axis=-2)
    return Track(incident=legs[0], rebound=legs[1], velocities=velocities)


def fit_path(
    points: FloatArray, time: FloatArray, pull: float, used: BoolArray | None = None
) -> Leg:
    """Fit a leg, by least squares, with constant horizontal velocity and vertical acceleration.

    Parameters
    ----------
    points
        Points of the leg, (..., m, 2).
    time
        Of the points, s, (..., m).
    pull
        Vertical acceleration, in the unit of the points per s2.
    used
        Which points count, two or more, (..., m); all if None.
    """
    used = np.ones(points.shape[:-1], dtype=bool) if used is None else used
    # Sums run over the last axis but one, point by point: points that do not count change nothing.
    share = used / np.sum(used, axis=-1, keepdims=True)
    middle = np.sum((share * time)[..., None], axis=-2)
    away = used * (time - middle)
    weights = away / np.sum(np.square(away)[..., None], axis=-2)
    level = points + 0.5 * np.array([0.0, pull]) * time[..., None] ** 2
    velocity = np.sum(weights[..., None] * level, axis=-2)
    origin = np.sum(share[..., None] * level, axis=-2) - velocity * middle
    off = level - origin[..., None, :] - velocity[..., None, :] * time[..., None]
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
    turned: FloatArray = vectors * np.sin(alpha)
    turned[..., 0] -= vectors[..., 1] * np.cos(alpha)
    turned[..., 1] += vectors[..., 0] * np.cos(alpha)
    return turned


def to_surface(leg: Leg, setup: Setup, *, outward: bool) -> Leg:
    """Return a leg with the time of contact; not a number where its path misses the surface.

    Of the two roots of the height above the surface, the one at which the sphere comes or leaves,
    in the form that does not cancel.

    Parameters
    ----------
    leg
        Fitted leg.
    setup
        Imaging system as it is set.
    outward
        Whether the sphere leaves the surface.
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
