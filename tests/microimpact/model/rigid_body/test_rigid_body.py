"""Rigid body model: identities of Eqs. (1)-(18)."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from microimpact.model.rigid_body.algebra import (
    INERTIA,
    adhesion_impulse,
    adhesion_work,
    deformation_impulse,
    energy_loss,
    restitution_with_adhesion,
    rigid_body_rebound,
    rolling_impulse_ratio,
)

RADIUS = 31e-6

states = st.fixed_dictionaries(
    {
        "v_n": st.floats(-10.0, -0.01),
        "v_t": st.floats(-10.0, 10.0),
        "omega": st.floats(-3e5, 3e5),
        "radius": st.just(RADIUS),
        "e": st.floats(0.0, 1.0),
        "friction": st.floats(0.0, 1.0),
    }
)


def kinetic(v_n, v_t, omega, radius):
    """Energies per mass, translational and in all."""
    linear = 0.5 * (v_n**2 + v_t**2)
    return linear, linear + 0.5 * INERTIA * radius**2 * omega**2


@given(state=states)
def test_newton_and_coulomb(state):
    after = rigid_body_rebound(**state)
    assert after.V_n == -state["e"] * state["v_n"]
    assert abs(after.mu) <= state["friction"]
    normal, tangential = after.V_n - state["v_n"], after.V_t - state["v_t"]
    assert tangential == pytest.approx(after.mu * normal, rel=1e-9, abs=1e-13)


@given(state=states)
def test_friction_keeps_the_moment_of_momentum_about_the_contact(state):
    after = rigid_body_rebound(**state)
    before_moment = state["v_t"] + INERTIA * RADIUS * state["omega"]
    after_moment = after.V_t + INERTIA * RADIUS * after.Omega
    assert after_moment == pytest.approx(before_moment, rel=1e-12, abs=1e-12)


@given(state=states)
def test_slip_stops_or_goes_on_in_its_direction(state):
    after = rigid_body_rebound(**state)
    before = state["v_t"] - RADIUS * state["omega"]
    left = after.V_t - RADIUS * after.Omega
    assert abs(left) <= abs(before) + 1e-12
    assert left * before >= -1e-12
    if abs(after.mu) < state["friction"]:
        assert left == pytest.approx(0.0, abs=1e-12)


@given(state=states)
def test_losses_are_those_of_the_velocities(state):
    after = rigid_body_rebound(**state)
    linear, total = kinetic(state["v_n"], state["v_t"], state["omega"], RADIUS)
    linear_after, total_after = kinetic(after.V_n, after.V_t, after.Omega, RADIUS)
    given_state = {key: state[key] for key in ("v_n", "v_t", "omega", "radius", "e")}
    loss = energy_loss(**given_state, mu=after.mu)
    scale = total / linear
    assert loss.translational == pytest.approx(1 - linear_after / linear, abs=1e-11 * scale)
    assert loss.total == pytest.approx((total - total_after) / linear, abs=1e-11 * scale)
    assert loss.total >= -1e-12 * scale


def test_the_printed_loss_is_translational_and_without_spin():
    """Eq. (14) and the form with 7/2 differ by what goes into rotation."""
    v_n, v_t, e, mu = -1.0, 2.0, 0.7, -0.15
    loss = energy_loss(v_n, v_t, 0.0, RADIUS, e, mu)
    eta, x = v_t / v_n, mu * (1 + e)
    printed = ((1 - e**2) + 2 * x * eta - x**2) / (1 + eta**2)
    assert loss.translational == pytest.approx(printed, rel=1e-14)
    assert loss.translational - loss.total == pytest.approx(2.5 * x**2 / (1 + eta**2), rel=1e-13)


def test_sliding_and_rolling_by_hand():
    sliding = rigid_body_rebound(-1.0, 4.0, 0.0, RADIUS, 0.5, 0.15)
    assert sliding.mu == -0.15
    assert sliding.V_t == pytest.approx(4 - 0.15 * 1.5)
    assert sliding.Omega == pytest.approx(2.5 * 0.15 * 1.5 / RADIUS)
    rolling = rigid_body_rebound(-1.0, 0.7, 0.0, RADIUS, 0.5, 0.15)
    assert rolling.mu == pytest.approx(-2 / 7 * 0.7 / 1.5)
    assert rolling.V_t == pytest.approx(0.5)
    assert rolling.Omega == pytest.approx(0.5 / RADIUS)


def test_rolling_impulse_ratio_is_signed():
    assert rolling_impulse_ratio(-1.0, 0.7, 0.5) == pytest.approx(-0.4 / 3, rel=1e-14)
    assert rolling_impulse_ratio(-1.0, -0.7, 0.5) == pytest.approx(0.4 / 3, rel=1e-14)


ROLLING = {"v_n": -1.0, "v_t": 0.4, "omega": 0.0, "radius": RADIUS, "e": 0.7, "friction": 0.5}
GOOD = ROLLING | {"friction": 0.15}


class TestAdhesionImpulses:
    @given(v_n=st.floats(-10, -0.01), restitution=st.floats(0.0, 1.0), rho=st.floats(0.0, 1.0))
    def test_impulses_give_the_restitution(self, v_n, restitution, rho):
        total = deformation_impulse(v_n, restitution) + adhesion_impulse(v_n, restitution, rho)
        e = restitution_with_adhesion(restitution, rho)
        assert total == pytest.approx(-(1 + e) * v_n, rel=1e-14)

    def test_adhesion_work_is_what_it_takes_from_the_rebound(self):
        assert adhesion_work(-2.0, 0.5, 0.0) == 0.0
        assert adhesion_work(-2.0, 0.5, 1.0) == pytest.approx(0.5 * 4 * 0.25)
        assert adhesion_work(-2.0, 0.5, 0.4) == pytest.approx(0.5 * 4 * 0.25 * 0.4 * 1.6)

    def test_full_adhesion_holds_the_sphere(self):
        assert restitution_with_adhesion(0.9, 1.0) == 0.0


class TestArguments:
    def test_they_broadcast(self):
        after = rigid_body_rebound(**GOOD | {"v_n": [[-1.0], [-2.0]], "friction": [0.1, 0.2, 0.3]})
        assert {np.shape(value) for value in after} == {(2, 3)}
        single = rigid_body_rebound(**GOOD | {"v_n": -2.0, "friction": 0.3})
        assert [value[1, 2] for value in after] == list(single)

    @pytest.mark.parametrize(
        ("name", "value", "said"),
        [
            ("v_n", 1.0, "1"),
            ("v_n", 0.0, "0"),
            ("v_t", math.nan, "nan"),
            ("omega", math.inf, "inf"),
            ("radius", 0.0, "0"),
            ("e", 1.1, "1.1"),
            ("e", -0.1, "-0.1"),
            ("friction", -0.1, "-0.1"),
        ],
    )
    def test_out_of_range_is_a_value_error(self, name, value, said):
        with pytest.raises(ValueError, match=f"^{name} must be finite.*got {said}$"):
            rigid_body_rebound(**GOOD | {name: value})

    @pytest.mark.parametrize("name", list(GOOD))
    @pytest.mark.parametrize("value", ["1", None, False, 1j])
    def test_no_number_is_a_type_error(self, name, value):
        with pytest.raises(TypeError, match=f"^{name} must be a real number"):
            rigid_body_rebound(**GOOD | {name: value})

    def test_shapes_are_named(self):
        with pytest.raises(ValueError, match=r"v_n \(2,\), v_t \(3,\)"):
            rigid_body_rebound(**GOOD | {"v_n": [-1.0, -2.0], "v_t": [1.0, 2.0, 3.0]})
