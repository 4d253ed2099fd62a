"""Schematics of an impact: variables, free body diagram, wavy surface (Figs. 3, 13 and 22)."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from study.figures import style
from study.figures.registry import FigureSpec
from study.figures.schematics import parts as draw
from study.figures.schematics.parts import PALE, STEEL, THICK, THIN, Points, Sheet
from study.tables import Tables

COMPUTED = "C0"
CENTRE_LINE, DASHED, DOTTED = (0, (6, 2, 1, 2)), (0, (4, 2)), (0, (2, 2))

# Radii of the spheres of Figs. 3 and 13, in units of the drawing.
SPHERE, BODY = 0.16, 0.28
# How far arrows may reach along t and n so that all of them find room.
ROOM = {
    "incident velocity": (0.87, 0.64),
    "rebound velocity": (0.62, 0.5),
    "tangential": (0.8, 0.8),
    "normal": (1.0, 1.0),
}
# Radius of the arcs of spin over that of the sphere.
AROUND = 1.3


@style.context()
def draw_fig03(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw the velocities before and after an impact with their components."""
    places, scale = {"impact": (0.0, 6.0, 86.0, 55.0)}, _fitting(tables["fig03"], spec)
    figure, sheets = draw.sheets(tables, spec, places, scale)
    sheet = sheets["impact"]
    ax, (left, right) = sheet.ax, sheet.panel.x_range
    draw.ground(ax, left + 0.06, right - 0.06, 0.07)
    contact = np.array([0.0, SPHERE])
    incident, rebound = (sheet.points[f"{leg} velocity"][1] for leg in ("incident", "rebound"))
    before = contact - incident - 1.3 * SPHERE * draw.unit(draw.direction(incident))
    after = contact + 3.6 * SPHERE * draw.unit(draw.direction(rebound))
    draw.sphere(ax, contact, SPHERE, facecolor="white", edgecolor="0.5", linestyle=(0, (3, 2)))
    draw.guide(ax, [before, contact, after], linestyle=CENTRE_LINE, zorder=4)
    _leg(sheet, "incident", before, 135.0)
    _leg(sheet, "rebound", after, 180.0)
    draw.axis(ax, (0.0, 0.0), (0.0, 1.15), "$n$", gap=0.06)
    draw.arrow(ax, (0.0, 0.0), (1.15, 0.0), THIN)
    draw.label(ax, (1.15, 0.07), "$t$")
    draw.guide(ax, [(-0.6, SPHERE), (0.0, SPHERE)])
    turn = draw.direction(-incident), 180.0
    draw.angle(ax, contact, 0.48, turn, sheet.word("angle"), gap=0.06)
    draw.scale_bar(ax, (1.15, -0.18), 0.65, scale, "m/s")
    return figure


def _fitting(table: pd.DataFrame, spec: FigureSpec) -> float:
    """Return the speed, m/s, that is one unit of the drawing if every arrow is to have room."""
    shares = [
        np.abs(vector / ROOM[name]).max()
        for panel in spec.panels
        for name, vector in draw.vectors(table, panel).items()
        if name in ROOM
    ]
    return float(max(shares))


def _leg(sheet: Sheet, leg: str, centre: Points, spin_at: float) -> None:
    """Draw a sphere with its velocity, components and spin, the latter about a direction."""
    ax = sheet.ax
    draw.sphere(ax, centre, SPHERE)
    velocity = sheet.points[f"{leg} velocity"][1]
    for name in ("tangential", "normal"):
        part = sheet.points[f"{leg} {name}"][1]
        draw.guide(ax, [centre + part, centre + velocity], linestyle=DOTTED)
        draw.arrow(ax, centre, centre + part, 0.9, color=COMPUTED)
        beyond = centre + part + 0.08 * draw.unit(draw.direction(part))
        draw.label(ax, beyond, sheet.word(f"{leg} {name}"), color=COMPUTED)
    draw.arrow(ax, centre, centre + velocity, 1.5, color=COMPUTED)
    across = draw.unit(draw.direction(velocity) + 90.0)
    spot = centre + 0.55 * velocity + 0.07 * across
    draw.label(ax, spot, sheet.word(f"{leg} velocity"), color=COMPUTED)
    _spin(sheet, f"{leg} spin", centre, SPHERE, spin_at)


def _spin(sheet: Sheet, part: str, centre: Points, radius: float, middle: float) -> None:
    """Draw a spin as an arc as long as the speed of the rim, clockwise in the sense of rolling."""
    speed = float(sheet.points[part][1, 0])
    around = AROUND * radius
    half = np.degrees(speed / around) / 2
    turn = middle + half, middle - half
    draw.arc(sheet.ax, centre, around, turn, head=True, color=COMPUTED, linewidth=0.9)
    spot = centre + (around + 0.04) * draw.unit(middle)
    draw.label(sheet.ax, spot, sheet.word(part), color=COMPUTED, ha="right")


@style.context()
def draw_fig13(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw momentum before, impulses and momentum after, as a sum."""
    places = {name: (58.0 * i, 6.0, 58.0, 77.0) for i, name in enumerate(spec.panels)}
    scale = _fitting(tables["fig13"], spec)
    figure, sheets = draw.sheets(tables, spec, places, scale)
    before, impulse, after = (sheets[name] for name in ("before", "impulse", "after"))
    _momentum(before)
    _impulses(impulse)
    _momentum(after)
    low, high = before.panel.y_range
    level = ((BODY - low) / (high - low) * 77.0 + 6.0) / spec.height_mm
    for middle, sign in ((58.0, "$+$"), (116.0, "$=$")):
        figure.text(middle / 174.0, level, sign, size=14, ha="center", va="center")
    origin = np.array([-0.5, -0.83])
    draw.axis(before.ax, origin, origin + np.array([0.0, 0.38]), "$n$", gap=0.18)
    draw.axis(before.ax, origin, origin + np.array([0.38, 0.0]), "$t$", gap=0.18)
    draw.scale_bar(after.ax, (0.75, -0.83), 0.6, scale, after.word("scale"))
    return figure


def _momentum(sheet: Sheet) -> None:
    """Draw a sphere on the surface with its momentum, the normal part above it."""
    ax, centre = sheet.ax, np.array([0.0, BODY])
    draw.ground(ax, -0.53, 0.53, 0.08)
    draw.sphere(ax, centre, BODY)
    normal, along = sheet.points["normal"][1], sheet.points["tangential"][1]
    tail = np.array([0.0, 2.0 * BODY + 0.03]) - np.minimum(normal, 0.0)
    draw.arrow(ax, tail, tail + normal, 1.5, color=COMPUTED)
    spot = tail + normal / 2 + np.array([0.06, 0.0])
    draw.label(ax, spot, sheet.word("normal"), color=COMPUTED, ha="left")
    tail = np.array([BODY + 0.03, BODY])
    draw.arrow(ax, tail, tail + along, 1.5, color=COMPUTED)
    spot = tail + along / 2 + np.array([0.0, 0.09])
    draw.label(ax, spot, sheet.word("tangential"), color=COMPUTED)
    _spin(sheet, "spin", centre, BODY, 180.0)


def _impulses(sheet: Sheet) -> None:
    """Draw the free body: a sphere with the impulses at its contact point."""
    ax, centre, contact = sheet.ax, np.array([0.0, BODY]), np.zeros(2)
    draw.guide(ax, [(-0.53, 0.0), (0.53, 0.0)], linestyle=DASHED)
    draw.sphere(ax, centre, BODY)
    normal, along = sheet.points["normal"][1], sheet.points["tangential"][1]
    draw.arrow(ax, -normal, contact, 1.5, color=COMPUTED)
    spot = -0.6 * normal + np.array([0.06, 0.0])
    draw.label(ax, spot, sheet.word("normal"), color=COMPUTED, ha="left")
    draw.arrow(ax, contact, along, 1.5, color=COMPUTED)
    spot = along + np.array([-0.05, -0.09])
    draw.label(ax, spot, sheet.word("tangential"), color=COMPUTED, ha="right")
    rim = centre + BODY * draw.unit(35.0)
    draw.arrow(ax, centre, rim, THIN)
    draw.label(ax, (centre + rim) / 2 + np.array([-0.03, 0.07]), sheet.word("radius"))
    for spot in (centre, contact):
        draw.sphere(ax, spot, 0.016, facecolor="black", zorder=7)
    draw.label(ax, contact + np.array([0.07, 0.08]), sheet.word("contact point"), zorder=7)
    draw.arc(ax, contact, 0.2, (330.0, 215.0), head=True, color="0.4", linewidth=0.7)
    draw.label(ax, (0.24, -0.17), sheet.word("moment"), color="0.4", ha="left")


@style.context()
def draw_fig22(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw a sphere that strikes a wavy surface, with nominal and local axes and angles.

    Ranges are in multiples of half the length of the surface, a wavelength.
    """
    wavelength = float(draw.vectors(tables["fig22"], "geometry")["surface"][0])
    places = {"geometry": (0.0, 6.0, 86.0, 60.0)}
    figure, sheets = draw.sheets(tables, spec, places, wavelength)
    sheet = sheets["geometry"]
    ax, points = sheet.ax, sheet.points
    x, z = points["surface"].T
    ax.fill_between(x, sheet.panel.y_range[0] + 0.06, z, color=STEEL, linewidth=0.0, zorder=1)
    draw.line(sheet, "surface", THICK, zorder=2)
    draw.line(sheet, "mean plane", THIN, zorder=2)
    draw.shape(sheet, "sphere", points["sphere"], PALE, color="black", zorder=3)
    for kind, colour in (("nominal", "black"), ("local", COMPUTED)):
        for part in (f"{kind} tangent", f"{kind} normal"):
            draw.axis(ax, (0.0, 0.0), points[part][1], sheet.word(part), color=colour)
        # The tangents are prolonged below the path of the sphere.
        back = -1.08 * points[f"{kind} tangent"]
        draw.guide(ax, back, color=colour, linestyle=DASHED, zorder=4)
    tail, tip = points["incident velocity"]
    draw.arrow(ax, tail, tip, 1.5)
    across = draw.unit(draw.direction(tip - tail) + 90.0)
    draw.label(ax, 0.85 * tail + 0.04 * across, sheet.word("incident velocity"))
    _angles(sheet)
    draw.note(sheet, "mean plane", (0.54, -0.12), leader=(0.5, 0.0), ha="right", va="top")
    spot = np.array([-0.4, np.interp(-0.4, x, z)]) - [0.0, (z.min() + z.max()) / 2]
    draw.note(sheet, "surface", (-0.48, -0.14), leader=spot, va="top")
    return figure


def _angles(sheet: Sheet) -> None:
    """Mark the angles between the lines that are drawn."""
    ax, points, origin = sheet.ax, sheet.points, np.zeros(2)
    path = draw.direction(points["incident velocity"][0])
    level, slope = (draw.direction(points[f"{kind} tangent"][1]) for kind in ("nominal", "local"))
    draw.angle(ax, origin, 0.3, (path, 180.0 + level), sheet.word("angle"), gap=-0.035)
    local = path, 180.0 + slope
    draw.angle(ax, origin, 0.43, local, sheet.word("local angle"), gap=0.07, color=COMPUTED)
    for first in (level, level + 90.0):
        turn = first, first + slope - level
        draw.angle(ax, origin, 0.3, turn, sheet.word("slope"), gap=0.035, color=COMPUTED)
