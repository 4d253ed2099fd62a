"""Figure of the phase Doppler particle analyser: a record stream, pairs and their correction."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from microimpact.figures import style
from microimpact.figures.registry import FigureSpec

STREAM = "stream"
COLUMNS = 3


@style.context()
def draw(tables: Mapping[str, pd.DataFrame], spec: FigureSpec) -> Figure:
    """Draw a stretch of a stream with its pairs, and curves against speed.

    Parameters
    ----------
    tables
        Figure data. In the panel ``stream`` series ``pair ...`` hold both records of a pair and are
        drawn as lines; the other panels hold curves against speed.
    spec
        Registry entry.

    Returns
    -------
    matplotlib.figure.Figure
        The panels of the entry in rows of three; the meaning of their lines is in the free place.
    """
    figure, axes = style.new_figure(spec, COLUMNS)
    evidence: list[str] = []
    for name, panel in spec.panels.items():
        table = next(t for t in tables.values() if (panel.shows or name) in set(t["panel"]))
        if name == STREAM:
            pairs = table["series"].str.startswith("pair ")
            _join(axes[name], table[pairs])
            table = table[~pairs]
        else:
            axes[name].set_xscale("log")
            axes[name].set_xticks(panel.x_ticks, [f"{tick:g}" for tick in panel.x_ticks])
            axes[name].set_xticks([], minor=True)
        style.draw_panel(axes[name], table, panel, name)
        evidence += list(table["evidence"])
    _legends(figure, axes)
    style.evidence_key(figure, evidence)
    return figure


def _legends(figure: Figure, axes: Mapping[str, Axes]) -> None:
    """Name every line and mark once, in the free place after the last panel."""
    place = figure.add_subplot(-(-(len(axes) + 1) // COLUMNS), COLUMNS, len(axes) + 1)
    place.set_axis_off()
    entries = {
        label: handle
        for ax in axes.values()
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True)
    }
    place.legend(entries.values(), entries.keys(), loc="center left")


def _join(ax: Axes, pairs: pd.DataFrame) -> None:
    """Join both records of each pair."""
    label: str | None = "accepted pair"
    for _, pair in pairs.groupby("series", sort=False):
        ax.plot(pair.iloc[:, 3], pair.iloc[:, 4], color="0.6", linewidth=0.8, label=label, zorder=1)
        label = None
