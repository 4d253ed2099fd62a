"""Observation by trajectory imaging: every impact to its frame, every frame to its track."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from microimpact.core.arrays import FloatArray
from microimpact.lab.events import Impacts, Measured
from microimpact.lab.ptis.exposure import INCIDENT, LEGS, REBOUND, Exposure, exposures
from microimpact.lab.ptis.frames import photographs
from microimpact.lab.ptis.system import Setup, Systematics, draw_systematics, event_generator
from microimpact.lab.ptis.track_fit import Rejection, Track
from microimpact.lab.ptis.tracks import measure_all

MEASURED = "measured"
CAPTURED = "captured"
TOO_SLOW = "too few pulses in a field"
OFF_SHEET = "outside the light sheet"
OFF_VIEW = "outside the field of view"
SPLIT = "split over fields"
UNMEASURABLE = "unmeasurable"


@dataclass(frozen=True, slots=True, kw_only=True)
class Observation:
    """What became of n impacts.

    Attributes
    ----------
    measured
        The events of which both legs were measured.
    fates
        One word per impact: `MEASURED` or why not, n.
    """

    measured: Measured
    fates: tuple[str, ...]

    @property
    def counts(self) -> dict[str, int]:
        """Number of impacts by fate."""
        return dict(Counter(self.fates))


def observe(
    impacts: Impacts,
    setup: Setup,
    rng: Generator,
    *,
    first: int = 0,
    errors: Systematics | None = None,
    with_gravity: bool = True,
    wanted: Callable[[Measured], int] | None = None,
) -> Observation:
    """Render and measure the frame of every impact that can be seen.

    Of the events that are `unseen` a frame would give 1 in 400 a velocity, from dashes of which a
    little is missing; they count as lost.

    Parameters
    ----------
    impacts
        The true impacts.
    setup
        The instrument as set.
    rng
        Of the experiment, made from a `numpy.random.SeedSequence`; nothing is drawn from it, only
        from its children, one per event.
    first
        Number of the first impact in the experiment, if these are a part of one.
    errors
        Of the experiment; drawn if not given.
    with_gravity
        As in `tracks.measure`.
    wanted
        Given the events measured so far, tells how many more are wanted: no more frames are made
        at once, and when none is wanted the fates end with the event that was the last.
    """
    errors = errors or draw_systematics(setup.instrument, rng)
    moving = np.flatnonzero(~impacts.captured)
    draws = [event_generator(rng, first + i) for i in moving.tolist()]
    exposure = exposures(impacts.select(moving), setup, errors, draws)
    fates = np.full(len(impacts), CAPTURED, dtype=object)
    fates[moving] = unseen(exposure, setup)
    shown = np.flatnonzero(fates[moving] == "")
    seen = observation(fates, np.empty((0, 2, 2)))
    disks, velocities = impacts.diameter[moving], list[FloatArray]()
    while len(shown):
        now, shown = np.split(shown, [wanted(seen.measured) if wanted else len(shown)])
        own = [draws[i] for i in now.tolist()]
        frames = photographs(exposure.select(now), disks[now], setup, errors, own)
        tracks = measure_all(frames, setup, with_gravity=with_gravity)
        fates[moving[now]] = [
            f"{UNMEASURABLE}: {of.reason}" if isinstance(of, Rejection) else MEASURED
            for of in tracks
        ]
        velocities += [of.velocities for of in tracks if isinstance(of, Track)]
        seen = observation(fates[: moving[now[-1]] + 1], np.reshape(velocities, (-1, 2, 2)))
        if wanted and not wanted(seen.measured):
            return seen
    return observation(fates, np.reshape(velocities, (-1, 2, 2)))


def unseen(exposure: Exposure, setup: Setup) -> NDArray[np.object_]:
    """Say what keeps a leg from having enough whole dashes in the frame; nothing if it has.

    For each event, the first that does of: time, light sheet, field of view, and where the field
    ends.
    """
    reasons = np.full(len(exposure), "", dtype=object)
    seen = np.ones(len(exposure.leg), dtype=bool)
    for condition, reason in (
        (exposure.whole, TOO_SLOW),
        (exposure.in_sheet, OFF_SHEET),
        (exposure.in_view, OFF_VIEW),
        (exposure.in_field, SPLIT),
    ):
        seen = seen & condition
        dashes = np.bincount(exposure.leg[seen], minlength=LEGS * len(exposure)).reshape(-1, LEGS)
        too_few = dashes[:, [INCIDENT, REBOUND]].min(axis=1) < setup.instrument.least_dashes
        reasons[too_few & (reasons == "")] = reason
    return reasons


def observation(fates: Iterable[str], velocities: FloatArray) -> Observation:
    """Return what the fates of all events and the velocities (k, 2, 2) of the measured amount to.

    Velocities as in `track_fit.Track`.
    """
    fates = tuple(fates)
    return Observation(
        measured=Measured(
            event=np.flatnonzero(np.array(fates, dtype=object) == MEASURED),
            incident_tangential=velocities[:, 0, 0],
            incident_normal=velocities[:, 0, 1],
            rebound_tangential=velocities[:, 1, 0],
            rebound_normal=velocities[:, 1, 1],
        ),
        fates=fates,
    )
