"""The search of Eq. (34) in many data sets, its compiled kernel, and the profile of v_c."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy.optimize import least_squares

from microimpact import fit_restitution, restitution
from microimpact.model.empirical.data import data_sets
from microimpact.model.empirical.intervals import interval_batch
from microimpact.model.empirical.kernel import V_C
from microimpact.model.empirical.search import Box, fit_batch, lowest, profile, squares

TRUE = {"k": 60.0, "p": 1.0, "kappa": 0.4, "q": 0.5, "v_c": 1.0}
CHI_SQUARE_95 = 3.841459


def measured(lowest, sigma, replicates, points=20):
    v = np.geomspace(lowest, 15.0, points)
    noise = np.random.default_rng([7, points]).standard_normal((replicates, points))
    return v, np.maximum(restitution(v, **TRUE) + sigma * noise, 0.0)


def chi_square_at(sets, v_c):
    """Least chi-square of each data set with v_c held, from two starts that no fit has."""
    count = len(sets.unit)
    return profile(sets, np.arange(count), 1.0 - v_c / sets.unit, fresh=2).value


def witness(v, e, sigma, q, held=None):
    """Least chi-square and its k, p, kappa, q, v_c by SciPy, from a net of starts.

    Another algorithm in other variables: v_c itself, the slopes by differences.
    """
    slowest = v[e > 0.0].min()

    def natural(x):
        k, p, kappa = np.exp(x[:3])
        rest = list(x[3:])
        exponent = np.exp(rest.pop(0)) if q is None else q
        return k, p, kappa, exponent, held if held is not None else rest[0]

    def misfit(x):
        return (restitution(v, *natural(x)) - e) / sigma

    logs = [np.log([k, 1.0, kappa]) for k, kappa in product((10.0, 100.0), (0.1, 1.0))]
    exponents = [[]] if q is not None else [[np.log(0.5)], [0.0]]
    captures = [[]] if held is not None else [[0.5 * slowest], [0.95 * slowest]]
    best = None
    for parts in product(logs, exponents, captures):
        start = np.concatenate(parts)
        low, high = np.full(start.size, np.log(1e-6)), np.full(start.size, np.log(1e8))
        low[1], high[1] = np.log([0.02, 20.0])
        if q is None:
            low[3], high[3] = np.log([0.02, 20.0])
        if held is None:
            low[-1], high[-1] = 0.0, slowest
        end = {"ftol": 1e-14, "xtol": 1e-14, "gtol": 1e-14, "max_nfev": 2000}
        found = least_squares(misfit, start, "3-point", (low, high), x_scale="jac", **end)
        if best is None or found.cost < best.cost:
            best = found
    return 2.0 * best.cost, np.array(natural(best.x))


@pytest.mark.parametrize("q", [None, 0.5])
@pytest.mark.parametrize(("lowest", "sigma"), [(1.05, 0.01), (1.2, 0.003), (1.5, 0.01)])
def test_search_finds_the_minimum_that_scipy_finds(lowest, sigma, q):
    v, e = measured(lowest, sigma, 2)
    sets = data_sets(v, e, 1.0 / sigma, q)
    fits = fit_batch(sets)
    for i in range(2):
        chi_square, parameters = witness(v, e[i], sigma, q)
        single = fit_restitution(v, e[i], sigma, q)
        assert single.chi_square == pytest.approx(chi_square, rel=1e-9)
        assert fits.chi_square[i] == pytest.approx(chi_square, rel=1e-8)
        assert single.v_c == pytest.approx(parameters[V_C], rel=1e-5)


def test_profile_is_that_of_scipy():
    v, e = measured(1.2, 0.01, 1)
    sets = data_sets(v, e, 100.0, 0.5)
    for v_c in (0.8, 1.0, 1.1):
        expected, _ = witness(v, e[0], 0.01, 0.5, held=v_c)
        assert chi_square_at(sets, v_c)[0] == pytest.approx(expected, rel=1e-8)


def test_interval_ends_where_the_profile_of_scipy_crosses():
    v, e = measured(1.2, 0.01, 1)
    sets = data_sets(v, e, 100.0, 0.5)
    found = interval_batch(sets, fit_batch(sets), CHI_SQUARE_95)
    least, _ = witness(v, e[0], 0.01, 0.5)
    for end in found.ends[0]:
        rise = witness(v, e[0], 0.01, 0.5, held=end)[0] - least
        assert rise == pytest.approx(CHI_SQUARE_95, rel=1e-4)
    assert not found.limited.any()


@pytest.mark.parametrize("q", [None, 0.5])
@pytest.mark.parametrize(("lowest", "sigma"), [(1.05, 0.01), (1.5, 0.03), (3.0, 0.003)])
def test_batch_finds_what_the_single_fit_finds(lowest, sigma, q):
    v, e = measured(lowest, sigma, 3)
    sets = data_sets(v, e, 1.0 / sigma, q)
    batch = fit_batch(sets)
    ends = interval_batch(sets, batch, CHI_SQUARE_95).ends
    for i in range(3):
        single = fit_restitution(v, e[i], sigma, q)
        assert batch.chi_square[i] == pytest.approx(single.chi_square, rel=1e-7)
        assert batch.v_c[i] == pytest.approx(single.v_c, abs=1e-3 * lowest)
        assert batch.capture_on_bound[i] == ("v_c" in single.on_bound)
        # an end near the slowest rebound, where the profile is flat, is known less well
        np.testing.assert_allclose(ends[i], single.v_c_interval, atol=0.005 * lowest)
        assert batch.converged[i]


@pytest.mark.parametrize("q", [None, 0.5])
def test_captured_spheres_count_as_in_the_single_fit(q):
    v, e = measured(1.05, 0.02, 4)
    v = np.concatenate([[0.7, 0.95], v])
    e = np.concatenate([np.zeros((4, 2)), e], axis=1)
    e[1, 1] = 0.05  # one seems to rebound below capture
    e[2, 2] = 0.0  # one seems captured above
    # four pieces of v_c: the lowest minimum of all takes more than the usual searches
    batch = fit_batch(data_sets(v, e, 50.0, q), starts=5)
    for i in range(4):
        single = fit_restitution(v, e[i], 0.02, q)
        assert batch.chi_square[i] == pytest.approx(single.chi_square, rel=1e-6)
        assert batch.v_c[i] == pytest.approx(single.v_c, abs=1e-3)
        assert batch.capture_on_bound[i] == ("v_c" in single.on_bound)


@pytest.mark.parametrize("q", [None, 0.5])
def test_profile_interval_covers_in_a_regular_cell(q):
    replicates = 1000
    v, e = measured(1.05, 0.003, replicates)
    error = np.sqrt(0.95 * 0.05 / replicates)

    def coverage(sigma):
        sets = data_sets(v, e, 1.0 / sigma, q)
        fit = fit_batch(sets)
        return np.mean(chi_square_at(sets, 1.0) - fit.chi_square <= CHI_SQUARE_95)

    assert coverage(0.003) == pytest.approx(0.95, abs=4.0 * error)
    # half the noise assumed: the interval is half as wide, and the normal law gives 0.67
    assert coverage(0.0015) == pytest.approx(0.673, abs=4.0 * np.sqrt(0.67 * 0.33 / replicates))


def test_coverage_is_that_of_the_interval():
    v, e = measured(1.5, 0.01, 200)
    sets = data_sets(v, e, 100.0, 0.5)
    fit = fit_batch(sets)
    ends = interval_batch(sets, fit, CHI_SQUARE_95).ends
    inside = (ends[:, 0] <= 1.0) & (ends[:, 1] >= 1.0)
    accepted = chi_square_at(sets, 1.0) - fit.chi_square <= CHI_SQUARE_95
    assert np.count_nonzero(inside != accepted) <= 1
    assert np.all(ends[:, 0] <= fit.v_c)
    assert np.all(fit.v_c <= ends[:, 1])


def test_a_fit_does_not_depend_on_its_batch():
    count = 40
    v, e = measured(1.5, 0.03, count)
    sets = data_sets(v, e, 1.0 / 0.03)
    whole = fit_batch(sets)
    ends = interval_batch(sets, whole, CHI_SQUARE_95).ends
    for i in (0, 5, count - 1):
        alone = data_sets(v, e[i], 1.0 / 0.03)
        fit = fit_batch(alone)
        np.testing.assert_array_equal(fit.parameters[0], whole.parameters[i])
        np.testing.assert_array_equal(interval_batch(alone, fit, CHI_SQUARE_95).ends[0], ends[i])


def test_a_search_goes_down_the_valley_of_rosenbrock_and_stays_in_its_box():
    def valley(x, rows):
        missed = np.column_stack([10.0 * (x[:, 1] - x[:, 0] ** 2), 1.0 - x[:, 0]])
        slopes = np.zeros((len(x), 2, 2))
        slopes[:, 0, 0], slopes[:, 0, 1], slopes[:, 1, 0] = -20.0 * x[:, 0], 10.0, -1.0
        return squares(missed, slopes)

    # Free; with a bound on the way; with the second variable fixed.
    low = np.array([[-5.0, -5.0], [-5.0, -5.0], [-5.0, 0.25]])
    high = np.array([[5.0, 5.0], [0.5, 5.0], [5.0, 0.25]])
    starts = np.array([np.tile([-1.2, 1.0], (3, 1)), np.tile([3.0, 3.0], (3, 1))])
    found = lowest(valley, starts, Box(low, high, np.full(2, 2.0)), 1e-12)
    assert found.converged.all()
    np.testing.assert_allclose(found.x[:2], [[1.0, 1.0], [0.5, 0.25]], atol=1e-6)
    np.testing.assert_allclose(found.value[:2], [0.0, 0.25], atol=1e-9)
    assert found.x[2, 1] == 0.25
    x = found.x[2, 0]
    assert 200.0 * x * (x**2 - 0.25) + (x - 1.0) == pytest.approx(0.0, abs=1e-4)
    # The start that promises most is followed where one is to be.
    assert lowest(valley, starts, Box(low, high, np.full(2, 2.0)), 1e-12, most=1).each.shape == (
        1,
        3,
    )


def test_a_missing_datum_is_one_that_was_never_taken():
    v, e = measured(1.2, 0.01, 1)
    weight = np.where(np.arange(20) == 0, 0.0, 100.0)
    masked = fit_batch(data_sets(v, e, weight, 0.5))
    short = fit_batch(data_sets(v[1:], e[:, 1:], 100.0, 0.5))
    np.testing.assert_allclose(masked.parameters, short.parameters, rtol=1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"weight": -1.0}, "weight must be"),
        ({"e": -0.1}, "e must be"),
        ({"v": 0.0}, "v must be"),
        ({"q": 0.0}, "q must be"),
    ],
)
def test_bad_data_are_refused(change, message):
    v, e = measured(1.2, 0.01, 1)
    good = {"v": v, "e": e, "weight": 100.0, "q": 0.5}
    bad = {name: np.full(np.shape(good[name]), value) for name, value in change.items()}
    with pytest.raises(ValueError, match=message):
        data_sets(**{**good, **bad})


def test_too_few_rebounds_are_refused():
    v, e = measured(1.2, 0.01, 2)
    e[1, 5:] = 0.0
    weight = np.where(e > 0.0, 100.0, 0.0)
    with pytest.raises(ValueError, match=r"data set 1 must hold at least 6 points .* got 5"):
        data_sets(v, e, weight)


def test_number_of_starts_is_checked():
    v, e = measured(1.2, 0.01, 1)
    with pytest.raises(ValueError, match="starts must be 1 to 5, got 6"):
        fit_batch(data_sets(v, e, 100.0), starts=6)
