"""Schematic of the stresses on a pressed sphere, to scale (Fig. 19)."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from study.figures import style
from study.figures.registry import FigureSpec
from study.figures.schematics import parts as draw
from study.figures.schematics.parts import MEDIUM, PALE, THIN, Points, Sheet
from study.tables import Tables

HERTZ, RING = "C0", "C1"
# The contact is seen from above and in front: its depth is shortened.
DEPTH = 0.3
# Lengths of the greatest pressure and of the ring tension on the drawing, in contact radii.
PEAK, PULL = 1.0, 0.5
ARROWS, RINGS = 13, 24
# Farther to the side an arrow behind would lie on the one in front of it.
SIDE = 0.75
DEGREES = np.linspace(0.0, 360.0, 181)


@style.context()
def draw_fig19(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw a sphere at its greatest compression, and the stresses on its contact.

    Ranges are in multiples of the radius of the sphere, and of that of the contact.
    """
    places = {"section": (0.0, 6.0, 76.0, 72.0), "stresses": (76.0, 6.0, 98.0, 72.0)}
    section = tables["fig19"]
    radius = float(section.loc[section["series"] == "free shape", "x_um"].max())
    figure, sheets = draw.sheets(tables, spec, places, radius)
    _section(sheets["section"], radius)
    pressure = tables["fig19_pressure"][["x_um", "y_GPa"]].to_numpy(float)
    tension = float(tables["fig19_ring"]["y_N_per_m"].abs().max())
    _stresses(sheets["stresses"], pressure / pressure.max(axis=0))
    _values(sheets["stresses"], float(pressure[:, 1].max()), tension)
    return figure


def _section(sheet: Sheet, radius: float) -> None:
    """Draw the sphere in multiples of its radius, and name its compression."""
    ax, points = sheet.ax, sheet.points
    left, right = sheet.panel.x_range
    draw.ground(ax, left + 0.06, right - 0.06, 0.065)
    draw.shape(sheet, "sphere", points["sphere"], PALE, zorder=2)
    draw.line(sheet, "free shape", THIN, color="0.4", linestyle=(0, (3, 2)), zorder=3)
    draw.line(sheet, "contact", 2.2, zorder=4, solid_capstyle="butt")
    (centre,) = points["centre"]
    draw.sphere(ax, centre, 0.02, facecolor="black", zorder=6)
    draw.axis(ax, centre, centre + np.array([0.0, 1.1]), "$n$", gap=0.05)
    draw.axis(ax, centre, centre + np.array([1.2, 0.0]), "$t$", gap=0.06)
    draw.arc(ax, centre, 0.36, (150.0, 30.0), head=True)
    draw.label(ax, centre + np.array([0.14, 0.46]), sheet.word("spin"))
    rim = centre + draw.unit(150.0)
    draw.arrow(ax, centre, rim, THIN)
    draw.label(ax, (centre + rim) / 2 + np.array([0.02, 0.08]), sheet.word("radius"))
    a, lowest = points["contact"][1, 0], points["free shape"][:, 1].min()
    level = -0.2
    for x in (0.0, a):
        draw.guide(ax, [(x, 0.0), (x, level - 0.03)], zorder=5)
    text = f"{sheet.word('contact')} = {a * radius:.2f} µm"
    draw.dimension(ax, ((0.0, level), (a, level)), text, (a + 0.04, level), ha="left")
    text = f"{sheet.word('free shape')} = {-1000.0 * lowest * radius:.0f} nm"
    draw.label(ax, (-a - 0.04, level), text, ha="right")
    draw.guide(ax, [(-a - 0.06, level + 0.04), (-0.01, lowest)], zorder=5)


def _stresses(sheet: Sheet, pressure: Points) -> None:
    """Draw the pressure as a dome below the contact that pushes up, and the tension of its edge.

    The pressure is given over the greatest one, against the radius over that of the contact.
    """
    ax = sheet.ax
    rho, height = pressure[:, 0], PEAK * pressure[:, 1]
    section = _seen(rho, 0.0, -height)
    ax.fill(*section.T, color=HERTZ, alpha=0.1, linewidth=0.0, zorder=2)
    ax.plot(*section.T, color=HERTZ, linewidth=1.2, zorder=5)
    _dome(sheet, rho, height)
    edge = _around(1.0, 0.0, DEGREES)
    ax.fill(*edge.T, color="white", alpha=0.65, linewidth=0.0, zorder=3)
    ax.plot(*edge.T, color=RING, linewidth=1.4, zorder=6)
    draw.guide(ax, [(-1.0, 0.0), (1.0, 0.0)], color=HERTZ, linewidth=MEDIUM, zorder=6)
    for x in np.linspace(-1.0, 1.0, ARROWS + 2)[1:-1]:
        draw.arrow(ax, (x, -np.interp(x, rho, height)), (x, 0.0), 0.7, color=HERTZ)
    for turn in 360.0 * (np.arange(RINGS) + 0.5) / RINGS:
        foot, behind = _around(1.0, 0.0, turn), turn < 180.0
        if not (behind and abs(foot[0]) > SIDE):
            layer = 1 if behind else 7
            draw.arrow(ax, foot, foot - np.array([0.0, PULL]), 0.8, color=RING, zorder=layer)


def _seen(x: ArrayLike, y: ArrayLike, z: ArrayLike) -> Points:
    """Return points in space as they are drawn: x across, y into the depth, z up."""
    across, depth, up = np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in (x, y, z)))
    return np.stack([across, DEPTH * depth + up], axis=-1)


def _around(radius: float, height: float, turn: ArrayLike) -> Points:
    """Return points of a level circle as they are drawn, at angles in degrees."""
    circle = radius * draw.unit(turn)
    return _seen(circle[..., 0], circle[..., 1], height)


def _dome(sheet: Sheet, rho: Points, height: Points) -> None:
    """Draw the dome of pressure: its outline as it is seen, and lines of equal radius."""
    half = np.sqrt(np.maximum(1.0 - rho**2, 0.0))
    depth = half[:, None] * np.linspace(-1.0, 1.0, 201)
    dome = _seen(rho[:, None], depth, -np.interp(np.hypot(rho[:, None], depth), rho, height))
    outline = np.stack([rho, dome[..., 1].min(axis=1)], axis=-1)
    sheet.ax.fill(*outline.T, color=HERTZ, alpha=0.1, linewidth=0.0, zorder=2)
    sheet.ax.plot(*outline.T, color=HERTZ, linewidth=0.6, zorder=2)
    for radius in (0.35, 0.65, 0.88):
        circle = _around(radius, -float(np.interp(radius, rho, height)), DEGREES)
        sheet.ax.plot(*circle.T, color=HERTZ, linewidth=0.4, alpha=0.6, zorder=2)


def _values(sheet: Sheet, peak: float, tension: float) -> None:
    """Write the greatest pressure (GPa) and the ring tension (N/m) beside them; name the radius."""
    ax = sheet.ax
    text = f"{sheet.word('pressure')} = {peak:.3f} GPa"
    draw.label(ax, (0.0, -PEAK - 0.12), text, color=HERTZ, va="top")
    text = f"{sheet.word('ring tension')} =\n{tension:.2f} N/m"
    draw.label(ax, (-1.08, -PULL / 2), text, color=RING, ha="right")
    level = DEPTH + 0.18
    draw.guide(ax, [(1.0, 0.0), (1.0, level + 0.04)], zorder=6)
    draw.dimension(
        ax, ((0.0, level), (1.0, level)), sheet.word("contact radius"), (0.5, level + 0.12)
    )
    draw.axis(ax, (0.0, 0.0), (0.0, 0.66), "$n$", gap=0.07)
