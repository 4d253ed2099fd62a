"""Samples of virtual impacts, their comparison, and the pieces of each mechanism."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.shared import STILL

from microimpact.lab.bounces import resting
from microimpact.lab.dispenser import NO_SPIN
from microimpact.lab.events import Falling
from microimpact.lab.experiment import Target
from microimpact.lab.reduction import EXACT
from microimpact.lab.surface import rough
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate, velocity_components
from microimpact.statistics.distributions import TruncatedNormal, generator
from study.analyses.mechanisms.impulse_regions import regions
from study.analyses.mechanisms.loss import rigid_loss
from study.analyses.mechanisms.spin import rolling_limit
from study.analyses.mechanisms.spore import off_centre
from study.analyses.pile_up.compute import onset
from study.samples import Dropped, Sample, Sampling, difference_columns, half_width

SAMPLING = Sampling(seed=5, impacts=800, events=40, angle_error_deg=0.25, dispenser=STILL)
STEEL = Dropped(
    case="none",
    friction=0.15,
    diameter_um=TruncatedNormal(mean=62, sd=0.01, low=61, high=63),
    surface_slope=0.0,
    particle_slope=0.0,
    speed_m_per_s=1.66,
    speed_range_m_per_s=(1.6, 1.72),
    spin=NO_SPIN,
)


def on(contact):
    return Sample(dropped=STEEL, contact=contact, sampling=SAMPLING)


@pytest.mark.parametrize("angle", [85.0, 60.0, 30.0])
def test_a_sample_without_spreads_is_the_single_impact(contact, angle):
    one = on(contact).seen(angle)
    sphere = simulate(contact, 1.66, angle)
    e, mu, loss = (one.means[q] for q in ("restitution", "impulse_ratio", "energy_loss"))
    assert e.value == pytest.approx(float(sphere.coefficient_of_restitution), abs=1e-4)
    assert mu.value == pytest.approx(float(sphere.impulse_ratio), abs=1e-4)
    assert loss.value == pytest.approx(float(sphere.translational_energy_loss), abs=1e-4)
    assert one.captured_share == 0.0
    # A tilt turns part of the tangential speed into normal speed: de = (1 + e) cot(alpha) dalpha
    # where the tangential speed hardly changes.
    if angle == 30.0:
        rebound = float(sphere.tangential_velocity) / (1.66 * np.sin(np.radians(angle)))
        cot = 1.0 / np.tan(np.radians(angle))
        slope = rebound + e.value * cot
        assert e.systematic == pytest.approx(slope * np.radians(0.25), rel=0.02)


def test_slopes_lower_restitution_at_steep_angles_and_raise_it_at_shallow_ones(contact):
    smooth = on(contact)
    rough = smooth.but(surface_slope=0.1)
    steep, shallow = (
        difference_columns(rough.seen(a), smooth.seen(a), SAMPLING) for a in (85.0, 15.0)
    )
    e = float(simulate(contact, 1.66, 85.0).coefficient_of_restitution)
    # Exact at normal incidence: e - (e + 5/7) phi^2, over both axes of slopes.
    assert steep["restitution_difference"] == pytest.approx(-2 * (e + 5 / 7) * 0.01, rel=0.15)
    assert shallow["restitution_difference"] > 0.2
    assert shallow["impulse_ratio_difference"] > 0.0


def test_half_width_of_a_difference():
    one = replace(EXACT, value=0.7, sd=0.04)
    other = replace(EXACT, value=0.6, sd=0.03, systematic=0.004)
    expected = 1.9908 * np.sqrt((0.04**2 + 0.03**2) / 40 + 0.004**2)
    assert half_width(one, other, SAMPLING) == pytest.approx(expected, rel=1e-4)


def test_bodies_without_offset_are_spheres(contact):
    body = off_centre(on(contact), 40.0, 0.0)
    sphere = on(contact).seen(40.0)
    for name, of in sphere.means.items():
        assert body.means[name].value == pytest.approx(of.value, abs=1e-9), name


def test_limit_of_rolling(contact):
    e = float(simulate(contact, 1.66, 48.0).coefficient_of_restitution)
    found = rolling_limit(contact, 1.66, 0.0)
    # cot(alpha) = (7/2) f (1 + e); adhesion adds to the compressive impulse that supports friction.
    closed = np.degrees(np.arctan(1.0 / (3.5 * 0.15 * (1.0 + e))))
    assert found == pytest.approx(closed, abs=1.0)
    assert rolling_limit(contact, 1.66, -0.3) > found + 5.0


def test_slopes_let_capture_appear_at_a_lower_normal_speed_at_shallow_angles(contact):
    """A finding of docs/experiments.md: without slopes capture knows the normal speed alone."""
    spheres, limit = 500, float(capture_velocity(contact))

    def captured(slope_sd, angle):
        """Return the share captured at 0.9 of the normal speed of capture."""
        into, along = velocity_components(0.9 * limit / np.sin(np.radians(angle)), angle)
        velocity = np.tile([along, 0.0, into], (spheres, 1))
        target = Target(contact=contact, surface=rough(slope_sd))
        diameter = np.full(spheres, contact.diameter)
        return target.hit(diameter, velocity, 0.0 * velocity, generator(98)).captured.mean()

    assert captured(0.0, 90.0) == captured(0.0, 10.0) == 1.0
    assert captured(0.1, 90.0) > 0.9
    assert captured(0.1, 10.0) < 0.5


def test_no_spin_both_narrows_the_rolling_region_and_ends_friction(contact):
    """A finding of docs/experiments.md, on Fig. 9."""
    slow, spins = 0.45, np.linspace(-1.0, 1.0, 41)
    wide = rolling_limit(contact, 1.6, 0.0)
    narrower = np.array([rolling_limit(contact, slow, spin) for spin in spins]) >= wide + 5.0
    impact = simulate(contact, slow, 45.0, spins * slow / contact.radius)
    frictionless = impact.impulse_ratio <= 0.0
    assert narrower.any()
    assert frictionless.any()
    assert not (narrower & frictionless).any()


def test_regions_of_an_ideal_curve():
    angle = np.arange(87.0, 5.0, -2.0)
    x = 1.0 / np.tan(np.radians(angle))
    ratio = np.interp(x, [0.0, 0.7, 1.4, 4.0, 11.0], [0.0, 0.12, 0.15, 0.15, 0.24])
    rows = regions(angle, ratio, np.full(angle.size, 1e-3), 0.1)
    assert [row["region"] for row in rows] == ["rolling", "transition", "sliding", "departure"]
    # Without a rise there is no fourth one, and noise makes none.
    noise = 1e-3 * generator(1).standard_normal(angle.size)
    plain = regions(angle, np.minimum(ratio, 0.15) + noise, np.full(angle.size, 1e-3), 0.1)
    assert "departure" not in {row["region"] for row in plain}


def test_loss_of_a_rolling_sphere():
    # (1 - e^2) sin^2 + (24/49) cos^2
    angle, e = np.array([80.0, 70.0]), 0.8
    sine = np.sin(np.radians(angle)) ** 2
    expected = (1 - e**2) * sine + 24 / 49 * (1 - sine)
    np.testing.assert_allclose(rigid_loss(e, 0.5, angle), expected, rtol=1e-12)


def falling_from(position, velocity, spin):
    """What arrives on smooth steel spheres of 62 um."""
    n = len(velocity)
    return Falling(
        time=np.zeros(n),
        diameter=np.full(n, 62e-6),
        position=np.array(position),
        velocity=np.array(velocity),
        spin=np.array(spin),
    )


def test_bounces_end_where_a_ball_would(contact):
    """Straight up and down with a drift: flight 2 V/g, a geometric series until capture."""
    drop, rng = STEEL.drop(contact, 90.0, STILL), generator(0)
    drift, speed = 0.004, 0.3
    rolls = [[0.0, drift / 31e-6, 0.0]]  # already: friction does nothing
    first = drop.hit(falling_from([[0.0, 0.0]], [[drift, 0.0, -speed]], rolls), rng)
    found = resting(first, drop.target.later(first.diameter, rng), 60, 1.0)
    way, v, count = 0.0, speed, 1
    while v >= float(capture_velocity(contact)):
        v *= float(simulate(contact, v).coefficient_of_restitution)
        way += drift * 2 * v / 9.80665
        count += 1
    assert found.captured.all()
    assert found.impacts[0] == count
    assert found.reach[0] == pytest.approx(way, rel=1e-6)
    assert found.on_target(1.01 * way).all()
    assert not found.on_target(0.99 * way).any()


def test_spheres_past_the_edge_are_let_go(contact):
    drop, rng = STEEL.drop(contact, 90.0, STILL), generator(0)
    velocity = [[0.5, 0.0, -0.5], [0.0, 0.0, -0.5]]
    first = drop.hit(falling_from(np.zeros((2, 2)), velocity, np.zeros((2, 3))), rng)
    found = resting(first, drop.target.later(first.diameter, rng), 60, 1e-3)
    assert found.captured.tolist() == [False, True]
    assert found.impacts[0] == 1
    assert found.impacts[1] > 3


def test_onset_is_the_last_crossing():
    speed = np.array([0.1, 0.2, 0.3, 0.4])
    assert onset(speed, np.array([0.9, 0.6, 0.4, 0.0]), 0.5) == pytest.approx(0.25)
    assert np.isnan(onset(speed, np.zeros(4), 0.5))
    assert np.isnan(onset(speed, np.ones(4), 0.5))
