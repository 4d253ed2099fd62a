"""Figure of capture velocities against diameter by competing laws."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from microimpact.figures import style
from microimpact.figures.registry import FigureSpec

COLUMNS = 3


@style.context()
def draw(tables: Mapping[str, pd.DataFrame], spec: FigureSpec) -> Figure:
    """Draw one panel per pair of the data, logarithmic, with the printed values labelled.

    Deposition codes rely on one of the lines, the law of Brach and Dunn 1992 in El-Batsh's form.

    Parameters
    ----------
    tables
        One table of capture velocity in m/s against diameter in um, a panel per pair.
    spec
        Registry entry. Its one panel describes how every pair is drawn, so that a pair added to the
        study needs no entry of its own; its height is that of two rows of panels.

    Returns
    -------
    matplotlib.figure.Figure
        Panels in rows of three, the legend in the first free place or above.
    """
    (table,) = tables.values()
    (pattern,) = spec.panels.values()
    pairs = list(dict.fromkeys(table["panel"]))
    panels = {pair: replace(pattern, title=_title(pair)) for pair in pairs}
    rows = -(-len(pairs) // COLUMNS)
    spec = replace(spec, panels=panels, height_mm=spec.height_mm * rows / 2)
    figure, axes = style.new_figure(spec, COLUMNS)
    for pair, ax in axes.items():
        ax.set(xscale="log", yscale="log")
        style.draw_panel(ax, table, panels[pair], pair)
        _label_marks(ax, table[table["panel"] == pair])
    _legend(figure, list(axes.values()))
    style.evidence_key(figure, table["evidence"])
    return figure


def _title(pair: str) -> str:
    return pair.replace("-", " ").replace("n =", "$n$ =")


def _label_marks(ax: Axes, rows: pd.DataFrame) -> None:
    """Write what is printed into the corner that falling curves leave free.

    Not the diameter: the article seldom states it.
    """
    values = rows.loc[rows["evidence"] == "printed"].iloc[:, 4]
    words = "\n".join(f"printed:\n{value:g} m/s" for value in values)
    corner = (0.95, 0.95)
    ax.text(*corner, words, fontsize="small", transform=ax.transAxes, ha="right", va="top")


def _legend(figure: Figure, axes: list[Axes]) -> None:
    """Name every line once, in the first free place or above the panels."""
    entries = {
        label: handle
        for ax in axes
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True)
    }
    free = -len(axes) % COLUMNS
    if not free:
        figure.legend(entries.values(), entries.keys(), loc="outside upper center", ncols=3)
        return
    place = figure.add_subplot(-(-len(axes) // COLUMNS), COLUMNS, len(axes) + 1)
    place.set_axis_off()
    place.legend(entries.values(), entries.keys(), loc="center left")
