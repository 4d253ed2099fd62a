"""What an overlay would change, before anything runs."""

from __future__ import annotations

import pandas as pd
import pytest
from tests.shared import ROOT

from study.declared.documents import ConfigError
from study.report.plan import plan


@pytest.fixture
def results(tmp_path):
    """A run of two analyses, with a claim on each."""
    claims = [
        ("C32", "force_ratios printed", "reproduced"),
        ("C72", "surface_pairs", "reproduced"),
    ]
    (tmp_path / "tables").mkdir()
    table = pd.DataFrame(claims, columns=["id", "inputs", "verdict"])
    table.assign(margin="", shares="", decided_by="", note="").to_csv(
        tmp_path / "tables/claims.csv", index=False
    )
    (tmp_path / "benchmarks").mkdir()
    costs = {"fig20_force_history": 2.0, "report": 1.0, "claim_draws": 2.0, "mechanisms": 40.0}
    for name, seconds in costs.items():
        (tmp_path / f"benchmarks/{name}.tsv").write_text(f"s\th:m:s\n{seconds}\t0:00:00\n")
    return tmp_path


@pytest.fixture
def overlay(tmp_path):
    path = tmp_path / "other.yaml"
    path.write_text("fig20_force_history: {speed_m_per_s: 4.0}\n")
    return path


def test_a_changed_speed_moves_its_figure_and_takes_the_verdict_of_its_claim(overlay, results):
    lines = plan([overlay], results).splitlines()
    assert lines[0] == "Inputs that differ, 1: fig20_force_history.speed_m_per_s"
    assert lines[1].endswith("made anew, 2: claim_numbers, fig20_force_history")
    assert lines[2].endswith("drawn anew, 1: fig20")
    assert lines[3:] == [
        "Claims not of this experiment, 1: C32",
        "These took 5 of the 45 s of all jobs there.",
    ]


def test_without_a_run_claims_and_seconds_are_not_known(overlay, tmp_path):
    assert "after a run: none in" in plan([overlay], tmp_path / "none")


def test_a_later_file_goes_before_an_earlier_one(tmp_path, overlay, results):
    back = tmp_path / "back.yaml"
    back.write_text("fig20_force_history: {speed_m_per_s: 5.2}\n")
    same = plan([overlay, back], results)
    assert "made anew, 0: -" in same
    assert same.endswith("These took 0 of the 45 s of all jobs there.")
    assert "made anew, 3" in plan([ROOT / "config/examples/high-friction.yaml", overlay], tmp_path)


def test_a_wrong_key_is_told(tmp_path):
    path = tmp_path / "wrong.yaml"
    path.write_text("fig20_force_history: {sped: 4.0}\n")
    with pytest.raises(ConfigError, match="sped: unknown key"):
        plan([path], tmp_path)
