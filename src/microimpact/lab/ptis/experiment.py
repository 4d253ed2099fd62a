"""Experiments at oblique incidence: particles dropped on a tilted target, seen by the PTIS.

`collect` goes by the error model alone, `modelled`. `photographed` renders and measures frames,
against which the tests hold the model.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from microimpact.core.arrays import BoolArray, FloatArray, Real
from microimpact.lab.events import Impacts, Measured
from microimpact.lab.experiment import Drop, Outcome, StopRule
from microimpact.lab.ptis.errors import theory
from microimpact.lab.ptis.exposure import (
    CAPTURED,
    MEASURED,
    OFF_SHEET,
    UNMEASURABLE,
    exposures,
    unseen,
)
from microimpact.lab.ptis.frames import photographs
from microimpact.lab.ptis.system import (
    ImagingSystem,
    Setup,
    Systematics,
    draw_systematics,
    event_generator,
)
from microimpact.lab.ptis.tracks import find_spots, reduce_legs, sort_legs
from microimpact.lab.reduction import reduced
from microimpact.statistics.distributions import child, mean

OUTSIDE_CLASS = "outside the class"


@dataclass(frozen=True, slots=True, kw_only=True)
class ImagedEvents:
    """Fates and velocities of n impacts."""

    measured: Measured  # The events of which both legs were measured
    fates: tuple[str, ...]  # One word per impact: `MEASURED` or why not, n


@dataclass(frozen=True, slots=True, kw_only=True)
class Photographed:
    """Frames of n impacts, sorted into legs, before any reduction."""

    fates: NDArray[np.object_]  # Why there is no frame, or nothing, n
    legs: list[tuple[FloatArray, FloatArray] | None]  # Of every frame, as from `sort_legs`

    def reduced(self, setup: Setup, *, with_gravity: bool = True) -> ImagedEvents:
        """Return the velocities, by paths under gravity or by straight lines."""
        tracks = [
            reduce_legs(*legs, setup, with_gravity=with_gravity) if legs else None
            for legs in self.legs
        ]
        fates = self.fates.copy()
        fates[fates == ""] = [MEASURED if track else UNMEASURABLE for track in tracks]
        return _observation(fates, [track.velocities for track in tracks if track])


def modelled(
    impacts: Impacts, setup: Setup, errors: Systematics, draws: Sequence[Generator]
) -> ImagedEvents:
    """Return the fates and velocities of all impacts, by the error model.

    The generators of `photographed` give an event the same field and the same pulses as there,
    apart from their jitter.

    Parameters
    ----------
    impacts
        Impacts of n spheres.
    setup
        Imaging system as it is set.
    errors
        Systematic errors of the experiment.
    draws
        Generators, one per event or the same for all.
    """
    moving = np.flatnonzero(~impacts.captured)
    event_draws = [draws[i] for i in moving.tolist()]
    reasons, expected = theory(impacts.select(moving), setup, errors, event_draws)
    fates = np.full(len(impacts), CAPTURED, dtype=object)
    fates[moving] = reasons
    measured = np.flatnonzero(reasons == MEASURED)
    normal = [event_draws[i].standard_normal((2, 2, 1)) for i in measured.tolist()]
    spread = np.linalg.cholesky(expected.covariance) @ np.reshape(normal, (-1, 2, 2, 1))
    return _observation(fates, expected.velocities + spread[..., 0])


def photographed(
    impacts: Impacts, setup: Setup, errors: Systematics, rng: Generator
) -> Photographed:
    """Render the frame of every impact that can be seen, and sort its spots into legs.

    Of the events that are `unseen` a frame would give 1 in 400 a velocity, from dashes of which a
    little is missing; they count as lost.

    Parameters
    ----------
    impacts, setup, errors
        As of `modelled`.
    rng
        Generator of the experiment, whose children serve the events.
    """
    moving = np.flatnonzero(~impacts.captured)
    draws = [event_generator(rng, i) for i in moving.tolist()]
    exposure = exposures(impacts.select(moving), setup, errors, draws)
    reasons = unseen(exposure, setup)
    shown = np.flatnonzero(reasons == "")
    frames = photographs(exposure.select(shown), setup, errors, [draws[i] for i in shown.tolist()])
    fates = np.full(len(impacts), CAPTURED, dtype=object)
    fates[moving] = reasons
    return Photographed(
        fates=fates, legs=[sort_legs(find_spots(frame, setup), setup) for frame in frames]
    )


def _observation(
    fates: NDArray[np.object_], velocities: FloatArray | Sequence[FloatArray]
) -> ImagedEvents:
    """Return the fates of all events with the velocities of those measured, as in `Track`."""
    events = np.flatnonzero(fates == MEASURED)
    measured = Measured(event=events, velocities=np.reshape(velocities, (-1, 2, 2)))
    return ImagedEvents(measured=measured, fates=tuple(fates))


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
        seen = modelled(batch, setup, errors, [child(rng, 1, dropped)] * len(batch))
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
