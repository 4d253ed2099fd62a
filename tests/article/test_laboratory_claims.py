"""Numbers behind the claims on measurements: complete, in their units, and breakable."""

from __future__ import annotations

import numpy as np
import pytest
from tests.article.claim_worlds import (
    require_changed_verdict,
    require_code,
    require_complete,
    verdict_of,
)
from tests.article.laboratory_claims_breaks import (
    BREAKS,
    MUTE,
    World,
    coverage,
    pairing,
    pile_up,
    ptis_range,
)

from microimpact.studies.claims.laboratory_claims import CLAIMS


@pytest.fixture(scope="module")
def tables(run_study, settings, shipped_calibration):
    """Return the tables of earlier studies, some of smaller ones."""
    made = dict(shipped_calibration)
    made |= run_study("mechanisms", made)
    with pytest.MonkeyPatch.context() as patch:
        world = World(run_study, settings, made, patch)
        made |= ptis_range(world) | pairing(world, 0.5, 2.0)
        made |= coverage(world) | pile_up(world, 5.0)
    return made


@pytest.fixture(scope="module")
def numbers(run_study, tables):
    return run_study("laboratory_claims", tables)["laboratory_claims"]


@pytest.fixture
def world(run_study, settings, tables, monkeypatch):
    return World(run_study, settings, tables, monkeypatch)


def test_every_number_of_every_claim_is_there_in_its_unit(claims, numbers, settings):
    wanted = settings.branches["laboratory_claims"]["claims"]
    assert set(wanted) == set(CLAIMS)
    require_complete(claims, numbers, wanted)
    require_code(numbers)


@pytest.mark.parametrize("name", [name for name in BREAKS if name not in MUTE])
def test_breaking_a_claim_changes_its_verdict(name, claims, numbers, world):
    require_changed_verdict(claims, name, numbers, BREAKS[name](name, world))


@pytest.mark.parametrize("name", MUTE)
def test_a_mute_break_finds_the_verdict_that_stands_already(name, claims, numbers, world):
    expected = claims[name].break_.expect
    broken = BREAKS[name](name, world)
    assert verdict_of(claims, name, numbers) == expected
    assert verdict_of(claims, name, broken) == expected
    own = numbers[numbers["claim"] == name]
    assert not np.array_equal(own["value"].to_numpy(), broken["value"].to_numpy())


def test_every_claim_has_its_break():
    assert set(BREAKS) == set(CLAIMS)
    assert set(MUTE) <= set(BREAKS)


def test_an_unknown_claim_is_refused(run_study, tables):
    with pytest.raises(ValueError, match=r"laboratory_claims\.claims: no claim 'C90' here"):
        run_study("laboratory_claims", tables, claims=["C90"])
