"""Plan of the campaign: blocks written out, counted, and refused where they do not agree."""

from __future__ import annotations

from dataclasses import replace

import pytest
from tests.shared import USUAL

from microimpact.lab.experiment import SpeedClass
from microimpact.statistics.distributions import Constant
from study.analyses.campaign.compute import (
    Block,
    Counts,
    SizeRange,
    check_counts,
    counts,
    expand,
)
from study.laboratory import DeclaredSurface

PARTICLES = {
    name: SizeRange(particle="steel", diameter_um=Constant(at=d), particle_slope=0.0, spin_sd=0.0)
    for name, d in (("small", 20.0), ("large", 70.0))
}
SURFACES = {
    name: DeclaredSurface(surface="silicon", surface_slope=s)
    for name, s in (("front", 0.0), ("back", 0.1))
}
CLASSES = {
    "middle": SpeedClass(speed_m_per_s=1.0, speed_range_m_per_s=(0.9, 1.1)),
    "fast": SpeedClass(speed_m_per_s=1.66, speed_range_m_per_s=(1.6, 1.72)),
}
ANGLES = 90.0, 45.0, 10.0
BLOCK = Block(
    particles=("small", "large"), surfaces=("front", "back"), case="any", speeds=("middle", "fast")
)
WANTED = Counts(experiments=24, diameter_ranges=2, surfaces=2, angles=3, speed_ranges=2)


def plan(*blocks):
    named = {str(number): block for number, block in enumerate(blocks)}
    return expand(named, PARTICLES, SURFACES, CLASSES, ANGLES)


def test_a_block_is_all_its_combinations():
    found = plan(BLOCK)
    assert counts(found) == WANTED
    assert len({one.title for one in found}) == 24
    check_counts(found, WANTED)


def test_random_draws_of_an_experiment_do_not_depend_on_its_place(contact):
    def key(one):
        return one.dropped(0.15).drop(contact, one.angle, USUAL).key

    alone = plan(replace(BLOCK, particles=("large",), angles_deg=(10.0,)))
    keys = {one.title: key(one) for one in plan(BLOCK)}
    assert len(set(keys.values())) == 24
    assert all(keys[one.title] == key(one) for one in alone)


def test_another_number_of_experiments_is_refused():
    fewer = plan(replace(BLOCK, angles_deg=(90.0, 45.0)))
    with pytest.raises(ValueError, match=r"^blocks: give 16 experiments, not 24; 2 angles, not 3"):
        check_counts(fewer, WANTED)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"particles": ("smal",)}, r"blocks\.1\.particles: 'smal' must be .* 'small'"),
        ({"surfaces": ("side",)}, r"blocks\.1\.surfaces: 'side' must be one of those declared"),
        ({"speeds": ("fats",)}, r"blocks\.1\.speeds: 'fats' must be .* 'fast'"),
        ({}, r"blocks\.1: small on front, 1 m/s, 90 deg: declared twice"),
    ],
)
def test_bad_blocks_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        plan(BLOCK, replace(BLOCK, **change))
