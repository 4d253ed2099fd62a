"""Fit of Eq. (34) and the uncertainty of v_c."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from tests.shared import execute

from microimpact import bootstrap_v_c, fit_restitution, restitution, simulate
from microimpact.model.empirical.data import data_sets
from microimpact.model.empirical.search import fit_batch, model, profile

TRUE = {"k": 30.0, "p": 1.2, "kappa": 0.15, "q": 0.5, "v_c": 0.4}
VALUES = np.array(list(TRUE.values()))
V = np.geomspace(0.44, 8.0, 20)
E = restitution(V, **TRUE)


def noisy(number, sigma=0.01):
    return E + sigma * np.random.default_rng([20, number]).standard_normal(E.shape)


def chi_square_at(sets, v_c):
    """Least chi-square of each data set with v_c held, from two starts that no fit has."""
    return profile(sets, np.zeros(1, int), 1.0 - v_c / sets.unit, fresh=2).value


@pytest.fixture(scope="module")
def fit():
    """One noisy fit with q fixed."""
    return fit_restitution(V, noisy(0), 0.01, 0.5)


@pytest.mark.parametrize("q", [None, 0.5])
@pytest.mark.parametrize("sigma", [None, 0.01])
def test_exact_data_give_the_parameters_back(q, sigma):
    found = fit_restitution(V, E, sigma, q)
    np.testing.assert_allclose(found.parameters, VALUES, rtol=1e-6)
    assert found.v_c == pytest.approx(0.4, abs=1e-6)
    assert found.converged
    assert found.on_bound == ()
    assert found.starts_agreeing == found.starts
    assert found.q_fixed == (q is not None)
    assert found.degrees_of_freedom == (15 if q is None else 16)
    assert found.v_c_interval[0] <= found.v_c <= found.v_c_interval[1]
    np.testing.assert_allclose(found.residuals, 0.0, atol=1e-8)
    np.testing.assert_allclose(found.curve(V), found.e - found.residuals, atol=1e-12)


@pytest.mark.parametrize(
    "true",
    [
        (5.0, 2.0, 0.8, 1.5, 0.05),
        (300.0, 0.6, 0.02, 0.4, 1.47),
        (20.0, 1.0, 0.5, 1.0, 0.18),
        (60.0, 0.5, 1.0, 0.7, 0.0002),
    ],
)
def test_exact_data_of_other_curves(true):
    v = np.geomspace(1.05 * true[-1] + 0.01, 20 * true[-1] + 5, 24)
    found = fit_restitution(v, restitution(v, *true))
    np.testing.assert_allclose(found.parameters, true, rtol=1e-5)


def test_slopes_match_differences():
    logs = np.log([30.0, 1.2, 0.15, 0.6])
    x = np.append(logs, np.log(0.05))
    v = np.array([0.2, 0.44, 0.46, 1.0, 8.0])

    def curve(x):
        return model(v, x[:4], 0.44, np.exp(x[4]))[0]

    slopes = model(v, logs, 0.44, 0.05)[1]
    for column, step in enumerate(1e-6 * np.eye(5)):
        difference = (curve(x + step) - curve(x - step)) / 2e-6
        np.testing.assert_allclose(slopes[:, column], difference, atol=1e-9)
    np.testing.assert_allclose(curve(x), restitution(v, *np.exp(logs), 0.39), rtol=1e-12)


@pytest.mark.parametrize("seed", [70, 121, 240, 322, 527, 633, 637, 669, 844, 1215])
def test_an_overlooked_minimum_ends_in_an_interval(seed):
    """No curve at all, and a small sigma: on the way the profile meets a lower minimum."""
    random = np.random.default_rng(seed)
    v, e = np.exp(random.uniform(-2.0, 2.0, 15)), random.uniform(0.0, 1.0, 15)
    found = fit_restitution(v, e, 1e-5)
    low, high = found.v_c_interval
    assert 0.0 <= low <= found.v_c * (1.0 + 1e-9)
    assert found.v_c * (1.0 - 1e-9) <= high <= v.min()


@pytest.mark.parametrize("number", range(4))
@pytest.mark.parametrize("q", [None, 0.5])
def test_noisy_data_give_the_truth_within_errors(number, q):
    found = fit_restitution(V, noisy(number), 0.01, q)
    free = [name for name in TRUE if not (name == "q" and q)]
    for name in set(free) - {"k", "p"}:
        assert abs(getattr(found, name) - TRUE[name]) < 4.0 * found.standard_errors[name]
    assert 0.2 < found.reduced_chi_square < 2.5
    assert found.r_squared > 0.98
    assert found.v_c_interval[0] < 0.4 < found.v_c_interval[1]


def test_standard_errors_match_the_scatter_of_many_fits():
    sigma = 0.002
    e = np.stack([noisy(i, sigma) for i in range(200)])
    sample = fit_batch(data_sets(V, e, 1.0 / sigma, 0.5)).parameters[:, [0, 1, 2, 4]]
    exact = fit_restitution(V, E, sigma, 0.5)
    expected = exact.standard_errors
    scatter = dict(zip(("k", "p", "kappa", "v_c"), sample.std(axis=0, ddof=1), strict=True))
    for name, value in scatter.items():
        assert value == pytest.approx(expected[name], rel=0.2), name
    free = np.array(list(expected.values())) > 0.0
    cov = exact.cov[np.ix_(free, free)]
    spread = np.sqrt(np.diag(cov))
    np.testing.assert_allclose(np.corrcoef(sample.T), cov / np.outer(spread, spread), atol=0.15)
    # The fit whose errors are compared is the estimator that was sampled.
    assert fit_restitution(V, noisy(0, sigma), sigma, 0.5).v_c == pytest.approx(sample[0, 3])


@pytest.mark.parametrize(
    ("sigma", "confidence", "quantile"),
    [(0.01, 0.95, 3.841459), (0.01, 0.99, 6.634897), (None, 0.95, 4.493998)],
)
def test_profile_interval_ends_where_chi_square_has_risen_by_the_quantile(
    fit, sigma, confidence, quantile
):
    # Chi-square with 1 degree of freedom; F with 1 and 16.
    found = fit_restitution(V, fit.e, sigma, 0.5, confidence=confidence)
    sets = data_sets(V, fit.e, 1.0 / found.sigma, 0.5)
    for end in found.v_c_interval:
        rise = chi_square_at(sets, end)[0] - found.chi_square
        assert rise == pytest.approx(quantile, rel=1e-4)
    assert found.v_c_interval_limited == (False, False)


def test_data_far_above_capture_leave_the_interval_open():
    v = np.linspace(4.0, 8.0, 12)
    e = restitution(v, **TRUE) + 0.01 * np.random.default_rng(4).standard_normal(12)
    found = fit_restitution(v, e, 0.01)
    assert found.v_c_interval[0] == 0.0
    assert found.v_c_interval[1] == 4.0
    assert found.v_c_interval_limited == (True, True)
    assert str(found).count("end of range") == 2


def test_bounds_that_were_hit_are_reported():
    never = fit_restitution(V, restitution(V, 30.0, 1.2, 0.15, 1.0, 0.0), 0.01, 1.6)
    assert never.v_c == 0.0
    assert fit_batch(data_sets(V, never.e, 100.0, 1.6)).capture_on_bound[0]
    assert "v_c" in never.on_bound
    assert never.v_c_interval[0] == 0.0
    assert never.v_c_interval_limited[0]
    assert np.isnan(never.standard_errors["v_c"])
    assert "on a bound" in str(never)
    cliff = fit_restitution(V, np.where(V < 2.0, E, 0.001), 0.01, 0.5)
    assert cliff.on_bound == ("p",)
    assert np.isnan(cliff.standard_errors["p"])
    assert np.isfinite(cliff.standard_errors["v_c"])


def test_parameters_the_data_leave_open_get_huge_errors():
    # No fall at high speed: neither k nor p can be told, v_c and kappa can.
    found = fit_restitution(V, restitution(V, 1e12, 1.2, 0.15, 0.5, 0.4), 0.01, 0.5)
    assert found.v_c == pytest.approx(0.4, abs=1e-4)
    assert found.standard_errors["p"] > 100.0
    assert found.standard_errors["v_c"] < 0.02
    words = {
        line.split(" = ")[0].strip(): line.partition("m/s")[2] for line in str(found).splitlines()
    }
    assert words["k"].strip() == "not determined by the data"
    assert words["kappa"].strip().startswith("+- ")


def test_captured_points_push_v_c_up():
    keep = V > 0.6
    far = fit_restitution(V[keep], noisy(1)[keep], 0.01, 0.5)
    v = np.concatenate([[0.1, 0.3, 0.39], V[keep]])
    e = np.concatenate([[0.0, 0.0, 0.0], noisy(1)[keep]])
    held = fit_restitution(v, e, 0.01, 0.5)
    assert held.v_c_interval[0] >= 0.38
    assert far.v_c_interval[0] < held.v_c_interval[0]
    exact = fit_restitution(v, restitution(v, **TRUE))
    np.testing.assert_allclose(exact.parameters, VALUES, rtol=1e-5)
    # Captured points that cannot miss tell nothing about sigma.
    assert exact.degrees_of_freedom == keep.sum() - 5
    np.testing.assert_array_equal(exact.residuals[:3], 0.0)


def test_v_c_resting_on_a_captured_speed_is_reported():
    # A slow sphere was caught that should not have been: the bend at its speed is the minimum.
    v, e = np.append(V, 0.425), np.append(noisy(2), 0.0)
    found = fit_restitution(v, e, 0.01, 0.5)
    assert found.v_c == pytest.approx(0.425, rel=1e-8)
    assert found.on_bound == ("v_c",)
    sets = data_sets(v, e, 100.0, 0.5)
    near = (0.42, 0.424, 0.425, 0.426, 0.43)
    around = [chi_square_at(sets, v_c)[0] for v_c in near]
    assert np.argmin(around) == 2


def test_captured_spheres_cannot_miss_below_v_c():
    """The printed form, without the clip, rises again below v_c, to e > 0 of captured spheres."""
    v = np.concatenate([[0.2, 0.3], V[V > 0.6]])
    found = fit_restitution(v, restitution(v, **TRUE), 0.01, 0.5)
    assert found.v_c == pytest.approx(0.4, abs=1e-6)
    assert found.chi_square < 1e-9
    k, p, kappa, q, v_c = VALUES
    mirrored = restitution(2.0 * v_c - v[:2], k, p, kappa, q, v_c)
    assert np.all(mirrored > 0.3)


def test_scaling_laws(fit):
    faster = fit_restitution(1e3 * V, fit.e, 0.01, 0.5)
    units = np.array([1e3, 1.0, 1e3, 1.0, 1e3])
    np.testing.assert_allclose(faster.parameters, units * fit.parameters, rtol=1e-6)
    np.testing.assert_allclose(faster.v_c_interval, np.multiply(1e3, fit.v_c_interval), rtol=1e-6)
    np.testing.assert_allclose(faster.cov, np.outer(units, units) * fit.cov, rtol=1e-4)
    rougher = fit_restitution(V, fit.e, 0.03, 0.5)
    np.testing.assert_allclose(rougher.parameters, fit.parameters, rtol=1e-6)
    for name, error in rougher.standard_errors.items():
        assert error == pytest.approx(3.0 * fit.standard_errors[name], rel=1e-4)
    assert rougher.chi_square == pytest.approx(fit.chi_square / 9.0)


@pytest.mark.parametrize("sigma", [1e-6, 1e6])
def test_common_sigma_does_not_move_the_minimum(fit, sigma):
    found = fit_restitution(V, fit.e, sigma, 0.5)
    np.testing.assert_allclose(found.parameters, fit.parameters, rtol=1e-7)


def test_estimated_sigma_is_the_scatter_of_the_residuals(fit):
    found = fit_restitution(V, fit.e, None, 0.5)
    s = np.sqrt(np.sum(np.square(found.residuals)) / 16)
    np.testing.assert_allclose(found.sigma, s)
    assert found.sigma_estimated
    assert found.reduced_chi_square == pytest.approx(1.0)
    np.testing.assert_allclose(found.cov, fit.cov * (s / 0.01) ** 2, rtol=1e-3, atol=1e-12)


def test_order_of_the_data_does_not_matter(fit):
    order = np.random.default_rng(1).permutation(V.size)
    found = fit_restitution(V[order], fit.e[order], np.full(V.size, 0.01), 0.5)
    np.testing.assert_allclose(found.parameters, fit.parameters, rtol=1e-6)
    np.testing.assert_allclose(found.residuals, fit.residuals[order], atol=1e-7)
    np.testing.assert_allclose(found.v_c_interval, fit.v_c_interval, rtol=1e-5)


def test_weights_count(fit):
    e, sigma = fit.e.copy(), np.full(V.size, 0.01)
    e[5] += 0.3
    sigma[5] = 1e4
    spoiled = fit_restitution(V, e, sigma, 0.5)
    without = fit_restitution(np.delete(V, 5), np.delete(fit.e, 5), 0.01, 0.5)
    np.testing.assert_allclose(spoiled.parameters, without.parameters, rtol=1e-5)


def test_bootstrap(fit):
    sample = bootstrap_v_c(fit, 60, 7)
    assert sample.sample.shape == (60,)
    assert sample.on_bound == 0
    assert sample.sample.std() == pytest.approx(fit.standard_errors["v_c"], rel=0.4)
    low, high = sample.interval
    assert low < fit.v_c < high
    assert high - low == pytest.approx(np.diff(fit.v_c_interval)[0], rel=0.4)
    text = str(sample)
    for number in (np.median(sample.sample), low, high):
        assert f"{number:.6g}" in text
    for words in ("60 replicates", "95 %", "0 with v_c on a bound"):
        assert words in text
    assert sample.summary() == text
    assert len(repr(sample)) < 150
    again = bootstrap_v_c(fit, 5, 7)
    np.testing.assert_array_equal(again.sample, sample.sample[:5])
    other = bootstrap_v_c(fit, 5, 7, spawn_key=(1,))
    assert not np.isin(other.sample, sample.sample).any()


def test_bootstrap_counts_bounds():
    never = fit_restitution(V, restitution(V, 30.0, 1.2, 0.15, 1.0, 0.0), 0.01, 1.6)
    assert bootstrap_v_c(never, 5, 0).on_bound >= 3


def test_summary_holds_the_numbers(fit):
    text = str(fit)
    assert text == fit.summary()
    for name, value in zip(TRUE, fit.parameters, strict=True):
        assert f"{name:5s} = {value:.6g}" in text
    for number in (*fit.v_c_interval, fit.r_squared):
        assert f"{number:.6g}" in text
    for words in ("fixed", "95 %", "16 degrees of freedom", "20 points", "converged", "(given)"):
        assert words in text
    assert f"+- {fit.standard_errors['kappa']:.2g}" in text
    assert "suppose that Eq. (34), with this q if fixed, is the true curve" in text


def test_a_curve_that_does_not_hold_is_told():
    off = fit_restitution(V, E, 0.003, 2.0)
    assert off.reduced_chi_square > 2.0
    assert "chi-square is too large for sigma: the curve does not hold" in str(off)
    assert "too large" not in str(fit_restitution(V, E, None, 2.0))


def test_simulated_curves_give_v_c_within_the_stated_bias(steel, silicon):
    """Steel on silicon, 62 um, captured below 0.17897 m/s; speeds from 1.1 to 10 times that."""
    from microimpact import Contact

    contact = Contact(
        particle=steel,
        surface=silicon,
        diameter=62e-6,
        work_of_adhesion=3.46,
        adhesion_damping=1.418,
    )
    v = 0.17897 * np.geomspace(1.1, 10.0, 25)
    e = simulate(contact, v).coefficient_of_restitution
    free, half = fit_restitution(v, e), fit_restitution(v, e, q=0.5)
    assert free.v_c / 0.17897 == pytest.approx(0.970, abs=0.002)
    assert half.v_c / 0.17897 == pytest.approx(1.046, abs=0.002)
    assert half.sigma[0] > 10.0 * free.sigma[0]
    # The intervals know nothing of the model's own error.
    assert free.v_c_interval[1] < 0.17897 < half.v_c_interval[0]


GOOD = {"v": V, "e": E, "sigma": 0.01, "q": 0.5}


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"v": V[:4], "e": E[:4]}, ValueError, "v must hold at least 5 points .* got 4"),
        ({"v": V[:5], "e": E[:5], "q": None}, ValueError, "at least 6 points .* got 5"),
        ({"v": np.repeat(V[:3], 4), "e": np.repeat(E[:3], 4)}, ValueError, "4 different speeds"),
        ({"e": 0.0 * V}, ValueError, "no sphere rebounds"),
        ({"v": -V}, ValueError, "v must be finite and in"),
        ({"v": np.where(V > 1.0, np.nan, V)}, ValueError, "v must be .* got nan at index"),
        ({"e": -E}, ValueError, "e must be finite and in \\[0, 1.2\\]"),
        ({"e": 3.0 * E}, ValueError, "e must be .* in \\[0, 1.2\\]"),
        ({"e": np.where(V > 1.0, np.inf, E)}, ValueError, "e must be .* got inf"),
        ({"e": E[1:]}, ValueError, "v and e must be of one shape"),
        ({"v": V[:, None], "e": E[:, None]}, ValueError, "one shape \\(n,\\)"),
        ({"sigma": 0.0}, ValueError, "sigma must be finite and in .*, got 0"),
        ({"sigma": [0.1, 0.2]}, ValueError, "sigma must be one number or of shape \\(20,\\)"),
        ({"q": 0.0}, ValueError, "q must be finite and > 0"),
        ({"q": [0.5, 0.6]}, TypeError, "q must be one real number"),
        ({"q": "free"}, TypeError, "q must be a real number"),
        ({"v": "fast"}, TypeError, "v must be a real number"),
        ({"e": None}, TypeError, "e must be a real number"),
        ({"sigma": "small"}, TypeError, "sigma must be a real number"),
        ({"confidence": 1.0}, ValueError, "confidence must be finite and in \\(0, 1\\)"),
    ],
)
def test_bad_arguments_are_named(changes, error, message):
    with pytest.raises(error, match=message):
        fit_restitution(**(GOOD | changes))


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ((0, 1), ValueError, "replicates must be at least 1, got 0"),
        ((2.0, 1), TypeError, "replicates must be a whole number"),
        ((2, -1), ValueError, "seed must be at least 0"),
        ((2, True), TypeError, "seed must be a whole number"),
    ],
)
def test_bad_arguments_of_the_bootstrap_are_named(fit, arguments, error, message):
    with pytest.raises(error, match=message):
        bootstrap_v_c(fit, *arguments)
    with pytest.raises(TypeError, match="fit must be a RestitutionFit"):
        bootstrap_v_c(None, 2, 1)


def test_optimisers_load_only_when_a_fit_is_made():
    code = "import sys, microimpact.model.empirical.fit; sys.exit('scipy' in sys.modules)"
    execute(sys.executable, "-c", code)


def test_interval_ends_in_the_lowest_valley_of_the_profile():
    # On the way to the upper end the search follows a valley at the bound of p; another is lower.
    v = [0.2786, 0.2285, 0.2094, 0.3725, 0.6512, 0.8251, 1.1572, 1.4372, 1.4584, 1.6697]
    v += [1.9192, 2.0821, 2.6778, 2.708, 3.3865, 3.6203, 3.7482, 3.9564, 8.0201]
    e = [0.0, 0.0, 0.0, 0.4423, 0.5818, 0.6803, 0.7008, 0.6906, 0.7262, 0.7057]
    e += [0.7926, 0.761, 0.8107, 0.7391, 0.8503, 0.7821, 0.8443, 0.827, 0.7428]
    # The end by a search of its own, with SciPy.
    assert fit_restitution(v, e, q=0.5).v_c_interval[1] == pytest.approx(0.316842, abs=1e-6)
