"""Sobol' indices beside the effects of designed experiments."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from study.figures import style
from study.figures.registry import FigureSpec, PanelSpec
from study.tables import Tables

FACTORS = ("$K$", "$w_A$", "$r$", r"$\zeta_A$", r"$\zeta_H$")
LOOKS: dict[str, dict[str, Any]] = {
    "total index": {"marker": "o"},
    "first-order index": {"marker": "o", "fillstyle": "none"},
    "share of squared effects": {"marker": "D", "fillstyle": "none"},
}
# Of the factors whose convergence is shown.
SHAPES = ("o", "s", "^", "D", "v")
# Distance of marks of the same factor.
APART = 0.2


@style.context()
def draw(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw indices of five factors and their convergence.

    The abscissa counts factors, or samples in the panel ``convergence``.
    """
    figure, axes = style.new_figure(spec)
    (table,) = tables.values()
    for name, panel in spec.panels.items():
        rows = table[table["panel"] == name]
        if rows.empty:
            raise ValueError(f"figure data: no rows for panel {name!r}")
        if name == "convergence":
            _draw_convergence(axes[name], rows, panel)
        else:
            _draw_factors(axes[name], rows, panel)
    style.legend_above(figure, [next(iter(axes.values()))], title="all computed")
    return figure


def _draw_factors(ax: Axes, rows: pd.DataFrame, panel: PanelSpec) -> None:
    for number, (name, look) in enumerate(LOOKS.items()):
        shift = APART * (number - 0.5 * (len(LOOKS) - 1))
        _marks(ax, rows[rows["series"] == name], panel, name, look, shift)
    ax.set_xticks(np.arange(len(FACTORS)), FACTORS)
    ax.xaxis.set_minor_locator(NullLocator())
    ax.tick_params(axis="x", length=0)


def _draw_convergence(ax: Axes, rows: pd.DataFrame, panel: PanelSpec) -> None:
    ax.set_xscale("log", base=2)
    for name, shape in zip(panel.series, SHAPES, strict=False):
        look = {"marker": shape, "linestyle": "solid", "markersize": 3.0, "linewidth": 0.9}
        _marks(ax, rows[rows["series"] == name], panel, name, look, 0.0)
    ax.xaxis.set_major_locator(LogLocator(base=2, subs=(1.0,)))
    style.plain_numbers(ax.xaxis)
    ax.xaxis.set_minor_locator(NullLocator())
    ax.legend(loc="upper right", ncols=len(panel.series) // 2 + 1)


def _marks(
    ax: Axes, rows: pd.DataFrame, panel: PanelSpec, name: str, look: Mapping[str, Any], shift: float
) -> None:
    x, y = (rows.iloc[:, column].to_numpy(float) for column in (3, 4))
    bounds = rows[["y_low", "y_high"]].to_numpy(float).T
    error = None if np.isnan(bounds).any() else np.maximum(np.array([[-1], [1]]) * (bounds - y), 0)
    spec = panel.series[name]
    style_of = {"linestyle": "none", "color": f"C{spec.colour or 0}", "zorder": 3, **look}
    ax.errorbar(x + shift, y, yerr=error, label=spec.label, clip_on=False, **style_of)
    low, high = ax.get_ylim()
    values = rows.iloc[:, [4, 5, 6]].to_numpy(float)
    ax.set_ylim(style.widened((low, high), values))
