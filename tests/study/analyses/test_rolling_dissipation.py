"""Moments of rolling neglected during an impact."""

from __future__ import annotations

import numpy as np
import pytest

from study.tables import NotComputedError

CONSTANT = "steel-silicon, n = 0"


@pytest.fixture(scope="module")
def tables(made):
    return made("rolling_dissipation")


@pytest.fixture(scope="module")
def moments(tables):
    return tables["rolling_dissipation"]


@pytest.fixture(scope="module")
def rebounds(moments):
    return moments[~moments["captured"].astype(bool)]


def test_every_impact_has_a_row_and_captured_ones_are_empty(moments, settings):
    branch = settings.branches["rolling_dissipation"]
    count = len(branch["diameters_um"]) * len(branch["speeds_m_per_s"]) * len(branch["angles_deg"])
    assert len(moments) == 2 * count
    captured = moments[moments["captured"].astype(bool)]
    assert captured["impact_over_friction"].isna().all()
    # 0.18 m/s at 62 um, by calibration
    slow = moments.query("diameter_um == 62 and speed_m_per_s == 0.2")
    normal_speed = 0.2 * np.sin(np.radians(slow["angle_deg"]))
    assert (slow["captured"].astype(bool) == (normal_speed < 0.18)).all()
    filled = moments[~moments["captured"].astype(bool)].drop(columns=["case"])
    assert filled.notna().all(axis=None)


def test_moment_of_friction_vanishes_towards_normal_incidence(rebounds):
    rolling = rebounds[rebounds["angle_deg"] >= 70]
    share = 2 / 7 * np.cos(np.radians(rolling["angle_deg"]))
    assert rolling["friction_over_r_m_v"].to_numpy() == pytest.approx(share.to_numpy(), rel=1e-9)


def test_within_an_impact_every_moment_is_negligible_and_the_bound_never_is(rebounds):
    assert (rebounds[["impact_over_friction", "damping_over_friction"]] < 0.1).all(axis=None)
    of_steel = rebounds.query("case == @CONSTANT and diameter_um == 62 and speed_m_per_s == 1.66")
    assert (of_steel["bound_over_friction"] > 0.1).all()


def test_a_case_of_another_law_costs_one_row(run_study):
    few = {"rate_exponents": [0.0, 1.0], "works_of_adhesion_J_per_m2": [0.7, 3.5]}
    members = {"steel-silicon, n = 1": {"law": "jkr"}}
    calibration = run_study("calibration", two_stage={**few, "members": members})
    tables = run_study("rolling_dissipation", calibration, points=5)
    cases = tables["rolling_dissipation"].groupby("case").size()
    assert cases["steel-silicon, n = 1"] == 1 < cases[CONSTANT]
    assert np.isfinite(tables["rolling"]["y_1"]).all()
    with pytest.raises(NotComputedError, match="contact must have the law 'ring force' here"):
        run_study("rolling_dissipation", calibration, cases=list(members))
