"""Figures of oblique impact: impulse ratio and energy loss against angle (Figs. 18 and 21)."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd
from matplotlib.figure import Figure

from microimpact.figures import style
from microimpact.figures.registry import FigureSpec


@style.context()
def draw(tables: Mapping[str, pd.DataFrame], spec: FigureSpec) -> Figure:
    """Draw curves against the angle of incidence, with the range of capture shaded.

    Parameters
    ----------
    tables
        One table of figure data whose series ``capture`` marks, in each panel, the angle at and
        below which the sphere is captured.
    spec
        Registry entry.

    Returns
    -------
    matplotlib.figure.Figure
        The panels of the entry.
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
