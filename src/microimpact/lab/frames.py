"""Frames of the imaging system: the light of every dash on the pixels of the camera.

The image of a resting sphere is its disk, blurred by a Gaussian. The moving one is summed along
the curved path at steps of less than a pixel, far finer than the blur can tell: the Gaussian part
with the exact integral over each pixel, the disk by its Fourier transform. Everything is computed
in a window around each dash.
"""

from __future__ import annotations

import math
from functools import cache, lru_cache

import numpy as np
import scipy
from numpy.random import Generator
from numpy.typing import NDArray

from microimpact.arrays import FloatArray
from microimpact.lab.events import Impacts, IntArray
from microimpact.lab.exposure import LATER, Exposure, expose
from microimpact.lab.ptis import Instrument, Setup, Systematics
from microimpact.model.compiled import jit

# Samples of the path per blur; the sum then equals the integral to parts in 10^8.
SAMPLES_PER_BLUR = 1.25
# Half width of a window beyond the disk, in blurs.
REACH = 5.5
# Beyond so many blurs a Gaussian has less light (2e-9) than single precision shows.
FAINTEST = 6.0
BRIGHTEST = 255
# Noise of a pixel is one of so many quantiles of the normal distribution: its standard deviation is
# right to 1e-5, and it is drawn in a fifth of the time.
QUANTILES = 2**16

_jit = jit()


def render(
    impacts: Impacts, i: int, setup: Setup, errors: Systematics, rng: Generator
) -> NDArray[np.uint8]:
    """Return the field of video that holds one impact.

    Parameters
    ----------
    impacts, i
        The impacts and which of them.
    setup, errors
        The instrument as set and the errors of the experiment.
    rng
        Of the event; see `ptis.event_generator`.

    Returns
    -------
    array
        Grey levels, shape (rows, columns); half the rows where the camera interlaces.
    """
    exposure = expose(impacts, i, setup, errors, rng)
    return photograph(exposure, float(impacts.diameter[i]), setup, errors, rng)


def photograph(
    exposure: Exposure, diameter: float, setup: Setup, errors: Systematics, rng: Generator
) -> NDArray[np.uint8]:
    """Return the frame, as `render` does, of the exposure of one event.

    Parameters
    ----------
    exposure
        Drawn with the generator of the event.
    diameter
        Of the sphere, m.
    setup, errors, rng
        As in `render`.
    """
    light = image(exposure, diameter, setup, errors)
    instrument = setup.instrument
    if instrument.interlace:
        light = 0.5 * (light[::2] + light[1::2])
    # Sixteen bits at a time of the stream, as ``rng.integers`` takes them at three times the cost.
    draw = rng.bit_generator.random_raw(-(-light.size // 4)).astype("<u8", copy=False).view("<u2")
    frame = np.empty(light.shape, dtype=np.uint8)
    # Most of a frame is dark, and what noise makes of no light is known beforehand.
    _expose(light, draw, _noise(), _dark(instrument), *_camera(instrument), frame)
    return frame


@_jit
def _expose(light, draw, normal, dark, background, electrons, least, frame):  # type: ignore[no-untyped-def]
    """Grey levels of light in counts above the background, each with the noise drawn for it."""
    lights, greys = light.ravel(), frame.ravel()
    for i in range(lights.size):
        if lights[i] > 0.0:
            greys[i] = _grey(lights[i], normal[draw[i]], background, electrons, least)
        else:
            greys[i] = dark[draw[i]]


@_jit
def _grey(light, normal, background, electrons, least):  # type: ignore[no-untyped-def]
    """Grey level with shot noise and the ``least`` variance of reading, in single precision."""
    level = light + background
    level += math.sqrt(level / electrons + least) * normal
    return np.uint8(min(max(np.rint(level), 0.0), BRIGHTEST))


def _camera(instrument: Instrument) -> tuple[np.float32, np.float32, np.float32]:
    """Return background, electrons per count and variance of reading."""
    return (
        np.float32(instrument.background_counts),
        np.float32(instrument.electrons_per_count),
        np.float32(instrument.read_noise_counts**2),
    )


@cache
def _noise() -> NDArray[np.float32]:
    quantiles: NDArray[np.float32] = scipy.special.ndtri(
        (np.arange(QUANTILES) + 0.5) / QUANTILES
    ).astype(np.float32)
    return quantiles


@lru_cache(maxsize=16)
def _dark(instrument: Instrument) -> NDArray[np.uint8]:
    """Return grey levels without light, one for each value of the noise."""
    dark = np.empty(QUANTILES, dtype=np.uint8)
    _darken(_noise(), *_camera(instrument), dark)
    return dark


@_jit
def _darken(normal, background, electrons, least, dark):  # type: ignore[no-untyped-def]
    for i in range(dark.size):
        dark[i] = _grey(np.float32(0.0), normal[i], background, electrons, least)


def image(
    exposure: Exposure, diameter: float, setup: Setup, errors: Systematics
) -> NDArray[np.float32]:
    """Return the light of one field above its background, in counts, before noise.

    The camera's gain is taken to suit the track: its brightest dash, that of the slower leg,
    reaches the peak of the exposure. Dashes that overlap add up, and may saturate.
    """
    width, height = setup.instrument.frame_px
    frame = np.zeros((height, width), dtype=np.float32)
    start = np.maximum(exposure.start, exposure.field[0])
    end = np.minimum(exposure.end, exposure.field[1])
    shown = np.flatnonzero(end > start)
    if shown.size == 0:
        return frame
    path = _sampled(exposure, shown, start[shown], end[shown], setup, errors)
    pad = REACH * setup.instrument.blur_px + 0.5 * diameter / setup.pixel
    near = np.all((path > -pad) & (path < np.array([width, height]) + pad), axis=-1).any(axis=1)
    shown, path = shown[near], path[near]
    if shown.size == 0:
        return frame
    corner, dashes = _windows(path, pad, diameter / setup.pixel, setup.instrument.blur_px)
    dashes *= (end - start)[shown, None, None] * setup.chop_rate
    first_legs = exposure.leg[shown] < LATER
    brightest = dashes[first_legs if np.any(first_legs) else slice(None)].max()
    _add(frame, corner, dashes, float(exposure.peak[0]) / brightest)
    return frame


def _sampled(
    exposure: Exposure,
    shown: IntArray,
    start: FloatArray,
    end: FloatArray,
    setup: Setup,
    errors: Systematics,
) -> FloatArray:
    """Return columns and rows of the path of each dash at equal steps of time, (m, n, 2)."""
    leg = exposure.leg[shown][:, None]
    speed = (
        np.abs(exposure.flight.velocity[leg[:, 0]])
        + np.abs(exposure.flight.gravity)
        * (np.abs(start - exposure.flight.start[leg[:, 0]])[:, None])
    )
    length = np.max(np.linalg.norm(speed, axis=1) * (end - start)) / setup.pixel
    n = max(8, int(np.ceil(SAMPLES_PER_BLUR * length / setup.instrument.blur_px)))
    share = (np.arange(n) + 0.5) / n
    time = start[:, None] + share * (end - start)[:, None]
    return setup.columns_rows(exposure.flight.at(leg, time), errors)


def _windows(path: FloatArray, pad: float, disk: float, blur: float) -> tuple[IntArray, FloatArray]:
    """Return the upper left pixel of each window, (m, 2), and its light, (m, size, size)."""
    low, high = path.min(axis=1) - pad, path.max(axis=1) + pad
    corner = np.floor(low).astype(np.int64)
    size = scipy.fft.next_fast_len(int(np.ceil((high - corner).max())) + 1, real=True)
    light = np.zeros((len(path), size, size))
    _spread(path, corner, blur, light)
    blurred = scipy.fft.irfft2(scipy.fft.rfft2(light) * _disk_transform(size, disk), s=(size, size))
    return corner, np.maximum(blurred, 0.0)


@lru_cache(maxsize=256)
def _disk_transform(size: int, diameter: float) -> FloatArray:
    """Return the Fourier transform of a uniform disk of unit light (diameter in pixels)."""
    frequency = np.hypot(scipy.fft.fftfreq(size)[:, None], scipy.fft.rfftfreq(size))
    x = np.pi * diameter * np.maximum(frequency, 1e-12)
    transform: FloatArray = 2.0 * scipy.special.j1(x) / x
    return transform


@_jit
def _spread(path, corner, blur, light):  # type: ignore[no-untyped-def]
    """Add to the window of each dash a Gaussian, integrated over the pixels, at every sample."""
    dashes, samples = path.shape[:2]
    size = light.shape[1]
    across, down = np.empty(size), np.empty(size)
    for i in range(dashes):
        for k in range(samples):
            left, right = _shares(path[i, k, 0] - corner[i, 0], blur, across)
            top, bottom = _shares(path[i, k, 1] - corner[i, 1], blur, down)
            for row in range(top, bottom):
                share = down[row] / samples
                for column in range(left, right):
                    light[i, row, column] += share * across[column]


@_jit
def _shares(place, blur, share):  # type: ignore[no-untyped-def]
    """Light of a unit Gaussian on each pixel of a row: between which pixels there is any."""
    first = max(int(place - FAINTEST * blur), 0)
    last = min(int(place + FAINTEST * blur) + 2, share.size)
    scale = math.sqrt(0.5) / blur
    before = math.erf((first - 0.5 - place) * scale)
    for i in range(first, last):
        after = math.erf((i + 0.5 - place) * scale)
        share[i] = 0.5 * (after - before)
        before = after
    return first, last


@_jit
def _add(frame, corner, dashes, scale):  # type: ignore[no-untyped-def]
    """Add windows to a frame, leaving out what lies beyond the frame."""
    height, width = frame.shape
    for i in range(dashes.shape[0]):
        left, top = corner[i]
        for row in range(max(top, 0), min(top + dashes.shape[1], height)):
            for column in range(max(left, 0), min(left + dashes.shape[2], width)):
                frame[row, column] += dashes[i, row - top, column - left] * scale
