"""Experiments at normal incidence: particles dropped on a horizontal target, seen by the PDPA."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator

from microimpact.core.arrays import Real
from microimpact.core.constants import gravity
from microimpact.lab.bounces import with_later_impacts
from microimpact.lab.events import Impacts, Measured
from microimpact.lab.experiment import Drop, Outcome, StopRule
from microimpact.lab.pdpa.analyser import Analyser
from microimpact.lab.pdpa.observation import Observation, observe
from microimpact.lab.reduction import reduced
from microimpact.statistics.distributions import child

# Several times the probe volume, m.
REACH = 1e-3
UNREACHED = "incident far from probe"
QUANTITIES = ("restitution", "energy_loss")


@dataclass(frozen=True, slots=True, kw_only=True)
class Session(Outcome):
    """One experiment, with all that the analyser makes of it."""

    observation: Observation


def collect(drop: Drop, instrument: Analyser, stop: StopRule, rng: Generator) -> Session:
    """Drop particles on a horizontal target until enough events are accepted, or give up.

    After every batch all records so far are searched for pairs: which belong together, and how
    high the probe stands, is seen from all of them. Particles that arrive further than `REACH`
    from the middle are not followed: they miss the probe volume, and so do nearly all their later
    bounces.

    Parameters
    ----------
    drop
        What is dropped on what; its range is of *measured* speeds, for later bounces are slower.
    rng
        Of the experiment; its children serve the parts.
    """
    first: list[Impacts] = []
    later: list[Impacts] = []
    dropped, end = 0, 0.0
    while True:
        number, batch_rng = stop.batch(dropped), child(rng, 0, dropped)
        batch = drop.impacts(number, batch_rng, within=REACH)
        batch = replace(batch, time=end + batch.time)
        bounce = drop.target.later(batch.diameter, batch_rng)
        whole = with_later_impacts(batch, bounce, instrument.later_impacts)
        first.append(batch)
        later.append(whole.select(slice(len(batch), None)))
        dropped, end = dropped + number, float(np.max(batch.time, initial=end))
        impacts, arrived = Impacts.joined(first + later), sum(map(len, first))
        # A second more, for the last sphere to bounce.
        setting = impacts, arrived, end + 1.0, instrument, child(rng, 1)
        seen = observe(*setting, drop_height=drop.height)
        events = seen.at_surface()
        measured = events.select(np.flatnonzero(drop.in_class(events.speed))[: stop.events])
        if stop.ended(len(measured), dropped):
            break
    return Session(
        measured=measured,
        impacts=impacts,
        first=arrived,
        dropped=dropped,
        fates={**seen.quality.fates, UNREACHED: dropped - arrived},
        means=reduced(measured, moved, seen.pairing.height_error, stop.fewest_events, QUANTITIES),
        observation=seen,
    )


def moved(measured: Measured, shift: Real) -> Measured:
    """Return the events as corrected with a height of the probe larger by a shift, m.

    v dv = g dh; the shift broadcasts with the events.
    """
    velocities = measured.velocities
    square = np.square(velocities) + 2.0 * gravity * np.asarray(shift)[..., None, None]
    return replace(measured, velocities=np.sign(velocities) * np.sqrt(np.maximum(square, 0.0)))
