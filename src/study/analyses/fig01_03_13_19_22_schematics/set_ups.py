"""Schematic layouts of the two experimental set-ups (Figs. 1 and 2)."""

from __future__ import annotations

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse

from study.analyses.fig01_03_13_19_22_schematics import parts
from study.analyses.fig01_03_13_19_22_schematics.parts import PALE, STEEL, THIN, Points, View

LIGHT, OTHER_LIGHT, PROBE = "C2", "C5", "C1"
BEAM = 1.6
OPTICAL_AXIS = (0, (6, 2, 1, 2))


def imaging_side(view: View) -> None:
    """Draw the particle trajectory imaging system from the side."""
    view.ax.fill(*view.points["light sheet"].T, color=LIGHT, alpha=0.2, linewidth=0.0, zorder=1)
    _along_the_beam(view)
    _disk(view)
    parts.box(view, "dispenser", "white")
    parts.line(view, "plate", 2.0, zorder=5)
    parts.sphere(view.ax, view.points["rotor"][0], 1.3, facecolor=STEEL)
    _needle(view, 2.6)
    _target(view)
    parts.dashes(view, "incident track", 1.8, zorder=5)
    parts.dashes(view, "rebound track", 1.8, zorder=5)
    _drop_height(view)
    parts.note(view, "vacuum cell", (37.0, 31.0), ha="right")
    parts.note(view, "lens", (0.0, -10.5))
    parts.note(view, "disk", (-11.5, 0.0), ha="right")
    parts.note(view, "light sheet", (35.5, 12.5))
    parts.note(view, "rotor", (3.0, -0.8), ha="left")
    parts.note(view, "needle", (2.2, -3.2), ha="left")
    parts.note(view, "target", (-1.0, -12.0), ha="right")
    parts.note(view, "incident track", (-1.8, 2.6), ha="right")
    parts.note(view, "rebound track", (3.5, -5.0), ha="left")


def _along_the_beam(view: View) -> None:
    """Draw the parts along the beam in both views."""
    parts.box(view, "vacuum cell", "none", word=False, zorder=2)
    parts.box(view, "chopper", "black")
    parts.line(view, "laser beam", BEAM, color=LIGHT, zorder=4.5)
    parts.line(view, "pulsed beam", BEAM, color=LIGHT, zorder=4.5, linestyle=(0, (1.6, 0.8)))
    parts.box(view, "laser", zorder=5)
    parts.box(view, "collimator", zorder=5)
    _lens(view, "lens", -1.0)


def _lens(view: View, part: str, side: float) -> None:
    """Draw a plano-convex lens on the line between two points, bulging to one side of it."""
    ends = view.points[part]
    along, middle = (ends[1] - ends[0]) / 2, ends.mean(axis=0)
    across = side * np.array([along[1], -along[0]])
    s = np.linspace(-1.0, 1.0, 41)[:, None]
    parts.shape(view, part, middle + s * along + 0.3 * (1.0 - s**2) * across, PALE, zorder=5)


def _disk(view: View) -> None:
    """Draw the chopper from the front, above its edge, the beam where it passes."""
    (left, level), (right, _) = view.points["disk"]
    centre, radius = np.array([(left + right) / 2, level]), (right - left) / 2
    top = view.points["chopper"][1]
    parts.guide(view.ax, [(centre[0], top[1]), (centre[0], level - radius)])
    parts.sphere(view.ax, centre, radius, facecolor=STEEL)
    parts.dashes(view, "slots", 2.8, color="white", zorder=4)
    parts.sphere(view.ax, centre, 0.9, facecolor="black")
    passing = view.points["slots"][:2].mean(axis=0)
    parts.sphere(view.ax, passing, 0.8, facecolor=LIGHT, linewidth=0.0, zorder=6)


def _needle(view: View, width: float) -> None:
    """Draw a hypodermic needle as a tube."""
    for colour, share in (("black", 1.0), ("white", 0.45)):
        parts.line(view, "needle", share * width, color=colour, solid_capstyle="butt", zorder=3)


def _target(view: View) -> None:
    """Draw the inclined target, its normal, and the angle of incidence."""
    left, right = view.points["target"]
    impact, _ = view.points["normal"]
    along = (right - left) / np.hypot(*(right - left))
    down = 2.2 * np.array([along[1], -along[0]])
    parts.shape(view, "target", [left, right, right + down, left + down], STEEL)
    parts.line(view, "normal", THIN, linestyle=(0, (4, 2)), zorder=3)
    turn = parts.direction(left - impact)
    parts.angle(view.ax, impact, 7.5, (turn, 90.0), view.word("angle"), gap=-2.2)


def _drop_height(view: View) -> None:
    ends = view.points["drop height"]
    inner = view.points["dispenser"][0, 0], view.points["target"][0, 0] + 4.0
    for (x, y), stop in zip(ends, inner, strict=True):
        parts.guide(view.ax, [(x - 1.5, y), (stop, y)])
    spot = ends[0] * [1.0, 0.7] + ends[1] * [0.0, 0.3] - [1.5, 0.0]
    parts.dimension(view.ax, ends, view.word("drop height"), spot, ha="right")


def imaging_top(view: View) -> None:
    """Draw the particle trajectory imaging system from above."""
    _along_the_beam(view)
    parts.line(view, "light sheet", 2.4, color=LIGHT, alpha=0.4, solid_capstyle="butt")
    parts.line(view, "camera axis", THIN, linestyle=OPTICAL_AXIS)
    parts.line(view, "porthole", 3.0, solid_capstyle="butt", color="0.45")
    parts.box(view, "camera")
    parts.box(view, "recorder")
    parts.pointer(view, "video signal", THIN)
    (centre,) = view.points["sphere"]
    parts.sphere(view.ax, centre, 0.9, facecolor="black", zorder=6)
    _viewing_angle(view, centre, view.points["camera axis"][1])
    parts.note(view, "porthole", (8.5, 2.8), ha="left")
    parts.note(view, "light sheet", (36.0, 3.2))
    parts.note(view, "sphere", (0.0, 3.6))


def _viewing_angle(view: View, corner: Points, end: Points) -> None:
    """Mark the angle between an optical axis and the beam ahead."""
    turn = parts.direction(end - corner) % 360.0
    parts.angle(view.ax, corner, 4.5, (turn, 360.0), view.word("angle"), gap=3.2)


def analyser_top(view: View) -> None:
    """Draw the phase Doppler particle analyser from above."""
    ax, points = view.ax, view.points
    parts.box(view, "vacuum cell", "none", word=False, zorder=2)
    parts.box(view, "target", STEEL, word=False, zorder=1)
    for part in ("laser beam", "horizontal pair, upper", "horizontal pair, lower"):
        parts.line(view, part, 1.1, color=LIGHT)
    parts.line(view, "vertical pair", 1.1, color=OTHER_LIGHT)
    for part in ("laser", "frequency shifter", "receiver", "data file"):
        parts.box(view, part)
    parts.box(view, "beam splitter", word=False)
    _lens(view, "transmitting lens", 1.0)
    _lens(view, "receiving lens", 1.0)
    parts.line(view, "receiver axis", THIN, linestyle=OPTICAL_AXIS, zorder=3)
    for spot in points["detectors"]:
        parts.sphere(ax, spot, 1.5, facecolor="white", zorder=6)
    _probe_volume(view, 5.0, 2.0)
    parts.pointer(view, "signal", THIN)
    (probe,) = points["probe volume"]
    _viewing_angle(view, probe, points["receiver axis"][1])
    parts.note(view, "vacuum cell", (19.0, 12.0), ha="left")
    parts.note(view, "target", (19.0, -8.0), ha="left", leader=(9.0, -8.0))
    parts.note(view, "probe volume", (19.0, 4.0), ha="left", leader=(2.0, 0.6))
    parts.note(view, "beam splitter", (0.0, -13.0))
    parts.note(view, "transmitting lens", (2.0, -13.0))
    parts.note(view, "receiving lens", (9.0, -1.0), ha="left")
    parts.note(view, "detectors", (11.0, 0.0), ha="left")
    _beam_key(view)


def _beam_key(view: View) -> None:
    """Name the velocity that each colour of beams measures, above them."""
    names = {"horizontal pair, upper": LIGHT, "vertical pair": OTHER_LIGHT}
    handles = [
        Line2D([], [], color=colour, linewidth=1.1, label=view.word(part))
        for part, colour in names.items()
    ]
    view.ax.legend(handles=handles, loc="upper left", bbox_to_anchor=(0.0, 0.915))


def _probe_volume(view: View, length: float, width: float) -> None:
    (probe,) = view.points["probe volume"]
    spot = float(probe[0]), float(probe[1])
    ellipse = Ellipse(spot, length, width, facecolor=PROBE, edgecolor="black", linewidth=THIN)
    ellipse.set(alpha=0.85, zorder=6)
    view.ax.add_patch(ellipse)


def analyser_side(view: View) -> None:
    """Draw the probe volume of the phase Doppler particle analyser from the side."""
    (left, level), (right, _) = view.points["target"]
    parts.ground(view.ax, left, right, 3.0, level)
    for part in ("vertical pair", "vertical pair, lower"):
        parts.line(view, part, 1.1, color=OTHER_LIGHT)
    _probe_volume(view, 6.0, 2.4)
    _needle(view, 3.2)
    for part in ("incident", "rebound"):
        parts.pointer(view, part, 1.0)
    height = view.points["probe height"]
    middle = height.mean(axis=0)
    (probe,) = view.points["probe volume"]
    parts.guide(view.ax, [height[1] - np.array([1.5, 0.0]), probe])
    parts.dimension(view.ax, height, view.word("probe height"), middle - [1.2, 0.0], ha="right")
    parts.note(view, "needle", (2.5, 0.0), ha="left")
    parts.note(view, "incident", (2.0, 2.0), ha="left")
    parts.note(view, "rebound", (2.0, -1.0), ha="left")
    parts.note(view, "target", (0.0, -6.0))
