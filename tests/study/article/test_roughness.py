"""Coefficients measured on a slope: what Section 4.1 says, and how far its equations reach."""

from __future__ import annotations

import numpy as np
import pytest

from microimpact.model.rigid_body.roughness import rough_rebound, shallow_restitution


@pytest.fixture(scope="module")
def tables(run_study):
    return run_study("roughness_expansions")


@pytest.fixture(scope="module")
def values(tables):
    return tables["roughness_expansions"]


@pytest.fixture(scope="module")
def ranges(tables):
    columns = ["equation", "form", "spin_ratio", "criterion", "variable", "fixed_deg"]
    return tables["roughness_ranges"].set_index(columns).sort_index()


def test_every_equation_stands_beside_the_exact_value(values):
    assert set(values["equation"]) == {"35", "37", "38", "39", "after 40", "41"}
    assert (values["angle_deg"] + values["slope_deg"] > 0).all()
    row = values.query("equation == '37' and angle_deg == 10 and slope_deg == 10").iloc[0]
    assert row["printed"] == pytest.approx(2.40)
    assert row["exact"] == pytest.approx(2.21, abs=5e-3)
    row = values.query("equation == '35' and angle_deg == 10 and slope_deg == 10").iloc[0]
    assert row["printed"] == pytest.approx(0.77, abs=5e-3)
    assert row["corrected"] == pytest.approx(row["exact"], rel=1e-14)


def test_corrections_bring_every_equation_nearer(values):
    small = values[values["slope_deg"].abs() <= 2.0]
    # without spin both forms of Eq. 41 are one
    small = small[(small["equation"] != "41") | (small["spin_ratio"] != 0.0)]
    for name, rows in small.groupby("equation"):
        assert (rows["corrected_error"] < rows["printed_error"]).all(), name


def test_exact_values_never_break_energy_but_equation_35_as_printed_does(values):
    e_m = values[values["quantity"] == "restitution"]
    assert e_m["exact_within_bound"].all()
    no_spin = e_m[e_m["spin_ratio"] == 0.0]
    assert (no_spin["exact"] <= no_spin["greatest_without_spin"]).all()
    printed = e_m[e_m["equation"] == "35"]
    broken = printed[~printed["printed_within_bound"].astype(bool)]
    assert (broken["slope_deg"] < 0).all()
    assert len(broken) > 0
    facing = printed[printed["slope_deg"] > 0]
    assert (facing["printed"] < 1.0).all()


def test_ends_of_ranges_are_where_the_error_is_one_per_cent(ranges):
    row = ranges.loc[("37", "printed", 0.0, "accuracy", "slope", 10.0)]
    for end in row[["low_deg", "high_deg"]]:
        slope, angle = np.radians(end), np.radians(10.0)
        exact = rough_rebound(angle, slope, 0.7, 0.15).measured_restitution
        printed = shallow_restitution(angle, slope, 0.7, -0.15, printed=True)
        assert abs(printed / exact - 1.0) == pytest.approx(0.01, rel=1e-6)
    assert not row["low_is_limit"]
    assert not row["high_is_limit"]


def test_equation_38_ends_where_the_sphere_begins_to_roll(ranges):
    row = ranges.loc[("38", "corrected", 0.0, "accuracy", "angle", 2.0)]
    local = np.degrees(np.arctan(2 / (7 * 0.15 * 1.7)))
    assert row["high_deg"] == pytest.approx(local - 2.0, abs=0.5)
