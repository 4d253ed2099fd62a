"""Probability plots of the effects of designed experiments (Figs. 24 and 25)."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from study.figures import style
from study.figures.registry import FigureSpec, PanelSpec
from study.tables import POINTS, Tables

# Marks of the responses: face and shape. Lines of the margins.
MARKS = {"v_c": ("full", "o"), "v_c by Eq. 34": ("none", "^"), "ln v_c": ("none", "s")}
MARGINS = {"margin": "dashed", "simultaneous margin": "dotted"}
MARGIN_COLOUR = "0.45"
# Effects that are labelled however small: the factors, and in one panel three pairs to compare;
# and those as large as any of the factors that matter.
FACTORS, MATTERING = tuple("ABCDE"), tuple("ABCD")
NAMED = (*FACTORS, "BC", "BD", "CD")
LABEL_SIZE = 7.5
LABEL_GAP = 4.5


@style.context()
def draw(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw a normal plot of effects, and a half-normal one.

    A series is called ``response: effect``, or as one of the margins. Each panel names the
    responses it shows; the margins belong to the first.
    """
    figure, axes = style.new_figure(spec)
    (table,) = tables.values()
    parts = table["series"].str.split(": ", n=1, expand=True)
    table = table.assign(response=parts[0], word=parts[1])
    for name, panel in spec.panels.items():
        rows = table[table["panel"] == name]
        if rows.empty:
            raise ValueError(f"figure data: no rows for panel {name!r}")
        _draw_panel(axes[name], rows, panel, half=name == "half_normal")
    title = next(panel.legend for panel in spec.panels.values())
    style.legend_above(figure, axes.values(), title=title, loc="outside lower center")
    entries: list[Line2D] = []
    points = table[table["evidence"].isin(POINTS)]
    names = list(points["series"].unique())
    for name, panel in spec.panels.items():
        entries += style.overlay(axes[name], table[table["panel"] == name], panel, names)
    if entries:
        style.evidence_key(figure, points["evidence"], entries, loc="outside upper center")
    return figure


def _draw_panel(ax: Axes, rows: pd.DataFrame, panel: PanelSpec, *, half: bool) -> None:
    x, y = rows.columns[3], rows.columns[4]
    responses = [name for name in MARKS if name in panel.series]
    shown = rows[rows["response"].isin(responses)]
    is_margin = shown["word"].isin(MARGINS)
    if not half:
        ax.axhline(0.0, color="0.85", linewidth=0.6, zorder=0)
        ax.axvline(0.0, color="0.85", linewidth=0.6, zorder=0)
    ax.set_xlim(style.widened(ax.get_xlim(), shown[x].to_numpy(float)))
    ax.set_ylim(style.widened(ax.get_ylim(), shown[y].to_numpy(float)))
    margins = shown[is_margin & (shown["response"] == responses[0])]
    for word, line in MARGINS.items():
        for i, margin in enumerate(margins.loc[margins["word"] == word, x]):
            label = panel.series[word].label if i == 0 else None
            ax.axvline(margin, color=MARGIN_COLOUR, linestyle=line, linewidth=0.9, label=label)
    limit = float(margins.loc[margins["word"] == "margin", x].max())
    for response in responses:
        points = shown[~is_margin & (shown["response"] == response)]
        spec = panel.series[response]
        colour = f"C{spec.colour or 0}"
        face, marker = MARKS[response]
        look: dict[str, Any] = {"marker": marker, "fillstyle": face, "color": colour}
        ax.plot(points[x], points[y], label=spec.label, linestyle="none", zorder=3, **look)
        first = response == responses[0]
        if half or first:
            size = points[x].abs()
            least = size[points["word"].isin(MATTERING)].min()
            worth = points["word"].isin(NAMED if half else FACTORS) | (size >= min(limit, least))
            _label(ax, points[worth], (x, y), colour, outward=not half, leftward=not first)


def _label(
    ax: Axes,
    points: pd.DataFrame,
    columns: tuple[str, str],
    colour: str,
    *,
    outward: bool,
    leftward: bool,
) -> None:
    """Write the effects beside their points: away from zero, or all to one side."""
    x, y = columns
    gap = LABEL_GAP if outward else LABEL_GAP + 1.5
    for word, effect, height in zip(points["word"], points[x], points[y], strict=True):
        left = effect < 0.0 if outward else leftward
        ax.annotate(
            word,
            (effect, height),
            xytext=(-gap if left else gap, 0.0),
            textcoords="offset points",
            ha="right" if left else "left",
            va="center",
            fontsize=LABEL_SIZE,
            color=colour,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.4},
            zorder=2.5,
        )
