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


def _banded(tables: Tables, spec: FigureSpec) -> tuple[Figure, dict[str, Axes]]:
    """Draw every panel; the series ``posterior`` is a band behind the others."""
    table = pd.concat(tables.values(), ignore_index=True)
    is_band = table["series"] == "posterior"

    def prepare(ax: Axes, name: str) -> None:
        panel = spec.panels[name]
        rows = table[is_band & (table["panel"] == (panel.shows or name))]
        if not rows.empty:
            series = panel.series["posterior"]
            style.draw_band(ax, rows, series, series.label)

    return style.line_figure({spec.name: table[~is_band]}, spec, prepare=prepare)


@style.context()
def draw_lines(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw the curves of every panel as the registry declares them."""
    return style.line_figure(tables, spec)[0]


@style.context()
def draw_trends(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw R, rho and e; the series ``capture velocity`` is an upright line, shaded below."""
    figure, axes = style.line_figure(tables, spec)
    (table,) = tables.values()
    line = table[table["series"] == "capture velocity"]
    style.shade_capture(axes["trends"], float(line.iloc[:, 3].max()))
    return figure


@style.context()
def draw_forces(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw forces against time; a term that is zero throughout says so in the legend."""
    (table,) = tables.values()
    largest = table.iloc[:, 4].abs().groupby(table["series"]).max()
    panels = {
        name: replace(
            panel,
            series={
                term: replace(series, label=f"{series.label} (zero)")
                if largest.get(term) == 0.0
                else series
                for term, series in panel.series.items()
            },
        )
        for name, panel in spec.panels.items()
    }
    return _banded(tables, replace(spec, panels=panels))[0]


@style.context()
def draw_normal(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw a quantity against the normal speed; the series `PILE_UP` is a shaded range."""
    (table,) = tables.values()
    is_band = table["series"] == PILE_UP
    figure, axes = style.line_figure(dict.fromkeys(tables, table[~is_band]), spec)
    for ax in axes.values() if is_band.any() else ():
        style.mark_range(ax, table[is_band].iloc[:, 3], "piles up (article)")
    return figure


@style.context()
def draw_oblique(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw curves against the angle of incidence, with the range of capture shaded.

    The series ``capture`` marks, in each panel, the angle at and below which the sphere is
    captured; ``posterior`` is a band.
    """
    table = pd.concat(tables.values(), ignore_index=True)
    limits = table[table["series"] == "capture"]
    figure, axes = _banded({"": table[table["series"] != "capture"]}, spec)
    for panel, ax in axes.items():
        angle = limits[limits["panel"] == panel].iloc[:, 3].to_numpy(float)[0]
        if angle > 0.0:
            style.shade_capture(ax, angle)
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
