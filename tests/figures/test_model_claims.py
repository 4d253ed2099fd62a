"""Numbers behind the claims on the models: complete, in their units, and breakable."""

from __future__ import annotations

import numpy as np
import pytest
from tests.figures.conftest import ROOT
from tests.figures.model_claims_breaks import (
    BREAKS,
    MUTE,
    WITHOUT_EFFECT,
    World,
    calibration,
    steel_fits,
)

from microimpact.ledgers.claims import NUMBER_COLUMNS, verdicts
from microimpact.ledgers.criteria import read_claims
from microimpact.studies import _model_claims_tables as from_tables
from microimpact.studies.model_claims import CLAIMS


@pytest.fixture(scope="module")
def claims():
    return read_claims(ROOT / "config/claims.yaml")


@pytest.fixture(scope="module")
def tables(run_study, settings):
    """Return the tables of earlier studies."""
    made = calibration(run_study, settings) | run_study("force_history")
    made |= run_study("rolling_dissipation", made, points=5)
    made |= run_study("restitution_fits", made, cases=steel_fits(settings))
    return made


@pytest.fixture(scope="module")
def numbers(run_study, tables):
    return run_study("model_claims", tables)["model_claims"]


@pytest.fixture(scope="module")
def value(numbers):
    """Return a function that gives the numbers of one quantity, in order of its cases."""

    def of(claim, quantity):
        own = (numbers["claim"] == claim) & (numbers["quantity"] == quantity)
        return numbers.loc[own, "value"].to_numpy(float)

    return of


@pytest.fixture
def world(run_study, settings, tables, monkeypatch):
    return World(run_study, settings, tables, monkeypatch)


def verdict_of(claims, name, numbers):
    found = verdicts({name: claims[name]}, numbers[numbers["claim"] == name])
    return found["verdict"].iloc[0]


def test_every_number_of_every_claim_is_there_in_its_unit(claims, numbers, settings):
    assert list(numbers.columns) == list(NUMBER_COLUMNS)
    wanted = settings.branches["model_claims"]["claims"]
    assert set(wanted) == set(CLAIMS)
    # verdicts refuses a number that is missing, not finite, twice there or of another unit
    verdicts({name: claims[name] for name in wanted}, numbers)


def test_numbers_are_called_calibrated_where_agreement_is_no_evidence(claims, numbers):
    for name, evidence in numbers.groupby("claim")["evidence"]:
        assert (set(evidence) == {"calibrated"}) == (claims[name].positive == "calibrated")


@pytest.mark.parametrize("name", [name for name in BREAKS if name not in MUTE | WITHOUT_EFFECT])
def test_breaking_a_claim_changes_its_verdict(name, claims, numbers, world):
    expected = claims[name].break_.expect
    assert verdict_of(claims, name, numbers) != expected
    assert verdict_of(claims, name, BREAKS[name](name, world)) == expected


@pytest.mark.parametrize("name", MUTE)
def test_a_mute_break_finds_the_verdict_that_stands_already(name, claims, numbers, world):
    expected = claims[name].break_.expect
    broken = BREAKS[name](name, world)
    assert verdict_of(claims, name, numbers) == expected
    assert verdict_of(claims, name, broken) == expected
    own = numbers[numbers["claim"] == name]
    assert not np.allclose(own["value"].to_numpy(), broken["value"].to_numpy(), rtol=0.1)


@pytest.mark.parametrize("name", WITHOUT_EFFECT)
def test_a_break_without_effect_leaves_the_verdict(name, claims, numbers, world):
    found = verdict_of(claims, name, numbers)
    broken = BREAKS[name](name, world)
    assert found not in {claims[name].break_.expect, "not identified"}
    assert verdict_of(claims, name, broken) == found
    own = numbers[numbers["claim"] == name]
    assert not own["value"].reset_index(drop=True).equals(broken["value"])


def test_the_couple_of_steady_rolling_could_not_be_neglected(claims, numbers, world):
    """C42 can fail: by what rolls steadily in place of what arises in an impact."""
    world.patch.setattr(from_tables, "COUPLES", ("steady_over_friction",))
    assert verdict_of(claims, "C42", numbers) == "reproduced"
    assert verdict_of(claims, "C42", world.numbers("C42")) == "not reproduced"


def test_every_claim_has_its_break():
    assert set(BREAKS) == set(CLAIMS)
    assert set(MUTE) | set(WITHOUT_EFFECT) <= set(BREAKS)


def test_an_unknown_claim_is_refused(run_study, tables):
    with pytest.raises(ValueError, match=r"model_claims\.claims: no claim 'C01' here"):
        run_study("model_claims", tables, claims=["C01"])
