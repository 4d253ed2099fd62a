"""Neglected moments of rolling, and captured spheres that roll away."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from microimpact.studies.models.rolling_dissipation import around_least

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


@pytest.fixture(scope="module")
def away(run_study, calibration):
    return run_study("captured_rolling", calibration)


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


def test_the_small_contact_radius_does_not_make_the_bound_small(rebounds):
    """The lever arm a is 3 to 10 % of r, but friction is only f of the normal force."""
    assert rebounds["contact_radius_over_r"].between(0.02, 0.11).all()
    assert rebounds["bound_over_friction"].min() > 0.25
    assert rebounds["bound_over_friction"].max() > 5.0


def test_steady_rolling_would_matter_near_normal_incidence(rebounds):
    steep = rebounds[rebounds["angle_deg"] == 85]
    assert (steep["steady_over_friction"] > 0.2).all()
    fast = rebounds.query("diameter_um == 62 and speed_m_per_s == 1.66")
    oblique = fast[fast["angle_deg"].between(15, 50)]
    assert (oblique["steady_over_friction"] < 0.1).all()


def test_what_an_impact_can_develop_is_negligible_at_every_angle(rebounds):
    assert (rebounds["impact_over_friction"] < 0.01).all()
    assert (rebounds["damping_over_friction"] < 0.02).all()


def test_a_sphere_rolls_through_little_of_its_contact_radius(rebounds):
    assert (rebounds["rolled_over_contact_radius"] < 0.15).all()
    # roughly as far as its steady moments would have to be scaled down
    assert (rebounds["impact_over_friction"] < 0.1 * rebounds["steady_over_friction"]).all()


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


def test_around_least():
    def excess(x):
        return (x - 2.0) ** 2 - 1.5

    x = np.arange(6.0)
    low, high = around_least(excess, x, excess(x))
    assert low == pytest.approx(2.0 - np.sqrt(1.5), abs=1e-3)
    assert high == pytest.approx(2.0 + np.sqrt(1.5), abs=1e-3)
    assert around_least(excess, x[1:4], excess(x[1:4])) == (1.0, 3.0)
    assert np.isnan(around_least(excess, x[4:], excess(x[4:]))).all()


def test_drawn(draw, tables, legend_texts):
    figure = draw("rolling", tables)
    assert len(figure.axes) == 4
    assert {ax.get_yscale() for ax in figure.axes} == {"log"}
    assert {"negligible below", "computed"} <= set(legend_texts(figure))


def test_wrong_parameters_are_refused(run_study, calibration):
    with pytest.raises(
        ValueError, match=r"^rolling_dissipation.angles_deg\[1\]: 90.0 must be .* 90$"
    ):
        run_study("rolling_dissipation", calibration, angles_deg=[45.0, 90.0])
    with pytest.raises(ValueError, match="must ascend"):
        run_study("rolling_dissipation", calibration, angles_deg=[45.0, 30.0])


def test_distance_by_hand(away):
    # 62 um, n = 1, 45 deg, xi = 1 nm: (7/10) m V_t^2/(6 pi w_A xi)
    row = (
        away["roll_away"]
        .query("case == @INVERSE and diameter_um == 62 and angle_deg == 45 and shift_nm == 1")
        .iloc[0]
    )
    assert row["rolling_velocity_m_per_s"] == pytest.approx(5 / 7 * 0.18, rel=1e-6)
    mass = 8000 * np.pi / 6 * 62e-6**3
    expected = 0.7 * mass * (5 / 7 * 0.18) ** 2 / (6 * np.pi * 0.7 * 1e-9)
    assert row["distance_mm"] == pytest.approx(expected * 1e3, rel=1e-6)
    assert row["distance_with_gravity_mm"] > row["distance_mm"]


def test_captured_spheres_leave_the_target_at_shallow_angles_only(away):
    table = away["roll_away"].query("diameter_um == 62")
    weak = table[table["shift_nm"] <= 1.0]
    assert weak[weak["angle_deg"] <= 10]["leaves_target"].all()
    # of silica's lag, adhesion holds them within the spot beyond 45 deg
    silica = table[table["shift_nm"] == 3.2]
    assert not silica[silica["angle_deg"] >= 45]["leaves_spot"].any()
    assert silica[silica["angle_deg"] == 5]["leaves_target"].all()


def test_gravity_alone_rolls_a_sphere_where_adhesion_lags_little(away):
    table = away["roll_away"]
    rolls = table["gravity_over_adhesion"] > 1.0
    assert (np.isinf(table["distance_with_gravity_mm"]) == rolls).all()
    # not at 62 um from 1 nm on, in either case; but at 0.2 nm with the weaker adhesion
    middle = table[table["diameter_um"] == 62]
    assert not rolls[middle[middle["shift_nm"] >= 1.0].index].any()
    weaker = middle.query("case == @INVERSE and shift_nm == 0.2 and angle_deg <= 70")
    assert rolls[weaker.index].all()
    strong = middle[middle["case"] == CONSTANT]
    assert not rolls[strong.index].any()


def test_speeds_are_those_of_capture(away):
    table = away["roll_away"]
    normal = table["speed_m_per_s"] * np.sin(np.radians(table["angle_deg"]))
    fastest = np.minimum(
        table["capture_velocity_m_per_s"], 5.0 * np.sin(np.radians(table["angle_deg"]))
    )
    assert normal.to_numpy() == pytest.approx(fastest.to_numpy(), rel=1e-12)


def test_curves_come_down_from_infinity_where_gravity_ends(away):
    data = away["roll_away_curves"]
    curve = data.query("panel == @INVERSE and series == '45 deg'")
    assert (np.diff(curve["y_mm"]) < 0).all()
    table = away["roll_away"].query("case == @INVERSE and diameter_um == 62 and angle_deg == 45")
    at = brentq(
        lambda x: np.interp(x, table["shift_nm"], 1 / table["gravity_over_adhesion"]) - 1, 0.2, 3
    )
    assert curve["x_nm"].iloc[0] == pytest.approx(at, rel=1e-4)
    assert curve["y_mm"].iloc[0] > 1e3


def test_distances_drawn(draw, away, legend_texts):
    figure = draw("roll_away", away)
    assert [(ax.get_xscale(), ax.get_yscale()) for ax in figure.axes] == [("log", "log")] * 2
    assert {"edge of the spot", "edge of the target"} <= set(legend_texts(figure))
