"""Particles on their way: sizes, release, fall, and spin picked up in the needle."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from microimpact.core.arrays import FloatArray
from microimpact.core.bounds import NonNegative, Positive
from microimpact.core.computable import NotComputable
from microimpact.core.constants import gravity
from microimpact.statistics.distributions import HalfNormal, mean, sample


@dataclass(frozen=True, slots=True, kw_only=True)
class Dispenser:
    """The needle and the rotor that taps it.

    Attributes
    ----------
    exit_speed_m_per_s
        Spread of the downward speed at the needle's end (half-normal).
    lateral_speed_m_per_s, lateral_position_mm
        Spread per horizontal axis (normal).
    taps_per_s, particles_per_tap
        Rate of taps and mean number of particles that a tap frees (Poisson).
    release_delay_ms
        Mean delay after a tap (exponential).
    """

    exit_speed_m_per_s: NonNegative
    lateral_speed_m_per_s: NonNegative
    lateral_position_mm: NonNegative
    taps_per_s: Positive
    particles_per_tap: Positive
    release_delay_ms: NonNegative


@dataclass(frozen=True, slots=True, kw_only=True)
class InitialSpin:
    """Spin before impact as a share of the speed: r omega / v.

    Attributes
    ----------
    sd
        Standard deviation per axis, mean zero: the wall of the needle is touched on any side.
    mean
        Mean about the tilt axis, positive in the sense of rolling down the target.
    """

    sd: NonNegative
    mean: float


NO_SPIN = InitialSpin(sd=0.0, mean=0.0)


def drop_height(speed: float, dispenser: Dispenser) -> float:
    """Return the height in m from which particles arrive at a nominal speed (m/s), free of drag.

    Raises ValueError if the particles leave the needle faster than that.
    """
    exit_speed = mean(HalfNormal(sd=dispenser.exit_speed_m_per_s))
    if speed <= exit_speed:
        raise NotComputable(
            f"speed must be above the mean speed at the needle, {exit_speed:.3g} m/s, got {speed:g}"
        )
    return (speed**2 - exit_speed**2) / (2.0 * gravity)


# Place of arrival, velocity and speed of the fall alone, (n, 2), (n, 3) and (n,), of n particles.
Paths = Callable[[int, np.random.Generator], tuple[FloatArray, FloatArray, FloatArray]]


def paths(
    n: int, rng: np.random.Generator, *, angle: float, height: float, dispenser: Dispenser
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the `Paths` of n particles from the needle to the target.

    Parameters
    ----------
    n, rng
        Number of particles, and source of the draws.
    angle
        Nominal angle of incidence from the surface, degrees.
    height
        From the needle to the target, m.
    dispenser
        Spreads of release.
    """
    tilt = np.radians(90.0 - angle)
    start = sample(HalfNormal(sd=dispenser.exit_speed_m_per_s), rng, n)
    fall = np.hypot(start, np.sqrt(2.0 * gravity * height))
    duration = (fall - start) / gravity
    lateral = dispenser.lateral_speed_m_per_s * rng.standard_normal((n, 2))
    position = dispenser.lateral_position_mm * 1e-3 * rng.standard_normal((n, 2))
    position += lateral * duration[:, None]
    position[:, 0] /= np.cos(tilt)
    # Horizontal across the tilt axis and vertical, seen from the target.
    horizontal = np.array([np.cos(tilt), 0.0, np.sin(tilt)])
    down = np.array([np.sin(tilt), 0.0, -np.cos(tilt)])
    velocity = fall[:, None] * down + lateral[:, :1] * horizontal
    velocity[:, 1] += lateral[:, 1]
    # Steered away from a nearly vertical target, a particle would never arrive.
    velocity[:, 2] = np.minimum(velocity[:, 2], -1e-6)
    return position, velocity, fall


def arrivals(n: int, dispenser: Dispenser, rng: np.random.Generator) -> FloatArray:
    """Return times of n arrivals, s: taps at a steady rate, each freeing a few particles.

    Parameters
    ----------
    n
        Number of particles.
    dispenser
        Rate of the taps, particles per tap and delay of the release.
    rng
        Generator of the draws.
    """
    freed = np.zeros(0, dtype=np.int64)
    while freed.sum() < n:
        taps = math.ceil(n / dispenser.particles_per_tap)
        freed = np.concatenate([freed, rng.poisson(dispenser.particles_per_tap, taps)])
    tap = np.repeat(np.arange(freed.size), freed)[:n]
    delay = dispenser.release_delay_ms * 1e-3 * rng.standard_exponential(n)
    return np.sort(tap / dispenser.taps_per_s + delay)
