"""Two runs compared: inputs, numbers, verdicts and figures, as text and as a page."""

from __future__ import annotations

import base64
import json
import re

import pytest
from tests.report.pages import Page
from tests.report.results_roots import CLAIMS, INPUTS, draw, results, run

from microimpact.core.files import write_checksums
from microimpact.report.check.compare import as_text, compare, page
from microimpact.report.check.wording import worst

EVIL = "<script>alert(1)</script>"


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


def configured(root, **config):
    stamp = {"git": {"commit": "abc"}, "config": config}
    (root / "run.json").write_text(json.dumps(stamp), encoding="utf-8")
    return root


def test_texts_and_lists_of_the_configuration_are_inputs(baseline, tmp_path):
    configured(baseline, friction={"surface": "silicon", "angles": [5, 15]}, chunks=2)
    rows = (
        "config,friction.angles[0],5,,,deg,chosen,x\nconfig,friction.angles[1],15,,,deg,chosen,x\n"
    )
    (baseline / "tables/inputs.csv").write_text(INPUTS + rows)
    other = results(tmp_path / "b", inputs=INPUTS + rows.replace(",5,", ",15,", 1))
    configured(other, friction={"surface": "glass", "angles": [15, 25]}, chunks=2)
    found = {(d.row, d.reference, d.found) for d in compare(baseline, other).inputs}
    assert found == {
        ("config, friction.surface", "silicon", "glass"),
        ("config, friction.angles", "[5, 15]", "[15, 25]"),
    }


def test_series_are_matched_by_name(baseline, tmp_path):
    def data(*series):
        rows = "".join(f"a,{name},computed,{x},{y},,\n" for name, y in series for x in (1, 2))
        return "panel,series,evidence,x_m_per_s,y_1,y_low,y_high\n" + rows

    other = results(tmp_path / "b")
    (baseline / "data/fig14.csv").write_text(data(("f = 0.1", 0.1), ("f = 0.2", 0.2)))
    (other / "data/fig14.csv").write_text(data(("f = 0.2", 0.2), ("f = 0.3", 0.3)))
    found = [(d.kind, d.row, d.reference, d.found) for d in compare(baseline, other).numbers]
    assert found == [
        ("missing row", "f = 0.1", "2 points", ""),
        ("extra row", "f = 0.3", "", "2 points"),
    ]


def test_figures_that_rest_on_a_changed_input_come_first(baseline, tmp_path):
    other = results(tmp_path / "b", slope=0.5)
    for root, slope in ((baseline, 0.2), (other, 0.4)):
        for name, rests_on in (("fig04", "the same"), ("fig17", f"slope {slope}")):
            draw(root, name, slope)
            write_checksums(root, [root / f"figures/{name}.svg"], rests_on)
        configured(root, restitution_fits={"points": slope})
    changes = compare(baseline, other)
    assert changes.resting == ("fig17",)
    assert [figure.name for figure in changes.figures] == ["fig17", "fig04", "fig14"]
    text = as_text(changes)
    assert text.index("Figures that rest on them: fig17.") < text.index("## Numbers")


def test_numbers_that_are_all_but_zero_do_not_lead(baseline, tmp_path):
    def table(small, mean, error):
        return f"case,mean,standard_error\na,{small},{error}\nb,{mean},0.1\nc,2.0,0.3\n"

    other = results(tmp_path / "b")
    (baseline / "tables/means.csv").write_text(table("1e-10", "1.0", "0.1"))
    (other / "tables/means.csv").write_text(table("9e-10", "1.1", "0.2"))
    found = worst([d for d in compare(baseline, other).numbers if d.file == "tables/means.csv"])
    assert [(d.row, d.column) for d in found] == [
        ("b", "mean"),
        ("a", "mean"),
        ("a", "standard_error"),
    ]


def test_a_claim_that_one_run_judged_is_a_change_of_verdict(baseline, tmp_path):
    other = results(tmp_path / "b", claims=CLAIMS + "C03,rolls,1,reproduced\n")
    (found,) = compare(baseline, other).verdicts
    assert (found.kind, found.row) == ("extra row", "C03")


def test_what_one_run_has_not_built_is_one_line(baseline, tmp_path):
    other = results(tmp_path / "b")
    draw(baseline, "fig20", 0.3)
    (other / "tables/claims.csv").unlink()
    changes = compare(baseline, other)
    assert changes.same
    assert changes.not_built == {
        "baseline": (),
        "changed": ("tables/claims.csv", "figures/fig20.svg"),
    }
    for told in (as_text(changes), page(changes)):
        assert f"2 files were not built in {other}." in told
        assert "fig20" not in told
    assert run("compare", other, baseline)[0] == 0


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
    drawn = [
        base64.b64decode(p["src"].removeprefix("data:image/svg+xml;base64,"), validate=True)
        for p in parsed.pictures
    ]
    assert drawn == [(root / "figures/fig14.svg").read_bytes() for root in (baseline, changed)]
    assert "color-scheme: light dark" in text


def test_the_page_needs_nothing_else(baseline, changed):
    text = page(compare(baseline, changed))
    parsed = Page(text)
    assert not {"link", "script", "iframe", "object", "base"} & {tag for tag, _ in parsed.tags}
    names = {name for _, given in parsed.tags for name in given}
    assert not {"href", "srcset", "style", "action"} & names
    assert all(link.startswith("data:") for link in parsed.links)
    without_pictures = re.sub(r"base64,[\w+/=]*", "", text)
    assert "//" not in without_pictures
    assert "url(" not in text
    assert "@import" not in text


def test_a_material_with_an_evil_name_stays_text(baseline, tmp_path):
    other = results(tmp_path / "b", inputs=INPUTS.replace("glass density", f'"{EVIL}"'), slope=0.5)
    draw(other, "<img src=x onerror=alert(1)>", 0.5)
    text = page(compare(baseline, other))
    parsed = Page(text)
    assert not parsed.has("script")
    assert not [name for _, given in parsed.tags for name in given if name.startswith("on")]
    assert EVIL in "".join(parsed.text)


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
