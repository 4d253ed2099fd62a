"""What the inputs do not allow costs its own results, which say why, and nothing else."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from tests.shared import ROOT, settings_as_shipped

from study.declared.parameters import build
from study.declared.selection import NamedTables
from study.figures.content import content
from study.figures.style import save, without_data
from study.run.config import read_inputs
from study.studies.claims import claim_numbers
from study.tables import NotComputedError, not_computed, read_table, write_table

WHY = "calibration.two_stage.members.n = 1: no solution"


@pytest.fixture
def lacking(tmp_path):
    path = tmp_path / "tables/calibration.csv"
    write_table(not_computed(WHY), path)
    return path


def test_a_study_without_its_table_writes_why(lacking, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "workflow/scripts")
    from run_study import main

    study, made = "rolling_dissipation", {name: tmp_path / f"{name}.csv" for name in "ab"}
    branch = settings_as_shipped().branches[study]
    job = SimpleNamespace(rule=study, input={"calibration": lacking}, output=made, wildcards={})
    job.params = SimpleNamespace(study=study, rows={}, branch=branch)
    main(job)
    for path in made.values():
        with pytest.raises(NotComputedError, match=f"^{WHY}$"):
            read_table(path)


def test_only_claims_that_rest_on_it_have_no_number(lacking, monkeypatch):
    few = {name: claim_numbers.CLAIMS[name] for name in ("C01", "C10")}
    monkeypatch.setattr(claim_numbers.claim, "CLAIMS", few)
    params = build(claim_numbers.Params, settings_as_shipped().branches["claim_numbers"])
    files = {"calibration": lacking, "admissible_contacts": lacking}
    table = claim_numbers.run(params, NamedTables({}, files))["claim_numbers"]
    problems = table.groupby("claim")["problem"].agg(set)
    assert problems["C01"] == {""}
    assert problems["C10"] == {WHY}
    assert set(problems.index) == {"C01", "C10"}


def test_a_figure_without_data_says_why(tmp_path):
    spec = read_inputs(settings_as_shipped()).figures["fig17"]
    picture = without_data(spec, WHY)
    save(picture, tmp_path / "a.png")
    (words,) = content(picture, spec).query("artist == 'Text'")["text"]
    assert " ".join(words.split()) == WHY
