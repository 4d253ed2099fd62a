"""Capture velocity by several models: truth inside, profiles that another search confirms."""

import re
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from scipy.optimize import least_squares

from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.empirical import shapes
from microimpact.model.empirical.comparison import (
    _require_sound,
    _runs,
    compare_models,
    compare_sets,
)
from microimpact.model.empirical.data import in_own_units
from microimpact.model.empirical.fit import fit_restitution

NOISE, POINTS = 0.02, 24
NO_STARTS = np.empty((0, 0, 0))


@pytest.fixture(scope="module")
def rated(contact):
    """Damping that falls with the rate: the shape that Eq. (34) with q = 1/2 does not have."""
    return contact.replace(
        work_of_adhesion=0.7,
        hertz_damping=0.2148,
        adhesion_damping=1.612,
        adhesion_rate_exponent=1.0,
        reference_velocity=1.66,
    )


def measured(law, seed, slowest=0.8):
    """Noisy restitutions of a contact, captured spheres among them."""
    limit = float(capture_velocity(law))
    v = limit * np.geomspace(slowest, 15.0, POINTS)
    exact = simulate(law, v).coefficient_of_restitution
    noise = np.random.default_rng(seed).normal(0.0, NOISE, POINTS)
    return limit, v, np.where(exact > 0.0, np.clip(exact + noise, 0.0, 1.0), 0.0)


@pytest.fixture(scope="module")
def compared(rated):
    limit, v, e = measured(rated, 1)
    return limit, v, e, compare_models(v, e, NOISE)


def test_the_true_law_is_found_and_the_interval_holds_v_c(compared):
    limit, _, _, found = compared
    low, high = found.v_c_interval
    assert low < limit < high
    true = next(model for model in found.models if model.name == "ring force")
    assert true.criterion < 2.0
    assert true.interval[0] < limit < true.interval[1]
    assert sum(model.weight for model in found.models) == pytest.approx(1.0)
    fixed = next(model for model in found.models if model.name == "Eq. 34, q = 1/2")
    assert not fixed.interval[0] <= limit <= fixed.interval[1]
    assert fixed.weight < 1e-3


def test_profiles_of_eq_34_are_those_of_its_own_fit(compared):
    _, v, e, found = compared
    for name, q in (("Eq. 34, q free", None), ("Eq. 34, q = 1/2", 0.5)):
        model = next(model for model in found.models if model.name == name)
        own = fit_restitution(v, e, NOISE, q)
        assert model.chi_square == pytest.approx(own.chi_square, abs=0.02)
        assert model.v_c == pytest.approx(own.v_c, rel=0.01)
        assert model.interval == pytest.approx(own.v_c_interval, rel=0.01)
        assert np.allclose(model.law(v), own.curve(v), atol=5e-3)


def test_the_ring_force_is_fitted_as_another_search_fits_it(contact):
    """The same least squares by SciPy, over damping, n and work of adhesion of a real contact."""
    limit, v, e = measured(contact, 3)
    found = compare_models(v, e, NOISE)
    model = next(model for model in found.models if model.name == "ring force")

    def changed(places):
        work, hertz, adhesion = np.exp(places[:3])
        return contact.replace(
            work_of_adhesion=work,
            hertz_damping=hertz,
            adhesion_damping=adhesion,
            adhesion_rate_exponent=places[3],
            reference_velocity=limit,
        )

    def missed(places):
        return (simulate(changed(places), v).coefficient_of_restitution - e) / NOISE

    start = [*np.log([0.5, 0.01, 3.0]), 0.5]
    bounds = [-np.inf] * 3 + [0.0], [np.inf] * 3 + [2.0]
    best = least_squares(missed, start, diff_step=1e-4, bounds=bounds)
    v_c = np.atleast_1d(capture_velocity(changed(best.x)))
    data = in_own_units(v[None], e[None], np.full((1, POINTS), 1.0 / NOISE), None)
    held = shapes.profile("ring force", data, np.zeros(1, int), v_c / data.unit, NO_STARTS)
    assert held.value[0] == pytest.approx(2.0 * best.cost, abs=0.02)
    # Values of v_c in a profile are some way apart.
    assert model.chi_square == pytest.approx(2.0 * best.cost, abs=0.05)
    assert model.v_c == pytest.approx(v_c[0], rel=2e-3)
    own = shapes.restitution("ring force", held.x[0], v / v_c)
    assert np.allclose(own - e, best.fun * NOISE, atol=2e-3)
    assert found.v_c_interval[0] < limit < found.v_c_interval[1]


def test_the_unit_of_speed_does_not_matter(compared):
    _, v, e, found = compared
    slower = compare_models(0.1 * v, e, NOISE)
    assert np.allclose(slower.v_c_interval, 0.1 * np.array(found.v_c_interval), rtol=1e-6)


def test_data_sets_side_by_side_are_compared_as_each_alone(compared, rated):
    _, v, e, found = compared
    _, other, fewer = measured(rated, 5, slowest=1.2)
    sets = [(v, e, NOISE), (other[2:], fewer[2:], NOISE), (v, e, None), (2.0 * v, e, 2.0 * NOISE)]
    together = compare_sets(sets)
    assert together[0].v_c_interval == pytest.approx(found.v_c_interval, rel=1e-9)
    for one, own in zip(together, sets, strict=True):
        alone = compare_models(*own)
        assert one.v_c_interval == pytest.approx(alone.v_c_interval, rel=1e-9)
        assert one.warnings == alone.warnings
        weights = [(model.name, pytest.approx(model.weight, rel=1e-9)) for model in alone.models]
        assert [(model.name, model.weight) for model in one.models] == weights


@pytest.mark.parametrize("sigma", [NOISE, NOISE / 5.0, None])
def test_the_criterion_is_akaikes(compared, sigma):
    _, v, e, _ = compared
    models = compare_models(v, e, sigma).models
    above = v >= v[e > 0.0].min()
    count, free = above.sum(), np.array([model.free for model in models])
    squares = np.array([np.sum((e - model.law(v))[above] ** 2) for model in models])
    if sigma is None:  # corrected for few data; sigma is a parameter, too
        numbers = free + 1
        criterion = count * np.log(squares / count)
        criterion += 2 * numbers + 2 * numbers * (numbers + 1) / (count - numbers - 1)
    else:
        scatter = np.min(squares / sigma**2 / (count - free))
        criterion = squares / sigma**2 / max(1.0, scatter) + 2 * free
    expected = criterion - criterion.min()
    assert [model.criterion for model in models] == pytest.approx(expected, abs=1e-6)
    weights = np.exp(-0.5 * expected) / np.sum(np.exp(-0.5 * expected))
    assert [model.weight for model in models] == pytest.approx(weights, abs=1e-6)


@pytest.mark.parametrize("sigma", [NOISE, NOISE / 5.0, None])
def test_intervals_of_eq_34_are_those_of_its_own_fit(compared, sigma):
    """With sigma too small or unknown, sigma is what the residuals say, and tails are Student's."""
    _, v, e, _ = compared
    (model,) = compare_models(v, e, sigma, models=["Eq. 34, q free"]).models
    estimated = None if sigma != NOISE else NOISE
    low, high = fit_restitution(v, e, estimated).v_c_interval
    assert model.interval == pytest.approx((low, high), abs=0.01 * (high - low))


def test_a_sigma_too_small_or_unknown_is_told(compared):
    _, v, e, _ = compared
    wrong, without = compare_models(v, e, NOISE / 5.0), compare_models(v, e)
    assert wrong.scatter > 2.0
    assert any("times the sigma given" in warning for warning in wrong.warnings)
    assert without.sigma == pytest.approx(NOISE, rel=0.5)
    assert any("sigma is not given" in warning for warning in without.warnings)


@pytest.mark.parametrize(("more", "less"), [(8, 8), (9, 5)])
def test_runs_of_signs_are_as_rare_as_counting_says(more, less):
    signs = [np.isin(range(more + less), c) for c in combinations(range(more + less), more)]
    runs = np.array([1 + np.sum(s[1:] != s[:-1]) for s in signs])
    for count in range(3, more + less - 2):
        series = signs[np.flatnonzero(runs == count)[0]] if count in runs else None
        if series is not None:
            share = _runs(np.where(series, 1.0, -1.0))
            assert share == pytest.approx(np.mean(runs <= count), abs=0.02)


def test_captures_just_below_are_near_capture():
    v = 0.2 * np.append([0.9, 0.95], np.geomspace(1.5, 10.0, 15))
    e = 0.8 * np.sqrt(np.maximum(1.0 - (0.2 / v) ** 2, 0.0))
    assert not any("near capture" in warning for warning in compare_models(v, e, 0.01).warnings)
    far = compare_models(v[2:], e[2:], 0.01).warnings
    assert any("no speed is near capture" in warning for warning in far)


def test_data_far_from_capture_say_so(rated):
    limit, v, e = measured(rated, 2, slowest=4.0)
    found = compare_models(v, e, NOISE)
    assert any("no speed is near capture" in warning for warning in found.warnings)
    assert found.v_c_interval[0] < limit < found.v_c_interval[1]
    assert np.diff(found.v_c_interval) > limit


def test_captures_above_rebounds_are_told(compared):
    _, v, e, _ = compared
    mixed = e.copy()
    mixed[np.flatnonzero(e > 0.0)[2]] = 0.0
    found = compare_models(v, mixed, NOISE)
    assert any("overlap" in warning for warning in found.warnings)


@pytest.mark.parametrize("confidence", [0.5, 0.99])
def test_intervals_grow_with_the_confidence(compared, confidence):
    _, v, e, found = compared
    other = compare_models(v, e, NOISE, confidence=confidence)
    wider = np.diff(other.v_c_interval) > np.diff(found.v_c_interval)
    assert wider == (confidence > found.confidence)


def test_what_is_no_curve_is_refused():
    random = np.random.default_rng(4)
    with pytest.raises(ValueError, match="e must depend on v"):
        compare_models(random.uniform(0.1, 5.0, 40), random.uniform(0.0, 1.0, 40), NOISE)


@pytest.mark.parametrize("sigma", [0.01, None])
@pytest.mark.parametrize("low", [0.0, 0.02])
def test_a_stray_row_is_named(sigma, low):
    """A sphere that hit dirt: in the refusal, and among fifty clean rows in the warning."""
    for points in (20, 50):
        v = np.geomspace(0.21, 2.4, points)
        e = 0.85 * np.sqrt(1.0 - (0.2 / v) ** 2)
        e += np.random.default_rng(1).normal(0.0, 0.01, points)
        e[-6] = low
        row = rf"largest residuals: row 6 \(v = {v[-6]:.4g} m/s, e = {low:g}, -\d+.\d sigma\)"
        if points == 20:
            with pytest.raises(ValueError, match=row):
                compare_models(v[::-1], e[::-1], sigma)
        else:
            first = compare_models(v[::-1], e[::-1], sigma).warnings[0]
            assert re.search(row, first)
            assert first.count("row ") == (3 if sigma else 1)


@pytest.mark.parametrize(
    ("v", "e", "message"),
    [
        ([1.0], [0.5], "at least 5 points"),
        (np.arange(1, 9), np.zeros(8), "no sphere rebounds"),
        (np.arange(1, 9), np.full(8, 1.1), r"in \[0, 1.06\], got 1.1"),
        (np.arange(1, 9), np.full(7, 0.5), "of one shape"),
        (np.ones(8), np.full(8, 0.5), "at least 4 different speeds"),
        (-np.arange(1, 9), np.full(8, 0.5), "v must be"),
    ],
)
def test_too_little_or_wrong_is_refused(v, e, message):
    with pytest.raises(ValueError, match=message):
        compare_models(v, e, NOISE)


@pytest.mark.parametrize("sigma", [5e-324, 1e-320, 1e308])
@pytest.mark.parametrize("compared_by", [compare_models, fit_restitution])
def test_numbers_at_the_ends_of_the_computers_are_refused(compared_by, sigma):
    v = np.geomspace(0.2, 2.0, 12)
    e = 0.8 * np.sqrt(1.0 - (0.19 / v) ** 2)
    with pytest.raises(ValueError, match=r"sigma must be finite and in \[1e-12, 1"):
        compared_by(v, e, sigma)
    with pytest.raises(ValueError, match=r"v must be finite and in \[1e-09, 1e\+06\]"):
        compared_by(v * 1e307, e, 0.01)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("rows", "sigma", "left_out"),
    [
        (5, None, ("Eq. 34, q free", "Eq. 34, q = 1/2", "ring force")),
        (5, 0.01, ("Eq. 34, q free",)),
        (7, None, ("Eq. 34, q free",)),
        (8, None, ()),
    ],
)
def test_models_that_need_more_rows_are_named(rows, sigma, left_out):
    v = np.geomspace(0.2, 2.0, rows)
    e = 0.8 * np.sqrt(1.0 - (0.19 / v) ** 2) + 0.01 * np.cos(7.0 * v)
    found = compare_models(v, e, sigma)
    assert found.left_out == left_out
    named = [w for w in found.warnings if w.startswith("models left out, for")]
    assert named == [
        f"models left out, for {rows} rows are too few for them: {', '.join(left_out)}"
    ] * bool(left_out)


def test_an_average_that_breaks_its_invariants_is_an_error(compared):
    *_, found = compared
    for change in (
        {"v_c": np.nan},
        {"v_c": found.v_c_interval[1] * 1.01},
        {"v_c_interval": (found.v_c, found.v_c)},
        {"v_c_interval": (0.0, np.inf)},
        {"models": found.models[:1]},
        {"models": tuple(replace(m, interval=(1e3, 2e3)) for m in found.models)},
    ):
        with pytest.raises(RuntimeError, match="the average of models went wrong"):
            _require_sound(replace(found, **change))


def test_models_may_be_chosen_by_name(compared):
    _, v, e, found = compared
    own = compare_models(v, e, NOISE, models=["Eq. 34, q free"])
    (only,) = own.models
    assert own.v_c_interval == pytest.approx(only.interval)
    assert only.interval == next(m.interval for m in found.models if m.name == only.name)
    with pytest.raises(ValueError, match=r"'viscous' must be one of Eq. 34, q free; .*viscous JKR"):
        compare_models(v, e, NOISE, models=["viscous"])
    with pytest.raises(ValueError, match=r"at least 6 points .* for these models, got 5"):
        compare_models(v[-5:], e[-5:], NOISE, models=["Eq. 34, q free"])
