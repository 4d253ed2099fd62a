"""Error model of trajectory imaging: the reduced velocities, without drawing the frames.

Which dashes a leg has follows from the geometry of the exposure, as in a frame: those that make a
spot of their own, whole and by themselves. The velocities are those that the reduction finds from
exact centroids, with the spread that noise of the centroids and jitter of the pulses give through
the normal equations of the fit. The tests hold the model against rendered frames. All
events of an experiment are treated together, and none depends on the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from microimpact.core.arrays import BoolArray, Columns, FloatArray
from microimpact.core.compiled import jit
from microimpact.lab.events import Impacts, IntArray
from microimpact.lab.ptis.exposure import (
    INCIDENT,
    LATER,
    LEGS,
    MEASURED,
    REBOUND,
    UNMEASURABLE,
    Exposure,
    exposures,
    unseen,
)
from microimpact.lab.ptis.system import Setup, Systematics
from microimpact.lab.ptis.tracks import (
    LEAST_BRIGHTNESS,
    SINGLE,
    SMOOTHING_PX,
    SURFACE_PX,
    WINGS_PX,
    Leg,
    fit_track,
    longest_runs,
    smooth,
    to_target,
    told_apart,
)

# What is seen of a dash, as measured on frames: how far its light reaches beyond the sharp edge of
# the disk, in blurs; how much of the radius is too faint at its ends, which only a part of the
# disk reaches; how close (px) the light of two dashes runs together; and the noise of centroids
# over its theory.
EDGE = 0.72
FAINT_END = 0.45
JOINED_PX = 2.0
CENTROID_NOISE = 1.15
# Points of each dash between which distances are taken.
POINTS = 5

_jit = jit()


@dataclass(frozen=True, slots=True, kw_only=True)
class Expected:
    """Mean and covariance of the reduced velocities of k events.

    Attributes
    ----------
    velocities
        Incident and rebound (rows), tangential and normal, m/s, shape (k, 2, 2).
    covariance
        Of tangential and normal velocity, (m/s)^2, per leg, shape (k, 2, 2, 2).
    dashes
        Used in each leg, shape (k, 2).
    """

    velocities: FloatArray
    covariance: FloatArray
    dashes: IntArray


def theory(
    impacts: Impacts, setup: Setup, errors: Systematics, rngs: Sequence[Generator]
) -> tuple[NDArray[np.object_], Expected]:
    """Return the fates of rebounding impacts, with mean and spread of their velocities.

    The fates are `MEASURED` or why not, one per impact; the rest is of those that are measured.

    Parameters
    ----------
    impacts
        Impacts of n spheres.
    setup
        Imaging system, with angle, speed and diameter for which it is set.
    errors
        Systematic errors of the experiment.
    rngs
        A generator for each impact, or the same for all, which draw from it in turn.
    """
    exposure = exposures(impacts, setup, errors, rngs, jitter=False)
    fates = unseen(exposure, setup)
    seen = np.flatnonzero(fates == "")
    fates[seen] = UNMEASURABLE
    disk = exposure.diameter[seen] / setup.pixel
    rows = longest_rows(exposure.select(seen), setup, errors)
    enough = np.minimum(rows[0].number, rows[1].number) >= setup.instrument.least_dashes
    clear = np.flatnonzero(enough & told_apart(rows[1].places, rows[1].used))
    rows = [row.select(clear) for row in rows]
    track = fit_track(rows[0].places, rows[1].places, setup, used=(rows[0].used, rows[1].used))
    flown = smooth(track.incident, setup) & smooth(track.rebound, setup) & track.meets_surface
    measured = seen[clear]
    variance = _centroid_variance(rows, exposure.peak[measured], disk[clear], setup)
    legs = track.incident, track.rebound
    covariance = [
        _velocity_covariance(leg, *of, setup) for leg, of in zip(legs, variance, strict=True)
    ]
    fates[measured[flown]] = MEASURED
    return fates, Expected(
        velocities=track.velocities[flown],
        covariance=np.stack(covariance, axis=1)[flown],
        dashes=np.stack([row.number for row in rows], axis=1)[flown],
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Rows(Columns):
    """The longest row of dashes that are found whole, of one leg of each of n exposures.

    Attributes
    ----------
    places
        Columns and rows in order of time, shape (n, k, 2); zero beyond the end of a row.
    used
        True up to the end of a row, shape (n, k).
    number, length
        Of the dashes, and their mean way, px, shape (n,).
    """

    places: FloatArray
    used: BoolArray
    number: IntArray
    length: FloatArray


def longest_rows(exposure: Exposure, setup: Setup, errors: Systematics) -> list[Rows]:
    """Return the rows of the legs `INCIDENT` and `REBOUND` of n exposures without jitter.

    Parameters
    ----------
    exposure
        Lit pieces of n events.
    setup
        Imaging system as it is set.
    errors
        Systematic errors of the experiment.
    """
    shown, start, end = exposure.dashes()
    order = np.argsort(exposure.leg[shown], kind="stable")
    order = order[exposure.in_view[shown[order]]]
    shown, start, end = shown[order], start[order], end[order]
    event, leg, flight = exposure.event[shown], exposure.leg[shown], exposure.flight
    size = exposure.diameter[event] / setup.pixel
    edge = 0.5 * size + outline(setup)
    length = np.linalg.norm(flight.at(leg, end) - flight.at(leg, start), axis=1) / setup.pixel
    trim = np.minimum(0.5, FAINT_END * 0.5 * size / np.maximum(length, 1e-12))[:, None]
    share = trim + (1.0 - 2.0 * trim) * np.linspace(0.0, 1.0, POINTS)
    time = start[:, None] + (end - start)[:, None] * share
    path = exposure.places(shown, time, setup, errors)
    # The mean over a dash lies off its middle by what gravity bends it.
    middle = flight.at(leg, 0.5 * (start + end))
    middle = middle + flight.gravity * ((end - start) ** 2)[:, None] / 24.0
    light = (end - start) * setup.chop_rate / setup.instrument.duty
    whole = (exposure.whole & exposure.in_sheet & exposure.in_field)[shown]
    bright = brightness(length, size, setup)
    brightest = np.zeros(len(exposure))
    np.maximum.at(brightest, event, np.where(leg % LEGS < LATER, bright, 0.0))
    good = whole & _alone(event, path, light, setup.height(path), edge)
    good &= bright > LEAST_BRIGHTNESS * brightest[event]
    runs = longest_runs(good, leg, LEGS * len(exposure))
    centre = setup.columns_rows(middle, errors)
    return [_row(centre, length, *(of[own::LEGS] for of in runs)) for own in (INCIDENT, REBOUND)]


def _alone(
    event: IntArray, path: FloatArray, light: FloatArray, height: FloatArray, edge: FloatArray
) -> BoolArray:
    """Tell which dashes make a spot of their own, above all that run together.

    As in `sort_legs`, spots that touch the surface do not count.
    """
    alone = np.empty(len(event), dtype=np.bool_)
    ends = np.flatnonzero(np.diff(event, append=-1)) + 1
    middle = path[:, POINTS // 2]
    # No point of a dash is farther from its middle one than its reach.
    near = edge + 0.5 * JOINED_PX
    reach = np.linalg.norm(path - middle[:, None], axis=2).max(axis=1) + near
    lowest = height.min(axis=1) - edge
    least = SURFACE_PX, SINGLE
    _sort(ends, path, reach, near, light, height.mean(axis=1), lowest, least, alone)
    return alone


@_jit
def _sort(  # type: ignore[no-untyped-def]
    ends, path, reach, near, light, level, lowest, least, alone
):
    """Write which dashes are `_alone`; those of an event end where those of the next begin."""
    spot = np.arange(alone.size)  # by the number of its first dash
    whole, centre, bottom = np.zeros((3, alone.size))
    surface, several = least
    begin = np.int64(0)  # a plain 0 has `_join` compiled for it alone
    for end in ends:
        _join(spot[begin:end], begin, path, reach, near)
        crowded = -np.inf
        for i in range(begin, end):
            number = spot[i]
            whole[number] += light[i]
            centre[number] += light[i] * level[i]
            bottom[number] = min(bottom[number], lowest[i]) if number < i else lowest[i]
        for i in range(begin, end):
            number = spot[i]
            if bottom[number] > surface and whole[number] > several:
                crowded = max(crowded, centre[number] / whole[number])
        for i in range(begin, end):
            number = spot[i]
            single = bottom[number] > surface and not whole[number] > several
            alone[i] = single and level[i] > crowded
        begin = end


@_jit
def _join(spot, begin, path, reach, near):  # type: ignore[no-untyped-def]
    """Give the dashes of an event that run together, from ``begin`` on, the number of the first."""
    for i in range(spot.size):
        for j in range(i + 1, spot.size):
            first, second = min(spot[i], spot[j]), max(spot[i], spot[j])
            if first < second and _together(begin + i, begin + j, path, reach, near):
                for k in range(spot.size):
                    if spot[k] == second:
                        spot[k] = first


@_jit
def _together(i, j, path, reach, near):  # type: ignore[no-untyped-def]
    """Tell whether the light of two dashes runs together."""
    middle = POINTS // 2
    x, y = path[i, middle, 0] - path[j, middle, 0], path[i, middle, 1] - path[j, middle, 1]
    if x * x + y * y > (reach[i] + reach[j]) ** 2:
        return False
    least = np.inf
    for a in range(POINTS):
        for b in range(POINTS):
            x, y = path[i, a, 0] - path[j, b, 0], path[i, a, 1] - path[j, b, 1]
            least = min(least, x * x + y * y)
    return least < (near[i] + near[j]) ** 2


def _row(centre: FloatArray, length: FloatArray, start: IntArray, number: IntArray) -> Rows:
    """Return the rows of one leg among dashes, from the first of each on."""
    position = np.arange(max(2, number.max(initial=0)))
    used = position < number[:, None]
    index = np.where(used, start[:, None] + position, 0)
    if not len(centre):  # nothing that the unused index 0 could mean
        centre, length = np.zeros((1, 2)), np.zeros(1)
    total = np.bincount(np.nonzero(used)[0], length[index[used]], minlength=len(number))
    return Rows(
        places=np.where(used[..., None], centre[index], 0.0),
        used=used,
        number=number,
        length=total / np.maximum(number, 1),
    )


def outline(setup: Setup) -> float:
    """Return how far the light of a sphere reaches beyond its disk, px."""
    return float(EDGE * np.hypot(setup.instrument.blur_px, SMOOTHING_PX))


def brightness(length: FloatArray, disk: FloatArray, setup: Setup) -> FloatArray:
    """Return the brightest light per pixel of dashes of unit light, near enough.

    Disk and blur add in squares.

    Parameters
    ----------
    length, disk
        Way of the centre and diameter of the disk, px; they broadcast.
    setup
        Imaging system as it is set.
    """
    chord = np.hypot(0.25 * np.pi * disk, np.sqrt(2.0 * np.pi) * setup.instrument.blur_px)
    light: FloatArray = 1.0 / (chord * np.hypot(chord, length))
    return light


def _centroid_variance(
    rows: list[Rows], peak: FloatArray, disk: FloatArray, setup: Setup
) -> list[tuple[FloatArray, FloatArray]]:
    """Return the variance of centroids along and across the dashes of each leg, px^2, (k,).

    Noise of n pixels over the spot moves a centroid by their noise times their distance, over the
    light of the dash.
    """
    instrument = setup.instrument
    least = instrument.read_noise_counts**2 + 1.0 / 12.0
    density = [brightness(row.length, disk, setup) for row in rows]
    light = peak / np.maximum(*density)
    wide = disk + 2.0 * (outline(setup) + WINGS_PX)
    variances = []
    for row, bright in zip(rows, density, strict=True):
        signal = 0.5 * light * bright
        shot = (signal + instrument.background_counts) / instrument.electrons_per_count
        noise = least + shot
        long = row.length + wide - FAINT_END * disk
        per_square = CENTROID_NOISE**2 * noise * long * wide / (12.0 * light**2)
        variances.append((per_square * long**2, per_square * wide**2))
    return variances


def _velocity_covariance(
    leg: Leg, along: FloatArray, across: FloatArray, setup: Setup
) -> FloatArray:
    """Return the covariance of tangential and normal velocity of k legs, (k, 2, 2).

    Jitter moves a dash along its own direction, which gravity turns.
    """
    jitter = setup.instrument.jitter / setup.chop_rate
    time = np.arange(leg.points.shape[-2]) / setup.chop_rate
    fall = np.array([0.0, leg.gravity]) * time[:, None]
    velocity = to_target(leg.velocity[:, None] - fall, setup)
    direction = velocity / np.linalg.norm(velocity, axis=-1, keepdims=True)
    aside = np.stack([-direction[..., 1], direction[..., 0]], axis=-1)
    noise = [np.sqrt(of)[:, None, None] * setup.pixel for of in (along, across)]
    each = [jitter * velocity, noise[0] * direction, noise[1] * aside]
    moves = np.concatenate([leg.weights[..., None] * one for one in each], axis=1)
    # Summed dash by dash, so that those of other events, which lengthen the arrays, do not matter.
    covariance: FloatArray = np.sum(moves[..., None] * moves[..., None, :], axis=1)
    return covariance
