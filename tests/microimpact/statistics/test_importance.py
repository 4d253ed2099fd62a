"""Importance sampling against integrals that are known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from microimpact.core.ensemble import effective_number
from microimpact.statistics.importance import drawn_size, integral, pool

# Two far peaks of unlike weight, and a broad hill, in three dimensions.
PEAKS = [
    (0.8, multivariate_normal([0.2, 0.3, 0.7], 0.0004 * np.eye(3))),
    (0.2, multivariate_normal([0.7, 0.8, 0.4], 0.0001 * np.eye(3))),
]
HILL = multivariate_normal([0.5, 0.5, 0.5], 0.01 * np.eye(3))


def densities(points):
    peaks = np.log(sum(share * np.maximum(of.pdf(points), 1e-300) for share, of in PEAKS))
    return np.stack([peaks - 7.0, HILL.logpdf(points)], axis=1)


@pytest.fixture(scope="module", params=[1, 2, 3])
def drawn(request):
    rng = np.random.default_rng(request.param)
    return pool(
        lambda points: {"log": densities(points)},
        lambda record: record["log"],
        lambda logs: logs,
        3,
        first=12,
        rounds=6,
        rng=rng,
    )


def test_integrals_of_all_densities_are_found_within_their_error(drawn):
    for column, exact in enumerate((-7.0, 0.0)):
        found = integral(drawn.log_weights(drawn.record["log"][:, column]), drawn.tried)
        assert abs(found.log - exact) < 3.5 * found.error
        assert found.error < 0.08
        assert found.effective_size > 150


def test_peaks_have_their_shares(drawn):
    logs = drawn.log_weights(drawn.record["log"][:, 0])
    weights = np.exp(logs - logs.max())
    first = np.sum(weights[drawn.points[:, 1] < 0.55]) / np.sum(weights)
    assert first == pytest.approx(PEAKS[0][0], abs=0.06)


def test_what_is_nowhere_has_no_integral():
    assert integral(np.full(5, -np.inf), 5).log == -np.inf


def test_a_share_over_points_drawn_again_varies_as_over_so_many_independent_ones():
    rng, shares, sizes = np.random.default_rng(2), [], []
    for _ in range(1500):
        points = rng.random(300)
        weights = np.exp(-3.0 * points)
        taken = rng.choice(points, 100, p=weights / weights.sum())
        shares.append(np.mean(taken < 0.25))
        sizes.append(drawn_size(effective_number(weights), 100))
    p = np.mean(shares)
    assert np.var(shares) == pytest.approx(p * (1 - p) / np.mean(sizes), rel=0.25)


def test_integrals_of_few_points_are_right_in_the_mean_and_vary_as_stated():
    """Points weighed with kernels set at themselves would give integrals that are too small."""
    ridge = multivariate_normal(5 * [0.5], 0.002 * np.eye(5) + 0.006)
    found = []
    for seed in range(60):
        of_seed = pool(
            lambda points: {"log": ridge.logpdf(points)},
            lambda record: record["log"][:, None],
            lambda logs: logs,
            5,
            first=8,
            rounds=4,
            rng=np.random.default_rng(seed),
        )
        found.append(integral(of_seed.log_weights(of_seed.record["log"]), of_seed.tried))
    integrals, errors = np.exp([i.log for i in found]), np.array([i.error for i in found])
    assert integrals.mean() == pytest.approx(1.0, abs=3 * integrals.std() / np.sqrt(60))
    assert integrals.std() == pytest.approx(np.sqrt(np.mean(errors**2)), rel=0.3)
