"""Distributions and draws: quantiles, correlation, methods of sampling, bad parameters, streams."""

import numpy as np
import pytest
from scipy import special, stats

from microimpact.statistics.distributions import (
    HalfNormal,
    Histogram,
    LogNormal,
    Normal,
    Sample,
    TruncatedNormal,
    Uniform,
    generator,
    mean,
    uniforms,
)
from microimpact.statistics.sampling import Correlation, joint_shares, unit_points

U = np.linspace(0.0005, 0.9995, 1999)


@pytest.mark.parametrize(
    ("distribution", "reference"),
    [
        (Uniform(low=-1.0, high=3.0), stats.uniform(-1.0, 4.0)),
        (Normal(mean=2.0, sd=0.5), stats.norm(2.0, 0.5)),
        (Normal(), stats.norm()),
        (
            TruncatedNormal(mean=50.0, sd=9.0, low=10.0, high=65.0),
            stats.truncnorm(-40.0 / 9.0, 15.0 / 9.0, 50.0, 9.0),
        ),
        # Far in a tail: the naive form would lose all digits.
        (TruncatedNormal(mean=0.0, sd=1.0, low=9.0, high=12.0), stats.truncnorm(9.0, 12.0)),
        (HalfNormal(sd=0.15), stats.halfnorm(0.0, 0.15)),
        (LogNormal(median=3.0, geometric_sd=1.5), stats.lognorm(np.log(1.5), 0.0, 3.0)),
    ],
)
def test_quantiles_are_those_of_the_named_distribution(distribution, reference):
    np.testing.assert_allclose(distribution.quantile(U), reference.ppf(U), rtol=1e-9, atol=1e-12)
    assert mean(distribution) == pytest.approx(reference.mean(), rel=2e-3, abs=1e-9)


def test_histogram_fills_its_bins_in_proportion_and_leaves_empty_ones_empty():
    values = Histogram(edges=(0.0, 1.0, 2.0, 5.0), counts=(1.0, 0.0, 3.0)).quantile(U)
    assert np.mean(values < 1.0) == pytest.approx(0.25, abs=1e-3)
    assert not np.any((values > 1.0) & (values < 2.0))
    upper = values[values >= 2.0]
    assert np.mean(upper) == pytest.approx(3.5, abs=2e-3)


def test_sample_returns_the_values_seen_in_equal_shares():
    values = Sample(values_seen=(3.0, 1.0, 2.0, 2.0)).quantile(U)
    assert [np.mean(values == v) for v in (1.0, 2.0, 3.0)] == pytest.approx(
        [0.25, 0.5, 0.25], abs=1e-3
    )


def test_sieve_classes_have_the_printed_means():
    # 49, 75 and 62 um (Sections 2.3.1 and 2.4.1), each printed to the micrometre.
    assert mean(TruncatedNormal(mean=50, sd=9, low=10, high=65)) == pytest.approx(49.0, abs=1.0)
    assert mean(TruncatedNormal(mean=71, sd=12, low=60, high=125)) == pytest.approx(75.0, abs=1.0)
    assert mean(TruncatedNormal(mean=62, sd=4.5, low=45, high=76)) == pytest.approx(62.0, abs=1.0)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Uniform(low=2.0, high=1.0), "low must be below high, got 2 and 1"),
        (lambda: TruncatedNormal(mean=0, sd=1, low=3, high=3), "low must be below high"),
        (lambda: TruncatedNormal(mean=0, sd=1, low=50, high=60), "nothing is drawn"),
        (lambda: Histogram(edges=(0.0,), counts=()), "counts must not all be zero"),
        (lambda: Histogram(edges=(0.0, 1.0), counts=(0.0,)), "counts must not all be zero"),
        (lambda: Histogram(edges=(0.0, 1.0), counts=(1.0, 2.0)), "one more than counts"),
        (lambda: Histogram(edges=(1.0, 0.0), counts=(1.0,)), "edges must increase"),
        (lambda: Sample(values_seen=()), "at least one value"),
    ],
)
def test_impossible_distributions_are_refused(make, words):
    with pytest.raises(ValueError, match=words):
        make()


def test_streams_of_different_keys_differ_and_of_equal_keys_agree():
    draws = {key: tuple(generator(1, *key).random(4)) for key in [(), (0,), (1,), (0, 1), (1, 0)]}
    assert len(set(draws.values())) == len(draws)
    assert draws[0, 1] == tuple(generator(1, 0, 1).random(4))


def test_uniform_numbers_never_reach_the_ends():
    class Ends:
        def random(self, shape):
            return np.array([0.0, 1.0 - 2.0**-53])

    assert np.all(np.isfinite(Normal().quantile(uniforms(Ends(), 2))))


# Draws of several variables

N = 2**16


@pytest.mark.parametrize("method", ["plain", "antithetic", "quasi_random"])
@pytest.mark.parametrize("by", ["exact", "central_limit"])
def test_correlation_is_that_of_the_normal_scores(method, by):
    matrix = ((1.0, 0.6, -0.3), (0.6, 1.0, 0.2), (-0.3, 0.2, 1.0))
    laws = {
        "a": Normal(mean=1.0, sd=2.0),
        "free": Normal(),
        "b": LogNormal(median=2.0, geometric_sd=1.3),
        "c": Uniform(low=-1.0, high=1.0),
    }
    correlation = Correlation(names=("a", "b", "c"), matrix=matrix)
    shares = joint_shares(
        laws, N, generator(2), correlation=correlation, method=method, generator=by
    )
    scores = np.stack([special.ndtri(shares[name]) for name in ("a", "b", "c", "free")])
    expected = np.eye(4)
    expected[:3, :3] = matrix
    assert np.corrcoef(scores) == pytest.approx(expected, abs=5 / np.sqrt(N))
    # a bivariate normal has r = 2 sin(pi/6 rho_s): between normal and lognormal ranks alone count
    values = [laws[name].quantile(shares[name]) for name in ("a", "b")]
    rank = stats.spearmanr(*values).statistic
    assert rank == pytest.approx(6 / np.pi * np.arcsin(0.3), abs=5 / np.sqrt(N))
    for name in ("b", "c"):
        assert stats.kstest(shares[name], "uniform").statistic < 2.0 / np.sqrt(N)


def test_sum_of_twelve_uniforms_lacks_a_tenth_of_kurtosis_and_has_no_tails():
    def drawn(law, by):
        return law.quantile(joint_shares({"x": law}, N, generator(1), generator=by)["x"])

    exact, summed = (drawn(Normal(), by) for by in ("exact", "central_limit"))
    assert summed.mean() == pytest.approx(0.0, abs=5 / np.sqrt(N))
    assert summed.var() == pytest.approx(1.0, abs=5 * np.sqrt(1.9 / N))
    # excess kurtosis of a uniform variable is -6/5, of a sum of twelve a twelfth of it
    assert stats.kurtosis(exact) == pytest.approx(0.0, abs=4 * np.sqrt(24 / N))
    assert stats.kurtosis(summed) == pytest.approx(-1.2 / 12, abs=4 * np.sqrt(24 / N))
    assert np.abs(summed).max() < 6.0  # the greatest sum
    # other laws take their uniform number in either generator
    for law in (Uniform(low=0.0, high=1.0), Sample(values_seen=(1.0, 2.0, 4.0))):
        assert np.array_equal(drawn(law, "exact"), drawn(law, "central_limit"))


def test_antithetic_points_come_in_opposite_pairs_and_quasi_random_ones_fill_every_interval():
    points = unit_points(64, 3, generator(3), "antithetic")
    assert points[:32] + points[32:] == pytest.approx(1.0)
    assert len(np.unique(points[:32])) == 96
    points = unit_points(256, 4, generator(4), "quasi_random")
    for column in points.T:
        assert np.array_equal(np.sort((column * 256).astype(int)), np.arange(256))
    assert not np.any(points == unit_points(256, 4, generator(5), "quasi_random"))


@pytest.mark.parametrize(
    ("names", "matrix", "message"),
    [
        (("a", "b"), ((1.0,), (0.5, 1.0)), r"2 rows of 2 numbers.*rows of \[1, 2\]"),
        (("a", "b"), ((1.0, 0.5), (0.4, 1.0)), "symmetric"),
        (("a", "b"), ((2.0, 0.5), (0.5, 1.0)), "ones on its diagonal"),
        (("a", "b"), ((1.0, 1.5), (1.5, 1.0)), "positive definite.*-0.5"),
        (("a", "a"), ((1.0, 0.5), (0.5, 1.0)), "'a' is given more than once"),
    ],
)
def test_bad_correlations_are_refused(names, matrix, message):
    with pytest.raises(ValueError, match=message):
        Correlation(names=names, matrix=matrix)
