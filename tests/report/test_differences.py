"""Differences of tables: found both ways, within tolerances, and told in few lines."""

from __future__ import annotations

import io
import math

import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from microimpact.report.check.differences import Difference, Tolerance, compare_tables
from microimpact.report.check.wording import markdown, summary, worst


def table(text):
    return pd.read_csv(io.StringIO(text), dtype=object, keep_default_na=False)


def compared(reference, found, **options):
    return compare_tables("data/x.csv", table(reference), table(found), **options)


def kinds(reference, found, **options):
    return [d.kind for d in compared(reference, found, **options)]


CURVES = "series,x,y\na,1,10\na,2,20\nb,1,30\n"


def test_equal_tables_do_not_differ():
    assert compared(CURVES, CURVES) == []


def test_a_number_written_otherwise_is_the_same_number():
    assert compared(CURVES, CURVES.replace("a,1,10\n", "a,1.0,1e1\n")) == []


def test_a_changed_number_is_named_with_both_values():
    assert compared(CURVES, CURVES.replace("20", "22")) == [
        Difference(
            file="data/x.csv",
            kind="number",
            row="a #2",
            column="y",
            reference="20",
            found="22",
            relative=0.1,
        )
    ]


@pytest.mark.parametrize(
    ("tolerance", "value", "differs"),
    [
        (Tolerance(), 20 * (1 + 0.99e-8), False),
        (Tolerance(), 20 * (1 + 1.01e-8), True),
        (Tolerance(), 20 * (1 - 1.01e-8), True),
        # Powers of two: the boundary itself is exact, and belongs to what is accepted.
        (Tolerance(rtol=0, atol=0.5), 20.5, False),
        (Tolerance(rtol=0, atol=0.5), math.nextafter(20.5, 21), True),
        (Tolerance(rtol=0.25, atol=0), 25, False),
        (Tolerance(rtol=0.25, atol=0), math.nextafter(25, 26), True),
        (Tolerance(rtol=0.25, atol=0.5), 25.5, False),
        (Tolerance(rtol=0, atol=0), math.nextafter(20, 21), True),
    ],
)
def test_the_boundary_of_a_tolerance(tolerance, value, differs):
    found = compared(CURVES, CURVES.replace("20", repr(value)), tolerance=lambda column: tolerance)
    assert bool(found) == differs


def test_the_tolerance_is_relative_to_the_reference_not_to_what_was_found():
    assert not Tolerance(rtol=0.1).admits(10, 11.05)
    assert Tolerance(rtol=0.1).admits(11.05, 10)


def test_each_column_has_its_own_tolerance():
    wide = {"y": Tolerance(rtol=0.5)}
    found = compared(
        "x,y\n1,1\n", "x,y\n1.4,1.4\n", tolerance=lambda column: wide.get(column, Tolerance())
    )
    assert [d.column for d in found] == ["x"]


@pytest.mark.parametrize(
    ("before", "after", "differs"),
    [
        ("", "", False),
        ("", "nan", False),
        ("", "0", True),
        ("0", "", True),
        ("inf", "inf", False),
        ("inf", "1e308", True),
        ("1e308", "inf", True),
        ("inf", "-inf", True),
        ("0", "-0.0", False),
        ("0", "1e-300", True),
    ],
)
def test_missing_infinite_and_zero_numbers(before, after, differs):
    found = compared(f"x,y\n1,{before}\n", f"x,y\n1,{after}\n")
    assert bool(found) == differs
    assert all(d.relative == math.inf and d.kind == "number" for d in found)


@given(st.floats(), st.floats(), st.sampled_from([0.0, 1e-8, 0.1]))
def test_without_an_absolute_part_zero_infinity_and_nan_agree_with_themselves_only(a, b, rtol):
    agree = Tolerance(rtol=rtol).admits(a, b)
    if math.isnan(a) or math.isinf(a) or a == 0:
        assert agree == (a == b or (math.isnan(a) and math.isnan(b)))
    elif agree:
        assert abs(b - a) <= rtol * abs(a)


def test_text_must_be_equal():
    keyed = {"keys": ("id",)}
    (found,) = compared("id,verdict\nC1,yes\n", "id,verdict\nC1,no\n", **keyed)
    assert (found.kind, found.reference, found.found) == ("text", "yes", "no")
    assert math.isnan(found.relative)
    assert kinds("id,v\nC1,True\n", "id,v\nC1,False\n", **keyed) == ["text"]
    assert kinds("id,v\nC1,3\n", "id,v\nC1,three\n", **keyed) == ["text"]


def test_a_changed_word_is_one_change_not_a_lost_and_a_new_row():
    (found,) = compared("name,note,y\na,old,1\nb,same,2\n", "name,note,y\na,new,1\nb,same,2\n")
    assert (found.column, found.reference, found.found) == ("note", "old", "new")


def test_missing_and_extra_rows_are_found_both_ways():
    shorter = CURVES.replace("b,1,30\n", "")
    (lost,) = compared(CURVES, shorter)
    assert (lost.kind, lost.row, lost.reference) == ("missing row", "b", "x 1, y 30")
    (new,) = compared(shorter, CURVES)
    assert (new.kind, new.row, new.found) == ("extra row", "b", "x 1, y 30")


def test_a_lost_series_leaves_the_others_alone():
    many = "series,y\n" + "".join(f"{s},{i}\n" for s in "abc" for i in range(50))
    without = "".join(line for line in many.splitlines(True) if not line.startswith("b,"))
    found = compared(many, without)
    assert [d.kind for d in found] == ["missing row"] * 50
    assert all(d.row.startswith("b") for d in found)


def test_rows_may_be_reordered_if_keys_name_them():
    keyed = "file,key,value\nc,one,1\nc,two,2\nm,one,3\n"
    turned = "file,key,value\nm,one,3\nc,two,2\nc,one,1\n"
    assert compared(keyed, turned, keys=("file", "key")) == []


def test_rows_without_keys_are_compared_in_order():
    assert kinds("x,y\n1,1\n2,2\n", "x,y\n2,2\n1,1\n") == ["number"] * 4
    assert kinds("x,y\n1,1\n", "x,y\n1,1\n2,2\n") == ["extra row"]


def test_the_order_of_the_points_of_a_curve_counts():
    assert kinds("series,y\na,1\na,2\n", "series,y\na,2\na,1\n") == ["number"] * 2


def test_missing_and_extra_columns_are_found_both_ways():
    assert kinds("x,y\n1,2\n", "x\n1\n") == ["missing column"]
    assert kinds("x\n1\n", "x,y\n1,2\n") == ["extra column"]
    assert kinds("x,y\n1,2\n", "x,z\n1,2\n") == ["missing column", "extra column"]


def test_tables_without_rows():
    assert compared("x,y\n", "x,y\n") == []
    assert kinds("x,y\n", "x,y\n1,2\n") == ["extra row"]
    assert kinds("x,y\n1,2\n", "x,y\n") == ["missing row"]


def test_keys_that_read_alike_together_are_not_confused():
    before = 'a,b,y\n"p, q",r,1\np,"q, r",2\n'
    after = 'a,b,y\np,"q, r",1\n"p, q",r,2\n'
    assert len(compared(before, after, keys=("a", "b"))) == 2


def many(n):
    before = "series,y\n" + "".join(f"a,{i + 1}\n" for i in range(n))
    after = "series,y\n" + "".join(f"a,{(i + 1) * (1 + 1e-6 * (i + 1))}\n" for i in range(n))
    return compared(before, after)


def test_thousands_of_differences_stay_readable():
    found = many(5000)
    assert len(found) == 5000
    text = markdown(found)
    assert "### data/x.csv: 5000 numbers differ, largest relative difference 5.0e-03" in text
    assert "and 4995 more" in text
    assert len(text.splitlines()) < 15
    assert [round(d.relative * 1e6) for d in worst(found)] == [5000, 4999, 4998, 4997, 4996]


def test_a_few_of_every_kind_are_shown():
    lost = [Difference(file="f", kind="missing row", row=f"r{i}") for i in range(9)]
    shown = worst([*many(9), *lost], few=2)
    assert [d.kind for d in shown] == ["missing row"] * 2 + ["number"] * 2


def test_summary_counts_every_kind():
    found = [
        Difference(file="f", kind="missing row", row="a"),
        Difference(file="f", kind="number", relative=0.5),
        Difference(file="f", kind="number", relative=math.inf),
        Difference(file="f", kind="text"),
    ]
    assert summary(found) == (
        "1 row is missing, 1 text differs, 2 numbers differ, largest relative difference 5.0e-01"
    )


def test_cells_cannot_break_the_table():
    found = [Difference(file="f", kind="text", row="a|b\nc", column="x", reference="y" * 500)]
    rows = [line for line in markdown(found).splitlines() if line.startswith("|")]
    assert len(rows) == 3
    assert "a\\|b c" in rows[2]
    assert len(rows[2]) < 250
