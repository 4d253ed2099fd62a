"""Numbers behind the claims: complete, right where physics says so, and breakable one by one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from tests.shared import tables_made_once
from tests.study.claims.breaks import BREAKS, STEEL, World, judged_with, read_breaks

from microimpact.core.computable import NotComputable
from study import analyses
from study.analyses import claim_numbers
from study.analyses.claim_numbers import numbers_of
from study.claims.claim import CLAIMS, NUMBER_COLUMNS, ascending
from study.contacts import DRAWN, calibrated_contact
from study.declared.parameters import build
from study.declared.references import merged
from study.judge import verdicts
from study.judge.shares import shares
from study.tables import NOT_COMPUTED, parse_table

# All rest on tables that take long to make.
pytestmark = pytest.mark.slow

CONTROLS = read_breaks()
DATA = [name for name, control in CONTROLS.items() if control.is_data]
# Breaks whose verdict is found without them already, so that they show nothing.
MUTE = {"C84": "no cause tried turns the rise below 15 deg, of three error bars, into a fall"}
# So small that verdicts may be others: only what cannot be computed is looked at.
LEAST = {
    "sampling": {"impacts": 200},
    "series_impacts": 200,
    "C109": {"experiments": 2},
}


@pytest.fixture(scope="module")
def branch(settings):
    return settings.branches["claim_numbers"]


@pytest.fixture(scope="module")
def inputs(made, settings):
    """Declared rows and the tables of earlier studies."""
    rows = settings.rows["claim_numbers"]
    tables = {name: made(maker)[name] for name, maker in analyses.needs("claim_numbers").items()}
    return {key: parse_table(text) for key, text in rows.items()} | tables


@pytest.fixture(scope="module")
def tables(branch, inputs, tmp_path_factory):
    def make():
        return claim_numbers.run(build(claim_numbers.Params, branch), inputs)

    return tables_made_once(tmp_path_factory, "numbers of claims", make)


@pytest.fixture(scope="module")
def numbers(tables):
    return texts_filled(tables["claim_numbers"])


@pytest.fixture(scope="module")
def ledger(claims, numbers, tables, inputs):
    drawn = shares(claims, tables["claim_draws"], inputs["posterior_contacts"])
    return verdicts(claims, numbers, drawn)[0].set_index("id")


def texts_filled(table):
    """Return a table that was read from a file with empty cells of text as they were."""
    return table.assign(
        **{n: table[n].astype(object).fillna("") for n in ("case", "inputs", "problem")}
    )


@pytest.fixture(scope="module")
def value(numbers):
    """Return a function that gives the numbers of one quantity, in order of its cases."""

    def of(claim, quantity):
        own = (numbers["claim"] == claim) & (numbers["quantity"] == quantity)
        return numbers.loc[own, "value"].to_numpy(float)

    return of


@pytest.fixture
def world(run_study, settings, inputs, monkeypatch):
    return World(run_study, settings, inputs, monkeypatch)


def verdict_of(claims, name, numbers):
    """Return the verdict by the cases alone."""
    ledger, _ = verdicts({name: claims[name]}, numbers[numbers["claim"] == name])
    return ledger["verdict"].iloc[0]


def test_every_number_of_every_testable_claim_is_there(claims, numbers, ledger):
    assert list(numbers.columns) == list(NUMBER_COLUMNS)
    assert ascending() == [name for name, claim in claims.items() if claim.testable]
    assert (numbers["problem"] == "").all()
    # verdicts refuses a number that is missing, not finite or twice there
    assert list(ledger.index) == list(claims)


def test_a_claim_alone_has_the_numbers_it_has_among_all(branch, inputs, numbers):
    params = build(claim_numbers.Params, branch)
    for name in ("C19", "C60", "C97"):
        alone = numbers_of(name, params, inputs)
        among = numbers[numbers["claim"] == name].reset_index(drop=True)
        pd.testing.assert_frame_equal(again(alone), among, check_exact=True)


def again(table):
    """Return a table as it is read from its file."""
    return texts_filled(parse_table(table.to_csv(index=False)))


def test_a_draw_that_is_a_calibrated_contact_has_its_numbers(branch, inputs, numbers):
    contact = calibrated_contact(inputs, STEEL[1])
    row = {
        "case": "steel",
        "scenario": "v",
        "law": "l",
        "contact_law": "ring force",
        "draw": 3,
        "particle": contact.particle.name,
        "surface": contact.surface.name,
        "friction_basis": "compressive",
        **{name: float(getattr(contact, field)) for name, field in DRAWN.items()},
    }
    row |= {"diameter_um": 1e6 * row["diameter_um"], "friction": branch["steel"]["friction"]}
    names = ["C05", "C37", "C68"]
    draws = {"case": "steel", "scenarios": ["v"]}
    params = build(claim_numbers.Params, branch | {"draws": draws})
    drawn = {**inputs, "posterior_contacts": pd.DataFrame([row])}
    table = claim_numbers.draws_of(params, drawn, *names)
    assert set(table["claim"]) == set(names)
    own = numbers[numbers["case"].str.startswith(STEEL[1]) & numbers["claim"].isin(names)]
    assert table["value"].to_numpy() == pytest.approx(own["value"].to_numpy(), rel=1e-6)


# Breaks


def test_every_claim_has_a_break():
    assert sorted([*DATA, *BREAKS]) == sorted(ascending())


@pytest.mark.parametrize("name", [name for name in DATA if name not in MUTE])
def test_the_change_declared_with_a_claim_changes_its_verdict(name, claims, ledger):
    control = CONTROLS[name]
    assert ledger["verdict"][name] != control.expect
    assert judged_with(name, control).ledger["verdict"] == control.expect


@pytest.mark.parametrize("name", [name for name in BREAKS if name not in MUTE])
def test_a_wrong_form_changes_the_verdict(name, claims, numbers, world):
    expected = CONTROLS[name].expect
    assert verdict_of(claims, name, numbers) != expected
    assert verdict_of(claims, name, BREAKS[name](name, world)) == expected


@pytest.mark.parametrize("name", MUTE)
def test_a_mute_break_finds_the_verdict_that_stands_already(name, claims, numbers, world):
    control = CONTROLS[name]
    is_data = control.is_data
    broken = judged_with(name, control).numbers if is_data else BREAKS[name](name, world)
    assert verdict_of(claims, name, numbers) == control.expect
    assert verdict_of(claims, name, broken) == control.expect
    own = numbers[numbers["claim"] == name]
    assert not np.array_equal(own["value"].to_numpy(), broken["value"].to_numpy())


# Claims that cannot be computed


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_slow_impacts_leave_claims_not_computed_and_the_others_alone(
    branch, claims, inputs, numbers
):
    """At 0.01 m/s steel is captured: there is no plateau and no rebound."""
    slow = merged(branch, LEAST | {"steel": {"speed_m_per_s": 0.01}})
    table = claim_numbers.numbers(build(claim_numbers.Params, slow), inputs)["claim_numbers"]
    problems = table[table["problem"] != ""].groupby("claim")["problem"].first()
    assert {"C10", "C19", "C23"} <= set(problems.index)
    assert problems["C10"] == "steel.speed_m_per_s: at 0.01 it rebounds at no angle"
    assert set(table.loc[table["problem"] != "", "quantity"]) == {NOT_COMPUTED}
    ledger = verdicts(claims, table)[0].set_index("id")
    assert (ledger["verdict"] == NOT_COMPUTED).to_dict() == {
        name: name in problems.index for name in ledger.index
    }
    assert ledger["sentence"]["C10"].startswith(f"{STEEL[0]}: {problems['C10']}")
    # what rests on no speed is as it was
    same = again(table[table["claim"] == "C01"])
    pd.testing.assert_frame_equal(same, numbers[numbers["claim"] == "C01"], check_exact=True)


@pytest.mark.parametrize(
    ("numbers", "problem"),
    [
        (NotComputable("one\n  two"), "one two"),
        ({"v": np.nan}, "v = nan is not a finite number"),
    ],
)
def test_what_the_settings_forbid_is_told_in_one_line(numbers, problem, world):
    def function(context, **settings):
        if isinstance(numbers, Exception):
            raise numbers
        return numbers

    world.patch.setitem(CLAIMS, "C01", replace(CLAIMS["C01"], function=function))
    (row,) = world.numbers("C01").to_dict("records")
    assert (row["claim"], row["quantity"], row["problem"]) == ("C01", NOT_COMPUTED, problem)


# What physics says of some numbers


def test_an_impact_rolls_too_little_for_hysteresis(value):
    """C42: hysteresis of rolling builds up over the contact's width; here it turns a part of it."""
    assert (value("C42", "largest_distance_rolled_over_contact_radius") < 0.2).all()
    impact = value("C42", "largest_rolling_moment_over_friction_moment")
    assert (impact < 0.1 * value("C42", "largest_bound_of_moment_over_friction_moment")).all()


@pytest.mark.parametrize(
    ("claim", "quantity", "low", "high"),
    [
        # period of Hertz over the time scale of Eqs. 23 and 24: 3.2181
        ("C103", "ratio_of_expressions", 1.0 / 3.21815, 1.0 / 3.21805),
        # a facet cannot make energy: no measured restitution exceeds one over the sine
        ("C46", "measured_restitution", 0.70, 1.0 / np.sin(np.radians(10.0))),
        # friction by the net force gives no rise at shallow angles
        ("C69", "rise_of_impulse_ratio_net", 1.0 - 1e-12, 1.0 + 1e-12),
    ],
)
def test_numbers_are_what_physics_demands(value, claim, quantity, low, high):
    numbers = value(claim, quantity)
    assert ((numbers >= low) & (numbers <= high)).all()


def test_friction_by_the_hertz_force_gives_the_greatest_rise(value):
    compressive, hertz = (value("C69", f"rise_of_impulse_ratio{end}") for end in ("", "_hertz"))
    assert ((compressive > 1.0) & (compressive < hertz)).all()
