"""The content of a figure holds its words and the looks and places of all that is drawn."""

from __future__ import annotations

from dataclasses import replace

import pytest
from matplotlib import rcParams
from tests.study.figures.test_pictures import SPECS, drawn

from study.figures import style
from study.figures.content import content


def style_colours():
    with style.context():
        return rcParams["axes.prop_cycle"].by_key()["color"]


def shown(spec, path):
    with style.context():
        figure = drawn(spec)
        style.save(figure, path)
    return content(figure, spec).astype(object).fillna("")


def changes(name, path, **changed):
    """Return the cells that differ, by column, once a figure is drawn with other entries."""
    before, after = (shown(spec, path) for spec in (SPECS[name], replace(SPECS[name], **changed)))
    assert before.shape == after.shape
    differ = before != after
    return {column: list(before.index[differ[column]]) for column in before if differ[column].any()}


def with_looks(name, panel, looks):
    """Return the panels of a figure with other looks of some series."""
    spec = SPECS[name].panels[panel]
    series = {key: replace(spec.series[key], **look) for key, look in looks.items()}
    return SPECS[name].panels | {panel: replace(spec, series=spec.series | series)}


@pytest.mark.parametrize(
    ("name", "panel", "first", "second", "look"),
    [
        ("fig17", "friction", "0.05", "0.1", "colour"),
        ("fig20", "force", "hertz", "adhesion", "colour"),
        ("fig24", "normal", "v_c", "v_c by Eq. 34", "colour"),
        ("fig20", "force", "hertz", "adhesion", "line"),
        ("fig04", "all", "SST65", "SST125", "open"),
    ],
)
def test_exchanged_looks_of_two_series_are_seen(name, panel, first, second, look, tmp_path):
    series = SPECS[name].panels[panel].series
    looks = [getattr(series[key], look) for key in (second, first)]
    exchanged = dict(zip((first, second), ({look: value} for value in looks), strict=True))
    cells = changes(name, tmp_path / "a.svg", panels=with_looks(name, panel, exchanged))
    assert set(cells) == {"look"}
    assert len(cells["look"]) >= 2


def test_title_and_caption_are_content(tmp_path):
    cells = changes("fig14", tmp_path / "a.svg", title="Another", caption="Other words")
    assert cells == {"text": [0, 2]}


def test_a_panel_a_tenth_wider_moves_what_is_in_it(tmp_path):
    ((panel, spec),) = SPECS["fig14"].panels.items()
    low, high = spec.x_range
    wider = {panel: replace(spec, x_range=(low, 1.1 * high))}
    assert {"x_high"} <= set(changes("fig14", tmp_path / "a.svg", panels=wider))


def test_all_that_is_drawn_lies_on_the_sheet_and_is_named(tmp_path):
    spec = SPECS["fig04"]
    table = shown(spec, tmp_path / "a.svg")
    assert list(table["text"][:4]) == [spec.title, spec.finding, spec.caption, spec.method]
    labels = {series.label for series in spec.panels["all"].series.values()}
    assert labels <= set(table.loc[table["artist"] == "Line2D", "text"])
    (blue, *_) = style_colours()
    assert table["look"].str.contains(blue.lower()).any()
    inside = table[table["artist"] != "Text"][4:]
    assert (inside["x_low"] >= 0).all()
    assert (inside["y_high"] <= spec.height_mm / style.MM_PER_INCH * 72).all()
