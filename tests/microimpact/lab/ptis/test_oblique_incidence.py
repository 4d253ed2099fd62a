"""Oblique experiments: what is counted, and that nothing depends on chunks or on other events."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.microimpact.lab.ptis.imaging_cases import (
    INSTRUMENT,
    generator,
    impacts,
    modelled_events,
    setup_for,
)
from tests.shared import USUAL

from microimpact.lab.dispenser import NO_SPIN
from microimpact.lab.experiment import Drop, StopRule, Target
from microimpact.lab.ptis.errors import theory
from microimpact.lab.ptis.experiment import OUTSIDE_CLASS, collect, turned
from microimpact.lab.ptis.exposure import MEASURED, exposures
from microimpact.lab.ptis.system import Systematics, event_generator
from microimpact.lab.ptis.tracks import longest_runs
from microimpact.lab.surface import rough
from microimpact.statistics.distributions import TruncatedNormal


@pytest.fixture
def drop(contact):
    return Drop(
        target=Target(contact=contact, surface=rough(0.1)),
        diameter_um=TruncatedNormal(mean=62.0, sd=4.5, low=45.0, high=76.0),
        angle=60.0,
        speed=1.66,
        speed_range=(1.6, 1.72),
        dispenser=USUAL,
        spin=NO_SPIN,
    )


def until(events, most_dropped):
    return StopRule(events=events, fewest_events=2, most_dropped=most_dropped)


def same(a, b):
    names = type(a).__dataclass_fields__
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in names)


def test_all_particles_have_a_fate_and_the_last_one_is_the_last_event(drop):
    found = collect(replace(drop, angle=30.0), INSTRUMENT, until(40, 8000), generator(1))
    assert len(found.measured) == 40
    fates = dict(found.fates)
    outside = fates.pop(OUTSIDE_CLASS)
    assert sum(fates.values()) == found.dropped
    assert fates[MEASURED] == 40 + outside
    assert found.measured.event[-1] == len(found.impacts) - 1
    assert np.all(np.diff(found.measured.event) > 0)
    assert found.first == len(found.impacts)


def test_an_experiment_without_events_is_given_up(drop):
    never = replace(drop, speed_range=(0.01, 0.02))
    found = collect(never, INSTRUMENT, until(5, 500), generator(1))
    assert len(found.measured) == 0
    assert found.dropped == 500
    assert found.fates[OUTSIDE_CLASS] == found.fates[MEASURED] > 0


def test_impacts_lit_together_are_lit_as_each_by_itself():
    n, errors = 6, Systematics(rate=0.003, scale=-0.004, angle_deg=0.2)
    events, setup = impacts(0.45, 45.0, n, seed=4), setup_for(0.45, 45.0)

    def draws():
        return [event_generator(generator(2), i) for i in range(n)]

    together = exposures(events, setup, errors, draws())
    for i, rng in enumerate(draws()):
        own = exposures(events.select(slice(i, i + 1)), setup, errors, [rng])
        picked = together.select(np.array([i]))
        for name in (
            "leg",
            "start",
            "end",
            "whole",
            "in_sheet",
            "in_view",
            "in_field",
            "peak",
            "diameter",
        ):
            assert np.array_equal(getattr(picked, name), getattr(own, name)), name
        assert same(picked.flight, own.flight)
    one, alone = (theory(events.select(which), setup, errors, draws()[:k])
                  for which, k in ((slice(n), n), (slice(1), 1)))  # fmt: skip
    assert one[0][0] == alone[0][0]
    if alone[0][0] == MEASURED:
        assert one[1].velocities[0] == pytest.approx(alone[1].velocities[0], rel=1e-12)


def test_shared_errors_stretch_and_turn_what_is_measured():
    """The repetitions of `interval_coverage` rest on this."""
    events, setup = impacts(1.66, 45.0, 40), setup_for(1.66, 45.0)
    errors = Systematics(rate=0.01, scale=-0.02, angle_deg=0.5)
    right, wrong = modelled_events(events, setup), modelled_events(events, setup, errors)
    right, wrong = right.measured, wrong.measured
    common, a, b = np.intersect1d(right.event, wrong.event, return_indices=True)
    assert common.size > 20
    stretch = 1.0 / (1.01 * 0.98)
    expected = turned(right.select(a), 0.5)
    found = wrong.select(b).velocities / stretch
    assert found == pytest.approx(expected.velocities, abs=6e-3)


def test_longest_stretch_of_each_group():
    good = np.array([1, 1, 0, 1, 1, 1, 1, 0, 0, 1, 0, 1], dtype=bool)
    group = np.array([0, 0, 0, 0, 0, 2, 2, 2, 3, 4, 4, 4])
    start, number = longest_runs(good, group, 6)
    assert number.tolist() == [2, 0, 2, 0, 1, 0]
    # The first of two equally long ones; none begins at zero.
    assert start[[0, 2, 4]].tolist() == [0, 5, 9]
