"""Two runs compared: inputs, numbers, verdicts and figures, as text and as a page."""

from __future__ import annotations

import base64
import re
from html.parser import HTMLParser

import pytest
from tests.report.results_roots import CLAIMS, INPUTS, draw, results, run

from microimpact.report.check.compare import as_text, compare
from microimpact.report.check.page import page

VOID = {"meta", "img"}
EVIL = "<script>alert(1)</script>"


class Page(HTMLParser):
    """Parses a page strictly: every element is closed in order."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.attributes, self.words = [], [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


@pytest.fixture
def baseline(tmp_path):
    return results(tmp_path / "a")


@pytest.fixture
def changed(tmp_path):
    return results(
        tmp_path / "b",
        slope=0.5,
        inputs=INPUTS.replace("2500", "2600"),
        claims=CLAIMS.replace("0.44,reproduced", "0.4,not reproduced"),
        commit="def",
    )


def test_a_run_is_the_same_as_itself(baseline, tmp_path):
    changes = compare(baseline, results(tmp_path / "again"))
    assert changes.same
    assert changes.unchanged_figures == ("fig14",)
    assert "are the same" in as_text(changes)
    assert "are the same" in page(changes)


def test_another_commit_alone_is_told_but_is_no_difference(baseline, tmp_path):
    changes = compare(baseline, results(tmp_path / "again", commit="def"))
    assert changes.same
    assert [(d.row, d.reference, d.found) for d in changes.runs] == [("git commit", "abc", "def")]


def test_every_kind_of_change_is_named(baseline, changed):
    changes = compare(baseline, changed)
    (given,) = changes.inputs
    assert (given.row, given.column) == ("materials.csv, glass density", "value")
    assert (given.reference, given.found) == ("2500", "2600")
    (verdict,) = changes.verdicts
    assert (verdict.row, verdict.reference, verdict.found) == (
        "C01",
        "reproduced",
        "not reproduced",
    )
    assert {d.file for d in changes.numbers} == {"data/fig14.csv", "tables/claims.csv"}
    assert [figure.name for figure in changes.figures] == ["fig14"]
    text = as_text(changes)
    for title in ("## Runs", "## Inputs", "## Verdicts", "## Numbers", "## Figures"):
        assert f"\n{title}\n" in text
    assert "| baseline" in text


def test_all_changed_inputs_are_shown(baseline, tmp_path):
    rows = "".join(f"config,a.b[{i}],1,,,-,chosen,x\n" for i in range(40))
    other = results(tmp_path / "b", inputs=INPUTS + rows)
    assert as_text(compare(baseline, other), few=3).count("| config, a.b[") == 40


def test_a_claim_that_one_run_judged_is_a_change_of_verdict(baseline, tmp_path):
    other = results(tmp_path / "b", claims=CLAIMS + "C03,rolls,1,reproduced\n")
    (found,) = compare(baseline, other).verdicts
    assert (found.kind, found.row) == ("extra row", "C03")


def test_figures_and_tables_of_one_run_only(baseline, changed):
    draw(changed, "fig20", 0.3)
    (baseline / "tables/claims.csv").unlink()
    changes = compare(baseline, changed)
    assert {f.name: f.what for f in changes.figures}["fig20"] == "only in the changed run"
    assert [(d.kind, d.file) for d in changes.verdicts] == [("extra file", "tables/claims.csv")]
    backwards = compare(changed, baseline)
    assert {f.name: f.what for f in backwards.figures}["fig20"] == "only in the baseline run"
    assert [d.kind for d in backwards.verdicts] == ["missing file"]
    assert Page(page(changes)).tags.count("img") == 3


def test_runs_without_claims_and_stamp_can_be_compared(baseline, changed):
    for root in (baseline, changed):
        (root / "tables/claims.csv").unlink()
        (root / "run.json").unlink()
    changes = compare(baseline, changed)
    assert changes.verdicts == changes.runs == ()
    assert changes.inputs


def test_the_page_is_well_formed_and_shows_figures_side_by_side(baseline, changed):
    text = page(compare(baseline, changed))
    parsed = Page(text)
    assert text.startswith("<!DOCTYPE html>\n")
    pictures = [value for name, value in parsed.attributes if name == "src"]
    drawn = [
        base64.b64decode(p.removeprefix("data:image/svg+xml;base64,"), validate=True)
        for p in pictures
    ]
    assert drawn == [(root / "figures/fig14.svg").read_bytes() for root in (baseline, changed)]
    assert "color-scheme: light dark" in text


def test_the_page_needs_nothing_else(baseline, changed):
    text = page(compare(baseline, changed))
    parsed = Page(text)
    assert not {"link", "script", "iframe", "object", "base"} & set(parsed.tags)
    names = {name for name, _ in parsed.attributes}
    assert not {"href", "srcset", "style", "action"} & names
    assert all(v.startswith("data:") for name, v in parsed.attributes if name == "src")
    without_pictures = re.sub(r"base64,[\w+/=]*", "", text)
    assert "//" not in without_pictures
    assert "url(" not in text
    assert "@import" not in text


def test_a_material_with_an_evil_name_stays_text(baseline, tmp_path):
    other = results(tmp_path / "b", inputs=INPUTS.replace("glass density", f'"{EVIL}"'), slope=0.5)
    draw(other, "<img src=x onerror=alert(1)>", 0.5)
    text = page(compare(baseline, other))
    parsed = Page(text)
    assert "script" not in parsed.tags
    assert not [name for name, _ in parsed.attributes if name.startswith("on")]
    assert EVIL in "".join(parsed.words)


def test_the_command(baseline, changed, tmp_path):
    html = tmp_path / "page.html"
    code, text, _ = run("compare", baseline, changed, "--html", html)
    assert code == 1
    assert "## Verdicts" in text
    Page(html.read_text(encoding="utf-8"))
    assert run("compare", baseline, baseline)[0] == 0


def test_the_command_refuses_what_are_no_results(baseline, tmp_path):
    code, _, error = run("compare", baseline, tmp_path / "nothing")
    assert (code, error) == (2, f"microimpact: {tmp_path / 'nothing'}: no such folder\n")
    (baseline / "run.json").write_text("{\n?")
    code, _, error = run("compare", baseline, baseline)
    assert code == 2
    assert "run.json, line 2: " in error
