"""Figures of the contacts that the statements prefer."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from study.figures import style
from study.figures.registry import FigureSpec, PanelSpec
from study.tables import Tables

# Distance of the laws of one line, and looks of those that are not a single law.
APART = 0.19
ALL, FEW = "all laws", "few contacts"
BOLD: dict[str, Any] = {"color": "black", "linewidth": 1.6, "markersize": 4.0}
GREY: dict[str, Any] = {"color": "0.7", "markerfacecolor": "white", "marker": "X"}
MARKS = ("o", "s", "^", "D", "v", "P")
SYMBOLS = {"v_c": "$v_c$", "w_A": "$w_A$", "c_A": "$c_A$", "n to": "$n$ to", "J/m2": "J/m$^2$"}
HEADS = {"scenario": "Scenarios", "without": "One statement less", "choice": "Other choices"}
LINE: dict[str, Any] = {"markersize": 2.8, "linewidth": 1.1, "linestyle": "none"}


@style.context()
def draw(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw a line per scenario, omission and choice, with an interval by each law.

    `tables`: a panel each; the series are ``kind; name; law``, and `FEW` at the end of those from
    few contacts; the abscissa of the data counts the lines and runs downwards here; `spec`:
    registry entry.
    """
    figure, axes = style.new_figure(spec)
    data = {str(table["panel"].iloc[0]): table for table in tables.values()}
    for number, (name, panel) in enumerate(spec.panels.items()):
        _draw_lines(axes[name], data[name], panel, is_first=number == 0)
    style.legend_above(figure, [axes[name] for name in spec.panels])
    return figure


def _draw_lines(ax: Axes, table: pd.DataFrame, panel: PanelSpec, *, is_first: bool) -> None:
    is_printed = table["evidence"] == "printed"
    names = table.loc[~is_printed, "series"].str.split("; ", expand=True)
    rows = table[~is_printed].assign(kind=names[0], line=names[1], law=names[2])
    is_grey = rows["series"].str.endswith(FEW)
    lines = rows.drop_duplicates("x_1")
    # A head of its own opens each kind.
    kinds = list(dict.fromkeys(lines["kind"]))
    heights = lines["x_1"] + lines["kind"].map(kinds.index)
    height = dict(zip(lines["x_1"], heights, strict=True))
    laws = [law for law in panel.series if law in set(rows["law"])]
    for number, law in enumerate(laws):
        shift = APART * (number - 0.5 * (len(laws) - 1))
        look = LINE | {"color": f"C{panel.series[law].colour or 0}"} | (BOLD if law == ALL else {})
        look |= {"marker": MARKS[list(panel.series).index(law)]}
        for grey, label in (({}, panel.series[law].label), (GREY, panel.series[FEW].label)):
            part = rows[(rows["law"] == law) & (is_grey == bool(grey))]
            middle, low, high = part.iloc[:, 4], part["y_low"], part["y_high"]
            y, error = part["x_1"].map(height) + shift, [middle - low, high - middle]
            if len(part):
                ax.errorbar(middle, y, xerr=error, capsize=0.0, label=label, **look | grey)
    for value in table.loc[is_printed].iloc[:, 4]:
        words = panel.series["printed"].label if "printed" in panel.series else None
        ax.axvline(value, color="0.4", linewidth=0.8, linestyle="dotted", zorder=0, label=words)
    ax.set_ylim(max(heights) + 0.6, min(heights) - 1.6)
    ax.set_xlim(style.widened(ax.get_xlim(), rows.iloc[:, [4, 5, 6]].to_numpy(float), log=True))
    heads = [float(heights[lines["kind"] == kind].min()) - 1.0 for kind in kinds]
    for head in heads:
        ax.axhline(head, color="0.85", linewidth=0.6, zorder=0)
    ax.tick_params(axis="y", length=0)
    ax.yaxis.set_minor_locator(NullLocator())
    ax.set_ylabel("")
    names_of_lines = [*lines["line"], *(HEADS[kind] for kind in kinds)] if is_first else []
    for name, symbol in SYMBOLS.items():
        names_of_lines = [line.replace(name, symbol) for line in names_of_lines]
    ax.set_yticks([*heights, *heads], names_of_lines)
    for tick in ax.get_yticklabels()[len(heights) :]:
        tick.set_fontweight("bold")
