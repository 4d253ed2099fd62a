"""Shares of the drawn contacts: counted, turned into verdicts, and what decides them."""

import numpy as np
import pandas as pd
import pytest
from tests.study.judge.test_claims import claim, numbers

from study.judge import judge, verdicts
from study.judge.judging import judged
from study.judge.shares import NUMBERS, Share, separation, shares

COLUMNS = ["claim", "contact", "scenario", "law", "draw", "alternative", "quantity", "value"]
CASES = {"cases": ("a", "b")}


def drawn(values, scenario="with", law="", alternative="", quantity="e"):
    rows = [
        ("C01", "steel", scenario, law, draw, alternative, quantity, value)
        for draw, value in enumerate(values)
    ]
    return pd.DataFrame(rows, columns=COLUMNS)


def contacts(count=20, **columns):
    rng = np.random.default_rng(1)
    table = pd.DataFrame({name: rng.random(count) for name in NUMBERS})
    table = table.assign(
        **({"friction_basis": "net", "case": "steel", "draw": np.arange(count)} | columns),
        effective_size=np.inf,
    )
    both = [
        table.assign(scenario=scenario, law=law)
        for scenario in ("with", "without")
        for law in ("", "n = 0")
    ]
    other = table.assign(case="other", scenario="with", law="")
    return pd.concat([other, *both], ignore_index=True)


# Criterion of the claim: 0.65 to 0.75.
def with_share(count, of=20, **group):
    return drawn([0.7] * count + [0.9] * (of - count), **group)


def share_of(*draws, **columns):
    table = contacts(400, **columns)
    return shares({"C01": claim(**CASES)}, pd.concat(draws), table)["C01"]


@pytest.mark.parametrize(
    ("count", "expected"),
    [
        (400, "reproduced"),
        (390, "reproduced"),
        (382, "undecided"),
        (375, "undecided"),
        (360, "not identified"),
        (40, "not identified"),
        (20, "undecided"),
        (10, "not reproduced"),
        (0, "not reproduced"),
    ],
)
def test_shares_decide_at_95_and_5_per_cent_beyond_their_binomial_error(count, expected):
    share = share_of(with_share(count, 400))
    assert judged("reproduced", share.intervals) == expected
    assert bool(share.decided_by) == (expected == "not identified")


@pytest.mark.parametrize(("size", "expected"), [(1e4, "reproduced"), (60.0, "undecided")])
def test_draws_of_few_weighted_contacts_are_worth_fewer(size, expected):
    draws, table = with_share(400, 400), contacts(400).assign(effective_size=size)
    share = shares({"C01": claim(**CASES)}, draws, table)["C01"]
    assert judged("reproduced", share.intervals) == expected
    assert share.counts["with", "", ""][1] == pytest.approx(1 / (1 / size + 1 / 400))


def test_a_law_without_numbers_is_named():
    other = with_share(400, 400, law="n = 0").assign(claim="C02")
    claims = {"C01": claim(**CASES), "C02": claim("C02", **CASES)}
    both = shares(claims, pd.concat([with_share(400, 400), other]), contacts(400))
    assert both["C01"].in_words().endswith("none by n = 0: the numbers are of the ring force")


@pytest.mark.parametrize(
    ("met", "rest", "expected", "by"),
    [
        ((400, 0), {"scenario": "without"}, "not identified", "capture velocity"),
        ((0, 200), {"scenario": "without"}, "not identified", "capture velocity"),
        ((400, 400), {"scenario": "without"}, "reproduced", ""),
        ((400, 380), {"scenario": "without"}, "undecided", ""),
        ((400, 0), {"law": "n = 0"}, "not identified", "law of contact"),
        ((400, 0), {"alternative": "y"}, "not identified", "alternative"),
    ],
)
def test_a_class_that_changes_is_not_identified_and_says_by_what(met, rest, expected, by):
    share = share_of(with_share(met[0], 400), with_share(met[1], 400, **rest))
    assert judged("reproduced", share.intervals) == expected
    assert share.decided_by == by


BASIS = {"friction_basis": ["net"] * 200 + ["hertz"] * 200}


@pytest.mark.parametrize("columns", [*({name: np.arange(400)} for name in NUMBERS), BASIS])
def test_what_decides_is_the_parameter_that_differs_most(columns):
    (name,) = columns
    words = name.removesuffix("_J_per_m2").removesuffix("_s_per_m").replace("_", " ")
    assert share_of(with_share(200, 400), **columns).decided_by == f"{words} (1.00)"


@pytest.mark.parametrize(
    ("values", "expected"),
    [([1, 2, 3, 4], 1.0), ([4, 3, 2, 1], 1.0), ([1, 1, 1, 1], 0.0), ([1, 4, 2, 3], 0.0)],
)
def test_separation_of_two_samples(values, expected):
    met = np.array([True, True, False, False])
    assert separation(np.array(values, float), met) == pytest.approx(expected)
    assert separation(np.array(values, float), np.ones(4, bool)) == 0.0


def test_the_share_decides_in_the_ledger_and_the_cases_are_examples():
    rows = [("C01", case, name, value) for case in "ab" for name, value in (("e", 0.7), ("v", 1.0))]
    share = Share(counts={("with", "", ""): (40, 100)}, decided_by="friction (0.90)")
    claims = {"C01": claim(**CASES)}
    assert verdicts(claims, numbers(*rows))[0]["verdict"].iloc[0] == "reproduced"
    row = verdicts(claims, numbers(*rows), {"C01": share})[0].iloc[0]
    assert row["verdict"] == "not identified"
    assert row["shares"] == "40 % (31 to 50) with"
    assert row["decided_by"] == "friction (0.90)"
    assert row["sentence"].startswith(
        "The claim holds for 40 % of the drawn contacts, depending on the friction. With the"
    )


def test_the_ledger_has_a_row_per_scenario(one):
    tables = {"claim_numbers": numbers(("C01", "", "e", 0.7))}
    draws = pd.concat([drawn([0.7, 0.7, 0.7, 0.1]), drawn([0.7], scenario="without")])
    tables |= {"claim_draws": draws, "posterior_contacts": contacts(4)}
    rows = judge(tables)["claim_shares"]
    shares = rows[["id", "scenario", "share"]].to_numpy().tolist()
    assert shares == [["C01", "with", 0.75], ["C01", "without", 1.0]]
    assert ((rows["low"] < rows["share"]) & (rows["high"] <= 1.0)).all()
