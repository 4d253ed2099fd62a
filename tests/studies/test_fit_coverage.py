"""Study of how well Eq. (34) finds the capture velocity."""

from __future__ import annotations

import re

import numpy as np
import pytest
from pydantic import ValidationError

from microimpact import Contact, capture_velocity, restitution, simulate
from microimpact.declared.parameters import build, explain
from microimpact.model.empirical.data import data_sets
from microimpact.model.empirical.search import fit_batch
from microimpact.studies.models.fit_coverage import Params
from microimpact.studies.models.fit_coverage.intervals import Methods, Sample, intervals
from microimpact.studies.models.fit_coverage.truths import (
    CURVE_RESAMPLES,
    MEASUREMENTS,
    Truths,
    Variant,
    mean_restitution,
    observed,
    standard_deviations,
    standard_noise,
)

TRUE = {"k": 60.0, "p": 1.0, "kappa": 0.4, "q": 0.5, "v_c": 1.0}
ONE_SIZE = Variant(
    variant="one size",
    noise="uniform",
    weights="equal",
    largest_size_ratio=1.0,
    selection="rebounds",
)


def measured(lowest, sigma, replicates, points=20):
    v = np.geomspace(lowest, 15.0, points)
    noise = standard_noise(7, MEASUREMENTS, points, replicates)
    return v, np.maximum(restitution(v, **TRUE) + sigma * noise, 0.0)


@pytest.fixture(scope="module")
def branch(settings):
    return settings.branches["fit_coverage"]


def test_replicates_have_streams_of_their_own():
    few, many = (standard_noise(3, MEASUREMENTS, 10, n) for n in (4, 9))
    np.testing.assert_array_equal(few, many[:4])
    assert len(np.unique(many)) == many.size
    assert not np.any(standard_noise(3, CURVE_RESAMPLES, 10, 4) == few)


@pytest.fixture(scope="module")
def truths(contact: Contact):
    return Truths(contact=contact, constants=tuple(TRUE.values()), sizes=5)


def test_truths_of_one_size_are_the_curves_themselves(truths, contact):
    ratio = np.array([1.05, 2.0, 10.0])
    e = mean_restitution(truths, "simulation", tuple(ratio), 1.0, "rebounds")
    nominal = simulate(contact, ratio * capture_velocity(contact)).coefficient_of_restitution
    np.testing.assert_allclose(e, nominal, rtol=1e-12)
    empirical = mean_restitution(truths, "Eq. 34", tuple(ratio), 1.0, "rebounds")
    np.testing.assert_allclose(empirical, restitution(ratio, **TRUE), rtol=1e-12)


@pytest.mark.parametrize("truth", ["Eq. 34", "simulation"])
def test_seeing_rebounds_only_raises_the_mean(truths, truth):
    seen, every = (
        mean_restitution(truths, truth, (1.02, 10.0), 2.0, selection)
        for selection in ("rebounds", "all")
    )
    # Small spheres are captured just above the nominal v_c, none is far above it. Two of five
    # sizes lie below the nominal one, so three rebound.
    assert every[0] == pytest.approx(3 / 5 * seen[0])
    assert every[1] == seen[1]


def test_velocimeter_noise_is_worst_at_low_speed():
    ratio, e = np.array([1.0, 2.0, 4.0]), np.array([0.3, 0.7, 0.8])
    variant = Variant(
        variant="",
        noise="velocimeter",
        weights="true",
        largest_size_ratio=1.0,
        selection="rebounds",
    )
    deviation = standard_deviations(0.01, ratio, e, variant)
    assert np.sqrt(np.mean(deviation**2)) == pytest.approx(0.01)
    speed_error = deviation * ratio / np.sqrt(1.0 + e**2)  # of V/v, both speeds with one error
    np.testing.assert_allclose(speed_error, speed_error[0])
    np.testing.assert_array_equal(standard_deviations(0.01, ratio, e, ONE_SIZE), 0.01)


def test_who_is_seen_not_to_rebound():
    curve, noise = np.array([0.0, 0.1, 0.1]), np.array([[0.5, -0.2, 0.2]])
    e, present = observed(curve, noise, "rebounds")
    np.testing.assert_allclose(e, [[0.0, 0.0, 0.3]])
    assert present.tolist() == [[False, False, True]]
    assert observed(curve, noise, "all")[1].all()


@pytest.fixture(scope="module")
def compared():
    v, e = measured(1.2, 0.01, 6)
    sets = data_sets(v, e, 100.0, 0.5)
    sample = Sample(ratio=v, noise=0.01, sets=sets, fit=fit_batch(sets))
    methods = Methods(lowest_speeds_in_v_c=(1.2,), replicates=6, resamples=60, share_of_points=0.6)
    return sample, intervals(sample, methods, 11, 0.95)


def test_intervals_lie_in_the_admissible_range(compared):
    sample, found = compared
    for ends in found.values():
        assert np.all(ends[:, 0] >= 0.0)
        assert np.all(ends[:, 0] < ends[:, 1])
        assert np.all(ends[:, 1] <= sample.sets.unit * (1.0 + 1e-12))


def test_methods_agree_where_the_fit_is_regular(compared):
    _, found = compared
    width = {method: np.median(np.diff(ends)) for method, ends in found.items()}
    usual = width["profile, chi-square"]
    # the mixture takes the quantile of 90 %: 1.64/1.96 of the width
    assert width["profile, boundary mixture"] == pytest.approx(0.84 * usual, rel=0.03)
    assert width["profile, parametric bootstrap"] == pytest.approx(usual, rel=0.35)
    assert width["percentiles of parametric bootstrap"] == pytest.approx(usual, rel=0.25)


def test_too_small_a_share_of_points_is_refused(compared):
    sample, _ = compared
    methods = Methods(lowest_speeds_in_v_c=(1.2,), replicates=6, resamples=60, share_of_points=0.2)
    with pytest.raises(ValueError, match=r"share_of_points: 0\.2 leaves too few different speeds"):
        intervals(sample, methods, 11, 0.95)


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"lowest_speeds_in_v_c": [1.0, 2.0]}, "lowest_speeds_in_v_c"),
        ({"lowest_speeds_in_v_c": [2.0, 15.0]}, "highest_speed_in_v_c: 15 must be above"),
        ({"noise_of_e": [-0.01, 0.01]}, "noise_of_e"),
        ({"replicates": 0}, "replicates"),
        ({"replicates": 20}, "interval_replicates: 50 must be at most replicates, 20"),
        ({"reference_points": 17}, r"reference_points: 17 must be one of points, \[10, 20, 40\]"),
        ({"variants": []}, r"variants: \[\] must hold at least 1"),
    ],
)
def test_bad_parameters_are_refused(branch, change, key):
    with pytest.raises(ValidationError) as caught:
        build(Params, {**branch, **change})
    (line,) = explain(caught.value, Params, "")
    assert re.search(key, line), line
