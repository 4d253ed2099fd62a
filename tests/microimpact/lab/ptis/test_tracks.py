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

from microimpact.lab.ptis.exposure import (
    CAPTURED,
    MEASURED,
    OFF_SHEET,
    OFF_VIEW,
    REBOUND,
    SPLIT,
    exposures,
    flights,
)
from microimpact.lab.ptis.frames import render
from microimpact.lab.ptis.observation import observe
from microimpact.lab.ptis.system import Systematics, event_generator
from microimpact.lab.ptis.tracks import (
    FEW,
    IRREGULAR,
    NO_VERTEX,
    OVERLAP,
    SATURATED,
    SECOND_BOUNCE,
    TOUCHING,
    Rejection,
    Track,
    find_spots,
    measure,
    reduce_legs,
    sort_legs,
)

EXACT = Systematics()
CASES = [(1.66, 85.0), (1.66, 45.0), (1.05, 20.0), (0.45, 60.0), (0.45, 30.0)]


def frames(speed, angle, instrument, n=12, **changes):
    events, setup = impacts(speed, angle, n, **changes), setup_for(speed, angle, instrument)
    for i in range(n):
        yield i, events, setup, render(events, i, setup, EXACT, event_generator(generator(), i))


def reasons(speed, angle, instrument=INSTRUMENT, **changes):
    found = [
        measure(frame, setup) for *_, setup, frame in frames(speed, angle, instrument, **changes)
    ]
    return Counter(one.reason if isinstance(one, Rejection) else MEASURED for one in found)


@pytest.mark.parametrize(("speed", "angle"), CASES)
def test_noiseless_frames_give_speed_and_angle(speed, angle):
    # Centroids without noise are good to 0.03 px. Four dashes 28 px apart then give a speed to
    # 0.03 * sum|k| / sum k^2 / 28 px = 0.03 * 0.8 / 28 = 0.09 %, and as many radians, 0.05 deg.
    seen = 0
    for i, events, setup, frame in frames(speed, angle, NOISELESS):
        track = measure(frame, setup)
        if isinstance(track, Rejection):
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
        if isinstance(legs, Rejection):
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
    assert isinstance(track, Track)
    true = impacts(0.45, 60.0).in_plane.velocities[0]
    assert track.velocities == pytest.approx(true, rel=1e-9)
    assert track.incident.contact * setup.chop_rate == pytest.approx(7.0)
    assert track.rebound.contact * setup.chop_rate == pytest.approx(-2.0)


def test_straight_lines_are_biased_in_frames_as_gravity_says():
    checked = 0
    for *_, setup, frame in frames(0.45, 60.0, NOISELESS):
        legs = sort_legs(find_spots(frame, setup), setup)
        if isinstance(legs, Rejection):
            continue
        track, straight = (reduce_legs(*legs, setup, with_gravity=falls) for falls in (True, False))
        if isinstance(track, Rejection) or isinstance(straight, Rejection):
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
    assert isinstance(reduce_legs(incident, rebound, setup), Track)
    gap = np.delete(incident, 3, axis=0)
    assert reduce_legs(gap, rebound, setup) == IRREGULAR
    assert reduce_legs(incident, np.delete(rebound, 2, axis=0), setup) == IRREGULAR


@pytest.mark.parametrize(("bend", "single"), [(2.0, True), (8.0, False)])
def test_a_kinked_leg_is_no_single_flight(bend, single):
    """A leg whose second half turns aside, until its last dash lies so many pixels off its line."""
    setup = setup_for(1.66, 45.0)
    incident, rebound = (falling(setup, leg, 8, speed=1.66) for leg in (0, 1))
    along = rebound[-1] - rebound[0]
    across = np.array([-along[1], along[0]]) / np.linalg.norm(along)
    aside = np.clip(np.arange(8) - 3.5, 0.0, None) / 3.5
    track = reduce_legs(incident, rebound + bend * aside[:, None] * across, setup)
    assert isinstance(track, Track) if single else track == IRREGULAR


def test_a_second_bounce_is_noticed():
    setup = replace(setup_for(0.3, 60.0), speed=0.9)
    path = flights(impacts(0.3, 60.0, restitution=0.3), setup)
    time = (1 + np.arange(60)) / setup.chop_rate
    leg = np.where(time < path.end[REBOUND], 1, 2)
    keep = time < path.end[2]
    rebound = setup.columns_rows(path.at(leg[keep], time[keep]), EXACT)
    assert np.any(leg[keep] == 2)
    incident = falling(setup, 0, 6, speed=0.3)
    assert reduce_legs(incident, rebound, setup) == SECOND_BOUNCE


def test_a_rebound_below_the_surface_is_no_impact():
    setup = setup_for(0.3, 45.0)
    incident, rebound = (falling(setup, leg, 6, speed=0.3) for leg in (0, 1))
    assert reduce_legs(incident, rebound + np.array([0.0, 400.0]), setup) == NO_VERTEX


def test_tracks_of_nearly_normal_impacts_overlap():
    found = reasons(1.66, 88.5)
    assert found[OVERLAP.reason] >= 8
    assert not found[MEASURED]


def test_slow_rebounds_have_dashes_that_touch():
    found = reasons(1.66, 60.0, restitution=0.2, kept=0.3)
    assert found[TOUCHING.reason] >= 6
    assert not found[MEASURED]


def test_a_coarse_chopper_gives_too_few_dashes():
    found = reasons(1.66, 60.0, replace(INSTRUMENT, dash_pitch_mm=1.5))
    assert found == {FEW.reason: 12}


def test_an_overexposed_frame_is_refused():
    for *_, setup, frame in frames(1.66, 60.0, NOISELESS, n=1):
        assert isinstance(measure(frame, setup), Track)
        bright = np.where(frame > 60, 255, frame).astype(np.uint8)
        assert measure(bright, setup) == SATURATED


def test_every_loss_has_its_reason():
    n = 12
    base = impacts(1.66, 60.0, n)
    fates = {
        CAPTURED: replace(base, captured=np.ones(n, dtype=bool)),
        OFF_SHEET: impacts(1.66, 60.0, n, side=0.8),
        OFF_VIEW: replace(base, position=base.position + np.array([8e-3, 0.0])),
    }
    for fate, events in fates.items():
        assert observe(events, setup_for(1.66, 60.0), EXACT, generator()).fates == (fate,) * n
    slow = Counter(observe(impacts(0.3, 60.0, 24), setup_for(0.3, 60.0), EXACT, generator()).fates)
    assert slow[SPLIT] > 8
