"""The declared claims: complete, consistent, and each criterion sharp at its boundary."""

from __future__ import annotations

import dataclasses
import math
import re

import pytest
from tests.shared import settings_as_shipped
from tests.study.claims.breaks import BREAKS, read_breaks

from study.claims.claim import CLAIMS, Claim, Number
from study.declared.documents import ConfigError
from study.equations import EQUATIONS
from study.figures.declaration import all_figures
from study.judge import amendments
from study.judge.criteria import declared_claims

DECLARED = declared_claims()
BRANCH = settings_as_shipped().branches["claim_numbers"]
CONTROLS = read_breaks()


def holds(number, value):
    return number.distance(value) >= 0.0


# Claims as a whole


def test_claims_ascend_and_quote_a_few_words_of_the_article():
    numbers = sorted(int(name.removeprefix("C")) for name in DECLARED)
    assert list(DECLARED) == [f"C{number:02d}" for number in numbers]
    assert all(name == claim.id for name, claim in DECLARED.items())
    assert all(len(claim.quote.split()) <= 15 for claim in DECLARED.values())


@pytest.mark.parametrize("name", DECLARED)
def test_a_claim_is_complete(name):
    claim = DECLARED[name]
    assert all((claim.statement, claim.where, claim.quote, claim.article, claim.reason))
    assert bool(claim.function) == bool(claim.numbers) == claim.testable
    assert len(claim.cases) != 1, "one case alone is no alternative"
    assert set(claim.figures.split()) <= set(all_figures())
    assert set(claim.equations.split()) <= set(EQUATIONS)
    assert all(re.fullmatch(r"[a-z]\w*", number) for number in claim.numbers)


def test_a_function_is_that_of_one_claim():
    name, claim = next(iter(CLAIMS.items()))
    with pytest.raises(ValueError, match=f"claim '{name}' has a function already"):
        Claim(name, "s", where="2", article="a", reason="r")(claim.function)


@pytest.mark.parametrize("name", [name for name, claim in DECLARED.items() if claim.testable])
def test_a_claim_has_a_break_with_a_verdict_that_it_can_get(name):
    claim, control = DECLARED[name], CONTROLS[name]
    possible = {claim.if_met, "not reproduced"}
    if claim.cases or claim.identified_if or claim.by_contact or claim.assumed:
        possible.add("not identified")
    assert control.change
    assert control.expect in possible
    assert control.is_data != (name in BREAKS)


def test_calibrated_claims_are_those_named_beforehand():
    # a number that fixed a parameter proves nothing
    fixed = "C05 C08 C28 C31 C33 C35 C36 C51 C52 C81 C86 C94 C96"
    assert all(DECLARED[key].if_met == "calibrated" for key in fixed.split())


def test_a_misprinted_equation_is_named_where_it_decides():
    # a corrected equation must be undone by its printed form, which then fails
    for name, claim in DECLARED.items():
        if claim.if_met == "reproduced with a correction":
            assert CONTROLS[name].expect == "not reproduced"
            assert "printed" in CONTROLS[name].change


def test_an_amendment_says_what_the_claim_says_now():
    rows = amendments()
    assert {row["id"] for row in rows} <= set(DECLARED)
    latest = {(row["id"], row["part"]): row["now"] for row in rows}
    for name, claim in DECLARED.items():
        assert latest.get((name, "statement"), claim.statement).startswith(claim.statement)
        if name in CONTROLS:
            change = CONTROLS[name].change
            assert latest.get((name, "break"), change).startswith(change)


# Words


def test_a_changed_value_changes_the_reasons_that_tell_it():
    here, there = (declared_claims(values) for values in (BRANCH, doubled(BRANCH)))
    for name, claim in DECLARED.items():
        assert (here[name].reason != there[name].reason) == ("[[" in claim.reason)
        assert "[[" not in here[name].reason
    labels = (of["C16"].labels["captured_share"] for of in (here, there))
    assert list(labels) == ["captured share below 0.2 m/s", "captured share below 0.4 m/s"]
    with pytest.raises(ConfigError, match=r"C04\.\S+: no parameter 'speed_m_per_s'"):
        declared_claims(BRANCH | {"C04": {}})


def doubled(node):
    if isinstance(node, dict):
        return {key: doubled(child) for key, child in node.items()}
    if isinstance(node, list):
        return [doubled(child) for child in node]
    return 2 * node if isinstance(node, int | float) else node


# Bounds


@pytest.mark.parametrize(
    ("bounds", "accepted", "refused"),
    [
        ({"within": (0.70, 0.005)}, [0.695, 0.705], [0.694999, 0.7051]),
        ({"at_least": 0.1}, [0.1, 1e9], [0.0999999, -1e9]),
        ({"at_most": -0.001}, [-0.001, -1e9], [-0.0009999, 1e9]),
        ({"at_least": 0.18, "at_most": 0.33}, [0.18, 0.33], [0.1799999, 0.3300001]),
    ],
)
def test_boundaries_are_sharp_and_belong_to_the_accepted_side(bounds, accepted, refused):
    number = Number(**bounds)
    assert number.is_tested
    assert all(holds(number, value) for value in accepted)
    assert not any(holds(number, value) for value in (*refused, math.nan))


def test_boundaries_are_those_of_the_decimals_as_written():
    # 0.1 + 0.2 is not 0.3 and 0.3 - 0.1 is not 0.2 in binary
    number = Number(within=(0.1, 0.2))
    assert number.interval == (-0.1, 0.3)
    assert not holds(number, math.nextafter(0.3, 1.0))
    assert holds(Number(within=(0.3, 0.1)), 0.2)


@pytest.mark.parametrize(
    ("bounds", "message"),
    [
        ({"within": (1.0, 0.1), "at_most": 1.0}, "within stands alone"),
        ({"at_least": 1.0, "at_most": 1.0}, "at_least 1.0 must be below at_most 1.0"),
    ],
)
def test_bounds_that_leave_nothing_or_say_it_twice_are_refused(bounds, message):
    with pytest.raises(ValueError, match=message):
        Number(**bounds)


def test_numbers_that_identify_stand_before_the_criteria():
    numbers = {
        "plain": Number(),
        "e": Number(at_most=1.0),
        "v": Number(at_least=1, identifies=True),
    }
    claim = dataclasses.replace(DECLARED["C01"], numbers=numbers, says="")
    assert list(claim.tests) == ["v", "e"]
    assert list(claim.criteria) == ["e"]
    assert list(claim.identified_if) == ["v"]
