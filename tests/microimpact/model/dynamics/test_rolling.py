"""Moments of rolling: closed forms against quadrature, limits, and impulses over an impact."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
import pytest
from scipy.constants import g
from scipy.integrate import dblquad, quad

from microimpact.model.contact_laws import JKR
from microimpact.model.dynamics.impact import simulate
from microimpact.model.dynamics.rolling import (
    adhesion_moment,
    damping_moment,
    deformation_moment,
    gravity_ratio,
    opening_level,
    peeling_moment,
    rolling_distance,
    rolling_impulses,
)

# Of SI numbers, which may be small: a share alone.
approx = partial(pytest.approx, abs=0.0)

A, FORCE, RING = 1.7e-6, 3e-3, 60.0


def hertz_moment(weight):
    """Moment of weight(x) times Hertz's pressure about the centre; x behind it, all over a F."""

    def element(y, x):
        return 1.5 / math.pi * math.sqrt(max(1 - x * x - y * y, 0.0)) * weight(x) * x

    return dblquad(element, -1, 1, lambda x: -math.sqrt(1 - x * x), lambda x: math.sqrt(1 - x * x))[
        0
    ]


@pytest.mark.parametrize("level", [-1.0, -0.4, 0.0, 0.4, 1.0])
def test_hysteresis_where_the_contact_opens(level):
    """Points at x > -h a open and carry less: the moment of the missing pressure."""
    loss = 0.3
    missing, _ = quad(
        lambda x: loss * 0.75 * (1 - x * x) * x, -level, 1.0
    )  # Hertz's pressure, strip by strip
    found = deformation_moment(A, FORCE, loss, level)
    assert found == approx(missing * A * FORCE, rel=1e-10, abs=1e-30)


def test_leading_half_of_hertz_pressure_has_three_sixteenths():
    half = hertz_moment(lambda x: float(x > 0.0))
    assert half == approx(3 / 16, rel=1e-4)
    assert deformation_moment(A, FORCE, 1.0, 0.0) == approx(half * A * FORCE, rel=1e-4)


def test_damping_of_hertz_pressure(contact):
    """A pressure that is greater by c_H spin x ahead of the centre (x^2 averages a^2/5)."""
    moment = hertz_moment(lambda x: x)
    found = damping_moment(contact.replace(hertz_damping=0.2), A, FORCE, 0.0, 2e4, 0.0)
    assert found == approx(0.2 * 2e4 * FORCE * A**2 * moment, rel=1e-6)


@pytest.mark.parametrize("level", [-1.0, -0.6, 0.0, 0.6, 1.0])
def test_ring_force_where_the_contact_opens(contact, level):
    lever, _ = quad(lambda t: math.cos(t) * (level + math.cos(t) > 0), -math.pi, math.pi, limit=500)
    expected = RING * A**2 * lever
    assert adhesion_moment(A, RING, level) == approx(expected, rel=1e-4, abs=1e-13)
    rate, _ = quad(lambda t: max(level + math.cos(t), 0.0) * math.cos(t), -math.pi, math.pi)
    found = damping_moment(contact, A, 0.0, 1.4, 2e4, level)
    assert found == approx(1.4 * float(contact.ring_force) * 2e4 * A**3 * rate, rel=1e-6, abs=1e-25)


def test_opening_level():
    assert opening_level(A, 0.0, 2e4) == 0.0
    assert opening_level(A, -1.0, 2e4) == -1.0
    assert opening_level(A, 0.5 * 2e4 * A, 2e4) == approx(0.5)
    # without rolling the whole contact closes, or opens
    assert opening_level(np.array([A, 0.0]), np.array([-0.3, 0.3]), 0.0).tolist() == [-1.0, 1.0]


def test_peeling_moment(contact):
    expected = 6 * math.pi * 0.5 * 31e-6 * 1e-9
    assert peeling_moment(contact, 1e-9) == approx(expected, rel=1e-14)


@pytest.fixture
def impact(contact):
    def run(angle=45.0, points=400, speed=1.66):
        return rolling_impulses(contact, speed, angle, points)

    return run


@pytest.mark.parametrize("angle", [10.0, 45.0, 70.0, 89.0])
def test_friction_is_that_of_the_simulation(contact, impact, angle):
    outcome = simulate(contact, 1.66, angle)
    v_t = 1.66 * math.sin(math.radians(90.0 - angle))
    momentum = contact.mass * contact.radius * (v_t - outcome.tangential_velocity)
    assert impact(angle).friction == approx(momentum, rel=1e-9)


def test_impulses_do_not_depend_on_the_sampling(impact):
    for angle in (20.0, 89.5):
        coarse, fine = impact(angle), impact(angle, points=20_000)
        for name in coarse.__dataclass_fields__:
            assert getattr(coarse, name) == approx(getattr(fine, name), rel=3e-3), name


@pytest.mark.parametrize("angle", [10.0, 45.0, 80.0])
def test_every_estimate_stays_below_its_bound(impact, angle):
    found = impact(angle)
    assert 0.0 < found.hysteresis < found.bound
    assert 0.0 < found.damping < found.bound


def test_bound_has_the_contact_radius_for_lever_arm(contact):
    """Without adhesion and in sliding, r times friction is r f times the impulse of pressure."""
    bare = contact.replace(work_of_adhesion=0.0)
    found = rolling_impulses(bare, 1.66, 20.0)
    lever = found.bound / found.friction * bare.friction * bare.radius
    assert 0.8 * found.contact_radius < lever < found.contact_radius


def test_moments_that_need_rolling_vanish_with_it_and_the_bound_does_not(impact):
    near, nearer = impact(88.0), impact(89.0)
    for name in ("hysteresis", "damping", "rolled"):
        halved = getattr(near, name) / getattr(nearer, name)
        assert halved == approx(2.0, rel=0.03), name
    assert near.bound == approx(nearer.bound, rel=1e-3)


def test_distance_is_that_of_the_energy(contact):
    v, shift = 0.1, 2e-9
    distance = rolling_distance(contact, v, shift)
    work = peeling_moment(contact, shift) / contact.radius * distance
    assert work == approx(0.7 * contact.mass * v**2, rel=1e-13)
    # downhill the weight adds its work
    downhill = rolling_distance(contact, v, shift, 30.0)
    weight = contact.mass * g * math.sin(math.radians(30.0)) * downhill
    resisted = peeling_moment(contact, shift) / contact.radius * downhill
    assert resisted == approx(0.7 * contact.mass * v**2 + weight, rel=1e-12)


def test_gravity_rolls_a_sphere_whose_adhesion_hardly_lags(contact):
    threshold = contact.mass * g / (6 * math.pi * contact.work_of_adhesion)
    assert gravity_ratio(contact, threshold, 90.0) == approx(1.0, rel=1e-13)
    shifts = threshold * np.array([0.9, 1.1])
    assert np.isinf(rolling_distance(contact, 0.1, shifts, 90.0)).tolist() == [True, False]
    # weight over adhesion grows with the cube of the diameter, whatever the radius of the contact
    larger = contact.replace(diameter=2 * contact.diameter)
    ratio = gravity_ratio(larger, 1e-9, 45.0) / gravity_ratio(contact, 1e-9, 45.0)
    assert ratio == approx(8.0, rel=1e-12)


def test_wrong_arguments_are_refused(contact):
    with pytest.raises(ValueError, match=r"no rebound at speed 0.001 m/s and angle 45 deg"):
        rolling_impulses(contact, 1e-3, 45.0)
    with pytest.raises(ValueError, match="contact must have the law 'ring force' here, got 'jkr'"):
        rolling_impulses(contact.by_law(JKR(), 0.1), 1.66, 45.0)
    with pytest.raises(ValueError, match="tilt must be"):
        rolling_distance(contact, 0.1, 1e-9, 91.0)
    with pytest.raises(ValueError, match="shift must be"):
        gravity_ratio(contact, 0.0, 45.0)
    with pytest.raises(TypeError, match="contact must be a Contact"):
        rolling_distance(None, 0.1, 1e-9)
