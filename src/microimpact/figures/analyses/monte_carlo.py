"""Figure of the Monte Carlo analysis: coefficients of a rough surface against angle."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from microimpact.figures import style
from microimpact.figures.registry import FigureSpec, PanelSpec, SeriesSpec

# The series that is a band only; those of a curve are its standard error.
MEASURED = "measured means"
CURVES = ("computed", "calibrated")


@style.context()
def draw(tables: Mapping[str, pd.DataFrame], spec: FigureSpec) -> Figure:
    """Draw curves in bands of standard error, and a band in which means of a few events lie.

    Parameters
    ----------
    tables
        Curves and bands; any further table of the same panels holds points with error bars.
    spec
        Registry entry.

    Returns
    -------
    matplotlib.figure.Figure
        One axis per panel.
    """
    table = pd.concat([tables[name] for name in spec.data], ignore_index=True)
    is_curve = table["evidence"].isin(CURVES)
    figure, axes = style.new_figure(spec)
    entries: list[Line2D] = []
    for name, ax in axes.items():
        in_panel = table["panel"] == name
        _draw_bands(ax, table[is_curve & in_panel], spec.panels[name])
        bare = _without_bands(table, is_curve)
        entries += style.draw_panel(ax, bare, spec.panels[name], name)
    style.evidence_key(figure, table["evidence"], entries)
    return figure


def _draw_bands(ax: Axes, table: pd.DataFrame, panel: PanelSpec) -> None:
    for series, rows in table[table["y_low"].notna()].groupby("series", sort=False):
        own = panel.series.get(str(series), SeriesSpec(label=str(series)))
        wide = series == MEASURED
        ax.fill_between(
            rows.iloc[:, 3],
            rows["y_low"],
            rows["y_high"],
            color="0.5" if own.colour is None else f"C{own.colour}",
            alpha=0.15 if wide else 0.5,
            linewidth=0,
            label=own.label if wide else None,
        )


def _without_bands(table: pd.DataFrame, is_curve: pd.Series[bool]) -> pd.DataFrame:
    """Return a table whose curves have no bounds, for they would be drawn as error bars."""
    bare = table.copy()
    bare.loc[is_curve, ["y_low", "y_high"]] = np.nan
    return bare[bare["series"] != MEASURED]
