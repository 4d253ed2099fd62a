"""Files of digitised points: what they hold, and what is refused in one line. All are made up."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd
import pytest
from tests.shared import ROOT

from study.declared.documents import ConfigError
from study.run.digitised import files_of, overlaid

CONFIG = ROOT / "config"
TOP = "# source: made up\n# digitised_by: nobody\nseries,x,y,y_low,y_high\n"
ROW = "a,1,2,,\n"
COLUMNS = ("panel", "series", "evidence", "x_m_per_s", "y_1", "y_low", "y_high")
TABLE = pd.DataFrame(columns=list(COLUMNS))


@pytest.fixture
def read(figures, tmp_path):
    """Return a function that returns the points of a file of one figure from its content."""

    def of(content, figure="fig14"):
        path = tmp_path / f"{figure}.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        spec = figures[figure]
        return overlaid({spec.data[0]: TABLE}, spec, str(path))[spec.data[0]]

    return of


def test_a_file_is_read(read):
    points = read(TOP + '"e, slow",0.5,0.1,,\nfast,1e0,.25,0.2, 0.4\n')
    assert list(points["panel"]) == ["trends", "trends"]
    assert list(points["series"]) == ["digitised: e, slow", "digitised: fast"]
    np.testing.assert_array_equal(
        points.iloc[:, 3:].astype(float), [[0.5, 0.1, np.nan, np.nan], [1.0, 0.25, 0.2, 0.4]]
    )
    measured = read(TOP.replace("digitised_by", "measured_by") + ROW + ROW)
    assert list(measured["evidence"]) == ["measured", "measured"]


@pytest.mark.parametrize(
    "rewritten",
    [
        lambda text: b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode(),
        lambda text: text.replace("\n", "\n\n").strip().encode(),
        lambda text: text.replace("a,1", '"a",1').encode(),
    ],
)
def test_what_programs_make_of_a_file_is_the_same_file(read, rewritten):
    plain = TOP + "a,1,2,,\nb,3,4,3,5\n"
    pd.testing.assert_frame_equal(read(plain), read(rewritten(plain)))


def test_the_panel_stands_before_the_name(read):
    table = read(TOP + "friction: a: b,30,0.1,,\nspin: a,30,0.1,,\n", "fig17")
    assert list(table["panel"]) == ["friction", "spin"]
    assert list(table["series"]) == ["digitised: a: b", "digitised: a"]
    # An enlarged view belongs to the panel it shows.
    assert list(read(TOP + "dips: a,1,1,,\n", "fig20")["panel"]) == ["force"]
    # An axis may begin below zero.
    assert read(TOP + "normal: a,-1,-0.2,,\n", "fig24").iloc[0, 3] == -1.0


# fmt: off
MALFORMED = [
    ("", "the header is ; it must be series, x, y, y_low, y_high"),
    (TOP, "at least one point must follow"),
    (TOP.replace("# digitised_by: nobody\n", "") + ROW, "a comment must say who: '# digitised_by"),
    ("# measured_by: me\n" + TOP + ROW, "a comment must say who: '# digitised_by: ...' or '# mea"),
    (TOP.replace(",", ";") + "a;1;2;;\n", "the header is series;x"),
    (TOP + "a, b,1,2,,\n", "line 4: must have 5 fields, has 6; one with a comma needs"),
    (TOP + '"a"b,1,2,,\n', "line 4: "),
    (TOP + ",1,2,,\n", "line 4, series: '' must not be empty"),
    (TOP + "a\u202eb,1,2,,\n", "series: 'a\\u202eb' must be printable"),
    (TOP + 41 * "a" + ",1,2,,\n", "aaa' must have at most 40 characters"),
    (TOP + 'a,1,"2,5",,\n', "line 4, y: '2,5' must be a valid number"),
    (TOP + "a,,2,,\n", "line 4, x: None must be a valid number"),
    (TOP + "a,1,nan,,\n", "line 4, y: nan must be a finite number"),
    (TOP + "a,1,2,1,\n", "line 4, y_low and y_high must be given both or neither"),
    (TOP + "a,1,2,2.5,3\n", "line 4, y: 2 must lie within y_low and y_high"),
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
    ],
)
def test_a_series_must_fit_its_figure(read, row, figure, message):
    with pytest.raises(ConfigError, match=re.escape(message)):
        read(TOP + row, figure)


@pytest.fixture
def folder(tmp_path):
    """Return a function that makes a folder of files with one point each."""

    def made(*names):
        for name in names:
            (tmp_path / name).write_text(TOP + ROW)
        return str(tmp_path)

    return made


def test_a_folder_holds_points_by_figure(figures, folder):
    assert files_of(folder(), figures) == {}
    place = folder("fig16.csv", "fig14.csv", "README.md", ".x.csv", "fig14.csv~")
    assert list(files_of(place, figures)) == ["fig14", "fig16"]


@pytest.mark.parametrize("name", ["fig014.csv", "fig14.txt", "fig03.csv", "ridge.csv"])
def test_a_file_for_no_plot_of_the_article_is_refused_by_name(figures, folder, name):
    with pytest.raises(ConfigError) as caught:
        files_of(folder(name, "fig16.csv"), figures)
    (line,) = str(caught.value).split("\n")
    assert f"/{name}: must be named for a plot of the article" in line


def test_problems_of_all_files_are_told_together(figures, folder, tmp_path):
    (tmp_path / "fig15.csv").mkdir()
    (tmp_path / "fig17.csv").symlink_to("nothing.csv")
    place = folder("fig99.csv", "fig18.csv")
    with pytest.raises(ConfigError) as caught:
        files_of(place, figures)
    lines = str(caught.value).split("\n")
    assert "fig15.csv: Is a directory" in lines[0]
    assert "fig17.csv: No such file" in lines[1]
    assert "fig18.csv, line 4, series" in lines[2]
    assert "fig99.csv: must be named" in lines[3]
    with pytest.raises(ConfigError, match="digitised: 'elsewhere' must be a folder"):
        files_of("elsewhere", figures)


def test_the_shipped_folder_holds_no_points_and_its_example_is_one(figures, read):
    assert files_of(str(CONFIG / "digitised"), figures) == {}
    text = (CONFIG / "digitised/README.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"^```csv\n(.*?)^```$", text, flags=re.DOTALL | re.MULTILINE)
    assert "made up" in example
    assert len(read(example, "fig16")) == 3
