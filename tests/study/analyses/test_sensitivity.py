"""Sobol' indices of the capture velocity."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from scipy.special import ndtri

from microimpact.model.dynamics.capture import capture_velocity
from study.analyses.fig24_25_doe.factors import LETTERS, at_levels
from study.analyses.sensitivity import compute as sensitivity
from study.contacts import calibrated_contact
from study.declared.parameters import build

STEEL = ["steel-silicon, n = 0", "steel-silicon, n = 1"]


@pytest.fixture(scope="module")
def levels(run_study, calibration, settings):
    sampling = {**settings.branches["fig24_25_doe"]["sampling"], "replicates": 2}
    tables = run_study("fig24_25_doe", calibration, sampling=sampling)
    return calibration | {name: tables[name] for name in ("doe_levels", "doe_effects")}


@pytest.fixture(scope="module")
def sobol(run_study, levels):
    return run_study("sensitivity", levels, samples=256, resamples=100)


def test_logarithmic_indices_are_the_shares_of_squared_effects(sobol):
    table = sobol["sensitivity_indices"]
    rows = table[(table["response"] == "ln v_c") & (table["variation"] == "uniform")]
    assert rows["first"].to_numpy() == pytest.approx(rows["effect_first"].to_numpy(), abs=0.05)
    assert rows["total"].to_numpy() == pytest.approx(rows["effect_total"].to_numpy(), abs=0.03)


def share_of_all_but_the_radius(contact, levels, quantile, n=2048, blocks=16):
    """Total index of the other factors and its error, by pairs of draws with one radius."""
    low, high = (levels[f"{end}_multiple"].to_numpy() for end in ("low", "high"))
    scores = np.random.default_rng(5).standard_normal((2, n, len(LETTERS)))
    scores[1, :, LETTERS.index("C")] = scores[0, :, LETTERS.index("C")]
    multiples = np.sqrt(low * high) * np.exp(0.5 * np.log(high / low) * scores / ndtri(quantile))
    one, other = capture_velocity(at_levels(contact, multiples))
    halves = 0.5 * (one - other) ** 2 / np.var([one, other])
    means = halves.reshape(blocks, -1).mean(axis=1)
    return float(means.mean()), float(means.std(ddof=1) / np.sqrt(blocks))


def test_what_the_radius_leaves_is_that_of_independent_draws(sobol, levels, settings):
    keys = ["case", "variation", "response", "factor"]
    indices = sobol["sensitivity_indices"].set_index(keys).sort_index()
    inputs = {**levels, "materials": pd.DataFrame(settings.tables.materials.rows)}
    by_case = levels["doe_levels"].query("variation == 'realistic'").groupby("case")
    quantile = settings.branches["sensitivity"]["level_quantile"]
    for case in STEEL:
        contact = calibrated_contact(inputs, case)
        truth, error = share_of_all_but_the_radius(contact, by_case.get_group(case), quantile)
        found = indices.loc[case, "realistic", "v_c", "C"]
        # an interval of 95 % is two standard errors to either side
        sampling = np.hypot((found["first_high"] - found["first_low"]) / 4.0, error)
        assert abs(1.0 - found["first"] - truth) < 3.0 * sampling
        assert truth - 4.0 * error > 0.2


def test_intervals_narrow(sobol):
    table = sobol["sensitivity_convergence"]
    table = table[(table["factor"] == "C") & (table["variation"] == "uniform")]
    for _, rows in table.groupby("case"):
        width = (rows["total_high"] - rows["total_low"]).to_numpy()
        assert rows["samples"].tolist() == [32, 64, 128, 256]
        assert width[-1] < 0.6 * width[0]


def test_a_case_without_levels_is_named(run_study, levels):
    table = levels["doe_levels"]
    some = {**levels, "doe_levels": table[table["case"] != STEEL[1]]}
    with pytest.raises(ValueError, match="n = 1' has no levels"):
        run_study("sensitivity", some, samples=32, resamples=20)


def test_indices_of_a_sum_are_shares_of_its_variance(settings, levels):
    params = build(sensitivity.Params, settings.branches["sensitivity"] | {"samples": 1024})
    rows = levels["doe_levels"].query("variation == 'uniform' and case == @STEEL[0]")
    points = sensitivity.sampled(params, "uniform", rows, np.random.default_rng(1))
    low, high = (rows[f"{end}_multiple"].to_numpy() for end in ("low", "high"))
    weights = np.arange(1.0, 6.0) / (high - low)
    response = (points @ weights).reshape(1024, -1)
    found = sensitivity.sobol_indices(params, response, np.random.default_rng(2))
    shares = np.arange(1.0, 6.0) ** 2 / 55.0
    for name in ("first", "total"):
        assert found[name] == pytest.approx(shares, abs=0.01)
        assert (found[f"{name}_low"] < shares).all()
        assert (shares < found[f"{name}_high"]).all()


@pytest.mark.parametrize("without", [np.nan, np.inf])
def test_base_samples_without_a_capture_velocity_are_left_out(without):
    response = np.arange(20.0).reshape(4, 5)
    response[1, 2] = without
    np.testing.assert_array_equal(sensitivity.kept(response), response[[0, 2, 3]])
    with pytest.raises(ValueError, match="1 of 2 base samples"):
        sensitivity.kept(response[:2])
