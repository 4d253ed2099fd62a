"""The check against references: what it names, what it refuses, and how references change."""

from __future__ import annotations

import gzip
import io
import math
import re
from shutil import rmtree

import pandas as pd
import pytest
from tests.study.report.results_roots import edit, results, run

from study.report.check import verify as verification
from study.report.check.differences import Tolerance, compare_tables
from study.report.check.results import read_cells
from study.report.check.verify import renew, verify

WIDE = Tolerance(file="*", column="*", reason="made up", rtol=0.25, atol=0.5)
CURVES = "name,x,y\na,1,10\na,2,20\nb,1,30\n"


def compared(before, after, tolerance=None):
    tables = (
        pd.read_csv(io.StringIO(text), dtype=object, keep_default_na=False)
        for text in (before, after)
    )
    return compare_tables("tables/x.csv", *tables, [tolerance] if tolerance else ())


@pytest.fixture
def built(tmp_path):
    return results(tmp_path / "built")


@pytest.fixture
def reference(tmp_path, built):
    target = tmp_path / "reference"
    target.mkdir()
    renew(built, target, verify(built, target))
    return target


@pytest.mark.parametrize(
    ("after", "expected"),
    [
        # The same number, written otherwise; rows of other names in another order.
        (CURVES.replace("a,1,10\n", "a,1.0,1e1\n"), []),
        ("name,x,y\nb,1,30\na,1,10\na,2,20\n", []),
        (CURVES.replace("20", "22"), [("number", "a #2", "y", "20", "22")]),
        (CURVES.replace("20", ""), [("number", "a #2", "y", "20", "")]),
        (CURVES.replace("b,1,30\n", ""), [("missing row", "b", "", "x 1, y 30", "")]),
        (CURVES + "b,2,4\n", [("extra row", "b #2", "", "", "x 2, y 4")]),
        (
            "name,x,z\na,1,10\na,2,20\nb,1,30\n",
            [("missing column", "", "y", "", ""), ("extra column", "", "z", "", "")],
        ),
    ],
)
def test_all_differences_of_tables_are_named_with_both_cells(after, expected):
    fields = ("kind", "row", "column", "reference", "result")
    differences = compared(CURVES, after)
    assert [tuple(getattr(d, name) for name in fields) for d in differences] == expected


def test_rows_of_numbers_alone_are_matched_by_their_order():
    (difference,) = compared("x,y\n1,10\n2,20\n", "x,y\n1,10\n2,22\n")
    assert (difference.row, difference.column, difference.result) == ("row 2", "y", "22")


@pytest.mark.parametrize(
    ("tolerance", "value", "differs"),
    [
        (None, 20 * (1 + 0.99e-8), False),
        (None, 20 * (1 + 1.01e-8), True),
        (None, 20 * (1 - 1.01e-8), True),
        # Powers of two: the bound itself is exact, and belongs to what is accepted.
        (WIDE, 25.5, False),
        (WIDE, math.nextafter(25.5, 26), True),
    ],
)
def test_the_bound_of_a_tolerance_is_relative_to_the_reference(tolerance, value, differs):
    assert bool(compared(CURVES, CURVES.replace("20", repr(value)), tolerance)) == differs


@pytest.mark.parametrize(
    ("before", "after", "kinds"),
    [
        ("", "nan", []),
        ("", "0", ["number"]),
        ("inf", "inf", []),
        ("inf", "-inf", ["number"]),
        ("0", "1e-300", ["number"]),
        ("True", "False", ["text"]),
    ],
)
def test_missing_infinite_and_zero_numbers_agree_with_themselves_alone(before, after, kinds):
    differences = compared(f"x,y\n1,{before}\n", f"x,y\n1,{after}\n")
    assert [d.kind for d in differences] == kinds


def test_results_agree_with_references_made_from_them(built, reference):
    assert verify(built, reference) == []
    code, text, _ = run("check", built, "--reference", reference)
    assert code == 0
    assert "5 files agree" in text


@pytest.mark.parametrize(
    ("file", "old", "new", "named"),
    [
        ("data/fig14.csv", ",0.7,", ",0.70000007,", "none, fig14, none"),
        ("tables/inputs.csv", "2500", "2502.5", "inputs, none, none"),
        ("tables/claims.csv", ",reproduced", ",calibrated", "claims, none, none"),
        ("figures/fig14.csv", "Restitution", "Loss", "none, none, fig14"),
        ("figures/fig14.csv", "#0072b2 1.2", "#d55e00 1.2", "none, none, fig14"),
        ("figures/fig14.csv", "#0072b2 1.2:", "#0072b2 1.2 - -:", "none, none, fig14"),
    ],
)
def test_a_changed_cell_names_its_table_data_or_figure(built, reference, file, old, new, named):
    edit(built / file, old, new)
    code, text, _ = run("check", built, "--reference", reference)
    assert code == 1
    assert ", ".join(re.findall(r"^(?:Tables|Data|Figures): (.*)$", text, re.MULTILINE)) == named
    assert all(cell.strip(",") in text for cell in (old, new))


def test_files_without_counterpart_fail_both_ways(built, reference):
    name = "figures/fig14.csv"
    text = (built / name).read_text()
    (built / name).unlink()
    (lost,) = verify(built, reference)
    assert (lost.kind, lost.file) == ("missing file", name)
    renew(built, reference, [lost], remove=True)
    assert verify(built, reference) == []
    (built / name).write_text(text)
    (new,) = verify(built, reference)
    assert (new.kind, new.file) == ("extra file", name)


def test_a_run_with_other_settings_is_one_line(built, reference):
    rows = "".join(f"config,a.b[{i}],{{}},,,-,chosen,x,\n" for i in range(21))
    for root, value in ((built, 1024), (reference, 64)):
        table = root / "tables/inputs.csv"
        table.write_text(table.read_text() + rows.replace("{}", str(value)))
    code, _, error = run("check", built, "--reference", reference)
    assert code == 2
    assert "21 inputs differ, as a.b[0]: 1024 where the references have 64" in error


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
        (TOLERANCE.replace("y_1", "y_2"), "no table has a column 'y_2' in 'data/fig*.csv'"),
    ],
)
def test_tolerances_are_checked(built, reference, text, expected):
    (reference / "tolerances.yaml").write_text(text)
    with pytest.raises(ValueError, match=re.escape(expected)):
        verify(built, reference)


def test_a_malformed_table_is_one_clear_error(built, reference):
    (built / "data/fig14.csv").write_text("a,b\n1,2\n1,2,3\n")
    code, _, error = run("check", built, "--reference", reference)
    assert code == 2
    assert "data/fig14.csv, line 3: 3 fields where the" in error


def test_folders_without_results_are_one_clear_error(built, reference, tmp_path):
    nothing = tmp_path / "nothing"
    code, _, error = run("check", nothing, "--reference", reference)
    assert (code, error) == (2, f"microimpact: {nothing}: no such folder\n")
    nothing.mkdir()
    code, _, error = run("check", nothing, "--reference", reference)
    assert code == 2
    assert "not a results folder" in error


def test_references_change_by_command_alone_where_they_differ(built, reference):
    def content():
        return {path: path.read_bytes() for path in reference.rglob("*.*")}

    before = content()
    edit(built / "data/fig14.csv", ",0.7,", ",0.7007,")
    edit(built / "tables/claims.csv", "0.44", "0.440000000001")
    assert run("check", built, "--reference", reference)[0] == 1
    assert before == content()
    code, text, _ = run("reference", built, "--reference", reference)
    assert code == 0
    assert "0.7007" in text
    assert "1 files changed" in text
    assert run("check", built, "--reference", reference)[0] == 0
    after = content()
    assert [path.name for path in after if after[path] != before[path]] == ["fig14.csv"]


def test_a_partial_run_cannot_drop_references(built, reference):
    (built / "tables/claims.csv").unlink()
    code, _, error = run("reference", built, "--reference", reference)
    assert code == 2
    assert "lacks 1 files that have references (tables/claims.csv)" in error
    assert run("reference", built, "--reference", reference, "--remove")[0] == 0
    assert not (reference / "tables/claims.csv").exists()


def test_large_tables_are_kept_compressed_in_twelve_digits(built, reference, monkeypatch):
    monkeypatch.setattr(verification, "PLAIN_BYTES", 100)
    edit(built / "data/fig14.csv", ",0.7,", ",0.70000000000000123,")
    rmtree(reference)
    reference.mkdir()
    renew(built, reference, verify(built, reference))
    packed = reference / "data/fig14.csv.gz"
    assert len(gzip.decompress(packed.read_bytes()).splitlines()) == 6
    assert list(read_cells(packed)["y_1"])[-1] == "0.7"
    assert verify(built, reference) == []
