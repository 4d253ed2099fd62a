"""Verdicts on claims: from numbers and criteria, with every way in which numbers can be wrong."""

import pandas as pd
import pytest

from microimpact.ledgers.claims import LedgerError, judge, verdict, verdicts
from microimpact.ledgers.criteria import Claim
from microimpact.parameters import build


def claim(**changes):
    entry = {
        "id": "C01",
        "where": "2",
        "statement": "s",
        "kind": "model",
        "article_value": "0.7",
        "unit": "-",
        "quantities": {"e": "-", "v": "m/s"},
        "criteria": [{"quantity": "e", "test": "within", "value": 0.7, "tolerance": 0.05}],
        "reason": "because",
        "verdicts": ["reproduced", "not reproduced"],
        "break": {"change": "x", "expect": "not reproduced"},
    }
    return build(Claim, entry | changes)


def numbers(*rows):
    columns = ["claim", "case", "quantity", "value", "unit", "evidence"]
    return pd.DataFrame([(*row, "computed") for row in rows], columns=columns)


GOOD = (("C01", "", "e", 0.72, "-"), ("C01", "", "v", 1.0, "m/s"))
TWO = {"cases": ["a", "b"], "verdicts": ["reproduced", "not reproduced", "not identified"]}
CONDITION = [{"quantity": "v", "test": "at_least", "value": 0.5}]


@pytest.mark.parametrize(
    ("changes", "values", "expected"),
    [
        ({}, {"": {"e": 0.75, "v": 1.0}}, "reproduced"),
        ({}, {"": {"e": 0.76, "v": 1.0}}, "not reproduced"),
        (TWO, {"a": {"e": 0.7, "v": 1.0}, "b": {"e": 0.7, "v": 1.0}}, "reproduced"),
        (TWO, {"a": {"e": 0.7, "v": 1.0}, "b": {"e": 0.1, "v": 1.0}}, "not identified"),
        (TWO, {"a": {"e": 0.9, "v": 1.0}, "b": {"e": 0.1, "v": 1.0}}, "not reproduced"),
        (
            TWO | {"cases": [], "identified_if": CONDITION},
            {"": {"e": 0.1, "v": 0.4}},
            "not identified",
        ),
        (
            TWO | {"cases": [], "identified_if": CONDITION},
            {"": {"e": 0.1, "v": 0.6}},
            "not reproduced",
        ),
        (
            {"verdicts": ["calibrated", "not reproduced"]},
            {"": {"e": 0.7, "v": 1.0}},
            "calibrated",
        ),
    ],
)
def test_verdict_follows_from_criteria_and_cases(changes, values, expected):
    assert verdict(claim(**changes), values)[0] == expected


def test_the_row_tells_numbers_criterion_and_what_failed():
    row = verdicts({"C01": claim()}, numbers(("C01", "", "e", 0.8, "-"), GOOD[1])).iloc[0]
    assert row["computed_value"] == "e = 0.8; v = 1 m/s"
    assert row["criterion"] == "e 0.7 within 0.05"
    assert row["note"] == "e = 0.8 is not 0.7 within 0.05"
    assert row["verdict"] == "not reproduced"


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        (GOOD[:1], r"C01: v is missing"),
        ((*GOOD, ("C01", "", "w", 1.0, "-")), r"C01: w is not declared"),
        ((*GOOD, ("C02", "", "e", 1.0, "-")), r"C02: no such claim.*C01"),
        ((GOOD[0], ("C01", "", "v", 1.0, "mm/s")), r"C01: v in mm/s, not m/s"),
        ((GOOD[0], ("C01", "", "v", float("inf"), "m/s")), r"C01: v = inf must be finite"),
        ((*GOOD, GOOD[0]), r"C01: a number is given twice"),
        ((GOOD[0], ("C01", "n = 0", "v", 1.0, "m/s")), r"v \(n = 0\) is not declared"),
    ],
)
def test_numbers_that_do_not_fit_are_refused(rows, words):
    with pytest.raises(LedgerError, match=words):
        verdicts({"C01": claim()}, numbers(*rows))


def test_a_claim_that_is_not_testable_needs_no_numbers():
    untestable = claim(quantities={}, criteria=[], verdicts=["not testable"], **{"break": None})
    other = claim(id="C02")
    rows = numbers(*((("C02", *row[1:])) for row in GOOD))
    table = verdicts({"C01": untestable, "C02": other}, rows)
    assert list(table["verdict"]) == ["not testable", "reproduced"]


def test_tables_of_groups_are_judged_together(tmp_path):
    path = tmp_path / "claims.yaml"
    path.write_text(
        """
C01:
  where: "2"
  statement: s
  kind: model
  article_value: "0.7"
  unit: "-"
  quantities: {e: "-"}
  criteria: [{quantity: e, test: at_least, value: 0.5}]
  reason: r
  verdicts: [reproduced, not reproduced]
  break: {change: x, expect: not reproduced}
"""
    )
    table = judge({"a": numbers(GOOD[0]), "b": numbers()}, path)
    assert list(table["verdict"]) == ["reproduced"]
