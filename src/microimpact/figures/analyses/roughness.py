"""Figure of coefficients measured on a slope: exact, printed and corrected."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from microimpact.figures import style
from microimpact.figures.registry import FigureSpec, PanelSpec

COLUMNS = 3
RANGE = "range "
# Heights of the bars, as a share of the panel.
LEVELS = {"printed": 0.03, "corrected": 0.07}


@style.context()
def draw(tables: Mapping[str, pd.DataFrame], spec: FigureSpec) -> Figure:
    """Draw curves, and bars at the foot of each panel for the ranges of agreement.

    Parameters
    ----------
    tables
        One table of figure data; a series ``range x`` holds the two ends of the range of series x.
    spec
        Registry entry.

    Returns
    -------
    matplotlib.figure.Figure
        Panels in rows of three under one legend.
    """
    (table,) = tables.values()
    is_range = table["series"].str.startswith(RANGE)
    figure, axes = style.new_figure(spec, COLUMNS)
    for name, ax in axes.items():
        style.draw_panel(ax, table[~is_range], spec.panels[name], spec.panels[name].shows)
        rows = table[is_range & (table["panel"] == spec.panels[name].shows)]
        _draw_ranges(ax, rows, spec.panels[name])
    entries = {
        label: handle
        for ax in axes.values()
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True)
    }
    figure.legend(entries.values(), entries.keys(), loc="outside upper center", ncols=3)
    style.evidence_key(figure, table["evidence"])
    return figure


def _draw_ranges(ax: Axes, rows: pd.DataFrame, panel: PanelSpec) -> None:
    for series, ends in rows.groupby("series"):
        of = str(series).removeprefix(RANGE)
        ax.plot(
            ends.iloc[:, 3],
            [LEVELS[of]] * len(ends),
            transform=ax.get_xaxis_transform(),
            color=f"C{panel.series[of].colour}",
            marker="|",
            linestyle="solid",
            clip_on=False,
        )
