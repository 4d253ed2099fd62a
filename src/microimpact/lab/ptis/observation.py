"""Observation by trajectory imaging: every impact to its fate, and to its velocities if measured.

`modelled` is what experiments go by: the error model alone. `observe` renders and measures frames,
against which the tests hold the model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from microimpact.core.arrays import FloatArray
from microimpact.lab.events import Impacts, Measured
from microimpact.lab.ptis.errors import theory
from microimpact.lab.ptis.exposure import CAPTURED, MEASURED, UNMEASURABLE, exposures, unseen
from microimpact.lab.ptis.frames import photographs
from microimpact.lab.ptis.system import Setup, Systematics, event_generator
from microimpact.lab.ptis.tracks import Rejection, Track, find_spots, reduce_legs, sort_legs


@dataclass(frozen=True, slots=True, kw_only=True)
class ImagedEvents:
    """Fates and velocities of n impacts."""

    measured: Measured  # The events of which both legs were measured
    fates: tuple[str, ...]  # One word per impact: `MEASURED` or why not, n


@dataclass(frozen=True, slots=True, kw_only=True)
class Photographed:
    """Frames of n impacts, sorted into legs, before any reduction."""

    fates: NDArray[np.object_]  # Why there is no frame, or nothing, n
    legs: list[tuple[FloatArray, FloatArray] | Rejection]  # Of every frame, as from `sort_legs`

    def reduced(self, setup: Setup, *, with_gravity: bool = True) -> ImagedEvents:
        """Return the velocities, by paths under gravity or by straight lines."""
        tracks = [
            legs
            if isinstance(legs, Rejection)
            else reduce_legs(*legs, setup, with_gravity=with_gravity)
            for legs in self.legs
        ]
        fates = self.fates.copy()
        fates[fates == ""] = [
            f"{UNMEASURABLE}: {of.reason}" if isinstance(of, Rejection) else MEASURED
            for of in tracks
        ]
        return _observation(fates, [of.velocities for of in tracks if isinstance(of, Track)])


def modelled(
    impacts: Impacts,
    setup: Setup,
    errors: Systematics,
    rng: Generator,
    draws: Sequence[Generator] | None = None,
) -> ImagedEvents:
    """Return the fates and velocities of all impacts, by the error model.

    The same generator gives an event the same field and the same pulses as in `observe`, apart from
    their jitter: nothing is drawn from it but from its children, one per event.

    Parameters
    ----------
    impacts
        Impacts of n spheres.
    setup
        Imaging system as it is set.
    errors
        Systematic errors of the experiment.
    rng
        Generator of the experiment.
    draws
        Generators in place of its children, one per event or the same for all.
    """
    moving = np.flatnonzero(~impacts.captured)
    event_draws = [draws[i] if draws else event_generator(rng, i) for i in moving.tolist()]
    reasons, expected = theory(impacts.select(moving), setup, errors, event_draws)
    fates = np.full(len(impacts), CAPTURED, dtype=object)
    fates[moving] = reasons
    measured = np.flatnonzero(reasons == MEASURED)
    normal = [event_draws[i].standard_normal((2, 2, 1)) for i in measured.tolist()]
    spread = np.linalg.cholesky(expected.covariance) @ np.reshape(normal, (-1, 2, 2, 1))
    return _observation(fates, expected.velocities + spread[..., 0])


def observe(impacts: Impacts, setup: Setup, errors: Systematics, rng: Generator) -> ImagedEvents:
    """Render and measure the frame of every impact that can be seen.

    Parameters
    ----------
    impacts, setup, errors, rng
        As of `modelled`.
    """
    return photographed(impacts, setup, errors, rng).reduced(setup)


def photographed(
    impacts: Impacts, setup: Setup, errors: Systematics, rng: Generator
) -> Photographed:
    """Render the frame of every impact that can be seen, and sort its spots into legs.

    Of the events that are `unseen` a frame would give 1 in 400 a velocity, from dashes of which a
    little is missing; they count as lost.

    Parameters
    ----------
    impacts, setup, errors, rng
        As of `modelled`.
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
