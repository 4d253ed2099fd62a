"""Verdicts on claims: from numbers and criteria, with every way in which numbers can be wrong."""

import numpy as np
import pandas as pd
import pytest

from microimpact.declared.parameters import build
from microimpact.ledgers.claims import COLUMNS, LedgerError, judge, verdict, verdicts
from microimpact.ledgers.claims.criteria import Claim
from microimpact.ledgers.claims.digitised import DigitisedCriteria, digitised_rows
from microimpact.studies.claims import NUMBER_COLUMNS


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
        "break": {"change": "x", "expect": "not reproduced"},
    }
    return build(Claim, entry | changes)


def numbers(*rows):
    """Rows of claim, case, quantity, value and unit, and maybe the standard error."""
    whole = [
        (
            *row[:4],
            row[5] if len(row) > 5 else float("nan"),
            row[4],
            "computed",
            "study.c",
            "t u",
            "",
        )
        for row in rows
    ]
    return pd.DataFrame(whole, columns=NUMBER_COLUMNS)


GOOD = (("C01", "", "e", 0.72, "-"), ("C01", "", "v", 1.0, "m/s"))
TWO = {"cases": ["a", "b"]}
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
        ({"if_met": "calibrated"}, {"": {"e": 0.7, "v": 1.0}}, "calibrated"),
    ],
)
def test_verdict_follows_from_criteria_and_cases(changes, values, expected):
    assert verdict(claim(**changes), values)[0] == expected


def test_the_row_tells_numbers_criterion_and_what_failed():
    row = verdicts({"C01": claim()}, numbers(("C01", "", "e", 0.8, "-"), GOOD[1])).iloc[0]
    assert row["computed_value"] == "e = 0.8; v = 1 m/s"
    assert row["criterion"] == "e 0.7 ± 0.05"
    assert row["note"] == "e = 0.8 (required: 0.7 ± 0.05)"
    assert row["verdict"] == "not reproduced"
    assert (row["code"], row["inputs"]) == ("study.c", "t u")


ONE_ERROR = {"": {"e": 0.01, "v": float("nan")}}


@pytest.mark.parametrize(
    ("e", "expected"),
    [
        # bounds 0.65 and 0.75, a standard error of 0.01: 1.96 of them cover the bound or not
        (0.70, "reproduced"),
        (0.731, "undecided"),
        (0.769, "undecided"),
        (0.770, "not reproduced"),
        (0.640, "undecided"),
        (0.630, "not reproduced"),
    ],
)
def test_a_bound_that_the_error_covers_is_not_decided(e, expected):
    found, words = verdict(claim(), {"": {"e": e, "v": 1.0}}, ONE_ERROR)
    assert found == expected
    assert (found == "undecided") == any("covers its bound" in line for line in words)


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        (0.70, 0.74, "undecided"),
        (0.90, 0.76, "undecided"),
        # one case that meets the criteria and one that does not leave nothing to the third
        (0.70, 0.90, "not identified"),
        (0.70, 0.70, "reproduced"),
    ],
)
def test_cases_with_errors(first, second, expected):
    values = {name: {"e": e, "v": 1.0} for name, e in (("a", first), ("b", second))}
    errors = dict.fromkeys(values, ONE_ERROR[""])
    assert verdict(claim(**TWO), values, errors)[0] == expected


@pytest.mark.parametrize(
    ("e", "error", "margin"), [(0.72, 0.01, 3.0), (0.78, 0.01, -3.0), (0.72, float("nan"), None)]
)
def test_the_margin_is_the_distance_to_the_bound_in_errors(e, error, margin):
    table = numbers(("C01", "", "e", e, "-", error), GOOD[1])
    found = verdicts({"C01": claim()}, table)["margin"].iloc[0]
    assert np.isnan(found) if margin is None else found == pytest.approx(margin)


def test_the_worst_criterion_of_a_case_gives_its_margin():
    criteria = [
        {"quantity": "e", "test": "at_least", "value": 0.5},
        {"quantity": "v", "test": "at_most", "value": 0.5},
    ]
    table = numbers(("C01", "", "e", 0.51, "-", 0.01), ("C01", "", "v", 1.0, "m/s", 0.1))
    assert verdicts({"C01": claim(criteria=criteria)}, table)["margin"].iloc[0] == pytest.approx(-5)


def test_the_row_has_the_columns_of_the_contract_and_the_code():
    contract = (
        *("id", "where", "statement", "criterion", "article_value", "computed_value", "unit"),
        *("verdict", "margin", "evidence", "note", "figures", "code"),
    )
    table = verdicts({"C01": claim()}, numbers(*GOOD))
    assert set(contract) <= set(COLUMNS) == set(table.columns)


def test_the_note_tells_what_was_amended():
    changes = [{"part": "criteria", "was": "a.", "now": "b", "reason": "c."}]
    row = verdicts({"C01": claim(amendments=changes)}, numbers(*GOOD)).iloc[0]
    assert row["note"] == "because | Changed after first judging, criteria: was a; now b. c."


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


def test_a_claim_that_could_not_be_computed_says_why_and_leaves_the_others_alone():
    whole = numbers(("C01", "a", "e", 0.7, "-"), ("C01", "a", "v", 1.0, "m/s"))
    nan = float("nan")
    lacking = ("C01", "b", "not computed", nan, nan, "-", "computed", "study.c", "", "No plateau")
    other = numbers(*(("C02", *row[1:]) for row in GOOD))
    table = pd.concat([whole, pd.DataFrame([lacking], columns=NUMBER_COLUMNS), other])
    claims = {"C01": claim(**TWO), "C02": claim(id="C02")}
    first, second = verdicts(claims, table).to_dict("records")
    assert (first["verdict"], first["note"]) == ("not computed", "b: No plateau")
    assert first["computed_value"] == "e (a) = 0.7; v (a) = 1 m/s"
    assert second["verdict"] == "reproduced"


def test_no_claim_can_declare_that_it_is_not_computed():
    with pytest.raises(ValueError, match="if_met"):
        claim(if_met="not computed")


def test_a_claim_that_is_not_testable_needs_no_numbers():
    untestable = claim(quantities={}, criteria=[], testable=False, **{"break": None})
    other = claim(id="C02")
    rows = numbers(*((("C02", *row[1:])) for row in GOOD))
    table = verdicts({"C01": untestable, "C02": other}, rows)
    assert list(table["verdict"]) == ["not testable", "reproduced"]


def test_claims_and_digitised_points_are_judged_together(tmp_path):
    path = tmp_path / "claims.yaml"
    path.write_text(
        """
digitised:
  normalised_rms: 2.0
  rms_difference: {fig17: 0.05}
  reason: r
C01:
  where: "2"
  statement: s
  kind: model
  article_value: "0.7"
  unit: "-"
  quantities: {e: "-"}
  criteria: [{quantity: e, test: at_least, value: 0.5}]
  reason: r
  break: {change: x, expect: not reproduced}
"""
    )
    none = pd.DataFrame(columns=["claim", "alternative"])
    tables = {"claim_numbers": numbers(GOOD[0]), "digitised_residuals": residuals()}
    tables |= {"claim_draws": none, "admissible_contacts": pd.DataFrame()}
    tables["external_evidence"] = pd.DataFrame(columns=["fact", "contact", "agreement"])
    assert list(judge(tables, path)["verdict"]) == ["reproduced"]
    tables["digitised_residuals"] = residuals(BARRED)
    table = judge(tables, path)
    assert list(table.columns) == list(COLUMNS)
    assert list(table["id"]) == ["C01", "D17-friction-0.15"]


# Digitised points

BARRED = {"n": 6, "bars": 6, "normalised_rms": 1.9, "rms_difference": 0.3}
BARE = {"n": 6, "bars": 5, "normalised_rms": 9.0, "rms_difference": 0.04}
FAR = {"rms_difference": 1.0}
POINTS = DigitisedCriteria(normalised_rms=2.0, rms_difference={"fig17": 0.05}, reason="because")


def residuals(*rows):
    base = {
        "figure": "fig17",
        "panel": "friction",
        "points": "0.15",
        "points_evidence": "digitised",
        "series": "a",
        "named": True,
        "evidence": "computed",
        "unit": "1",
        "n": 6,
        "beyond": 0,
        "bias": 0.01,
        "within_bars": 0.9,
        "rms_difference": 0.01,
        "normalised_rms": 0.1,
        "bars": 0,
    }
    return pd.DataFrame([base | row for row in rows], columns=list(base))


@pytest.mark.parametrize(
    ("rows", "verdict", "criterion"),
    [
        # bars decide if all points have one, else the bound of the figure
        ([BARRED], "reproduced", "normalised_rms at most 2"),
        ([BARRED | {"normalised_rms": 2.1}], "not reproduced", "normalised_rms at most 2"),
        ([BARE], "reproduced", "rms_difference at most 0.05"),
        ([BARE | {"rms_difference": 0.06}], "not reproduced", "rms_difference at most 0.05"),
        # a series of the same name decides, whatever others do
        (
            [BARE, BARE | {"series": "b", "named": False, "rms_difference": 1.0}],
            "reproduced",
            "rms_difference at most 0.05",
        ),
        (
            [BARE | {"rms_difference": 1.0}, BARE | {"series": "b", "named": False}],
            "not reproduced",
            "rms_difference at most 0.05",
        ),
        # without one, all are cases
        (
            [BARE | {"named": False}, BARE | {"series": "b", "named": False} | FAR],
            "not identified",
            "rms_difference at most 0.05",
        ),
        ([BARE | {"n": 0, "beyond": 6}], "not testable", "rms_difference at most 0.05"),
    ],
)
def test_digitised_points_are_judged(rows, verdict, criterion):
    (row,) = digitised_rows(POINTS, residuals(*rows))
    assert row["verdict"] == verdict
    assert row["criterion"] == criterion
    assert set(row) <= set(COLUMNS)
    assert (row["evidence"], row["figures"], row["unit"]) == ("digitised", "fig17", "-")
    assert row["article_value"] == "6 points"


def test_every_series_of_points_has_one_row_and_no_points_have_none():
    other = BARE | {"points": "0.2", "beyond": 2}
    rows = digitised_rows(POINTS, residuals(BARE, other, BARE | {"series": "b"}))
    assert [row["id"] for row in rows] == ["D17-friction-0.15", "D17-friction-0.2"]
    assert [row["article_value"] for row in rows] == ["6 points", "8 points"]
    assert "2 points beyond" in rows[1]["note"]
    assert digitised_rows(POINTS, residuals()) == []


def test_a_figure_without_a_bound_is_named():
    with pytest.raises(ValueError, match=r"digitised\.rms_difference: fig18 has no bound"):
        digitised_rows(POINTS, residuals(BARE | {"figure": "fig18"}))
