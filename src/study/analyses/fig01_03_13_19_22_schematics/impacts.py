"""Schematics of an impact: variables, free body diagram, wavy surface (Figs. 3, 13 and 22)."""

from __future__ import annotations

import numpy as np
import pandas as pd

from study.analyses.fig01_03_13_19_22_schematics import parts
from study.analyses.fig01_03_13_19_22_schematics.parts import PALE, STEEL, THICK, THIN, Points, View

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


def fitting(table: pd.DataFrame) -> float:
    """Return the speed, m/s, that is one unit of the drawing if every arrow is to have room."""
    arrows = table[table["series"].isin(ROOM)].groupby(["panel", "series"]).last()
    room = [ROOM[str(name)] for name in arrows.index.get_level_values("series")]
    return float(np.abs(arrows.iloc[:, 1:3].to_numpy(float) / room).max())


def velocities(view: View) -> None:
    """Draw the velocities before and after an impact with their components."""
    ax, (left, right) = view.ax, view.ax.get_xlim()
    parts.ground(ax, left + 0.06, right - 0.06, 0.07)
    contact = np.array([0.0, SPHERE])
    incident, rebound = (view.points[f"{leg} velocity"][1] for leg in ("incident", "rebound"))
    before = contact - incident - 1.3 * SPHERE * parts.unit(parts.direction(incident))
    after = contact + 3.6 * SPHERE * parts.unit(parts.direction(rebound))
    parts.sphere(ax, contact, SPHERE, facecolor="white", edgecolor="0.5", linestyle=(0, (3, 2)))
    parts.guide(ax, [before, contact, after], linestyle=CENTRE_LINE, zorder=4)
    _leg(view, "incident", before, 135.0)
    _leg(view, "rebound", after, 180.0)
    parts.axis(ax, (0.0, 0.0), (0.0, 1.15), "$n$", gap=0.06)
    parts.arrow(ax, (0.0, 0.0), (1.15, 0.0), THIN)
    parts.label(ax, (1.15, 0.07), "$t$")
    parts.guide(ax, [(-0.6, SPHERE), (0.0, SPHERE)])
    turn = parts.direction(-incident), 180.0
    parts.angle(ax, contact, 0.48, turn, view.word("angle"), gap=0.06)
    parts.scale_bar(view, (1.15, -0.18), 0.65, "m/s")


def _leg(view: View, leg: str, centre: Points, spin_at: float) -> None:
    """Draw a sphere with its velocity, components and spin, the latter about a direction."""
    ax = view.ax
    parts.sphere(ax, centre, SPHERE)
    velocity = view.points[f"{leg} velocity"][1]
    for name in ("tangential", "normal"):
        part = view.points[f"{leg} {name}"][1]
        parts.guide(ax, [centre + part, centre + velocity], linestyle=DOTTED)
        parts.arrow(ax, centre, centre + part, 0.9, color=COMPUTED)
        beyond = centre + part + 0.08 * parts.unit(parts.direction(part))
        parts.label(ax, beyond, view.word(f"{leg} {name}"), color=COMPUTED)
    parts.arrow(ax, centre, centre + velocity, 1.5, color=COMPUTED)
    across = parts.unit(parts.direction(velocity) + 90.0)
    spot = centre + 0.55 * velocity + 0.07 * across
    parts.label(ax, spot, view.word(f"{leg} velocity"), color=COMPUTED)
    _spin(view, f"{leg} spin", centre, SPHERE, spin_at)


def _spin(view: View, part: str, centre: Points, radius: float, middle: float) -> None:
    """Draw a spin as an arc as long as the speed of the rim, clockwise in the sense of rolling."""
    speed = float(view.points[part][1, 0])
    around = AROUND * radius
    half = np.degrees(speed / around) / 2
    turn = middle + half, middle - half
    parts.arc(view.ax, centre, around, turn, head=True, color=COMPUTED, linewidth=0.9)
    spot = centre + (around + 0.04) * parts.unit(middle)
    parts.label(view.ax, spot, view.word(part), color=COMPUTED, ha="right")


def momentum_balance(before: View, impulse: View, after: View) -> None:
    """Draw momentum before, impulses and momentum after, side by side, as a sum."""
    _momentum(before)
    _impulses(impulse)
    _momentum(after)
    low, high = before.ax.get_ylim()
    for view, sign in ((before, "$+$"), (impulse, "$=$")):
        box = view.ax.get_position(original=True)
        level = box.y0 + (BODY - low) / (high - low) * box.height
        view.ax.figure.text(box.x1, level, sign, size=14, ha="center", va="center")
    origin = np.array([-0.5, -0.83])
    parts.axis(before.ax, origin, origin + np.array([0.0, 0.38]), "$n$", gap=0.18)
    parts.axis(before.ax, origin, origin + np.array([0.38, 0.0]), "$t$", gap=0.18)
    parts.scale_bar(after, (0.75, -0.83), 0.6, after.word("scale"))


def _momentum(view: View) -> None:
    """Draw a sphere on the surface with its momentum, the normal part above it."""
    ax, centre = view.ax, np.array([0.0, BODY])
    parts.ground(ax, -0.53, 0.53, 0.08)
    parts.sphere(ax, centre, BODY)
    normal, along = view.points["normal"][1], view.points["tangential"][1]
    tail = np.array([0.0, 2.0 * BODY + 0.03]) - np.minimum(normal, 0.0)
    parts.arrow(ax, tail, tail + normal, 1.5, color=COMPUTED)
    spot = tail + normal / 2 + np.array([0.06, 0.0])
    parts.label(ax, spot, view.word("normal"), color=COMPUTED, ha="left")
    tail = np.array([BODY + 0.03, BODY])
    parts.arrow(ax, tail, tail + along, 1.5, color=COMPUTED)
    spot = tail + along / 2 + np.array([0.0, 0.09])
    parts.label(ax, spot, view.word("tangential"), color=COMPUTED)
    _spin(view, "spin", centre, BODY, 180.0)


def _impulses(view: View) -> None:
    """Draw the free body: a sphere with the impulses at its contact point."""
    ax, centre, contact = view.ax, np.array([0.0, BODY]), np.zeros(2)
    parts.guide(ax, [(-0.53, 0.0), (0.53, 0.0)], linestyle=DASHED)
    parts.sphere(ax, centre, BODY)
    normal, along = view.points["normal"][1], view.points["tangential"][1]
    parts.arrow(ax, -normal, contact, 1.5, color=COMPUTED)
    spot = -0.6 * normal + np.array([0.06, 0.0])
    parts.label(ax, spot, view.word("normal"), color=COMPUTED, ha="left")
    parts.arrow(ax, contact, along, 1.5, color=COMPUTED)
    spot = along + np.array([-0.05, -0.09])
    parts.label(ax, spot, view.word("tangential"), color=COMPUTED, ha="right")
    rim = centre + BODY * parts.unit(35.0)
    parts.arrow(ax, centre, rim, THIN)
    parts.label(ax, (centre + rim) / 2 + np.array([-0.03, 0.07]), view.word("radius"))
    for spot in (centre, contact):
        parts.sphere(ax, spot, 0.016, facecolor="black", zorder=7)
    parts.label(ax, contact + np.array([0.07, 0.08]), view.word("contact point"), zorder=7)
    parts.arc(ax, contact, 0.2, (330.0, 215.0), head=True, color="0.4", linewidth=0.7)
    parts.label(ax, (0.24, -0.17), view.word("moment"), color="0.4", ha="left")


def wavy_surface(view: View) -> None:
    """Draw a sphere that strikes a wavy surface, with nominal and local axes and angles."""
    ax, points = view.ax, view.points
    x, z = points["surface"].T
    ax.fill_between(x, ax.get_ylim()[0] + 0.06, z, color=STEEL, linewidth=0.0, zorder=1)
    parts.line(view, "surface", THICK, zorder=2)
    parts.line(view, "mean plane", THIN, zorder=2)
    parts.shape(view, "sphere", points["sphere"], PALE, color="black", zorder=3)
    for kind, colour in (("nominal", "black"), ("local", COMPUTED)):
        for part in (f"{kind} tangent", f"{kind} normal"):
            parts.axis(ax, (0.0, 0.0), points[part][1], view.word(part), color=colour)
        # The tangents are prolonged below the path of the sphere.
        back = -1.08 * points[f"{kind} tangent"]
        parts.guide(ax, back, color=colour, linestyle=DASHED, zorder=4)
    tail, tip = points["incident velocity"]
    parts.arrow(ax, tail, tip, 1.5)
    across = parts.unit(parts.direction(tip - tail) + 90.0)
    parts.label(ax, 0.85 * tail + 0.04 * across, view.word("incident velocity"))
    _angles(view)
    parts.note(view, "mean plane", (0.54, -0.12), leader=(0.5, 0.0), ha="right", va="top")
    spot = np.array([-0.4, np.interp(-0.4, x, z)]) - [0.0, (z.min() + z.max()) / 2]
    parts.note(view, "surface", (-0.48, -0.14), leader=spot, va="top")


def _angles(view: View) -> None:
    """Mark the angles between the lines that are drawn."""
    ax, points, origin = view.ax, view.points, np.zeros(2)
    path = parts.direction(points["incident velocity"][0])
    level, slope = (parts.direction(points[f"{kind} tangent"][1]) for kind in ("nominal", "local"))
    parts.angle(ax, origin, 0.3, (path, 180.0 + level), view.word("angle"), gap=-0.035)
    local = path, 180.0 + slope
    parts.angle(ax, origin, 0.43, local, view.word("local angle"), gap=0.07, color=COMPUTED)
    for first in (level, level + 90.0):
        turn = first, first + slope - level
        parts.angle(ax, origin, 0.3, turn, view.word("slope"), gap=0.035, color=COMPUTED)
