"""Exposure in the chopped light sheet: pieces of the paths of spheres, pulse by pulse.

Frames and error model rest on the same pieces, and on the same reasons why an impact is not seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.compiled import jit
from microimpact.core.constants import gravity
from microimpact.lab.events import Impacts, IntArray
from microimpact.lab.ptis.system import Setup, Systematics

INCIDENT, REBOUND, LATER = 0, 1, 2
LEGS = 3

_jit = jit()

# What becomes of an impact.
MEASURED = "measured"
CAPTURED = "captured"
TOO_SLOW = "too few pulses in a field"
OFF_SHEET = "outside the light sheet"
OFF_VIEW = "outside the field of view"
SPLIT = "split over fields"
UNMEASURABLE = "unmeasurable"


@dataclass(frozen=True, slots=True, kw_only=True)
class Flight:
    """Paths of the centres of n spheres: falling, rebounding, and after a second bounce.

    Leg 3 i + `INCIDENT`, `REBOUND` or `LATER` is of sphere i.
    """

    # Of each leg, s after impact, shape (3 n,); an empty leg ends where it begins.
    begin: FloatArray
    end: FloatArray
    # Each leg passes `origin` (3 n, 3), m, with `velocity` (3 n, 3), m/s, at the time `start`.
    start: FloatArray
    origin: FloatArray
    velocity: FloatArray
    gravity: FloatArray  # m/s2, shape (3,)

    def select(self, which: IntArray) -> Flight:
        """Return the paths of some spheres."""
        legs = (LEGS * which[:, None] + np.arange(LEGS)).ravel()
        columns = {
            k: getattr(self, k)[legs] for k in ("begin", "end", "start", "origin", "velocity")
        }
        return replace(self, **columns)

    def at(self, leg: IntArray, time: FloatArray) -> FloatArray:
        """Return the position, m, shape (..., 3), of a leg at times s after impact."""
        t = (time - self.start[leg])[..., None]
        # In place and by `take`: half of the time, a tenth of that of a virtual experiment.
        position: FloatArray = np.take(self.velocity, leg, axis=0) * t
        position += np.take(self.origin, leg, axis=0)
        position += 0.5 * self.gravity * np.square(t)
        return position


def flights(impacts: Impacts, setup: Setup) -> Flight:
    """Return the paths of all spheres.

    No sphere was ever slower than at rest: the first leg begins where it would have been. A
    second bounce is taken to keep the share of the normal velocity that the first one kept.
    """
    pull = setup.gravity
    before, after = impacts.velocity, impacts.rebound_velocity
    fallen = np.maximum(before @ pull, 0.0) / gravity**2
    aloft = np.where(impacts.captured, 0.0, 2.0 * after[:, 2] / -pull[2])
    kept = after[:, 2] / -before[:, 2]
    origin = np.column_stack([impacts.position, 0.5 * impacts.diameter])
    time, never = aloft[:, None], np.zeros(len(impacts))
    landing = origin + after * time + 0.5 * pull * time**2
    again = after + pull * time
    again[:, 2] *= -kept

    def legs(*values: FloatArray) -> FloatArray:
        return np.stack(values, axis=1).reshape(LEGS * len(impacts), *values[0].shape[1:])

    return Flight(
        begin=legs(-fallen, never, aloft),
        end=legs(never, aloft, aloft * (1.0 + kept)),
        start=legs(never, never, aloft),
        origin=legs(origin, origin, landing),
        velocity=legs(before, after, again),
        gravity=pull,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Exposure:
    """Lit pieces of the paths of n spheres: m pieces, by sphere, in order of time."""

    leg: IntArray  # Of the `flight`, shape (m,)
    # s after impact; of the part in the sheet (none if not `start` < `end`), in whatever field.
    start: FloatArray
    end: FloatArray
    whole: BoolArray  # True where the pulse falls on this leg alone, not cut by the impact
    in_sheet: BoolArray  # True where all of it lies in the sheet
    in_view: BoolArray  # True where the image lies inside the frame
    in_field: BoolArray  # True where the pulse lies in the field that holds the impact
    # Beginning and end of that field, s after impact, each of shape (n,).
    field: tuple[FloatArray, FloatArray]
    peak: FloatArray  # Grey level of the brightest dash above the background, shape (n,)
    diameter: FloatArray  # Of the spheres, m, shape (n,)
    flight: Flight  # The paths

    def __len__(self) -> int:
        return len(self.peak)

    @property
    def event(self) -> IntArray:
        """Whose each piece is, shape (m,)."""
        return self.leg // LEGS

    def select(self, which: IntArray) -> Exposure:
        """Return the lit pieces of some events, by ascending numbers."""
        number = np.full(len(self), -1)
        number[which] = np.arange(len(which))
        kept = number[self.event] >= 0
        names = "start", "end", "whole", "in_sheet", "in_view", "in_field"
        return replace(
            self,
            **{name: getattr(self, name)[kept] for name in names},
            leg=LEGS * number[self.event[kept]] + self.leg[kept] % LEGS,
            field=(self.field[0][which], self.field[1][which]),
            peak=self.peak[which],
            diameter=self.diameter[which],
            flight=self.flight.select(which),
        )

    def dashes(self) -> tuple[IntArray, FloatArray, FloatArray]:
        """Return which pieces show in the field of their impact, and from when to when, s."""
        start = np.maximum(self.start, self.field[0][self.event])
        end = np.minimum(self.end, self.field[1][self.event])
        shown = np.flatnonzero(end > start)
        return shown, start[shown], end[shown]

    def places(
        self, piece: IntArray, time: FloatArray, setup: Setup, errors: Systematics
    ) -> FloatArray:
        """Return columns and rows, (k, m, 2), of the centre on k pieces.

        Parameters
        ----------
        piece
            Indices of the pieces, (k,).
        time
            s after impact, (k, m).
        setup
            Imaging system as it is set.
        errors
            Systematic errors of the experiment.
        """
        return setup.columns_rows(self.flight.at(self.leg[piece][:, None], time), errors)


def exposures(
    impacts: Impacts,
    setup: Setup,
    errors: Systematics,
    rngs: Sequence[Generator],
    *,
    jitter: bool = True,
) -> Exposure:
    """Light events: each impact falls anywhere in a field, and the chopper runs free.

    Parameters
    ----------
    impacts
        Impacts of n spheres.
    setup
        Imaging system as it is set.
    errors
        Systematic errors of the experiment.
    rngs
        A generator for each event, or the same for all, which draw from it in turn.
    jitter
        Whether the times of the pulses scatter.
    """
    instrument = setup.instrument
    rate, exposure = setup.chop_rate * (1.0 + errors.rate), 1.0 / instrument.fields_per_s
    most = int(np.ceil(exposure * rate)) + 1
    uniform, noise = np.empty((len(impacts), 3)), np.empty((len(impacts), 2 * most + 1))
    for i, rng in enumerate(rngs):
        rng.random(out=uniform[i])
        rng.standard_normal(out=noise[i])
    begin, phase = -exposure * uniform[:, 0], uniform[:, 1:2]
    least, largest = instrument.least_peak_counts, instrument.largest_peak_counts
    peak = least + (largest - least) * uniform[:, 2]
    pulse = np.arange(-most, most + 1) + phase + instrument.jitter * noise * jitter
    opening = pulse / rate
    closing = opening + instrument.duty / rate
    path = flights(impacts, setup)
    entry, leaving = _in_sheet(path, 0.5e-3 * instrument.sheet_thickness_mm)
    spot = 0.5 * impacts.diameter / setup.pixel + 1.5 * instrument.blur_px
    # A leg ends within one pulse at most.
    most = opening.shape[0] * (opening.shape[1] + LEGS - 1)
    leg, times = np.empty(most, dtype=np.int64), np.empty((2, most))
    flags = np.empty((4, most), dtype=bool)
    legs = path.begin, path.end, entry, leaving, path.start, path.origin, path.velocity
    view = setup.imaging(errors), instrument.frame_px, spot
    pulses = opening, closing, begin, exposure
    lit = slice(_lit(pulses, legs, path.gravity, view, leg, *times, flags))
    start, end = times[:, lit]
    whole, in_sheet, in_view, in_field = flags[:, lit]
    return Exposure(
        leg=leg[lit],
        start=start,
        end=end,
        whole=whole,
        in_sheet=in_sheet,
        in_view=in_view,
        in_field=in_field,
        field=(begin, begin + exposure),
        peak=peak - instrument.background_counts,
        diameter=impacts.diameter,
        flight=path,
    )


@_jit
def _lit(pulses, legs, pull, view, leg, start, end, flags):  # type: ignore[no-untyped-def]
    """Write the pieces lit by pulses (n, m), as fields of an `Exposure`; return their number."""
    opening, closing, field, exposure = pulses
    begin, last, entry, leaving, since, origin, velocity = legs
    imaging, frame, margin = view
    piece = 0
    for event in range(opening.shape[0]):
        close = field[event] + exposure
        for pulse in range(opening.shape[1]):
            opens, closes = opening[event, pulse], closing[event, pulse]
            for leg_index in range(LEGS * event, LEGS * (event + 1)):
                first, final = max(opens, begin[leg_index]), min(closes, last[leg_index])
                if not first < final:
                    continue
                start[piece], end[piece] = (
                    max(first, entry[leg_index]),
                    min(final, leaving[leg_index]),
                )
                leg[piece] = leg_index
                inside = True
                for time in (start[piece], end[piece]):
                    t = time - since[leg_index]
                    x = velocity[leg_index, 0] * t + origin[leg_index, 0] + 0.5 * pull[0] * t * t
                    z = velocity[leg_index, 2] * t + origin[leg_index, 2] + 0.5 * pull[2] * t * t
                    inside &= _inside(x, z, imaging, frame, margin[event])
                flags[0, piece] = first == opens and final == closes
                flags[1, piece] = start[piece] == first and end[piece] == final
                flags[2, piece] = inside
                flags[3, piece] = opens >= field[event] and closes <= close
                piece += 1
    return piece


@_jit
def _inside(x, z, imaging, frame, margin):  # type: ignore[no-untyped-def]
    """Tell whether the image of a place lies inside the frame; as `Setup.columns_rows`."""
    across, down, sine, cosine, pixel = imaging
    column = across + (x * sine + z * cosine) / pixel
    row = down + (x * cosine - z * sine) / pixel
    in_columns = margin <= column <= frame[0] - 1 - margin
    return in_columns and margin <= row <= frame[1] - 1 - margin


def _in_sheet(path: Flight, half: float) -> tuple[FloatArray, FloatArray]:
    """Return when each leg enters and leaves the sheet; nothing but inertia acts across it."""
    y, speed = path.origin[:, 1], path.velocity[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        crossings = np.sort([(-half - y) / speed, (half - y) / speed], axis=0)
    never = np.where(np.abs(y) < half, -np.inf, np.inf)
    entry = np.where(speed == 0.0, never, path.start + crossings[0])
    leaving = np.where(speed == 0.0, np.inf, path.start + crossings[1])
    return np.clip(entry, path.begin, path.end), np.clip(leaving, path.begin, path.end)


def unseen(exposure: Exposure, setup: Setup) -> NDArray[np.object_]:
    """Reason why a leg has too few whole dashes in the frame; empty if it has enough.

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
