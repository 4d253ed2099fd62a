"""Measurement of a frame: the two legs of a track, from the spots found (Section 2.1)."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.compiled import jit
from microimpact.lab.events import IntArray
from microimpact.lab.ptis.spots import Spots, find_spots
from microimpact.lab.ptis.system import Setup
from microimpact.lab.ptis.track_fit import (
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
# Incident tracks are as steep as this (tangent from the vertical), straight to so many pixels.
STEEP = math.tan(math.radians(5.0))
STRAIGHT_PX = 1.5
# Consecutive dashes must move on sideways by this much to be put in order.
LEAST_STEP_PX = 1.0

_jit = jit()


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
    incident, rebound, concerned = _legs(
        spots.place,
        spots.light,
        spots.height,
        spots.clear,
        spots.saturated,
        setup.instrument.least_dashes,
    )
    if not len(rebound):
        return _why(spots, concerned) if np.any(concerned) else FEW
    if not told_apart(spots.place[rebound]):
        return OVERLAP
    return spots.place[incident], spots.place[rebound]


@_jit
def _legs(place, light, height, clear, saturated, least):  # type: ignore[no-untyped-def]
    """Spots of both legs in order of time; else none, and which spots do not make a leg, if any."""
    none, nowhere = np.empty(0, dtype=np.int64), np.zeros(len(light), dtype=np.bool_)
    if not np.any(clear):
        return none, none, nowhere
    # Up to some height dashes run together, and may not be told apart.
    merged = clear & (light > SINGLE * np.median(light[clear]))
    crowded = -np.inf
    for spot in np.flatnonzero(merged):
        crowded = max(crowded, height[spot])
    usable = clear & ~saturated & (height > crowded)
    if np.sum(usable) < 2 * least:
        return none, none, ~nowhere
    single = usable & (np.abs(light / np.median(light[usable]) - 1.0) < 0.5)
    on_line = _steep_row(place, single)
    if not np.any(on_line):
        return none, none, nowhere
    incident = _longest_run(place[:, 1], light, usable, on_line)
    if len(incident) < least:
        return none, none, on_line
    rebound = _longest_run(place[:, 0], light, usable, ~on_line)
    if len(rebound) < least:
        return none, none, ~on_line
    end = place[incident[-1], 0]
    if abs(place[rebound[-1], 0] - end) < abs(place[rebound[0], 0] - end):
        rebound = rebound[::-1].copy()
    return incident, rebound, nowhere


@_jit
def _steep_row(place, single):  # type: ignore[no-untyped-def]
    """Which spots lie on the steep line through most single ones, and closest; none without."""
    row, most, least = np.zeros(len(place), dtype=np.bool_), 0, np.inf
    index = np.flatnonzero(single)
    for a in index:
        for b in index[index > a]:
            across, down = place[b, 0] - place[a, 0], place[b, 1] - place[a, 1]
            if abs(across) >= STEEP * abs(down):
                continue
            off = np.abs(place[:, 0] - place[a, 0] - across / down * (place[:, 1] - place[a, 1]))
            near = off < STRAIGHT_PX
            number, spread = np.sum(near & single), np.sum(off[near & single])
            if number > most or (number == most and spread < least):
                row, most, least = near, number, spread
    return row


@_jit
def _longest_run(along, light, usable, mine):  # type: ignore[no-untyped-def]
    """Longest row of dashes of a leg, in order, that have the light of one whole pulse."""
    order = np.flatnonzero(mine)
    order = order[np.argsort(along[order])]
    if not np.any(usable[order]):
        return order[:0]
    whole = np.median(light[order][usable[order]])
    first, number, length = 0, 0, 0
    for i, spot in enumerate(order):
        good = usable[spot] and abs(light[spot] / whole - 1.0) < WHOLE
        length = length + 1 if good else 0
        if length > number:
            first, number = i + 1 - length, length
    return order[first : first + number]


def is_steep(way: FloatArray) -> BoolArray:
    """Tell which ways, columns and rows (..., 2), are as steep as an incident track."""
    across, down = np.moveaxis(np.abs(way), -1, 0)
    steep: BoolArray = across < STEEP * down
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
