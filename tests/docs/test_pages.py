"""Pages with numbers are what the templates and the kept tables of a full run say."""

from __future__ import annotations

import re
import shutil

import pandas as pd
import pytest
from tests.docs.blocks import ROOT
from tests.shared import settings_as_shipped

from study.judge.criteria import declared_claims
from study.judge.words import bounds, readable
from study.report.documents import LEDGERS, SUFFIX, PageError, deviations, pages, renew

FULL = ROOT / "tests/reference/full"
TOLD = {"not reproduced", "not identified", "reproduced with a correction", "undecided"}
TOLD |= {"not testable", "not computed"}
IN_FULL = "not reproduced"
RENEW = "bring it up to date after a full run: make pages RESULTS=results"


@pytest.fixture
def docs(tmp_path):
    """A folder with one template."""
    folder = tmp_path / "docs"
    folder.mkdir()
    (folder / f"sizes.md{SUFFIX}").write_text(
        '{{ table("sizes")("speed", case="a") | fixed(2) }} of {{ 0.25 | percent }}\n'
    )
    return folder


@pytest.fixture
def run(tmp_path):
    """The kept tables of the ledgers, and one more."""
    tables = tmp_path / "run/tables"
    shutil.copytree(FULL / "tables", tables)
    pd.DataFrame({"case": ["a", "b"], "speed": [-0.456, 1.0]}).to_csv(tables / "sizes.csv")
    return tmp_path / "run"


def test_committed_pages_are_those_of_the_kept_tables_and_read_all_of_them():
    made, read = pages(FULL, ROOT / "docs")
    for name, text in made.items():
        assert (ROOT / "docs" / name).read_text(encoding="utf-8") == text, f"{name}: {RENEW}"
    assert set(read) == {path.stem for path in (FULL / "tables").iterdir()}


def test_kept_verdicts_are_on_the_declared_statements_and_criteria():
    kept = pd.read_csv(FULL / "tables/claims.csv", keep_default_na=False).set_index("id")
    declared = declared_claims(settings_as_shipped().branches["claim_numbers"])
    assert list(kept.index) == list(declared), RENEW
    for name, claim in declared.items():
        row = kept.loc[name]
        criterion = "; ".join(
            f"{claim.labels[n]} {bounds(c.row)}" for n, c in claim.criteria.items()
        )
        assert row["statement"] == claim.statement, f"{name}: {RENEW}"
        assert row["criterion"] == criterion, f"{name}: {RENEW}"


def test_a_changed_number_changes_the_page_and_the_kept_table(docs, run, tmp_path):
    kept = tmp_path / "kept"
    shutil.copytree(run, kept)
    renew(kept, docs, kept)
    page = docs / "sizes.md"
    assert page.read_text(encoding="utf-8").endswith("−0.46 of 25 %\n")
    assert renew(kept, docs, kept) == []
    pd.DataFrame({"case": ["a"], "speed": [0.5]}).to_csv(kept / "tables/sizes.csv")
    assert renew(kept, docs, kept) == [page]
    assert page.read_text(encoding="utf-8").endswith("0.50 of 25 %\n")
    names = {path.stem for path in (kept / "tables").iterdir()}
    assert names >= {*LEDGERS, "sizes", "normal_experiments"}  # The last by remarks on Fig. 4
    assert "calibration" not in names


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ('table("sises")("speed")', "sises.csv: no such table"),
        ('table("sizes")("sped")', "sizes: no column 'sped' (did you mean 'speed'?)"),
        ('table("sizes")("speed")', "sizes.speed: 2 numbers at {}, not one"),
        ("nothing", "'nothing' is undefined"),
    ],
)
def test_a_number_that_is_not_there_is_named(docs, run, asked, message):
    (docs / f"sizes.md{SUFFIX}").write_text("{{ " + asked + " }}")
    with pytest.raises(PageError) as error:
        pages(run, docs)
    assert message in str(error.value)


def test_what_the_example_analysis_found_is_in_its_table():
    page = (ROOT / "docs/separation.md").read_text(encoding="utf-8")
    rows = page.partition("| statement of the abstract | found |")[2].splitlines()[2:]
    found = " ".join(row.split(" | ")[1] for row in rows if row)
    table = pd.read_csv(ROOT / "tests/reference/tables/particle_separation.csv")
    values = table.select_dtypes("number").stack()
    numbers = re.findall(r"\d+(?:\.\d+)?", found)
    for text in numbers:
        digits = max(len(text.replace(".", "").lstrip("0").rstrip("0" * ("." not in text))), 1)
        told = {float(f"{v * k:.{digits}g}") for v in values for k in (1.0, 100.0)}
        assert float(text) in told, f"{text}: not in the table"
    assert len(numbers) > 15


@pytest.fixture(scope="module")
def made():
    """The page of deviations."""
    return deviations(FULL)


def test_every_equation_and_statement_that_deviates_has_its_place(made):
    equations = pd.read_csv(FULL / "tables/equations.csv", keep_default_na=False)
    claims = pd.read_csv(FULL / "tables/claims.csv", keep_default_na=False)
    assert made.count("\n### ") == (claims["verdict"] == IN_FULL).sum()
    for row in equations.itertuples():
        deviates = row.verdict in ("corrected", "typographical slip", "undecidable")
        assert (f" | {row.reason}" in made) == deviates, row.equation
    verdicts = dict(zip(claims["id"], claims["verdict"], strict=True))
    for claim in declared_claims().values():
        heading = f"### {claim.id} ({claim.where})\n\n{claim.statement}\n"
        assert (heading in made) == (verdicts[claim.id] == IN_FULL)
        row = f"| {claim.id} | {claim.statement} | {claim.where} |"
        assert (row in made) == (verdicts[claim.id] in TOLD - {IN_FULL})


def test_every_statement_not_reproduced_has_its_sentence(made):
    sentences = pd.read_csv(FULL / "tables/claims.csv").set_index("id")["sentence"]
    part = made.split("## Statements not reproduced")[1].split("## Statements not identified")[0]
    for entry in part.split("\n### ")[1:]:
        assert f"- {sentences[entry.split()[0]]}\n" in entry, entry
    held = made.split("## Statements reproduced with")[1].split("## Statements undecided")[0]
    assert "**" not in held


def test_tables_of_other_claims_are_refused(run):
    path = run / "tables/claims.csv"
    table = pd.read_csv(path, keep_default_na=False)
    table[table["id"] != "C09"].to_csv(path, index=False)
    with pytest.raises(ValueError, match="do not hold the same claims: C09 in one of them"):
        deviations(run)


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
