"""Figure of a frame of the particle trajectory imaging system, with its track."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from study.figures import style
from study.figures.registry import FigureSpec
from study.tables import Tables


@style.context()
def draw(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw a part of a frame with the centroids and paths found in it; rows count downwards.

    ``ptis_pixels`` holds grey levels over columns, one series per row of the frame.
    """
    figure, axes = style.new_figure(spec)
    ((name, panel),) = spec.panels.items()
    ax, track = axes[name], tables["ptis_frame"]
    image, extent = grey_levels(tables["ptis_pixels"])
    shown = ax.imshow(image, cmap="gray", vmin=0, vmax=255, extent=extent, zorder=0)
    figure.colorbar(shown, ax=ax, label="Grey level (counts)", shrink=0.85)
    style.draw_panel(ax, track, panel, name)
    ax.set(xlim=extent[:2], ylim=extent[2:], aspect="equal")
    # Open and small: the dashes show behind their centroids.
    for marks in (line for line in ax.lines if line.get_marker() in style.MARKS.values()):
        marks.set(markersize=3.0, markerfacecolor="none", markeredgewidth=0.8)
    for path in (line for line in ax.lines if line.get_linestyle() != "None"):
        path.set_linewidth(0.8)
    # Marks inside the axes would be lost on the picture.
    ax.tick_params(which="both", direction="out", top=False, right=False)
    style.legend_above(figure, [ax])
    style.evidence_key(figure, track["evidence"])
    return figure


def grey_levels(pixels: pd.DataFrame) -> tuple[np.ndarray, tuple[float, float, float, float]]:
    """Return an image and its extent (left, right, bottom, top) from rows of grey levels."""
    rows = pixels.assign(row=pixels["series"].astype(int))
    table = rows.pivot_table(index="row", columns="x_px", values="y_counts", sort=True)
    lines, columns = table.index.to_numpy(float), table.columns.to_numpy(float)
    left, right = columns[0] - 0.5, columns[-1] + 0.5
    top, bottom = lines[0] - 0.5, lines[-1] + (lines[1] - lines[0]) - 0.5
    return table.to_numpy(), (left, right, bottom, top)
