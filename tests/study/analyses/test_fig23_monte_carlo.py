"""Fig. 23: Monte Carlo analysis of impacts on a rough surface."""

from __future__ import annotations

import numpy as np
import pytest

ROUGH = ("equal weights", "facets by area seen")


@pytest.fixture(scope="module")
def tables(run_study, calibration, settings):
    branch = settings.branches["fig23_monte_carlo"]
    fewer = {"plan": {**branch["plan"], "events": 1024}}
    return run_study("fig23_monte_carlo", calibration, **fewer)


@pytest.fixture(scope="module")
def means(tables):
    return {
        name: part.set_index("angle_deg") for name, part in tables["monte_carlo"].groupby("variant")
    }


def test_subtraction_hides_what_roughness_takes_at_steep_incidence(tables, means):
    # e_m = e - (e + 5/7) phi^2 at normal incidence; the slope is of the order 0.2
    equal = means["equal weights"]
    lost = equal["smooth_restitution"][90.0] - equal["restitution"][90.0]
    slope = tables["slope_inference"].set_index("variant")["slope_sd"]["equal weights"]
    assert lost == pytest.approx((0.7 + 5 / 7) * slope**2, rel=0.15)
    assert equal["relative_restitution"][90.0] == pytest.approx(0.0, abs=0.002)


def test_errors_of_the_curves_are_below_what_can_be_seen(means):
    for name in ROUGH:
        assert means[name]["relative_restitution_error"].max() < 0.003
        assert means[name]["impulse_ratio_error"].max() < 3e-4
        shares = means[name][[c for c in means[name] if c.endswith("_share")]]
        assert shares.sum(axis=1).to_numpy() == pytest.approx(1.0)


def test_slopes_are_drawn_as_inferred(tables, means):
    found = tables["slope_inference"].set_index("variant")
    # of other random numbers, and from more events than the inference
    for name in ROUGH:
        assert means[name].loc[20.0, "restitution"] == pytest.approx(1.0, abs=0.005)
    # weighting by area, which favours facets that face the sphere, needs less roughness
    weighted = found.loc["facets by area seen", "slope_sd"]
    assert weighted < 0.8 * found.loc["equal weights", "slope_sd"]
    laboratory = found.loc["as in the virtual laboratory"]
    # 0.16 per axis in the virtual laboratory
    assert laboratory["slope_sd_low"] < 0.16 < laboratory["slope_sd_high"]
    assert laboratory["slope_sd"] > weighted
    # a program that accepts everything finds no roughness that would do
    none = found.loc["equal weights, no rule"]
    assert not none["reached"]
    assert none["largest_restitution"] < 0.85
    assert np.isnan(none["slope_sd"])


def test_declared_slopes_take_the_place_of_inferred_ones(run_study, calibration, tables, settings):
    plan = {**settings.branches["fig23_monte_carlo"]["plan"], "events": 1024}
    sd = tables["slope_inference"].set_index("variant")["slope_sd"]["equal weights"]
    slope = {"kind": "normal", "sd": float(sd)}
    declared = run_study("fig23_monte_carlo", calibration, plan=plan, process={"slope": slope})
    assert declared["slope_inference"].equals(tables["slope_inference"])
    assert set(declared["fig23"]["evidence"]) == {"computed"}
    assert "calibrated" in set(tables["fig23"]["evidence"])
    name = "variant == 'equal weights'"
    same, wider = (
        declared["monte_carlo"].query(f"variant {is_} 'equal weights'") for is_ in ("==", "!=")
    )
    assert same.equals(tables["monte_carlo"].query(name))
    assert wider["restitution"].iloc[0] > 1.2 * tables["monte_carlo"]["restitution"].iloc[21]


def test_the_smooth_surface_is_smooth_whatever_the_slopes(run_study, calibration, tables):
    slope = {"kind": "lognormal", "median": 0.1, "geometric_sd": 1.5}
    plan = {"replicates": 2, "events": 64}
    declared = run_study("fig23_monte_carlo", calibration, plan=plan, process={"slope": slope})
    smooth, same = (each["fig23"].query("series == 'smooth'") for each in (tables, declared))
    assert same["y_1"].to_numpy() == pytest.approx(smooth["y_1"].to_numpy(), rel=1e-12)
