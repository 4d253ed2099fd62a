"""Figures of the virtual experiments: measured means and pile-up."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from microimpact.core.tables import Tables
from microimpact.figures import style
from microimpact.figures.registry import FigureSpec

# The series of both ends of the speeds at which particles piled up.
PILE_UP = "printed pile-up"


@style.context()
def draw_normal(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw a quantity against the normal speed, with the speeds at which particles piled up."""
    (table,) = tables.values()
    is_band = table["series"] == PILE_UP
    figure, axes = style.line_figure(dict.fromkeys(tables, table[~is_band]), spec)
    for ax in axes.values() if is_band.any() else ():
        style.mark_range(ax, table[is_band].iloc[:, 3], "piles up (article)")
    return figure


@style.context()
def draw_oblique(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw measured quantities against the angle of incidence.

    Means that lie above a panel are written at its upper edge.
    """
    figure, axes = style.line_figure(tables, spec)
    table = pd.concat([tables[name] for name in spec.data])
    measured = table[table["evidence"] == "virtual experiment"]
    for name, ax in axes.items():
        panel = spec.panels[name]
        style.written_above(ax, measured[measured["panel"] == (panel.shows or name)])
    return figure
