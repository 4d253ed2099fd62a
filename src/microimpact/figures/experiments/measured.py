"""Figures of the virtual experiments: restitution, impulse ratio and energy loss as measured."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd
from matplotlib.figure import Figure

from microimpact.figures import style
from microimpact.figures.registry import FigureSpec

PILE_UP = "printed pile-up"


@style.context()
def draw_normal(tables: Mapping[str, pd.DataFrame], spec: FigureSpec) -> Figure:
    """Draw a quantity against the normal speed, with the speeds at which particles piled up.

    Parameters
    ----------
    tables
        ``fig04`` or ``fig05``; the series `PILE_UP` holds both ends of a range of speeds.
    spec
        Registry entry, with one panel.

    Returns
    -------
    matplotlib.figure.Figure
        One panel.
    """
    bands = {name: table[table["series"] == PILE_UP] for name, table in tables.items()}
    rest = {name: table[table["series"] != PILE_UP] for name, table in tables.items()}
    figure, axes = style.line_figure(rest, spec)
    for name, ax in axes.items():
        for table in bands.values():
            own = table[table["panel"] == name]
            if own.empty:
                continue
            low, high = own[own.columns[3]].min(), own[own.columns[3]].max()
            ax.axvspan(low, high, color="0.9", linewidth=0, zorder=0)
            middle, above = (low + high) / 2, ax.get_xaxis_transform()
            ax.text(
                middle,
                1.01,
                "piles up",
                fontsize="small",
                transform=above,
                ha="center",
                va="bottom",
            )
    return figure


@style.context()
def draw_oblique(tables: Mapping[str, pd.DataFrame], spec: FigureSpec) -> Figure:
    """Draw measured quantities against the angle of incidence.

    Parameters
    ----------
    tables
        One of ``fig06`` to ``fig12``.
    spec
        Registry entry, with a panel per quantity.

    Returns
    -------
    matplotlib.figure.Figure
        Panels side by side; means that lie above a panel are written at its upper edge.
    """
    figure, axes = style.line_figure(tables, spec)
    table = pd.concat([tables[name] for name in spec.data])
    x, y = table.columns[3:5]
    measured = table[table["evidence"] == "virtual experiment"]
    for name, ax in axes.items():
        panel = spec.panels[name]
        rows = measured[measured["panel"] == (panel.shows or name)]
        for at, points in rows[rows[y] > ax.get_ylim()[1]].groupby(x):
            words = ", ".join(f"{value:.1f}" for value in sorted(points[y]))
            ax.annotate(
                f"{words} ↑",
                (float(str(at)), 0.97),
                xycoords=ax.get_xaxis_transform(),
                rotation=90,
                ha="center",
                va="top",
                fontsize="small",
            )
    return figure
