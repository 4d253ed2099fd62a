"""Phase Doppler particle analyser: passages through the probe volume, and records of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.constants import g

from microimpact.lab.bounces import with_later_impacts
from microimpact.lab.events import Impacts
from microimpact.lab.pdpa.analyser import INCIDENT, REBOUND, Analyser, passages, records
from microimpact.lab.surface import Rebound

H = 1e-3
DEFAULT = Analyser(
    probe_height_mm=1.0,
    probe_height_error_um=50.0,
    initial_estimate_error=0.2,
    probe_across_um=150.0,
    probe_along_um=300.0,
    velocity_noise_relative=0.005,
    velocity_noise_floor_m_per_s=0.004,
    diameter_noise_relative=0.02,
    diameter_noise_um=1.0,
    outlier_fraction=0.01,
    outlier_factors=(0.7, 1.4),
    time_resolution_us=10.0,
    drop_out=0.1,
    false_records_per_s=0.5,
    false_speed_m_per_s=2.0,
    false_diameters_um=(10.0, 125.0),
)
QUIET = replace(
    DEFAULT,
    velocity_noise_relative=0.0,
    velocity_noise_floor_m_per_s=0.0,
    diameter_noise_relative=0.0,
    diameter_noise_um=0.0,
    outlier_fraction=0.0,
    time_resolution_us=0.0,
    drop_out=0.0,
    false_records_per_s=0.0,
)


def impacts(speed, rebound, time=None, position=(0.0, 0.0), lateral=(0.0, 0.0), d=50e-6):
    """Vertical impacts; a rebound speed of 0 is capture."""
    speed, rebound = np.broadcast_arrays(np.atleast_1d(speed).astype(float), rebound)
    n = len(speed)
    across = np.broadcast_to(lateral, (n, 2))
    velocity = np.column_stack([across, -speed])
    after = np.column_stack([across * (rebound > 0)[:, None], rebound])
    return Impacts(
        time=np.arange(n) * 1.0 + 1.0 if time is None else np.asarray(time, float),
        diameter=np.broadcast_to(d, n).astype(float),
        position=np.broadcast_to(position, (n, 2)).astype(float),
        velocity=velocity,
        spin=np.zeros((n, 3)),
        rebound_velocity=after,
        rebound_spin=np.zeros((n, 3)),
        captured=rebound == 0.0,
        contacts=np.ones(n, dtype=np.int64),
    )


def test_crossing_times_are_those_of_free_flight():
    v, V = np.array([0.3, 0.75, 1.66, 4.0]), np.array([0.2, 0.5, 1.2, 3.0])
    found = passages(impacts(v, V), H, QUIET)
    assert found.crossed.all()
    fall, rise = found.time - impacts(v, V).time
    # falling onto the surface, and rising from it, through exactly h
    assert v * -fall - 0.5 * g * fall**2 == pytest.approx(H, rel=1e-12)
    assert V * rise - 0.5 * g * rise**2 == pytest.approx(H, rel=1e-12)
    assert (fall < 0).all()
    assert (rise > 0).all()


def test_velocity_is_the_mean_over_the_transit():
    v = np.array([0.3, 1.66])
    found = passages(impacts(v, v), H, QUIET)
    # middle of the probe volume: 150 um from top to bottom
    top, bottom = (np.sqrt(v**2 - 2 * g * (H + s * 75e-6)) for s in (1, -1))
    for leg, sign in ((INCIDENT, -1.0), (REBOUND, 1.0)):
        assert found.velocity[leg] == pytest.approx(sign * (top + bottom) / 2, rel=1e-12)
        assert found.transit[leg] == pytest.approx((bottom - top) / g, rel=1e-9)
    assert found.chord == pytest.approx(150e-6, rel=1e-12)


def test_chord_of_an_ellipse():
    place = np.array([[0.0, 0.0], [60e-6, 0.0], [0.0, 120e-6], [45e-6, 90e-6], [74e-6, 74e-6]])
    found = passages(impacts(np.full(5, 1.0), 0.5, position=place), H, QUIET)
    share = 1 - (place[:, 0] / 75e-6) ** 2 - (place[:, 1] / 150e-6) ** 2
    assert found.inside[INCIDENT].tolist() == (share > 0).tolist() == [True] * 4 + [False]
    assert found.chord[INCIDENT, :4] == pytest.approx(150e-6 * np.sqrt(share[:4]), rel=1e-12)


def test_a_sphere_must_cross_on_each_leg():
    # 75 um off after h / V: a rebound inclined by more than atan(75 um / 1 mm) passes beside
    fast = impacts(np.full(2, 50.0), 50.0)
    slope = np.tan(np.radians([4.2, 4.4]))
    fast.rebound_velocity[:, 0] = 50.0 * slope
    found = passages(fast, H, QUIET)
    assert found.crossed[INCIDENT].all()
    assert found.crossed[REBOUND].tolist() == [True, False]
    # across the beam, not along it
    turned = impacts(np.full(2, 50.0), 50.0)
    turned.rebound_velocity[:, 1] = 50.0 * slope
    assert passages(turned, H, QUIET).crossed[REBOUND].all()


def test_slow_rebounds_do_not_reach_the_probe_volume():
    least = np.sqrt(2 * g * (H + 75e-6))
    found = passages(impacts(np.full(4, 1.0), [0.0, 0.999 * least, 1.001 * least, 0.5]), H, QUIET)
    assert found.crossed[INCIDENT].all()
    assert found.crossed[REBOUND].tolist() == [False, False, True, True]


def test_a_bounce_is_an_impact_again():
    e = 0.5
    seen = []

    def later(velocity, spin, sphere):
        seen.append(sphere.tolist())
        after = velocity * [1.0, 1.0, -e]
        stays = -velocity[:, 2] < 0.3
        after = np.where(stays[:, None], 0.0, after)
        return Rebound(velocity=after, spin=spin, kept=stays, contacts=np.ones_like(sphere))

    first = impacts([1.0, 2.0, 1.0], [0.5, 1.0, 0.0], lateral=(0.01, 0.0))
    everything = with_later_impacts(first, later)
    # sphere 0 falls back with 0.5 and 0.25, sphere 1 with 1, 0.5 and 0.25
    assert seen == [[0, 1], [0, 1], [1]]
    assert -everything.velocity[3:, 2] == pytest.approx([0.5, 1.0, 0.25, 0.5, 0.25])
    assert everything.captured.tolist() == [False, False, True, False, False, True, False, True]
    flight = 2 * np.array([0.5, 1.0]) / g
    assert everything.time[3:5] == pytest.approx(first.time[:2] + flight, rel=1e-12)
    assert everything.position[3:5, 0] == pytest.approx(0.01 * flight, rel=1e-12)
    # on its way back the sphere passes the probe as fast as it rose
    found = passages(everything, H, replace(QUIET, probe_along_um=1e5, probe_across_um=1e-3))
    assert -found.velocity[INCIDENT, 3] == pytest.approx(found.velocity[REBOUND, 0], rel=1e-9)
    assert len(with_later_impacts(first, later, 0)) == 3


def test_noise_is_as_declared():
    n = 20000
    apart = np.arange(n) * 1e-2 + np.random.default_rng(3).uniform(0.0, 5e-3, n)
    many = impacts(np.full(n, 1.66), 0.0, time=apart, d=50e-6)
    found = passages(many, H, DEFAULT)
    stream, truth = records(found, n * 1e-2, DEFAULT, np.random.default_rng(4))
    real = truth.impact >= 0
    v = found.velocity[truth.leg[real], truth.impact[real]]
    assert np.std(stream.velocity[real] - v) == pytest.approx(
        np.hypot(0.005 * abs(v[0]), 0.004), rel=0.02
    )
    growth = np.log(stream.diameter[real] / 50e-6)
    # 1 % outliers do not move the quartiles
    spread = np.diff(np.quantile(growth, [0.25, 0.75]))[0] / 1.349
    assert spread == pytest.approx(np.hypot(0.02, 0.02), rel=0.03)
    outside = 1.0 - (np.exp(0.15) - np.exp(-0.15)) / (1.4 - 0.7)
    assert np.mean(np.abs(growth) > 0.15) == pytest.approx(0.01 * outside, abs=0.002)
    late = stream.time[real] - found.time[truth.leg[real], truth.impact[real]]
    assert np.abs(late).max() <= 5.0001e-6
    assert np.std(late) == pytest.approx(10e-6 / np.sqrt(12), rel=0.03)


def test_drop_out_is_a_mean_over_the_ellipse_and_none_in_the_middle():
    rng, n = np.random.default_rng(5), 40000
    place = rng.uniform(-1, 1, (n, 2))
    place = place[np.sum(place**2, axis=1) < 1] * [75e-6, 150e-6]
    n = len(place)
    spaced = {"time": np.arange(n) * 1e-2}
    spread = passages(impacts(np.ones(n), 0.0, position=place, **spaced), H, DEFAULT)
    truth = records(spread, 1.0, DEFAULT, rng)[1]
    assert truth.dropped[INCIDENT].mean() == pytest.approx(0.1, abs=0.006)
    middle = passages(impacts(np.ones(n), 0.0, **spaced), H, DEFAULT)
    assert not records(middle, 1.0, DEFAULT, rng)[1].dropped.any()


def test_false_records_come_at_their_rate_and_are_uniform():
    nobody = passages(impacts([], []), H, DEFAULT)
    stream, truth = records(nobody, 20000.0, DEFAULT, np.random.default_rng(6))
    assert len(stream) == pytest.approx(10000, abs=400)  # 4 standard deviations
    assert (truth.impact == -1).all()
    assert np.all(np.diff(stream.time) >= 0)
    for values, low, high in (
        (stream.time, 0.0, 20000.0),
        (stream.velocity, -2.0, 2.0),
        (stream.diameter, 10e-6, 125e-6),
    ):
        assert low <= values.min() < values.max() <= high
        assert values.mean() == pytest.approx((low + high) / 2, abs=0.02 * (high - low))


def test_two_spheres_at_once_reject_both():
    transit = 150e-6 / 1.0
    times = np.array([1.0, 1.0 + 0.9 * transit, 2.0, 2.0 + 1.1 * transit])
    found = passages(impacts(np.ones(4), 0.0, time=times), H, QUIET)
    stream, truth = records(found, 3.0, QUIET, np.random.default_rng(7))
    assert truth.overlapped[INCIDENT].tolist() == [True, True, False, False]
    assert truth.impact.tolist() == [2, 3]
    assert len(stream) == 2
