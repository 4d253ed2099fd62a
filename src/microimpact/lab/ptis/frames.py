"""Frames of the imaging system: light and noise as grey levels on the pixels of the camera."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from functools import cache, lru_cache

import numpy as np
import scipy
from numpy.random import Generator
from numpy.typing import NDArray

from microimpact.core.arrays import FloatArray
from microimpact.core.compiled import jit
from microimpact.lab.events import Impacts, IntArray
from microimpact.lab.ptis.exposure import Exposure, expose
from microimpact.lab.ptis.light import lights
from microimpact.lab.ptis.system import Instrument, Setup, Systematics

BRIGHTEST = 255
# Less light than this, in counts, is not seen; rounding leaves less between dashes.
UNSEEN = 1e-4
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
    return next(photographs(exposure, impacts.diameter[[i]], setup, errors, [rng]))


def photographs(
    exposure: Exposure,
    diameter: FloatArray,
    setup: Setup,
    errors: Systematics,
    rngs: Iterable[Generator],
) -> Iterator[NDArray[np.uint8]]:
    """Yield the frame of every event of an exposure, each as `render` does.

    Parameters
    ----------
    exposure
        Drawn with the generators of its n events.
    diameter
        Of the spheres, m, shape (n,).
    setup, errors
        As in `render`.
    rngs
        One per event.
    """
    for (light, boxes), rng in zip(lights(exposure, diameter, setup, errors), rngs, strict=True):
        yield _photograph(light, boxes, setup.instrument, rng)


def _photograph(
    light: NDArray[np.float32], boxes: IntArray, instrument: Instrument, rng: Generator
) -> NDArray[np.uint8]:
    """Return the frame of light that lies in boxes: left, top, right, bottom, shape (m, 4)."""
    if instrument.interlace:
        light = 0.5 * (light[::2] + light[1::2])
        boxes = (boxes + np.array([0, 0, 0, 1])) // np.array([1, 2, 1, 2])
    # Sixteen bits at a time of the stream, as ``rng.integers`` takes them at three times the cost.
    draw = rng.bit_generator.random_raw(-(-light.size // 4)).astype("<u8", copy=False).view("<u2")
    frame = np.empty(light.shape, dtype=np.uint8)
    _expose(light, boxes, draw, _noise(), _dark(instrument), *_camera(instrument), frame)
    return frame


@_jit
def _expose(light, boxes, draw, normal, dark, background, electrons, least, frame):  # type: ignore[no-untyped-def]
    """Grey levels of light in counts above the background, each with the noise drawn for it.

    Most of a frame is dark, and what noise makes of no light is known beforehand.
    """
    greys = frame.ravel()
    for i in range(greys.size):
        greys[i] = dark[draw[i]]
    for k in range(len(boxes)):
        left, top, right, bottom = boxes[k]
        for row in range(top, bottom):
            for column in range(left, right):
                bright, noise = light[row, column], normal[draw[row * light.shape[1] + column]]
                if bright > UNSEEN:
                    frame[row, column] = _grey(bright, noise, background, electrons, least)


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
