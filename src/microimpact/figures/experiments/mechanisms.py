"""Figures of supposed mechanisms, and of how a target piles up."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd
from matplotlib.figure import Figure

from microimpact.figures import style
from microimpact.figures.registry import FigureSpec

COLUMNS = 2
PILE_UP = "printed pile-up"


@style.context()
def draw_causes(tables: Mapping[str, pd.DataFrame], spec: FigureSpec) -> Figure:
    """Draw one panel per mechanism.

    Parameters
    ----------
    tables
        ``causes``, ``causes_slope``, ``causes_shallow``: a table per unit of the abscissa.
    spec
        Registry entry.

    Returns
    -------
    matplotlib.figure.Figure
        Panels in rows of two, each with a legend of its own.
    """
    figure, axes = style.new_figure(spec, COLUMNS)
    for name, ax in axes.items():
        (table,) = (t for t in tables.values() if name in set(t["panel"]))
        style.draw_panel(ax, table, spec.panels[name], name)
        if name == "spin":
            ax.axhline(0.0, color="0.6", linewidth=0.6, zorder=0)
        if name in {"slope", "spore"}:
            ax.axhline(1.0, color="0.6", linewidth=0.6, zorder=0)
    style.evidence_key(figure, pd.concat([t["evidence"] for t in tables.values()]))
    return figure


@style.context()
def draw_pile_up(tables: Mapping[str, pd.DataFrame], spec: FigureSpec) -> Figure:
    """Draw shares of spheres on the target against their speed, with the printed range.

    Parameters
    ----------
    tables
        ``pile_up_onset``; the series `PILE_UP` holds both ends of a range of speeds.
    spec
        Registry entry, with one panel.

    Returns
    -------
    matplotlib.figure.Figure
        One panel.
    """
    (table,) = tables.values()
    rest = table[table["series"] != PILE_UP]
    figure, axes = style.line_figure({spec.name: rest}, spec)
    speeds = table[table["series"] == PILE_UP].iloc[:, 3]
    for ax in axes.values():
        ax.axvspan(speeds.min(), speeds.max(), color="0.9", linewidth=0, zorder=0)
        ax.text(
            speeds.mean(),
            1.01,
            "piles up (article)",
            fontsize="small",
            transform=ax.get_xaxis_transform(),
            ha="center",
            va="bottom",
        )
    return figure
