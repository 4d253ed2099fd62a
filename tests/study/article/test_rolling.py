"""Moments of rolling neglected during an impact."""

from __future__ import annotations

import numpy as np
import pytest

CONSTANT, INVERSE = "steel-silicon, n = 0", "steel-silicon, n = 1"


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


def test_sums_are_those_of_the_parts(rebounds):
    for grade in ("bound", "steady", "impact"):
        total = rebounds[f"{grade}_deformation"] + rebounds[f"{grade}_adhesion"]
        assert total.to_numpy() == pytest.approx(rebounds[f"{grade}_over_friction"].to_numpy())


def test_ranges_of_angles(tables, moments):
    ranges = tables["rolling_ranges"].set_index(["case", "diameter_um", "speed_m_per_s", "grade"])
    steady = ranges.loc[(CONSTANT, 62.0, 1.66, "steady")]
    assert steady["negligible_to_deg"] == pytest.approx(62.5, abs=0.5)
    assert not steady["to_is_limit"]
    bound = ranges.loc[(CONSTANT, 62.0, 1.66, "bound")]
    assert np.isnan(bound["negligible_from_deg"])
    impact = ranges.xs("impact", level="grade")
    assert impact["from_is_limit"].all()
    assert impact["to_is_limit"].all()
    assert (impact["negligible_to_deg"] == 85.0).all()
    assert ranges["greatest_ratio"].max() == moments["bound_over_friction"].max()
