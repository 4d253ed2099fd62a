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
    smooth = _smoothed(frame, part, np.float32(background))
    threshold = max(DETECTION * noise, LEAST_BRIGHTNESS * float(smooth.max()))
    # Wings below the threshold count too: cut off, they would draw centroids to pixel centres.
    spot, boxes = _patches(smooth, np.float32(threshold))
    core = smooth > np.float32(threshold)
    alpha = np.radians(setup.angle)
    surface = (*setup.centre, np.cos(alpha), np.sin(alpha))
    sums = _sums(frame, float(background), spot, core, boxes, part, lines, surface)
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


def _part_with_light(
    frame: NDArray[np.uint8], background: float, least: float
) -> tuple[int, int, int, int]:
    """Return the part of a frame outside which no smoothed light can exceed the threshold.

    First row and column, and those after the last.
    The threshold is at least `least` and the share `LEAST_BRIGHTNESS` of the smoothed brightest
    pixel; a mean exceeds it only where a pixel does. The margin holds what smoothing and wings
    reach.
    """
    row, column = divmod(int(np.argmax(frame)), frame.shape[1])
    height, width = frame.shape
    top, left = max(row - REACH, 0), max(column - REACH, 0)
    patch = top, left, min(row + REACH + 1, height), min(column + REACH + 1, width)
    peak = _smoothed(frame, patch, np.float32(background))[row - top, column - left]
    threshold = max(least, LEAST_BRIGHTNESS * float(peak))
    # A little less, for sums are rounded.
    lit = frame > int(background + 0.999 * threshold)
    ends = []
    for axis, size in ((1, height), (0, width)):
        (index,) = np.nonzero(lit.any(axis=axis))
        low, high = (int(index[0]), int(index[-1])) if index.size else (0, 0)
        ends.append((max(low - 3 * REACH, 0), min(high + 3 * REACH + 1, size)))
    return ends[0][0], ends[1][0], ends[0][1], ends[1][1]


@_jit
def _histogram(frame):  # type: ignore[no-untyped-def]
    """Number of pixels at each grey level; neighbours, often alike, are counted apart."""
    count = np.zeros((4, BRIGHTEST + 1), dtype=np.int64)
    grey = frame.ravel()
    for i in range(grey.size):
        count[i % 4, grey[i]] += 1
    return count.sum(axis=0)


@_jit
def _smoothed(frame, part, background):  # type: ignore[no-untyped-def]
    """Light of a part, above the background, convolved with `KERNEL`; its edges are mirrors."""
    top, left, bottom, right = part
    height, width = bottom - top, right - left
    smooth = np.empty((height, width), dtype=np.float32)
    line = np.empty(width + 2 * REACH, dtype=np.float32)
    # Rows smoothed along themselves, as many as one smoothed row needs: memory would cost more.
    rows = np.empty((2 * REACH + 1, width), dtype=np.float32)
    k = KERNEL
    for i in range(-REACH, height + REACH):
        mirrored = -1 - i if i < 0 else i if i < height else 2 * height - 1 - i
        source = frame[top + mirrored]
        for j in range(width):
            line[j + REACH] = np.float32(source[left + j]) - background
        for j in range(REACH):
            line[REACH - 1 - j] = line[REACH + j]
            line[REACH + width + j] = line[REACH + width - 1 - j]
        row = rows[i % 7]
        for j in range(width):
            row[j] = (
                k[0] * line[j + 6] + k[1] * line[j + 5] + k[2] * line[j + 4] + k[3] * line[j + 3]
                + k[4] * line[j + 2] + k[5] * line[j + 1] + k[6] * line[j]
            )  # fmt: skip
        if i < REACH:
            continue
        a, b, c, d = rows[i % 7], rows[(i - 1) % 7], rows[(i - 2) % 7], rows[(i - 3) % 7]
        e, f, g = rows[(i - 4) % 7], rows[(i - 5) % 7], rows[(i - 6) % 7]
        row = smooth[i - REACH]
        for j in range(width):
            row[j] = (
                k[0] * a[j] + k[1] * b[j] + k[2] * c[j] + k[3] * d[j]
                + k[4] * e[j] + k[5] * f[j] + k[6] * g[j]
            )  # fmt: skip
    return smooth


@_jit
def _patches(smooth, threshold):  # type: ignore[no-untyped-def]
    """Number, from 1 on, the patches of bright pixels that touch, also by corners, with wings.

    Returns
    -------
    spot, boxes
        Number of the patch at each pixel, 0 elsewhere, where wings meet that of the later one; and
        first row and column of each patch and those after its last, shape (n, 4).
    """
    height, width = smooth.shape
    spot = np.zeros((height, width), dtype=np.int32)
    boxes: list[tuple[int, int, int, int]] = []
    patches: list[list[tuple[int, int]]] = []
    for i in range(height):
        for j in range(width):
            if smooth[i, j] > threshold and spot[i, j] == 0:
                spot[i, j] = len(boxes) + 1
                patch = _patch(smooth, threshold, spot, i, j)
                boxes.append(_box(patch, height, width))
                patches.append(patch)
    # In the same map, for memory is dear: where a wing covers a later patch, that comes back.
    for k in range(len(patches)):
        for row, column in patches[k]:
            for i in range(max(row - WINGS_PX, 0), min(row + WINGS_PX + 1, height)):
                for j in range(max(column - WINGS_PX, 0), min(column + WINGS_PX + 1, width)):
                    spot[i, j] = k + 1
    found = np.empty((len(boxes), 4), dtype=np.int64)
    for k in range(len(boxes)):
        found[k] = boxes[k]
    return spot, found


@_jit
def _patch(smooth, threshold, spot, row, column):  # type: ignore[no-untyped-def]
    """Pixels of the patch that holds a bright pixel; they take its number."""
    height, width = smooth.shape
    pixels, number = [(row, column)], spot[row, column]
    # The list grows while it is gone through.
    at = 0
    while at < len(pixels):
        row, column = pixels[at]
        at += 1
        for i in range(max(row - 1, 0), min(row + 2, height)):
            for j in range(max(column - 1, 0), min(column + 2, width)):
                if smooth[i, j] > threshold and spot[i, j] == 0:
                    spot[i, j] = number
                    pixels.append((i, j))
    return pixels


@_jit
def _box(pixels, height, width):  # type: ignore[no-untyped-def]
    """First row and column of pixels with their wings, and those after the last."""
    top, left = bottom, right = pixels[0]
    for row, column in pixels:
        top, left = min(top, row), min(left, column)
        bottom, right = max(bottom, row), max(right, column)
    first = max(top - WINGS_PX, 0), max(left - WINGS_PX, 0)
    return *first, min(bottom + WINGS_PX + 1, height), min(right + WINGS_PX + 1, width)


@_jit
def _sums(frame, background, spot, core, boxes, part, lines, surface):  # type: ignore[no-untyped-def]
    """Sums over the pixels of each spot, second moments about its centroid; shape (9, n)."""
    sums = np.zeros((9, len(boxes)))
    x_0, y_0, cos, sin = surface
    height, width = frame.shape
    for k in range(len(boxes)):
        top, left, bottom, right = boxes[k]
        own = sums[:, k]
        for i in range(top, bottom):
            row = i + part[0]
            y = lines * row + 0.5 * (lines - 1)
            for j in range(left, right):
                if spot[i, j] != k + 1:
                    continue
                column = j + part[1]
                weight = frame[row, column] - background
                own[LIGHT] += weight
                own[COLUMN] += weight * column
                own[ROW] += weight * y
                own[FULL] += frame[row, column] == BRIGHTEST
                if core[i, j]:
                    own[CORE] += 1
                    edge = row in (0, height - 1) or column in (0, width - 1)
                    own[NEAR] += edge or (column - x_0) * cos - (y - y_0) * sin < SURFACE_PX
        own[COLUMN] /= own[LIGHT]
        own[ROW] /= own[LIGHT]
        for i in range(top, bottom):
            row = i + part[0]
            dy = lines * row + 0.5 * (lines - 1) - own[ROW]
            for j in range(left, right):
                if spot[i, j] == k + 1:
                    column = j + part[1]
                    weight, dx = frame[row, column] - background, column - own[COLUMN]
                    own[ACROSS] += weight * dx * dx
                    own[DOWN] += weight * dy * dy
                    own[MIXED] += weight * dx * dy
        own[ACROSS : MIXED + 1] /= own[LIGHT]
    return sums
