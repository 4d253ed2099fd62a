"""Distributions and draws: quantiles, bad parameters, streams."""

import numpy as np
import pytest
from scipy import stats

from microimpact.statistics.distributions import (
    HalfNormal,
    Histogram,
    LogNormal,
    Normal,
    SampleFile,
    TruncatedNormal,
    Uniform,
    generator,
    mean,
    quasi_random,
    uniforms,
)

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


def test_a_sample_returns_the_values_seen_in_equal_shares(tmp_path):
    (tmp_path / "seen.txt").write_text("3\n1\n2\n2\n", encoding="utf-8")
    values = SampleFile(path=str(tmp_path / "seen.txt")).quantile(U)
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


def test_quasi_random_points_fill_every_interval():
    points = quasi_random(256, 4, generator(4))
    for column in points.T:
        assert np.array_equal(np.sort((column * 256).astype(int)), np.arange(256))
    assert not np.any(points == quasi_random(256, 4, generator(5)))
