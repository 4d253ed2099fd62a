"""Patches of light in a frame: what is found of dashes (Section 2.1).

Dashes are found by their light, and their centroids are used, never their ends: the size of the
sphere lengthens a dash by its diameter and leaves its centroid alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from microimpact.arrays import BoolArray, FloatArray
from microimpact.lab.frames import BRIGHTEST
from microimpact.lab.ptis import Setup
from microimpact.model.compiled import jit

# Detection: a frame is smoothed by this Gaussian (px); what exceeds both so many deviations of the
# smoothed noise and this share of the brightest spot is light of a dash.
SMOOTHING_PX = 1.0
REACH = 3
KERNEL = np.exp(-((np.arange(2 * REACH + 1) - REACH) ** 2) / (2.0 * SMOOTHING_PX * SMOOTHING_PX))
KERNEL = (KERNEL / KERNEL.sum()).astype(np.float32)
DETECTION = 6.0
LEAST_BRIGHTNESS = 0.1
# Spots are widened by this much to hold the light of their wings.
WINGS_PX = 2
# Light this close to the line of the surface (px) may be that of a dash bent by the impact.
SURFACE_PX = 2.0
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
    low, background = np.searchsorted(levels, frame.size * np.array([0.1587, 0.5]))
    noise = max(float(background - low), 1.0) / (2.0 * np.sqrt(np.pi) * SMOOTHING_PX)
    part = _part_with_light(frame, float(background), DETECTION * noise)
    light = frame[part] - np.float32(background)
    smooth = _smoothed(light)
    threshold = max(DETECTION * noise, LEAST_BRIGHTNESS * float(smooth.max()))
    core, boxes = _patches(smooth, np.float32(threshold))
    # Wings below the threshold count too: cut off, they would draw centroids to pixel centres.
    wide = _widened(core, boxes)
    alpha = np.radians(setup.angle)
    surface = (*setup.centre, np.cos(alpha), np.sin(alpha))
    corner = part[0].start, part[1].start
    sums = _sums(frame, light, core, wide, boxes, corner, lines, surface)
    whole = sums[LIGHT]
    centre = sums[[COLUMN, ROW]].T
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


def _part_with_light(
    frame: NDArray[np.uint8], background: float, least: float
) -> tuple[slice, slice]:
    """Return rows and columns outside which no smoothed light can exceed the threshold.

    The threshold is at least `least` and the share `LEAST_BRIGHTNESS` of the smoothed brightest
    pixel; a mean exceeds it only where a pixel does. The margin holds what smoothing and wings
    reach.
    """
    row, column = divmod(int(np.argmax(frame)), frame.shape[1])
    top, left = max(row - REACH, 0), max(column - REACH, 0)
    patch = frame[top : row + REACH + 1, left : column + REACH + 1] - np.float32(background)
    peak = _smoothed(patch)[row - top, column - left]
    threshold = max(least, LEAST_BRIGHTNESS * float(peak))
    # A little less, for sums are rounded.
    lit = frame > int(background + 0.999 * threshold)
    slices = []
    for axis in (1, 0):
        (index,) = np.nonzero(lit.any(axis=axis))
        low, high = (index[0], index[-1]) if index.size else (0, 0)
        margin = 3 * REACH
        slices.append(slice(max(int(low) - margin, 0), int(high) + margin + 1))
    return slices[0], slices[1]


@_jit
def _histogram(frame):  # type: ignore[no-untyped-def]
    """Number of pixels at each grey level; neighbours, often alike, are counted apart."""
    count = np.zeros((4, BRIGHTEST + 1), dtype=np.int64)
    grey = frame.ravel()
    for i in range(grey.size):
        count[i % 4, grey[i]] += 1
    return count.sum(axis=0)


@_jit
def _smoothed(light):  # type: ignore[no-untyped-def]
    """Convolution with `KERNEL` along both axes; edges are mirrors."""
    height, width = light.shape
    line = np.empty(width + 2 * REACH, dtype=np.float32)
    half = np.empty((height + 2 * REACH, width), dtype=np.float32)
    smooth = np.empty((height, width), dtype=np.float32)
    k = KERNEL
    for i in range(height):
        for j in range(width):
            line[j + REACH] = light[i, j]
        for j in range(1, REACH + 1):
            line[REACH - j] = line[REACH - 1 + j]
            line[REACH + width - 1 + j] = line[REACH + width - j]
        row = half[i + REACH]
        for j in range(width):
            row[j] = (
                k[0] * line[j + 6] + k[1] * line[j + 5] + k[2] * line[j + 4] + k[3] * line[j + 3]
                + k[4] * line[j + 2] + k[5] * line[j + 1] + k[6] * line[j]
            )  # fmt: skip
    for i in range(1, REACH + 1):
        half[REACH - i] = half[REACH - 1 + i]
        half[REACH + height - 1 + i] = half[REACH + height - i]
    for i in range(height):
        for j in range(width):
            smooth[i, j] = (
                k[0] * half[i + 6, j] + k[1] * half[i + 5, j] + k[2] * half[i + 4, j]
                + k[3] * half[i + 3, j] + k[4] * half[i + 2, j] + k[5] * half[i + 1, j]
                + k[6] * half[i, j]
            )  # fmt: skip
    return smooth


@_jit
def _patches(smooth, threshold):  # type: ignore[no-untyped-def]
    """Number, from 1 on, the patches of bright pixels that touch, also by corners.

    Returns
    -------
    core, boxes
        Number at each bright pixel, 0 elsewhere; first row and column of each patch, and the ones
        after its last, shape (n, 4), widened by `WINGS_PX`.
    """
    height, width = smooth.shape
    core = np.zeros((height, width), dtype=np.int32)
    rows, columns = np.empty((2, smooth.size), dtype=np.int32)
    boxes = []
    for i in range(height):
        for j in range(width):
            if smooth[i, j] <= threshold or core[i, j] > 0:
                continue
            number, waiting = len(boxes) + 1, 1
            core[i, j], rows[0], columns[0] = number, i, j
            top, left, bottom, right = i, j, i, j
            while waiting > 0:
                waiting -= 1
                row, column = rows[waiting], columns[waiting]
                bottom, left, right = max(bottom, row), min(left, column), max(right, column)
                for r in range(max(row - 1, 0), min(row + 2, height)):
                    for c in range(max(column - 1, 0), min(column + 2, width)):
                        if smooth[r, c] > threshold and core[r, c] == 0:
                            core[r, c], rows[waiting], columns[waiting] = number, r, c
                            waiting += 1
            first = max(top - WINGS_PX, 0), max(left - WINGS_PX, 0)
            last = min(bottom + WINGS_PX + 1, height), min(right + WINGS_PX + 1, width)
            boxes.append(first + last)
    found = np.empty((len(boxes), 4), dtype=np.int64)
    for k in range(len(boxes)):
        found[k] = boxes[k]
    return core, found


@_jit
def _widened(core, boxes):  # type: ignore[no-untyped-def]
    """Patches widened by `WINGS_PX` each way; of two that meet the later one has the pixel."""
    wide = np.zeros_like(core)
    for k in range(len(boxes)):
        top, left, bottom, right = boxes[k]
        for i in range(top, bottom):
            for j in range(left, right):
                if core[i, j] == k + 1:
                    wide[
                        max(i - WINGS_PX, top) : i + WINGS_PX + 1,
                        max(j - WINGS_PX, left) : j + WINGS_PX + 1,
                    ] = k + 1
    return wide


@_jit
def _sums(frame, light, core, wide, boxes, corner, lines, surface):  # type: ignore[no-untyped-def]
    """Sums over the pixels of each spot, second moments about its centroid; shape (9, n)."""
    sums = np.zeros((9, len(boxes)))
    x_0, y_0, cos, sin = surface
    height, width = frame.shape
    for k in range(len(boxes)):
        top, left, bottom, right = boxes[k]
        own = sums[:, k]
        for i in range(top, bottom):
            row = i + corner[0]
            y = lines * row + 0.5 * (lines - 1)
            for j in range(left, right):
                if wide[i, j] != k + 1:
                    continue
                column, weight = j + corner[1], np.float64(light[i, j])
                own[LIGHT] += weight
                own[COLUMN] += weight * column
                own[ROW] += weight * y
                own[FULL] += frame[row, column] == BRIGHTEST
                if core[i, j] > 0:
                    own[CORE] += 1
                    edge = row in (0, height - 1) or column in (0, width - 1)
                    own[NEAR] += edge or (column - x_0) * cos - (y - y_0) * sin < SURFACE_PX
        own[COLUMN] /= own[LIGHT]
        own[ROW] /= own[LIGHT]
        for i in range(top, bottom):
            dy = lines * (i + corner[0]) + 0.5 * (lines - 1) - own[ROW]
            for j in range(left, right):
                if wide[i, j] == k + 1:
                    dx, weight = j + corner[1] - own[COLUMN], np.float64(light[i, j])
                    own[ACROSS] += weight * dx * dx
                    own[DOWN] += weight * dy * dy
                    own[MIXED] += weight * dx * dy
        own[ACROSS : MIXED + 1] /= own[LIGHT]
    return sums
