"""The capture velocity that Eq. (34), and an average of models, find from data above capture."""

from __future__ import annotations

import numpy as np
import pytest

from microimpact import capture_velocity, restitution, simulate
from study.analyses.fit_coverage.compute import (
    PREDICTED,
    TRIED,
    Design,
    Params,
    Spheres,
    averaged_designs,
    fit_designs,
    measured,
    true_contact,
    true_curve,
)
from study.declared.parameters import build
from study.tables import parse_table

FEW = {"sets": 60, "lowest_speeds_in_v_c": [1.05, 1.5]}


@pytest.fixture(scope="module")
def earlier(made, calibration):
    return calibration | {"restitution_fits": made("fig15_16_restitution_fits")["restitution_fits"]}


@pytest.fixture(scope="module")
def inputs(settings, earlier):
    rows = {name: parse_table(text) for name, text in settings.rows["fit_coverage"].items()}
    return rows | earlier


@pytest.fixture(scope="module")
def branch(settings):
    return settings.branches["fit_coverage"]


@pytest.fixture(scope="module")
def tables(run_study, earlier):
    return run_study("fit_coverage", earlier, **FEW)


@pytest.fixture(scope="module")
def cell(tables):
    names = ["truth", "noise_of_e", "exponent", "lowest_speed_in_v_c"]
    return tables["fit_coverage"].set_index(names).sort_index().loc


def test_truths_are_the_curves_themselves(branch, inputs):
    params, ratio = build(Params, branch), np.array([1.05, 2.0, 10.0])
    contact = true_contact(params, inputs, "simulation")
    e = simulate(contact, ratio * capture_velocity(contact)).coefficient_of_restitution
    assert true_curve(params, inputs, "simulation", ratio) == pytest.approx(e, rel=1e-12)
    fits = inputs["restitution_fits"].query("case == @params.case and exponent == 'fixed'").iloc[0]
    k, p, kappa, q, v_c = fits[["k_m_per_s", "p", "kappa_m_per_s", "q", "v_c_m_per_s"]].astype(
        float
    )
    e = restitution(ratio * v_c, k, p, kappa, q, v_c)
    assert true_curve(params, inputs, "Eq. 34", ratio) == pytest.approx(e, rel=1e-12)


def test_laws_have_the_capture_velocity_of_steel(branch, inputs):
    params = build(Params, branch)
    for truth, law in {"viscous JKR": "jkr", "Thornton-Ning": "thornton-ning"}.items():
        contact = true_contact(params, inputs, truth)
        assert contact.law.name == law
        assert capture_velocity(contact) == pytest.approx(0.18, rel=0.03)


def test_noise_is_independent_between_designs_and_of_the_declared_size(branch, inputs):
    params = build(Params, branch)
    noise = []
    for design in fit_designs(params):
        ratio, e = measured(params, inputs, design)
        deviation = (e - true_curve(params, inputs, design.truth, ratio)) / design.noise_of_e
        noise.append(deviation[:, -6:].ravel())  # far above capture nothing is cut off
    noise = np.array(noise)
    size = noise.shape[1]
    assert noise.std(axis=1) == pytest.approx(1.0, abs=4.0 / np.sqrt(2 * size))
    off = np.corrcoef(noise) - np.eye(len(noise))
    assert np.abs(off).max() < 4.5 / np.sqrt(size)
    # and of fewer sets the first ones are the same
    few = build(Params, {**branch, "sets": 5})
    design = Design("Eq. 34", 0.03, 1.05)
    assert np.array_equal(measured(few, inputs, design)[1], measured(params, inputs, design)[1][:5])


@pytest.mark.parametrize("exponent", ["free", "fixed"])
def test_a_true_model_covers(cell, exponent):
    for lowest in (1.05, 1.5):
        row = cell["Eq. 34", 0.01, exponent, lowest]
        assert row["coverage"] > 0.95 - 4 * 0.028
        assert row["reduced_chi_square"] == pytest.approx(1.0, abs=0.15)


def test_intervals_hold_v_c_where_the_scatter_is_told_and_warn_where_it_is_not(tables):
    """Of the designs that this run computes, by 60 sets, and of the file, by 300."""
    exact, scattered = tables["averaged_intervals"].itertuples()
    assert exact.held >= 51, "of 60; 50 or fewer are 0.1 % at 95 %"
    assert scattered.held < 51
    assert scattered.missed_without_warning <= 0.1 * (60 - scattered.held)
    told = TRIED[TRIED["scatter"] != "exact"]
    assert told["coverage"].min() > 0.92
    assert abs(told["coverage"].mean() - 0.95) < 0.02
    assert (told["coverage"] < 0.985).mean() > 0.8
    others = TRIED[TRIED["scatter"] == "exact"]
    missed = (others["sets"] - others["held"]).sum()
    assert others["missed_without_warning"].sum() <= 0.1 * missed


def test_drawn_contacts_predict_other_sizes_as_often_as_they_say(tables):
    predicted = tables["capture_predictions"]
    assert sorted(set(predicted["truth"])) == ["ring force, n = 0.7", "viscous JKR"]
    assert (predicted["sets"] + predicted["without_convergence"] >= 300).all()
    assert predicted["coverage"].between(0.85, 0.96).all()
    figure = tables["averaged_coverage"].query("panel == 'at other sizes'")
    assert len(figure) == len(predicted) + 2


def test_a_run_predicts_other_sizes_itself_where_it_is_to(run_study, earlier):
    few = {"designs": ["viscous JKR, one size, taken as exact"], "predicted": 1}
    predicted = run_study("fit_coverage", earlier, **FEW | {"sets": 1}, averaged=few)
    table = predicted["capture_predictions"]
    assert list(table.columns) == list(PREDICTED.columns)
    assert (table["sets"] == 1).all()
    assert table["held"].sum() >= 4, "of 8"


def test_designs_of_the_file_are_what_the_study_computes(branch, inputs):
    """Speeds have errors, some spheres stay, and v_c of a smaller one is higher."""
    params = build(Params, {**branch, "averaged": {**branch["averaged"], "designs": "all"}})
    assert len(averaged_designs(params)) == len(TRIED)
    spheres = Spheres(size_scatter=0.07, speed_error=0.02)
    v, e = measured(params, inputs, Design("viscous JKR", 0.01, 1.05), spheres)
    assert np.std(np.log(v / np.median(v, axis=0))) == pytest.approx(0.02, rel=0.1)
    assert 0.05 < np.mean(e[:, 0] == 0.0) < 0.5
    for truth in ("Eq. 34", "Thornton-Ning", "foreign curve"):
        curve = true_curve(
            params, inputs, truth, np.array([0.99, 1.01, 1.01]), np.array([1, 1, 0.9])
        )
        assert list(curve > 0.0) == [False, True, False]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"averaged": {"designs": ["viscous"]}}, r"averaged\.designs: 'viscous' is no design"),
        ({"noise_of_e": [1.0], "points": 8}, "noise_of_e: 1 hides too many rebounds"),
        ({"case": "lycopodium-silicon"}, "case: 'lycopodium-silicon' must be one with a fit"),
    ],
)
def test_wrong_designs_are_refused(run_study, earlier, changes, message):
    with pytest.raises(ValueError, match=message):
        run_study("fit_coverage", earlier, **FEW, **changes)
