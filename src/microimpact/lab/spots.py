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
    light = frame[part].astype(np.float32) - np.float32(background)
    smooth = _smoothed(light)
    threshold = max(DETECTION * noise, LEAST_BRIGHTNESS * float(smooth.max()))
    spot, n = _patches(smooth > threshold)
    # Wings below the threshold count too: cut off, they would draw centroids to pixel centres.
    alpha = np.radians(setup.angle)
    sums = _sums(
        frame, light, _widened(spot), spot, n,
        part[0].start, part[1].start, lines, setup.centre, np.cos(alpha), np.sin(alpha),
    )  # fmt: skip
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
    patch = frame[top : row + REACH + 1, left : column + REACH + 1].astype(np.float32) - background
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
def _patches(found):  # type: ignore[no-untyped-def]
    """Number, from 1 on, the patches of true pixels that touch, also by corners; and how many."""
    height, width = found.shape
    spot = np.zeros((height, width), dtype=np.int32)
    open_rows, open_columns = np.empty((2, found.size), dtype=np.int32)
    n = 0
    for i in range(height):
        for j in range(width):
            if not found[i, j] or spot[i, j] > 0:
                continue
            n += 1
            spot[i, j] = n
            open_rows[0], open_columns[0], waiting = i, j, 1
            while waiting > 0:
                waiting -= 1
                row, column = open_rows[waiting], open_columns[waiting]
                for r in range(max(row - 1, 0), min(row + 2, height)):
                    for c in range(max(column - 1, 0), min(column + 2, width)):
                        if found[r, c] and spot[r, c] == 0:
                            spot[r, c] = n
                            open_rows[waiting], open_columns[waiting] = r, c
                            waiting += 1
    return spot, n


@_jit
def _widened(spot):  # type: ignore[no-untyped-def]
    """Patches widened by `WINGS_PX` each way; of two that meet the later one has the pixel."""
    height, width = spot.shape
    wide = np.zeros_like(spot)
    for i in range(height):
        for j in range(width):
            if spot[i, j] > 0:
                for r in range(max(i - WINGS_PX, 0), min(i + WINGS_PX + 1, height)):
                    for c in range(max(j - WINGS_PX, 0), min(j + WINGS_PX + 1, width)):
                        wide[r, c] = max(wide[r, c], spot[i, j])
    return wide


@_jit
def _sums(frame, light, wide, core, n, top, left, lines, centre, cos, sin):  # type: ignore[no-untyped-def]
    """Sums over the pixels of each spot, moments about its centroid; shape (9, n)."""
    sums = np.zeros((9, n))
    for moment in range(2):
        for i in range(wide.shape[0]):
            y = lines * (i + top) + 0.5 * (lines - 1)
            for j in range(wide.shape[1]):
                if wide[i, j] == 0:
                    continue
                spot, weight, x = wide[i, j] - 1, np.float64(light[i, j]), np.float64(j + left)
                if moment == 1:
                    dx, dy = x - sums[COLUMN, spot], y - sums[ROW, spot]
                    sums[ACROSS, spot] += weight * dx * dx
                    sums[DOWN, spot] += weight * dy * dy
                    sums[MIXED, spot] += weight * dx * dy
                    continue
                sums[LIGHT, spot] += weight
                sums[COLUMN, spot] += weight * x
                sums[ROW, spot] += weight * y
                sums[FULL, spot] += frame[i + top, j + left] == BRIGHTEST
                if core[i, j] > 0:
                    sums[CORE, spot] += 1
                    edge = i + top in (0, frame.shape[0] - 1) or j + left in (0, frame.shape[1] - 1)
                    near = (x - centre[0]) * cos - (y - centre[1]) * sin < SURFACE_PX
                    sums[NEAR, spot] += edge or near
        first, last = (ACROSS, MIXED) if moment == 1 else (COLUMN, ROW)
        sums[first : last + 1] /= sums[LIGHT]
    return sums
