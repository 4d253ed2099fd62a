"""The capture velocity of the backward map."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.dynamics.normal import (
    ALWAYS_CAPTURED_ADHESION_GROUP,
    ALWAYS_CAPTURED_HERTZ_GROUP,
    normal_impact,
)

CRITICAL_HERTZ = 0.487408
CRITICAL_ADHESION = 1.162799


def bisected(contact, lower=1e-9, upper=1e4):
    """Capture velocity by halving the interval of speeds, every contact at once."""
    low = np.full(contact.shape, np.log(lower * contact.velocity_scale))
    high = np.full(contact.shape, np.log(upper * contact.velocity_scale))
    for _ in range(45):
        middle = 0.5 * (low + high)
        captured = simulate(contact, np.exp(middle)).captured
        low, high = np.where(captured, middle, low), np.where(captured, high, middle)
    return np.exp(0.5 * (low + high))


@pytest.mark.parametrize("damped", [False, True])
@pytest.mark.parametrize("exponent", [0.0, 0.5, 1.0])
def test_it_separates_capture_from_rebound(scaled, exponent, damped):
    contact = scaled(
        [0.0, 0.1, 1e-6, 0.03, 0.3],
        [0.3, 0.0, 1e-4, 0.6, 0.05],
        adhesion_rate_exponent=exponent,
        reference_velocity=3.0 * scaled().velocity_scale,
        damped_attachment=damped,
    )
    # 45 halvings leave 1e-12 of the speed
    assert capture_velocity(contact) == pytest.approx(bisected(contact), rel=1e-11)
    overdamped = contact.replace(hertz_damping=0.6 / contact.velocity_scale)
    assert np.isinf(capture_velocity(overdamped)).all()


def test_arrays_give_what_each_contact_gives_alone(scaled):
    c_h, c_a = np.array([[0.0], [0.1], [0.6]]), np.array([0.0, 0.1, 2.0])
    table = capture_velocity(scaled(c_h, c_a))
    assert table.shape == (3, 3)
    for i, hertz in enumerate(c_h[:, 0]):
        for j, adhesion in enumerate(c_a):
            assert table[i, j] == capture_velocity(scaled(hertz, adhesion))


def test_it_is_zero_without_damping_and_without_adhesion(scaled):
    assert capture_velocity(scaled()) == 0.0
    assert capture_velocity(scaled(0.1, 0.1).replace(work_of_adhesion=0.0)) == 0.0
    rated = scaled(0.0, 0.0, adhesion_rate_exponent=1.0, reference_velocity=1.0)
    assert capture_velocity(rated) == 0.0
    bare = scaled(0.1, 0.1, adhesion_rate_exponent=1.0, reference_velocity=1.0)
    assert capture_velocity(bare.replace(work_of_adhesion=0.0)) == 0.0


def _escapes(c_h, c_a):
    """Whether the path that leaves at rest, reversed in time, finds no turning point."""

    def rate(s, u):
        return 2 * s**2 * ((1 - s**2) / u - c_a - c_h * s**2)

    def turned(s, u):
        return u[0] + 0.02 * s if s > 1.2 else -1.0

    def free(s, u):
        return 1 + c_h * u[0] if c_h > 0 else u[0] + 0.3 * c_a * s**3 if s > 60 else 1.0

    turned.terminal = free.terminal = True
    start = 1e-3
    exit_speed = -np.sqrt(4 / 3) * start**1.5
    path = solve_ivp(
        rate, (start, 200), [exit_speed], "LSODA", rtol=1e-10, atol=1e-13, events=(turned, free)
    )
    return path.t_events[0].size == 0


@pytest.mark.parametrize(
    ("place", "critical"), [((1.0, 0.0), CRITICAL_HERTZ), ((0.0, 1.0), CRITICAL_ADHESION)]
)
def test_there_is_a_damping_beyond_which_no_speed_rebounds(scaled, place, critical):
    direction = np.array(place)
    assert _escapes(*(critical * (1 + 1e-5) * direction))
    assert not _escapes(*(critical * (1 - 1e-5) * direction))
    assert np.isinf(capture_velocity(scaled(*(critical * (1 + 2e-6) * direction))))
    assert np.isfinite(capture_velocity(scaled(*(critical * (1 - 2e-6) * direction))))


def test_the_bounds_of_damping_that_always_captures_lie_just_beyond():
    assert CRITICAL_HERTZ < ALWAYS_CAPTURED_HERTZ_GROUP < 1.01 * CRITICAL_HERTZ
    assert CRITICAL_ADHESION < ALWAYS_CAPTURED_ADHESION_GROUP < 1.01 * CRITICAL_ADHESION


def test_damped_attachment_captures_more(scaled):
    plain, damped = (capture_velocity(scaled(0.0, 0.3, damped_attachment=d)) for d in (False, True))
    assert damped > 1.1 * plain


@pytest.mark.parametrize("exponent", [0.3, 1.0, 10.0, 100.0])
def test_a_rated_threshold_meets_its_own_damping(scaled, exponent):
    reference = 2.0 * scaled().velocity_scale
    contact = scaled(0.02, 0.4, adhesion_rate_exponent=exponent, reference_velocity=reference)
    threshold = capture_velocity(contact)
    constant = scaled(0.02).replace(adhesion_damping=contact.adhesion_damping_at(threshold))
    assert capture_velocity(constant) == pytest.approx(threshold, rel=1e-10 * max(1, exponent))


@pytest.mark.parametrize("ledger", [False, True])
def test_rounding_decides_at_the_threshold_itself_and_nothing_fails(scaled, ledger):
    """There s falls towards zero for ever; the integration must end all the same."""
    rng = np.random.default_rng(5)
    contact = scaled(rng.uniform(0.0, 0.05, 4000), rng.uniform(0.05, 0.9, 4000))
    limit = capture_velocity(contact)
    for ulps in (-2, -1, 0, 1, 2):
        speed = limit * (1.0 + ulps * np.finfo(float).eps)
        impact = normal_impact(contact, speed, ledger=ledger)
        e = impact.coefficient_of_restitution[~impact.captured]
        assert np.all(np.isfinite(e))
        assert np.all((e >= 0.0) & (e < 1e-5))
