"""Experiments at normal incidence: particles dropped on a horizontal target, seen by the PDPA."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy import constants

from microimpact.arrays import BoolArray, FloatArray
from microimpact.lab.collision import collide
from microimpact.lab.dispenser import Dispenser, InitialSpin, drop_height
from microimpact.lab.distributions import Distribution
from microimpact.lab.events import IntArray, Measured
from microimpact.lab.experiment import Target, true_impacts
from microimpact.lab.pdpa import Instrument
from microimpact.lab.pdpa_observation import Observation, observe
from microimpact.lab.reduction import Mean, mean_interval
from microimpact.model.contact import resized

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
            contact, velocity, spin, target.slope_sd, rng, planar_slopes=target.planar_slopes
        )
        return rebound.velocity, rebound.spin, rebound.captured

    # A second more, for the last sphere to bounce.
    duration = float(impacts.time[-1]) + 1.0
    height = drop_height(speed, dispenser)
    return observe(impacts, later, duration, instrument, rng, drop_height=height)


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
    high, low = (quantities(_moved(measured, sign * height_error)) for sign in (1.0, -1.0))
    return {
        name: mean_interval(values, systematic=0.5 * abs(np.mean(high[name] - low[name])))
        for name, values in quantities(measured).items()
    }


def _moved(measured: Measured, shift: float) -> Measured:
    """Return the events as corrected with another height of the probe: v dv = g dh."""

    def corrected(velocity: FloatArray) -> FloatArray:
        square = np.square(velocity) + 2.0 * constants.g * shift
        return np.sign(velocity) * np.sqrt(np.maximum(square, 0.0))

    return replace(
        measured,
        incident_normal=corrected(measured.incident_normal),
        rebound_normal=corrected(measured.rebound_normal),
    )
