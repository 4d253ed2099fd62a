"""Impact on a slope: rotation, the expansions and their orders, bounds of energy (Eqs. 35-41)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from microimpact.model.rigid_body.algebra import INERTIA, rigid_body_rebound
from microimpact.model.rigid_body.roughness import (
    energy_bound,
    measured_impulse_ratio,
    measured_restitution,
    normal_restitution,
    rolling_impulse_ratio_measured,
    rolling_restitution,
    rough_rebound,
    shallow_restitution,
    sloped_impulse_ratio,
)

E, F = 0.7, 0.15
RADIUS, SPEED = 31e-6, 1.66

impacts = st.fixed_dictionaries(
    {
        "angle": st.floats(0.02, np.pi / 2),
        "slope": st.floats(-1.4, 1.4),
        "e": st.floats(0.0, 1.0),
        "friction": st.floats(0.0, 1.0),
        "spin_ratio": st.floats(-1.0, 1.0),
    }
)


def turned(vector, angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]]) @ vector


def rotated_collision(angle, slope, e, friction, spin_ratio):
    """Turn velocities into the frame of the slope, collide, and turn back; SI units.

    Vectors are (t, n). A slope that faces a sphere moving along +t rises along +t.
    """
    v = SPEED * np.array([np.cos(angle), -np.sin(angle)])
    local_t, local_n = turned(v, -slope)
    omega = spin_ratio * SPEED / RADIUS
    after = rigid_body_rebound(local_n, local_t, omega, RADIUS, e, friction)
    V = turned(np.array([after.V_t, after.V_n]), slope)
    return v, V, after


@given(impact=impacts)
def test_exact_coefficients_are_those_of_a_rotated_collision(impact):
    assume(impact["angle"] + impact["slope"] > 0.02)
    v, V, after = rotated_collision(**impact)
    change = V - v
    assume(abs(change[1]) > 0.05 * SPEED)
    rebound = rough_rebound(**impact)
    scale = 1.0 / np.sin(impact["angle"])
    assert rebound.impulse_ratio == pytest.approx(after.mu, abs=1e-13)
    assert rebound.measured_restitution == pytest.approx(-V[1] / v[1], abs=1e-13 * scale)
    ratio = change[0] / change[1]
    assert rebound.measured_impulse_ratio == pytest.approx(ratio, abs=1e-13 * (1 + ratio**2) * 20)


def test_equation_35_term_by_term():
    """The printed numerator over both denominators, from the primed velocities."""
    angle, slope, mu = np.radians(25.0), np.radians(7.0), -0.1
    before_t, before_n = np.cos(angle + slope), -np.sin(angle + slope)
    after_t = before_t - mu * (1 + E) * before_n
    numerator = E * np.cos(slope) - after_t * np.sin(slope) / before_n
    tangent = before_t * np.sin(slope) / before_n
    found = measured_restitution(angle, slope, E, mu)
    assert found == pytest.approx(numerator / (np.cos(slope) + tangent), rel=1e-13)
    printed = measured_restitution(angle, slope, E, mu, printed=True)
    assert printed == pytest.approx(numerator / (np.cos(slope) - tangent), rel=1e-13)


def test_a_flat_surface_is_measured_as_it_is():
    rebound = rough_rebound(np.radians([5.0, 45.0, 90.0]), 0.0, E, F, 0.1)
    assert rebound.measured_restitution == pytest.approx(E, rel=1e-15)
    assert rebound.measured_impulse_ratio == pytest.approx(rebound.impulse_ratio, rel=1e-15)


def order(error):
    """Power of the small quantity by which an error falls, between its smallest values."""
    small = np.array([4e-3, 2e-3, 1e-3])
    errors = np.array([abs(error(x)) for x in small])
    return np.log2(errors[:-1] / errors[1:])[-1]


def shallow_error(x, printed):
    exact = rough_rebound(x, 0.7 * x, E, F).measured_restitution
    return shallow_restitution(x, 0.7 * x, E, -F, printed=printed) - exact


def test_order_of_the_shallow_expansion_in_both_angles():
    assert order(lambda x: shallow_error(x, True)) == pytest.approx(1.0, abs=0.1)
    assert order(lambda x: shallow_error(x, False)) == pytest.approx(2.0, abs=0.1)
    # without friction the printed form is as good: the condition is on f, not on f over alpha
    frictionless = rough_rebound(0.01, 0.007, E, 0.0).measured_restitution
    both = [shallow_restitution(0.01, 0.007, E, 0.0, printed=p) for p in (True, False)]
    assert both[0] == both[1] == pytest.approx(frictionless, rel=1e-3)


@pytest.mark.parametrize("friction", [0.02, 0.15, 0.5])
@pytest.mark.parametrize("angle", [0.01, 0.03, 0.1])
def test_condition_of_the_shallow_expansion(friction, angle):
    """Its relative error is about f (1 + e) phi (alpha + phi)/(...): f/alpha says nothing."""
    slope = angle
    exact = rough_rebound(angle, slope, E, friction).measured_restitution
    error = shallow_restitution(angle, slope, E, -friction, printed=True) / exact - 1.0
    condition = friction * (1.0 + E) * (angle + slope)
    assert error < condition + (angle + slope) ** 2
    share = slope / (E * (angle + slope) + slope)
    assert error == pytest.approx(condition * share, abs=1.5 * (angle + slope) ** 2)


def test_orders_of_the_sloped_impulse_ratio():
    def error(x, printed):
        return sloped_impulse_ratio(x, -F, printed=printed) - measured_impulse_ratio(x, -F)

    assert order(lambda x: error(x, True)) == pytest.approx(1.0, abs=0.1)
    assert order(lambda x: error(x, False)) == pytest.approx(2.0, abs=0.1)


def at_normal(x, spin=0.0, friction=10.0):
    return rough_rebound(np.pi / 2, x, E, friction, spin)


def test_exact_forms_at_normal_incidence():
    x, spin = np.linspace(-0.4, 0.4, 9), 0.3
    c, s = np.cos(x), np.sin(x)
    rebound = at_normal(x, spin)
    assert rebound.rolling.all()
    general = E * c**2 - s**2 + (1 + E) * rebound.impulse_ratio * s * c
    assert rebound.measured_restitution == pytest.approx(general, rel=1e-13)
    rolling = E * c**2 - 5 / 7 * s**2 + 2 / 7 * spin * s
    assert rebound.measured_restitution == pytest.approx(rolling, rel=1e-13)


@pytest.mark.parametrize("spin", [0.0, 0.3])
def test_orders_of_the_normal_restitution(spin):
    def error(x, printed):
        rebound = at_normal(x, spin)
        value = normal_restitution(x, E, rebound.impulse_ratio, printed=printed)
        return value - rebound.measured_restitution

    assert order(lambda x: error(x, True)) == pytest.approx(2.0, abs=0.1)
    # the first error is of (1 + e) mu phi^3, which without spin is of the fourth order
    assert order(lambda x: error(x, False)) == pytest.approx(3.0 if spin else 4.0, abs=0.1)


def test_orders_of_the_rolling_restitution():
    def error(x, spin, printed):
        value = rolling_restitution(x, E, spin, printed=printed)
        return value - at_normal(x, spin).measured_restitution

    assert order(lambda x: error(x, 0.0, True)) == pytest.approx(2.0, abs=0.1)
    assert order(lambda x: error(x, 0.0, False)) == pytest.approx(4.0, abs=0.1)
    assert order(lambda x: error(x, 0.3, False)) == pytest.approx(3.0, abs=0.1)
    # 9/7 for e + 5/7: right at e = 4/7 alone
    assert rolling_restitution(0.1, 4 / 7) == pytest.approx(
        rolling_restitution(0.1, 4 / 7, printed=True), rel=1e-14
    )
    assert rolling_restitution(0.1, E, printed=True) > rolling_restitution(0.1, E)


def test_orders_and_sign_of_the_rolling_impulse_ratio():
    def error(x, spin, printed):
        value = rolling_impulse_ratio_measured(x, E, spin, printed=printed)
        return value - at_normal(x, spin).measured_impulse_ratio

    assert order(lambda x: error(x, 0.0, True)) == pytest.approx(3.0, abs=0.1)
    assert order(lambda x: error(x, 0.3, True)) == pytest.approx(0.0, abs=0.1)
    assert order(lambda x: error(x, 0.3, False)) == pytest.approx(2.0, abs=0.1)
    # no slope: the spin alone, forward spin pushes forward
    exact = at_normal(0.0, 0.3).measured_impulse_ratio
    assert exact > 0.0
    assert rolling_impulse_ratio_measured(0.0, E, 0.3) == pytest.approx(exact, rel=1e-14)
    assert rolling_impulse_ratio_measured(0.0, E, 0.3, printed=True) == pytest.approx(-exact)


@given(impact=impacts)
def test_no_impact_breaks_energy(impact):
    assume(impact["angle"] + impact["slope"] > 1e-3)
    rebound = rough_rebound(**impact)
    e_m, mu_m = rebound.measured_restitution, rebound.measured_impulse_ratio
    bound = energy_bound(impact["angle"], impact["spin_ratio"])
    assert abs(e_m) <= bound * (1 + 1e-12)
    assume(abs(1 + e_m) > 1e-3 and abs(mu_m) < 1e3)
    sine, cosine = np.sin(impact["angle"]), np.cos(impact["angle"])
    kept = (e_m * sine) ** 2 + (cosine + mu_m * (1 + e_m) * sine) ** 2  # of translation
    assert kept <= (1 + INERTIA * impact["spin_ratio"] ** 2) * (1 + 1e-9)


def test_the_bound_of_energy_is_reached():
    angle = np.radians([5.0, 20.0, 60.0])
    reached = rough_rebound(angle, (np.pi / 2 - angle) / 2, 1.0, 0.0).measured_restitution
    assert reached == pytest.approx(energy_bound(angle), rel=1e-13)


def test_wrong_arguments_are_refused():
    with pytest.raises(ValueError, match=r"angle \+ slope must be .* in \(0, 3.14159\)"):
        rough_rebound(0.1, -0.1, E, F)
    with pytest.raises(ValueError, match=r"angle must be .* got 2"):
        rough_rebound(2.0, 0.1, E, F)
    with pytest.raises(ValueError, match="slope must be"):
        measured_impulse_ratio(1.6, 0.1)
    with pytest.raises(ValueError, match="e must be"):
        normal_restitution(0.1, 1.2, 0.1)
    with pytest.raises(ValueError, match="shapes do not broadcast"):
        rough_rebound([0.1, 0.2], [0.1, 0.2, 0.3], E, F)
    assert rough_rebound([[0.1], [0.2]], [0.1, 0.2, 0.3], E, F).rolling.shape == (2, 3)
