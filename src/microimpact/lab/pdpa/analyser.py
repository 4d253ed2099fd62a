"""Phase Doppler particle analyser: from true impacts to a stream of records (Section 2.1).

The target is horizontal: gravity acts along -z. One small probe volume at a height h above the
surface reports the vertical velocity, the diameter and the time of every sphere that crosses it,
on its way down or up; no record says which sphere it is of. Heights are those
of a sphere's centre above its position in contact: its radius counts to the error of h.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from annotated_types import Gt, Lt
from numpy.random import Generator

from microimpact.core.arrays import BoolArray, Columns, FloatArray, Real
from microimpact.core.bounds import Fraction, NonNegative, Positive, PositiveRange
from microimpact.core.compiled import jit
from microimpact.core.constants import gravity
from microimpact.lab.events import Impacts, IntArray

INCIDENT, REBOUND = 0, 1
SMALLEST = float(np.finfo(float).tiny)

_jit = jit()


@dataclass(frozen=True, slots=True, kw_only=True)
class Analyser:
    """Settings of the analyser; noise as standard deviations.

    Attributes
    ----------
    probe_height_mm, probe_height_error_um
        Nominal height of the probe volume, and the error of its setting, drawn once per experiment.
    initial_estimate_error
        Relative error of the height from which the search for pairs starts; the search takes it
        for the uncertainty of that height too.
    probe_across_um, probe_along_um
        Diameters of the probe volume: across the beam (x and z) and along it (y).
    velocity_noise_relative, velocity_noise_floor_m_per_s
        Of the velocity, added in squares.
    diameter_noise_relative, diameter_noise_um
        Of the logarithm of the diameter, and of the diameter, added in squares.
    outlier_fraction, outlier_factors
        Share of diameters off by a factor, uniform between two.
    time_resolution_us
        Of the time stamps.
    drop_out
        Share of passages without record, on average over the probe volume; none through its
        middle, most near its edge, where the signal is short.
    false_records_per_s, false_speed_m_per_s, false_diameters_um
        Rate of records of noise, uniform up to this speed either way and between two diameters.
    """

    probe_height_mm: Positive
    probe_height_error_um: NonNegative
    initial_estimate_error: Annotated[float, Gt(-1), Lt(1)]
    probe_across_um: Positive
    probe_along_um: Positive
    velocity_noise_relative: NonNegative
    velocity_noise_floor_m_per_s: NonNegative
    diameter_noise_relative: NonNegative
    diameter_noise_um: NonNegative
    outlier_fraction: Fraction
    outlier_factors: PositiveRange
    time_resolution_us: NonNegative
    drop_out: Fraction
    false_records_per_s: NonNegative
    false_speed_m_per_s: Positive
    false_diameters_um: PositiveRange

    def __post_init__(self) -> None:
        """Refuse a probe volume that may come to lie in the surface."""
        highest = 100.0 * self.probe_height_mm
        if self.probe_height_error_um > highest:
            raise ValueError(
                f"probe_height_error_um: {self.probe_height_error_um:g} must be at most a tenth of"
                f" probe_height_mm, {highest:g}"
            )

    @property
    def initial_height(self) -> float:
        """Height from which the search for pairs starts, m."""
        return 1e-3 * self.probe_height_mm * (1.0 + self.initial_estimate_error)

    def velocity_noise(self, velocity: FloatArray) -> FloatArray:
        """Return the standard deviation of recorded velocities, m/s."""
        return np.hypot(self.velocity_noise_relative * velocity, self.velocity_noise_floor_m_per_s)

    def diameter_noise(self, diameter: FloatArray) -> FloatArray:
        """Return the standard deviation of the logarithm of recorded diameters (m)."""
        return np.hypot(self.diameter_noise_relative, 1e-6 * self.diameter_noise_um / diameter)


@dataclass(frozen=True, slots=True, kw_only=True)
class Passages:
    """Passages through the probe volume, shape (2, n): incident and rebound leg of n impacts.

    Attributes
    ----------
    reached
        True where the sphere crosses the whole probe volume upright, or would if it did not miss.
    inside
        True where it crosses the level of the probe within the ellipse.
    time
        When the centre crosses the level of the probe, s.
    velocity
        Vertical, mean over the transit, m/s; negative downward.
    chord, transit
        Length of the path inside, m, and its duration, s.
    diameter
        m, shape (n,).

    Where a sphere does not cross, the numbers mean nothing.
    """

    reached: BoolArray
    inside: BoolArray
    time: FloatArray
    velocity: FloatArray
    chord: FloatArray
    transit: FloatArray
    diameter: FloatArray

    @property
    def crossed(self) -> BoolArray:
        """True where the sphere crosses the probe volume."""
        return self.reached & self.inside


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordStream(Columns):
    """Records of the analyser: k by time of acquisition, s, with m/s (signed) and m."""

    time: FloatArray
    velocity: FloatArray
    diameter: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundTruth:
    """The ground truth, unknown to an experimenter, of a stream of k records from passages (2, n).

    Attributes
    ----------
    leg, impact
        The passage of each record, shape (k,); -1 for noise.
    overlapped, dropped
        Passages lost because two spheres were in the probe volume, or without valid signal.
    """

    leg: IntArray
    impact: IntArray
    overlapped: BoolArray
    dropped: BoolArray

    @property
    def recorded(self) -> BoolArray:
        """True for the passages of which there is a record, shape (2, n)."""
        present = np.zeros(self.dropped.shape, dtype=np.bool_)
        real = self.impact >= 0
        present[self.leg[real], self.impact[real]] = True
        return present


def true_height(instrument: Analyser, rng: Generator) -> float:
    """Draw the height of the probe volume in one experiment, m."""
    error = 1e-6 * instrument.probe_height_error_um
    return 1e-3 * instrument.probe_height_mm + error * float(rng.standard_normal())


def passages(impacts: Impacts, height: Real, instrument: Analyser, fall: Real = np.inf) -> Passages:
    """Return the passages of all spheres through the probe volume.

    Parameters
    ----------
    impacts
        All impacts, later ones included (`bounces.with_later_impacts`).
    height
        Of the probe volume, m, one number or that of each sphere, shape (n,).
    fall
        Height from which each sphere fell, m, shape (n,) or one number: from below the probe
        volume no sphere comes down through it.
    """
    n = len(impacts)
    reached, inside = np.empty((2, 2, n), dtype=np.bool_)
    time, velocity, chord, transit = np.empty((4, 2, n))
    # One kind of arrays, for which the compiled loop is in the cache.
    level, position = np.full(n, height), np.ascontiguousarray(impacts.position)
    axes = half_axes(instrument)
    for leg, sign, path in (
        (INCIDENT, -1.0, np.ascontiguousarray(impacts.velocity)),
        (REBOUND, 1.0, np.ascontiguousarray(impacts.rebound_velocity)),
    ):
        outputs = reached[leg], inside[leg], time[leg], velocity[leg], chord[leg], transit[leg]
        _cross(impacts.time, position, path, level, sign, axes, gravity, *outputs)
    reached[INCIDENT] &= np.asarray(fall) > height
    reached[REBOUND] &= ~impacts.captured
    return Passages(
        reached=reached,
        inside=inside,
        time=time,
        velocity=velocity,
        chord=chord,
        transit=transit,
        diameter=impacts.diameter,
    )


def half_axes(instrument: Analyser) -> FloatArray:
    """Return half the axes of the probe volume along x, y and z, m."""
    across, along = instrument.probe_across_um, instrument.probe_along_um
    return 0.5e-6 * np.array([across, along, across])


def through_probe(
    position: FloatArray, velocity: FloatArray, height: float, instrument: Analyser
) -> BoolArray:
    """Tell which spheres fall through the level of the probe volume inside its ellipse.

    Spheres that never were so high count where their flight began.

    Parameters
    ----------
    position
        Where they reach the surface, m, (n, 2).
    velocity
        At the surface, m/s, (n, 3).
    height
        Of the probe volume above the surface, m.
    instrument
        Analyser, with the size of the probe volume.
    """
    inside = np.empty(len(position), dtype=np.bool_)
    _fall_through(position, velocity, height, half_axes(instrument), gravity, inside)
    return inside


@_jit
def _level(at_surface, height, sign, g):  # type: ignore[no-untyped-def]
    """Vertical velocity squared at a level, and when after the impact (sign -1: before it).

    Free flight to or from the surface at a vertical speed: where the level is out of reach, the
    square is below zero and the time that of the highest point.
    """
    square = at_surface * at_surface - 2.0 * g * height
    reached = min(height, at_surface * at_surface / (2.0 * g))
    there = at_surface + math.sqrt(max(square, 0.0))
    return square, sign * 2.0 * reached / (there if there > 0.0 else 1.0)


@_jit
def _fall_through(position, velocity, height, axes, g, inside):  # type: ignore[no-untyped-def]
    for i in range(inside.size):
        _, time = _level(abs(velocity[i, 2]), height, -1.0, g)
        x = (position[i, 0] + time * velocity[i, 0]) / axes[0]
        y = (position[i, 1] + time * velocity[i, 1]) / axes[1]
        inside[i] = x * x + y * y < 1.0


@_jit
def _cross(  # type: ignore[no-untyped-def]
    impact, position, flight, level, sign, axes, g, reached, inside, time, velocity, chord, transit
):
    """One leg of each flight; sign of the vertical velocity, and of time."""
    for i in range(impact.size):
        vx, vy = flight[i, 0], flight[i, 1]
        square, after = _level(abs(flight[i, 2]), level[i], sign, g)
        square = max(square, 0.0)
        speed = math.sqrt(square)
        # |place + time path| = 1 where the path, in units of the axes, enters and leaves.
        x = (position[i, 0] + after * vx) / axes[0]
        y = (position[i, 1] + after * vy) / axes[1]
        p, q, r = vx / axes[0], vy / axes[1], sign * speed / axes[2]
        squared = max(p * p + (q * q + r * r), SMALLEST)
        beside = 1.0 - (x * x + y * y)
        middle = x * p + y * q
        straight = 2.0 * math.sqrt(max(middle * middle + squared * beside, 0.0)) / squared
        rise = straight * speed
        slowed = math.sqrt(max(square - g * rise, 0.0))
        mean = 0.5 * (math.sqrt(square + g * rise) + slowed)
        reached[i], inside[i] = slowed > 0.0, beside > 0.0
        time[i], velocity[i] = impact[i] + after, sign * mean
        chord[i] = straight * math.sqrt(vx * vx + (vy * vy + square))
        transit[i] = rise / max(mean, SMALLEST)


def records(
    crossing: Passages, duration: float, instrument: Analyser, rng: Generator
) -> tuple[RecordStream, GroundTruth]:
    """Record the passages: noise, losses, and records of nothing.

    Parameters
    ----------
    duration
        Of the experiment, which begins at time zero, s.
    rng
        Source of the draws, which are made in the order of the passages' times.

    Returns
    -------
    Stream, GroundTruth
        The records in order of acquisition, and what they are of.
    """
    leg, impact = np.nonzero(crossing.crossed)
    order = np.argsort(crossing.time[leg, impact], kind="stable")
    passed = leg[order], impact[order]
    together = overlapping(crossing.time[passed], crossing.transit[passed])
    share = np.minimum(crossing.chord[passed] / (1e-6 * instrument.probe_across_um), 1.0)
    # Over an ellipse the mean share of the longest chord is 2/3.
    dropped = rng.random(len(order)) < 3.0 * instrument.drop_out * (1.0 - share)
    overlapped_all, dropped_all = np.zeros((2, *crossing.crossed.shape), dtype=np.bool_)
    overlapped_all[passed], dropped_all[passed] = together, dropped & ~together

    kept = ~(together | dropped)
    real = _with_noise(crossing, passed, instrument, rng).select(kept)
    false = _false_records(duration, instrument, rng)
    stream = RecordStream.joined([real, false])
    acquired = np.argsort(stream.time, kind="stable")
    nothing = np.full(len(false), -1)
    leg, impact = (np.concatenate([index[kept], nothing])[acquired] for index in passed)
    truth = GroundTruth(leg=leg, impact=impact, overlapped=overlapped_all, dropped=dropped_all)
    stream = stream.select(acquired)
    if resolution := 1e-6 * instrument.time_resolution_us:
        stream = replace(stream, time=np.round(stream.time / resolution) * resolution)
    return stream, truth


def overlapping(time: FloatArray, transit: FloatArray) -> BoolArray:
    """Tell which of some passages, in any order, share the probe volume with another."""
    start, end = time - 0.5 * transit, time + 0.5 * transit
    order = np.argsort(start, kind="stable")
    shared = np.zeros(len(time), dtype=np.bool_)
    latest = np.maximum.accumulate(end[order])
    shared[order[1:]] = start[order[1:]] < latest[:-1]
    shared[order[:-1]] |= end[order[:-1]] > start[order[1:]]
    return shared


def _with_noise(
    crossing: Passages, passed: tuple[IntArray, IntArray], instrument: Analyser, rng: Generator
) -> RecordStream:
    velocity, diameter = crossing.velocity[passed], crossing.diameter[passed[1]]
    number = len(velocity)
    noise = instrument.velocity_noise(velocity) * rng.standard_normal(number)
    factor = np.exp(instrument.diameter_noise(diameter) * rng.standard_normal(number))
    outlier = rng.random(number) < instrument.outlier_fraction
    factor *= np.where(outlier, rng.uniform(*instrument.outlier_factors, number), 1.0)
    return RecordStream(
        time=crossing.time[passed], velocity=velocity + noise, diameter=diameter * factor
    )


def _false_records(duration: float, instrument: Analyser, rng: Generator) -> RecordStream:
    number = int(rng.poisson(instrument.false_records_per_s * duration))
    speed = instrument.false_speed_m_per_s
    low, high = instrument.false_diameters_um
    return RecordStream(
        time=rng.uniform(0.0, duration, number),
        velocity=rng.uniform(-speed, speed, number),
        diameter=1e-6 * rng.uniform(low, high, number),
    )
