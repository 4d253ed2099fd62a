"""Shares of the admissible contacts: counted, turned into verdicts, and what decides them."""

import numpy as np
import pandas as pd
import pytest
from tests.study.ledgers.test_claims import claim, numbers

from study.ledgers.claims import verdicts
from study.ledgers.claims.judging import verdict
from study.ledgers.claims.shares import NUMBERS, Share, separation, shares

COLUMNS = ["claim", "contact", "variant", "draw", "alternative", "quantity", "value"]
CASES = {"cases": ["a", "b"]}


def drawn(values, variant="with", alternative="", quantity="e"):
    rows = [
        ("C01", "steel", variant, draw, alternative, quantity, value)
        for draw, value in enumerate(values)
    ]
    return pd.DataFrame(rows, columns=COLUMNS)


def contacts(count=20, **columns):
    rng = np.random.default_rng(1)
    table = pd.DataFrame({name: rng.random(count) for name in NUMBERS})
    table = table.assign(friction_basis="net", case="steel", draw=np.arange(count), **columns)
    both = [table.assign(variant=variant) for variant in ("with", "without")]
    other = table.assign(case="other", variant="with")
    return pd.concat([other, *both], ignore_index=True)


# Criterion of the claim: 0.65 to 0.75.
def with_share(count, of=20):
    return drawn([0.7] * count + [0.9] * (of - count))


@pytest.mark.parametrize(
    ("count", "expected"),
    [
        (20, "reproduced"),
        (19, "reproduced"),
        (18, "not identified"),
        (2, "not identified"),
        (1, "not reproduced"),
        (0, "not reproduced"),
    ],
)
def test_shares_decide_at_95_and_5_per_cent(count, expected):
    found = shares({"C01": claim(**CASES)}, with_share(count), contacts())["C01"]
    assert found.share == pytest.approx(count / 20)
    assert verdict("reproduced", found.margin) == expected
    assert bool(found.decided_by) == (expected == "not identified")


def test_the_first_variant_decides_and_the_other_is_told():
    both = pd.concat([with_share(20), drawn([0.9] * 20, variant="without")])
    found = shares({"C01": claim(**CASES)}, both, contacts())["C01"]
    assert found.share == 1.0
    assert verdict("reproduced", found.margin) == "reproduced"
    assert found.variants == {"with": 1.0, "without": 0.0}
    assert found.in_words() == "Met by 100 % with, 0 % without, of the admissible contacts"


def test_each_alternative_of_a_claim_counts_for_each_draw():
    both = pd.concat([drawn([0.7] * 20, alternative="x"), drawn([0.9] * 20, alternative="y")])
    found = shares({"C01": claim(**CASES)}, both, contacts())["C01"]
    assert (found.share, len(found.margin)) == (0.5, 40)
    assert found.decided_by == "alternative (1.00)"


@pytest.mark.parametrize("name", NUMBERS)
def test_what_decides_is_the_parameter_that_differs_most(name):
    met = with_share(10)
    order = np.arange(20) if name != "friction" else -np.arange(20.0)
    found = shares({"C01": claim(**CASES)}, met, contacts(**{name: order}))["C01"]
    words = name.removesuffix("_J_per_m2").removesuffix("_s_per_m").replace("_", " ")
    assert found.decided_by == f"{words} (1.00)"


def test_a_basis_of_friction_can_decide():
    basis = ["net"] * 10 + ["hertz"] * 10
    table = contacts()
    table["friction_basis"] = basis * 3
    found = shares({"C01": claim(**CASES)}, with_share(10), table)["C01"]
    assert found.decided_by == "friction basis (1.00)"


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
    share = Share(
        variants={"with": 0.4},
        margin=np.repeat([np.inf, -np.inf], [4, 6]),
        decided_by="friction (0.90)",
    )
    claims = {"C01": claim(**CASES)}
    assert verdicts(claims, numbers(*rows))[0]["verdict"].iloc[0] == "reproduced"
    row = verdicts(claims, numbers(*rows), {"C01": share})[0].iloc[0]
    assert (row["verdict"], row["share"]) == ("not identified", 0.4)
    assert row["decided_by"] == "friction (0.90)"
    assert row["note"].startswith("Met by 40 % with, of the admissible contacts")
