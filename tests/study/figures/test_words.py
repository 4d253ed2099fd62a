"""The words of the figures follow the inputs: another pair leaves no word of the old one."""

from __future__ import annotations

import re
from collections.abc import Mapping

import pytest
from study.figures.registry import filled, registry
from tests.shared import ROOT, settings_as_shipped

from study.declared.documents import load

ENTRIES = load(ROOT / "config/figures.yaml")
SETTINGS = settings_as_shipped()
MATERIALS = "steel|silicon|mirror|Formica|Lycopodium|spore|fluorescein|molybdenum|mica|latex|silica"
# Studies that are of one pair by their nature.
OF_ONE_PAIR = {"particle_separation", "oblique_data", "inference"}
FIGURES = [name for name, entry in ENTRIES.items() if entry["study"] not in OF_ONE_PAIR]


def renamed(node):
    """Return parameters in which every case has another name."""
    if isinstance(node, Mapping):
        return {CASES.get(key, key): renamed(child) for key, child in node.items()}
    if isinstance(node, list):
        return [renamed(child) for child in node]
    return CASES.get(node, node) if isinstance(node, str) else node


CASES = {name: f"case {number}" for number, name in enumerate(SETTINGS.pairs)}
PAIRS = dict.fromkeys((*SETTINGS.pairs, *CASES.values()), ("glass", "glass"))
BRANCHES = {study: renamed(branch) for study, branch in SETTINGS.branches.items()}


@pytest.mark.parametrize("name", FIGURES)
def test_words_of_another_pair_leave_none_of_the_old(name):
    entry = ENTRIES[name]
    spec = registry(filled({name: entry}, BRANCHES, PAIRS, {entry["study"]: "case"}))[name]
    words = [spec.title, spec.caption, spec.method, *spec.tables.values()]
    for panel in spec.panels.values():
        words += [panel.title, panel.legend, panel.x_label, panel.y_label]
        words += [series.label for series in panel.series.values()]
    old = [text for text in words if re.search(MATERIALS, text, re.IGNORECASE)]
    assert not old


def test_what_only_holds_as_shipped_goes_with_the_inputs():
    words = {"finding": "They meet at [[a]].", "method": "By fits.", "as_shipped": "Twice [[a]]."}
    entry = {"f": {"study": "s", "caption": "Curves.", "contact": "By hand.", **words}}
    shipped = filled(entry, {"s": {"a": 1}})["f"]
    assert (shipped["finding"], shipped["method"]) == (
        "They meet at 1.",
        "By fits. Twice 1. By hand.",
    )
    changed = filled(entry, {"s": {}}, {}, {"s": "a"})["f"]
    assert (changed["finding"], changed["method"]) == ("", "By fits.")
