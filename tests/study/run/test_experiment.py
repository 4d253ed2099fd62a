"""Another experiment is declared in one place: words and claims of what rests on it follow."""

from __future__ import annotations

import re

import pytest
from tests.shared import ROOT, settings_as_shipped, shipped

from study.declared.documents import load
from study.declared.references import merged
from study.judge.changed import OF_ANOTHER, with_inputs
from study.run.changed import changed_inputs, of_other_impacts
from study.run.config import read_inputs, validate

OVERLAY = ROOT / "config/examples/latex-on-silica.yaml"
FIGURES = re.search(r"snakemake (.*) --configfile", OVERLAY.read_text())[1].split()


@pytest.fixture(scope="module")
def latex():
    settings = validate(merged(shipped(), load(OVERLAY)), shipped())
    return settings, changed_inputs(settings, settings_as_shipped())


@pytest.mark.parametrize("name", FIGURES)
def test_no_word_is_of_the_old_pair(latex, name):
    spec = read_inputs(*latex).figures[name]
    assert not re.search("steel|silicon|molybdenum|SST", f"{spec.title} {spec.caption}")


@pytest.mark.parametrize("name", [f"fig{number:02d}" for number in range(7, 13)])
def test_figures_of_the_articles_pairs_keep_their_words(latex, name):
    old, new = (
        read_inputs(settings, inputs).figures[name]
        for settings, inputs in ((settings_as_shipped(), {}), latex)
    )
    assert (new.title, new.caption) == (old.title, old.caption)


def test_only_another_impact_costs_the_words_on_the_shipped_ones():
    finer = {"seed": 7, "fig23_monte_carlo": {"plan": {"events": 4096}}}
    rougher = {"frictions": {"steel on silicon": 0.3}}
    figures = [
        read_inputs(settings, of_other_impacts(changed_inputs(settings, settings_as_shipped())))
        .figures["fig23"]
        .method
        for settings in (validate(merged(shipped(), each), shipped()) for each in (finer, rougher))
    ]
    assert ["drawn independently" in method for method in figures] == [True, False]


@pytest.mark.parametrize("table", ["pairing_quality", "rolling_dissipation", "force_ratios"])
def test_claims_of_these_analyses_are_not_of_this_experiment(latex, table):
    row = {"id": "C01", "inputs": table, "verdict": "reproduced", "sentence": ""}
    assert with_inputs(row, latex[1])["verdict"] == OF_ANOTHER


def test_claims_of_the_articles_pairs_stay(latex):
    row = {"id": "C01", "inputs": "surface_pairs", "verdict": "reproduced", "sentence": ""}
    assert with_inputs(row, latex[1])["verdict"] == "reproduced"


@pytest.mark.parametrize(
    ("tables", "verdict"),
    [
        ("calibration materials", "reproduced"),
        ("calibration molybdenum_capture", OF_ANOTHER),
        ("force_ratios", OF_ANOTHER),
    ],
)
def test_another_size_of_fluorescein_leaves_the_claims_on_steel(tables, verdict):
    overlay = {"particles": {"fluorescein": {"mean_diameter_um": 2.58}}}
    settings = validate(merged(shipped(), overlay), shipped())
    row = {"id": "C01", "inputs": tables, "verdict": "reproduced", "sentence": ""}
    marked = with_inputs(row, changed_inputs(settings, settings_as_shipped()))
    assert marked["verdict"] == verdict
    assert "particles.fluorescein.mean_diameter_um" in marked["changed_inputs"]


def test_another_contact_must_be_of_its_pair():
    overlay = {"impact": {"cases": ["steel-silicon, n = 1", "steel-mirror front"]}}
    with pytest.raises(ValueError, match=r"impact\.cases\[1\]: 'steel-mirror front' is of"):
        validate(merged(shipped(), overlay), shipped())


def test_another_contact_changes_what_is_made_of_all_contacts(tmp_path):
    path = tmp_path / "contacts.csv"
    rows = (ROOT / "config/contacts.csv").read_text(encoding="utf-8").splitlines()
    row = next(line for line in rows if "work_of_adhesion" in line)
    fields = row.split(",")
    fields[3] = "0.123"
    path.write_text("\n".join(rows).replace(row, ",".join(fields)) + "\n", encoding="utf-8")
    settings = validate(shipped() | {"contacts": str(path)}, shipped())
    changed = changed_inputs(settings, settings_as_shipped())
    assert f"contacts.{fields[0]}" in changed["contact_properties"].values()
