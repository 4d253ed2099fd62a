"""Curves of the models against speed, angle and time (Figs. 14, 17, 18, 20, 21; rolling)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from microimpact.core.tables import Tables
from microimpact.figures import style
from microimpact.figures.registry import FigureSpec

COLUMNS = 2


def _banded(tables: Tables, spec: FigureSpec) -> tuple[Figure, dict[str, Axes]]:
    """Draw every panel; the series ``admissible`` is a band behind the others."""
    table = pd.concat(tables.values(), ignore_index=True)
    is_band = table["series"] == "admissible"

    def prepare(ax: Axes, name: str) -> None:
        panel = spec.panels[name]
        rows = table[is_band & (table["panel"] == (panel.shows or name))]
        if not rows.empty:
            own = panel.series["admissible"]
            style.draw_band(ax, rows, own, own.label)

    return style.line_figure({spec.name: table[~is_band]}, spec, prepare=prepare)


@style.context()
def draw_trends(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw R, rho and e; the series ``capture velocity`` is an upright line, shaded below."""
    figure, axes = style.line_figure(tables, spec)
    (table,) = tables.values()
    line = table[table["series"] == "capture velocity"]
    style.shade_capture(axes["trends"], float(line.iloc[:, 3].max()))
    return figure


@style.context()
def draw_signed(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw curves of either sign, with the axis of zero."""
    figure, axes = style.line_figure(tables, spec)
    for ax in axes.values():
        ax.axhline(0.0, color="0.5", linewidth=0.5)
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
                term: replace(own, label=f"{own.label} (zero)") if largest.get(term) == 0.0 else own
                for term, own in panel.series.items()
            },
        )
        for name, panel in spec.panels.items()
    }
    figure, axes = _banded(tables, replace(spec, panels=panels))
    for ax in axes.values():
        ax.axhline(0.0, color="0.5", linewidth=0.5)
    style.legend_above(figure, axes.values(), 3)
    return figure


@style.context()
def draw_laws(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw restitution against the logarithm of the speed, a panel per way of fitting."""
    figure, axes = style.line_figure(tables, spec, COLUMNS, style.log_x)
    style.legend_above(figure, axes.values(), 4)
    for ax in axes.values():
        style.plain_numbers(ax.xaxis)
    return figure


@style.context()
def draw_oblique(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw curves against the angle of incidence, with the range of capture shaded.

    The series ``capture`` marks, in each panel, the angle at and below which the sphere is
    captured; ``admissible`` is a band.
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


@style.context()
def draw_moments(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw ratios of moments of rolling against the angle, a panel per estimate."""
    figure, axes = style.line_figure(tables, spec, COLUMNS, lambda ax, _: ax.set_yscale("log"))
    style.legend_above(figure, axes.values(), 4)
    return figure


@style.context()
def draw_distances(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw distances rolled by captured spheres against the shift, a panel per case."""
    figure, axes = style.line_figure(tables, spec, COLUMNS, lambda ax, _: ax.loglog())
    style.legend_above(figure, axes.values(), 7)
    for ax in axes.values():
        ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        style.plain_numbers(ax.xaxis, ax.yaxis)
    return figure
