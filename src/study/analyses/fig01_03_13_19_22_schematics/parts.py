"""Vocabulary of the schematic figures: parts, arrows, angles, dimensions and labels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, FancyArrowPatch, Polygon
from numpy.typing import ArrayLike, NDArray

from study.figures.style import WIDTH_MM, Sheet

Points = NDArray[np.float64]
Range = tuple[float, float]

# How a part shows its evidence, and the words of the key.
INK: dict[str, dict[str, Any]] = {
    "printed": {"color": "black"},
    "assumed": {"color": "0.4", "linestyle": (0, (3.0, 1.6))},
    "computed": {"color": "C0"},
}
KEY = {
    "printed": "named or stated in the article",
    "assumed": "assumed",
    "computed": "computed, to scale",
}
THIN, MEDIUM, THICK = 0.5, 0.8, 1.3
STEEL, PALE = "0.8", "0.94"


@dataclass(frozen=True, slots=True)
class View:
    """One panel of a schematic: where it is drawn, points and evidence of its parts, their words.

    One unit of the drawing is `scale` of the table.
    """

    ax: Axes
    points: Mapping[str, Points]
    evidence: Mapping[str, str]
    words: Mapping[str, str]
    scale: float

    def word(self, part: str) -> str:
        """Return the label of a part; empty if it has none."""
        return self.words.get(part, "")

    def ink(self, part: str, width: float = MEDIUM) -> dict[str, Any]:
        """Return the pen for a part, by its evidence."""
        return {**INK[self.evidence[part]], "linewidth": width}


def view(
    sheet: Sheet,
    name: str,
    frame: tuple[float, float, float, float],
    ends: tuple[Range, Range],
    words: Mapping[str, str],
    scale: float = 1.0,
) -> View:
    """Add a panel, without axes, whose units are equally long along x and y.

    Parameters
    ----------
    sheet
        Its first table holds the parts of all panels.
    name
        Of the panel.
    frame
        Its left and lower end, width and height, mm.
    ends
        What is drawn of x and of y.
    words
        Labels by part.
    scale
        What counts as one in the ends, in the unit of the table: a drawing in multiples of, say,
        the radius keeps its looks at another radius.
    """
    figure, titles = sheet.figure, sheet.declared.panels
    figure.set_layout_engine("none")
    width, height = WIDTH_MM[sheet.declared.width], sheet.declared.height_mm
    left, low, wide, high = frame
    ax = figure.add_axes((left / width, low / height, wide / width, high / height))
    ax.set(xlim=ends[0], ylim=ends[1], aspect="equal")
    ax.set_axis_off()
    if title := titles[name]:
        prefix = f"({'abcdefgh'[list(titles).index(name)]}) " if len(titles) > 1 else ""
        spot = (left + 1.0) / width, (low + high - 0.5) / height
        figure.text(*spot, prefix + sheet.fill(title), va="top", size=9)
    table = sheet.tables[sheet.declared.data[0]]
    groups = {
        str(part): rows
        for part, rows in table[table["panel"] == name].groupby("series", sort=False)
    }
    points = {part: rows.iloc[:, 3:5].to_numpy(float) / scale for part, rows in groups.items()}
    evidence = {part: str(rows["evidence"].iloc[0]) for part, rows in groups.items()}
    return View(ax, points, evidence, {p: sheet.fill(word) for p, word in words.items()}, scale)


def key(sheet: Sheet) -> None:
    """Give the evidence of the lines below the drawing."""
    evidence = set(sheet.tables[sheet.declared.data[0]]["evidence"])
    handles = [
        Line2D([], [], linewidth=THICK, label=KEY[name], **look)
        for name, look in INK.items()
        if name in evidence
    ]
    sheet.figure.legend(handles=handles, loc="lower center", ncols=len(handles), borderaxespad=0.4)


def unit(turn: ArrayLike) -> Points:
    """Return the unit vector at an angle from x, degrees."""
    angle = np.radians(np.asarray(turn, dtype=float))
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def direction(vector: ArrayLike) -> float:
    """Return the angle of a vector from x, degrees."""
    x, y = np.asarray(vector, dtype=float)
    return float(np.degrees(np.arctan2(y, x)))


def label(ax: Axes, spot: ArrayLike, text: str, **look: Any) -> None:
    """Write a text centred on a spot, or as `ha` and `va` say."""
    x, y = np.asarray(spot, dtype=float)
    ax.text(x, y, text, **{"ha": "center", "va": "center", "linespacing": 1.05, **look})


def note(
    view: View, part: str, offset: ArrayLike, leader: ArrayLike | None = None, **look: Any
) -> None:
    """Write the word of a part beside its middle, with a thin line to a spot on it if given."""
    points = view.points[part]
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    spot = middle + np.asarray(offset, dtype=float)
    if leader is not None:
        end = middle + np.asarray(leader, dtype=float)
        guide(view.ax, [0.95 * spot + 0.05 * end, end], color="0.4", zorder=6.5)
    label(view.ax, spot, view.word(part), **look)


def line(view: View, part: str, width: float = MEDIUM, **look: Any) -> None:
    """Draw a part as a line through its points."""
    view.ax.plot(*view.points[part].T, **{**view.ink(part, width), **look})


def guide(ax: Axes, points: ArrayLike, **look: Any) -> None:
    """Draw a thin grey line through points."""
    pen: dict[str, Any] = {"color": "0.5", "linewidth": THIN, "zorder": 2}
    ax.plot(*np.asarray(points, dtype=float).T, **{**pen, **look})


def dashes(view: View, part: str, width: float, **look: Any) -> None:
    """Draw a part as separate strokes, one for each two points."""
    pen = {**view.ink(part, width), "solid_capstyle": "butt", **look}
    for stroke in view.points[part].reshape(-1, 2, 2):
        view.ax.plot(*stroke.T, **pen)


def box(view: View, part: str, face: str = PALE, *, word: bool = True, **look: Any) -> None:
    """Draw a part as a box between two corners or as an outline, with its word inside."""
    points = view.points[part]
    if len(points) == 2:
        (left, low), (right, high) = points
        points = np.array([[left, low], [right, low], [right, high], [left, high]])
    shape(view, part, points, face, **look)
    if word:
        label(view.ax, points.mean(axis=0), view.word(part), zorder=7)


def shape(view: View, part: str, points: ArrayLike, face: str, **look: Any) -> None:
    """Draw a closed outline with the pen of a part."""
    pen = {**view.ink(part), "zorder": 4, **look}
    pen["edgecolor"] = pen.pop("color")
    view.ax.add_patch(Polygon(np.asarray(points), closed=True, facecolor=face, **pen))


def sphere(ax: Axes, centre: ArrayLike, radius: float, **look: Any) -> None:
    """Draw a sphere as a disk."""
    x, y = np.asarray(centre, dtype=float)
    pen = {"facecolor": PALE, "edgecolor": "black", "linewidth": MEDIUM, "zorder": 3}
    ax.add_patch(Circle((x, y), radius, **{**pen, **look}))


def arrow(ax: Axes, tail: ArrayLike, tip: ArrayLike, width: float = THICK, **look: Any) -> None:
    """Draw an arrow whose point ends exactly at the tip; nothing if it has no length."""
    ends = np.asarray([tail, tip], dtype=float)
    if np.array_equal(*ends):
        return
    pen = {"arrowstyle": "-|>", "color": "black", "mutation_scale": 5.0 + 3.0 * width, "zorder": 6}
    pen |= {"shrinkA": 0.0, "shrinkB": 0.0, "linewidth": width, "joinstyle": "miter"}
    ax.add_patch(FancyArrowPatch(*map(tuple, ends), **{**pen, **look}))


def pointer(view: View, part: str, width: float) -> None:
    """Draw a part as an arrow between its two points."""
    tail, tip = view.points[part]
    arrow(view.ax, tail, tip, width, color=view.ink(part)["color"])


def axis(ax: Axes, origin: ArrayLike, tip: ArrayLike, word: str, **look: Any) -> None:
    """Draw a coordinate axis with its name beyond the tip."""
    colour = look.pop("color", "black")
    gap = look.pop("gap", 0.08)
    arrow(ax, origin, tip, THIN, color=colour, **look)
    tip, origin = np.asarray(tip, dtype=float), np.asarray(origin, dtype=float)
    label(ax, tip + gap * (tip - origin), word, color=colour)


def arc(ax: Axes, centre: ArrayLike, radius: float, turn: Sequence[float], **look: Any) -> None:
    """Draw an arc from one angle to another, degrees; with ``head`` it ends in an arrow."""
    head = look.pop("head", False)
    first, last = turn
    points = np.asarray(centre) + radius * unit(np.linspace(first, last, 80))
    pen = {"color": "black", "linewidth": THIN, **look}
    if not head:
        ax.plot(*points.T, **pen)
        return
    # The line stops within the head, whose chord is so short that it follows the arc.
    back = max(len(points) - 8, 1)
    ax.plot(*points[: back + 1].T, **pen)
    arrow(ax, points[back], points[-1], pen["linewidth"], color=pen["color"])


def angle(
    ax: Axes, corner: ArrayLike, radius: float, turn: tuple[float, float], word: str, **look: Any
) -> None:
    """Mark an angle by an arc, with its word beyond the middle of the arc."""
    gap = look.pop("gap", 0.0)
    arc(ax, corner, radius, turn, zorder=6, **look)
    spot = np.asarray(corner) + (radius + gap) * unit(sum(turn) / 2)
    label(ax, spot, word, color=look.get("color", "black"), zorder=7)


def dimension(ax: Axes, ends: ArrayLike, text: str, spot: ArrayLike, **look: Any) -> None:
    """Draw a distance between two points, with its value at a spot."""
    first, second = np.asarray(ends, dtype=float)
    arrow(ax, first, second, THIN, arrowstyle="<|-|>", color=look.pop("color", "black"))
    label(ax, spot, text, **look)


def scale_bar(view: View, right: ArrayLike, longest: float, unit: str) -> None:
    """Draw a round length that ends at a spot, its value to the left.

    Parameters
    ----------
    longest
        What the length must not exceed, in units of the drawing.
    unit
        That of the table, as it is written.
    """
    most = longest * view.scale
    power = 10.0 ** np.floor(np.log10(most))
    value = max(step * power for step in (1.0, 2.0, 5.0) if step * power <= most)
    end = np.asarray(right, dtype=float)
    begin = end - np.array([value / view.scale, 0.0])
    gap = np.array([0.03 * longest, 0.0])
    dimension(view.ax, (begin, end), f"{value:g} {unit}", begin - 2.0 * gap, ha="right")


def ground(ax: Axes, left: float, right: float, depth: float, level: float = 0.0) -> None:
    """Draw a solid surface, hatched below."""
    ax.fill_between(
        [left, right], level - depth, level, facecolor="none", edgecolor="0.6", hatch="//////",
        linewidth=0.0, zorder=1,
    )  # fmt: skip
    ax.plot([left, right], [level, level], color="black", linewidth=MEDIUM, zorder=2)
