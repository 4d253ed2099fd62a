"""Experiments at normal incidence: particles dropped on a horizontal target, seen by the PDPA."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from microimpact.core.arrays import BoolArray, FloatArray, Real
from microimpact.core.constants import gravity
from microimpact.lab.collision import collide
from microimpact.lab.dispenser import Dispenser, InitialSpin, drop_height
from microimpact.lab.events import IntArray, Measured
from microimpact.lab.experiment import Target, true_impacts
from microimpact.lab.pdpa.analyser import Instrument
from microimpact.lab.pdpa.observation import Observation, observe
from microimpact.lab.ptis.system import child
from microimpact.lab.reduction import Mean, mean_interval
from microimpact.model.contact import resized
from microimpact.statistics.distributions import Distribution

# Several times the probe volume, m.
REACH = 1e-3


def drop_and_observe(
    n: int,
    *,
    target: Target,
    speed: float,
    diameter_um: Distribution,
    dispenser: Dispenser,
    spin: InitialSpin,
    instrument: Instrument,
    rng: np.random.Generator,
) -> Observation:
    """Return what the analyzer makes of n particles dropped on a horizontal target.

    Arguments as in `lab.experiment.true_impacts`; the settings of the analyzer are in
    ``instrument``. Particles that arrive further than `REACH` from the middle are not followed:
    they miss the probe volume, and so do nearly all their later bounces.
    """
    impacts = true_impacts(
        n,
        target=target,
        angle=90.0,
        speed=speed,
        diameter_um=diameter_um,
        dispenser=dispenser,
        spin=spin,
        rng=rng,
        within=REACH,
    )

    def later(
        velocity: FloatArray, spin: FloatArray, sphere: IntArray
    ) -> tuple[FloatArray, FloatArray, BoolArray]:
        contact = resized(target.contact, impacts.diameter[sphere])
        rebound = collide(
            contact,
            velocity,
            spin,
            target.slope_sd,
            rng,
            planar_slopes=target.planar_slopes,
            law=target.law,
        )
        return rebound.velocity, rebound.spin, rebound.captured

    # A second more, for the last sphere to bounce.
    duration = float(impacts.time[-1]) + 1.0
    height = drop_height(speed, dispenser)
    return observe(impacts, later, duration, instrument, rng, drop_height=height)


@dataclass(frozen=True, slots=True, kw_only=True)
class Collected:
    """Outcome of one experiment.

    Attributes
    ----------
    measured
        Accepted events, in order of time; `event` counts in the impacts of `observation`.
    observation
        All that the analyzer makes of the experiment.
    dropped
        Particles dropped.
    """

    measured: Measured
    observation: Observation
    dropped: int


def collect(
    speed_range: tuple[float, float],
    events: int,
    dropped: int,
    most_dropped: int,
    rng: np.random.Generator,
    **setting: Any,
) -> Collected:
    """Repeat an experiment with more particles until enough events are accepted, or give up.

    Parameters
    ----------
    speed_range
        Range of *measured* speeds accepted, m/s: later bounces are slower.
    events
        Number of accepted events wanted.
    dropped, most_dropped
        Number of particles at first, and after which the experiment is given up.
    rng
        Of the experiment; its children serve the attempts.
    **setting
        As in `drop_and_observe`.
    """
    while True:
        observation = drop_and_observe(dropped, rng=child(rng, dropped), **setting)
        speed = observation.measured.speed
        inside = np.flatnonzero((speed >= speed_range[0]) & (speed <= speed_range[1]))
        if len(inside) >= events or dropped >= most_dropped:
            measured = observation.measured.select(inside[:events])
            return Collected(measured=measured, observation=observation, dropped=dropped)
        # Half as many again as these few events say, for their scatter.
        wanted = int(np.ceil(1.5 * dropped * events / max(1, len(inside))))
        dropped = min(max(2 * dropped, wanted), most_dropped)


def true_restitution(observation: Observation) -> FloatArray:
    """Return e of every first impact, 0 where captured; shape (n,)."""
    impacts = observation.impacts
    first = slice(sum(observation.quality.fates.values()))
    e: FloatArray = -impacts.rebound_velocity[first, 2] / impacts.velocity[first, 2]
    return np.where(impacts.captured[first], 0.0, e)


def quantities(measured: Measured) -> dict[str, FloatArray]:
    """Return restitution and energy loss (Eqs. 1 and 3) of every event."""
    return {
        "restitution": measured.coefficient_of_restitution,
        "energy_loss": measured.translational_energy_loss,
    }


def reduced(measured: Measured, height_error: float) -> Mapping[str, Mean]:
    """Return mean and interval of every quantity; the height's error (m) is shared by all events.

    Raises
    ------
    ValueError
        With fewer than two events.
    """
    high, low = (quantities(moved(measured, sign * height_error)) for sign in (1.0, -1.0))
    return {
        name: mean_interval(values, systematic=0.5 * abs(np.mean(high[name] - low[name])))
        for name, values in quantities(measured).items()
    }


def moved(measured: Measured, shift: Real) -> Measured:
    """Return the events as corrected with a height of the probe larger by a shift, m.

    v dv = g dh; the shift broadcasts with the events.
    """

    def corrected(velocity: FloatArray) -> FloatArray:
        square = np.square(velocity) + 2.0 * gravity * np.asarray(shift)
        return np.sign(velocity) * np.sqrt(np.maximum(square, 0.0))

    return replace(
        measured,
        incident_normal=corrected(measured.incident_normal),
        rebound_normal=corrected(measured.rebound_normal),
    )
