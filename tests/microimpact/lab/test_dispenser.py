"""Release and fall, and the interval of an experiment's mean."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import constants
from tests.shared import STILL, USUAL

from microimpact.lab.dispenser import NO_SPIN, InitialSpin, drop_height, paths
from microimpact.lab.experiment import Drop, Target
from microimpact.lab.reduction import mean_interval
from microimpact.statistics.distributions import Constant, TruncatedNormal, generator


def fall(n=5000, *, dispenser=USUAL, spin=NO_SPIN, angle=30.0, speed=1.0):
    drop = Drop(
        target=None,
        diameter_um=TruncatedNormal(mean=62, sd=4.5, low=45, high=76),
        angle=angle,
        speed=speed,
        speed_range=(0.0, np.inf),
        dispenser=dispenser,
        spin=spin,
    )
    return drop.release(n, generator(7))


@pytest.mark.parametrize("angle", [90.0, 60.0, 5.0])
def test_particles_fall_along_gravity_and_meet_the_target_at_its_angle(angle):
    falling = fall(10, dispenser=STILL, angle=angle)
    a = np.radians(angle)
    np.testing.assert_allclose(
        falling.velocity, np.tile([np.cos(a), 0.0, -np.sin(a)], (10, 1)), atol=1e-14
    )
    assert np.all(falling.position == 0.0)
    assert np.all(falling.spin == 0.0)


def test_nominal_speed_is_met_and_printed_classes_are_about_as_wide_as_their_ranges():
    # 1.59-1.69 m/s and 0.39-0.49 m/s (Section 2.4.2) hold most of what falls.
    for nominal, low, high in [(1.62, 1.59, 1.69), (0.45, 0.39, 0.49)]:
        falling = fall(speed=nominal)
        speed = np.linalg.norm(falling.velocity, axis=1)
        assert np.mean(speed) == pytest.approx(nominal, rel=0.02)
        assert np.mean((speed > low) & (speed < high)) > 0.6


def test_drop_height_is_that_of_free_fall():
    assert drop_height(np.sqrt(2 * constants.g * 0.01), STILL) == pytest.approx(0.01, rel=1e-12)
    with pytest.raises(ValueError, match=r"above the mean speed at the needle, 0.12 m/s, got 0.1"):
        drop_height(0.1, USUAL)


def test_particles_drift_for_as_long_as_they_fall():
    """From the start that their speed at the target has, h = V t - g t^2/2 with h = 10 cm."""
    fast = replace(USUAL, exit_speed_m_per_s=1.0, lateral_position_mm=0.0)
    position, velocity, speed = paths(100, generator(3), angle=90.0, height=0.1, dispenser=fast)
    time = position[:, 1] / velocity[:, 1]
    np.testing.assert_allclose(speed * time - 0.5 * constants.g * time**2, 0.1, rtol=1e-9)


def test_lateral_spread_is_seen_as_declared():
    falling = fall(20_000, angle=90.0)
    assert np.std(falling.velocity[:, 1]) == pytest.approx(0.01, rel=0.03)
    assert np.std(falling.velocity[:, 0]) == pytest.approx(0.01, rel=0.03)
    # On a tilted target the spot is drawn out along the slope.
    tilted = fall(20_000, angle=30.0)
    assert np.std(tilted.position[:, 0]) == pytest.approx(
        2 * np.std(falling.position[:, 0]), rel=0.03
    )


def test_spin_has_its_declared_share_and_sense():
    falling = fall(20_000, spin=InitialSpin(sd=0.1, mean=0.2))
    share = falling.spin * (falling.diameter / 2)[:, None]
    share /= np.linalg.norm(falling.velocity, axis=1)[:, None]
    np.testing.assert_allclose(share.mean(axis=0), [0.0, 0.2, 0.0], atol=0.004)
    np.testing.assert_allclose(share.std(axis=0), 0.1, rtol=0.03)


def test_rolling_sense_of_spin_is_that_of_the_impact(contact):
    """Spin with the mean r omega = v_t makes the slip vanish: no friction."""
    angle = 40.0
    spin = InitialSpin(sd=0.0, mean=np.cos(np.radians(angle)))
    drop = Drop(
        target=Target(contact=contact),
        diameter_um=Constant(at=62.0),
        angle=angle,
        speed=1.0,
        speed_range=(0.9, 1.1),
        dispenser=STILL,
        spin=spin,
    )
    impacts = drop.impacts(4, generator(1))
    np.testing.assert_allclose(impacts.rebound_velocity[:, 0], impacts.velocity[:, 0], rtol=1e-12)


def test_arrivals_are_in_order_and_come_in_bursts():
    time = fall(4000).time
    assert np.all(np.diff(time) >= 0.0)
    assert 4000 / time[-1] == pytest.approx(2.0 * 3.0, rel=0.05)
    gaps = np.diff(time)
    assert np.std(gaps) > 1.3 * np.mean(gaps)  # 1 for single particles at random


def test_interval_covers_the_true_mean_as_often_as_it_says():
    rng = generator(11)
    held = [
        (m := mean_interval(row)).low <= 0.7 <= m.high
        for row in 0.7 + 0.05 * rng.standard_normal((4000, 40))
    ]
    # Four standard errors of 4000 repetitions.
    assert np.mean(held) == pytest.approx(0.95, abs=4 * np.sqrt(0.95 * 0.05 / 4000))
