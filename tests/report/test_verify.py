"""The check against references: what it names, what it refuses, and how references change."""

from __future__ import annotations

import gzip
import json
import shutil

import numpy as np
import pytest
from tests.report.results_roots import draw, results, run

from microimpact.report.check import verify as verification
from microimpact.report.check.results import ResultsError, read_cells, table_files
from microimpact.report.check.shapes import read_shape, structure
from microimpact.report.check.verify import concerned, renew, verify


@pytest.fixture
def built(tmp_path):
    return results(tmp_path / "built")


@pytest.fixture
def reference(tmp_path, built):
    target = tmp_path / "reference"
    target.mkdir()
    renew(built, target, verify(built, target))
    return target


def edit(path, old, new):
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def test_results_agree_with_what_was_made_from_them(built, reference):
    assert verify(built, reference) == []
    code, text, _ = run("check", built, "--reference", reference)
    assert code == 0
    assert "4 files agree" in text


def test_a_changed_number_names_its_figure_and_its_table(built, reference):
    edit(built / "data/fig14.csv", ",0.7,", ",0.7007,")
    edit(built / "tables/inputs.csv", "2500", "2502.5")
    code, text, _ = run("check", built, "--reference", reference)
    assert code == 1
    assert "\nFigures: fig14\nTables: inputs\n" in text
    assert "glass density" in text
    assert "| 2500 " in text
    assert "| 2502.5 " in text


def test_a_run_with_other_settings_is_one_line(built, reference):
    rows = "".join(f"config,a.b[{i}],{{}},,,-,chosen,x\n" for i in range(21))
    for root, value in ((built, 1024), (reference, 64)):
        table = root / "tables/inputs.csv"
        table.write_text(table.read_text() + rows.replace("{}", str(value)))
    code, text, error = run("check", built, "--reference", reference)
    assert (code, text) == (2, "")
    assert error.count("\n") == 1
    assert "21 inputs differ, as a.b[0]: 1024 where the references have 64" in error
    edit(built / "tables/inputs.csv", "a.b[20],1024", "a.b[20],64")
    assert run("check", built, "--reference", reference)[0] == 1


def test_differences_concern_every_figure_that_is_drawn_from_a_table(built, reference):
    edit(built / "data/fig14.csv", ",0.7,", ",0.7007,")
    found = verify(built, reference)
    drawn = {"fig14": ("fig14",), "overview": ("fig13", "fig14"), "fig13": ("fig13",)}
    assert concerned(found, drawn) == (["fig14", "overview"], [])


@pytest.mark.parametrize(
    ("name", "figures", "tables"),
    [
        ("tables/claims.csv", [], ["claims"]),
        ("data/fig14.csv", ["fig14"], []),
        ("figures/fig14.svg", ["fig14"], []),
    ],
)
def test_files_without_counterpart_fail_both_ways(built, reference, name, figures, tables):
    drawn = {"fig14": ("fig14",)}
    (built / name).rename(built / "aside")
    (lost,) = verify(built, reference)
    assert lost.kind == "missing file"
    assert concerned([lost], drawn) == (figures, tables)
    renew(built, reference, [lost], remove=True)
    assert verify(built, reference) == []
    (built / "aside").rename(built / name)
    (new,) = verify(built, reference)
    assert new.kind == "extra file"
    assert concerned([new], drawn) == (figures, tables)


@pytest.mark.parametrize(
    ("changes", "kind", "where"),
    [
        ({"label": "e"}, "structure", "texts"),
        ({"lines": 2}, "structure", "artists"),
        # Steeper by a third: the same lines, texts and ticks, another picture.
        ({"slope": 0.95}, "picture", "look"),
    ],
)
def test_another_picture_is_noticed(built, reference, changes, kind, where):
    draw(built, "fig14", **{"slope": 0.7} | changes)
    found = verify(built, reference)
    assert (kind, where) in {(d.kind, d.column) for d in found}
    assert {d.file for d in found} == {"figures/fig14"}


def test_the_same_figure_drawn_again_is_the_same(built, reference):
    draw(built, "fig14", 0.7)
    assert verify(built, reference) == []


def test_structure_tells_texts_ticks_and_points(built):
    parts = structure((built / "figures/fig14.svg").read_text())["axes_1"]
    assert {"speed", "e", "restitution"} <= set(parts["texts"])
    assert parts["y ticks"][:2] == ["0.0", "0.2"]
    assert "line2d: 30 points, 0 marks" in parts["artists"]
    assert "line2d: 0 points, 2 marks" in parts["artists"]


def test_a_thumbnail_is_the_picture_from_afar(built):
    grey = read_shape(built / "figures/fig14.svg").thumbnail
    assert grey.shape == (45, 64)
    assert grey[0, 0] == 255
    assert grey.min() < 200
    assert np.median(grey) == 255


TOLERANCE = "columns:\n- {file: data/fig*.csv, column: y_1, rtol: 0.01, reason: made up}\n"


def test_a_wider_tolerance_holds_for_its_column_alone(built, reference):
    (reference / "tolerances.yaml").write_text(TOLERANCE)
    edit(built / "data/fig14.csv", ",0.7,", ",0.7007,")
    assert verify(built, reference) == []
    edit(built / "data/fig14.csv", "1.0,0.7007", "1.001,0.7007")
    assert [d.column for d in verify(built, reference)] == ["x_m_per_s"]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (TOLERANCE.replace(", reason: made up", ""), "columns[0].reason: missing"),
        (TOLERANCE.replace("0.01", "-1"), "columns[0].rtol: -1 must be greater than or equal to 0"),
        (TOLERANCE.replace("rtol", "rtoll"), "columns[0].rtoll: unknown key"),
        (TOLERANCE.replace("y_1", "y_2"), "no table has a column 'y_2' in 'data/fig*.csv'"),
        (TOLERANCE.replace("fig*", "gif*"), "no table has a column 'y_1' in 'data/gif*.csv'"),
    ],
)
def test_tolerances_are_checked(built, reference, text, expected):
    (reference / "tolerances.yaml").write_text(text)
    code, _, error = run("check", built, "--reference", reference)
    assert code == 2
    assert expected in error
    assert "tolerances.yaml" in error


@pytest.mark.parametrize(
    ("name", "content", "expected"),
    [
        ("data/fig14.csv", "a,b\n1,2\n1,2,3\n", "data/fig14.csv, line 3: 3 fields where the"),
        ("data/fig14.csv", 'a,b\n1,"2\n', "data/fig14.csv, line 2: unexpected end of data"),
        ("data/fig14.csv", "", "data/fig14.csv, line 1: must be a header"),
        ("data/fig14.csv", "a,a\n", "data/fig14.csv, line 1: must be a header"),
        ("figures/fig14.svg", "<svg>\n<g></svg>", "figures/fig14.svg, line 2: mismatched tag"),
        ("figures/fig14.png", "no picture", "figures/fig14.png: cannot be read"),
    ],
)
def test_malformed_results_are_one_clear_error(built, reference, name, content, expected):
    (built / name).write_text(content)
    code, _, error = run("check", built, "--reference", reference)
    assert code == 2
    assert expected in error
    assert "Traceback" not in error


def test_malformed_references_are_one_clear_error(built, reference):
    (reference / "figures/fig14.json").write_text('{"structure": {}}\n')
    code, _, error = run("check", built, "--reference", reference)
    assert code == 2
    assert "fig14.json: not a reference of a figure" in error


def test_missing_folders_are_one_clear_error(built, reference, tmp_path):
    nothing = tmp_path / "nothing"
    for arguments in ((nothing, "--reference", reference), (built, "--reference", nothing)):
        code, _, error = run("check", *arguments)
        assert (code, error) == (2, f"microimpact: {nothing}: no such folder\n")
    nothing.mkdir()
    code, _, error = run("check", nothing, "--reference", reference)
    assert code == 2
    assert "not a results folder" in error


def test_references_change_by_command_only_and_show_what_changes(built, reference):
    edit(built / "data/fig14.csv", ",0.7,", ",0.7007,")
    before = {p: p.read_bytes() for p in reference.rglob("*.*")}
    assert run("check", built, "--reference", reference)[0] == 1
    assert before == {p: p.read_bytes() for p in reference.rglob("*.*")}
    code, text, _ = run("reference", built, "--reference", reference)
    assert code == 0
    assert "0.7007" in text
    assert "1 files changed" in text
    assert run("check", built, "--reference", reference)[0] == 0
    after = {p: p.read_bytes() for p in reference.rglob("*.*")}
    assert {p.name for p in after if after[p] != before[p]} == {"fig14.csv"}


def test_what_is_within_tolerance_is_not_written_anew(built, reference):
    edit(built / "data/fig14.csv", ",0.7,", ",0.700000001,")
    assert renew(built, reference, verify(built, reference)) == []


def test_a_partial_run_cannot_drop_references(built, reference):
    (built / "tables/claims.csv").unlink()
    code, _, error = run("reference", built, "--reference", reference)
    assert code == 2
    assert "lacks 1 files that have references (tables/claims.csv)" in error
    assert (reference / "tables/claims.csv").exists()
    assert run("reference", built, "--reference", reference, "--remove")[0] == 0
    assert not (reference / "tables/claims.csv").exists()


def test_large_tables_are_kept_compressed_and_nothing_is_left_out(built, reference, monkeypatch):
    monkeypatch.setattr(verification, "PLAIN_BYTES", 300)
    shutil.rmtree(reference)
    reference.mkdir()
    renew(built, reference, verify(built, reference))
    packed = reference / "data/fig14.csv.gz"
    assert len(gzip.decompress(packed.read_bytes()).splitlines()) == 31
    assert verify(built, reference) == []
    first = packed.read_bytes()
    edit(built / "data/fig14.csv", ",0.7,", ",0.8,")
    assert [d.reference for d in verify(built, reference)] == ["0.7"]
    edit(built / "data/fig14.csv", ",0.8,", ",0.7,")
    packed.unlink()
    renew(built, reference, verify(built, reference))
    assert packed.read_bytes() == first
    (built / "data/fig14.csv").write_text("series,y\na,1\n")
    renew(built, reference, verify(built, reference))
    assert list(table_files(reference).values())[-1] == reference / "data/fig14.csv"
    assert not packed.exists()


def test_references_hold_twelve_digits(built, reference):
    stored, computed = (read_cells(root / "data/fig14.csv") for root in (reference, built))
    for column in ("x_m_per_s", "y_1"):
        digits = [
            table[column].str.replace(".", "").str.lstrip("0").str.len().max()
            for table in (stored, computed)
        ]
        assert digits[0] == 12 < digits[1]
    assert list(stored["panel"]) == list(computed["panel"])


def test_figures_are_kept_as_readable_text(reference):
    kept = json.loads((reference / "figures/fig14.json").read_text())
    assert set(kept) == {"structure", "thumbnail"}
    assert len(kept["thumbnail"]) == 45


def test_the_first_references_are_made_beside_their_tolerances(built, tmp_path):
    (tmp_path / "new").mkdir()
    (tmp_path / "new/tolerances.yaml").write_text(TOLERANCE)
    assert run("reference", built, "--reference", tmp_path / "new")[0] == 0
    assert run("check", built, "--reference", tmp_path / "new")[0] == 0


def test_a_results_folder_is_not_what_any_folder_is(tmp_path):
    with pytest.raises(ResultsError, match="not a results folder"):
        verify(tmp_path, tmp_path)
