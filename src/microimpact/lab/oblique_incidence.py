"""Experiments at oblique incidence: particles dropped on a tilted target, seen by the PTIS."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.random import Generator

from microimpact.arrays import FloatArray
from microimpact.lab.dispenser import Dispenser, InitialSpin
from microimpact.lab.distributions import Distribution, mean
from microimpact.lab.events import Impacts, Measured
from microimpact.lab.experiment import Target, true_impacts
from microimpact.lab.ptis import Instrument, Setup, child, draw_systematics
from microimpact.lab.ptis_model import modelled
from microimpact.lab.ptis_observation import OFF_SHEET, Observation, observe
from microimpact.lab.reduction import Mean, mean_interval

Method = Literal["frames", "model"]
OBSERVERS: Mapping[Method, Callable[..., Observation]] = {"frames": observe, "model": modelled}

# Particles dropped at a time, and how many of them are looked at before events are counted.
DROPPED_AT_ONCE = 200
LOOKED_AT_ONCE = 24


@dataclass(frozen=True, slots=True, kw_only=True)
class Recipe:
    """What an oblique experiment is made of, but for its angle.

    Attributes
    ----------
    target
        Contact and roughness.
    diameter_um
        Sizes of the particles.
    speed, speed_range
        Nominal speed, m/s, and range of *measured* speeds accepted.
    dispenser, spin, instrument
        Settings.
    method
        Whether frames are rendered and measured, or the model of their errors serves.
    """

    target: Target
    diameter_um: Distribution
    speed: float
    speed_range: tuple[float, float]
    dispenser: Dispenser
    spin: InitialSpin
    instrument: Instrument
    method: Method


@dataclass(frozen=True, slots=True, kw_only=True)
class Collected:
    """Outcome of one experiment.

    Attributes
    ----------
    measured
        Accepted events, in order of time.
    dropped
        Particles dropped until there were enough.
    fates
        What became of them; `outside the class` is measured but of another speed.
    captured, rebounded
        Of those that arrived in the light sheet.
    true_restitution
        Of the accepted events, as they were; same shape as `measured`.
    """

    measured: Measured
    dropped: int
    fates: Mapping[str, int]
    captured: int
    rebounded: int
    true_restitution: FloatArray


def collect(
    recipe: Recipe, angle: float, events: int, most_dropped: int, rng: Generator
) -> Collected:
    """Drop particles until enough events are accepted, or the experiment is given up.

    Parameters
    ----------
    recipe
        What to drop, on what, and how to look at it.
    angle
        Nominal angle of incidence from the surface, degrees, below 90.
    events
        Number of accepted events wanted.
    most_dropped
        Number of particles after which the experiment is given up.
    rng
        Of the experiment; its children serve the parts.
    """
    setup = Setup(
        instrument=recipe.instrument,
        angle=angle,
        speed=recipe.speed,
        diameter=mean(recipe.diameter_um) * 1e-6,
    )
    errors = draw_systematics(recipe.instrument, rng)
    low, high = recipe.speed_range
    fates: Counter[str] = Counter()
    parts: list[Measured] = []
    truths: list[FloatArray] = []
    dropped = captured = rebounded = accepted = looked = 0
    while accepted < events and dropped < most_dropped:
        impacts = _in_sheet(_drop(recipe, angle, child(rng, 2, dropped)), recipe.instrument)
        dropped += DROPPED_AT_ONCE
        fates[OFF_SHEET] += DROPPED_AT_ONCE - len(impacts)
        for start in range(0, len(impacts), LOOKED_AT_ONCE):
            some = _some(impacts, slice(start, start + LOOKED_AT_ONCE))
            seen = OBSERVERS[recipe.method](some, setup, rng, first=looked, errors=errors)
            looked += len(some)
            inside = (seen.measured.speed >= low) & (seen.measured.speed <= high)
            fates.update(seen.fates)
            fates["outside the class"] += int(np.sum(~inside))
            captured += int(np.sum(some.captured))
            rebounded += int(np.sum(~some.captured))
            parts.append(seen.measured.select(inside))
            truths.append(_restitution(some)[parts[-1].event])
            accepted += len(parts[-1])
            if accepted >= events:
                break
    return Collected(
        measured=_joined(parts).select(slice(events)),
        dropped=dropped,
        fates=dict(fates),
        captured=captured,
        rebounded=rebounded,
        true_restitution=np.concatenate(truths)[:events],
    )


def _drop(recipe: Recipe, angle: float, rng: Generator) -> Impacts:
    return true_impacts(
        DROPPED_AT_ONCE,
        target=recipe.target,
        angle=angle,
        speed=recipe.speed,
        diameter_um=recipe.diameter_um,
        dispenser=recipe.dispenser,
        spin=recipe.spin,
        rng=rng,
    )


def _in_sheet(impacts: Impacts, instrument: Instrument) -> Impacts:
    """Return the impacts that the light sheet and the camera can see at all."""
    half = 0.5e-3 * instrument.sheet_thickness_mm
    field = 1e-6 * instrument.pixel_um * max(instrument.frame_px)
    seen = (np.abs(impacts.position[:, 1]) <= half) & (np.abs(impacts.position[:, 0]) <= field)
    return _some(impacts, seen)


def _some(impacts: Impacts, which: slice | np.ndarray) -> Impacts:
    return Impacts(**{name: getattr(impacts, name)[which] for name in Impacts.__dataclass_fields__})


def _joined(parts: list[Measured]) -> Measured:
    names = Measured.__dataclass_fields__
    return Measured(**{name: np.concatenate([getattr(p, name) for p in parts]) for name in names})


def _restitution(impacts: Impacts) -> FloatArray:
    e: FloatArray = -impacts.rebound_velocity[:, 2] / impacts.velocity[:, 2]
    return e


def quantities(measured: Measured) -> dict[str, FloatArray]:
    """Return restitution, impulse ratio and energy loss (Eqs. 1-3) of every event."""
    return {
        "restitution": measured.coefficient_of_restitution,
        "impulse_ratio": measured.impulse_ratio,
        "energy_loss": measured.translational_energy_loss,
    }


def reduced(measured: Measured, angle_error: float) -> dict[str, Mean]:
    """Return mean and interval of every quantity; the target's angle is shared by all events.

    The magnification and the chopper's rate scale all speeds alike and leave the ratios.

    Parameters
    ----------
    measured
        At least two events.
    angle_error
        Standard uncertainty of the target's angle, degrees.
    """
    high, low = (quantities(turned(measured, sign * angle_error)) for sign in (1.0, -1.0))
    return {
        name: mean_interval(values, systematic=0.5 * abs(np.mean(high[name] - low[name])))
        for name, values in quantities(measured).items()
    }


def turned(measured: Measured, angle: float) -> Measured:
    """Return the events as seen from a target turned by an angle in degrees."""
    cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))

    def both(normal: FloatArray, tangential: FloatArray) -> tuple[FloatArray, FloatArray]:
        return cos * normal - sin * tangential, cos * tangential + sin * normal

    incident = both(measured.incident_normal, measured.incident_tangential)
    rebound = both(measured.rebound_normal, measured.rebound_tangential)
    return replace(
        measured,
        incident_normal=incident[0],
        incident_tangential=incident[1],
        rebound_normal=rebound[0],
        rebound_tangential=rebound[1],
    )
