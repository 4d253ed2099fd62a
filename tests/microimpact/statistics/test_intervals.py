"""Intervals of means and shares."""

from __future__ import annotations

import numpy as np
import pytest
import scipy

from microimpact.statistics.intervals import (
    mean_and_error,
    student_half_width,
    wilson_interval,
)


@pytest.mark.parametrize(("part", "whole"), [(0, 10), (1, 2), (3, 10), (10, 10), (991, 1000)])
def test_wilson_as_in_scipy(part, whole):
    expected = scipy.stats.binomtest(part, whole).proportion_ci(method="wilson")
    assert wilson_interval(part, whole) == pytest.approx(tuple(expected), rel=1e-12)


def test_ends_solve_the_equation_of_the_score():
    # Each end is a share p at which the one found lies 1.96 standard errors sqrt(p q / n) away.
    for end in wilson_interval(30, 40):
        assert abs(0.75 - end) == pytest.approx(1.959964 * (end * (1 - end) / 40) ** 0.5, rel=1e-6)


def test_standard_errors_of_means():
    assert mean_and_error(np.array([1.0, 3.0])) == pytest.approx((2.0, 1.0))
    assert np.isnan(mean_and_error(np.array([1.0]))[1])
    assert np.isnan(mean_and_error(np.array([]))[0])


def test_a_difference_of_means_has_the_freedom_of_both():
    # t(0.975; 18) = 2.1009
    assert student_half_width(5.0, 10, freedom=18) == pytest.approx(2.1009 * np.sqrt(2.5), rel=1e-4)
