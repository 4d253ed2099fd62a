"""Frames of the imaging system: light of every dash, and noise, as grey levels of the camera.

The image of a resting sphere is its disk, blurred by a Gaussian. The moving one is summed along
the curved path at steps of less than a pixel, far finer than the blur can tell: the Gaussian part
with the exact integral over each pixel, the disk by its Fourier transform. Everything is computed
in a window around each dash.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cache

import numpy as np
import scipy
from numpy.random import Generator
from numpy.typing import NDArray

from microimpact.core.arrays import FloatArray
from microimpact.lab.events import Impacts, IntArray
from microimpact.lab.ptis.exposure import LATER, LEGS, Exposure, exposures
from microimpact.lab.ptis.system import ImagingSystem, Setup, Systematics

BRIGHTEST = 255
# Samples of the path per blur; within a dash the sum then equals the integral to parts in 10^8.
SAMPLES_PER_BLUR = 1.25
FEWEST_SAMPLES = 8
# Half width of a window beyond the disk, in blurs.
REACH = 5.5
# Noise of a pixel is one of these quantiles of the normal distribution: its standard deviation is
# right to 1e-5, and it is drawn in half the time.
QUANTILES = 2**16


def render(
    impacts: Impacts, i: int, setup: Setup, errors: Systematics, rng: Generator
) -> NDArray[np.uint8]:
    """Return the field of video that holds one impact: grey levels, shape (rows, columns).

    Parameters
    ----------
    impacts
        Impacts of several spheres.
    i
        Number of the impact.
    setup
        Imaging system as it is set.
    errors
        Systematic errors of the experiment.
    rng
        Generator of the event.
    """
    exposure = exposures(impacts.select(slice(i, i + 1)), setup, errors, [rng])
    return next(photographs(exposure, setup, errors, [rng]))


def photographs(
    exposure: Exposure, setup: Setup, errors: Systematics, rngs: Iterable[Generator]
) -> Iterator[NDArray[np.uint8]]:
    """Yield the frame of every event of an exposure, as `render`.

    Parameters
    ----------
    exposure
        Lit pieces of n events.
    setup
        Imaging system as it is set.
    errors
        Systematic errors of the experiment.
    rngs
        A generator for each event.
    """
    for i, rng in zip(range(len(exposure)), rngs, strict=True):
        light = light_of(exposure.select(np.array([i])), setup, errors)
        yield photograph(light, setup.instrument, rng)


def light_of(exposure: Exposure, setup: Setup, errors: Systematics) -> NDArray[np.float32]:
    """Return the light of one event in its field, counts above the background, before noise.

    The camera's gain is taken to suit the track: its brightest dash, that of the slower leg,
    reaches the peak of the exposure. Dashes that overlap add up, and may saturate.

    Parameters
    ----------
    exposure
        Lit pieces of a single event.
    setup
        Imaging system as it is set.
    errors
        Systematic errors of the experiment.
    """
    size, blur = np.array(setup.instrument.frame_px), setup.instrument.blur_px
    frame = np.zeros(size[::-1], dtype=np.float32)
    piece, start, end = exposure.dashes()
    disk = float(exposure.diameter[0]) / setup.pixel
    pad = REACH * blur + 0.5 * disk
    ends = exposure.places(piece, np.stack([start, end], axis=1), setup, errors)
    way = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).max(initial=0.0)
    n = max(FEWEST_SAMPLES, int(np.ceil(SAMPLES_PER_BLUR * way / blur)))
    time = start[:, None] + (end - start)[:, None] * (np.arange(n) + 0.5) / n
    path = exposure.places(piece, time, setup, errors)
    near = np.all((path > -pad) & (path < size + pad), axis=-1).any(axis=1)
    if not np.any(near):
        return frame
    corner, dashes = _windows(path[near], pad, disk, blur)
    bright = ((end - start) * setup.chop_rate)[near]
    first = exposure.leg[piece[near]] % LEGS < LATER
    peaks = dashes.max(axis=(1, 2)) * bright
    scale = exposure.peak[0] / peaks[first if np.any(first) else slice(None)].max()
    for (left, top), light, weight in zip(corner, dashes, scale * bright, strict=True):
        rows = slice(max(top, 0), top + len(light))
        columns = slice(max(left, 0), left + len(light))
        part = frame[rows, columns]
        inside = light[rows.start - top :, columns.start - left :]
        part += weight * np.maximum(inside[: part.shape[0], : part.shape[1]], 0.0)
    return frame


def _windows(path: FloatArray, pad: float, disk: float, blur: float) -> tuple[IntArray, FloatArray]:
    """Return the upper left pixel of each window, (m, 2), and its light, (m, side, side)."""
    corner = np.floor(path.min(axis=1) - pad).astype(np.int64)
    widest = np.ceil(path.max(axis=1) + pad) - corner
    side = scipy.fft.next_fast_len(int(widest.max()) + 1, real=True)
    # Shares of a Gaussian at each point of the path on each column and each row of the window.
    edges = np.arange(side + 1) - 0.5
    offset = (path - corner[:, None])[..., None]
    share = np.diff(scipy.special.ndtr((edges - offset) / blur))
    light = np.swapaxes(share[:, :, 1], 1, 2) @ share[:, :, 0] / path.shape[1]
    return corner, through_disk(light, disk)


def through_disk(light: FloatArray, diameter: float) -> FloatArray:
    """Return windows of light (..., side, side) convolved with a uniform disk of unit light."""
    side = light.shape[-1]
    disk = scipy.ndimage.fourier_ellipsoid(np.ones((side, side // 2 + 1)), diameter, n=side)
    spread: FloatArray = scipy.fft.irfft2(scipy.fft.rfft2(light) * disk, s=(side, side))
    return spread


def photograph(
    light: NDArray[np.float32], instrument: ImagingSystem, rng: Generator
) -> NDArray[np.uint8]:
    """Return grey levels of light, with shot and reading noise.

    Most of a frame is dark, and what noise makes of no light is known beforehand.

    Parameters
    ----------
    light
        Counts above the background, (rows, columns).
    instrument
        Camera, with its noise.
    rng
        Generator of the noise.
    """
    draw = rng.integers(0, QUANTILES, light.shape, dtype=np.uint16)
    frame = _dark(instrument).take(draw)
    lit = light > 0.0
    frame[lit] = _grey(light[lit], _normal()[draw[lit]], instrument)
    return frame


def _grey(
    light: NDArray[np.float32], normal: NDArray[np.float32], instrument: ImagingSystem
) -> NDArray[np.uint8]:
    level = light + instrument.background_counts
    variance = level / instrument.electrons_per_count + instrument.read_noise_counts**2
    grey: FloatArray = np.rint(level + np.sqrt(variance) * normal)
    return grey.clip(0.0, BRIGHTEST).astype(np.uint8)


@cache
def _dark(instrument: ImagingSystem) -> NDArray[np.uint8]:
    """Return grey levels without light, one for each value of the noise."""
    return _grey(np.zeros(QUANTILES, dtype=np.float32), _normal(), instrument)


@cache
def _normal() -> NDArray[np.float32]:
    """Return quantiles of the normal distribution."""
    quantiles: FloatArray = scipy.special.ndtri((np.arange(QUANTILES) + 0.5) / QUANTILES)
    return quantiles.astype(np.float32)
