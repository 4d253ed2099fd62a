"""Impact off the centre: momentum, energy, limits that have closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from microimpact.model.rigid_body.algebra import rigid_body_rebound
from microimpact.model.rigid_body.eccentric import JAMMING, eccentric_rebound

RADIUS = 16.5e-6
speeds = st.floats(-2.0, 2.0)
shares = st.floats(0.0, 1.0)
offsets = st.floats(-0.9, 0.9)


def kinetic(v_n, v_t, omega):
    return 0.5 * (v_n**2 + v_t**2 + 0.4 * (RADIUS * omega) ** 2)


@given(v_n=st.floats(-2.0, -0.01), v_t=speeds, spin=speeds, e=shares, friction=shares)
def test_without_offset_it_is_the_sphere(v_n, v_t, spin, e, friction):
    omega = spin / RADIUS
    sphere = rigid_body_rebound(v_n, v_t, omega, RADIUS, e, friction)
    body = eccentric_rebound(v_n, v_t, omega, RADIUS, 0.0, e, friction)
    assert body.V_n == pytest.approx(sphere.V_n, abs=1e-12)
    assert body.V_t == pytest.approx(sphere.V_t, abs=1e-12)
    assert body.Omega * RADIUS == pytest.approx(sphere.Omega * RADIUS, abs=1e-11)


@given(v_n=st.floats(-2.0, -0.01), v_t=speeds, spin=speeds, b=offsets, e=shares, f=shares)
def test_energy_is_lost_and_the_balance_closes(v_n, v_t, spin, b, e, f):
    omega = spin / RADIUS
    if v_n - b * spin >= -1e-6:
        return
    after = eccentric_rebound(v_n, v_t, omega, RADIUS, b, e, f)
    assert after.energy_loss >= -1e-12
    lost = kinetic(v_n, v_t, omega) - kinetic(after.V_n, after.V_t, after.Omega)
    assert lost == pytest.approx(after.energy_loss, abs=1e-11)
    # Friction within its cone, and the point of contact leaves the plane.
    p_n, p_t = after.V_n - v_n, after.V_t - v_t
    assert abs(p_t) <= f * p_n * (1 + 1e-12) + 1e-12
    assert after.V_n - b * RADIUS * after.Omega >= -1e-11
    # Moment of both impulses about the centre.
    turn = -(np.sqrt(1 - b**2) * p_t + b * p_n) / 0.4
    assert RADIUS * (after.Omega - omega) == pytest.approx(turn, abs=1e-10)


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_without_friction_and_spin_an_offset_only_lowers_restitution(e):
    b = np.linspace(-0.6, 0.6, 25)
    after = eccentric_rebound(-1.3, 0.8, 0.0, RADIUS, b, e, 0.0)
    closed = (1.0 + e) / (1.0 + 2.5 * b**2) - 1.0
    np.testing.assert_allclose(after.V_n / 1.3, closed, atol=1e-14)
    assert np.all(closed <= e)
    np.testing.assert_allclose(after.V_t, 0.8)


def test_energy_of_a_frictionless_elastic_impact_is_kept():
    after = eccentric_rebound(-1.0, 0.7, 3e4, RADIUS, np.linspace(-0.8, 0.8, 9), 1.0, 0.0)
    np.testing.assert_allclose(after.energy_loss, 0.0, atol=1e-15)


def test_sliding_raises_restitution_at_most_by_the_closed_form():
    # Sliding throughout: 1 + e_m = (1 + e)/(1 + (b^2 - f b h)/k), greatest near b = f/2.
    b = np.linspace(-0.3, 0.3, 61)
    f, e = 0.15, 0.7
    after = eccentric_rebound(-0.2, 2.0, 0.0, RADIUS, b, e, f)
    h = np.sqrt(1 - b**2)
    np.testing.assert_allclose(
        1 + after.V_n / 0.2, (1 + e) / (1 + (b**2 - f * b * h) / 0.4), rtol=1e-12
    )
    rise = after.V_n.max() / 0.2 - e
    assert 0.0 < rise < (1 + e) * f**2 / 1.6 * 1.05


def test_marched_impulses_agree():
    """Small steps of impulse with friction decided at each step."""
    v_n, v_t, w, b, e, f = -0.9, 0.35, -0.5, 0.35, 0.6, 0.2
    h, step = np.sqrt(1 - b**2), 2e-6
    vn, vt, spin, spent, regained = v_n, v_t, w, 0.0, 0.0
    while True:
        c_n, c_t = vn - b * spin, vt - h * spin
        drift = b * h / 0.4 / (1 + h**2 / 0.4)
        mu = -f * np.sign(c_t) if abs(c_t) > 1e-5 else float(np.clip(-drift, -f, f))
        work = -c_n * step
        if c_n < 0:
            spent += work
        else:
            regained -= work
            if regained >= e**2 * spent:
                break
        vn, vt, spin = vn + step, vt + mu * step, spin - (h * mu + b) * step / 0.4
    after = eccentric_rebound(v_n, v_t, w / RADIUS, RADIUS, b, e, f)
    assert after.V_n == pytest.approx(vn, abs=2e-5)
    assert after.V_t == pytest.approx(vt, abs=2e-5)
    assert after.Omega * RADIUS == pytest.approx(spin, abs=1e-4)


def test_wrong_input_is_refused():
    with pytest.raises(ValueError, match="must approach"):
        eccentric_rebound(-0.1, 0.0, 1e6, RADIUS, -0.5, 0.7, 0.15)
    with pytest.raises(ValueError, match="offset"):
        eccentric_rebound(-1.0, 0.0, 0.0, RADIUS, 1.0, 0.7, 0.15)
    with pytest.raises(ValueError, match="friction"):
        eccentric_rebound(-1.0, 0.0, 0.0, RADIUS, 0.1, 0.7, 1.5)


@given(b=shares, f=st.floats(0.0, 0.999 * JAMMING))
def test_below_the_friction_that_jams_the_contact_always_separates(b, f):
    after = eccentric_rebound(-1.0, np.array([-9.0, 0.1, 9.0]), 0.0, RADIUS, 0.99 * b, 0.7, f)
    assert np.all(after.energy_loss >= 0.0)
    assert np.all(np.isfinite(after.V_n))


def test_friction_jams_first_at_one_offset():
    b = np.linspace(0.001, 0.999, 99801)
    jams = (1.0 + b**2 / 0.4) / (b * np.sqrt(1.0 - b**2) / 0.4)
    assert jams.min() == pytest.approx(JAMMING, rel=1e-9)
    assert b[jams.argmin()] ** 2 == pytest.approx(2.0 / 9.0, abs=1e-4)
