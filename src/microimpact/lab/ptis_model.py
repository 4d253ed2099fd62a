"""Errors of trajectory imaging without its frames.

Which dashes a leg has follows from the geometry of the exposure, as in a frame; the velocities are
those that the reduction finds from exact centroids, with the spread that noise of the centroids
and jitter of the pulses give through the normal equations of the fit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from microimpact.arrays import BoolArray, FloatArray
from microimpact.lab.events import Impacts, IntArray
from microimpact.lab.exposure import INCIDENT, LATER, REBOUND, Exposure, expose
from microimpact.lab.ptis import Setup, Systematics, draw_systematics, event_generator
from microimpact.lab.ptis_observation import (
    CAPTURED,
    UNMEASURABLE,
    Observation,
    observation,
    unseen,
)
from microimpact.lab.track_fit import Rejection, Track, reduce_legs, to_target, velocity_weights
from microimpact.lab.tracks import (
    LEAST_BRIGHTNESS,
    SINGLE,
    SMOOTHING_PX,
    SURFACE_PX,
    WINGS_PX,
    longest_run,
    told_apart,
)

# What is seen of a dash, as measured on frames: how far its light reaches beyond the sharp edge of
# the disk, in blurs; how much of the radius is too faint at its ends, which only a part of the
# disk reaches; and how close (px) the light of two dashes runs together.
EDGE = 0.72
FAINT_END = 0.45
JOINED_PX = 2.0
# Noise of centroids over its theory, as measured on frames.
CENTROID_NOISE = 1.15
# Points of each dash between which distances are taken.
POINTS = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class Expected:
    """What the reduction gives for one event on average, and its spread.

    Attributes
    ----------
    velocities
        Incident and rebound (rows), tangential and normal, m/s.
    covariance
        Of tangential and normal velocity, (m/s)^2, per leg, shape (2, 2, 2).
    dashes
        Used in each leg.
    """

    velocities: FloatArray
    covariance: FloatArray
    dashes: tuple[int, int]


def modelled(
    impacts: Impacts,
    setup: Setup,
    rng: Generator,
    *,
    first: int = 0,
    errors: Systematics | None = None,
) -> Observation:
    """Return what `ptis_observation.observe` would, without rendering frames.

    The same generator gives an event the same field and the same pulses, apart from their jitter.

    Parameters
    ----------
    impacts, setup, rng, first, errors
        As in `ptis_observation.observe`.
    """
    errors = errors or draw_systematics(setup.instrument, rng)
    outcomes: list[FloatArray | str] = []
    for i in range(len(impacts)):
        draws = event_generator(rng, first + i)
        found = expected(impacts, i, setup, errors, draws)
        if isinstance(found, Expected):
            normal = draws.standard_normal((2, 2, 1))
            spread = np.linalg.cholesky(found.covariance) @ normal
            outcomes.append(found.velocities + spread[..., 0])
        else:
            outcomes.append(found)
    return observation(outcomes)


def expected(
    impacts: Impacts, i: int, setup: Setup, errors: Systematics, rng: Generator
) -> Expected | str:
    """Return mean and spread of what is measured of one event, or why nothing is.

    Parameters
    ----------
    impacts, i
        The impacts and which of them.
    setup, errors
        The instrument as set and the errors of the experiment.
    rng
        Of the event; see `ptis.event_generator`.
    """
    if impacts.captured[i]:
        return CAPTURED
    exposure = expose(impacts, i, setup, errors, rng, jitter=False)
    reason = unseen(exposure, setup)
    if reason:
        return reason
    disk = float(impacts.diameter[i]) / setup.pixel
    dashes = _Dashes.of(exposure, disk, setup, errors)
    runs = [dashes.run(leg) for leg in (INCIDENT, REBOUND)]
    if min(run.size for run in runs) < setup.instrument.least_dashes:
        return UNMEASURABLE
    places = [dashes.centre[run] for run in runs]
    if not told_apart(places[1]):
        return UNMEASURABLE
    track = reduce_legs(places[0], places[1], setup)
    if isinstance(track, Rejection):
        return UNMEASURABLE
    along, across = _centroid_variance(dashes, runs, exposure.peak, disk, setup)
    return Expected(
        velocities=track.velocities,
        covariance=_velocity_covariance(track, along, across, setup),
        dashes=(runs[0].size, runs[1].size),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Dashes:
    """Dashes of one exposure in the frame: what `tracks` would find.

    Attributes
    ----------
    leg, centre, length
        Which leg each belongs to, centroid (columns and rows, (m, 2)) and way of the centre, px.
    good
        True where it is found whole and by itself.
    """

    leg: IntArray
    centre: FloatArray
    length: FloatArray
    good: BoolArray

    @classmethod
    def of(cls, exposure: Exposure, disk: float, setup: Setup, errors: Systematics) -> _Dashes:
        start = np.maximum(exposure.start, exposure.field[0])
        end = np.minimum(exposure.end, exposure.field[1])
        shown = (end > start) & exposure.in_view
        start, end, leg = start[shown], end[shown], exposure.leg[shown]
        ends = [exposure.flight.at(leg, time) for time in (start, end)]
        length = np.linalg.norm(ends[1] - ends[0], axis=1) / setup.pixel
        trim = np.minimum(0.5, FAINT_END * 0.5 * disk / np.maximum(length, 1e-12))[:, None]
        share = trim + (1.0 - 2.0 * trim) * np.linspace(0.0, 1.0, POINTS)
        time = start[:, None] + (end - start)[:, None] * share
        path = setup.columns_rows(exposure.flight.at(leg[:, None], time), errors)
        # The mean over a dash lies off its middle by what gravity bends it.
        middle = exposure.flight.at(leg, 0.5 * (start + end))
        middle = middle + exposure.flight.gravity * ((end - start) ** 2)[:, None] / 24.0
        centre = setup.columns_rows(middle, errors)
        light = (end - start) * setup.chop_rate / setup.instrument.duty
        edge = 0.5 * disk + EDGE * np.hypot(setup.instrument.blur_px, SMOOTHING_PX)
        height = setup.height(path)
        lowest, height = height.min(axis=1) - edge, height.mean(axis=1)
        whole = (exposure.whole & exposure.in_sheet & exposure.in_field)[shown]
        good = whole & _alone(path, light, height, lowest, edge)
        bright = _density(length, disk, setup)
        good &= bright > LEAST_BRIGHTNESS * bright[leg < LATER].max(initial=0.0)
        return cls(leg=leg, centre=centre, length=length, good=good)

    def run(self, leg: int) -> IntArray:
        """Return the longest stretch of good dashes of a leg."""
        mine = np.flatnonzero(self.leg == leg)
        return mine[longest_run(self.good[mine])]


def _alone(
    path: FloatArray, light: FloatArray, height: FloatArray, lowest: FloatArray, edge: float
) -> BoolArray:
    """Tell which dashes make a spot of their own, above all that run together.

    As in `tracks`, spots that touch the surface do not count.
    """
    gap = path[:, None, :, None] - path[None, :, None, :]
    near = np.hypot(gap[..., 0], gap[..., 1]).min(axis=(2, 3)) < 2.0 * edge + JOINED_PX
    n, spot = connected_components(csr_array(near), directed=False)
    whole = np.bincount(spot, light, minlength=n)
    centre = np.bincount(spot, light * height, minlength=n) / whole
    bottom = np.full(n, np.inf)
    np.minimum.at(bottom, spot, lowest)
    clear = bottom > SURFACE_PX
    merged = clear & (whole > SINGLE)
    alone: BoolArray = (clear & ~merged)[spot]
    alone &= height > centre[merged].max(initial=-np.inf)
    return alone


def _density(length: FloatArray, disk: float, setup: Setup) -> FloatArray:
    """Return the brightest light per pixel of dashes of unit light, near enough.

    A disk at rest spreads over the square of its mean chord, pi d/4, which blur widens; a moving
    one over that chord times its way.
    """
    chord = np.hypot(0.25 * np.pi * disk, np.sqrt(2.0 * np.pi) * setup.instrument.blur_px)
    density: FloatArray = 1.0 / (chord * np.hypot(chord, length))
    return density


def _centroid_variance(
    dashes: _Dashes, runs: list[IntArray], peak: float, disk: float, setup: Setup
) -> tuple[FloatArray, FloatArray]:
    """Return the variance of centroids along and across the dashes of each leg, px^2, (2,).

    Noise of n pixels over the spot moves a centroid by their noise times their distance, over the
    light of the dash.
    """
    instrument = setup.instrument
    length = np.array([dashes.length[run].mean() for run in runs])
    density = _density(length, disk, setup)
    light = peak / density.max()
    signal = 0.5 * light * density
    noise = instrument.read_noise_counts**2 + 1.0 / 12.0
    noise = noise + (signal + instrument.background_counts) / instrument.electrons_per_count
    noise = noise * (2.0 if instrument.interlace else 1.0)
    wide = disk + 2.0 * (EDGE * np.hypot(instrument.blur_px, SMOOTHING_PX) + WINGS_PX)
    long = length + wide - FAINT_END * disk
    per_square = CENTROID_NOISE**2 * noise * long * wide / (12.0 * light**2)
    return per_square * long**2, per_square * wide**2


def _velocity_covariance(
    track: Track, along: FloatArray, across: FloatArray, setup: Setup
) -> FloatArray:
    """Return the covariance of tangential and normal velocity per leg, (2, 2, 2).

    Jitter moves a dash along its own direction, which gravity turns.
    """
    jitter = setup.instrument.jitter / setup.chop_rate
    covariance = []
    for k, leg in enumerate((track.incident, track.rebound)):
        time = np.arange(len(leg.points)) / setup.chop_rate
        velocity = leg.velocity - np.array([0.0, leg.gravity]) * time[:, None]
        velocity = to_target(velocity, setup)
        direction = velocity / np.linalg.norm(velocity, axis=1)[:, None]
        aside = np.stack([-direction[:, 1], direction[:, 0]], axis=1)
        weights = velocity_weights(len(leg.points), setup.chop_rate)[:, None]
        moves = np.concatenate(
            [
                weights * jitter * velocity,
                weights * np.sqrt(along[k]) * setup.pixel * direction,
                weights * np.sqrt(across[k]) * setup.pixel * aside,
            ]
        )
        covariance.append(moves.T @ moves)
    return np.array(covariance)
