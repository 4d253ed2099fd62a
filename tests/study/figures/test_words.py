"""The words of the figures follow the inputs: another pair leaves no word of the old one."""

from __future__ import annotations

import re
from collections.abc import Mapping

import pytest
from tests.shared import settings_as_shipped
from tests.study.figures.test_pictures import data_of, drawn, texts

from study.figures.declaration import all_figures
from study.figures.style import context

FIGURES = all_figures()
SETTINGS = settings_as_shipped()
MATERIALS = "steel|silicon|mirror|Formica|Lycopodium|spore|fluorescein|molybdenum|mica|latex|silica"
# Analyses that are of one pair by their nature.
OF_ONE_PAIR = {"particle_separation", "oblique_data", "inference"}


def renamed(node):
    """Return parameters in which every case has another name."""
    if isinstance(node, Mapping):
        return {CASES.get(key, key): renamed(child) for key, child in node.items()}
    if isinstance(node, list):
        return [renamed(child) for child in node]
    return CASES.get(node, node) if isinstance(node, str) else node


CASES = {name: f"case {number}" for number, name in enumerate(SETTINGS.pairs)}
PAIRS = dict.fromkeys((*SETTINGS.pairs, *CASES.values()), ("glass", "glass"))
BRANCHES = {name: renamed(branch) for name, branch in SETTINGS.branches.items()}


@pytest.mark.parametrize(
    "name", [name for name, figure in FIGURES.items() if figure.analysis not in OF_ONE_PAIR]
)
def test_words_of_another_pair_leave_none_of_the_old(name):
    branch = BRANCHES[FIGURES[name].analysis]
    figure = FIGURES[name].filled(branch, PAIRS, changed=True)
    words = [figure.title, figure.finding, figure.caption, figure.method]
    words += [*figure.tables.values(), *figure.panels.values()]
    with context():
        sheet = drawn(figure, branch, PAIRS)
        sheet.draw_without_rendering()
    words += [text.get_text() for text, _ in texts(sheet, 0.0)]
    of_data = {str(name) for table in data_of(figure) for name in table["series"]}
    old = [t for t in words if re.search(MATERIALS, t, re.IGNORECASE) and t not in of_data]
    assert not old
