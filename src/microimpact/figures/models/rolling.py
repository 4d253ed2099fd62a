"""Figures of rolling: neglected moments against the angle, and how far captured spheres roll."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from microimpact.figures import style
from microimpact.figures.registry import FigureSpec

COLUMNS = 2


@style.context()
def draw_moments(tables: Mapping[str, pd.DataFrame], spec: FigureSpec) -> Figure:
    """Draw ratios of moments, logarithmic, one legend above all panels.

    Parameters
    ----------
    tables
        ``rolling``: rolling moment over friction moment against the angle, a panel per estimate.
    spec
        Registry entry.

    Returns
    -------
    matplotlib.figure.Figure
        The panels of the entry in rows of two.
    """
    return _logarithmic(tables, spec, x_scale="linear", legend_columns=4)


@style.context()
def draw_distances(tables: Mapping[str, pd.DataFrame], spec: FigureSpec) -> Figure:
    """Draw distances rolled by captured spheres, both axes logarithmic.

    Parameters
    ----------
    tables
        ``roll_away_curves``: distance against the shift, a panel per case.
    spec
        Registry entry.

    Returns
    -------
    matplotlib.figure.Figure
        The panels of the entry side by side.
    """
    figure = _logarithmic(tables, spec, x_scale="log", legend_columns=7)
    for ax in figure.axes:
        ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        ax.xaxis.set_minor_formatter(NullFormatter())
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    return figure


def _logarithmic(
    tables: Mapping[str, pd.DataFrame], spec: FigureSpec, x_scale: str, legend_columns: int
) -> Figure:
    (table,) = tables.values()
    figure, axes = style.new_figure(spec, COLUMNS)
    for name, ax in axes.items():
        ax.set(xscale=x_scale, yscale="log")
        style.draw_panel(ax, table, spec.panels[name], name)
    entries = {
        label: handle
        for ax in axes.values()
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True)
    }
    figure.legend(
        entries.values(), entries.keys(), loc="outside upper center", ncols=legend_columns
    )
    style.evidence_key(figure, table["evidence"])
    return figure
