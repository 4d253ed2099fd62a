"""Figure of capture velocities against diameter by competing laws."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from study.figures import style
from study.figures.registry import FigureSpec
from study.tables import Tables


@style.context()
def draw(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw one panel per pair of the data, logarithmic, with the printed values labelled.

    The panel ``pair`` of the entry describes how a pair is drawn that has no panel of its own, as
    one added to the study; the height of the entry is that of two rows of panels.
    """
    (table,) = tables.values()
    pairs = list(dict.fromkeys(table["panel"]))
    pattern = spec.panels["pair"]
    panels = {pair: spec.panels.get(pair, replace(pattern, title=pair)) for pair in pairs}
    rows = -(-len(pairs) // (spec.columns or len(pairs)))
    spec = replace(spec, panels=panels, height_mm=spec.height_mm * rows / 2)
    figure, axes = style.line_figure(tables, spec)
    for pair, ax in axes.items():
        _label_marks(ax, table[table["panel"] == pair])
    if spec.columns and len(axes) % spec.columns:
        style.legend_after(figure, spec.columns, axes.values())
    else:
        style.legend_above(figure, axes.values(), 3)
    return figure


def _label_marks(ax: Axes, rows: pd.DataFrame) -> None:
    """Write the printed values into the corner that falling curves leave free.

    Not the diameter: the article seldom states it.
    """
    values = rows.loc[rows["evidence"] == "printed"].iloc[:, 4]
    # The article prints capture velocities with two decimals or more.
    numbers = (np.format_float_positional(value, min_digits=2) for value in values)
    words = "\n".join(f"printed:\n{number} m/s" for number in numbers)
    corner = (0.95, 0.95)
    ax.text(*corner, words, fontsize="small", transform=ax.transAxes, ha="right", va="top")
