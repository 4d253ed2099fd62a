"""What the inputs do not allow costs its own results, which say why, and nothing else."""

from __future__ import annotations

from types import SimpleNamespace

import pandas as pd
import pytest
from tests.shared import ROOT, settings_as_shipped

from study.claims.claim import claim_numbers
from study.contacts import calibrated_contact, solved_contacts
from study.declared.parameters import build
from study.declared.selection import NamedTables
from study.run.study import run_study
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


def test_a_case_without_solution_costs_those_that_name_it():
    few = {"works_of_adhesion_J_per_m2": [3.5]}
    tables = run_study("calibration", two_stage=few, force_ratios={"diameter_um": 1.0})
    lacking = tables["calibration"].query("role == 'not computed'")
    assert list(lacking["case"]) == ["fluorescein-molybdenum, greatest"]
    assert lacking["problem"].item().startswith("calibration.force_ratios: the peak of adhesion")
    with pytest.raises(NotComputedError, match=r"calibration\.force_ratios"):
        calibrated_contact(tables, "fluorescein-molybdenum, greatest")
    assert not solved_contacts(tables, ["fluorescein-molybdenum, greatest"])
    with pytest.raises(NotComputedError, match=r"calibration\.force_ratios"):
        NamedTables(tables)["molybdenum_capture"]
    materials = pd.read_csv(ROOT / "config/materials.csv")
    steel = calibrated_contact(tables | {"materials": materials}, "steel-formica")
    assert steel.adhesion_damping > 0.0


def test_only_claims_that_rest_on_it_have_no_number(lacking, monkeypatch):
    few = {name: claim_numbers.CLAIMS[name] for name in ("C01", "C10")}
    monkeypatch.setattr(claim_numbers.claim, "CLAIMS", few)
    params = build(claim_numbers.Params, settings_as_shipped().branches["claim_numbers"])
    files = {"calibration": lacking, "posterior_contacts": lacking}
    table = claim_numbers.run(params, NamedTables(files))["claim_numbers"]
    problems = table.groupby("claim")["problem"].agg(set)
    assert problems["C01"] == {""}
    assert problems["C10"] == {WHY}
    assert set(problems.index) == {"C01", "C10"}
