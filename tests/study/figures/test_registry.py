"""The figure registry: what it refuses, axes as declared, and how values get into its words."""

from __future__ import annotations

import copy

import pytest
from study.figures.registry import RegistryError, figure_spec, filled, registry
from tests.shared import ROOT

from study.declared.documents import ConfigError, load
from study.equations import EQUATIONS
from study.figures.style import new_figure

ENTRIES = load(ROOT / "config/figures.yaml")


def changed(**keys):
    return {**copy.deepcopy(ENTRIES["fig14"]), **keys}


def test_figures_come_in_order_with_words_of_their_own():
    specs = registry(ENTRIES)
    # the article's by number, then the project's own
    assert list(specs) == sorted(specs, key=lambda name: (not name.startswith("fig"), name))
    for spec in specs.values():
        assert spec.panels
        assert spec.data
        assert set(spec.equations) <= set(EQUATIONS), spec.name


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        (changed(captoin="x"), r"fig14\.captoin: unknown key \(did you mean 'caption'\?\)"),
        (changed(width="huge"), r"fig14\.width: 'huge' must be 'single' or 'double'"),
        (changed(module="os"), r"fig14\.module: 'os' "),
        (changed(data=[1]), r"fig14\.data\[0\]: 1 must be"),
        (
            changed(evidence_labels={"printet": "x"}),
            r"fig14.evidence_labels: 'printet' is no evidence .*'printed'\?\)",
        ),
        (None, "fig14: None must be a mapping"),
    ],
)
def test_a_bad_entry_is_named(entry, message):
    with pytest.raises(RegistryError, match=message):
        figure_spec("fig14", entry)


@pytest.mark.parametrize(
    ("module", "key", "value", "message"),
    [
        ("models.curves", "x_range", [1.0, 1.0], r"x_range: \[1, 1\] must ascend"),
        ("models.curves", "x_scale", "log", r"x_range: 0 must be above 0 on a log scale"),
        ("models.curves", "x_scale", "ln", r"x_scale: 'ln' "),
        ("models.curves", "x_steps", [0.0], r"x_steps\[0\]: 0.0 must be greater than 0"),
        ("models.curves", "y_steps", [1, 3], r"y_steps: must be empty: the scale is linear"),
        ("models.curves", "y_label", "", r"y_label: '' must not be empty"),
        (
            "fig01_03_13_19_22_schematics.impacts",
            "x_label",
            "x",
            r"x_label: 'x' must be empty: it has no axes",
        ),
    ],
)
def test_an_axis_that_cannot_be_is_refused_and_words_for_none(module, key, value, message):
    entry = changed(module=f"study.figures.{module}")
    entry["panels"]["trends"][key] = value
    with pytest.raises(RegistryError, match=rf"panels\.trends\.{message}"):
        figure_spec("fig14", entry)


@pytest.mark.parametrize(
    "name", ["fig4", "fig123", "Ridge", "capture-laws", "capture__laws", "capture_", "laws2"]
)
def test_a_name_that_is_no_figure_is_refused(name):
    with pytest.raises(RegistryError, match=name):
        figure_spec(name, changed())


def test_a_figure_of_the_projects_own_has_a_name_of_words():
    assert figure_spec("capture_laws", changed()).name == "capture_laws"


def test_an_axis_is_drawn_as_it_is_declared():
    entry = changed(columns=1)
    entry["panels"]["trends"] |= {"x_range": [0.1, 10.0], "x_scale": "log", "x_steps": [1, 3]}
    entry["panels"]["trends"]["level"] = 0.0
    entry["panels"]["again"] = entry["panels"]["trends"] | {"x_ticks": [0.2, 5.0]}
    figure, axes = new_figure(figure_spec("fig14", entry))
    figure.draw_without_rendering()
    texts = [[tick.get_text() for tick in ax.get_xticklabels()] for ax in axes.values()]
    assert {"0.1", "0.3", "1", "3", "10"} <= set(texts[0])
    assert texts[1] == ["0.2", "5"]
    assert [ax.get_subplotspec().colspan.start for ax in axes.values()] == [0, 0]
    assert [list(ax.lines[0].get_ydata()) for ax in axes.values()] == [[0.0, 0.0]] * 2


def test_parameters_fill_the_words():
    entries = {"fig14": {"study": "s", "title": "f = [[f:.2f]]", "list": ["[[n]]"], "number": 3}}
    words = {"study": "s", "title": "f = 0.50", "list": ["7"], "number": 3}
    entry = filled(entries, {"s": {"f": 0.5, "n": 7}})["fig14"]
    assert {name: entry[name] for name in words} == words
    named = {"fig14": {"study": "s", "title": "[[by name.1.60 m/s, fast.v.1:.2f]] m/s"}}
    values = {"by name": {"1.60 m/s": {}, "1.60 m/s, fast": {"v": [1.0, 1.64]}}}
    assert filled(named, {"s": values})["fig14"]["title"] == "1.64 m/s"
    listed = {"fig14": {"study": "s", "title": "[[v:g]] m/s"}}
    assert filled(listed, {"s": {"v": [0.5, 1.0, 1.5]}})["fig14"]["title"] == "0.5, 1 and 1.5 m/s"
    with pytest.raises(ConfigError, match=r"fig14\.title: no parameter 'f' "):
        filled(entries, {"s": {"g": 1}})
    with pytest.raises(RegistryError, match=r"fig14\.study: 's' is no study"):
        filled(entries, {"t": {}})
