"""Curves against speed, angle and time, of the models and of the virtual experiments."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from study.figures import style
from study.figures.registry import FigureSpec
from study.tables import Tables

# The series of both ends of the speeds at which particles piled up.
PILE_UP = "printed pile-up"
# Part of an axis in which no word fits.
NARROW = 0.04


@style.context()
def draw(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw the series of every panel as the registry declares them."""
    return style.line_figure(tables, spec)[0]


@style.context()
def draw_pairs(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw one panel per pair of the data.

    The panel ``pair`` of the entry describes how a pair is drawn that has no panel of its own, as
    one added to the study; the height of the entry is that of two rows of panels.
    """
    (table,) = tables.values()
    panels = {
        pair: spec.panels.get(pair, replace(spec.panels["pair"], title=pair))
        for pair in dict.fromkeys(table["panel"])
    }
    rows = -(-len(panels) // (spec.columns or len(panels)))
    spec = replace(spec, panels=panels, height_mm=spec.height_mm * rows / 2)
    return style.line_figure(tables, spec)[0]


@style.context()
def draw_trends(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw R, rho and e; the series ``capture velocity`` is an upright line, shaded below."""
    figure, axes = style.line_figure(tables, spec)
    (table,) = tables.values()
    line = table[table["series"] == "capture velocity"]
    _shade_capture(axes["trends"], line.iloc[:, 3].max())
    return figure


@style.context()
def draw_normal(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw a quantity against the normal speed; the series `PILE_UP` is a shaded range."""
    (table,) = tables.values()
    is_band = table["series"] == PILE_UP
    figure, axes = style.line_figure({spec.name: table[~is_band]}, spec)
    low, high = table.loc[is_band, table.columns[3]].agg(["min", "max"])
    look: dict[str, Any] = {"fontsize": "small", "ha": "center", "va": "bottom"}
    for ax in axes.values() if is_band.any() else ():
        ax.axvspan(low, high, color="0.9", linewidth=0, zorder=0)
        words, across = "piles up (article)", ax.get_xaxis_transform()
        ax.text((low + high) / 2, 1.01, words, transform=across, **look)
    return figure


@style.context()
def draw_oblique(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw curves against the angle of incidence, with the range of capture shaded.

    The series ``capture`` marks, in each panel, the angle at and below which the sphere is
    captured.
    """
    table = pd.concat(tables.values(), ignore_index=True)
    limits = table[table["series"] == "capture"]
    figure, axes = style.line_figure({spec.name: table[table["series"] != "capture"]}, spec)
    for panel, ax in axes.items():
        _shade_capture(ax, limits.loc[limits["panel"] == panel].iloc[:, 3].max())
    return figure


@style.context()
def draw_losses(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw losses of energy against the angle; between the two, shaded, is the energy of spin."""
    figure = draw_oblique(tables, spec)
    table = tables[spec.name]
    for name, ax in zip(spec.panels, figure.axes, strict=True):
        rows = table[table["panel"] == name]
        total, moved = (rows[rows["series"] == s] for s in ("total", "translational"))
        ends = total.iloc[:, 4].to_numpy(), moved.iloc[:, 4].to_numpy()
        look: dict[str, Any] = {"color": "0.85", "linewidth": 0, "zorder": 0}
        ax.fill_between(total.iloc[:, 3], *ends, label="energy of the final spin", **look)
        ax.legend(loc="lower right")
    return figure


def _shade_capture(ax: Axes, limit: float) -> None:
    """Shade the part of an axis from zero to a limit in which the sphere does not rebound."""
    if limit <= 0.0:
        return
    ax.axvspan(0.0, limit, color="0.93", linewidth=0, zorder=0)
    low, high = ax.get_ylim()
    if limit > NARROW * ax.get_xlim()[1]:
        ax.text(limit / 2, (low + high) / 2, "captured", rotation=90, ha="center", va="center")
