"""Eqs. 32-34."""

from __future__ import annotations

import numpy as np
import pytest

from microimpact.model.empirical.equations import (
    adhesion_coefficient,
    body_restitution,
    restitution,
)


def test_values_by_hand():
    assert body_restitution(2.0, 4.0, 2.0) == pytest.approx(16 / 20, rel=1e-15)
    assert adhesion_coefficient(3.0, 2.0, 3.0, 1.0) == pytest.approx(0.5, rel=1e-15)
    e = restitution(3.0, 4.0, 2.0, 2.0, 3.0, 1.0)
    assert e == pytest.approx(16 / 25 * 0.5, rel=1e-15)


def test_limits_the_article_states():
    assert body_restitution(0.0, 4.0, 2.0) == 1.0
    assert adhesion_coefficient(1.0, 2.0, 3.0, 1.0) == 1.0
    below = restitution([0.0, 0.5, 1.0], 4.0, 2.0, 2.0, 3.0, 1.0)
    assert (below == 0.0).all()


def test_product_holds_and_is_accurate_just_above_capture():
    v = np.linspace(0.0, 50.0, 1001)
    R, rho = body_restitution(v, 30.0, 1.2), adhesion_coefficient(v, 0.6, 1.5, 0.9)
    np.testing.assert_allclose(
        restitution(v, 30.0, 1.2, 0.6, 1.5, 0.9), R * (1 - rho), rtol=1e-12, atol=1e-15
    )
    tiny = restitution(1.0 + 2.0**-40, 30.0, 1.0, 0.5, 1.0, 1.0)
    assert tiny == pytest.approx(30 / 31 * 2.0**-39, rel=1e-9, abs=0.0)


def test_extreme_arguments_do_not_overflow():
    assert body_restitution(1e200, 1e-200, 50.0) == 0.0
    assert body_restitution(1e-200, 1e200, 50.0) == 1.0


def test_arguments_broadcast():
    assert restitution(np.ones((3, 1)), 1.0, 1.0, 1.0, np.ones(4), 0.5).shape == (3, 4)
    with pytest.raises(ValueError, match="shapes do not broadcast: v"):
        body_restitution(np.ones(3), np.ones(2), 1.0)


@pytest.mark.parametrize(
    ("arguments", "error", "name"),
    [
        ((-1.0, 1.0, 1.0), ValueError, "v must be"),
        ((1.0, 0.0, 1.0), ValueError, "k must be"),
        ((1.0, 1.0, np.nan), ValueError, "p must be"),
        (("1", 1.0, 1.0), TypeError, "v must be"),
    ],
)
def test_bad_arguments_are_named(arguments, error, name):
    with pytest.raises(error, match=name):
        body_restitution(*arguments)
