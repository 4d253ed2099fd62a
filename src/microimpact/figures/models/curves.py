"""Curves of the models against speed, angle and time (Figs. 14, 17, 18, 20, 21; rolling)."""

from __future__ import annotations

from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from microimpact.core.tables import Tables
from microimpact.figures import style
from microimpact.figures.registry import FigureSpec

COLUMNS = 2


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
def draw_laws(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw restitution against the logarithm of the speed, a panel per way of fitting.

    The series ``hysteresis`` is named beside its curve: there are more laws than kinds of lines.
    """
    (table,) = tables.values()
    figure, axes = style.line_figure(tables, spec, COLUMNS, style.log_x)
    style.legend_above(figure, axes.values(), 4)
    for panel, ax in axes.items():
        style.plain_numbers(ax.xaxis)
        rows = table[(table["panel"] == panel) & (table["series"] == "hysteresis")]
        x, y = (rows.iloc[:, column].to_numpy(float) for column in (3, 4))
        near = abs(y - 0.9).argmin()
        ax.text(x[near] * 0.95, y[near], "hysteresis", fontsize="small", ha="right")
    return figure


@style.context()
def draw_oblique(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw curves against the angle of incidence, with the range of capture shaded.

    The series ``capture`` marks, in each panel, the angle at and below which the sphere is
    captured.
    """
    (table,) = tables.values()
    limits = table[table["series"] == "capture"]
    curves = dict.fromkeys(tables, table[table["series"] != "capture"])
    figure, axes = style.line_figure(curves, spec)
    for panel, ax in axes.items():
        angle = limits[limits["panel"] == panel].iloc[:, 3].to_numpy(float)[0]
        if angle > 0.0:
            style.shade_capture(ax, angle)
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
        ax.xaxis.set_minor_formatter(NullFormatter())
        style.plain_numbers(ax.xaxis, ax.yaxis)
    return figure
