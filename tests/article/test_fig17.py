"""Fig. 17: impulse ratio against angle for Coulomb friction, rigid body model."""

from __future__ import annotations

import numpy as np
import pytest

E = 0.70  # Section 2.4.1
F = 0.15  # Section 2.4.1


@pytest.fixture(scope="module")
def tables(run_study):
    return run_study("coulomb_friction")


@pytest.fixture(scope="module")
def curve(tables):
    table = tables["fig17"]

    def get(panel, series):
        rows = table[(table["panel"] == panel) & (table["series"] == series)]
        return rows["x_deg"].to_numpy(), rows["y_1"].to_numpy()

    return get


def test_sliding_plateau_and_rolling_branch(curve):
    angle, ratio = curve("friction", "0.15")
    end = np.degrees(np.arctan(2 / (7 * F * (1 + E))))  # cot(alpha) = 7 f (1 + e) / 2
    np.testing.assert_allclose(ratio[angle < end], F, rtol=1e-12)
    rolling = 2 / (7 * (1 + E)) / np.tan(np.radians(angle))
    np.testing.assert_allclose(ratio[angle > end], rolling[angle > end], rtol=1e-9, atol=1e-15)
    # The article: from rolling to sliding near 50 deg, where +-10 % is meant by "near".
    assert end == pytest.approx(50, rel=0.1)


@pytest.mark.parametrize("friction", ["0.05", "0.1", "0.15", "0.2"])
def test_without_spin_no_impulse_at_normal_incidence(curve, friction):
    angle, ratio = curve("friction", friction)
    assert angle[-1] == 90.0
    assert ratio[-1] == 0.0
    assert (np.diff(ratio) <= 1e-15).all()
    assert ratio[0] == pytest.approx(float(friction))


def test_the_printed_point_is_an_anchor(tables):
    table = tables["fig17"]
    (point,) = table[table["evidence"] == "printed"].to_dict("records")
    assert (point["x_deg"], point["y_1"]) == (90.0, 0.0)


@pytest.mark.parametrize("spin", [-0.4, -0.2, 0.2, 0.4])
def test_spin_displaces_normal_incidence_by_eq_12(curve, spin):
    _, ratio = curve("spin", f"{spin:g}")
    assert ratio[-1] == pytest.approx(-2 * spin / (7 * (1 + E)), rel=1e-12)


def test_no_ratio_exceeds_the_friction_coefficient(tables):
    spin = tables["fig17"].query("panel == 'spin'")
    assert spin["y_1"].abs().max() == pytest.approx(F)


def test_forward_spin_ends_sliding_earlier(curve):
    ends = []
    for spin in ("-0.4", "-0.2", "0", "0.2", "0.4"):
        angle, ratio = curve("spin", spin)
        ends.append(angle[ratio >= F * (1 - 1e-12)].max())
    assert ends == sorted(ends, reverse=True)
    assert len(set(ends)) == len(ends)
