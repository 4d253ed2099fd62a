"""The root finder and the threshold finder."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize.elementwise import find_root

from microimpact.core.solve import ROUNDING, NoRootError, root, roots, threshold


@pytest.mark.parametrize("ends", [(0.0, 2.0), (2.0, 0.0)])
def test_a_root_is_found_to_rounding(ends):
    assert root(np.cos, *ends) == pytest.approx(np.pi / 2, rel=1e-15)
    assert roots(np.cos, *sorted(ends)) == pytest.approx(np.pi / 2, rel=1e-15)


def test_roots_of_many_functions_are_those_of_each():
    power = np.array([[1.0], [3.0], [9.0]])
    wanted = np.array([0.0, 1e-12, 0.5, 4.0])
    found = roots(lambda x, n, c: x**n - c, 0.0, 4.0, power, wanted, relative=1e-14)
    np.testing.assert_allclose(found, wanted ** (1.0 / power), rtol=1e-13, atol=1e-30)
    one = [[root(lambda x, n=n, c=c: x**n - c, 0.0, 4.0) for c in wanted] for n in power.ravel()]
    np.testing.assert_allclose(found, one, rtol=1e-13, atol=1e-30)


def test_roots_are_those_of_scipy():
    def cubic(x, c):
        return x**3 + x - c

    c = np.geomspace(1e-3, 1e3, 50)
    ends = np.zeros(c.shape), np.full(c.shape, 20.0)
    precise = {"xatol": 0.0, "xrtol": ROUNDING, "fatol": 0.0, "frtol": 0.0}
    witness = find_root(cubic, ends, args=(c,), tolerances=precise)
    assert np.all(witness.success)
    np.testing.assert_array_equal(roots(cubic, *ends, c), witness.x)


def test_roots_that_are_found_are_left_alone():
    asked = []

    def function(x, number):
        asked.append(number.size)
        return np.where(number == 0, x - 0.5, np.exp(20.0 * x) - np.exp(0.1))

    roots(function, 0.0, 1.0, np.arange(2))
    assert asked[0] == 2
    assert asked[-1] == 1


@pytest.mark.parametrize("tolerance", [{"absolute": 1e-3}, {"relative": 1e-3}])
def test_tolerances_end_a_search_early(tolerance):
    counts = []
    for asked in (tolerance, {}):
        calls = []
        found = root(lambda x, calls=calls: calls.append(x) or x**3 - 2.0, 0.0, 2.0, **asked)
        assert found == pytest.approx(2.0 ** (1 / 3), abs=2e-3)
        counts.append(len(calls))
    assert counts[0] < counts[1]
    held = threshold(lambda x: x >= 1.3, 0.0, 2.0, **tolerance)
    assert 1.3 <= held <= 1.3 + 2e-3
    assert held != pytest.approx(1.3, rel=1e-9)


def test_ends_are_looked_at_once():
    calls = []
    root(lambda x: calls.append(x) or x - 0.3, 0.0, 1.0)
    assert len(calls) == len(set(calls))


def test_a_threshold_is_the_least_number_at_which_the_condition_holds():
    found = threshold(lambda x: x >= 0.3, 0.0, 1.0)
    assert 0.3 <= found <= 0.3 * (1.0 + 1e-15)
    falling = threshold(lambda x: x <= 0.3, 1.0, 0.0)
    assert 0.3 * (1.0 - 1e-15) <= falling <= 0.3
    assert isinstance(found, float)


def test_thresholds_of_arrays():
    at = np.array([[0.1, 0.2], [1e-9, 0.9]])
    found = threshold(lambda x: x > at, np.zeros(at.shape), np.ones(at.shape))
    np.testing.assert_allclose(found, at, rtol=1e-15)
    assert np.all(found > at)


def test_a_search_for_nothing_ends():
    assert 0.0 < threshold(lambda x: x > 0.0, -1.0, 1.0) < 1e-300
    assert abs(root(lambda x: x**3, -1.0, 2.0)) < 1e-100


@pytest.mark.parametrize(
    ("search", "message"),
    [
        (lambda: root(np.cos, 0.0, 1.0), "no change of sign between 0, with 1, and 1, with 0.54"),
        (lambda: root(lambda x: np.nan, 0.0, 1.0), "between 0, with nan, and 1, with nan"),
        (
            lambda: roots(lambda x, c: x - c, 0.0, 1.0, np.array([0.5, 2.0])),
            "root 1: none found between 0, with -2, and 1, with -1",
        ),
        (lambda: threshold(lambda x: x > 3.0, 0.0, 2.0), "the condition must hold at 2"),
        (lambda: threshold(lambda x: x > -1.0, 0.0, 2.0), "the condition must not hold at 0"),
        (
            lambda: threshold(lambda x: x > np.array([0.5, 9.0]), np.zeros(2), np.array([1.0, 7])),
            "the condition must hold at 7",
        ),
    ],
)
def test_where_there_is_none_the_error_says_so(search, message):
    with pytest.raises(NoRootError, match=message):
        search()


def test_an_error_of_the_function_is_its_own():
    def fails(x):
        raise ValueError("of the function")

    with pytest.raises(ValueError, match="of the function"):
        root(fails, 0.0, 1.0)


def test_a_small_value_at_an_end_passes_for_a_root():
    # Rounding may give both ends of a bracket one sign.
    ends = {"low": np.array([1.0]), "high": np.array([1.0 + 1e-15])}
    with pytest.raises(NoRootError, match="root 0"):
        roots(lambda x: x - 1.0 + 1e-15, **ends)
    found = roots(lambda x: x - 1.0 + 1e-15, **ends, residual=1e-14)
    assert found[0] == pytest.approx(1.0, rel=1e-14)
