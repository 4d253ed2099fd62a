"""Declared figures: all there, their words filled, their panels as the sheet sets them up."""

from __future__ import annotations

import re

import pandas as pd
import pytest
from matplotlib.ticker import NullFormatter

from study import analyses
from study.declared.documents import ConfigError, filled
from study.equations import EQUATIONS
from study.figures.declaration import Figure, Series, all_figures
from study.figures.style import Sheet, context
from study.tables import RESULT_EVIDENCE

FIGURES = all_figures()
WORDS = {"finding": "They meet at [[a]].", "method": "By fits.", "as_shipped": "Twice [[a]]."}


def figure(panels, **words):
    return Figure(print, "fig14", "Trends", "Curves.", panels, data=("fig14",), **words)


def sheet(panels, rows=(), **words):
    columns = ["panel", "series", "evidence", "x_m", "y_1", "y_low", "y_high"]
    table = pd.DataFrame([(*row, None, None) for row in rows], columns=columns)
    with context():
        return Sheet(figure(panels, **words), {"fig14": table}, {"speed": 2.0}, {})


def test_figures_of_the_article_come_first_and_each_has_an_analysis_with_its_number():
    assert list(FIGURES) == sorted(FIGURES, key=lambda n: (not n.startswith("fig"), n))
    assert {f"fig{number:02d}" for number in range(1, 26)} <= set(FIGURES)
    for name, each in FIGURES.items():
        assert re.fullmatch(r"fig\d\d|[a-z]+(_[a-z]+)*", name)
        assert each.analysis in analyses.homes(), name
        numbers = re.match(r"fig((?:\d\d_)*)", each.analysis)
        if name.startswith("fig"):
            own = [int(n) for n in numbers[1].split("_")[:-1]]
            assert min(own) <= int(name[3:]) <= max(own), name
        assert set(filter(None, each.equations.split(", "))) <= set(EQUATIONS), name
        assert set(each.evidence_labels) <= set(RESULT_EVIDENCE), name
        assert set(each.views) <= set(each.panels), name
        assert set(each.views.values()) <= set(each.panels), name
        assert bool(each.article) == name.startswith("fig"), name


def test_what_only_holds_as_shipped_goes_with_the_inputs():
    declared = figure({"p": ""}, contact="By hand.", **WORDS)
    shipped = declared.filled({"a": 1}, {})
    assert (shipped.finding, shipped.method) == ("They meet at 1.", "By fits. Twice 1. By hand.")
    changed = declared.filled({"a": 1}, {}, changed=True)
    assert changed.method == "By fits."


def test_a_name_in_the_words_that_is_no_parameter_is_refused():
    with pytest.raises(ConfigError, match=r"fig14\.caption: no parameter 'f' "):
        Figure(print, "fig14", "t", "[[f]]", {}, data=("d",)).filled({"g": 1}, {})


@pytest.mark.parametrize(
    ("text", "values", "words"),
    [
        ("f = [[f:.2f]]", {"f": 0.5}, "f = 0.50"),
        (
            "[[by name.1.60 m/s, fast.v.1:.2f]] m/s",
            {"by name": {"1.60 m/s": {}, "1.60 m/s, fast": {"v": [1.0, 1.64]}}},
            "1.64 m/s",
        ),
        ("[[v:g]] m/s", {"v": [0.5, 1.0, 1.5]}, "0.5, 1 and 1.5 m/s"),
    ],
)
def test_parameters_fill_the_words(text, values, words):
    assert filled(text, values, "fig14") == words


def test_panels_stand_in_columns_with_letters_and_titles_of_the_inputs():
    drawn = sheet({"a": "at [[speed:g]] m/s", "b": ""}, columns=1)
    one, other = drawn.panels(ylim=(0.0, 1.0))
    assert [ax.get_title() for ax in (one, other)] == ["(a) at 2 m/s", "(b) "]
    assert [ax.get_subplotspec().colspan.start for ax in (one, other)] == [0, 0]
    assert [ax.get_ylim() for ax in (one, other)] == [(0.0, 1.0)] * 2


def test_numbers_on_logarithmic_axes_are_plain_and_where_they_are_declared():
    drawn = sheet({"a": "", "b": ""})
    steps, ticks = drawn.panels(xscale="log", xlim=(0.1, 10.0))
    drawn.ticks(steps.xaxis, (1.0, 3.0), decades=True)
    drawn.ticks(ticks.xaxis, (0.2, 5.0))
    drawn.figure.draw_without_rendering()
    shown = [[tick.get_text() for tick in ax.get_xticklabels()] for ax in (steps, ticks)]
    assert {"0.1", "0.3", "1", "3", "10"} <= set(shown[0])
    assert shown[1] == ["0.2", "5"]
    assert isinstance(steps.xaxis.get_minor_formatter(), NullFormatter)


def test_a_series_without_a_look_is_drawn_under_its_own_name_and_axes_grow_to_it():
    rows = [("p", s, "computed", x, y) for s, y in (("known", 0.5), ("new", 3.0)) for x in (0, 9)]
    drawn = sheet({"p": ""}, rows)
    (ax,) = drawn.panels(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    drawn.draw(ax, {"known": Series("n = [[speed:g]]", 0)})
    _, labels = ax.get_legend_handles_labels()
    assert labels == ["$n$ = 2", "new"]
    assert ax.get_xlim()[1] > 9.0
    assert ax.get_ylim()[1] > 3.0


def test_a_view_shows_the_data_of_another_panel_and_stays_enlarged():
    rows = [("p", "s", "computed", x, 0.1 * x) for x in range(10)]
    drawn = sheet({"p": "", "near": ""}, rows, views={"near": "p"})
    whole, near = drawn.panels(xlim=(0.0, 1.0), ylim=(0.0, 0.1))
    for ax in (whole, near):
        drawn.draw(ax, {}, fixed=ax is near)
    assert whole.get_xlim()[1] > 9.0
    assert near.get_xlim() == (0.0, 1.0)
    assert list(near.lines[0].get_ydata()) == list(whole.lines[0].get_ydata())


def test_a_panel_without_data_is_refused():
    drawn = sheet({"p": ""}, [("q", "s", "computed", 0.0, 0.0)])
    (ax,) = drawn.panels()
    with pytest.raises(ValueError, match="no rows for panel 'p'"):
        drawn.draw(ax, {})
