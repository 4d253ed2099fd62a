"""Figure of bias, error and coverage of the capture velocity that Eq. (34) finds."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from microimpact.core.tables import Tables
from microimpact.figures import style
from microimpact.figures.registry import FigureSpec, PanelSpec

# Factor between the abscissae of the first and last series where marks would hide each other.
APART = 1.11
GUIDE: dict[str, Any] = {"linewidth": 0.6, "alpha": 0.7, "zorder": 2}


@style.context()
def draw(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw panels in two columns, one for each true curve, with thin lines to guide the eye.

    A panel is called ``quantity, truth``; the series of a ``coverage`` are moved apart.
    """
    (table,) = tables.values()
    figure, axes = style.new_figure(spec)
    for name, panel in spec.panels.items():
        ax, rows = axes[name], table[table["panel"] == name]
        if name.startswith("coverage"):
            found = set(rows.loc[rows["evidence"] == "virtual experiment", "series"])
            names = [n for n in panel.series if n in found]
            rows = style.apart(rows, names, APART ** (1.0 / max(len(names) - 1, 1)))
        style.draw_panel(ax, rows, panel, name)
        _guide(ax, rows, panel)
    style.legend_above(figure, axes.values(), 4)
    style.evidence_key(figure, table["evidence"])
    return figure


def _guide(ax: Axes, rows: pd.DataFrame, panel: PanelSpec) -> None:
    x, y = rows.columns[3], rows.columns[4]
    for name, part in rows[rows["evidence"] == "virtual experiment"].groupby("series"):
        own = panel.series.get(str(name))
        if own is not None and own.colour is not None:
            line = "dashed" if own.open else "solid"
            ax.plot(part[x], part[y], color=f"C{own.colour}", linestyle=line, **GUIDE)
