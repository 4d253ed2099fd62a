"""Imaging system: geometry, exposure, and the light on the camera."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy
from tests.microimpact.lab.ptis.imaging_cases import (
    DIAMETER,
    INSTRUMENT,
    NOISELESS,
    generator,
    impacts,
    setup_for,
)

from microimpact.lab.ptis.exposure import INCIDENT, LATER, REBOUND, exposures, flights
from microimpact.lab.ptis.frames import (
    FEWEST_SAMPLES,
    SAMPLES_PER_BLUR,
    light_of,
    render,
    through_disk,
)
from microimpact.lab.ptis.system import Systematics, draw_systematics

EXACT = Systematics()


def lit(speed, angle, instrument=NOISELESS, seed=0, **changes):
    events = impacts(speed, angle, **changes)
    setup = setup_for(speed, angle, instrument)
    return exposures(events.select(slice(1)), setup, EXACT, [generator(seed)]), setup


def middle_field(exposure):
    """The same exposure with the impact in the middle of its field."""
    return replace(exposure, field=(np.array([-1 / 120]), np.array([1 / 120])))


@pytest.mark.parametrize("angle", [85.0, 60.0, 45.0, 10.0])
def test_particles_fall_straight_down_the_image(angle):
    setup = setup_for(1.66, angle)
    fall = impacts(1.66, angle).velocity[0]
    for vector in (setup.gravity, fall):
        path = setup.columns_rows(np.array([0.0, 1e-4])[:, None] * vector, EXACT)
        across, down = path[1] - path[0]
        assert across == pytest.approx(0.0, abs=1e-9)
        assert down == pytest.approx(1e-4 * np.linalg.norm(vector) / 10e-6)


@pytest.mark.parametrize("angle", [85.0, 60.0, 10.0])
def test_height_above_the_surface_is_the_normal_coordinate(angle):
    setup = setup_for(1.0, angle)
    points = np.array([[3e-4, 0.0, 0.0], [-1e-3, 0.0, 2e-4], [1e-3, 1e-4, 5e-4]])
    found = setup.height(setup.columns_rows(points, EXACT))
    assert found == pytest.approx(points[:, 2] / 10e-6, abs=1e-9)


def test_normal_incidence_is_left_to_phase_doppler():
    with pytest.raises(ValueError, match=r"90 deg .* phase Doppler \(lab\.pdpa\)"):
        setup_for(1.66, 90.0)


def test_the_chopper_follows_the_speed_up_to_its_limit():
    assert setup_for(1.0, 45.0).chop_rate == pytest.approx(2500.0)
    assert setup_for(1.0, 45.0).disk_speed == pytest.approx(15_000.0)
    fast = setup_for(30.0, 45.0)
    assert (fast.chop_rate, fast.disk_speed) == pytest.approx((5000.0, 30_000.0))


def test_the_path_is_a_fall_before_and_after_impact():
    events, setup = impacts(0.45, 60.0), setup_for(0.45, 60.0)
    path = flights(events.select(slice(1)), setup)
    assert path.at(np.array([0]), np.array([0.0]))[0, 2] == pytest.approx(DIAMETER / 2)
    # Energy: v^2 / 2 - g . x is the same all along a leg, and nothing was ever slower than at rest.
    for leg in (INCIDENT, REBOUND):
        times = np.linspace(path.begin[leg], path.end[leg], 5)
        place = path.at(np.full(5, leg), times)
        speed = path.velocity[leg] + path.gravity * (times - path.start[leg])[:, None]
        energy = 0.5 * np.sum(speed**2, axis=1) - place @ path.gravity
        assert energy == pytest.approx(energy[0], rel=1e-9)
    at_rest = path.velocity[0] + path.gravity * path.begin[0]
    assert at_rest == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    # It comes back to the surface where the next leg begins.
    landing = path.at(np.array([REBOUND, LATER]), path.end[[REBOUND, REBOUND]])
    assert landing[:, 2] == pytest.approx(DIAMETER / 2, abs=1e-12)


def test_pulses_are_as_long_as_the_duty_and_only_the_impact_divides_one():
    exposure, setup = lit(1.0, 60.0)
    open_time = 0.5 / setup.chop_rate
    inside = exposure.whole & exposure.in_sheet
    assert (exposure.end - exposure.start)[inside] == pytest.approx(open_time)
    divided = np.flatnonzero(~exposure.whole & (exposure.leg != LATER))
    begin = exposure.flight.begin[INCIDENT]
    near = [i for i in divided if exposure.start[i] > begin]
    assert len(near) in {0, 2}


def test_a_rebound_out_of_plane_leaves_the_sheet_half_a_millimetre_off():
    exposure, _ = lit(1.0, 60.0, side=0.3, position=np.zeros((1, 2)))
    rebound = exposure.leg == REBOUND
    assert np.all(exposure.end[rebound & exposure.in_sheet] <= 0.5e-3 / 0.3 + 1e-12)
    assert not np.any(exposure.in_sheet[rebound & (exposure.start > 0.5e-3 / 0.3)])
    assert np.all(exposure.in_sheet[exposure.leg == INCIDENT])


def test_moments_of_a_dash_are_those_of_disk_blur_and_way():
    exposure, setup = lit(1.66, 60.0)
    exposure = middle_field(exposure)
    one = np.flatnonzero(exposure.whole & (exposure.leg == INCIDENT) & exposure.in_view)[-2:-1]
    names = ("leg", "start", "end", "whole", "in_sheet", "in_view", "in_field")
    single = replace(exposure, **{name: getattr(exposure, name)[one] for name in names})
    light = light_of(single, setup, EXACT).astype(float)
    assert light.max() == pytest.approx(exposure.peak, rel=1e-6)
    rows, columns = np.indices(light.shape)
    total = light.sum()
    across, down = (np.sum(light * axis) / total for axis in (columns, rows))
    leg = single.leg
    ends = np.array(
        [setup.columns_rows(single.flight.at(leg, t)[0], EXACT) for t in (single.start, single.end)]
    )
    # Gravity moves the centroid off the middle of the ends by less than 1e-3 px here.
    assert (across, down) == pytest.approx(tuple(ends.mean(axis=0)), abs=2e-3)
    # A disk has the variance d^2/16 per axis, a pixel 1/12, and a uniform way length^2/12.
    still = (DIAMETER / setup.pixel) ** 2 / 16 + 1.0 + 1 / 12
    way = np.linalg.norm(ends[1] - ends[0])
    spread = [
        np.sum(light * (axis - mean) ** 2) / total
        for axis, mean in ((columns, across), (rows, down))
    ]
    assert spread[0] == pytest.approx(still, rel=2e-3)
    assert spread[1] == pytest.approx(still + way**2 / 12, rel=2e-3)


def test_every_whole_pulse_gives_the_same_light_and_the_slower_leg_is_brighter():
    exposure, setup = lit(1.66, 60.0)
    exposure = middle_field(exposure)
    names = ("leg", "start", "end", "whole", "in_sheet", "in_view", "in_field")
    whole = exposure.whole & exposure.in_view & (exposure.leg != LATER)
    # One incident and one rebound dash, far enough from each other.
    pair = [np.flatnonzero(whole & (exposure.leg == leg))[k] for leg, k in ((0, -3), (1, 3))]
    two = replace(exposure, **{name: getattr(exposure, name)[pair] for name in names})
    light = light_of(two, setup, EXACT)
    column = int(setup.columns_rows(two.flight.at(two.leg, two.start), EXACT)[:, 0].mean())
    left, right = light[:, :column], light[:, column:]
    assert left.sum() == pytest.approx(right.sum(), rel=1e-3)
    assert right.max() == pytest.approx(two.peak, rel=1e-6)
    assert left.max() < right.max()


@pytest.mark.parametrize("blur", [0.7, 1.0, 2.3])
def test_light_is_the_exact_integral_over_pixels_of_the_blurred_path(blur):
    """Without a disk, against the sum of Gaussians at the same points of the path."""
    instrument = replace(NOISELESS, blur_px=blur)
    exposure, setup = lit(1.66, 60.0, instrument, diameter=np.array([1e-12]))
    exposure = middle_field(exposure)
    one = np.flatnonzero(exposure.whole & (exposure.leg == REBOUND) & exposure.in_view)[2:3]
    names = ("leg", "start", "end", "whole", "in_sheet", "in_view", "in_field")
    single = replace(exposure, **{name: getattr(exposure, name)[one] for name in names})
    light = light_of(single, setup, EXACT)
    ends = single.places(np.array([0]), np.stack([single.start, single.end], axis=1), setup, EXACT)
    n = max(
        FEWEST_SAMPLES,
        int(np.ceil(SAMPLES_PER_BLUR * np.linalg.norm(np.ptp(ends[0], axis=0)) / blur)),
    )
    time = single.start + (single.end - single.start) * (np.arange(n) + 0.5) / n
    path = setup.columns_rows(single.flight.at(np.repeat(single.leg, n), time), EXACT)
    width, height = instrument.frame_px
    across, down = (
        np.diff(scipy.special.ndtr((np.arange(n + 1) - 0.5 - of[:, None]) / blur))
        for n, of in ((width, path[:, 0]), (height, path[:, 1]))
    )
    expected = down.T @ across
    assert light / light.sum() == pytest.approx(expected / expected.sum(), abs=2e-8)


def test_a_disk_spreads_light_evenly_over_its_area():
    rows, columns = np.indices((64, 64))
    spot = np.exp(-((columns - 31.0) ** 2 + (rows - 32.0) ** 2) / 2.0)
    found = through_disk(spot, 20.0)
    assert found.sum() == pytest.approx(spot.sum())
    # Well inside and outside the edge, where the blur of 1 px does not reach.
    off = np.hypot(columns - 31.0, rows - 32.0)
    assert found[off < 5.0] == pytest.approx(spot.sum() / (np.pi * 10.0**2), rel=2e-3)
    assert np.abs(found[off > 15.0]).max() < 1e-3 * found.max()


def test_noise_of_the_dark_frame():
    instrument = replace(INSTRUMENT, electrons_per_count=2.0)
    setup = setup_for(1.66, 60.0, instrument)
    events = impacts(1.66, 60.0, position=np.array([[0.0, 1e-3]]))
    dark = render(events, 0, setup, EXACT, generator(3)).astype(float)
    assert dark.mean() == pytest.approx(20.0, abs=0.1)
    # Read noise of 4 counts, shot noise of 40 electrons, rounding.
    assert dark.std() == pytest.approx(np.sqrt(16.0 + 10.0 + 1 / 12), rel=0.02)


def test_systematic_errors_have_their_standard_deviations():
    drawn = [draw_systematics(INSTRUMENT, generator(i)) for i in range(400)]
    for name, sd in (("rate", 0.005), ("scale", 0.005), ("angle_deg", 0.25)):
        values = np.array([getattr(one, name) for one in drawn])
        # Standard error of a standard deviation: 1 / sqrt(2 n) = 3.5 %.
        assert values.std() == pytest.approx(sd, rel=0.12)
        assert abs(values.mean()) < 4 * sd / 20
