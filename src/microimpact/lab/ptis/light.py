"""The light of every dash on the pixels of the camera.

The image of a resting sphere is its disk, blurred by a Gaussian. The moving one is summed along
the curved path at steps of less than a pixel, far finer than the blur can tell: the Gaussian part
with the exact integral over each pixel, the disk by its Fourier transform. Everything is computed
in a window around each dash.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import NDArray

from microimpact.core.arrays import FloatArray
from microimpact.core.compiled import jit
from microimpact.lab.events import IntArray
from microimpact.lab.ptis.exposure import LATER, LEGS, Exposure, Flight
from microimpact.lab.ptis.system import Setup, Systematics

# Samples of the path per blur; within a dash the sum then equals the integral to parts in 10^8.
SAMPLES_PER_BLUR = 1.25
# Half width of a window beyond the disk, in blurs.
REACH = 5.5
# Beyond so many blurs a Gaussian has less light (2e-9) than single precision shows.
FAINTEST = 6.0
# Steps per pixel of the table of a Gaussian's light; cubics between them are right to 1e-9.
STEPS = 64

_jit = jit()


def lights(
    exposure: Exposure, diameter: FloatArray, setup: Setup, errors: Systematics
) -> Iterator[tuple[NDArray[np.float32], IntArray]]:
    """Yield the light of each event and the boxes that hold it: left, top, right, bottom, (m, 4).

    The light is that of one field above its background, in counts, before noise. The camera's
    gain is taken to suit the track: its brightest dash, that of the slower leg, reaches the peak
    of the exposure. Dashes that overlap add up, and may saturate. The array is the same every
    time, for memory is dear.
    """
    size, blur = np.array(setup.instrument.frame_px), setup.instrument.blur_px
    event = exposure.event
    start = np.maximum(exposure.start, exposure.field[0][event])
    end = np.minimum(exposure.end, exposure.field[1][event])
    shown = np.flatnonzero(end > start)
    event, leg, start, end = event[shown], exposure.leg[shown], start[shown], end[shown]
    # A path under gravity is the parabola through three of its points.
    time = np.stack([start, 0.5 * (start + end), end], axis=1)
    points = setup.columns_rows(exposure.flight.at(leg[:, None], time), errors)
    length = _longest(exposure.flight, leg, start, end) / setup.pixel
    bright, first = (end - start) * setup.chop_rate, leg % LEGS < LATER
    disk = diameter / setup.pixel
    bounds = np.searchsorted(event, np.arange(len(exposure) + 1))
    frame = np.empty(size[::-1], dtype=np.float32)
    for i, (begin, stop) in enumerate(pairwise(bounds.tolist())):
        frame.fill(0.0)
        boxes = np.empty((0, 4), dtype=np.int64)
        own, pad = slice(begin, stop), REACH * blur + 0.5 * disk[i]
        n = max(8, int(np.ceil(SAMPLES_PER_BLUR * length[own].max(initial=0.0) / blur)))
        path = _parabola(n) @ points[own]
        near = np.all((path > -pad) & (path < size + pad), axis=-1).any(axis=1)
        if np.any(near):
            corner, dashes = _windows(path[near], pad, float(disk[i]), blur)
            boxes = np.clip(np.hstack([corner, corner + dashes.shape[1]]), 0, np.tile(size, 2))
            peaks = dashes.max(axis=(1, 2)) * bright[own][near]
            of = first[own][near]
            scale = exposure.peak[i] / peaks[of if np.any(of) else slice(None)].max()
            _add(frame, boxes, corner, dashes, scale * bright[own][near])
        yield frame, boxes


def _longest(flight: Flight, leg: IntArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Return a length, m, shape (m,), that pieces of legs do not exceed."""
    fallen = np.abs(start - flight.start[leg])[:, None] * np.abs(flight.gravity)
    speed = np.linalg.norm(np.abs(flight.velocity[leg]) + fallen, axis=1)
    longest: FloatArray = speed * (end - start)
    return longest


@lru_cache(maxsize=256)
def _parabola(n: int) -> FloatArray:
    """Return the weights of first, middle and last point in n others between them, (n, 3)."""
    t = 2.0 * (np.arange(n) + 0.5) / n - 1.0
    return np.stack([0.5 * t * (t - 1.0), 1.0 - t**2, 0.5 * t * (t + 1.0)], axis=1)


def _windows(
    path: FloatArray, pad: float, disk: float, blur: float
) -> tuple[IntArray, NDArray[np.float32]]:
    """Return the upper left pixel of each window, (m, 2), and its light, (m, size, size)."""
    low, high = path.min(axis=1) - pad, path.max(axis=1) + pad
    corner = np.floor(low).astype(np.int64)
    size = scipy.fft.next_fast_len(int(np.ceil((high - corner).max())) + 1, real=True)
    light = np.zeros((len(path), size, size), dtype=np.float32)
    _spread(path, corner, *_gaussian(blur), light)
    transform = scipy.fft.rfft2(light, overwrite_x=True)
    transform *= _disk_transform(size, disk)
    return corner, scipy.fft.irfft2(transform, s=(size, size), overwrite_x=True)


@lru_cache(maxsize=256)
def _disk_transform(size: int, diameter: float) -> NDArray[np.float32]:
    """Return the Fourier transform of a uniform disk of unit light (diameter in pixels)."""
    frequency = np.hypot(scipy.fft.fftfreq(size)[:, None], scipy.fft.rfftfreq(size))
    x = np.pi * diameter * np.maximum(frequency, 1e-12)
    transform: NDArray[np.float32] = (2.0 * scipy.special.j1(x) / x).astype(np.float32)
    return transform


@lru_cache(maxsize=16)
def _gaussian(blur: float) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return what a Gaussian of unit light gives to the pixels of a row, and its slope.

    Shape (STEPS + 1, pixels): the centre lies 0 to 1 pixel, by steps, beyond that of the middle
    pixel; the slope is per step.
    """
    reach = int(np.ceil(FAINTEST * blur))
    place = np.arange(-reach, reach + 2) - np.arange(STEPS + 1)[:, None] / STEPS
    ends = (place[..., None] + [-0.5, 0.5]) / blur
    density = np.exp(-0.5 * ends**2) / (np.sqrt(2.0 * np.pi) * blur * STEPS)
    share, slope = np.diff(scipy.special.ndtr(ends))[..., 0], -np.diff(density)[..., 0]
    return share.astype(np.float32), slope.astype(np.float32)


@_jit
def _spread(path, corner, share, slope, light):  # type: ignore[no-untyped-def]
    """Add to the window of each dash a Gaussian, integrated over the pixels, at every sample."""
    dashes, samples = path.shape[:2]
    size, pixels = light.shape[1], share.shape[1]
    across, down = np.empty(pixels, dtype=np.float32), np.empty(pixels, dtype=np.float32)
    for i in range(dashes):
        for k in range(samples):
            left = _shares(path[i, k, 0] - corner[i, 0], share, slope, across)
            top = _shares(path[i, k, 1] - corner[i, 1], share, slope, down)
            first, last = max(-left, 0), min(size - left, pixels)
            for row in range(max(-top, 0), min(size - top, pixels)):
                weight = down[row] / np.float32(samples)
                line = light[i, top + row]
                for column in range(first, last):
                    line[left + column] += weight * across[column]


@_jit
def _shares(place, share, slope, found):  # type: ignore[no-untyped-def]
    """Light of a unit Gaussian on the pixels of a row, and which of them is the first of these.

    By cubics between the steps of the table.
    """
    middle = math.floor(place)
    step = (place - middle) * STEPS
    at = min(int(step), STEPS - 1)
    t = np.float32(step - at)
    rest = np.float32(1.0) - t
    b = t * t * (np.float32(3.0) - t - t)
    a, c, d = np.float32(1.0) - b, t * rest * rest, t * t * rest
    for i in range(found.size):
        found[i] = a * share[at, i] + b * share[at + 1, i] + c * slope[at, i] - d * slope[at + 1, i]
    return int(middle) - (found.size - 2) // 2


@_jit
def _add(frame, boxes, corner, dashes, scale):  # type: ignore[no-untyped-def]
    """Add to a frame the part of each window that lies in it."""
    for i in range(dashes.shape[0]):
        left, top, right, bottom = boxes[i]
        for row in range(top, bottom):
            for column in range(left, right):
                light = dashes[i, row - corner[i, 1], column - corner[i, 0]]
                frame[row, column] += max(light, np.float32(0.0)) * np.float32(scale[i])
