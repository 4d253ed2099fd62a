"""Two runs compared: inputs, numbers, verdicts and figures."""

from __future__ import annotations

import json

import pytest
from tests.study.report.results_roots import (
    CLAIM_RESULTS,
    CLAIMS,
    INPUTS,
    draw,
    edit,
    results,
    run,
    write,
)

from study.report.check.compare import compare


@pytest.fixture
def baseline(tmp_path):
    return results(tmp_path / "a")


@pytest.fixture
def changed(tmp_path):
    root = results(
        tmp_path / "b",
        slope=0.5,
        inputs=INPUTS.replace("2500", "2600"),
        claims=CLAIMS.replace("0.44,reproduced", "0.4,not reproduced"),
        commit="def",
    )
    return write(root, {"tables/claim_results.csv": CLAIM_RESULTS.replace("0.44", "0.4")})


def told(differences):
    return [(d.row, d.column, d.reference, d.result) for d in differences]


def test_a_run_is_the_same_as_itself_at_another_commit(baseline, tmp_path):
    changes = compare(baseline, results(tmp_path / "again", commit="def"))
    assert changes.same
    assert told(changes.runs) == [("git commit", "value", "abc", "def")]
    assert "are the same" in str(changes)


def test_every_kind_of_change_is_named(baseline, changed):
    changes = compare(baseline, changed)
    assert told(changes.inputs) == [("materials, glass.density", "value", "2500", "2600")]
    assert told(changes.verdicts) == [
        ("C01", "verdict", "reproduced (fall = 0.44)", "not reproduced (fall = 0.4)")
    ]
    files = {"data/fig14.csv", "tables/claims.csv", "tables/claim_results.csv"}
    assert {d.file for d in changes.numbers} == files
    assert list(changes.figures) == ["fig14"]
    text = str(changes)
    for title in ("Runs", "Inputs", "Verdicts", "Numbers", "Figures"):
        assert f"## {title}\n" in text
    assert "- C01, verdict: reproduced (fall = 0.44) -> not reproduced (fall = 0.4)" in text


def test_words_of_figures_and_criteria_are_named(baseline, tmp_path):
    other = results(tmp_path / "b", claims=CLAIMS.replace("at most 1", "at most 2"))
    edit(other / "figures/fig14.csv", "Restitution", "Loss")
    changes = compare(baseline, other)
    assert told(changes.inputs) == [("C01", "criterion", "at most 1", "at most 2")]
    assert told(changes.figures["fig14"]) == [("figure, title", "text", "Restitution", "Loss")]
    assert "- fig14: 1 text (figure, title)" in str(changes)


def configured(root, **config):
    (root / "run.json").write_text(json.dumps({"git": {"commit": "abc"}, "config": config}))
    return root


def test_a_changed_input_is_one_row_however_often_it_is_used(baseline, tmp_path):
    uses = "".join(f"config,study.v[{i}],{{v}},,,m/s,printed,x,printed.v[{i}]\n" for i in (0, 1))
    rows = INPUTS + uses + "printed_values,v,{v},,,m/s,printed,x,\n"
    other = results(tmp_path / "b", inputs=rows.replace("{v}", "2"))
    (baseline / "tables/inputs.csv").write_text(rows.replace("{v}", "1"))
    configured(baseline, friction={"surface": "silicon", "angles": [5, 15]})
    configured(other, friction={"surface": "glass", "angles": [10, 15]})
    assert told(compare(baseline, other).inputs) == [
        ("friction.surface", "value", "silicon", "glass"),
        ("friction.angles", "value", "[5, 15]", "[10, 15]"),
        ("printed_values, v", "value", "1", "2"),
    ]


def test_changed_and_added_files_are_named(baseline, tmp_path):
    other = results(tmp_path / "b")
    files = {"laboratory.yaml": "a" * 64, "digitised/fig04.csv": "c" * 64}
    for root, sums in ((baseline, {"laboratory.yaml": "b" * 64}), (other, files)):
        (root / "run.json").write_text(json.dumps({"files": sums}))
    assert told(compare(baseline, other).inputs) == [
        ("laboratory.yaml", "value", "b" * 64, "a" * 64),
        ("digitised/fig04.csv", "value", "", "c" * 64),
    ]


def test_a_run_without_some_files_is_told_in_one_line_and_is_the_same(baseline, tmp_path):
    other = results(tmp_path / "b")
    draw(baseline, "fig20", 0.3)
    (other / "tables/claims.csv").unlink()
    changes = compare(baseline, other)
    assert changes.same
    lacking = ["tables/claims.csv", "figures/fig20.csv", "figures/fig20.svg"]
    assert changes.not_built == {other: lacking}
    assert f"3 files were not built in {other}." in str(changes)
    assert "fig20" not in str(changes)
    assert run("compare", other, baseline)[0] == 0


def test_the_command_ends_with_one_where_something_differs(baseline, changed):
    code, text, _ = run("compare", baseline, changed)
    assert code == 1
    assert "## Verdicts" in text
    assert run("compare", baseline, baseline)[0] == 0
