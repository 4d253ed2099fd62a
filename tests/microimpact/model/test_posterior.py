"""Contacts drawn from measured restitutions: what is known is found, as often as it should be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from microimpact import Contact, calibrate, capture_velocity, simulate
from microimpact.core import ensemble
from microimpact.model import posterior
from microimpact.model.posterior import NoConvergenceError, has_converged

SPEEDS = np.array([0.25, 0.4, 0.7, 1.1, 1.8])
DAMPING = ("hertz_damping", "adhesion_damping")


@pytest.fixture(scope="module")
def contact(steel, silicon):
    return Contact(
        particle=steel,
        surface=silicon,
        diameter=62e-6,
        work_of_adhesion=0.7,
        hertz_damping=0.2148,
        adhesion_damping=1.612,
        adhesion_rate_exponent=1.0,
        reference_velocity=1.66,
    )


@pytest.fixture(scope="module")
def exact(contact):
    return simulate(contact, SPEEDS).coefficient_of_restitution


def test_known_damping_is_found(contact, exact):
    found = calibrate(contact, SPEEDS, exact, 0.01, DAMPING, draws=300)
    for name in DAMPING:
        draws = getattr(found.contact, name)
        assert draws.shape == (300,)
        assert np.mean(draws) == pytest.approx(getattr(contact, name), abs=np.std(draws))
        assert found.split_r_hat[name] < 1.05
    assert found.effective_size > 300
    assert np.mean(capture_velocity(found.contact)) == pytest.approx(0.18, abs=0.004)
    # at the best contact hardly a deviation is left, and chi-square is that of the draws
    e = simulate(found.contact, SPEEDS[:, None]).coefficient_of_restitution
    chi_square = np.sum(np.square((e - exact[:, None]) / 0.01), axis=0)
    assert -2.0 * found.log_likelihood == pytest.approx(chi_square, rel=1e-6, abs=1e-9)
    best = simulate(found.best, SPEEDS).coefficient_of_restitution
    assert np.sum(np.square((best - exact) / 0.01)) == pytest.approx(chi_square.min(), abs=1e-9)
    assert "split R-hat" in str(found)


def test_the_posterior_is_that_of_a_grid(contact, exact):
    # one free parameter: the mean and spread by quadrature
    grid = np.linspace(0.15, 0.28, 400)
    e = simulate(contact.replace(hertz_damping=grid), SPEEDS[:, None]).coefficient_of_restitution
    weight = np.exp(-0.5 * np.sum(np.square((e - exact[:, None]) / 0.02), axis=0))
    mean = np.average(grid, weights=weight)
    spread = np.sqrt(np.average(np.square(grid - mean), weights=weight))
    found = calibrate(contact, SPEEDS, exact, 0.02, "hertz_damping", draws=2000)
    draws = found.contact.hertz_damping
    assert np.mean(draws) == pytest.approx(mean, abs=0.15 * spread)
    assert np.std(draws) == pytest.approx(spread, rel=0.1)


@pytest.mark.slow
def test_intervals_hold_the_truth_as_often_as_they_say(contact, monkeypatch):
    """Simulation-based calibration: truths from the prior, ranks of the truth among its draws.

    Each rank is compared with that of the exact posterior, by quadrature over both parameters, too:
    that takes the chance of the data away.
    """
    for name, value in {"SPREAD": 10, "WALKERS": 40}.items():
        monkeypatch.setattr(posterior, name, value)
    rng, sigma, draws = np.random.default_rng(3), 0.02, 200
    ranges = {"hertz_damping": (0.0, 0.3), "adhesion_damping": (0.3, 3.0)}
    share = (np.arange(150) + 0.5) / 150
    axes = 0.3 * share, 0.3 * 10.0**share
    grid = dict(zip(DAMPING, map(np.ravel, np.meshgrid(*axes, indexing="ij")), strict=True))
    on_grid = simulate(contact.replace(**grid), SPEEDS[:, None]).coefficient_of_restitution
    ranks, exact = [], []
    for seed in range(30):
        truth = contact.replace(
            hertz_damping=0.3 * rng.random(), adhesion_damping=0.3 * 10.0 ** rng.random()
        )
        e = simulate(truth, SPEEDS).coefficient_of_restitution
        e = np.clip(e + rng.normal(0.0, sigma, SPEEDS.size), 0.0, 1.0)
        found = calibrate(
            contact, SPEEDS, e, sigma, DAMPING, ranges=ranges, draws=draws, steps=54, seed=seed
        )
        ranks.append([np.mean(getattr(found.contact, n) < getattr(truth, n)) for n in DAMPING])
        weight = np.exp(-0.5 * np.sum(np.square((on_grid - e[:, None]) / sigma), axis=0))
        exact.append([weight[grid[n] < getattr(truth, n)].sum() / weight.sum() for n in DAMPING])
    ranks, exact = np.array(ranks), np.array(exact)
    assert ranks == pytest.approx(exact, abs=4.0 * np.sqrt(0.25 / draws))
    assert np.mean(ranks - exact, axis=0) == pytest.approx(0.0, abs=0.02)
    for level in (0.5, 0.9):
        inside = np.mean(np.abs(ranks - 0.5) < level / 2)
        # three binomial standard errors
        assert inside == pytest.approx(level, abs=3.0 * np.sqrt(level * (1 - level) / ranks.size))


def test_data_without_information_leave_the_prior(contact, exact):
    free = ("work_of_adhesion", "hertz_damping", "adhesion_damping")
    ranges = {"work_of_adhesion": (0.01, 1.0), "hertz_damping": (0.0, 0.2)}
    ranges |= {"adhesion_damping": (0.1, 10.0)}
    found = calibrate(contact, SPEEDS, exact, 1e3, free, ranges=ranges, draws=2000).contact
    shares = {
        "work_of_adhesion": 0.5 * np.log10(found.work_of_adhesion / 0.01),
        "hertz_damping": found.hertz_damping / 0.2,
        "adhesion_damping": 0.5 * np.log10(found.adhesion_damping / 0.1),
    }
    for share in shares.values():
        assert np.quantile(share, [0.1, 0.5, 0.9]) == pytest.approx([0.1, 0.5, 0.9], abs=0.06)


def test_more_draws_than_the_chains_are_worth_are_refused(contact, exact):
    with pytest.raises(NoConvergenceError, match=r"they are worth .* split R-hat of .* is 1\.0"):
        calibrate(contact, SPEEDS, exact, 1e3, "hertz_damping", draws=3000, steps=60)


def test_chains_that_differ_are_worth_nothing_however_many():
    chain = ensemble.Draws(
        points=np.zeros((9, 2)),
        log_density=np.zeros(9),
        acceptance=0.3,
        effective_size=9.0,
        split_r_hat=np.array([1.0, 1.2]),
        kept=90,
    )
    assert not has_converged(chain, 9)
    assert has_converged(replace(chain, split_r_hat=np.array([1.0, 1.05])), 9)


def test_chains_that_have_not_come_together_are_refused(contact, exact):
    free = ("work_of_adhesion", "hertz_damping", "adhesion_damping", "adhesion_rate_exponent")
    with pytest.raises(NoConvergenceError, match="have not come together in 30 steps"):
        calibrate(contact, SPEEDS, exact, 0.002, free, steps=30)


def test_the_reference_velocity_is_chosen_and_symbols_are_names(contact, exact):
    plain = contact.replace(adhesion_rate_exponent=0.0, reference_velocity=None)
    found = calibrate(plain, SPEEDS, exact, 0.01, ["c_A", "n"], draws=100)
    assert found.free == ("adhesion_damping", "adhesion_rate_exponent")
    assert found.contact.reference_velocity == pytest.approx(np.exp(np.log(SPEEDS).mean()))
    assert np.median(capture_velocity(found.contact)) == pytest.approx(0.18, abs=0.02)


def test_a_misfit_has_its_probability(contact, exact):
    wrong = exact + 0.05 * np.array([1.0, -1.0, 1.0, -1.0, 1.0])
    found = calibrate(contact, SPEEDS, wrong, 0.01, DAMPING, draws=100)
    assert found.misfit.freedom == 3
    assert found.misfit.probability < 1e-6
    assert "ring force does not fit: reduced chi-square" in found.misfit.warnings[0]
    assert not calibrate(contact, SPEEDS, exact, 0.01, DAMPING, draws=100).misfit.warnings


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"free": ["hertz_dampin"]}, "hertz_dampin.*did you mean 'hertz_damping'"),
        ({"free": []}, "free must name one field or more"),
        ({"free": ["hertz_damping", "hertz_damping"]}, "each once"),
        ({"v": [1.0]}, "one shape"),
        ({"v": [1.0], "e": [0.7]}, "two measurements or more, got 1"),
        ({"v": [0.0, 1.0], "e": [0.5, 0.7]}, "v must be finite and > 0"),
        ({"e": [0.7, 0.7, 1.2, 0.7, 0.7]}, r"e must be finite and in \[0, 1\], got 1.2 at index 2"),
        ({"sigma": 0.0}, "sigma must be finite and > 0"),
        ({"sigma": [0.1, 0.1]}, r"sigma must be one number or of shape \(5,\), got \(2,\)"),
        ({"ranges": {"hertz_damping": (0.3, 0.1)}}, "two numbers that ascend"),
        ({"ranges": {"hertz_damping": (-0.3, 0.1)}}, "must be finite and >= 0"),
        ({"ranges": {"friction": (0.1, 0.2)}}, "'friction' is not free"),
        ({"draws": 0}, "draws must be at least 1, got 0"),
        ({"draws": 10**6}, "draws must be at most"),
        ({"seed": -1}, "seed must be at least 0"),
    ],
)
def test_bad_input_is_refused(contact, exact, changes, message):
    given = {"v": SPEEDS, "e": exact, "sigma": 0.01, "free": DAMPING} | changes
    with pytest.raises(ValueError, match=message):
        calibrate(contact, **given)


def test_bad_contacts_are_refused(contact, exact):
    many = contact.replace(diameter=np.array([5e-5, 6e-5]))
    with pytest.raises(ValueError, match="contact must be a single one"):
        calibrate(many, SPEEDS, exact, 0.01)
    with pytest.raises(TypeError, match="contact must be a Contact"):
        calibrate(None, SPEEDS, exact, 0.01)
    with pytest.raises(TypeError, match="steps must be a whole number"):
        calibrate(contact, SPEEDS, exact, 0.01, steps=10.5)
