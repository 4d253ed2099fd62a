"""Measurement of frames: centroids, legs, velocities at the surface, and what is refused."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from scipy.constants import g
from tests.microimpact.lab.ptis.imaging_cases import (
    INSTRUMENT,
    NOISELESS,
    STEADY,
    generator,
    impacts,
    setup_for,
)

from microimpact.lab.ptis.experiment import photographed
from microimpact.lab.ptis.exposure import (
    CAPTURED,
    OFF_SHEET,
    OFF_VIEW,
    REBOUND,
    SPLIT,
    exposures,
    flights,
)
from microimpact.lab.ptis.frames import render
from microimpact.lab.ptis.system import Systematics, event_generator
from microimpact.lab.ptis.tracks import find_spots, measure, reduce_legs, sort_legs

EXACT = Systematics()
CASES = [(1.66, 85.0), (1.66, 45.0), (1.05, 20.0), (0.45, 60.0), (0.45, 30.0)]


def frames(speed, angle, instrument, n=12, **changes):
    events, setup = impacts(speed, angle, n, **changes), setup_for(speed, angle, instrument)
    for i in range(n):
        yield i, events, setup, render(events, i, setup, EXACT, event_generator(generator(), i))


@pytest.mark.parametrize(("speed", "angle"), CASES)
def test_noiseless_frames_give_speed_and_angle(speed, angle):
    # Centroids without noise are good to 0.03 px. Four dashes 28 px apart then give a speed to
    # 0.03 * sum|k| / sum k^2 / 28 px = 0.03 * 0.8 / 28 = 0.09 %, and as many radians, 0.05 deg.
    seen = 0
    for i, events, setup, frame in frames(speed, angle, NOISELESS):
        track = measure(frame, setup)
        if track is None:
            continue
        seen += 1
        true = events.in_plane.velocities[i]
        size = np.linalg.norm(true, axis=1)
        assert np.linalg.norm(track.velocities, axis=1) == pytest.approx(size, rel=2e-3)
        turned = np.degrees(np.arctan2(*track.velocities.T[::-1]) - np.arctan2(*true.T[::-1]))
        assert turned == pytest.approx([0.0, 0.0], abs=0.1)
    assert seen >= 4


@pytest.mark.parametrize(("speed", "angle"), [(1.66, 60.0), (0.45, 45.0)])
def test_centroids_are_good_to_a_fraction_of_a_pixel(speed, angle):
    off = []
    for i, events, setup, frame in frames(speed, angle, STEADY, n=16):
        legs = sort_legs(find_spots(frame, setup), setup)
        if legs is None:
            continue
        rngs = [event_generator(generator(), i)]
        exposure = exposures(events.select(slice(i, i + 1)), setup, EXACT, rngs)
        whole = exposure.whole & exposure.in_sheet
        time = 0.5 * (exposure.start + exposure.end)[whole]
        true = setup.columns_rows(exposure.flight.at(exposure.leg[whole], time), EXACT)
        for places in legs:
            gap = places[:, None] - true
            off.append(gap[np.arange(len(places)), np.linalg.norm(gap, axis=2).argmin(axis=1)])
    off = np.concatenate(off)
    assert len(off) > 60
    # A tenth of a pixel would make 0.3 % of the speed over four dashes.
    assert np.all(off.std(axis=0) < 0.08)
    assert np.all(np.abs(off.mean(axis=0)) < 5 * off.std(axis=0) / np.sqrt(len(off)))


def test_large_spheres_lengthen_dashes_and_leave_centroids_alone():
    places, lengths = [], []
    for diameter in (20e-6, 62e-6):
        events = impacts(1.66, 60.0, diameter=np.array([diameter]), position=np.zeros((1, 2)))
        setup = replace(setup_for(1.66, 60.0, NOISELESS), diameter=diameter)
        frame = render(events, 0, setup, EXACT, event_generator(generator(), 1))
        incident, _ = sort_legs(find_spots(frame, setup), setup)
        # The surface stops the centre at half a diameter: the whole path is shifted by as much.
        shift = setup.columns_rows(np.array([0.0, 0.0, 0.5 * diameter]), EXACT) - setup.centre
        places.append(incident - shift)
        column, row = np.rint(incident[1]).astype(int)
        stretch = frame[row - 22 : row + 22, column].astype(float) - 20.0
        lengths.append(np.count_nonzero(stretch > 0.05 * stretch.max()))
    number = min(map(len, places))
    assert places[0][-number:] == pytest.approx(places[1][-number:], abs=0.05)
    # 42 um are 4.2 px; at the ends, where little of a disk is, some of it is too faint.
    assert 2 <= lengths[1] - lengths[0] <= 5


def falling(setup, leg, n, first=2, speed=0.45):
    """Exact places of consecutive dashes of one leg, with the first a few periods from impact."""
    path = flights(impacts(speed, setup.angle, position=np.zeros((1, 2))), setup)
    time = (first + np.arange(n)) / setup.chop_rate
    time = time if leg == REBOUND else -time[::-1]
    return setup.columns_rows(path.at(np.full(n, leg), time), EXACT)


def test_exact_dashes_give_exact_velocities():
    setup = setup_for(0.45, 60.0)
    track = reduce_legs(falling(setup, 0, 6), falling(setup, 1, 5), setup)
    true = impacts(0.45, 60.0).in_plane.velocities[0]
    assert track.velocities == pytest.approx(true, rel=1e-9)
    assert track.incident.contact * setup.chop_rate == pytest.approx(7.0)
    assert track.rebound.contact * setup.chop_rate == pytest.approx(-2.0)


def test_straight_lines_are_biased_in_frames_as_gravity_says():
    checked = 0
    for *_, setup, frame in frames(0.45, 60.0, NOISELESS):
        legs = sort_legs(find_spots(frame, setup), setup)
        if legs is None:
            continue
        track, straight = (reduce_legs(*legs, setup, with_gravity=falls) for falls in (True, False))
        if track is None or straight is None:
            continue
        checked += 1
        for leg, plain in ((track.incident, straight.incident), (track.rebound, straight.rebound)):
            middle = 0.5 * (len(leg.points) - 1) / setup.chop_rate
            lost = g * (leg.contact - middle)
            assert plain.velocity[1] - leg.contact_velocity[1] == pytest.approx(lost, abs=1e-6)
        assert np.linalg.norm(straight.velocities[0]) < 0.97 * np.linalg.norm(track.velocities[0])
    assert checked >= 3


def test_a_missing_dash_is_noticed():
    setup = setup_for(1.66, 45.0)
    incident, rebound = falling(setup, 0, 6, speed=1.66), falling(setup, 1, 6, speed=1.66)
    assert reduce_legs(incident, rebound, setup)
    assert reduce_legs(np.delete(incident, 3, axis=0), rebound, setup) is None
    assert reduce_legs(incident, np.delete(rebound, 2, axis=0), setup) is None


@pytest.mark.parametrize(("bend", "single"), [(2.0, True), (8.0, False)])
def test_a_kinked_leg_is_no_single_flight(bend, single):
    """A leg whose second half turns aside, until its last dash lies so many pixels off its line."""
    setup = setup_for(1.66, 45.0)
    incident, rebound = (falling(setup, leg, 8, speed=1.66) for leg in (0, 1))
    along = rebound[-1] - rebound[0]
    across = np.array([-along[1], along[0]]) / np.linalg.norm(along)
    aside = np.clip(np.arange(8) - 3.5, 0.0, None) / 3.5
    track = reduce_legs(incident, rebound + bend * aside[:, None] * across, setup)
    assert (track is not None) == single


def test_a_second_bounce_is_noticed():
    setup = replace(setup_for(0.3, 60.0), speed=0.9)
    path = flights(impacts(0.3, 60.0, restitution=0.3), setup)
    time = (1 + np.arange(60)) / setup.chop_rate
    leg = np.where(time < path.end[REBOUND], 1, 2)
    keep = time < path.end[2]
    rebound = setup.columns_rows(path.at(leg[keep], time[keep]), EXACT)
    assert np.any(leg[keep] == 2)
    incident = falling(setup, 0, 6, speed=0.3)
    assert reduce_legs(incident, rebound, setup) is None


def test_a_rebound_below_the_surface_is_no_impact():
    setup = setup_for(0.3, 45.0)
    incident, rebound = (falling(setup, leg, 6, speed=0.3) for leg in (0, 1))
    assert reduce_legs(incident, rebound + np.array([0.0, 400.0]), setup) is None


@pytest.mark.parametrize(
    ("angle", "instrument", "changes"),
    [
        (88.5, INSTRUMENT, {}),
        (60.0, INSTRUMENT, {"restitution": 0.2, "kept": 0.3}),
        (60.0, replace(INSTRUMENT, dash_pitch_mm=1.5), {}),
    ],
    ids=["tracks overlap", "dashes touch", "too few dashes"],
)
def test_frames_without_two_rows_of_single_dashes_are_refused(angle, instrument, changes):
    for *_, setup, frame in frames(1.66, angle, instrument, **changes):
        assert measure(frame, setup) is None


def test_an_overexposed_frame_is_refused():
    for *_, setup, frame in frames(1.66, 60.0, NOISELESS, n=1):
        assert measure(frame, setup)
        assert measure(np.where(frame > 60, 255, frame).astype(np.uint8), setup) is None


def test_every_loss_has_its_reason():
    n = 12
    base = impacts(1.66, 60.0, n)

    def fates(events, speed=1.66):
        setup = setup_for(speed, 60.0)
        return Counter(photographed(events, setup, EXACT, generator()).reduced(setup).fates)

    assert fates(replace(base, captured=np.ones(n, dtype=bool))) == {CAPTURED: n}
    assert fates(impacts(1.66, 60.0, n, side=0.8)) == {OFF_SHEET: n}
    assert fates(replace(base, position=base.position + np.array([8e-3, 0.0]))) == {OFF_VIEW: n}
    assert fates(impacts(0.3, 60.0, 24), 0.3)[SPLIT] > 8
