"""Experiments at oblique incidence: particles dropped on a tilted target, seen by the PTIS.

What the PTIS makes of an impact is told by the error model of its frames (`observation.modelled`).
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
from numpy.random import Generator

from microimpact.core.arrays import BoolArray, FloatArray, Real
from microimpact.lab.events import Impacts, Measured
from microimpact.lab.experiment import Drop, Outcome, StopRule
from microimpact.lab.ptis.exposure import MEASURED, OFF_SHEET
from microimpact.lab.ptis.observation import modelled
from microimpact.lab.ptis.system import ImagingSystem, Setup, draw_systematics
from microimpact.lab.reduction import reduced
from microimpact.statistics.distributions import child, mean

OUTSIDE_CLASS = "outside the class"


def collect(drop: Drop, instrument: ImagingSystem, stop: StopRule, rng: Generator) -> Outcome:
    """Drop particles on a tilted target until enough events are accepted, or give up.

    The experiment ends with its last event, whoever else has been dropped with it. `outside the
    class` is measured but of another speed.

    Parameters
    ----------
    drop
        What is dropped on what, at an angle below 90 degrees; its range is of *measured* speeds.
    rng
        Of the experiment; its children serve the parts.
    """
    setup = set_for(drop, instrument)
    errors = draw_systematics(instrument, rng)
    fates: Counter[str] = Counter()
    looked: list[Impacts] = []
    accepted_events: list[Measured] = []
    dropped = first = accepted = 0
    while not stop.ended(accepted, dropped):
        number = stop.batch(dropped)
        batch_rng = child(rng, 2, dropped)
        falling = drop.release(number, batch_rng)
        # Others arrive where they cannot be seen.
        shown = np.flatnonzero(in_sheet(falling.position, instrument))
        batch = drop.hit(falling.select(shown), batch_rng)
        wanted, used = stop.events - accepted, number
        seen = modelled(batch, setup, errors, rng, [child(rng, 1, dropped)] * len(batch))
        inside = np.flatnonzero(drop.in_class(seen.measured.speed))[:wanted]
        part = seen.measured.select(inside)
        end = int(part.event[-1]) + 1 if len(part) == wanted else len(batch)
        fates.update(seen.fates[:end])
        looked.append(batch.select(slice(end)))
        accepted_events.append(replace(part, event=part.event + first))
        accepted, first = accepted + len(part), first + end
        if accepted == stop.events:
            used = int(shown[end - 1]) + 1
        fates[OFF_SHEET] += used - int(np.sum(shown < used))
        dropped += used
    fates[OUTSIDE_CLASS] = fates[MEASURED] - accepted
    measured = Measured.joined(accepted_events)
    return Outcome(
        measured=measured,
        impacts=Impacts.joined(looked),
        first=first,
        dropped=dropped,
        fates=dict(fates),
        means=reduced(measured, turned, instrument.angle_error_deg, stop.fewest_events),
    )


def set_for(drop: Drop, instrument: ImagingSystem) -> Setup:
    """Return the instrument as set for an experiment."""
    diameter = mean(drop.diameter_um) * 1e-6
    return Setup(instrument=instrument, angle=drop.angle, speed=drop.speed, diameter=diameter)


def in_sheet(position: FloatArray, instrument: ImagingSystem) -> BoolArray:
    """Tell at which places (n, 2) the light sheet and the camera can see an impact at all."""
    half = 0.5e-3 * instrument.sheet_thickness_mm
    field = 1e-6 * instrument.pixel_um * max(instrument.frame_px)
    x, y = position.T
    seen: BoolArray = (np.abs(y) <= half) & (np.abs(x) <= field)
    return seen


def turned(measured: Measured, angle: Real) -> Measured:
    """Return the events as seen from a target turned by an angle in degrees.

    The angle broadcasts with the events.
    """
    turn, velocities = np.radians(np.asarray(angle))[..., None, None], measured.velocities
    across = velocities[..., ::-1] * [1.0, -1.0]
    return replace(measured, velocities=np.cos(turn) * velocities + np.sin(turn) * across)
