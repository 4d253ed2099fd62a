"""The page of deviations is what the ledgers say, and says it in readable numbers."""

from __future__ import annotations

import shutil

import pandas as pd
import pytest
from tests.docs.blocks import ROOT

from study.ledgers.claims.criteria import read_claims
from study.ledgers.claims.words import readable
from study.report.documents import LEDGERS, deviations

REFERENCE = ROOT / "tests/reference/full"
CRITERIA = ROOT / "config/claims.yaml"
TOLD = {"not reproduced", "not identified", "reproduced with a correction", "undecided"}
TOLD |= {"not testable", "not computed"}


@pytest.fixture(scope="module")
def made():
    return deviations(REFERENCE, CRITERIA)


@pytest.fixture
def run(tmp_path):
    """Tables of a run that may be changed."""
    (tmp_path / "tables").mkdir()
    for name in LEDGERS:
        shutil.copy(REFERENCE / f"tables/{name}.csv", tmp_path / "tables")
    return tmp_path


def edit(run, name, change):
    path = run / "tables" / name
    change(pd.read_csv(path, keep_default_na=False)).to_csv(path, index=False)


def test_every_equation_and_statement_that_deviates_has_its_place(made):
    equations = pd.read_csv(REFERENCE / "tables/equations.csv", keep_default_na=False)
    claims = pd.read_csv(REFERENCE / "tables/claims.csv", keep_default_na=False)
    assert made.count("\n### ") == claims["verdict"].isin(TOLD).sum()
    for row in equations.itertuples():
        deviates = row.verdict in ("corrected", "typographical slip", "undecidable")
        assert (f" | {row.reason}" in made) == deviates, row.equation
    verdicts = dict(zip(claims["id"], claims["verdict"], strict=True))
    for claim in read_claims(CRITERIA).values():
        for amendment in claim.amendments:
            assert f"| {claim.id}, {amendment.part} | {amendment.was} | {amendment.now} |" in made
        heading = f"### {claim.id} ({claim.where})\n\n{claim.statement}\n"
        assert (heading in made) == (verdicts[claim.id] in TOLD)


def test_every_statement_not_reproduced_shows_a_number_that_fails(made):
    part = made.split("## Statements not reproduced")[1].split("## Statements not identified")[0]
    for entry in part.split("\n### ")[1:]:
        assert "**" in entry, entry
    held = made.split("## Statements reproduced with")[1].split("## Statements undecided")[0]
    assert "**" not in held


def test_tables_of_other_claims_are_refused(run):
    edit(run, "claims.csv", lambda table: table[table["id"] != "C09"])
    with pytest.raises(ValueError, match="do not hold the same claims: C09 in one of them"):
        deviations(run, CRITERIA)


@pytest.mark.parametrize(
    ("number", "text"),
    [
        ((0.14004712, "m/s"), "0.14 m/s"),
        ((24585.88, "rad/s"), "24600 rad/s"),
        ((0.99964, "-"), "0.9996"),
        ((3.04345144516e11, "Pa"), "3.04 × 10¹¹ Pa"),
        ((-1.85e-5, "1"), "−1.85 × 10⁻⁵"),
        ((1.45158949, "s**2/m**2"), "1.45 s^2/m^2"),
        ((3.3e-16, "-", 1e-9), "0"),
        ((1.8e-17, "s/m"), "1.80 × 10⁻¹⁷ s/m"),
    ],
)
def test_numbers_are_readable(number, text):
    assert readable(*number) == text
