"""True restitution curves, and measurements of them with noise, for the study of Eq. (34)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.declared.parameters import Name
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.empirical.equations import restitution

ANALYSIS = 34
# What a stream of random numbers is for.
MEASUREMENTS, CURVE_RESAMPLES, DATA_RESAMPLES = range(3)

TruthName = Literal["Eq. 34", "simulation"]
TRUTHS: tuple[TruthName, ...] = ("Eq. 34", "simulation")
Selection = Literal["rebounds", "all"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Variant:
    """How e is measured and fitted."""

    variant: Name
    # ``uniform``: one standard deviation of e for all speeds; ``velocimeter``: that of e = V/v with
    # one error of both speeds, (sigma_v/v) sqrt(1 + e^2), of the same mean square.
    noise: Literal["uniform", "velocimeter"]
    weights: Literal["equal", "true"]  # ``equal``, or by the ``true`` standard deviations
    # Openings of the coarser sieve over those of the finer; 1 for one size. Logarithms of the
    # diameters are evenly spread, and the nominal sphere, whose v_c is sought, is in the middle.
    largest_size_ratio: Annotated[float, Field(ge=1, le=100)]
    # ``rebounds``: only spheres seen to rebound count. ``all``: captured ones count as e = 0.
    selection: Selection


@dataclass(frozen=True, slots=True, kw_only=True)
class Truths:
    """The two true curves, of speed in units of the capture velocity of the nominal sphere."""

    contact: Contact  # The contact that is simulated, of one diameter
    # k, p, kappa, q, v_c of the true Eq. (34), m/s.
    constants: tuple[float, float, float, float, float]
    sizes: int  # Number of diameters that represent a sieve cut


# Cells that differ in noise or exponent alone share it.
@cache
def mean_restitution(
    truths: Truths,
    truth: TruthName,
    ratio: tuple[float, ...],
    largest_size_ratio: float,
    selection: Selection,
) -> FloatArray:
    """Mean e (n,) of the spheres that count, at speeds ratio (n,) times v_c.

    Every speed of Eq. (34) follows the diameter as the capture velocity of the simulation.
    """
    centre = (np.arange(truths.sizes) + 0.5) / truths.sizes - 0.5
    diameter = truths.contact.diameter * largest_size_ratio**centre
    if largest_size_ratio == 1.0:
        diameter = diameter[:1]
    contacts = resized(truths.contact, diameter[:, None])
    nominal, speeds = capture_velocity(truths.contact), np.array(ratio)
    if truth == "simulation":
        e = simulate(contacts, speeds * nominal).coefficient_of_restitution
    else:
        k, p, kappa, q, v_c = truths.constants
        scale = capture_velocity(contacts) / nominal
        e = restitution(speeds * v_c, k * scale, p, kappa * scale, q, v_c * scale)
    counted = np.maximum(np.sum(e > 0.0, axis=0), 1) if selection == "rebounds" else len(e)
    mean: FloatArray = np.sum(e, axis=0) / counted
    mean.flags.writeable = False
    return mean


def standard_deviations(
    noise: float, ratio: FloatArray, e: FloatArray, variant: Variant
) -> FloatArray:
    """Standard deviations (n,) of e, of root mean square ``noise``."""
    if variant.noise == "uniform":
        return np.full(ratio.shape, noise)
    shape = np.sqrt(1.0 + e**2) / ratio
    scaled: FloatArray = shape * (noise / np.sqrt(np.mean(shape**2)))
    return scaled


@cache
def standard_noise(seed: int, use: int, points: int, replicates: int) -> FloatArray:
    """Standard normal numbers (replicates, points), each row from a stream of its own.

    Replicates of cells with as many points share their rows, so that cells can be compared.
    """
    noise = np.stack(
        [stream(seed, use, points, i).standard_normal(points) for i in range(replicates)]
    )
    noise.flags.writeable = False
    return noise


def stream(seed: int, use: int, points: int, replicate: int) -> np.random.Generator:
    """Random numbers of one replicate for one use."""
    key = (ANALYSIS, use, points, replicate)
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=key)))


def observed(
    curve: FloatArray, noise: FloatArray, selection: Selection
) -> tuple[FloatArray, BoolArray]:
    """Measured e (r, n), 0 where the sphere seems captured, and which data there are."""
    e = np.where(curve > 0.0, np.maximum(curve + noise, 0.0), 0.0)
    return e, (e > 0.0) if selection == "rebounds" else np.ones(e.shape, bool)
