"""Fig. 23: Monte Carlo analysis of impacts on a rough surface."""

from __future__ import annotations

import numpy as np
import pytest

ROUGH = ("equal weights", "facets by area seen")


@pytest.fixture(scope="module")
def tables(run_study, calibration, settings):
    branch = settings.branches["monte_carlo"]
    fewer = {"plan": {**branch["plan"], "events": 1024}}
    return run_study("monte_carlo", calibration, **fewer)


@pytest.fixture(scope="module")
def means(tables):
    return {
        name: part.set_index("angle_deg") for name, part in tables["monte_carlo"].groupby("variant")
    }


def curve(tables, panel, series):
    table = tables["fig23"]
    rows = table[(table["panel"] == panel) & (table["series"] == series)].sort_values("x_deg")
    assert not rows.empty
    return rows


def test_rough_and_smooth_are_alike_from_45_deg_on_and_part_below(means):
    for name in ROUGH:
        apart = means[name]["relative_restitution"] - means[name]["smooth_relative_restitution"]
        assert apart.loc[45.0:].abs().max() < 0.05
        assert apart.loc[:20.0].min() > 0.3
        assert np.all(np.diff(apart.loc[:45.0]) < 0)


def test_rough_restitution_rises_to_unity_where_the_smooth_falls(tables, means):
    for name in ROUGH:
        relative = means[name]["relative_restitution"]
        assert np.all(np.diff(relative.loc[:75.0]) < 0)
        assert relative[10.0] == pytest.approx(1.1, abs=0.1)
        assert means[name]["restitution"][20.0] == pytest.approx(1.0, abs=0.01)
    smooth = curve(tables, "restitution", "smooth")
    shallow = smooth[smooth["x_deg"] < 45.0]["y_1"]
    assert np.all(np.diff(shallow) > 0)
    assert shallow.min() < -0.3


def test_subtraction_hides_what_roughness_takes_at_steep_incidence(tables, means):
    # e_m = e - (e + 5/7) phi^2 at normal incidence; the slope is of the order 0.2
    equal = means["equal weights"]
    lost = equal["smooth_restitution"][90.0] - equal["restitution"][90.0]
    slope = tables["slope_inference"].set_index("variant")["slope_sd"]["equal weights"]
    assert lost == pytest.approx((0.7 + 5 / 7) * slope**2, rel=0.15)
    assert equal["relative_restitution"][90.0] == pytest.approx(0.0, abs=0.002)


def test_impulse_ratio_of_the_smooth_surface_alone_is_constant(tables, means):
    smooth = curve(tables, "impulse_ratio", "smooth")
    plateau = smooth[smooth["x_deg"].between(7.0, 45.0)]["y_1"]
    assert plateau.to_numpy() == pytest.approx(0.15, rel=1e-9)
    for name in ROUGH:
        ratio = means[name]["impulse_ratio"]
        # never constant: it falls all the way, by more than 0.002 per degree up to 45 deg
        steps = np.diff(ratio) / np.diff(ratio.index)
        assert steps.max() < -1e-3
        assert steps[ratio.index[1:] <= 45.0].max() < -0.002
        assert ratio[10.0] > 0.28
        assert ratio[90.0] == pytest.approx(0.0, abs=1e-3)


def test_errors_of_the_curves_are_below_what_can_be_seen(means):
    for name in ROUGH:
        assert means[name]["relative_restitution_error"].max() < 0.003
        assert means[name]["impulse_ratio_error"].max() < 3e-4
        shares = means[name][[c for c in means[name] if c.endswith("_share")]]
        assert shares.sum(axis=1).to_numpy() == pytest.approx(1.0)


def test_the_slope_alone_explains_the_departure(tables):
    table = tables["monte_carlo_ablation"]
    e = table[table["quantity"] == "restitution"].set_index("source")
    assert e.loc["slope", "share"].between(0.98, 1.02).all()
    for source in ("diameter_um", "speed_m_per_s", "spin_ratio"):
        assert e.loc[source, "share"].abs().max() < 0.02
    assert (e.loc["diameter_um", "estimate"] < e.loc["diameter_um", "smooth"]).all()


def test_slopes_are_drawn_as_inferred(tables, means):
    found = tables["slope_inference"].set_index("variant")
    # of other random numbers, and from more events than the inference
    for name in ROUGH:
        assert means[name].loc[20.0, "restitution"] == pytest.approx(1.0, abs=0.005)
    # weighting by area, which favours facets that face the sphere, needs less roughness
    weighted = found.loc["facets by area seen", "slope_sd"]
    assert weighted < 0.8 * found.loc["equal weights", "slope_sd"]
    laboratory = found.loc["as in the virtual laboratory"]
    assert laboratory["laboratory_within"]
    assert laboratory["slope_sd"] > weighted
    # a program that accepts everything finds no roughness that would do
    none = found.loc["equal weights, no rule"]
    assert not none["reached"]
    assert none["largest_restitution"] < 0.85
    assert np.isnan(none["slope_sd"])


def test_quasi_random_draws_are_worth_many_plain_ones(tables):
    table = tables["monte_carlo_sampling"].set_index(["method", "generator", "quantity"])
    table = table.sort_index()
    assert table.loc[("quasi_random", "exact"), "variance_ratio_high"].max() < 0.02
    plain = table.loc[("plain", "exact", "restitution")]
    for key in (("quasi_random", "exact"), ("plain", "central_limit")):
        other = table.loc[(*key, "restitution")]
        error = np.hypot(plain["standard_error"], other["standard_error"])
        assert abs(plain["estimate"] - other["estimate"]) < 4 * error


@pytest.fixture(scope="module", params=[20.0, 80.0])
def antithetic(request, run_study, calibration, settings):
    """Angle, and variance ratios of antithetic draws by quantity, within a factor of 1.3."""
    branch = settings.branches["monte_carlo"]
    few = {**branch["plan"], "replicates": 2, "events": 64}
    table = run_study(
        "monte_carlo",
        calibration,
        plan=few,
        variants=dict.fromkeys(list(branch["variants"])[1:]),
        points=10,
        comparison={"angle_deg": request.param, "replicates": 256, "events": 256},
        slope_inference={**branch["slope_inference"], "plan": {**few, "events": 256}},
    )["monte_carlo_sampling"]
    return request.param, table[table["method"] == "antithetic"].set_index("quantity")


def test_antithetic_draws_help_what_is_odd_in_the_slope(antithetic):
    """Nearly upright, -mu is odd in the slope: the halves of a pair make up for each other.

    Restitution is even in it, and gains nothing; nor does either where a rule drops events.
    """
    angle, ratio = antithetic
    low, high = ratio["variance_ratio_low"], ratio["variance_ratio_high"]
    assert low["restitution"] < 1.0 < high["restitution"]
    if angle == 80.0:
        assert high["impulse_ratio"] < 0.01
    else:
        assert low["impulse_ratio"] < 1.0 < high["impulse_ratio"] < 1.3


def test_the_whole_study_runs_on_the_simulation(run_study, calibration, settings):
    branch = settings.branches["monte_carlo"]
    small = {"replicates": 2, "events": 64}
    found = run_study(
        "monte_carlo",
        calibration,
        model="simulation",
        plan={**branch["plan"], **small},
        comparison={**branch["comparison"], **small},
        slope_inference={
            **branch["slope_inference"],
            "restitution_half_width": 0.0,
            "plan": {**branch["plan"], **small},
        },
        variants=dict.fromkeys(list(branch["variants"])[1:]),
        points=10,
    )
    relative = found["monte_carlo"].set_index("angle_deg")["relative_restitution"]
    assert relative[20.0] > 0.1
