"""Patches of light: detection, wings and moments against small cases known by hand."""

from __future__ import annotations

import numpy as np
import pytest
import scipy
from tests.microimpact.lab.ptis.imaging_cases import generator, setup_for

from microimpact.lab.ptis.tracks import (
    LEAST_BRIGHTNESS,
    MOST_SATURATED,
    SMOOTHING_PX,
    WINGS_PX,
    find_spots,
    patches,
)

# The camera's frame, one that is hardly larger than the Gaussian, and one between.
SHAPES = [(480, 640), (61, 83), (9, 7)]


def blobs(rng, shape, share):
    """Bright patches of any form, on noise."""
    bright = scipy.ndimage.binary_dilation(rng.random(shape) < share, iterations=2)
    light = 20.0 + 3.0 * rng.standard_normal(shape) + bright * rng.uniform(30.0, 260.0, shape)
    return np.clip(np.rint(light), 0, 255).astype(np.uint8)


def maps(frame, background, least):
    """Number of the patch at every pixel, and which are bright."""
    row, column, patch, core = patches(frame, background, least)
    spot, bright = np.zeros(frame.shape, dtype=int), np.zeros(frame.shape, dtype=bool)
    spot[row, column], bright[row, column] = patch, core
    return spot, bright


def smoothed(frame, background):
    """The frame through a Gaussian of 1 px, cut at 3 px, by its sum; edges are mirrors."""
    place = np.arange(-3, 4)
    kernel = np.exp(-0.5 * (place / SMOOTHING_PX) ** 2)
    kernel /= kernel.sum()
    wide = np.pad(frame - background, 3, mode="symmetric")
    rows = sum(k * wide[3 + i : 3 + i + frame.shape[0]] for i, k in zip(place, kernel, strict=True))
    return sum(
        k * rows[:, 3 + i : 3 + i + frame.shape[1]] for i, k in zip(place, kernel, strict=True)
    )


@pytest.mark.parametrize("shape", SHAPES)
def test_bright_is_where_the_smoothed_light_exceeds_both_thresholds(shape):
    rng = generator(len(shape), *shape)
    for share, least in ((0.002, 8.0), (0.05, 8.0), (0.05, 30.0)):
        frame = blobs(rng, shape, share)
        smooth = smoothed(frame.astype(float), 20.0)
        threshold = max(least, LEAST_BRIGHTNESS * smooth.max())
        wrong = maps(frame, 20.0, least)[1] != (smooth > threshold)
        # Single precision may decide a pixel that is at the threshold.
        assert np.all(np.abs(smooth[wrong] - threshold) < 1e-4)


def test_wings_are_two_pixels_around_what_is_bright():
    frame = np.zeros((30, 40), dtype=np.uint8)
    frame[10, 20] = 200
    spot, bright = maps(frame, 0.0, 20.0)
    # 200 / 2 pi = 32 in the middle, 19 beside it.
    assert np.argwhere(bright).tolist() == [[10, 20]]
    assert np.argwhere(spot).min(axis=0).tolist() == [10 - WINGS_PX, 20 - WINGS_PX]
    assert np.argwhere(spot).max(axis=0).tolist() == [10 + WINGS_PX, 20 + WINGS_PX]
    assert spot.sum() == (2 * WINGS_PX + 1) ** 2


@pytest.mark.parametrize(
    ("second", "least", "number"), [((6, 6), 40.0, 1), ((6, 4), 40.0, 1), ((5, 8), 30.0, 2)]
)
def test_pixels_that_touch_also_by_a_corner_are_one_patch(second, least, number):
    frame = np.zeros((20, 20), dtype=np.uint8)
    frame[5, 5] = frame[second] = 200
    # Smoothed, each has 32, of its neighbour by a corner 12; two more pixels touch both, with 39.
    row, column, patch, core = patches(frame, 0.0, least)
    assert patch.max() == number
    assert set(zip(row[core], column[core], strict=True)) == {(5, 5), second}


def test_place_and_light_are_moments():
    setup, rng = setup_for(1.66, 60.0), generator(11)
    frame = np.full((480, 640), 20, dtype=np.uint8)
    block = rng.integers(150, 250, (7, 5))
    frame[60:67, 200:205] = block
    spots = find_spots(frame, setup)
    rows, columns = np.indices(block.shape)
    y, x = 60 + rows, 200 + columns
    light = block - 20.0
    place = [np.average(axis, weights=light) for axis in (x, y)]
    assert spots.light == pytest.approx([light.sum()])
    assert spots.centroid == pytest.approx(np.array([place]))
    assert spots.height == pytest.approx(setup.height(np.array([place])))
    assert spots.clear.tolist() == [True]
    assert spots.saturated.tolist() == [False]


def test_spots_at_the_edge_or_the_surface_are_not_clear():
    setup = setup_for(1.66, 60.0)
    frame = np.full((480, 640), 20, dtype=np.uint8)
    column, row = np.rint(setup.centre).astype(int)
    for left, top in ((300, 0), (0, 200), (300, 150), (column, row)):
        frame[top : top + 5, left : left + 5] = 200
    spots = find_spots(frame, setup)
    clear = dict(zip(map(tuple, np.rint(spots.centroid).astype(int)), spots.clear, strict=True))
    assert clear == {
        (302, 2): False,
        (2, 202): False,
        (302, 152): True,
        (column + 2, row + 2): False,
    }


@pytest.mark.parametrize("share", [0.5, 1.5])
def test_spots_with_enough_pixels_at_the_end_of_the_scale_are_saturated(share):
    setup = setup_for(1.66, 60.0)
    frame = np.full((480, 640), 20, dtype=np.uint8)
    frame[100:120, 300:320] = 200
    core = patches(frame, 20.0, 6.0)[3].sum()
    full = round(share * MOST_SATURATED * core)
    rows, columns = np.divmod(np.arange(full), 20)
    frame[100 + rows, 300 + columns] = 255
    assert find_spots(frame, setup).saturated.tolist() == [share > 1.0]


def test_spots_of_round_light_are_found_where_they_were_drawn():
    setup = setup_for(1.66, 60.0)
    rng = generator(17)
    rows, columns = np.indices((480, 640))
    centres = np.array([[100.3, 80.7], [240.5, 60.2], [330.9, 120.1]])
    light = sum(
        150.0 * np.exp(-((columns - x) ** 2 + (rows - y) ** 2) / (2.0 * 9.0)) for x, y in centres
    )
    frame = np.rint(20.0 + light + 2.0 * rng.standard_normal(light.shape)).clip(0, 255)
    spots = find_spots(frame.astype(np.uint8), setup)
    order = np.argsort(spots.centroid[:, 0])
    assert spots.centroid[order] == pytest.approx(centres, abs=0.1)
    assert spots.light == pytest.approx(150.0 * 2.0 * np.pi * 9.0, rel=0.03)
    assert np.all(spots.clear)
    assert not np.any(spots.saturated)
