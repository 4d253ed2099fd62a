"""What the chopped light sheet shows of one sphere: pieces of its path, pulse by pulse."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from scipy.constants import g as gravity

from microimpact.arrays import BoolArray, FloatArray
from microimpact.lab.events import Impacts, IntArray
from microimpact.lab.ptis import Setup, Systematics

INCIDENT, REBOUND, LATER = 0, 1, 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Flight:
    """Path of a sphere's centre in three legs: falling, rebounding, and after a second bounce.

    Attributes
    ----------
    begin, end
        Of each leg, s after impact, shape (3,); an empty leg ends where it begins.
    start, origin, velocity
        Each leg passes `origin` (3, 3), m, with `velocity` (3, 3), m/s, at the time `start` (3,).
    gravity
        m/s2, shape (3,).
    """

    begin: FloatArray
    end: FloatArray
    start: FloatArray
    origin: FloatArray
    velocity: FloatArray
    gravity: FloatArray

    def at(self, leg: IntArray, time: FloatArray) -> FloatArray:
        """Return the position, m, shape (..., 3), of a leg at times s after impact."""
        t = (time - self.start[leg])[..., None]
        return self.origin[leg] + self.velocity[leg] * t + 0.5 * self.gravity * np.square(t)


def flight(impacts: Impacts, i: int, setup: Setup) -> Flight:
    """Return the path of one sphere.

    No sphere was ever slower than at rest: the first leg begins where it would have been. A
    second bounce is taken to keep the share of the normal velocity that the first one kept.
    """
    pull = setup.gravity
    before, after = impacts.velocity[i], impacts.rebound_velocity[i]
    fallen = max(float(before @ pull), 0.0) / gravity**2
    aloft = 0.0 if impacts.captured[i] else 2.0 * after[2] / -pull[2]
    kept = after[2] / -before[2]
    origin = np.array([*impacts.position[i], 0.5 * impacts.diameter[i]])
    landing = origin + after * aloft + 0.5 * pull * aloft**2
    again = (after + pull * aloft) * [1.0, 1.0, -kept]
    return Flight(
        begin=np.array([-fallen, 0.0, aloft]),
        end=np.array([0.0, aloft, aloft * (1.0 + kept)]),
        start=np.array([0.0, 0.0, aloft]),
        origin=np.stack([origin, origin, landing]),
        velocity=np.stack([before, after, again]),
        gravity=pull,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Exposure:
    """What each pulse lights of the path of one sphere, m pieces in order of time.

    Attributes
    ----------
    leg
        `INCIDENT`, `REBOUND` or `LATER`.
    start, end
        s after impact; of the part in the sheet (none if not `start` < `end`), in whatever field.
    whole
        True where the pulse falls on this leg alone, not cut by the impact.
    in_sheet
        True where all of it lies in the sheet.
    in_view
        True where the image lies inside the frame.
    in_field
        True where the pulse lies in the field that holds the impact.
    field
        Beginning and end of that field, s after impact.
    peak
        Grey level of the brightest dash above the background.
    flight
        The path.
    """

    leg: IntArray
    start: FloatArray
    end: FloatArray
    whole: BoolArray
    in_sheet: BoolArray
    in_view: BoolArray
    in_field: BoolArray
    field: tuple[float, float]
    peak: float
    flight: Flight


def expose(
    impacts: Impacts,
    i: int,
    setup: Setup,
    errors: Systematics,
    rng: Generator,
    *,
    jitter: bool = True,
) -> Exposure:
    """Light one event: the impact falls anywhere in a field, and the chopper runs free.

    Parameters
    ----------
    impacts, i
        The impacts and which of them.
    setup, errors
        The instrument as set and the errors of the experiment.
    rng
        Of the event; see `event_generator`.
    jitter
        Whether the pulses come at irregular times.
    """
    instrument = setup.instrument
    rate, exposure = setup.chop_rate * (1.0 + errors.rate), 1.0 / instrument.fields_per_s
    begin = -exposure * rng.random()
    phase = rng.random()
    peak = rng.uniform(instrument.least_peak_counts, instrument.largest_peak_counts)
    most = int(np.ceil(exposure * rate)) + 1
    noise = instrument.jitter * rng.standard_normal(2 * most + 1) * jitter
    opens = ((np.arange(-most, most + 1) + phase + noise) / rate)[:, None]
    closes = opens + instrument.duty / rate
    path = flight(impacts, i, setup)
    number, leg = np.nonzero(np.maximum(opens, path.begin) < np.minimum(closes, path.end))
    opens, closes = opens[number, 0], closes[number, 0]
    begins, ends = np.maximum(opens, path.begin[leg]), np.minimum(closes, path.end[leg])
    entry, leaving = _in_sheet(path, 0.5e-3 * instrument.sheet_thickness_mm)
    start, end = np.maximum(begins, entry[leg]), np.minimum(ends, leaving[leg])
    spot = 0.5 * impacts.diameter[i] / setup.pixel + 1.5 * instrument.blur_px
    return Exposure(
        leg=leg,
        start=start,
        end=end,
        whole=(begins == opens) & (ends == closes),
        in_sheet=(start == begins) & (end == ends),
        in_view=np.all(
            [_inside(setup, errors, path.at(leg, t), spot) for t in (start, end)], axis=0
        ),
        in_field=(opens >= begin) & (closes <= begin + exposure),
        field=(begin, begin + exposure),
        peak=peak - instrument.background_counts,
        flight=path,
    )


def _in_sheet(path: Flight, half: float) -> tuple[FloatArray, FloatArray]:
    """Return when each leg enters and leaves the sheet; nothing but inertia acts across it."""
    y, speed = path.origin[:, 1], path.velocity[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        crossings = np.sort([(-half - y) / speed, (half - y) / speed], axis=0)
    never = np.where(np.abs(y) < half, -np.inf, np.inf)
    entry = np.where(speed == 0.0, never, path.start + crossings[0])
    leaving = np.where(speed == 0.0, np.inf, path.start + crossings[1])
    return np.clip(entry, path.begin, path.end), np.clip(leaving, path.begin, path.end)


def _inside(setup: Setup, errors: Systematics, position: FloatArray, margin: float) -> BoolArray:
    place = setup.columns_rows(position, errors)
    size = np.asarray(setup.instrument.frame_px)
    inside: BoolArray = np.all((place >= margin) & (place <= size - 1 - margin), axis=-1)
    return inside
