"""Figure of separation forces against the silica on a particle."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from study.figures import style
from study.figures.registry import FigureSpec, PanelSpec
from study.tables import Tables

STATED = "stated"


@style.context()
def draw(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw curves with shaded bands on a logarithmic ordinate, and the statements as marks.

    Each panel shows the series that it names.
    """
    (table,) = tables.values()
    figure, axes = style.new_figure(spec)
    for name, panel in spec.panels.items():
        ax, rows = axes[name], table[table["series"].isin(panel.series)]
        is_curve = rows["series"] != STATED
        _draw_bands(ax, rows[is_curve], panel)
        style.draw_panel(ax, style.without_bounds(rows, is_curve), panel, name)
        if not is_curve.all():
            _label_marks(ax, rows[~is_curve])
    style.legend_above(figure, axes.values(), 3)
    style.evidence_key(figure, table["evidence"], labels=spec.evidence_labels)
    return figure


def _draw_bands(ax: Axes, curves: pd.DataFrame, panel: PanelSpec) -> None:
    for series, rows in curves[curves["y_low"].notna()].groupby("series", sort=False):
        spec = panel.series.get(str(series))
        colour = "0.5" if spec is None or spec.colour is None else f"C{spec.colour}"
        edges = rows["y_low"], rows["y_high"]
        ax.fill_between(rows.iloc[:, 3], *edges, color=colour, alpha=0.15, linewidth=0)
        for edge in edges:
            ax.plot(rows.iloc[:, 3], edge, color=colour, alpha=0.5, linewidth=0.5)


def _label_marks(ax: Axes, marks: pd.DataFrame) -> None:
    """Write the share of the first beside each statement."""
    places = marks.iloc[:, 3:5].to_numpy(float)
    shares = places[:, 1] / places[0, 1]
    for share, (x, y) in zip(shares, places, strict=True):
        words, drop = ("JKR", 4) if share == 1.0 else (f"{100 * share:.0f} % of JKR", -10)
        ax.annotate(words, (x, y), (6, drop), textcoords="offset points", fontsize="small")
