"""Patches of light in a frame: what is found of dashes (Section 2.1).

Dashes are found by their light, and their centroids are used, never their ends: the size of the
sphere lengthens a dash by its diameter and leaves its centroid alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.compiled import jit
from microimpact.lab.ptis.frames import BRIGHTEST
from microimpact.lab.ptis.system import Setup

# Detection: a frame is smoothed by this Gaussian (px); what exceeds both so many deviations of the
# smoothed noise and this share of the brightest spot is light of a dash.
SMOOTHING_PX = 1.0
REACH = 3
KERNEL = np.exp(-((np.arange(2 * REACH + 1) - REACH) ** 2) / (2.0 * SMOOTHING_PX * SMOOTHING_PX))
KERNEL = (KERNEL / KERNEL.sum()).astype(np.float32)
# Rows are smoothed across the others only in stretches of so many pixels that may hold light.
STRETCH = 32
DETECTION = 6.0
LEAST_BRIGHTNESS = 0.1
# Spots are widened by this much to hold the light of their wings.
WINGS_PX = 2
# Light this close to the line of the surface (px) may be that of a dash bent by the impact.
SURFACE_PX = 2.0
# Levels are counted in every so manieth row: 77 000 pixels are enough.
EVERY = 4
# A spot with more of its pixels than this at the end of the scale is saturated.
MOST_SATURATED = 0.2

# Sums over the pixels of a spot: light, first and second moments, pixels at the end of the scale;
# and of its core alone, which exceeds the threshold: its pixels, and those at surface or edge.
LIGHT, COLUMN, ROW, ACROSS, DOWN, MIXED, FULL, CORE, NEAR = range(9)

_jit = jit()


@dataclass(frozen=True, slots=True, kw_only=True)
class Spots:
    """Connected patches of light in a frame, n of them.

    Attributes
    ----------
    place
        Centroid, column and row in lines of the camera, shape (n, 2).
    light
        Counts above the background.
    length, width
        Standard deviations of the light along its longest direction and across it, px.
    height
        Of the centroid above the line of the surface, px.
    clear
        False where a spot touches the line of the surface or the edge of the frame.
    saturated
        True where the camera's scale ends.
    """

    place: FloatArray
    light: FloatArray
    length: FloatArray
    width: FloatArray
    height: FloatArray
    clear: BoolArray
    saturated: BoolArray


def find_spots(frame: NDArray[np.uint8], setup: Setup) -> Spots:
    """Find the patches of light in a frame."""
    lines = setup.instrument.frame_px[1] // frame.shape[0]
    levels = np.cumsum(_histogram(frame))
    # Most of a frame is dark: its median is the background, its lower half tells the noise.
    low, background = np.searchsorted(levels, levels[-1] * np.array([0.1587, 0.5]))
    noise = max(float(background - low), 1.0) / (2.0 * np.sqrt(np.pi) * SMOOTHING_PX)
    core = _core(frame, np.float32(background), np.float32(DETECTION * noise))
    # Wings below the threshold count too: cut off, they would draw centroids to pixel centres.
    spot, boxes = _patches(core, *frame.shape)
    alpha = np.radians(setup.angle)
    surface = (*setup.centre, np.cos(alpha), np.sin(alpha))
    sums = _sums(frame, float(background), spot, core, boxes, lines, surface)
    whole = sums[LIGHT]
    centre = np.stack([sums[COLUMN], sums[ROW]], axis=1)
    mean = 0.5 * (sums[ACROSS] + sums[DOWN])
    apart = np.hypot(0.5 * (sums[ACROSS] - sums[DOWN]), sums[MIXED])
    return Spots(
        place=centre,
        light=whole,
        length=np.sqrt(np.maximum(mean + apart, 0.0)),
        width=np.sqrt(np.maximum(mean - apart, 0.0)),
        height=setup.height(centre),
        clear=sums[NEAR] == 0,
        saturated=sums[FULL] > MOST_SATURATED * sums[CORE],
    )


@_jit
def _histogram(frame):  # type: ignore[no-untyped-def]
    """Number of pixels at each grey level; neighbours, often alike, are counted apart."""
    count = np.zeros((4, BRIGHTEST + 1), dtype=np.int64)
    for i in range(0, frame.shape[0], EVERY):
        for j in range(frame.shape[1]):
            count[j % 4, frame[i, j]] += 1
    return count.sum(axis=0)


@_jit
def _core(frame, background, least):  # type: ignore[no-untyped-def]
    """Where the smoothed light exceeds a least and a share of its maximum: places in order.

    A place is the index in the flat frame. A mean of rows exceeds the threshold only where one of
    them does.
    """
    height, width = frame.shape
    place, light = np.empty(8 * width, dtype=np.int64), np.empty(8 * width, dtype=np.float32)
    found, threshold = 0, least
    # Rows smoothed along themselves, as many as one smoothed row needs: memory would cost more.
    rows = np.empty((2 * REACH + 1, width), dtype=np.float32)
    line, smooth = np.empty(width + 2 * REACH, dtype=np.float32), np.empty_like(rows[0])
    lit = np.zeros((2 * REACH + 1, -(-width // STRETCH)), dtype=np.uint64)
    above = np.zeros(lit.shape[1] * STRETCH, dtype=np.uint8)
    eights = above.view(np.uint64)
    for i in range(-REACH, height + REACH):
        mirrored = -1 - i if i < 0 else i if i < height else 2 * height - 1 - i
        _along(frame[mirrored], background, line, rows[i % 7])
        # A little less, for sums are rounded.
        _mark(rows[i % 7], np.float32(0.999) * threshold, above, eights, lit[i % 7])
        if found + width > place.size:
            place, light = np.append(place, place), np.append(light, light)
        for part in range(lit.shape[1] if i >= REACH else 0):
            if np.any(lit[:, part]):
                begin, end = part * STRETCH, min((part + 1) * STRETCH, width)
                _across(rows, i, begin, end, smooth)
                found, threshold = _above(
                    smooth, begin, end, (i - REACH) * width, place, light, found, threshold
                )
    return place[:found][light[:found] > threshold]


@_jit
def _along(source, background, line, row):  # type: ignore[no-untyped-def]
    """Smooth a row of a frame along itself; its edges are mirrors."""
    width = row.size
    for j in range(width):
        line[j + REACH] = np.float32(source[j]) - background
    for j in range(REACH):
        line[REACH - 1 - j] = line[REACH + j]
        line[REACH + width + j] = line[REACH + width - 1 - j]
    k = KERNEL
    for j in range(width):
        row[j] = (
            k[0] * line[j + 6] + k[1] * line[j + 5] + k[2] * line[j + 4] + k[3] * line[j + 3]
            + k[4] * line[j + 2] + k[5] * line[j + 1] + k[6] * line[j]
        )  # fmt: skip


@_jit
def _mark(row, threshold, above, eights, lit):  # type: ignore[no-untyped-def]
    """Tell in which stretches of a row a pixel is above the threshold: eight are read at once."""
    for j in range(row.size):
        above[j] = row[j] > threshold
    for part in range(lit.size):
        k = 4 * part
        lit[part] = eights[k] | eights[k + 1] | eights[k + 2] | eights[k + 3]


@_jit
def _across(rows, i, begin, end, smooth):  # type: ignore[no-untyped-def]
    """Smooth a stretch of rows, the last of which is row i, across them."""
    k = KERNEL
    a, b, c, d = rows[i % 7], rows[(i - 1) % 7], rows[(i - 2) % 7], rows[(i - 3) % 7]
    e, f, g = rows[(i - 4) % 7], rows[(i - 5) % 7], rows[(i - 6) % 7]
    for j in range(begin, end):
        smooth[j] = (
            k[0] * a[j] + k[1] * b[j] + k[2] * c[j] + k[3] * d[j]
            + k[4] * e[j] + k[5] * f[j] + k[6] * g[j]
        )  # fmt: skip


@_jit
def _above(smooth, begin, end, first, place, light, found, threshold):  # type: ignore[no-untyped-def]
    """Add what exceeds the threshold in a stretch to the places found, and raise the threshold."""
    for j in range(begin, end):
        if smooth[j] > threshold:
            place[found], light[found] = first + j, smooth[j]
            found += 1
            threshold = max(threshold, np.float32(LEAST_BRIGHTNESS * smooth[j]))
    return found, threshold


@_jit
def _patches(core, height, width):  # type: ignore[no-untyped-def]
    """Number, from 1 on, the patches of bright pixels that touch, also by corners, with wings.

    Parameters
    ----------
    core
        Places of bright pixels in the flat frame, ascending.
    height, width
        Of the frame.

    Returns
    -------
    spot, boxes
        Number of the patch at each pixel, 0 elsewhere, where wings meet that of the later one; and
        first row and column of each patch and those after its last, shape (n, 4).
    """
    spot, flat = np.zeros((height, width), dtype=np.int32), core.copy()
    for place in core:
        spot[place // width, place % width] = -1
    # Places patch by patch: each patch grows while it is gone through.
    first, known, number = [0], 0, 0
    for place in core:
        if spot[place // width, place % width] > 0:
            continue
        number += 1
        spot[place // width, place % width] = number
        at, flat[known] = known, place
        known += 1
        while at < known:
            row, column = divmod(flat[at], width)
            at += 1
            for i in range(max(row - 1, 0), min(row + 2, height)):
                for j in range(max(column - 1, 0), min(column + 2, width)):
                    if spot[i, j] < 0:
                        spot[i, j] = number
                        flat[known] = i * width + j
                        known += 1
        first.append(known)
    boxes = np.empty((number, 4), dtype=np.int64)
    for k in range(number):
        # In the same map: where a wing covers a later patch, that comes back.
        boxes[k] = _widen(flat[first[k] : first[k + 1]], k + 1, spot)
    return spot, boxes


@_jit
def _widen(patch, number, spot):  # type: ignore[no-untyped-def]
    """Give the pixels of a patch and its wings its number; its first and last row and column."""
    height, width = spot.shape
    top, left, bottom, right = height, width, 0, 0
    for place in patch:
        row, column = divmod(place, width)
        first, last = max(row - WINGS_PX, 0), min(row + WINGS_PX + 1, height)
        begin, end = max(column - WINGS_PX, 0), min(column + WINGS_PX + 1, width)
        for i in range(first, last):
            for j in range(begin, end):
                spot[i, j] = number
        top, left, bottom, right = (
            min(top, first), min(left, begin), max(bottom, last), max(right, end)
        )  # fmt: skip
    return top, left, bottom, right


@_jit
def _sums(frame, background, spot, core, boxes, lines, surface):  # type: ignore[no-untyped-def]
    """Sums over the pixels of each spot, second moments about its centroid; shape (9, n)."""
    sums = np.zeros((9, len(boxes)))
    x_0, y_0, cos, sin = surface
    height, width = frame.shape
    for place in core:
        row, column = divmod(place, width)
        own = sums[:, spot[row, column] - 1]
        own[CORE] += 1
        y = lines * row + 0.5 * (lines - 1)
        edge = row in (0, height - 1) or column in (0, width - 1)
        own[NEAR] += edge or (column - x_0) * cos - (y - y_0) * sin < SURFACE_PX
    for k in range(len(boxes)):
        top, left, bottom, right = boxes[k]
        light = x = y = full = across = down = mixed = 0.0
        for row in range(top, bottom):
            level = lines * row + 0.5 * (lines - 1)
            for column in range(left, right):
                if spot[row, column] == k + 1:
                    weight = frame[row, column] - background
                    light += weight
                    x += weight * column
                    y += weight * level
                    full += frame[row, column] == BRIGHTEST
        x, y = x / light, y / light
        for row in range(top, bottom):
            dy = lines * row + 0.5 * (lines - 1) - y
            for column in range(left, right):
                if spot[row, column] == k + 1:
                    weight, dx = frame[row, column] - background, column - x
                    across += weight * dx * dx
                    down += weight * dy * dy
                    mixed += weight * dx * dy
        sums[:CORE, k] = light, x, y, across / light, down / light, mixed / light, full
    return sums
