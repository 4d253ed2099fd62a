"""Files of digitised points: what they hold, and what is refused in one line. All are made up."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from tests.shared import ROOT

from microimpact.core.tables import parse_table, points_series, series_frame
from microimpact.declared.documents import load
from microimpact.figures.registry import registry
from microimpact.run.digitised import DigitisedError, as_rows, overlaid, read_folder, read_points

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
    assert (points.figure, points.source) == ("fig14", "made up")
    assert (points.licence, points.by, points.evidence) == ("CC0-1.0", "nobody", "digitised")
    table = points.table
    assert list(table["panel"]) == ["trends", "trends"]
    assert list(table["series"]) == [
        points_series("digitised", "e, slow"),
        points_series("digitised", "fast"),
    ]
    np.testing.assert_array_equal(
        table[["x", "y", "y_low", "y_high"]], [[0.5, 0.1, np.nan, np.nan], [1.0, 0.25, 0.2, 0.4]]
    )


def test_measured_points_are_told_apart_from_digitised_ones(read, figures):
    points = read(TOP.replace("digitised_by", "measured_by") + "a,1,2,,\n")
    assert (points.by, points.evidence) == ("nobody", "measured")
    assert list(points.table["series"]) == [points_series("measured", "a")]
    frame = series_frame(
        panel="trends", series="s", evidence="computed", x=[1.0], y=[1.0], x_unit="m_per_s",
        y_unit="1",
    )  # fmt: skip
    drawn = overlaid({"fig14": frame}, figures["fig14"], points)["fig14"]
    assert list(drawn["evidence"]) == ["computed", "measured"]


@pytest.mark.parametrize(
    "rewritten",
    [
        lambda text: b"\xef\xbb\xbf" + text.encode(),
        lambda text: text.replace("\n", "\r\n").encode(),
        lambda text: text.replace("\n", "\r").encode(),
        lambda text: text.replace("\n", "\n\n").encode(),
        lambda text: text.strip().encode(),
        lambda text: text.replace("a,1", '"a",1').encode(),
        lambda text: text.replace("# ", "#  ").replace(": ", ":").encode(),
    ],
)
def test_what_programs_make_of_a_file_is_the_same_file(read, rewritten):
    plain = TOP + "a,1,2,,\nb,3,4,3,5\n"
    one, other = read(plain), read(rewritten(plain))
    assert one.table.equals(other.table)
    assert one.source == other.source


def test_the_panel_stands_before_the_name(read):
    table = read(TOP + "friction: a: b,30,0.1,,\nspin: a,30,0.1,,\n", "fig17").table
    assert list(table["panel"]) == ["friction", "spin"]
    assert list(table["series"]) == [
        points_series("digitised", "a: b"),
        points_series("digitised", "a"),
    ]


def test_points_of_an_enlarged_view_belong_to_the_panel_it_shows(read):
    assert list(read(TOP + "dips: a,1,1,,\n", "fig20").table["panel"]) == ["force"]


@pytest.mark.parametrize("name", ["<script>alert(1)</script>", "$x", "_x", "5", "true", "é £", "'"])
def test_a_name_is_text(read, name):
    points = read(TOP + f'"{name}",1,2,,\n')
    assert list(points.table["series"]) == [points_series("digitised", name)]
    text = as_rows({"fig14": points}, ["fig14"])["digitised"]
    # as a study reads it
    assert list(parse_table(text)["series"]) == [points_series("digitised", name)]


def test_thousands_of_points(read):
    rows = "".join(f"a,{i * 1e-4:g},{i * 2e-5:g},,\n" for i in range(20000))
    assert len(read(TOP + rows).table) == 20000


ROW = "a,1,2,,\n"
MALFORMED = {
    "nothing": ("", 4, "line 1, column names: the line series,x,y,y_low,y_high is missing"),
    "no points": (TOP, 1, "line 4, column series: at least one point must follow"),
    "no header": (NAMES + ROW, 3, "line 1, header: '# source: ...' is missing"),
    "one key less": (
        HEADER.replace("# licence: CC0-1.0\n", "") + NAMES + ROW,
        1,
        "line 1, header: '# licence: ...' is missing",
    ),
    "nobody": (
        HEADER.replace("# digitised_by: nobody\n", "") + NAMES + ROW,
        1,
        "line 1, header: '# digitised_by or measured_by: ...' is missing",
    ),
    "two origins": (
        "# measured_by: me\n" + TOP + ROW,
        1,
        "line 1, header: give either digitised_by or measured_by, not both",
    ),
    "empty key": (TOP.replace("made up", "") + ROW, 1, "line 1, header: 'source' is empty"),
    "unknown key": (
        "# license: MIT\n" + TOP + ROW,
        1,
        "line 1, header: unknown key 'license' (did you mean 'licence'?)",
    ),
    "key in capitals": (
        "# Source: me\n" + TOP + ROW,
        1,
        "header: unknown key 'Source' (did you mean 'source'?)",
    ),
    "key twice": (
        HEADER + "# source: other\n" + NAMES + ROW,
        1,
        "line 4, header: 'source' is given twice",
    ),
    "a mere remark": ("# by hand\n" + TOP + ROW, 1, "header: '# by hand' must be '# key: text'"),
    "control character": (TOP.replace("made up", "a\x1bb") + ROW, 1, "header: 'source' 'a\\x1bb'"),
    "late comment": (TOP + ROW + "# x: y\n", 1, "line 6, column series: comments must stand above"),
    "column missing": (
        HEADER + "series,x,y\na,1,2\n",
        1,
        "line 4, column names: column 'y_low' is missing, column 'y_high' is missing",
    ),
    "column misnamed": (
        HEADER + "series,x,y,y_low,y_hi\n" + ROW,
        1,
        "line 4, column names: column 'y_high' is missing, column 'y_hi' is not expected",
    ),
    "columns out of order": (
        HEADER + "x,series,y,y_low,y_high\n" + ROW,
        1,
        "line 4, column names: columns are in another order",
    ),
    "semicolons": (TOP.replace(",", ";") + "a;1;2;;\n", 1, "column names: column 'series' is miss"),
    "too few fields": (TOP + "a,1,2\n", 1, "line 5, column y: must have 5 fields, has 3"),
    "comma without quotes": (
        TOP + "a, b,1,2,,\n",
        1,
        "must have 5 fields, has 6; a series name with a comma must stand in double quotes",
    ),
    "quote left open": (TOP + '"a,1,2,,\n' + ROW, 1, "line 5, column series: quotes must enclose"),
    "quote amid a field": (TOP + '"a"b,1,2,,\n', 1, "line 5, column series: quotes must enclose"),
    "no name": (TOP + ",1,2,,\n", 1, "line 5, column series: name '' must be 1 to 48 printable"),
    "space around a name": (TOP + " a,1,2,,\n", 1, "line 5, column series: name ' a' must be"),
    "unprintable name": (TOP + "a\u202eb,1,2,,\n", 1, "name 'a\\u202eb' must be"),
    "byte zero": (TOP + "a\0,1,2,,\n", 1, "name 'a\\x00' must be"),
    "endless name": (TOP + 49 * "a" + ",1,2,,\n", 1, "column series: name 'aaa"),
    "a panel that goes without saying": (
        TOP + "trends: a,1,2,,\n",
        1,
        "column series: fig14 has one panel, write just 'a'",
    ),
    "no number": (TOP + "a,one,2,,\n", 1, "line 5, column x: 'one' must be a finite number"),
    "decimal comma": (TOP + 'a,1,"2,5",,\n', 1, "line 5, column y: '2,5' must be a finite number"),
    "empty number": (TOP + "a,,2,,\n", 1, "line 5, column x: '' must be a finite number"),
    "nan": (TOP + "a,1,nan,,\n", 1, "line 5, column y: 'nan' must be a finite number"),
    "infinite": (TOP + "a,1,1e999,,\n", 1, "line 5, column y: '1e999' must be a finite number"),
    "underscore": (TOP + "a,1_0,2,,\n", 1, "line 5, column x: '1_0' must be a finite number"),
    "other digits": (TOP + "a,١,2,,\n", 1, "line 5, column x: '١' must be a finite number"),
    "half a bar": (TOP + "a,1,2,1,\n", 1, "line 5, column y_high: is empty, y_low and y_high must"),
    "other half": (TOP + "a,1,2,,3\n", 1, "line 5, column y_low: is empty, y_low and y_high must"),
    "bar above": (TOP + "a,1,2,2.5,3\n", 1, "line 5, column y_low: 2.5 must not exceed y, 2"),
    "bar below": (TOP + "a,1,2,1,1.5\n", 1, "line 5, column y_high: 1.5 must not be below y, 2"),
    "bar upside down": (TOP + "a,1,2,3,1\n", 2, "line 5, column y_high: 1 must not be below y, 2"),
    "the same point": (
        TOP + ROW + "b,1,2,,\n" + "a,1.0,2.00,,\n",
        1,
        "line 7, column series: repeats the point of line 5",
    ),
    "latin-1": (
        TOP.encode() + "é,1,2,,\n".encode("latin-1"),
        1,
        "line 5, column 1 (bytes): must be UTF-8 text, has the byte 0xe9",
    ),
    "utf-16": ((TOP + ROW).encode("utf-16"), 1, "line 1, column 1 (bytes): must be UTF-8 text"),
}


@pytest.mark.parametrize(("content", "lines", "message"), MALFORMED.values(), ids=MALFORMED)
def test_a_malformed_file_is_told_by_line_and_column(read, content, lines, message):
    with pytest.raises(DigitisedError) as caught:
        read(content)
    found = str(caught.value).split("\n")
    assert len(found) == lines
    place = re.compile(r".*/fig14\.csv, line \d+, (header|column [a-z_0-9 ()]+): ")
    assert all(place.match(line) for line in found)
    assert any(message in line for line in found)


@pytest.mark.parametrize(
    ("row", "figure", "message"),
    [
        ("a,1,2,,", "fig17", "series: 'a' must be 'panel: name', panel one of friction, spin"),
        ("frction: a,1,2,,", "fig17", "series: fig17 has no panel 'frction' (did you mean 'fric"),
        ("spin: ,1,2,,", "fig17", "series: name '' must be"),
        ("a,0,0.2,,", "fig16", "x: 0 must be positive, as the axis of 'restitution' is"),
        ("half_normal: a,-1,2,,", "fig24", "x: -1 must be positive"),
    ],
)
def test_a_series_must_fit_its_figure(read, row, figure, message):
    with pytest.raises(DigitisedError, match=re.escape(f"line 5, column {message}")):
        read(TOP + row, figure)


def test_a_point_below_zero_is_one_where_the_axis_begins_there(read):
    assert read(TOP + "normal: a,-1,-0.2,,\n", "fig24").table["x"].item() == -1.0


def test_all_problems_come_in_order_and_the_many_are_counted(read):
    with pytest.raises(DigitisedError) as caught:
        read("# x: y\n" + TOP + "a,1,y,,\na,x,1,,\n")
    assert [int(n) for n in re.findall(r"line (\d+)", str(caught.value))] == [1, 6, 7]
    with pytest.raises(DigitisedError) as caught:
        read(TOP + "a,1,y,,\n" * 1000)
    lines = str(caught.value).split("\n")
    assert len(lines) == 21
    assert lines[-1].endswith("fig14.csv: 980 more problems")


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


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("fig014.csv", "no figure 'fig014' (did you mean 'fig14'?)"),
        ("Fig14.csv", "no figure 'Fig14' (did you mean 'fig14'?)"),
        ("fig14.CSV", "must be named figNN.csv for a figure (did you mean 'fig14'?)"),
        ("fig14.txt", "must be named figNN.csv"),
        ("fig03.csv", "'fig03' is a schematic and takes no digitised points"),
        ("ridge.csv", "'ridge' is no figure of the article and takes no digitised points"),
    ],
)
def test_a_file_for_no_figure_is_refused_by_name(figures, folder, name, message):
    with pytest.raises(DigitisedError) as caught:
        read_folder(folder(name, "fig16.csv"), figures)
    (line,) = str(caught.value).split("\n")
    assert f"/{name}: {message}" in line


def test_problems_of_all_files_are_told_together(figures, folder, tmp_path):
    (tmp_path / "fig15.csv").mkdir()
    (tmp_path / "fig17.csv").symlink_to("nothing.csv")
    place = folder("fig99.csv", "fig18.csv")
    with pytest.raises(DigitisedError) as caught:
        read_folder(place, figures)
    lines = str(caught.value).split("\n")
    assert "fig15.csv: Is a directory" in lines[0]
    assert "fig17.csv: No such file" in lines[1]
    assert "fig18.csv, line 5, column series" in lines[2]
    assert "fig99.csv: no figure" in lines[3]
    with pytest.raises(DigitisedError, match="digitised: 'elsewhere' must be a folder"):
        read_folder("elsewhere", figures)


def test_the_shipped_folder_holds_no_points_and_its_example_is_one(figures, read):
    assert read_folder(str(CONFIG / "digitised"), figures) == {}
    text = (CONFIG / "digitised/README.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"^```csv\n(.*?)^```$", text, flags=re.DOTALL | re.MULTILINE)
    assert "made up" in example
    assert len(read(example, "fig16").table) == 3


def test_figure_data_get_the_points_as_rows_of_their_own(read, figures):
    points = read(TOP + "R,1,2,1,3\n")
    # a series of the same name as a computed one stays apart from it
    own = series_frame(
        panel="trends", series="R", evidence="computed", x=[1, 2], y=1, x_unit="m_per_s", y_unit="1"
    )
    table = overlaid({"fig14": own}, figures["fig14"], points)["fig14"]
    assert list(table.columns) == list(own.columns)
    assert list(table["series"]) == ["R", "R", points_series("digitised", "R")]
    assert list(table["evidence"]) == ["computed", "computed", "digitised"]
    assert table.iloc[2, 3:].tolist() == [1.0, 2.0, 1.0, 3.0]


def test_a_study_is_given_the_points_of_its_figures_alone(read):
    points = read(TOP + ROW)
    both = {"fig14": points, "fig16": replace(points, figure="fig16")}
    assert as_rows({}, ["fig15"]) == as_rows(both, ["fig15"]) == {}
    assert list(parse_table(as_rows(both, ["fig16"])["digitised"])["figure"]) == ["fig16"]
