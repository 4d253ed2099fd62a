"""Measurement of a frame: the two legs of a track, from the spots found (Section 2.1)."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from microimpact.arrays import BoolArray, FloatArray
from microimpact.lab.events import IntArray
from microimpact.lab.ptis import Setup
from microimpact.lab.spots import Spots, find_spots
from microimpact.lab.track_fit import (
    FEW,
    OVERLAP,
    SATURATED,
    TOUCHING,
    Rejection,
    Track,
    reduce_tracks,
)

# Light of a whole dash, relative to the others of its leg; light of one dash and no more; and how
# slender dashes in a row are, unlike dashes side by side.
WHOLE = 0.05
SINGLE = 1.3
SLENDER = 5.0
# Incident tracks are as steep as this, and straight to so many pixels.
INCIDENT_CONE_DEG = 5.0
STRAIGHT_PX = 1.5
# Consecutive dashes must move on sideways by this much to be put in order.
LEAST_STEP_PX = 1.0


def measure(
    frame: NDArray[np.uint8], setup: Setup, *, with_gravity: bool = True
) -> Track | Rejection:
    """Measure one frame.

    Parameters
    ----------
    frame
        Grey levels, as from `frames.render`.
    setup
        What is known of the instrument.
    with_gravity
        Whether the legs are fitted by paths under gravity or by straight lines at constant speed.
    """
    return measure_all([frame], setup, with_gravity=with_gravity)[0]


def measure_all(
    frames: Iterable[NDArray[np.uint8]], setup: Setup, *, with_gravity: bool = True
) -> list[Track | Rejection]:
    """Measure frames, each as `measure` does; one is held at a time, and all tracks are fitted."""
    sorted_ = [sort_legs(find_spots(frame, setup), setup) for frame in frames]
    legs = [one for one in sorted_ if not isinstance(one, Rejection)]
    tracks = iter(reduce_tracks(legs, setup, with_gravity=with_gravity))
    return [one if isinstance(one, Rejection) else next(tracks) for one in sorted_]


def sort_legs(spots: Spots, setup: Setup) -> tuple[FloatArray, FloatArray] | Rejection:
    """Sort spots into the incident and the rebound leg, whole dashes alone.

    Spheres fall: the incident leg is the longest steep row of spots. The rest is the rebound,
    whose horizontal velocity is constant and tells its order.

    Returns
    -------
    tuple or Rejection
        Columns and rows of both legs, each (m, 2) in order of time.
    """
    if not np.any(spots.clear):
        return FEW
    usable = spots.clear & ~spots.saturated & (spots.height > _crowded(spots))
    if np.count_nonzero(usable) < 2 * setup.instrument.least_dashes:
        return _why(spots, np.ones_like(spots.clear))
    single = usable & (np.abs(spots.light / np.median(spots.light[usable]) - 1.0) < 0.5)
    on_line = _steep_row(spots.place, single)
    if on_line is None:
        return FEW
    legs = []
    for mine, axis in ((on_line, 1), (~on_line, 0)):
        order = np.flatnonzero(mine)
        order = order[np.argsort(spots.place[order, axis])]
        good = usable[order] & _whole(spots.light[order], usable[order])
        run = order[longest_run(good)]
        if run.size < setup.instrument.least_dashes:
            return _why(spots, mine)
        legs.append(spots.place[run])
    incident, rebound = legs
    if not told_apart(rebound):
        return OVERLAP
    if abs(rebound[-1, 0] - incident[-1, 0]) < abs(rebound[0, 0] - incident[-1, 0]):
        rebound = rebound[::-1]
    return incident, rebound


def _crowded(spots: Spots) -> float:
    """Return the height up to which dashes run together, and may not be told apart; px."""
    merged = spots.clear & (spots.light > SINGLE * np.median(spots.light[spots.clear]))
    return float(spots.height[merged].max(initial=-np.inf))


def _steep_row(place: FloatArray, single: BoolArray) -> BoolArray | None:
    """Return which spots lie on the steep line through most single ones."""
    index = np.flatnonzero(single)
    first, second = np.triu_indices(index.size, 1)
    a, b = place[index[first]], place[index[second]]
    steep = is_steep(b - a)
    if not np.any(steep):
        return None
    a, b = a[steep, None], b[steep, None]
    slope = (b[..., 0] - a[..., 0]) / (b[..., 1] - a[..., 1])
    off = np.abs(place[:, 0] - a[..., 0] - slope * (place[:, 1] - a[..., 1]))
    near = off < STRAIGHT_PX
    spread = np.where(near & single, off, 0.0).sum(axis=1)
    best = np.lexsort((spread, -np.count_nonzero(near & single, axis=1)))[0]
    row: BoolArray = near[best]
    return row


def is_steep(way: FloatArray) -> BoolArray:
    """Tell which ways, columns and rows (..., 2), are as steep as an incident track."""
    across, down = np.moveaxis(np.abs(way), -1, 0)
    steep: BoolArray = across < np.tan(np.radians(INCIDENT_CONE_DEG)) * down
    return steep


def told_apart(rebound: FloatArray, used: BoolArray | None = None) -> BoolArray:
    """Tell whether a rebound is no second incident track and its dashes have an order.

    Parameters
    ----------
    rebound
        Columns and rows of two or more dashes, shape (..., m, 2).
    used
        Which of them count, shape (..., m): the first ones; all if not given.
    """
    used = np.ones(rebound.shape[:-1], dtype=bool) if used is None else used
    last = (np.sum(used, axis=-1) - 1)[..., None, None]
    way = np.take_along_axis(rebound, last, axis=-2)[..., 0, :] - rebound[..., 0, :]
    step = np.where(used[..., 1:], np.abs(np.diff(rebound[..., 0], axis=-1)), np.inf)
    apart: BoolArray = ~is_steep(way) & (step.min(axis=-1) >= LEAST_STEP_PX)
    return apart


def _whole(light: FloatArray, usable: BoolArray) -> BoolArray:
    """Tell which dashes of a leg have the light of one whole pulse."""
    if not np.any(usable):
        return usable
    whole: BoolArray = np.abs(light / np.median(light[usable]) - 1.0) < WHOLE
    return whole


def longest_run(good: BoolArray) -> slice:
    """Return the longest stretch of true values."""
    (start,), (number,) = longest_runs(good, np.zeros(len(good), dtype=np.int64), 1)
    return slice(int(start), int(start + number))


def longest_runs(good: BoolArray, group: IntArray, groups: int) -> tuple[IntArray, IntArray]:
    """Return the longest stretch of true values within each group.

    Parameters
    ----------
    good
        Shape (m,).
    group
        Of each value: numbers below `groups` that ascend, shape (m,).
    groups
        Number of groups.

    Returns
    -------
    start, number
        Where the first of the longest stretches begins, and its values, shape (groups,); zero
        where there is none.
    """
    follows = np.zeros_like(good)
    follows[1:] = good[:-1] & (group[1:] == group[:-1])
    begin = np.flatnonzero(good & ~follows)
    length = np.bincount(np.cumsum(good & ~follows)[good] - 1, minlength=len(begin))
    order = np.lexsort((begin, -length, group[begin]))
    found, first = np.unique(group[begin][order], return_index=True)
    start, number = np.zeros((2, groups), dtype=np.int64)
    start[found], number[found] = begin[order[first]], length[order[first]]
    return start, number


def _why(spots: Spots, concerned: BoolArray) -> Rejection:
    """Say why spots do not make a leg."""
    several = concerned & (spots.light > SINGLE * np.median(spots.light[spots.clear]))
    if np.any(several & (spots.length < SLENDER * spots.width)):
        return OVERLAP
    if np.any(several):
        return TOUCHING
    return SATURATED if np.any(spots.saturated & spots.clear & concerned) else FEW
