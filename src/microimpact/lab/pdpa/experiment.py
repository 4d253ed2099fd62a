"""Experiments at normal incidence: particles dropped on a horizontal target, seen by the PDPA."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator

from microimpact.core.arrays import Real
from microimpact.core.constants import gravity
from microimpact.lab.bounces import with_later_impacts
from microimpact.lab.events import Impacts, IntArray, Measured
from microimpact.lab.experiment import Drop, Outcome, StopRule
from microimpact.lab.pdpa.analyser import (
    INCIDENT,
    REBOUND,
    Analyser,
    GroundTruth,
    Passages,
    RecordStream,
    passages,
    records,
    true_height,
)
from microimpact.lab.pdpa.pairing import Form, Pairing, correct, search
from microimpact.lab.reduction import reduced
from microimpact.statistics.distributions import child

# Several times the probe volume, m.
REACH = 1e-3
UNREACHED = "incident far from probe"
# What became of an impact: the first of these that holds, in the order in which they can happen.
FATES = (
    "incident below probe",
    "incident missed probe",
    "captured",
    "rebound below probe",
    "rebound missed probe",
    "overlap",
    "drop-out",
    "not paired",
    "paired",
)
QUANTITIES = ("restitution", "energy_loss")


@dataclass(frozen=True, slots=True, kw_only=True)
class Quality:
    """How well the pairs of a stream agree with the ground truth."""

    pairs: int  # Accepted
    true_pairs: int  # Those of them whose records are of one impact
    recorded_pairs: int  # Impacts of which both records exist
    seen_rebounds: int  # First impacts with a rebound and an incident record
    fates: Mapping[str, int]  # Number of first impacts by `FATES`; they add up to all of them


@dataclass(frozen=True, slots=True, kw_only=True)
class Observation:
    """All that one experiment leaves."""

    impacts: Impacts  # First and later impacts
    first: int  # Number of first impacts
    # Passages through the probe volume, the records, what they are of, and the pairs found.
    crossing: Passages
    stream: RecordStream
    truth: GroundTruth
    pairing: Pairing

    def at_surface(self, form: Form = "exact") -> Measured:
        """Reduce accepted pairs to normal velocities at the surface, with the height found.

        Events are numbers of `impacts`.
        """
        pairs = np.stack([self.pairing.incident, self.pairing.rebound], axis=-1)
        normal = np.asarray(correct(self.stream.velocity[pairs], self.pairing.height, form))
        return Measured.of_normal(pair_events(self.pairing, self.truth), normal)

    @property
    def quality(self) -> Quality:
        """Compare the pairs with the ground truth."""
        event, recorded = pair_events(self.pairing, self.truth), self.truth.recorded
        first = slice(self.first)
        return Quality(
            pairs=len(event),
            true_pairs=int(np.sum(event >= 0)),
            recorded_pairs=int(np.sum(np.all(recorded, axis=0))),
            seen_rebounds=int(np.sum(recorded[INCIDENT, first] & ~self.impacts.captured[first])),
            fates=self._fates(event),
        )

    def _fates(self, event: IntArray) -> dict[str, int]:
        (falls, rises), (enters, returns) = self.crossing.reached, self.crossing.inside
        conditions = [
            ~falls,
            ~enters,
            self.impacts.captured,
            ~rises,
            ~returns,
            np.any(self.truth.overlapped, axis=0),
            np.any(self.truth.dropped, axis=0),
            ~np.isin(np.arange(len(falls)), event),
        ]
        fate = np.select(conditions, list(range(len(conditions))), len(conditions))[: self.first]
        return dict(zip(FATES, np.bincount(fate, minlength=len(FATES)).tolist(), strict=True))


def observe(
    impacts: Impacts,
    first: int,
    duration: float,
    instrument: Analyser,
    rng: Generator,
    *,
    drop_height: float = np.inf,
) -> Observation:
    """Observe one experiment of normal impacts on a horizontal target.

    Parameters
    ----------
    impacts
        First impacts, and after them those of spheres that fall back, see `lab.bounces`.
    first
        Number of first impacts.
    duration
        Of the experiment, s.
    instrument
        Settings; the height of the probe volume is drawn once.
    rng
        Source of all draws of the instrument.
    drop_height
        Height from which the spheres fall, m; spheres from below the probe volume rise into it
        but do not fall through it.
    """
    fall = np.full(len(impacts), np.inf)
    fall[:first] = drop_height
    crossing = passages(impacts, true_height(instrument, rng), instrument, fall)
    stream, truth = records(crossing, duration, instrument, rng)
    return Observation(
        impacts=impacts,
        first=first,
        crossing=crossing,
        stream=stream,
        truth=truth,
        pairing=search(stream, instrument.initial_height, instrument),
    )


def pair_events(pairing: Pairing, truth: GroundTruth) -> IntArray:
    """Return the impact that both records of a pair are of; -1 if there is none, shape (k,)."""
    first, second = truth.impact[pairing.incident], truth.impact[pairing.rebound]
    legs = (truth.leg[pairing.incident] == INCIDENT) & (truth.leg[pairing.rebound] == REBOUND)
    return np.where((first == second) & legs, first, -1)


def ratio(part: float, whole: float) -> float:
    """Return a share; nan of nothing."""
    return part / whole if whole else float("nan")


def collect(drop: Drop, instrument: Analyser, stop: StopRule, rng: Generator) -> Outcome:
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
        whole = with_later_impacts(batch, bounce)
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
    return Outcome(
        measured=measured,
        impacts=impacts,
        first=arrived,
        dropped=dropped,
        fates={**seen.quality.fates, UNREACHED: dropped - arrived},
        means=reduced(measured, moved, seen.pairing.height_error, stop.fewest_events, QUANTITIES),
    )


def moved(measured: Measured, shift: Real) -> Measured:
    """Return the events as corrected with a height of the probe larger by a shift, m.

    v dv = g dh; the shift broadcasts with the events.
    """
    velocities = measured.velocities
    square = np.square(velocities) + 2.0 * gravity * np.asarray(shift)[..., None, None]
    return replace(measured, velocities=np.sign(velocities) * np.sqrt(np.maximum(square, 0.0)))
