"""Figure of the phase Doppler particle analyser: a record stream, pairs and their correction."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from study.figures import style
from study.figures.registry import FigureSpec
from study.tables import Tables

STREAM = "stream"
# Factor between the abscissae of neighbouring heights, whose marks would hide each other.
APART = 1.06


@style.context()
def draw(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw a stretch of a stream with its pairs, and curves against speed.

    In the panel ``stream`` series ``pair ...`` hold both records of a pair and are drawn as lines.
    Heights of the probe volume, which three panels share, are named after the last panel.
    """
    stream = {name: table["panel"].eq(STREAM).any() for name, table in tables.items()}
    is_pair = {name: table["series"].str.startswith("pair ") for name, table in tables.items()}

    def prepare(ax: Axes, name: str) -> None:
        for which, shown in stream.items():
            if shown and name == STREAM:
                _join(ax, tables[which][is_pair[which]])

    heights = list(spec.panels["seen"].series)
    rest = {name: style.apart(t[~is_pair[name]], heights, APART) for name, t in tables.items()}
    figure, axes = style.line_figure(rest, spec, prepare)
    style.legend_after(figure, spec.columns, [axes["seen"]], title="(b–d) probe volume at")
    return figure


def _join(ax: Axes, pairs: pd.DataFrame) -> None:
    """Join both records of each pair."""
    label: str | None = "accepted pair"
    for _, pair in pairs.groupby("series", sort=False):
        ax.plot(pair.iloc[:, 3], pair.iloc[:, 4], color="0.6", linewidth=0.8, label=label, zorder=1)
        label = None
