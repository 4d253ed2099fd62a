"""Patches of light: smoothing, labels, wings and sums against plain NumPy and SciPy."""

from __future__ import annotations

import numpy as np
import pytest
import scipy
from tests.lab.ptis.imaging_cases import generator, setup_for

from microimpact.lab.ptis.spots import (
    ACROSS,
    COLUMN,
    CORE,
    DOWN,
    EVERY,
    FULL,
    KERNEL,
    LEAST_BRIGHTNESS,
    LIGHT,
    MIXED,
    NEAR,
    ROW,
    SMOOTHING_PX,
    SURFACE_PX,
    WINGS_PX,
    _core,
    _histogram,
    _patches,
    _sums,
    find_spots,
)

TOUCHING = np.ones((3, 3))
# The camera's frame, ones that stretches do not divide, and one hardly larger than the kernel.
SHAPES = [(480, 640), (61, 83), (33, 32), (9, 7)]


def blobs(rng, shape, share):
    """Bright patches of any form, on noise."""
    bright = scipy.ndimage.binary_dilation(rng.random(shape) < share, iterations=2)
    light = 20.0 + 3.0 * rng.standard_normal(shape) + bright * rng.uniform(30.0, 260.0, shape)
    return np.clip(np.rint(light), 0, 255).astype(np.uint8)


def mask(core, shape):
    found = np.zeros(shape, dtype=bool)
    found.ravel()[core] = True
    return found


def places(bright):
    return np.flatnonzero(bright.ravel())


def labelled(bright):
    """Patches in order of their first pixel, widened; the later one takes what two share."""
    patches, number = scipy.ndimage.label(bright, TOUCHING)
    spot = np.zeros(bright.shape, dtype=int)
    square = np.ones((2 * WINGS_PX + 1, 2 * WINGS_PX + 1))
    for k in range(1, number + 1):
        spot[scipy.ndimage.binary_dilation(patches == k, square)] = k
    return spot, number


@pytest.mark.parametrize("shape", SHAPES)
def test_core_is_where_the_gaussian_mean_exceeds_both_thresholds(shape):
    rng = generator(len(shape), *shape)
    for share, least in ((0.002, 8.0), (0.05, 8.0), (0.0, 2.5), (0.05, 30.0)):
        frame = blobs(rng, shape, share)
        smooth = frame - 20.0
        for axis in (0, 1):
            # SciPy's `reflect` repeats the edge pixel, as a mirror at the edge does.
            smooth = scipy.ndimage.convolve1d(
                smooth, KERNEL.astype(float), axis=axis, mode="reflect"
            )
        threshold = max(least, LEAST_BRIGHTNESS * smooth.max())
        found = _core(frame, np.float32(20.0), np.float32(least))
        assert np.all(np.diff(found) > 0)
        wrong = mask(found, shape) != (smooth > threshold)
        # Single precision may decide a pixel that is at the threshold.
        assert np.all(np.abs(smooth[wrong] - threshold) < 1e-4)


def test_smoothing_is_the_gaussian_of_its_width():
    spike = np.zeros(21)
    spike[10] = 1.0
    gauss = scipy.ndimage.gaussian_filter1d(spike, SMOOTHING_PX, radius=len(KERNEL) // 2)
    assert gauss[7:14] == pytest.approx(KERNEL, abs=1e-7)


def test_a_dark_frame_has_no_core():
    frame = np.full((40, 50), 20, dtype=np.uint8)
    core = _core(frame, np.float32(20.0), np.float32(6.0))
    spot, boxes = _patches(core, *frame.shape)
    assert (core.size, boxes.shape, spot.any()) == (0, (0, 4), False)


@pytest.mark.parametrize("share", [0.005, 0.03, 0.1, 0.4])
def test_patches_are_those_of_scipy_with_their_wings(share):
    rng = generator(7, int(1000 * share))
    for _ in range(25):
        bright = rng.random(rng.integers(4, 40, 2)) < share
        spot, boxes = _patches(places(bright), *bright.shape)
        expected, number = labelled(bright)
        assert np.array_equal(spot, expected)
        assert len(boxes) == number
        patches, _ = scipy.ndimage.label(bright, TOUCHING)
        for box, (rows, columns) in zip(boxes, scipy.ndimage.find_objects(patches), strict=True):
            first = max(rows.start - WINGS_PX, 0), max(columns.start - WINGS_PX, 0)
            last = rows.stop + WINGS_PX, columns.stop + WINGS_PX
            assert tuple(box) == (*first, *np.minimum(last, bright.shape))


def test_pixels_that_touch_by_a_corner_are_one_patch():
    for corner in ((6, 6), (6, 4)):
        bright = np.zeros((12, 12), dtype=bool)
        bright[5, 5] = bright[corner] = True
        assert len(_patches(places(bright), 12, 12)[1]) == 1


def test_where_wings_meet_the_later_patch_has_them():
    bright = np.zeros((9, 12), dtype=bool)
    bright[4, 4] = bright[4, 7] = True
    spot, boxes = _patches(places(bright), 9, 12)
    assert len(boxes) == 2
    assert spot[4].tolist() == [0, 0, 1, 1, 1, 2, 2, 2, 2, 2, 0, 0]


@pytest.mark.parametrize("lines", [1, 2])
def test_sums_are_moments_of_the_light(lines):
    rng = generator(11, lines)
    surface = 30.0, 25.0 * lines, np.cos(1.0), np.sin(1.0)
    for _ in range(20):
        frame = blobs(rng, (50, 60), 0.004)
        bright = scipy.ndimage.gaussian_filter(frame - 20.0, 1.0) > 15.0
        core = places(bright)
        spot, boxes = _patches(core, *frame.shape)
        sums = _sums(frame, 20.0, spot, core, boxes, lines, surface)
        rows, columns = np.indices(frame.shape)
        down = lines * rows + 0.5 * (lines - 1)
        above = (columns - surface[0]) * surface[2] - (down - surface[1]) * surface[3]
        near = (above < SURFACE_PX) | (rows == 0) | (rows == 49) | (columns == 0) | (columns == 59)
        assert sums.shape == (9, len(boxes))
        for k, own in enumerate(sums.T):
            mine = spot == k + 1
            light = (frame - 20.0)[mine]
            x, y = columns[mine], down[mine]
            place = np.average([x, y], axis=1, weights=light)
            dx, dy = x - place[0], y - place[1]
            expected = {
                LIGHT: light.sum(),
                COLUMN: place[0],
                ROW: place[1],
                ACROSS: np.average(dx**2, weights=light),
                DOWN: np.average(dy**2, weights=light),
                MIXED: np.average(dx * dy, weights=light),
                FULL: np.sum(frame[mine] == 255),
                CORE: np.sum(mine & bright),
                NEAR: np.sum(mine & bright & near),
            }
            assert own == pytest.approx([expected[i] for i in range(9)], rel=1e-9, abs=1e-9)


def test_levels_are_counted_in_every_fourth_row():
    frame = generator(13).integers(0, 256, (30, 41)).astype(np.uint8)
    counted = np.bincount(frame[::EVERY].ravel(), minlength=256)
    assert np.array_equal(_histogram(frame), counted)


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
    order = np.argsort(spots.place[:, 0])
    assert spots.place[order] == pytest.approx(centres, abs=0.1)
    # Cut off where the light ends, a spot is a little narrower than it was drawn.
    assert spots.length == pytest.approx(3.0, rel=0.1)
    assert spots.light == pytest.approx(150.0 * 2.0 * np.pi * 9.0, rel=0.03)
    assert np.all(spots.clear)
    assert not np.any(spots.saturated)
