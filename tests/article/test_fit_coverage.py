"""The capture velocity that Eq. (34) finds from data that never reach capture."""

from __future__ import annotations

import pytest

from microimpact import capture_velocity
from microimpact.core.tables import parse_table
from microimpact.declared.parameters import build
from microimpact.studies.models.fit_coverage.averaged import Averaged, true_contact

FEW = {
    "noise_of_e": [0.003, 0.01],
    "points": [20],
    "lowest_speeds_in_v_c": [1.05, 1.5],
    "replicates": 120,
    "interval_replicates": 20,
    "methods": {"replicates": 10, "resamples": 20, "lowest_speeds_in_v_c": [1.05]},
    "averaged": {"sets": 12, "lowest_speeds_in_v_c": [1.05, 3.0], "noise_of_e": [0.01]},
}
BASE = "uniform noise"


@pytest.fixture(scope="module")
def earlier(made, calibration):
    names = {"restitution_fits": "restitution_fits", "contact_laws": "contact_law_fits"}
    return calibration | {table: made(study)[table] for study, table in names.items()}


@pytest.fixture(scope="module")
def tables(run_study, earlier):
    return run_study("fit_coverage", earlier, **FEW)


@pytest.fixture(scope="module")
def cell(tables):
    names = ["truth", "variant", "noise_of_e", "exponent", "lowest_speed_in_v_c"]
    return tables["fit_coverage"].set_index(names).sort_index().loc


def test_every_cell_is_there_once(tables):
    table = tables["fit_coverage"]
    factors = ["truth", "variant", "noise_of_e", "points", "lowest_speed_in_v_c", "exponent"]
    assert not table.duplicated(factors).any()
    # 2 truths, 2 exponents and 2 lowest speeds, at 2 noises of the first variant and 1 of 5 others
    assert len(table) == 2 * 2 * 2 * (2 + 5)
    shares = table[["coverage", "coverage_sigma_estimated", "v_c_on_bound", "any_on_bound"]]
    assert shares.stack().between(0.0, 1.0).all()
    assert not table.isna().any().any()
    assert (table["rms_error"] >= table["bias"].abs()).all()


@pytest.mark.parametrize("exponent", ["free", "fixed"])
def test_a_true_model_covers(cell, exponent):
    for lowest in (1.05, 1.5):
        row = cell["Eq. 34", BASE, 0.003, exponent, lowest]
        assert row["coverage"] > 0.95 - 4 * 0.02
        assert row["reduced_chi_square"] == pytest.approx(1.0, abs=0.12)


@pytest.mark.parametrize("truth", ["Eq. 34", "simulation"])
@pytest.mark.parametrize("exponent", ["free", "fixed"])
def test_v_c_is_lost_as_the_data_move_away_from_capture(cell, truth, exponent):
    near, far = (cell[truth, BASE, 0.01, exponent, lowest] for lowest in (1.05, 1.5))
    assert far["rms_error"] > 3 * near["rms_error"]
    assert far["median_width"] > 3 * near["median_width"]


def test_a_known_exponent_is_worth_much_where_it_is_true(cell):
    free, fixed = (cell["Eq. 34", BASE, 0.01, exponent, 1.5] for exponent in ("free", "fixed"))
    assert free["rms_error"] > 2 * fixed["rms_error"]
    assert free["v_c_on_bound"] > fixed["v_c_on_bound"]


def test_the_exponent_of_the_threshold_is_not_that_of_the_simulated_curve(cell):
    # q = 1/2 holds at capture only: the fit is precise, too high, and its interval misses v_c
    row = cell["simulation", BASE, 0.003, "fixed", 1.05]
    assert row["bias"] > 0.01
    assert row["coverage"] < 0.1
    assert cell["simulation", BASE, 0.003, "free", 1.05]["bias"] < 0


def test_wrong_weights_cost_coverage(cell):
    weighted, equal = (
        cell["Eq. 34", f"velocimeter noise, {weights}", 0.01, "fixed", 1.05]
        for weights in ("weighted", "equal weights")
    )
    assert weighted["coverage"] > 0.87
    assert equal["coverage"] < 0.8


def test_spheres_of_many_sizes_that_rebound_hide_capture(cell):
    # of a wide sieve the large ones rebound below the nominal v_c
    for truth in ("Eq. 34", "simulation"):
        row = cell[truth, "wide sieve, rebounds", 0.01, "free", 1.05]
        assert row["median_error"] < -0.5
        assert row["coverage"] < 0.05


def test_every_method_is_compared_in_every_cell(tables):
    methods = tables["fit_intervals"]
    assert len(methods) == 2 * 2 * 5
    assert methods["method"].nunique() == 5
    width = methods.pivot(index=["truth", "exponent"], columns="method", values="median_width")
    assert (width["profile, boundary mixture"] < width["profile, chi-square"]).all()


def test_the_averaged_interval_holds_v_c_of_every_shape(tables):
    table = tables["averaged_intervals"].set_index(["truth", "lowest_speed_in_v_c"])
    held = table["held"].groupby("truth").sum()
    assert held.min() >= 20, "of 24; 19 or fewer are 0.6 % at 95 %"
    near, far = (table.xs(lowest, level=1) for lowest in (1.05, 3.0))
    assert (near["median_width"] < 0.1).all()
    assert (far["median_width"] > 1.5).all()
    assert (far["warned"] == 1.0).all(), "no speed is near capture"
    assert ((table["coverage_low"] < table["coverage"]) | (table["coverage"] == 0.0)).all()


def test_the_viscous_truth_is_the_law_that_was_fitted(earlier, settings):
    params = settings.branches["fit_coverage"]["averaged"]
    materials = parse_table(settings.tables.contact_rows()["materials"])
    inputs = {**earlier, "materials": materials}
    contact = true_contact(build(Averaged, params), inputs, "viscous JKR")
    fit = earlier["contact_law_fits"].query("law == 'JKR, viscous' and targets == 'with v_c'")
    numbers = fit.set_index("quantity")["value"]
    assert contact.law.viscous_time == pytest.approx(1e-9 * numbers["viscous_time_ns"])
    assert contact.work_of_adhesion == numbers["work_of_adhesion_J_per_m2"]
    assert capture_velocity(contact) == pytest.approx(numbers["capture_velocity"])


def test_other_cells_do_not_change_a_cell(run_study, earlier, tables):
    alone = {**FEW, "lowest_speeds_in_v_c": [1.5], "noise_of_e": [0.01], "averaged": {"sets": 1}}
    variants = run_study("fit_coverage", earlier, **alone)["fit_coverage"]
    table = tables["fit_coverage"]
    same = table[(table["lowest_speed_in_v_c"] == 1.5) & (table["noise_of_e"] == 0.01)]
    assert variants["rms_error"].to_numpy() == pytest.approx(same["rms_error"].to_numpy())
    assert variants["coverage"].tolist() == same["coverage"].tolist()


def test_noise_that_hides_rebounds_is_refused(run_study, earlier):
    loud = {**FEW, "noise_of_e": [5.0], "reference_noise_of_e": 5.0, "points": [8]}
    with pytest.raises(ValueError, match="noise_of_e: 5 hides too many rebounds"):
        run_study("fit_coverage", earlier, **loud, reference_points=8)


def test_a_case_without_a_fit_is_refused(run_study, earlier):
    with pytest.raises(ValueError, match="case: 'lycopodium-silicon' must be one with a fit"):
        run_study("fit_coverage", earlier, **FEW, case="lycopodium-silicon")


def test_every_coverage_has_a_bar_also_of_none_or_all(tables):
    data = tables["capture_recovery"]
    own = data[data["panel"].str.startswith("coverage") & data["y_low"].notna()]
    assert own["y_1"].isin([0.0, 1.0]).any()
    assert ((own["y_low"] <= own["y_1"]) & (own["y_1"] <= own["y_high"])).all()
    assert (own["y_high"] > own["y_low"] + 0.01).all()


def test_drawn(draw, tables, legend_texts):
    averaged = draw("averaged_coverage", tables)
    assert "ring force, $n$ = 1.5" in legend_texts(averaged)
    figure = draw("capture_recovery", tables)
    assert len(figure.axes) == 6
    texts = legend_texts(figure)
    assert "nominal coverage" in texts
    assert "virtual experiment" in texts
