"""Pairs in the records of a phase Doppler particle analyser, and reduction to the surface.

From an initial estimate of the height h of the probe volume: which rebound record is of the same
sphere as which incident record? The delay between them is known from h and both velocities, the
sphere falling and rising freely; sizes must agree. Accepted pairs give a better h, and so on.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from microimpact.core.arrays import FloatArray, Real
from microimpact.core.constants import gravity
from microimpact.lab.events import IntArray
from microimpact.lab.pdpa.analyser import Analyser, RecordStream

# With fewer pairs than this, h is left as it is: they may all be accidental.
FEWEST_PAIRS = 3
MOST_ROUNDS = 30
# Half width of the windows in which a pair is sought, in standard deviations: they lose 0.3 %.
GATE = 3.0

Form = Literal["exact", "printed"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Pairing:
    """Accepted pairs, and the height found from them.

    Attributes
    ----------
    incident, rebound
        Records of each pair, indices into the stream, in order of the incident's time; shape (k,).
    height, height_error
        Of the probe volume and its standard error, m; the initial estimate and its uncertainty
        where there are too few pairs.
    converged
        Whether the last search found the same pairs as the one before.
    """

    incident: IntArray
    rebound: IntArray
    height: float
    height_error: float
    converged: bool


def correct(velocity: Real, height: Real, form: Form = "exact") -> Real:
    """Return vertical velocities at the surface from those in the probe volume, m/s.

    Parameters
    ----------
    velocity
        Vertical velocities in the probe volume, m/s; incident ones are negative.
    height
        Of the probe volume above the surface, m.
    form
        ``exact``: by v^2 + 2 g h, the energy of free fall. ``printed``: the article's constant
        sqrt(2 g h) is added to the speed (Section 2.1).
    """
    if form == "printed":
        return np.asarray(velocity + np.sign(velocity) * _surface_speed(0.0, height))
    return np.asarray(np.sign(velocity) * _surface_speed(velocity, height))


def _surface_speed(velocity: Real, height: Real) -> FloatArray:
    return np.sqrt(np.square(velocity) + 2.0 * gravity * np.asarray(height))


def delay(incident: Real, rebound: Real, height: Real) -> Real:
    """Return the time from the incident to the rebound passage, s.

    Parameters
    ----------
    incident, rebound
        Vertical speeds in the probe volume, m/s.
    height
        Of the probe volume above the surface, m.
    """
    return _leg_time(incident, height) + _leg_time(rebound, height)


def _leg_time(velocity: Real, height: Real) -> Real:
    return np.asarray(2.0 * height / (np.abs(velocity) + _surface_speed(velocity, height)))


def height_from_delay(incident: Real, rebound: Real, time: Real) -> Real:
    """Return the height at which the `delay` of two passages is the given time: its inverse.

    Parameters
    ----------
    incident, rebound
        Vertical speeds in the probe volume, m/s.
    time
        From the incident to the rebound passage, s.
    """
    # With x = 2 g h the surface speeds have sum s and the difference of their squares is known.
    s = gravity * np.asarray(time) + np.abs(incident) + np.abs(rebound)
    at_surface = 0.5 * (s + (np.square(incident) - np.square(rebound)) / s)
    return np.asarray((np.square(at_surface) - np.square(incident)) / (2.0 * gravity))


def delay_noise(
    incident: FloatArray, rebound: FloatArray, height: Real, instrument: Analyser
) -> tuple[FloatArray, FloatArray]:
    """Return the standard deviation of predicted less recorded delays, s, and d delay / d h.

    Parameters
    ----------
    incident, rebound
        Vertical velocities recorded, m/s.
    height
        Of the probe volume above the surface, m.
    instrument
        Analyser, with its noise.
    """
    stamps = 1e-6 * instrument.time_resolution_us / np.sqrt(6.0)
    variance, slope = np.full(incident.shape, stamps**2), np.zeros(incident.shape)
    for velocity in (incident, rebound):
        at_surface = _surface_speed(velocity, height)
        # d(time)/d(velocity) = -time / surface speed, d(time)/d(height) = 1 / surface speed
        change = _leg_time(velocity, height) / at_surface
        variance += np.square(change * instrument.velocity_noise(velocity))
        slope += 1.0 / at_surface
    return np.sqrt(variance), slope


def search(stream: RecordStream, height: float, instrument: Analyser) -> Pairing:
    """Find the pairs of a stream, in any order, and the height of the probe volume.

    Parameters
    ----------
    stream
        Records of an experiment.
    height
        Initial estimate of the height, m, wrong by about ``initial_estimate_error``.
    instrument
        Analyser, with its noise.
    """
    initial = height, abs(instrument.initial_estimate_error) * height
    estimate, pairs, converged = initial, None, False
    for _ in range(MOST_ROUNDS):
        before, pairs = pairs, assign(stream, *estimate, instrument)
        if len(pairs[0]) < FEWEST_PAIRS:
            estimate = initial
            break
        converged = before is not None and np.array_equal(pairs, before)
        arguments = stream, np.stack(pairs), np.asarray(estimate[0]), instrument
        best, error = estimate_height(*arguments)
        estimate = float(best), float(error)
        if converged:
            break
    incident, rebound = pairs or (np.zeros(0, dtype=np.int64),) * 2
    return Pairing(
        incident=incident,
        rebound=rebound,
        height=estimate[0],
        height_error=estimate[1],
        converged=converged,
    )


def estimate_height(
    stream: RecordStream, pairs: IntArray, height: FloatArray, instrument: Analyser
) -> tuple[FloatArray, FloatArray]:
    """Return the height that fits the delays of some pairs, and its standard error, m.

    Least absolute deviations in units of the noise at the present height: a weighted median, which
    a few wrong pairs hardly move. Where the deviations exceed the noise, the error grows.

    Parameters
    ----------
    stream
        Records of an experiment.
    pairs
        Indices of incident and rebound, (2, pairs), or of many sets of pairs, (2, ..., pairs).
    height
        Present heights, m, (...).
    instrument
        Analyser, with its noise.
    """
    incident, rebound = stream.velocity[pairs]
    recorded = stream.time[pairs[1]] - stream.time[pairs[0]]
    noise, slope = delay_noise(incident, rebound, height[..., None], instrument)
    heights, weight = np.asarray(height_from_delay(incident, rebound, recorded)), slope / noise
    order = np.argsort(heights, axis=-1, kind="stable")
    reached = np.cumsum(np.take_along_axis(weight, order, -1), axis=-1)
    middle = np.sum(reached < 0.5 * reached[..., -1:], axis=-1, keepdims=True)
    best = np.take_along_axis(heights, np.take_along_axis(order, middle, -1), -1)
    excess = np.sqrt(np.mean(np.square((heights - best) * weight), axis=-1))
    error = np.sqrt(0.5 * np.pi / np.sum(np.square(weight), axis=-1))
    return best[..., 0], np.maximum(1.0, excess) * error


def assign(
    stream: RecordStream, height: float, height_error: float, instrument: Analyser
) -> tuple[IntArray, IntArray]:
    """Return the best one-to-one pairs at a height known to a standard error.

    A pair costs its squared deviations of size and delay, in units of the noise; as many of the
    pairs inside the windows as fit together are worth more than none (see `matched`). Pairs are
    indices of incident and rebound in the stream, in order of the incident's time.

    Parameters
    ----------
    stream
        Records of an experiment.
    height
        Of the probe volume above the surface, m.
    height_error
        Its standard error, m.
    instrument
        Analyser, with its noise.
    """
    incident, rebound = _candidates(stream, height, height_error, instrument)
    falling, rising = stream.velocity[incident], stream.velocity[rebound]
    noise, slope = delay_noise(falling, rising, height, instrument)
    late = stream.time[rebound] - stream.time[incident] - delay(falling, rising, height)
    lateness = late / np.hypot(noise, slope * height_error)
    sizes = np.hypot(*(instrument.diameter_noise(stream.diameter[i]) for i in (incident, rebound)))
    growth = np.log(stream.diameter[rebound] / stream.diameter[incident]) / sizes
    inside = (np.abs(growth) < GATE) & (np.abs(lateness) < GATE)
    cost = np.square(growth[inside]) + np.square(lateness[inside])
    chosen = matched(incident[inside], rebound[inside], 2.0 * GATE**2 - cost)
    first, second = incident[inside][chosen], rebound[inside][chosen]
    order = np.lexsort((second, stream.time[first]))
    return first[order], second[order]


def _candidates(
    stream: RecordStream, height: float, height_error: float, instrument: Analyser
) -> tuple[IntArray, IntArray]:
    """Return all pairs of a falling and a rising record that are not out of the question."""
    down, up = (np.flatnonzero(sign * stream.velocity > 0.0) for sign in (-1.0, 1.0))
    up = up[np.argsort(stream.time[up], kind="stable")]
    # The slowest rise starts from rest in the probe volume, reversed in time.
    highest = height + GATE * height_error
    slowest = np.zeros(len(down))
    noise, slope = delay_noise(stream.velocity[down], slowest, height, instrument)
    longest = delay(stream.velocity[down], slowest, highest)
    longest = longest + GATE * np.hypot(noise, slope * height_error)
    start = stream.time[down]
    first = np.searchsorted(stream.time[up], start, side="left")
    last = np.searchsorted(stream.time[up], start + longest, side="right")
    number = last - first
    incident = np.repeat(down, number)
    within = np.arange(number.sum()) - np.repeat(np.cumsum(number) - number, number)
    return incident, up[np.repeat(first, number) + within]


def matched(incident: IntArray, rebound: IntArray, worth: FloatArray) -> IntArray:
    """Return which possible pairs to accept: one-to-one, of the greatest total worth.

    Parameters
    ----------
    incident, rebound
        Indices of the records of each possible pair, (m,).
    worth
        Of each possible pair, (m,).
    """
    ends = incident, rebound
    alone = np.all([np.bincount(of)[of] == 1 for of in ends], axis=0)
    contested = np.flatnonzero(~alone)
    if not contested.size:
        return np.flatnonzero(alone)
    (n, row), (m, column) = (
        (len(own), place)
        for own, place in (np.unique(of[contested], return_inverse=True) for of in ends)
    )
    # Each incident may also go without, in a column of its own. All have a partner then, so that
    # what is added to every worth decides nothing; a worth of zero would be no edge.
    every = np.arange(n)
    places = np.concatenate([row, every]), np.concatenate([column, m + every])
    values = np.append(worth[contested], np.zeros(n)) + 1.0
    graph = scipy.sparse.csr_array((values, places), shape=(n, n + m))
    chosen = scipy.sparse.csgraph.min_weight_full_bipartite_matching(graph, maximize=True)[1]
    return np.concatenate([np.flatnonzero(alone), contested[chosen[row] == column]])
