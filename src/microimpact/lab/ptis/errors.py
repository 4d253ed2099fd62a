"""Errors of trajectory imaging without its frames.

Which dashes a leg has follows from the geometry of the exposure, as in a frame; the velocities are
those that the reduction finds from exact centroids, with the spread that noise of the centroids
and jitter of the pulses give through the normal equations of the fit. All events of an experiment
are treated together; each has its own generator, so that none depends on the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from microimpact.core.arrays import FloatArray
from microimpact.lab.events import Impacts, IntArray
from microimpact.lab.ptis.dashes import (
    FAINT_END,
    Rows,
    brightness,
    find_dashes,
    longest_rows,
    outline,
)
from microimpact.lab.ptis.exposure import INCIDENT, REBOUND, exposures
from microimpact.lab.ptis.observation import (
    CAPTURED,
    MEASURED,
    UNMEASURABLE,
    Observation,
    observation,
    unseen,
)
from microimpact.lab.ptis.spots import WINGS_PX
from microimpact.lab.ptis.system import Setup, Systematics, draw_systematics, event_generator
from microimpact.lab.ptis.track_fit import Leg, fit_track, smooth, to_target
from microimpact.lab.ptis.tracks import told_apart

# Noise of centroids over its theory, as measured on frames.
CENTROID_NOISE = 1.15


@dataclass(frozen=True, slots=True, kw_only=True)
class Expected:
    """What the reduction gives on average, and its spread: for one event, or k of them.

    Attributes
    ----------
    velocities
        Incident and rebound (rows), tangential and normal, m/s, shape (..., 2, 2).
    covariance
        Of tangential and normal velocity, (m/s)^2, per leg, shape (..., 2, 2, 2).
    dashes
        Used in each leg, shape (..., 2).
    """

    velocities: FloatArray
    covariance: FloatArray
    dashes: IntArray


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
    moving = np.flatnonzero(~impacts.captured)
    draws = [event_generator(rng, first + i) for i in moving.tolist()]
    reasons, found = theory(impacts.select(moving), setup, errors, draws)
    fates = np.full(len(impacts), CAPTURED, dtype=object)
    fates[moving] = reasons
    measured = np.flatnonzero(reasons == MEASURED)
    normal = [draws[i].standard_normal((2, 2, 1)) for i in measured.tolist()]
    spread = np.linalg.cholesky(found.covariance) @ np.reshape(normal, (-1, 2, 2, 1))
    return observation(fates, found.velocities + spread[..., 0])


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
    return expected_of_all(impacts.select(slice(i, i + 1)), setup, errors, [rng])[0]


def expected_of_all(
    impacts: Impacts, setup: Setup, errors: Systematics, rngs: Sequence[Generator]
) -> list[Expected | str]:
    """Return what is `expected` of every impact, each with its own generator."""
    moving = np.flatnonzero(~impacts.captured)
    draws = [rngs[i] for i in moving.tolist()]
    fates, found = theory(impacts.select(moving), setup, errors, draws)
    outcome: list[Expected | str] = [CAPTURED] * len(impacts)
    k = 0
    for i, fate in zip(moving.tolist(), fates, strict=True):
        outcome[i] = str(fate)
        if fate == MEASURED:
            outcome[i] = Expected(
                velocities=found.velocities[k],
                covariance=found.covariance[k],
                dashes=found.dashes[k],
            )
            k += 1
    return outcome


def theory(
    impacts: Impacts, setup: Setup, errors: Systematics, rngs: Sequence[Generator]
) -> tuple[NDArray[np.object_], Expected]:
    """Return what becomes of impacts that all rebound: mean and spread of what is measured.

    Parameters
    ----------
    impacts, setup, errors
        As in `expected`.
    rngs
        One per impact.

    Returns
    -------
    fates, found
        `MEASURED` or why not, one per impact, and those that are measured.
    """
    exposure = exposures(impacts, setup, errors, rngs, jitter=False)
    fates = unseen(exposure, setup)
    seen = np.flatnonzero(fates == "")
    fates[seen] = UNMEASURABLE
    disk = impacts.diameter[seen] / setup.pixel
    dashes = find_dashes(exposure.select(seen), disk, setup, errors)
    rows = [longest_rows(dashes, leg) for leg in (INCIDENT, REBOUND)]
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
    found = []
    for row, bright in zip(rows, density, strict=True):
        signal = 0.5 * light * bright
        shot = (signal + instrument.background_counts) / instrument.electrons_per_count
        noise = (least + shot) * (2.0 if instrument.interlace else 1.0)
        long = row.length + wide - FAINT_END * disk
        per_square = CENTROID_NOISE**2 * noise * long * wide / (12.0 * light**2)
        found.append((per_square * long**2, per_square * wide**2))
    return found


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
