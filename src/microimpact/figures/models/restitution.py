"""Figures of the coefficients of restitution and adhesion (Fig. 14)."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd
from matplotlib.figure import Figure

from microimpact.figures import style
from microimpact.figures.registry import FigureSpec


@style.context()
def draw(tables: Mapping[str, pd.DataFrame], spec: FigureSpec) -> Figure:
    """Draw the trends of R, rho and e, with the range of capture shaded.

    Parameters
    ----------
    tables
        ``fig14``: curves and, as the series ``capture velocity``, an upright line.
    spec
        Registry entry.

    Returns
    -------
    matplotlib.figure.Figure
        One panel.
    """
    figure, axes = style.line_figure(tables, spec)
    (table,) = tables.values()
    line = table[table["series"] == "capture velocity"]
    capture = float(line.iloc[:, 3].max())
    style.shade_capture(axes["trends"], capture)
    return figure
