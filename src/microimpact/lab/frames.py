"""Frames of the imaging system: the light of every dash on the pixels of the camera.

The image of a resting sphere is its disk, blurred by a Gaussian. The moving one is summed along
the curved path at steps of less than a pixel, far finer than the blur can tell: the Gaussian part
with the exact integral over each pixel, the disk by its Fourier transform. Everything is computed
in a window around each dash.
"""

from __future__ import annotations

from functools import cache, lru_cache

import numpy as np
import scipy
from numpy.random import Generator
from numpy.typing import NDArray

from microimpact.arrays import FloatArray
from microimpact.lab.events import Impacts, IntArray
from microimpact.lab.exposure import LATER, Exposure, expose
from microimpact.lab.ptis import Instrument, Setup, Systematics

# Samples of the path per blur; the sum then equals the integral to parts in 10^8.
SAMPLES_PER_BLUR = 1.25
# Half width of a window beyond the disk, in blurs.
REACH = 5.5
BRIGHTEST = 255
# Noise of a pixel is one of so many quantiles of the normal distribution: its standard deviation is
# right to 1e-5, and it is drawn in a fifth of the time.
QUANTILES = 2**16


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
    draw = rng.integers(QUANTILES, size=light.shape, dtype=np.uint16)
    # Most of a frame is dark, and what noise makes of no light is known beforehand.
    frame = _dark(instrument)[draw]
    lit = np.flatnonzero(light.ravel() > 0.0)
    frame.ravel()[lit] = _grey(light.ravel()[lit], _noise()[draw.ravel()[lit]], instrument)
    return frame


def _grey(
    light: NDArray[np.float32], normal: NDArray[np.float32], instrument: Instrument
) -> NDArray[np.uint8]:
    """Return grey levels of light in counts above the background, with shot and read noise."""
    level = light + np.float32(instrument.background_counts)
    noise = level / np.float32(instrument.electrons_per_count)
    noise += np.float32(instrument.read_noise_counts**2)
    np.sqrt(noise, out=noise)
    noise *= normal
    level += noise
    return np.clip(np.rint(level, out=level), 0, BRIGHTEST, out=level).astype(np.uint8)


@cache
def _noise() -> NDArray[np.float32]:
    quantiles: NDArray[np.float32] = scipy.special.ndtri(
        (np.arange(QUANTILES) + 0.5) / QUANTILES
    ).astype(np.float32)
    return quantiles


@lru_cache(maxsize=16)
def _dark(instrument: Instrument) -> NDArray[np.uint8]:
    """Return grey levels without light, one for each value of the noise."""
    return _grey(np.zeros(QUANTILES, dtype=np.float32), _noise(), instrument)


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
    for (column, row), dash in zip(corner, dashes * (exposure.peak / brightest), strict=True):
        _add(frame, dash, int(column), int(row))
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
    edges = np.arange(size + 1) - 0.5 + corner[:, :, None, None]
    passed = scipy.special.ndtr((edges - path.transpose(0, 2, 1)[..., None]) / blur)
    within = np.diff(passed, axis=-1)
    across, down = within[:, 0], within[:, 1]
    light = np.matmul(down.transpose(0, 2, 1), across) / path.shape[1]
    blurred = scipy.fft.irfft2(scipy.fft.rfft2(light) * _disk_transform(size, disk), s=(size, size))
    return corner, np.maximum(blurred, 0.0)


@lru_cache(maxsize=256)
def _disk_transform(size: int, diameter: float) -> FloatArray:
    """Return the Fourier transform of a uniform disk of unit light (diameter in pixels)."""
    frequency = np.hypot(scipy.fft.fftfreq(size)[:, None], scipy.fft.rfftfreq(size))
    x = np.pi * diameter * np.maximum(frequency, 1e-12)
    transform: FloatArray = 2.0 * scipy.special.j1(x) / x
    return transform


def _add(frame: NDArray[np.float32], dash: FloatArray, column: int, row: int) -> None:
    """Add a window to a frame, leaving out what lies beyond the frame."""
    height, width = frame.shape
    top, left = max(row, 0), max(column, 0)
    bottom, right = min(row + dash.shape[0], height), min(column + dash.shape[1], width)
    if top < bottom and left < right:
        frame[top:bottom, left:right] += dash[
            top - row : bottom - row, left - column : right - column
        ]
