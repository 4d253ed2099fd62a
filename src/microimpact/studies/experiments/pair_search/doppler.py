"""Virtual experiments on normal impacts with the phase Doppler particle analyser."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from microimpact.lab.bounces import with_later_impacts
from microimpact.lab.dispenser import Dispenser, Falling, InitialSpin
from microimpact.lab.events import Impacts
from microimpact.lab.experiment import Drop, Target
from microimpact.lab.pdpa.analyser import Instrument, through_probe
from microimpact.lab.pdpa.observation import Observation, observe
from microimpact.model.contact import Contact
from microimpact.statistics.distributions import Distribution, generator

NORMAL_INCIDENCE = 90.0
# Particles released at a time for each that is to fall through the probe volume, and how often.
RELEASED_FOR_ONE, MOST_BATCHES = 40, 500
NO_SPIN = InitialSpin(sd=0.0, mean=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """What an experiment is made with; `seed` is the root of its draws."""

    seed: int
    contact: Contact
    diameter_um: Distribution
    dispenser: Dispenser
    instrument: Instrument

    def drop(self, speed: float) -> Drop:
        """Return what is dropped at a nominal speed, m/s."""
        return Drop(
            target=Target(contact=self.contact),
            diameter_um=self.diameter_um,
            angle=NORMAL_INCIDENCE,
            speed=speed,
            speed_range=(0.0, np.inf),
            dispenser=self.dispenser,
            spin=NO_SPIN,
        )

    @property
    def steady(self) -> Setup:
        """The same with impacts at one speed and with the probe volume where it should be."""
        return replace(
            self,
            dispenser=replace(self.dispenser, exit_speed_m_per_s=0.0),
            instrument=replace(self.instrument, probe_height_error_um=0.0),
        )

    @property
    def aligned(self) -> Setup:
        """The same with every sphere falling through the middle of the probe volume."""
        straight = replace(self.dispenser, lateral_speed_m_per_s=0.0, lateral_position_mm=0.0)
        return replace(self, dispenser=straight)


def dropped(setup: Setup, speed: float, particles: int, key: tuple[int, ...]) -> Impacts:
    """Drop particles at a nominal speed, m/s, until so many fall through the probe volume.

    Only they are followed, and they alone arrive at the dispenser's rate: the stream of records
    is then as dense as declared, however few of all particles find the probe volume.

    Raises
    ------
    ValueError
        If hardly any particle falls through the probe volume.
    """
    rng = generator(setup.seed, *key)
    batches = [_through_probe(setup, speed, particles, rng)]
    while sum(len(batch.diameter) for batch in batches) < particles:
        if len(batches) == MOST_BATCHES:
            released = MOST_BATCHES * RELEASED_FOR_ONE * particles
            raise ValueError(
                f"particles: at {speed:g} m/s fewer than {particles} of {released} fall through the"
                " probe volume; make"
                " probe_across_um or probe_along_um larger, or lateral_speed_m_per_s smaller"
            )
        batches.append(_through_probe(setup, speed, particles, rng))
    fields = ("diameter", "position", "velocity", "spin")
    falling = {k: np.concatenate([getattr(b, k) for b in batches])[:particles] for k in fields}
    drop = setup.drop(speed)
    impacts = drop.hit(Falling(time=np.zeros(particles), **falling), rng)
    return replace(impacts, time=drop.release(particles, rng).time)


def _through_probe(setup: Setup, speed: float, particles: int, rng: np.random.Generator) -> Falling:
    # One tap frees them all: when those chosen arrive is drawn afterwards.
    number = RELEASED_FOR_ONE * particles
    at_once = replace(setup, dispenser=replace(setup.dispenser, particles_per_tap=2.0 * number))
    falling = at_once.drop(speed).release(number, rng)
    height = 1e-3 * setup.instrument.probe_height_mm
    return falling.select(
        through_probe(falling.position, falling.velocity, height, setup.instrument)
    )


def observed(setup: Setup, impacts: Impacts, speed: float, key: tuple[int, ...]) -> Observation:
    """Observe impacts of particles dropped at a nominal speed, m/s."""
    rng, drop = generator(setup.seed, *key), setup.drop(speed)
    later = drop.target.later(impacts.diameter, rng)
    return observe(
        with_later_impacts(impacts, later, setup.instrument.later_impacts),
        len(impacts),
        float(np.max(impacts.time)) + 1.0 / setup.dispenser.taps_per_s,
        setup.instrument,
        rng,
        drop_height=drop.height,
    )
