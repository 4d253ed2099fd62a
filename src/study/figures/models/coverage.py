"""Figure of bias, error and coverage of the capture velocity that Eq. (34) finds."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from study.figures import style
from study.figures.registry import FigureSpec, PanelSpec
from study.tables import Tables

# Factor between the abscissae of the first and last series where marks would hide each other.
APART = 1.11
GUIDE: dict[str, Any] = {"linewidth": 0.6, "alpha": 0.7, "zorder": 2}


@style.context()
def draw(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw panels in two columns; those of one true curve have thin lines to guide the eye.

    Such a panel is called ``quantity, truth``; the series of a ``coverage`` are moved apart.
    """
    (table,) = tables.values()
    figure, axes = style.new_figure(spec)
    for name, panel in spec.panels.items():
        ax, rows = axes[name], table[table["panel"] == name]
        if name.startswith("coverage"):
            present = set(rows.loc[rows["evidence"] == "virtual experiment", "series"])
            names = [n for n in panel.series if n in present]
            rows = style.apart(rows, names, APART ** (1.0 / max(len(names) - 1, 1)))
        style.draw_panel(ax, rows, panel, name)
        if ", " in name:
            _guide(ax, rows, panel)
    style.legend_above(figure, axes.values(), 4)
    style.evidence_key(figure, table["evidence"])
    return figure


def _guide(ax: Axes, rows: pd.DataFrame, panel: PanelSpec) -> None:
    x, y = rows.columns[3], rows.columns[4]
    for name, part in rows[rows["evidence"] == "virtual experiment"].groupby("series"):
        spec = panel.series.get(str(name))
        if spec is not None and spec.colour is not None:
            line = "dashed" if spec.open else "solid"
            ax.plot(part[x], part[y], color=f"C{spec.colour}", linestyle=line, **GUIDE)
