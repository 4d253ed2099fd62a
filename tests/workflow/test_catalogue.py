"""Uses that the workflow catalogue promises: as a module of another workflow."""

from __future__ import annotations

import pytest
import yaml
from tests.shared import ROOT
from tests.workflow.conftest import Project

from study.tables import read_table

pytestmark = [pytest.mark.workflow, pytest.mark.slow]

SNAKEFILE = f"""
module microimpact:
    snakefile: "{ROOT}/workflow/Snakefile"
    config: config
use rule * from microimpact
"""


@pytest.fixture
def elsewhere(tmp_path):
    """A folder with nothing but a workflow that uses the rules of this one."""
    (tmp_path / "Snakefile").write_text(SNAKEFILE)
    return Project(tmp_path)


def test_another_workflow_plans_all_of_this_one(elsewhere):
    planned = elsewhere.snakemake("--dry-run").text
    assert {"fig23_monte_carlo", "claims", "report"} <= set(planned.split())
    assert {file for file in elsewhere.files() if ".snakemake" not in file} == {"Snakefile"}


def test_another_workflow_makes_one_figure_by_rules_and_inputs_of_its_own(elsewhere):
    (elsewhere.root / "Snakefile").write_text(f"{SNAKEFILE.rstrip()} as article_*\n")
    overlay = {"fig17_coulomb_friction": {"points": 7}, "pathvars": {"results": "made"}}
    (elsewhere.root / "mine.yaml").write_text(yaml.safe_dump(overlay))
    (elsewhere.root / "made").mkdir()
    (elsewhere.root / "made/beside.txt").write_text("a result of the other workflow")
    elsewhere.snakemake("article_fig17", "--configfile", "mine.yaml")
    series = read_table(elsewhere.root / "made/data/fig17.csv").groupby(["panel", "series"])
    assert set(series.size()) >= {7}
    again = elsewhere.snakemake("article_fig17", "--configfile", "mine.yaml")
    assert "Nothing to be done" in again.text
