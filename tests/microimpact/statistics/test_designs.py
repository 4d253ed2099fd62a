"""Two-level designs against columns written by hand."""

from __future__ import annotations

import numpy as np
import pytest

from microimpact.statistics.effects import fractional_factorial, full_factorial


def yates(factors):
    """Levels in standard order: factor i changes every 2^i runs."""
    run = np.arange(2**factors)
    return np.stack([np.where(run // 2**i % 2, 1.0, -1.0) for i in range(factors)], axis=1)


def test_half_fraction_of_five_factors():
    design = fractional_factorial("a b c d abcd")
    free = yates(4)
    np.testing.assert_array_equal(design[:, :4], free)
    np.testing.assert_array_equal(design[:, 4], free.prod(axis=1))


def test_quarter_fraction_and_negative_generator():
    design = fractional_factorial("a b c ab -ac")
    a, b, c = yates(3).T
    np.testing.assert_array_equal(design, np.stack([a, b, c, a * b, -a * c], axis=1))


@pytest.mark.parametrize("factors", [1, 3, 5])
def test_full_factorial(factors):
    np.testing.assert_array_equal(full_factorial(factors), yates(factors))
