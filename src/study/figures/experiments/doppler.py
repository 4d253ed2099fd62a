"""Figure of the phase Doppler particle analyser: a record stream, pairs and their correction."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from study.figures import style
from study.figures.registry import FigureSpec
from study.tables import Tables

STREAM = "stream"


@style.context()
def draw(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw a stretch of a stream with its pairs, and curves against speed.

    In the panel ``stream`` series ``pair ...`` hold both records of a pair and are drawn as lines.
    """
    is_pair = {name: table["series"].str.startswith("pair ") for name, table in tables.items()}
    rest = {name: table[~is_pair[name]] for name, table in tables.items()}
    figure, axes = style.line_figure(rest, spec)
    pairs = [pair for k, t in tables.items() for _, pair in t[is_pair[k]].groupby("series")]
    for number, pair in enumerate(pairs):
        look: dict[str, Any] = {"color": "0.6", "linewidth": 0.8, "zorder": 1}
        label = "_pair" if number else "accepted pair"
        axes[STREAM].plot(pair.iloc[:, 3], pair.iloc[:, 4], label=label, **look)
    axes[STREAM].legend(loc="upper left")
    return figure
