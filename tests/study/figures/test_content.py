"""The content of a figure holds its words and the looks and places of all that is drawn."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import pytest
from matplotlib import rcParams
from matplotlib.artist import getp
from tests.study.figures.test_pictures import SPECS, drawn

from study.figures import style
from study.figures.content import content


def style_colours():
    with style.context():
        return rcParams["axes.prop_cycle"].by_key()["color"]


def shown(spec, path, alter=None):
    with style.context():
        figure = drawn(spec)
        if alter:
            alter(figure)
        style.save(figure, path)
        table = content(figure, spec)
    return table.astype(object).fillna("")


def changes(name, path, alter=None, **changed):
    """Return the cells that differ, by column, once a figure is drawn in another way.

    `alter` changes the picture after it was drawn, `changed` what is declared.
    """
    before = shown(SPECS[name], path)
    after = shown(replace(SPECS[name], **changed), path, alter)
    assert before.shape == after.shape
    differ = before != after
    return {column: list(before.index[differ[column]]) for column in before if differ[column].any()}


@pytest.mark.parametrize(
    ("name", "panel", "look"),
    [
        ("fig17", "friction", "color"),
        ("fig20", "force", "color"),
        ("fig20", "force", "linestyle"),
        ("fig24", "normal", "color"),
        ("fig04", "all", "markerfacecolor"),
    ],
)
def test_exchanged_looks_of_two_series_are_seen(name, panel, look, tmp_path):
    def exchange(figure):
        (ax,) = (ax for ax in figure.axes if ax.get_label() == panel)
        lines = [line for line in ax.lines if len(line.get_xdata()) > 2]
        one, other = next(
            pair
            for pair in combinations(lines, 2)
            if len({str(getp(each, look)) for each in pair}) > 1
        )
        mine = getp(one, look)
        one.set(**{look: getp(other, look)})
        other.set(**{look: mine})

    cells = changes(name, tmp_path / "a.svg", exchange)
    assert set(cells) == {"look"}
    assert len(cells["look"]) >= 2


def test_title_and_caption_are_content(tmp_path):
    cells = changes("fig14", tmp_path / "a.svg", title="Another", caption="Other words")
    assert cells == {"text": [0, 2]}


def test_a_panel_a_tenth_wider_moves_what_is_in_it(tmp_path):
    def widen(figure):
        (ax,) = figure.axes
        ax.set_xlim(right=1.1 * ax.get_xlim()[1])

    assert {"x_high"} <= set(changes("fig14", tmp_path / "a.svg", widen))


def test_all_that_is_drawn_lies_on_the_sheet_and_is_named(tmp_path):
    spec = SPECS["fig04"]
    table = shown(spec, tmp_path / "a.svg")
    assert list(table["text"][:4]) == [spec.title, spec.finding, spec.caption, spec.method]
    assert "SST65, virtual experiment" in set(table["text"])
    (blue, *_) = style_colours()
    assert table["look"].str.contains(blue.lower()).any()
    inside = table[table["artist"] != "Text"][4:]
    assert (inside["x_low"] >= 0).all()
    assert (inside["y_high"] <= spec.height_mm / style.MM_PER_INCH * 72).all()


def test_an_svg_says_what_it_shows(tmp_path):
    path = tmp_path / "a.svg"
    with style.context():
        style.save(drawn(SPECS["fig14"]), path, title="e < 1", description="R & rho.")
    text = path.read_text(encoding="utf-8")
    assert "<title>e &lt; 1</title>\n <desc>R &amp; rho.</desc>" in text


@pytest.mark.parametrize("formats", [("png",), ("pdf", "png"), ("png", "svg")])
def test_what_a_table_shows_does_not_depend_on_formats(formats, tmp_path):
    tables = []
    for kinds in (("svg",), formats):
        with style.context():
            figure = drawn(SPECS["fig01"])
            style.save(figure, *(tmp_path / f"fig01.{kind}" for kind in kinds))
            tables.append(content(figure, SPECS["fig01"]))
    assert tables[0].equals(tables[1])


def test_a_palette_replaces_the_colours_of_series(tmp_path):
    others = [f"#{level}{level}{level}" for level in ("11", "33", "55", "77", "99", "bb", "dd")]
    with style.context(others):
        figure = drawn(SPECS["fig20"])
        style.save(figure, tmp_path / "fig20.svg")
        looks = " ".join(content(figure, SPECS["fig20"])["look"].dropna())
    assert others[0] in looks
    assert not any(colour.lower() in looks for colour in style_colours()[:6])
