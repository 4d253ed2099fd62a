"""Which dashes of exposures `lab.tracks` would find in their frames, by geometry alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.lab.events import IntArray
from microimpact.lab.ptis.exposure import LATER, LEGS, Exposure
from microimpact.lab.ptis.spots import LEAST_BRIGHTNESS, SMOOTHING_PX, SURFACE_PX
from microimpact.lab.ptis.system import Setup, Systematics
from microimpact.lab.ptis.tracks import SINGLE, longest_runs

# What is seen of a dash, as measured on frames: how far its light reaches beyond the sharp edge of
# the disk, in blurs; how much of the radius is too faint at its ends, which only a part of the
# disk reaches; and how close (px) the light of two dashes runs together.
EDGE = 0.72
FAINT_END = 0.45
JOINED_PX = 2.0
# Points of each dash between which distances are taken.
POINTS = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class Dashes:
    """Dashes of n exposures in their frames, m in all, leg by leg and in order of time.

    Attributes
    ----------
    events
        Number n of exposures.
    leg, centre, length
        Which leg each belongs to (as in `lab.exposure`), centroid (columns and rows, (m, 2)) and
        way of the centre, px.
    good
        True where it is found whole and by itself.
    """

    events: int
    leg: IntArray
    centre: FloatArray
    length: FloatArray
    good: BoolArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Rows:
    """The longest row of good dashes of one leg of each of n exposures.

    Attributes
    ----------
    places
        Columns and rows in order of time, shape (n, k, 2); zero beyond the end of a row.
    used
        True up to the end of a row, shape (n, k).
    number, length
        Of the dashes, and their mean way, px, shape (n,).
    """

    places: FloatArray
    used: BoolArray
    number: IntArray
    length: FloatArray

    def select(self, which: IntArray | BoolArray) -> Rows:
        """Return the rows of some exposures."""
        return Rows(**{name: getattr(self, name)[which] for name in self.__dataclass_fields__})


def outline(setup: Setup) -> float:
    """Return how far the light of a sphere reaches beyond its disk, px."""
    return float(EDGE * np.hypot(setup.instrument.blur_px, SMOOTHING_PX))


def brightness(length: FloatArray, disk: FloatArray, setup: Setup) -> FloatArray:
    """Return the brightest light per pixel of dashes of unit light, near enough.

    The widths of disk and blur add in squares.

    Parameters
    ----------
    length, disk
        Way of the centre and diameter, px; they broadcast.
    setup
        What is known of the instrument.
    """
    chord = np.hypot(0.25 * np.pi * disk, np.sqrt(2.0 * np.pi) * setup.instrument.blur_px)
    light: FloatArray = 1.0 / (chord * np.hypot(chord, length))
    return light


def find_dashes(exposure: Exposure, disk: FloatArray, setup: Setup, errors: Systematics) -> Dashes:
    """Return the dashes of n exposures.

    Parameters
    ----------
    exposure
        Without jitter.
    disk
        Diameter of the spheres, px, shape (n,).
    setup, errors
        The instrument as set and the errors of the experiment.
    """
    event, flight = exposure.event, exposure.flight
    start = np.maximum(exposure.start, exposure.field[0][event])
    end = np.minimum(exposure.end, exposure.field[1][event])
    shown = np.flatnonzero((end > start) & exposure.in_view)
    shown = shown[np.argsort(exposure.leg[shown], kind="stable")]
    start, end = start[shown], end[shown]
    event, leg = event[shown], exposure.leg[shown]
    size, edge = disk[event], 0.5 * disk[event] + outline(setup)
    length = np.linalg.norm(flight.at(leg, end) - flight.at(leg, start), axis=1) / setup.pixel
    trim = np.minimum(0.5, FAINT_END * 0.5 * size / np.maximum(length, 1e-12))[:, None]
    share = trim + (1.0 - 2.0 * trim) * np.linspace(0.0, 1.0, POINTS)
    time = start[:, None] + (end - start)[:, None] * share
    path = setup.columns_rows(flight.at(leg[:, None], time), errors)
    # The mean over a dash lies off its middle by what gravity bends it.
    middle = flight.at(leg, 0.5 * (start + end))
    middle = middle + flight.gravity * ((end - start) ** 2)[:, None] / 24.0
    light = (end - start) * setup.chop_rate / setup.instrument.duty
    whole = (exposure.whole & exposure.in_sheet & exposure.in_field)[shown]
    bright = brightness(length, size, setup)
    brightest = np.zeros(len(exposure))
    np.maximum.at(brightest, event, np.where(leg % LEGS < LATER, bright, 0.0))
    return Dashes(
        events=len(exposure),
        leg=leg,
        centre=setup.columns_rows(middle, errors),
        length=length,
        good=whole
        & _alone(event, path, light, setup.height(path), edge)
        & (bright > LEAST_BRIGHTNESS * brightest[event]),
    )


def _alone(
    event: IntArray, path: FloatArray, light: FloatArray, height: FloatArray, edge: FloatArray
) -> BoolArray:
    """Tell which dashes make a spot of their own, above all that run together.

    As in `tracks`, spots that touch the surface do not count.
    """
    pairs, m = _near(event, path, edge), len(event)
    graph = scipy.sparse.coo_array((np.ones(len(pairs[0])), pairs), shape=(m, m))
    n, spot = scipy.sparse.csgraph.connected_components(graph, directed=False)
    whole = np.bincount(spot, light, minlength=n)
    centre = np.bincount(spot, light * height.mean(axis=1), minlength=n) / whole
    bottom, owner = np.full(n, np.inf), np.zeros(n, dtype=np.int64)
    np.minimum.at(bottom, spot, height.min(axis=1) - edge)
    owner[spot] = event
    clear = bottom > SURFACE_PX
    merged = clear & (whole > SINGLE)
    crowded = np.full(event.max(initial=0) + 1, -np.inf)
    np.maximum.at(crowded, owner[merged], centre[merged])
    alone: BoolArray = (clear & ~merged)[spot] & (height.mean(axis=1) > crowded[event])
    return alone


def _near(event: IntArray, path: FloatArray, edge: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the pairs of dashes of one event whose light runs together."""
    later = np.searchsorted(event, event, side="right") - np.arange(len(event)) - 1
    first = np.repeat(np.arange(len(event)), later)
    within = np.arange(later.sum()) - np.repeat(np.cumsum(later) - later, later)
    second = first + 1 + within
    joined = edge[first] + edge[second] + JOINED_PX
    # No point of a dash is farther from its middle one than its reach: most pairs drop out here.
    middle = path[:, POINTS // 2]
    reach = np.linalg.norm(path - middle[:, None], axis=2).max(axis=1)
    apart = np.linalg.norm(middle[first] - middle[second], axis=1)
    close = apart < joined + reach[first] + reach[second]
    first, second, joined = first[close], second[close], joined[close]
    gap = path[first][:, :, None] - path[second][:, None]
    near = np.hypot(gap[..., 0], gap[..., 1]).min(axis=(1, 2)) < joined
    return first[near], second[near]


def longest_rows(dashes: Dashes, leg: int) -> Rows:
    """Return the longest rows of good dashes of the legs `INCIDENT` or `REBOUND`."""
    start, number = longest_runs(dashes.good, dashes.leg, LEGS * dashes.events)
    start, number = start[leg::LEGS], number[leg::LEGS]
    place = np.arange(max(2, number.max(initial=0)))
    used = place < number[:, None]
    index = np.where(used, start[:, None] + place, 0)
    # Without any dash there is nothing that the unused index 0 could mean.
    centre = dashes.centre if len(dashes.centre) else np.zeros((1, 2))
    length = dashes.length if len(dashes.length) else np.zeros(1)
    return Rows(
        places=np.where(used[..., None], centre[index], 0.0),
        used=used,
        number=number,
        length=np.bincount(np.nonzero(used)[0], length[index[used]], minlength=dashes.events)
        / np.maximum(number, 1),
    )
