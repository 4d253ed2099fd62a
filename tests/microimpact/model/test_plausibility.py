"""Doubts about impacts, by numbers that are known otherwise."""

from __future__ import annotations

import re

import numpy as np
import pytest

from microimpact.model.closed_forms import contact_modulus, yield_velocity
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.plausibility import doubts


@pytest.fixture
def bare(contact):
    return contact.replace(work_of_adhesion=0.0, hertz_damping=0.0)


def pressures(*arguments):
    words = " ".join(doubts(*arguments))
    return [float(number) for number in re.findall(r"pressure, (\S+) Pa", words)]


def test_the_pressure_is_that_of_hertz_in_the_middle(bare):
    """p_0 = 2 E* a/(pi R)."""
    depth = 0.02 * bare.radius
    expected = 2 / np.pi * contact_modulus(bare) * np.sqrt(depth * bare.radius) / bare.radius
    assert pressures(bare, depth) == pytest.approx([expected], rel=5e-3)


@pytest.mark.parametrize(("over", "doubted"), [(0.98, False), (1.02, True)])
def test_it_yields_above_the_yield_velocity(bare, over, doubted):
    speed = over * float(yield_velocity(bare, 0.3e9))
    depth = normal_impact(bare, speed).maximum_compression
    assert bool(pressures(bare, depth, 0.3e9)) == doubted
