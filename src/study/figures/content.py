"""The content of a drawn figure as a table: its words, and all artists with look and extent."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axis import Axis
from matplotlib.backend_bases import RendererBase
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike, NDArray

from study.figures.declaration import Figure as Words

POINTS_PER_INCH = 72.0
# Panel of all that stands outside of the declared panels.
FIGURE = "figure"
# How Matplotlib labels artists without a label.
AUTOMATIC = ("_child", "_container", "_nolegend_")
EXTENT = ("x_low", "x_high", "y_low", "y_high")


def content(figure: Figure, words: Words) -> pd.DataFrame:
    """Return the content of a figure: its words, then all that is drawn in the `style.context`.

    Parameters
    ----------
    figure
        The figure as it was saved, its layout made. It is drawn again, at a point a pixel: what a
        table says does not depend on the formats in which the figure was saved.
    words
        What is said of it, filled in.

    Returns
    -------
    pandas.DataFrame
        ``panel``; ``artist``: class; ``text``: words, or the label of a series; ``look``: marks,
        then colour, width and dashes of strokes, fills, and numbers of points; ``x_low``,
        ``x_high``, ``y_low``, ``y_high``: extent in points (1/72 inch) from the lower left corner.
    """
    rows: list[dict[str, Any]] = [
        {"panel": FIGURE, "artist": name, "text": getattr(words, name)}
        for name in ("title", "finding", "caption", "method")
    ]
    labels = {
        child: str(container.get_label())
        for ax in figure.axes
        for container in ax.containers
        for child in container.get_children()
    }
    figure.dpi = POINTS_PER_INCH
    figure.draw(_Recorder())
    for parent in (*figure.axes, *figure.legends, *figure.texts):
        for artist in _leaves(parent):
            recorder = _Recorder()
            artist.draw(recorder)
            if recorder.looks:
                label = labels.get(artist, str(artist.get_label()))
                label = "" if label.startswith(AUTOMATIC) else label
                rows.append(
                    {
                        "panel": str(parent.get_label()) or FIGURE,
                        "artist": type(artist).__name__,
                        "text": "; ".join(recorder.words) or label,
                        "look": "; ".join((*_mark(artist), *recorder.counted())),
                        **recorder.extent(),
                    }
                )
    return pd.DataFrame(rows, columns=["panel", "artist", "text", "look", *EXTENT])


def _leaves(artist: Artist) -> Iterator[Artist]:
    """Return the visible artists that an artist is made of; an axis with its ticks is one."""
    children = [] if isinstance(artist, Axis) else artist.get_children()
    if artist.get_visible():
        yield from (leaf for child in children for leaf in _leaves(child)) if children else [artist]


def _mark(artist: Artist) -> list[str]:
    mark = artist.get_marker() if isinstance(artist, Line2D) else None
    return [] if mark in (None, "None", "none", "") else [f"mark {mark}"]


class _Recorder(RendererBase):
    """Renderer that notes words, looks with their numbers of points, and where they are."""

    def __init__(self) -> None:
        super().__init__()
        self.words: list[str] = []
        self.looks: Counter[str] = Counter()
        self.corners: list[NDArray[np.float64]] = []

    def counted(self) -> list[str]:
        """Return each look with its number of points."""
        return [f"{look}: {number}" for look, number in self.looks.items()]

    def extent(self) -> dict[str, float]:
        """Return the ends of all that was drawn, to a tenth."""
        low, high = np.min(self.corners, axis=0), np.max(self.corners, axis=0)
        ends = np.round(np.array([low, high]).T.ravel(), 1) + 0.0
        return dict(zip(EXTENT, ends.tolist(), strict=True))

    def draw_path(self, gc: Any, path: Any, transform: Any, rgbFace: Any = None) -> None:
        self._note(_look(gc, rgbFace), transform.transform(path.vertices))

    def draw_markers(self, gc: Any, *shapes: Any, rgbFace: Any = None) -> None:
        _, _, path, transform, *face = shapes
        self._note(_look(gc, *face or [rgbFace]), transform.transform(path.vertices))

    def draw_text(self, gc: Any, x: float, y: float, s: str, *_: Any, **__: Any) -> None:
        self.words.append(s)
        self._note(_look(gc, None), [(x, y)])

    def draw_image(self, _: Any, x: float, y: float, im: Any, transform: Any = None) -> None:
        del transform  # None: an image is drawn as it is
        self._note("image", [(x, y), (x + im.shape[1], y + im.shape[0])])

    def flipy(self) -> bool:
        return False

    def _note(self, look: str, vertices: ArrayLike) -> None:
        points = np.asarray(vertices, float)
        points = points[np.isfinite(points).all(axis=1)]
        if points.size:
            self.looks[look] += len(points)
            self.corners += [points.min(axis=0), points.max(axis=0)]


def _look(gc: Any, face: Any) -> str:
    def colour(rgba: Any) -> str:
        return to_hex(rgba, keep_alpha=True).removesuffix("ff")

    stroke = f"{colour(gc.get_rgb())} {gc.get_linewidth():.3g}" if gc.get_linewidth() else "none"
    dashes = "".join(f" {length:.3g}" for length in gc.get_dashes()[1] or ())
    hatch = f" hatched {gc.get_hatch()}" if gc.get_hatch() else ""
    fill = "" if face is None else f" on {colour(face)}"
    return f"{stroke}{dashes and f' dashed{dashes}'}{hatch}{fill}"
