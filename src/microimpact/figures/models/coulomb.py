"""Figures of Coulomb friction in the rigid body model (Fig. 17)."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd
from matplotlib.figure import Figure

from microimpact.figures import style
from microimpact.figures.registry import FigureSpec


@style.context()
def draw(tables: Mapping[str, pd.DataFrame], spec: FigureSpec) -> Figure:
    """Draw the impulse ratio against the angle of incidence.

    Parameters
    ----------
    tables
        ``fig17``: panels ``friction`` (no spin) and ``spin``.
    spec
        Registry entry.

    Returns
    -------
    matplotlib.figure.Figure
        Two panels; the axis of no tangential impulse is drawn in the second.
    """
    figure, axes = style.line_figure(tables, spec)
    for ax in axes.values():
        ax.axhline(0.0, color="0.5", linewidth=0.5)
    return figure
