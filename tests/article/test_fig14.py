"""Fig. 14: trends of R, rho and e with the impact speed."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib import rc_context

from microimpact.figures.style import save


@pytest.fixture(scope="module")
def tables(run_study):
    return run_study("restitution_trends")


@pytest.fixture(scope="module")
def curves(tables):
    table = tables["fig14"]
    return {
        name: (rows["x_m_per_s"].to_numpy(), rows["y_1"].to_numpy())
        for name, rows in table.groupby("series")
    }


def test_all_is_computed(tables):
    assert set(tables["fig14"]["evidence"]) == {"computed"}


def test_adhesion_takes_all_at_and_below_capture(curves):
    v_c = curves["capture velocity"][0][0]
    speed, rho = curves["adhesion"]
    assert v_c in speed
    assert (rho[speed <= v_c] == 1.0).all()
    assert (np.diff(rho[speed >= v_c]) < 0).all()


def test_body_restitution_falls_from_one(curves):
    _, R = curves["body restitution"]
    assert R[0] == 1.0
    assert (np.diff(R) < 0).all()


def test_overall_restitution_rises_from_zero_then_falls_with_the_body(curves):
    v_c = curves["capture velocity"][0][0]
    speed, e = curves["overall restitution"]
    assert (e[speed <= v_c] == 0.0).all()
    top = int(np.argmax(e))
    assert v_c < speed[top] < speed[-1]
    assert (np.diff(e[(speed >= v_c) & (speed <= speed[top])]) > 0).all()
    assert (np.diff(e[top:]) < 0).all()
    assert (e <= curves["body restitution"][1]).all()


def test_printed_form_without_the_clip_would_rise_again(curves):
    """The absolute value in the printed Eq. 33 would let slow spheres rebound."""
    v_c = curves["capture velocity"][0][0]
    speed, e = curves["overall restitution"]
    slow = speed < v_c
    printed = 1 - 0.6 / (0.6 + np.abs(speed[slow] - v_c))
    assert printed.max() > 0.5
    assert e[slow].max() == 0.0


def test_the_users_own_settings_of_matplotlib_change_nothing(draw, tables, tmp_path):
    def drawn():
        save(draw("fig14", tables), tmp_path / "one.svg")
        return (tmp_path / "one.svg").read_bytes()

    plain = drawn()
    with rc_context({"lines.linewidth": 9.0, "axes.grid": True, "font.size": 20.0}):
        assert drawn() == plain
