"""Schematic layouts of the two experimental set-ups (Figs. 1 and 2)."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse

from study.figures import style
from study.figures.registry import FigureSpec
from study.figures.schematics import parts as draw
from study.figures.schematics.parts import PALE, STEEL, THIN, Points, Sheet
from study.tables import Tables

LIGHT, OTHER_LIGHT, PROBE = "C2", "C5", "C1"
BEAM = 1.6
OPTICAL_AXIS = (0, (6, 2, 1, 2))


@style.context()
def draw_fig01(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw the particle trajectory imaging system from the side and from above."""
    places = {"side": (0.0, 49.0, 174.0, 76.0), "top": (0.0, 6.0, 174.0, 42.0)}
    figure, sheets = draw.sheets(tables, spec, places)
    _imaging_side(sheets["side"])
    _imaging_top(sheets["top"])
    return figure


def _imaging_side(sheet: Sheet) -> None:
    sheet.ax.fill(*sheet.points["light sheet"].T, color=LIGHT, alpha=0.2, linewidth=0.0, zorder=1)
    _along_the_beam(sheet)
    _disk(sheet)
    draw.box(sheet, "dispenser", "white")
    draw.line(sheet, "plate", 2.0, zorder=5)
    draw.sphere(sheet.ax, sheet.points["rotor"][0], 1.3, facecolor=STEEL)
    needle(sheet, 2.6)
    _target(sheet)
    draw.dashes(sheet, "incident track", 1.8, zorder=5)
    draw.dashes(sheet, "rebound track", 1.8, zorder=5)
    _drop_height(sheet)
    draw.note(sheet, "vacuum cell", (37.0, 31.0), ha="right")
    draw.note(sheet, "lens", (0.0, -10.5))
    draw.note(sheet, "disk", (-11.5, 0.0), ha="right")
    draw.note(sheet, "light sheet", (35.5, 12.5))
    draw.note(sheet, "rotor", (3.0, -0.8), ha="left")
    draw.note(sheet, "needle", (2.2, -3.2), ha="left")
    draw.note(sheet, "target", (-1.0, -12.0), ha="right")
    draw.note(sheet, "incident track", (-1.8, 2.6), ha="right")
    draw.note(sheet, "rebound track", (3.5, -5.0), ha="left")


def _along_the_beam(sheet: Sheet) -> None:
    """Draw the parts along the beam in both views."""
    draw.box(sheet, "vacuum cell", "none", word=False, zorder=2)
    draw.box(sheet, "chopper", "black")
    draw.line(sheet, "laser beam", BEAM, color=LIGHT, zorder=4.5)
    draw.line(sheet, "pulsed beam", BEAM, color=LIGHT, zorder=4.5, linestyle=(0, (1.6, 0.8)))
    draw.box(sheet, "laser", zorder=5)
    draw.box(sheet, "collimator", zorder=5)
    _lens(sheet, "lens", -1.0)


def _lens(sheet: Sheet, part: str, side: float) -> None:
    """Draw a plano-convex lens on the line between two points, bulging to one side of it."""
    ends = sheet.points[part]
    along, middle = (ends[1] - ends[0]) / 2, ends.mean(axis=0)
    across = side * np.array([along[1], -along[0]])
    s = np.linspace(-1.0, 1.0, 41)[:, None]
    draw.shape(sheet, part, middle + s * along + 0.3 * (1.0 - s**2) * across, PALE, zorder=5)


def _disk(sheet: Sheet) -> None:
    """Draw the chopper from the front, above its edge, the beam where it passes."""
    (left, level), (right, _) = sheet.points["disk"]
    centre, radius = np.array([(left + right) / 2, level]), (right - left) / 2
    top = sheet.points["chopper"][1]
    draw.guide(sheet.ax, [(centre[0], top[1]), (centre[0], level - radius)])
    draw.sphere(sheet.ax, centre, radius, facecolor=STEEL)
    draw.dashes(sheet, "slots", 2.8, color="white", zorder=4)
    draw.sphere(sheet.ax, centre, 0.9, facecolor="black")
    passing = sheet.points["slots"][:2].mean(axis=0)
    draw.sphere(sheet.ax, passing, 0.8, facecolor=LIGHT, linewidth=0.0, zorder=6)


def needle(sheet: Sheet, width: float) -> None:
    """Draw a hypodermic needle as a tube."""
    for colour, share in (("black", 1.0), ("white", 0.45)):
        draw.line(sheet, "needle", share * width, color=colour, solid_capstyle="butt", zorder=3)


def _target(sheet: Sheet) -> None:
    """Draw the inclined target, its normal, and the angle of incidence."""
    left, right = sheet.points["target"]
    impact, _ = sheet.points["normal"]
    along = (right - left) / np.hypot(*(right - left))
    down = 2.2 * np.array([along[1], -along[0]])
    draw.shape(sheet, "target", [left, right, right + down, left + down], STEEL)
    draw.line(sheet, "normal", THIN, linestyle=(0, (4, 2)), zorder=3)
    turn = draw.direction(left - impact)
    draw.angle(sheet.ax, impact, 7.5, (turn, 90.0), sheet.word("angle"), gap=-2.2)


def _drop_height(sheet: Sheet) -> None:
    ends = sheet.points["drop height"]
    inner = sheet.points["dispenser"][0, 0], sheet.points["target"][0, 0] + 4.0
    for (x, y), stop in zip(ends, inner, strict=True):
        draw.guide(sheet.ax, [(x - 1.5, y), (stop, y)])
    spot = ends[0] * [1.0, 0.7] + ends[1] * [0.0, 0.3] - [1.5, 0.0]
    draw.dimension(sheet.ax, ends, sheet.word("drop height"), spot, ha="right")


def _imaging_top(sheet: Sheet) -> None:
    _along_the_beam(sheet)
    draw.line(sheet, "light sheet", 2.4, color=LIGHT, alpha=0.4, solid_capstyle="butt")
    draw.line(sheet, "camera axis", THIN, linestyle=OPTICAL_AXIS)
    draw.line(sheet, "porthole", 3.0, solid_capstyle="butt", color="0.45")
    draw.box(sheet, "camera")
    draw.box(sheet, "recorder")
    draw.pointer(sheet, "video signal", THIN)
    (centre,) = sheet.points["sphere"]
    draw.sphere(sheet.ax, centre, 0.9, facecolor="black", zorder=6)
    _viewing_angle(sheet, centre, sheet.points["camera axis"][1])
    draw.note(sheet, "porthole", (8.5, 2.8), ha="left")
    draw.note(sheet, "light sheet", (36.0, 3.2))
    draw.note(sheet, "sphere", (0.0, 3.6))


def _viewing_angle(sheet: Sheet, corner: Points, end: Points) -> None:
    """Mark the angle between an optical axis and the beam ahead."""
    turn = draw.direction(end - corner) % 360.0
    draw.angle(sheet.ax, corner, 4.5, (turn, 360.0), sheet.word("angle"), gap=3.2)


@style.context()
def draw_fig02(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw the phase Doppler particle analyser from above, and its probe volume from the side."""
    places = {"top": (0.0, 6.0, 128.0, 72.0), "side": (128.0, 6.0, 46.0, 72.0)}
    figure, sheets = draw.sheets(tables, spec, places)
    _analyser_top(sheets["top"])
    _analyser_side(sheets["side"])
    return figure


def _analyser_top(sheet: Sheet) -> None:
    ax, points = sheet.ax, sheet.points
    draw.box(sheet, "vacuum cell", "none", word=False, zorder=2)
    draw.box(sheet, "target", STEEL, word=False, zorder=1)
    for part in ("laser beam", "horizontal pair, upper", "horizontal pair, lower"):
        draw.line(sheet, part, 1.1, color=LIGHT)
    draw.line(sheet, "vertical pair", 1.1, color=OTHER_LIGHT)
    for part in ("laser", "frequency shifter", "receiver", "data file"):
        draw.box(sheet, part)
    draw.box(sheet, "beam splitter", word=False)
    _lens(sheet, "transmitting lens", 1.0)
    _lens(sheet, "receiving lens", 1.0)
    draw.line(sheet, "receiver axis", THIN, linestyle=OPTICAL_AXIS, zorder=3)
    for spot in points["detectors"]:
        draw.sphere(ax, spot, 1.5, facecolor="white", zorder=6)
    _probe_volume(sheet, 5.0, 2.0)
    draw.pointer(sheet, "signal", THIN)
    (probe,) = points["probe volume"]
    _viewing_angle(sheet, probe, points["receiver axis"][1])
    draw.note(sheet, "vacuum cell", (19.0, 12.0), ha="left")
    draw.note(sheet, "target", (19.0, -8.0), ha="left", leader=(9.0, -8.0))
    draw.note(sheet, "probe volume", (19.0, 4.0), ha="left", leader=(2.0, 0.6))
    draw.note(sheet, "beam splitter", (0.0, -13.0))
    draw.note(sheet, "transmitting lens", (2.0, -13.0))
    draw.note(sheet, "receiving lens", (9.0, -1.0), ha="left")
    draw.note(sheet, "detectors", (11.0, 0.0), ha="left")
    _beam_key(sheet)


def _beam_key(sheet: Sheet) -> None:
    """Name the velocity that each colour of beams measures, above them."""
    names = {"horizontal pair, upper": LIGHT, "vertical pair": OTHER_LIGHT}
    handles = [
        Line2D([], [], color=colour, linewidth=1.1, label=sheet.word(part))
        for part, colour in names.items()
    ]
    sheet.ax.legend(handles=handles, loc="upper left", bbox_to_anchor=(0.0, 0.915))


def _probe_volume(sheet: Sheet, length: float, width: float) -> None:
    (probe,) = sheet.points["probe volume"]
    spot = float(probe[0]), float(probe[1])
    ellipse = Ellipse(spot, length, width, facecolor=PROBE, edgecolor="black", linewidth=THIN)
    ellipse.set(alpha=0.85, zorder=6)
    sheet.ax.add_patch(ellipse)


def _analyser_side(sheet: Sheet) -> None:
    (left, level), (right, _) = sheet.points["target"]
    draw.ground(sheet.ax, left, right, 3.0, level)
    for part in ("vertical pair", "vertical pair, lower"):
        draw.line(sheet, part, 1.1, color=OTHER_LIGHT)
    _probe_volume(sheet, 6.0, 2.4)
    needle(sheet, 3.2)
    for part in ("incident", "rebound"):
        draw.pointer(sheet, part, 1.0)
    height = sheet.points["probe height"]
    middle = height.mean(axis=0)
    (probe,) = sheet.points["probe volume"]
    draw.guide(sheet.ax, [height[1] - np.array([1.5, 0.0]), probe])
    draw.dimension(sheet.ax, height, sheet.word("probe height"), middle - [1.2, 0.0], ha="right")
    draw.note(sheet, "needle", (2.5, 0.0), ha="left")
    draw.note(sheet, "incident", (2.0, 2.0), ha="left")
    draw.note(sheet, "rebound", (2.0, -1.0), ha="left")
    draw.note(sheet, "target", (0.0, -6.0))
