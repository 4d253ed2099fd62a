"""Figures of the contacts that the printed statements admit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from study.figures import style
from study.figures.registry import FigureSpec, PanelSpec

# Densities are lines, pairs are points; a single number among them is a mark.
PAIRS = ("rate", "work")
CLOUD: dict[str, Any] = {
    "linestyle": "none",
    "markersize": 1.8,
    "markeredgewidth": 0.4,
    "zorder": 2,
}
# Clouds are told apart by form and not by colour alone.
CLOUD_MARKS = ("o", "^")
STAR: dict[str, Any] = {"linestyle": "none", "marker": "*", "markersize": 8.0, "zorder": 5}
BAND_ALPHA = 0.25
# Factor between the abscissae of printed marks of neighbouring sizes.
APART = 1.08


@style.context()
def draw_pairs(tables: Mapping[str, pd.DataFrame], spec: FigureSpec) -> Figure:
    """Draw marginals and pairs of the draws, beside the two-stage estimates.

    Four panels in two columns, one legend above. `tables`: panels ``limit``, ``share`` (densities),
    ``work``, ``rate`` (pairs), a series per variant; those named two-stage are single contacts;
    `spec`: registry entry.
    """
    figure, axes = style.new_figure(spec)
    for name, panel in spec.panels.items():
        table = next(t for t in tables.values() if name in set(t["panel"]))
        _draw_pairs(axes[name], table[table["panel"] == name], panel, name)
    style.legend_above(figure, axes.values())
    style.evidence_key(figure, pd.concat([t["evidence"] for t in tables.values()]))
    return figure


def _draw_pairs(ax: Axes, rows: pd.DataFrame, panel: PanelSpec, name: str) -> None:
    x, y = rows.columns[3], rows.columns[4]
    marks = iter(CLOUD_MARKS)
    for series, spec in panel.series.items():
        part = rows[rows["series"] == series]
        if part.empty:
            continue
        ends = part[x].to_numpy(float), part[y].to_numpy(float)
        look: dict[str, Any] = {"color": f"C{spec.colour or 0}", "label": spec.label}
        if spec.open:
            look["markerfacecolor"] = "white"
        if part["evidence"].iloc[0] == "printed":
            ax.axvline(ends[0][0], color="0.4", linewidth=0.8, linestyle="dotted", zorder=1)
            ax.plot(*ends, linestyle="none", marker="D", clip_on=False, zorder=6, **look)
        elif len(part) == 1:
            ax.plot(*ends, clip_on=False, **STAR, **look)
        elif name in PAIRS:
            ax.plot(*ends, marker=next(marks), **CLOUD, **look)
        else:
            line = style.EVIDENCE[part["evidence"].iloc[0]] | {"linestyle": style.LINES[spec.line]}
            ax.plot(*ends, **line, **look)
            ax.fill_between(*ends, color=look["color"], alpha=BAND_ALPHA / 2, linewidth=0)


@style.context()
def draw_bands(tables: Mapping[str, pd.DataFrame], spec: FigureSpec) -> Figure:
    """Draw e against the speed: bands of the draws, single contacts, printed facts.

    A panel per pair, abscissas logarithmic, each with a legend. `tables`: one table, a panel per
    pair; series with bounds at many speeds are bands; `spec`: registry entry.
    """
    (table,) = tables.values()
    figure, axes = style.new_figure(spec)
    for name, panel in spec.panels.items():
        ax, rows = axes[name], table[table["panel"] == name]
        banded = rows[(rows["evidence"] != "printed") & rows["y_low"].notna()]
        for series, part in banded.groupby("series", sort=False):
            style.draw_band(ax, part, panel.series[str(series)])
        lines = rows.assign(
            y_low=rows["y_low"].where(rows["evidence"] == "printed"),
            y_high=rows["y_high"].where(rows["evidence"] == "printed"),
        )
        style.draw_panel(
            ax,
            style.apart(lines, [n for n in panel.series if n.startswith("printed, ")], APART),
            panel,
            name,
        )
    style.evidence_key(figure, table["evidence"])
    return figure
