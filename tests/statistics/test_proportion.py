"""Intervals of shares."""

from __future__ import annotations

import pytest
import scipy

from microimpact.statistics.proportion import wilson_interval


@pytest.mark.parametrize(("part", "whole"), [(0, 10), (1, 2), (3, 10), (10, 10), (991, 1000)])
def test_wilson_as_in_scipy(part, whole):
    expected = scipy.stats.binomtest(part, whole).proportion_ci(method="wilson")
    assert wilson_interval(part, whole) == pytest.approx(tuple(expected), rel=1e-12)


def test_ends_solve_the_equation_of_the_score():
    # Each end is a share p at which the one found lies 1.96 standard errors sqrt(p q / n) away.
    for end in wilson_interval(30, 40):
        assert abs(0.75 - end) == pytest.approx(1.959964 * (end * (1 - end) / 40) ** 0.5, rel=1e-6)
