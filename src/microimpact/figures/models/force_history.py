"""Figure of the normal force and its terms against time (Fig. 20)."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd
from matplotlib.figure import Figure

from microimpact.figures import style
from microimpact.figures.registry import FigureSpec


@style.context()
def draw(tables: Mapping[str, pd.DataFrame], spec: FigureSpec) -> Figure:
    """Draw the normal force and its terms, compression positive.

    Parameters
    ----------
    tables
        ``fig20``: force in uN against time in ns.
    spec
        Registry entry.

    Returns
    -------
    matplotlib.figure.Figure
        The whole contact, and a panel that enlarges the dips near both ends.
    """
    figure, axes = style.line_figure(tables, spec)
    for ax in axes.values():
        ax.axhline(0.0, color="0.5", linewidth=0.5)
    return figure
