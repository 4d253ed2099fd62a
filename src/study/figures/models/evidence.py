"""Figures of the contacts that the statements prefer."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from study.figures import style
from study.figures.registry import FigureSpec, PanelSpec
from study.tables import Tables

# Distance of the laws of one line, and looks of those that are not a single law.
APART = 0.19
ALL, GREY = "all laws", "few contacts"
LOOKS: dict[str, dict[str, Any]] = {
    ALL: {"color": "black", "linewidth": 1.6, "markersize": 4.0},
    GREY: {"color": "0.7"},
}
HEADS = {"scenario": "Scenarios", "without": "One statement less", "choice": "Other choices"}
LINE: dict[str, Any] = {"marker": "o", "markersize": 2.6, "linewidth": 1.1, "linestyle": "none"}


@style.context()
def draw(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw a line per scenario, omission and choice, with an interval by each law.

    `tables`: a panel each; the series are ``kind; name; law``, the abscissa of the data counts the
    lines and runs downwards here; `spec`: registry entry.
    """
    figure, axes = style.new_figure(spec)
    data = {str(table["panel"].iloc[0]): table for table in tables.values()}
    for number, (name, panel) in enumerate(spec.panels.items()):
        _draw_lines(axes[name], data[name], panel, is_first=number == 0)
    style.legend_above(figure, [axes[name] for name in spec.panels])
    return figure


def _draw_lines(ax: Axes, table: pd.DataFrame, panel: PanelSpec, *, is_first: bool) -> None:
    is_printed = table["evidence"] == "printed"
    names = table.loc[~is_printed, "series"].str.split("; ", n=2, expand=True)
    rows = table[~is_printed].assign(kind=names[0], line=names[1], law=names[2])
    lines = rows.drop_duplicates("x_1").set_index("x_1")
    # A head of its own opens each kind.
    kinds = list(dict.fromkeys(lines["kind"]))
    height = {x: x + kinds.index(kind) for x, kind in lines["kind"].items()}
    laws = [law for law in panel.series if law in set(rows["law"])]
    for number, law in enumerate(laws):
        part = rows[rows["law"] == law]
        middle, low, high = part.iloc[:, 4], part["y_low"], part["y_high"]
        shift = APART * (number - 0.5 * (len(laws) - 1))
        y = part["x_1"].map(height) + shift
        look = LINE | {"color": f"C{panel.series[law].colour or 0}"} | LOOKS.get(law, {})
        error = np.maximum([middle - low, high - middle], 0.0)
        label = panel.series[law].label
        ax.errorbar(middle, y, xerr=error, capsize=0.0, label=label, **look)
    for value in table.loc[is_printed].iloc[:, 4]:
        words = panel.series["printed"].label if "printed" in panel.series else None
        ax.axvline(value, color="0.4", linewidth=0.8, linestyle="dotted", zorder=0, label=words)
    ends = [min(height.values()) - 1.6, max(height.values()) + 0.6]
    ax.set_ylim(ends[1], ends[0])
    ax.set_xlim(style.widened(ax.get_xlim(), rows.iloc[:, [4, 5, 6]].to_numpy(float), log=True))
    heads = {min(h for x, h in height.items() if lines["kind"][x] == k) - 1: k for k in kinds}
    for y in heads:
        ax.axhline(y, color="0.85", linewidth=0.6, zorder=0)
    ax.set_yticks([*height.values(), *heads], [])
    ax.tick_params(axis="y", length=0)
    ax.set_ylabel("")
    if is_first:
        words = [*lines["line"], *(HEADS[kind] for kind in heads.values())]
        ax.set_yticks([*height.values(), *heads], words)
        for label in ax.get_yticklabels()[len(height) :]:
            label.set_fontweight("bold")


@style.context()
def draw_bands(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw e against the speed: bands of contacts by law, single contacts, printed values.

    `tables`: one table; series with bounds at many speeds are bands; `spec`: registry entry.
    """
    (table,) = tables.values()
    figure, axes = style.new_figure(spec)
    is_band = (table["evidence"] != "printed") & table["y_low"].notna()
    for name, panel in spec.panels.items():
        rows = table[(table["panel"] == name) & is_band]
        for series, part in rows.groupby("series", sort=False):
            style.draw_band(axes[name], part, panel.series[str(series)])
        style.draw_panel(axes[name], style.without_bounds(table, is_band), panel, name)
    style.legend_above(figure, axes.values())
    style.evidence_key(figure, table["evidence"])
    return figure
