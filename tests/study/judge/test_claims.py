"""Verdicts on claims: from numbers and criteria, with every way in which numbers can be wrong."""

import math

import numpy as np
import pandas as pd
import pytest

from study.claims.claim import NUMBER_COLUMNS, Claim, Number
from study.judge import COLUMNS, LedgerError, judge, verdicts
from study.judge.criteria import ClaimsError, declared_claims
from study.judge.independent import AGREES, DISAGREES, SPLIT, agreements, independent
from study.judge.judging import RESULT_COLUMNS
from study.judge.words import agreement
from study.tables import NotComputedError

WORDS = {"where": "2", "quote": "q", "article": "0.7", "reason": "because"}
NEAR, SPEED = Number(within=(0.7, 0.05)), Number(unit="m/s")


def claim(name="C01", **changes):
    return Claim(name, "s", **{**WORDS, "numbers": {"e": NEAR, "v": SPEED}, **changes})


def numbers(*rows):
    """Rows of claim, case, quantity and value, and maybe the standard error."""
    whole = [(*(*row, math.nan)[:5], "study.c", "t u", "") for row in rows]
    return pd.DataFrame(whole, columns=NUMBER_COLUMNS)


def ledger_of(rows, **changes):
    """The row and the results of one claim, changed, from its numbers."""
    table, results = verdicts({"C01": claim(**changes)}, numbers(*rows))
    return table.iloc[0], results


def cases(*values, error=math.nan):
    """Numbers of e, one per case a, b, ..., and of v."""
    names = "ab"[: len(values)] if len(values) > 1 else [""]
    return [
        row
        for name, e in zip(names, values, strict=True)
        for row in (("C01", name, "e", e, error), ("C01", name, "v", 1.0))
    ]


GOOD = cases(0.72)
TWO = {"cases": ("a", "b")}


def condition(bound):
    return {"numbers": {"e": NEAR, "v": Number(unit="m/s", at_least=bound, identifies=True)}}


@pytest.mark.parametrize(
    ("changes", "values", "expected"),
    [
        ({}, [0.75], "reproduced"),
        ({}, [0.76], "not reproduced"),
        (TWO, [0.7, 0.7], "reproduced"),
        (TWO, [0.7, 0.1], "not identified"),
        (TWO, [0.9, 0.1], "not reproduced"),
        (condition(1.1), [0.1], "not identified"),
        (condition(0.9), [0.1], "not reproduced"),
        ({"if_met": "calibrated"}, [0.7], "calibrated"),
    ],
)
def test_verdict_follows_from_criteria_and_cases(changes, values, expected):
    assert ledger_of(cases(*values), **changes)[0]["verdict"] == expected


@pytest.mark.parametrize(
    ("values", "expected", "margin"),
    [
        # bounds 0.65 and 0.75, a standard error of 0.01: 1.96 of them cover the bound or not
        ([0.70], "reproduced", 5.0),
        ([0.731], "undecided", 1.9),
        ([0.769], "undecided", -1.9),
        ([0.770], "not reproduced", -2.0),
        ([0.70, 0.74], "undecided", 1.0),
        ([0.70, 0.90], "not identified", 5.0),
    ],
)
def test_a_bound_that_the_error_covers_is_not_decided(values, expected, margin):
    changes = TWO if len(values) > 1 else {}
    row, _ = ledger_of(cases(*values, error=0.01), **changes)
    assert row["verdict"] == expected
    assert row["margin"] == pytest.approx(margin)


def test_the_worst_criterion_of_a_case_gives_its_margin_and_exact_numbers_none():
    bounds = {"e": Number(at_least=0.5), "v": Number(at_most=0.5)}
    rows = [("C01", "", "e", 0.51, 0.01), ("C01", "", "v", 1.0, 0.1)]
    assert ledger_of(rows, numbers=bounds)[0]["margin"] == pytest.approx(-5.0)
    assert np.isnan(ledger_of(GOOD)[0]["margin"])


def test_a_result_tells_number_bound_and_whether_it_passed():
    row, results = ledger_of(cases(0.8))
    assert set(COLUMNS) == set(row.index)
    e, v = results
    assert set(e) == set(v) == set(RESULT_COLUMNS)
    assert (e["quantity"], e["value"], e["test"], e["passed"]) == ("e", 0.8, "within", False)
    assert (e["low"], e["high"]) == (0.65, 0.75)
    assert (v["test"], v["unit"], v["passed"]) == ("", "m/s", None)
    assert (row["code"], row["inputs"]) == ("study.c", "t u")
    assert row["sentence"] == "E is 0.8 (required: 0.7 ± 0.05)."


SAYS = "restitution is {e}, and {e:bound} is accepted; the speed is {v}."


@pytest.mark.parametrize(
    ("rows", "changes", "sentence"),
    [
        (GOOD, {}, "Restitution is 0.72, and 0.7 ± 0.05 is accepted; the speed is 1 m/s."),
        (
            cases(0.7, 0.1),
            TWO,
            "Restitution is 0.1 to 0.7, and 0.7 ± 0.05 is accepted; the speed is 1 m/s.",
        ),
        (
            cases(0.731, error=0.01),
            {"says": "Of the speed {e:%} is left; {e:bound %} is accepted."},
            "Of the speed 73.1 % is left; 70 ± 5 % is accepted."
            " The sampling error covers what would decide.",
        ),
        (
            cases(0.1),
            {"assumed": "the friction"},
            "Restitution is 0.1, and 0.7 ± 0.05 is accepted; the speed is 1 m/s."
            " Inputs that decide are assumed: the friction.",
        ),
    ],
)
def test_a_sentence_tells_the_number_that_is_judged_its_bound_and_why_it_is_open(
    rows, changes, sentence
):
    row, _ = ledger_of(rows, **{"says": SAYS} | changes)
    assert row["sentence"] == sentence


@pytest.mark.parametrize("says", ["The speed is {v}.", "Restitution is {e}, and {w}."])
def test_a_sentence_that_leaves_out_the_number_that_is_judged_is_refused(says):
    with pytest.raises(ValueError, match=r"C01.*must tell all of e"):
        claim(says=says)


def test_every_claim_with_numbers_has_a_sentence():
    claims = declared_claims().values()
    assert [each.id for each in claims if each.testable and not each.says] == []


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        (GOOD[:1], r"C01: v is missing"),
        ((*GOOD, ("C01", "", "w", 1.0)), r"C01: w is not declared"),
        ((GOOD[0], ("C01", "", "v", math.inf)), r"C01: v must be finite"),
        ((*GOOD, GOOD[0]), r"C01: e is there twice"),
        ((GOOD[0], ("C01", "n = 0", "v", 1.0)), r"v \(n = 0\) is not declared"),
    ],
)
def test_numbers_that_do_not_fit_are_refused(rows, words):
    with pytest.raises(LedgerError, match=words):
        verdicts({"C01": claim()}, numbers(*rows))


def test_a_claim_that_could_not_be_computed_says_why_and_leaves_the_others_alone():
    whole = numbers(*cases(0.7, 0.7)[:2])
    lacking = ("C01", "b", "not computed", *[math.nan] * 2, None, "", "No plateau")
    second = numbers(*(("C02", *row[1:]) for row in GOOD))
    table = pd.concat([whole, pd.DataFrame([lacking], columns=NUMBER_COLUMNS), second])
    ledger, _ = verdicts({"C01": claim(**TWO), "C02": claim("C02")}, table)
    assert list(ledger["verdict"]) == ["not computed", "reproduced"]
    assert ledger["sentence"][0] == "b: No plateau"
    assert ledger["computed_value"][0] == "e (a) = 0.7; v (a) = 1 m/s"


def test_claims_facts_and_amendments_make_the_ledger(one):
    none = pd.DataFrame(columns=["claim", "alternative"])
    tables = {"claim_numbers": numbers(GOOD[0])}
    tables |= {"claim_draws": none, "posterior_contacts": pd.DataFrame()}
    row = ("falls", "silver", "agrees with independent data")
    tables["external_evidence"] = pd.DataFrame([row], columns=["fact", "contact", "agreement"])
    ledger = judge(tables)
    assert list(ledger["claims"]["verdict"]) == ["reproduced"]
    assert list(ledger["claims"]["independent"]) == ["agrees with independent data"]
    assert ledger["claim_evidence"].to_dict("records") == [
        {"id": "C01", "fact": "falls", "agreeing": "silver", "disagreeing": ""}
    ]
    assert list(ledger["claim_amendments"].iloc[0]) == ["C01", "criteria", "a", "b", "c"]


# Facts found by others

FACTS = pd.DataFrame(
    [
        ("falls with size", "a", AGREES),
        ("falls with size", "b", DISAGREES),
        ("no target", "a", AGREES),
        ("half is lost", "b", DISAGREES),
        ("never computed", "b", "not computed"),
    ],
    columns=["fact", "contact", "agreement"],
)


@pytest.mark.parametrize(
    ("facts", "expected", "words"),
    [
        (["no target"], AGREES, ["no target: yes for a"]),
        (["half is lost"], DISAGREES, ["half is lost: no for b"]),
        (["falls with size"], SPLIT, ["falls with size: yes for a; no for b"]),
        (["never computed"], None, []),
        ([], None, []),
    ],
)
def test_what_independent_data_say(facts, expected, words):
    evidence = independent({"C01": claim(external=tuple(facts))}, FACTS)
    assert agreements(evidence).get("C01") == expected
    assert list(map(agreement, evidence.to_dict("records"))) == words


def test_a_fact_that_nobody_found_is_refused():
    with pytest.raises(ClaimsError, match=r"C01.external: 'no targt' .* 'no target'"):
        independent({"C01": claim(external=("no targt",))}, FACTS)


def test_without_drawn_contacts_claims_on_them_are_not_judged_by_the_calibrated(monkeypatch):
    class Lacking(dict):
        def __missing__(self, name):
            raise NotComputedError("no contact is admitted")

    claims = {"C01": claim(), "C02": claim("C02", by_contact=True)}
    monkeypatch.setattr("study.judge.declared_claims", lambda values: claims)
    both = numbers(*GOOD, *(("C02", *row[1:]) for row in GOOD))
    ledger = judge(Lacking(claim_numbers=both, external_evidence=None))["claims"].set_index("id")
    assert ledger["verdict"].to_dict() == {"C01": "reproduced", "C02": "not computed"}
    assert ledger.loc["C02", "sentence"] == "no contact is admitted"
