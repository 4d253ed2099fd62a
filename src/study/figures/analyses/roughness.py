"""Figure of coefficients measured on a slope: exact, printed and corrected."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from study.figures import style
from study.figures.registry import FigureSpec, PanelSpec
from study.tables import Tables

RANGE = "range "
# Heights of the bars, as a share of the panel.
WORDS = {"printed": "as printed", "corrected": "corrected"}
LEVELS = {"printed": 0.03, "corrected": 0.07}


@style.context()
def draw(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw curves, and bars at the foot of each panel for the ranges of agreement.

    A series ``range x`` holds the two ends of the range of series x.
    """
    (table,) = tables.values()
    is_range = table["series"].str.startswith(RANGE)
    figure, axes = style.new_figure(spec)
    for name, panel in spec.panels.items():
        style.draw_panel(axes[name], table[~is_range], panel, name)
        _draw_ranges(axes[name], table[is_range & (table["panel"] == name)], panel)
    style.legend_above(figure, axes.values())
    style.evidence_key(figure, table["evidence"])
    return figure


def _draw_ranges(ax: Axes, rows: pd.DataFrame, panel: PanelSpec) -> None:
    for series, ends in rows.groupby("series"):
        name = str(series).removeprefix(RANGE)
        ax.plot(
            ends.iloc[:, 3],
            [LEVELS[name]] * len(ends),
            transform=ax.get_xaxis_transform(),
            color=f"C{panel.series[name].colour}",
            marker="|",
            linestyle="solid",
            clip_on=False,
            label=f"holds to the tolerance, {WORDS[name]}",
        )
