"""Sobol' indices of the capture velocity, beside the effects of the designed experiments."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from scipy.special import ndtri

from microimpact.model.dynamics.capture import capture_velocity
from study.studies.analyses.doe.factors import LETTERS, at_levels
from study.studies.contacts import calibrated_contact

STEEL = ["steel-silicon, n = 0", "steel-silicon, n = 1"]


@pytest.fixture(scope="module")
def earlier(run_study, settings, calibration):
    sampling = {**settings.branches["doe"]["sampling"], "replicates": 2}
    found = run_study("doe", calibration, sampling=sampling)
    return calibration | {name: found[name] for name in ("doe_levels", "doe_effects")}


@pytest.fixture(scope="module")
def tables(run_study, earlier):
    small = {"samples": 256, "calibrated_samples": 64, "resamples": 100}
    return run_study("sensitivity", earlier, **small)


def test_logarithmic_indices_are_the_shares_of_squared_effects(tables):
    table = tables["sensitivity_indices"]
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


def test_the_weight_of_the_parameters_is_that_of_independent_draws(tables, earlier, settings):
    keys = ["case", "variation", "kind", "input"]
    groups = tables["sensitivity_groups"].set_index(keys).sort_index()
    inputs = {**earlier, "materials": pd.DataFrame(settings.tables.materials.rows)}
    levels = earlier["doe_levels"].query("variation == 'realistic'").groupby("case")
    quantile = settings.branches["sensitivity"]["level_quantile"]
    for case in STEEL:
        contact = calibrated_contact(inputs, case)
        truth, error = share_of_all_but_the_radius(contact, levels.get_group(case), quantile)
        found = groups.loc[case, "realistic", "group", "uncertainty"]
        # an interval of 95 % is two standard errors to either side
        sampling = np.hypot((found["total_high"] - found["total_low"]) / 4.0, error)
        assert abs(found["total"] - truth) < 3.0 * sampling
        assert truth - 4.0 * error > 0.2


def test_intervals_narrow(tables):
    table = tables["sensitivity_convergence"]
    table = table[(table["factor"] == "C") & (table["variation"] == "uniform")]
    for _, rows in table.groupby("case"):
        width = (rows["total_high"] - rows["total_low"]).to_numpy()
        assert rows["samples"].tolist() == [32, 64, 128, 256]
        assert width[-1] < 0.6 * width[0]


def test_a_case_without_levels_is_named(run_study, earlier):
    levels = earlier["doe_levels"]
    some = {**earlier, "doe_levels": levels[levels["case"] != STEEL[1]]}
    with pytest.raises(ValueError, match="n = 1' has no levels"):
        run_study("sensitivity", some, samples=32, calibrated_samples=32, resamples=20)


@pytest.mark.parametrize(
    ("name", "deviation"),
    [("restitution_deviation", 0.3), ("capture_velocity_deviation_m_per_s", 0.2)],
)
def test_draws_outside_the_admissible_are_named(run_study, earlier, name, deviation):
    small = {"samples": 32, "calibrated_samples": 32, "resamples": 20}
    with pytest.raises(ValueError, match=f"{name}: draws"):
        run_study("sensitivity", earlier, **small, **{name: deviation})
