"""Numbers behind the claims on the models: complete, in their units, and breakable."""

from __future__ import annotations

import pytest
from tests.article.claim_worlds import require_changed_verdict, require_code, require_complete
from tests.article.model_claims_breaks import (
    BREAKS,
    World,
    calibration,
    steel_fits,
)

from microimpact.studies.claims.model_claims import CLAIMS


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


def test_every_number_of_every_claim_is_there_in_its_unit(claims, numbers, settings):
    wanted = settings.branches["model_claims"]["claims"]
    assert set(wanted) == set(CLAIMS)
    require_complete(claims, numbers, wanted)
    require_code(numbers)


@pytest.mark.parametrize("name", BREAKS)
def test_breaking_a_claim_changes_its_verdict(name, claims, numbers, world):
    require_changed_verdict(claims, name, numbers, BREAKS[name](name, world))


def test_an_impact_rolls_too_little_for_the_couple_of_steady_rolling(value):
    """C42: hysteresis of rolling builds up over the contact's width; here it turns a part of it."""
    assert (value("C42", "largest_distance_rolled_over_contact_radius") < 0.2).all()
    impact, steady, bound = (
        value("C42", f"largest_{name}_over_friction_couple")
        for name in ("rolling_couple", "couple_of_steady_rolling", "bound_of_couple")
    )
    assert (impact < 0.1 * steady).all()
    assert (steady < bound).all()


def test_every_claim_has_its_break():
    assert set(BREAKS) == set(CLAIMS)


def test_an_unknown_claim_is_refused(run_study, tables):
    with pytest.raises(ValueError, match=r"model_claims\.claims: no claim 'C01' here"):
        run_study("model_claims", tables, claims=["C01"])
