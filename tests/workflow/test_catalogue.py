"""Uses that the workflow catalogue promises: as a module of another workflow, with a report."""

from __future__ import annotations

import pytest
import yaml
from tests.shared import ROOT
from tests.workflow.conftest import SMALL, Project

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
    assert {"monte_carlo", "claims", "report"} <= set(planned.split())
    assert {file for file in elsewhere.files() if ".snakemake" not in file} == {"Snakefile"}


def test_another_workflow_makes_one_figure_by_rules_and_inputs_of_its_own(elsewhere):
    (elsewhere.root / "Snakefile").write_text(f"{SNAKEFILE.rstrip()} as article_*\n")
    overlay = {"coulomb_friction": {"points": 7}, "pathvars": {"results": "made"}}
    (elsewhere.root / "mine.yaml").write_text(yaml.safe_dump(overlay))
    (elsewhere.root / "made").mkdir()
    (elsewhere.root / "made/beside.txt").write_text("a result of the other workflow")
    elsewhere.snakemake("article_fig17", "--configfile", "mine.yaml")
    series = read_table(elsewhere.root / "made/data/fig17.csv").groupby(["panel", "series"])
    assert set(series.size()) >= {7}
    again = elsewhere.snakemake("article_fig17", "--configfile", "mine.yaml")
    assert "Nothing to be done" in again.text


def test_the_report_has_every_figure_with_its_caption(project, tmp_path):
    project.snakemake(*SMALL, "--report", str(tmp_path / "report.html"))
    report = (tmp_path / "report.html").read_text(encoding="utf-8")
    for figure, entry in yaml.safe_load((ROOT / "config/figures.yaml").read_text()).items():
        words = (entry["title"], entry.get("finding", entry["title"]))
        shown = (
            f"<strong>{figure}: {' '.join(each.split(' [[')[0].split()[:3])}" for each in words
        )
        assert any(each in report for each in shown), figure
