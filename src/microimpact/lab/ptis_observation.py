"""Observation by trajectory imaging: every impact to its frame, every frame to its track."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from microimpact.arrays import FloatArray
from microimpact.lab.events import Impacts, IntArray, Measured
from microimpact.lab.exposure import INCIDENT, REBOUND, Exposure, expose
from microimpact.lab.frames import render
from microimpact.lab.ptis import Setup, Systematics, draw_systematics, event_generator
from microimpact.lab.track_fit import Rejection
from microimpact.lab.tracks import measure

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
) -> Observation:
    """Render and measure the frame of every impact.

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
    """
    errors = errors or draw_systematics(setup.instrument, rng)
    outcomes = [
        _observed(impacts, i, setup, errors, rng, first + i, with_gravity)
        for i in range(len(impacts))
    ]
    return observation(outcomes)


def _observed(
    impacts: Impacts,
    i: int,
    setup: Setup,
    errors: Systematics,
    rng: Generator,
    event: int,
    with_gravity: bool,
) -> FloatArray | str:
    """Return the velocities of one event, as in `Track`, or why there are none."""
    if impacts.captured[i]:
        return CAPTURED
    frame = render(impacts, i, setup, errors, event_generator(rng, event))
    track = measure(frame, setup, with_gravity=with_gravity)
    if not isinstance(track, Rejection):
        return track.velocities
    exposure = expose(impacts, i, setup, errors, event_generator(rng, event))
    return unseen(exposure, setup) or f"{UNMEASURABLE}: {track.reason}"


def unseen(exposure: Exposure, setup: Setup) -> str:
    """Say what keeps a leg from having enough whole dashes in the frame; nothing if it has.

    The first that does of: time, light sheet, field of view, and where the field ends.
    """
    seen = np.ones(len(exposure.leg), dtype=bool)
    for condition, reason in (
        (exposure.whole, TOO_SLOW),
        (exposure.in_sheet, OFF_SHEET),
        (exposure.in_view, OFF_VIEW),
        (exposure.in_field, SPLIT),
    ):
        seen = seen & condition
        dashes = [np.count_nonzero(seen & (exposure.leg == leg)) for leg in (INCIDENT, REBOUND)]
        if min(dashes) < setup.instrument.least_dashes:
            return reason
    return ""


def observation(outcomes: Iterable[FloatArray | str]) -> Observation:
    """Return what the velocities of each event, or the reasons why it has none, amount to."""
    fates, events, rows = [], [], []
    for i, outcome in enumerate(outcomes):
        fates.append(outcome if isinstance(outcome, str) else MEASURED)
        if not isinstance(outcome, str):
            events.append(i)
            rows.append(outcome)
    velocities = np.array(rows).reshape(-1, 2, 2)
    index: IntArray = np.array(events, dtype=np.int64)
    return Observation(
        measured=Measured(
            event=index,
            incident_tangential=velocities[:, 0, 0],
            incident_normal=velocities[:, 0, 1],
            rebound_tangential=velocities[:, 1, 0],
            rebound_normal=velocities[:, 1, 1],
        ),
        fates=tuple(fates),
    )
