"""What the inputs do not allow costs its own results, which say why, and nothing else."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from tests.shared import ROOT, settings_as_shipped

from study.analyses import claim_numbers
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


def job(tmp_path, study, inputs, *names, is_shipped):
    branch = settings_as_shipped().branches[study]
    made = {name: tmp_path / f"{name}.csv" for name in names}
    params = SimpleNamespace(analysis=study, rows={}, branch=branch, is_shipped=is_shipped)
    return SimpleNamespace(rule=study, input=inputs, output=made, wildcards={}, params=params)


@pytest.fixture
def script(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "workflow/scripts")
    import run_analysis

    return run_analysis


def test_a_study_without_its_table_writes_why(lacking, tmp_path, script):
    changed, shipped = (
        job(
            tmp_path,
            "rolling_dissipation",
            {"calibration": lacking},
            "a",
            "b",
            is_shipped=is_shipped,
        )
        for is_shipped in (False, True)
    )
    # Inputs as shipped allow all.
    with pytest.raises(NotComputedError, match=f"^with the inputs as shipped, .*: {WHY}$"):
        script.main(shipped)
    assert not any(path.exists() for path in shipped.output.values())
    script.main(changed)
    for path in changed.output.values():
        with pytest.raises(NotComputedError, match=f"^{WHY}$"):
            read_table(path)


def test_an_error_of_the_program_is_no_result(lacking, tmp_path, script, monkeypatch):
    def run(params, inputs):
        return np.ones(3) + np.ones(4)

    monkeypatch.setattr("study.analyses.fig17_coulomb_friction.compute.run", run)
    with pytest.raises(ValueError, match="could not be broadcast"):
        script.main(job(tmp_path, "fig17_coulomb_friction", {}, "fig17", is_shipped=False))
    assert not (tmp_path / "fig17.csv").exists()


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
    for name in set(claim_numbers.CLAIMS) - {"C01", "C10"}:
        monkeypatch.delitem(claim_numbers.CLAIMS, name)
    params = build(claim_numbers.Params, settings_as_shipped().branches["claim_numbers"])
    files = {"calibration": lacking, "posterior_contacts": lacking}
    table = claim_numbers.numbers(params, NamedTables(files))["claim_numbers"]
    problems = table.groupby("claim")["problem"].agg(set)
    assert problems["C01"] == {""}
    assert problems["C10"] == {WHY}
    assert set(problems.index) == {"C01", "C10"}
