"""Files of digitised points: what they hold, and what is refused in one line. All are made up."""

from __future__ import annotations

import re

import numpy as np
import pytest
from study.figures.registry import registry
from tests.shared import ROOT

from study.declared.documents import ConfigError, load
from study.run.digitised import as_rows, read_folder, read_points
from study.tables import parse_table, points_series

CONFIG = ROOT / "config"
HEADER = "# source: made up\n# licence: CC0-1.0\n# digitised_by: nobody\n"
NAMES = "series,x,y,y_low,y_high\n"
TOP = HEADER + NAMES


@pytest.fixture(scope="module")
def figures():
    return registry(load(CONFIG / "figures.yaml"))


@pytest.fixture
def read(figures, tmp_path):
    """Return a function that reads a file of one figure from its content."""

    def of(content, figure="fig14"):
        path = tmp_path / f"{figure}.csv"
        data = content if isinstance(content, bytes) else content.encode()
        path.write_bytes(data)
        return read_points(str(path), figures[figure])

    return of


def test_a_file_is_read(read):
    points = read(TOP + '"e, slow",0.5,0.1,,\nfast,1e0,.25,0.2, 0.4\n')
    assert (points.figure, points.evidence) == ("fig14", "digitised")
    header = points.header
    assert (header.source, header.licence, header.digitised_by) == ("made up", "CC0-1.0", "nobody")
    table = points.table
    assert list(table["panel"]) == ["trends", "trends"]
    assert list(table["series"]) == [
        points_series("digitised", "e, slow"),
        points_series("digitised", "fast"),
    ]
    np.testing.assert_array_equal(
        table[["x", "y", "y_low", "y_high"]], [[0.5, 0.1, np.nan, np.nan], [1.0, 0.25, 0.2, 0.4]]
    )


def test_measured_points_are_told_apart_from_digitised_ones(read):
    points = read(TOP.replace("digitised_by", "measured_by") + "a,1,2,,\n")
    assert (points.header.measured_by, points.evidence) == ("nobody", "measured")
    assert list(points.table["series"]) == [points_series("measured", "a")]


@pytest.mark.parametrize(
    "rewritten",
    [
        lambda text: b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode(),
        lambda text: text.replace("\n", "\n\n").strip().encode(),
        lambda text: text.replace("a,1", '"a",1').replace("# ", "#  ").replace(": ", ":").encode(),
    ],
)
def test_what_programs_make_of_a_file_is_the_same_file(read, rewritten):
    plain = TOP + "a,1,2,,\nb,3,4,3,5\n"
    first, second = read(plain), read(rewritten(plain))
    assert first.table.equals(second.table)
    assert first.header == second.header


def test_the_panel_stands_before_the_name(read):
    table = read(TOP + "friction: a: b,30,0.1,,\nspin: a,30,0.1,,\n", "fig17").table
    assert list(table["panel"]) == ["friction", "spin"]
    assert list(table["series"]) == [points_series("digitised", name) for name in ("a: b", "a")]
    # An enlarged view belongs to the panel it shows.
    assert list(read(TOP + "dips: a,1,1,,\n", "fig20").table["panel"]) == ["force"]
    # An axis may begin below zero.
    assert read(TOP + "normal: a,-1,-0.2,,\n", "fig24").table["x"].item() == -1.0


@pytest.mark.parametrize("name", ["<script>alert(1)</script>", "$x", "5", "true"])
def test_a_name_is_text(read, name):
    points = read(TOP + f'"{name}",1,2,,\n')
    assert list(points.table["series"]) == [points_series("digitised", name)]
    text = as_rows({"fig14": points}, ["fig14"])["digitised"]
    # as a study reads it
    assert list(parse_table(text)["series"]) == [points_series("digitised", name)]


ROW = "a,1,2,,\n"
# fmt: off
MALFORMED = [
    ("", "the header is ; it must be series, x, y, y_low, y_high"),
    (TOP, "at least one point must follow"),
    (TOP.replace("# licence: CC0-1.0\n", "") + ROW, "header.licence: missing"),
    (TOP.replace("# digitised_by: nobody\n", "") + ROW, "header: give either digitised_by"),
    ("# measured_by: me\n" + TOP + ROW, "header: give either digitised_by or measured_by"),
    (TOP.replace("made up", "") + ROW, "header.source: '' must not be empty"),
    ("# license: MIT\n" + TOP + ROW, "header.license: unknown key (did you mean 'licence'?)"),
    ("# source: other\n" + TOP + ROW, "header: a key is given twice"),
    (TOP.replace("made up", "a\x1bb") + ROW, "header.source: 'a\\x1bb' must be printable"),
    (TOP.replace(",", ";") + "a;1;2;;\n", "the header is series;x"),
    (TOP + "a, b,1,2,,\n", "line 5: must have 5 fields, has 6; one with a comma needs"),
    (TOP + '"a"b,1,2,,\n', "line 5: "),
    (TOP + ",1,2,,\n", "line 5, series: '' must not be empty"),
    (TOP + "a\u202eb,1,2,,\n", "series: 'a\\u202eb' must be printable"),
    (TOP + 49 * "a" + ",1,2,,\n", "aaa' must have at most 48 characters"),
    (TOP + 'a,1,"2,5",,\n', "line 5, y: '2,5' must be a valid number"),
    (TOP + "a,,2,,\n", "line 5, x: None must be a valid number"),
    (TOP + "a,1,nan,,\n", "line 5, y: nan must be a finite number"),
    (TOP + "a,1,2,1,\n", "line 5, y_low and y_high must be given both or neither"),
    (TOP + "a,1,2,2.5,3\n", "line 5, y_low: 2.5 must not exceed y, 2"),
    (TOP + "a,1,2,1,1.5\n", "line 5, y_high: 1.5 must not be below y, 2"),
    (TOP + ROW + "b,1,2,,\na,1.0,2.00,,\n", "line 7, series: repeats the point of line 5"),
    (TOP.encode() + "é,1,2,,\n".encode("latin-1"), "must be a text in UTF-8, byte"),
]
# fmt: on


@pytest.mark.parametrize(("content", "message"), MALFORMED, ids=range(len(MALFORMED)))
def test_a_malformed_file_is_refused_by_its_place(read, content, message):
    with pytest.raises(ConfigError) as caught:
        read(content)
    assert any("/fig14.csv" in line and message in line for line in str(caught.value).split("\n"))


@pytest.mark.parametrize(
    ("row", "figure", "message"),
    [
        ("a,1,2,,", "fig17", "series: 'a' must be 'panel: name', panel one of friction, spin"),
        ("frction: a,1,2,,", "fig17", "panel one of friction, spin (did you mean 'friction'?)"),
        ("a,0,0.2,,", "fig16", "x: 0 must be positive, as the axis of 'restitution' is"),
        ("a,1,200,,", "fig16", "y: 200 is far off the axis of 'restitution'"),
    ],
)
def test_a_series_must_fit_its_figure(read, row, figure, message):
    with pytest.raises(ConfigError, match=re.escape(message)):
        read(TOP + row, figure)


def test_all_problems_come_together_and_of_many_the_first(read):
    with pytest.raises(ConfigError) as caught:
        read("# x: y\n" + TOP + "a,1,y,,\na,x,1,,\n")
    assert set(re.findall(r"header|line \d+", str(caught.value))) == {"header", "line 6", "line 7"}
    with pytest.raises(ConfigError) as caught:
        read(TOP + "a,1,y,,\n" * 1000)
    assert len(str(caught.value).split("\n")) == 20


@pytest.fixture
def folder(tmp_path):
    """Return a function that makes a folder of files with one point each."""

    def made(*names):
        for name in names:
            (tmp_path / name).write_text(TOP + ROW)
        return str(tmp_path)

    return made


def test_a_folder_holds_points_by_figure(figures, folder):
    assert read_folder(folder(), figures) == {}
    place = folder("fig16.csv", "fig14.csv", "README.md", ".x.csv", "fig14.csv~")
    assert list(read_folder(place, figures)) == ["fig14", "fig16"]


@pytest.mark.parametrize("name", ["fig014.csv", "fig14.txt", "fig03.csv", "ridge.csv"])
def test_a_file_for_no_plot_of_the_article_is_refused_by_name(figures, folder, name):
    with pytest.raises(ConfigError) as caught:
        read_folder(folder(name, "fig16.csv"), figures)
    (line,) = str(caught.value).split("\n")
    assert f"/{name}: must be named for a plot of the article" in line


def test_problems_of_all_files_are_told_together(figures, folder, tmp_path):
    (tmp_path / "fig15.csv").mkdir()
    (tmp_path / "fig17.csv").symlink_to("nothing.csv")
    place = folder("fig99.csv", "fig18.csv")
    with pytest.raises(ConfigError) as caught:
        read_folder(place, figures)
    lines = str(caught.value).split("\n")
    assert "fig15.csv: Is a directory" in lines[0]
    assert "fig17.csv: No such file" in lines[1]
    assert "fig18.csv, line 5, series" in lines[2]
    assert "fig99.csv: must be named" in lines[3]
    with pytest.raises(ConfigError, match="digitised: 'elsewhere' must be a folder"):
        read_folder("elsewhere", figures)


def test_the_shipped_folder_holds_no_points_and_its_example_is_one(figures, read):
    assert read_folder(str(CONFIG / "digitised"), figures) == {}
    text = (CONFIG / "digitised/README.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"^```csv\n(.*?)^```$", text, flags=re.DOTALL | re.MULTILINE)
    assert "made up" in example
    assert len(read(example, "fig16").table) == 3
