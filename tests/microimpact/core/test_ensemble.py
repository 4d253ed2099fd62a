"""Draws from densities whose moments are known without them."""

from __future__ import annotations

import numpy as np
import pytest

from microimpact.core import ensemble
from microimpact.core.ensemble import NoDensityError, draw, effective_number, resampled

SMALL = {"draws": 2000, "steps": 300, "seed": 5}


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(ensemble, "SPREAD", 11)
    monkeypatch.setattr(ensemble, "WALKERS", 32)


def test_a_correlated_normal_is_drawn_with_its_mean_and_covariance():
    covariance = np.array([[1.0, 1.9], [1.9, 4.0]])
    inverse = np.linalg.inv(covariance)

    def log_density(x):
        return -0.5 * np.einsum("ni,ij,nj->n", x - 3.0, inverse, x - 3.0)

    found = draw(log_density, np.full(2, -20.0), np.full(2, 30.0), **SMALL)
    error = 4.0 * np.sqrt(np.diag(covariance) / found.effective_size)
    assert np.all(np.abs(found.points.mean(axis=0) - 3.0) < error)
    assert np.cov(found.points.T) == pytest.approx(covariance, rel=0.2)
    assert np.all(found.split_r_hat < 1.02)
    assert 500 < found.effective_size < 12_800


def test_walls_of_the_box_are_met_evenly():
    # as flat as the box: the share in its lower tenth is a tenth
    found = draw(lambda x: np.zeros(len(x)), np.zeros(2), np.array([1.0, 100.0]), **SMALL)
    error = 4.0 * np.sqrt(0.09 / found.effective_size)
    assert np.mean(found.points[:, 0] < 0.1) == pytest.approx(0.1, abs=error)
    assert np.mean(found.points[:, 1] > 90.0) == pytest.approx(0.1, abs=error)


def test_two_modes_get_their_shares():
    def log_density(x):
        left, right = (-0.5 * np.sum(np.square((x - c) / 0.1), axis=1) for c in (-1.0, 1.0))
        return np.logaddexp(np.log(0.7) + left, np.log(0.3) + right)

    found = draw(log_density, np.full(2, -2.0), np.full(2, 2.0), **SMALL)
    assert np.mean(found.points[:, 0] < 0.0) == pytest.approx(0.7, abs=0.12)
    again = draw(log_density, np.full(2, -2.0), np.full(2, 2.0), **SMALL)
    assert np.array_equal(found.points, again.points)


def test_no_density_and_too_many_draws_are_refused():
    box = np.zeros(2), np.ones(2)
    with pytest.raises(NoDensityError, match="0 of 2048 points"):
        draw(lambda x: np.full(len(x), -np.inf), *box, **SMALL)
    with pytest.raises(ValueError, match="draws must be at most 12800, got 20000"):
        draw(lambda x: np.zeros(len(x)), *box, **SMALL | {"draws": 20000})


def test_weights_count_and_draw():
    assert effective_number(np.ones(7)) == pytest.approx(7.0)
    assert effective_number(np.array([1.0, 0.0, 0.0])) == pytest.approx(1.0)
    taken = resampled(np.array([0.0, 1.0, 3.0]), 400, np.random.default_rng(1))
    assert np.bincount(taken, minlength=3).tolist() == [0, 100, 300]
