"""Schematic of the stresses on a pressed sphere, to scale (Fig. 19)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from study.analyses.fig01_03_13_19_22_schematics import parts
from study.analyses.fig01_03_13_19_22_schematics.parts import MEDIUM, PALE, THIN, Points, View

HERTZ, RING = "C0", "C1"
# The contact is seen from above and in front: its depth is shortened.
DEPTH = 0.3
# Lengths of the greatest pressure and of the ring tension on the drawing, in contact radii.
PEAK, PULL = 1.0, 0.5
ARROWS, RINGS = 13, 24
# Farther to the side an arrow behind would lie on the one in front of it.
SIDE = 0.75
DEGREES = np.linspace(0.0, 360.0, 181)


def section(view: View) -> None:
    """Draw a sphere at its greatest compression, in multiples of its radius, and its depth."""
    ax, points = view.ax, view.points
    left, right = ax.get_xlim()
    parts.ground(ax, left + 0.06, right - 0.06, 0.065)
    parts.shape(view, "sphere", points["sphere"], PALE, zorder=2)
    parts.line(view, "free shape", THIN, color="0.4", linestyle=(0, (3, 2)), zorder=3)
    parts.line(view, "contact", 2.2, zorder=4, solid_capstyle="butt")
    (centre,) = points["centre"]
    parts.sphere(ax, centre, 0.02, facecolor="black", zorder=6)
    parts.axis(ax, centre, centre + np.array([0.0, 1.1]), "$n$", gap=0.05)
    parts.axis(ax, centre, centre + np.array([1.2, 0.0]), "$t$", gap=0.06)
    parts.arc(ax, centre, 0.36, (150.0, 30.0), head=True)
    parts.label(ax, centre + np.array([0.14, 0.46]), view.word("spin"))
    rim = centre + parts.unit(150.0)
    parts.arrow(ax, centre, rim, THIN)
    parts.label(ax, (centre + rim) / 2 + np.array([0.02, 0.08]), view.word("radius"))
    a, lowest = points["contact"][1, 0], points["free shape"][:, 1].min()
    level = -0.2
    for x in (0.0, a):
        parts.guide(ax, [(x, 0.0), (x, level - 0.03)], zorder=5)
    text = f"{view.word('contact')} = {a * view.scale:.2f} µm"
    parts.dimension(ax, ((0.0, level), (a, level)), text, (a + 0.04, level), ha="left")
    text = f"{view.word('free shape')} = {-1000.0 * lowest * view.scale:.0f} nm"
    parts.label(ax, (-a - 0.04, level), text, ha="right")
    parts.guide(ax, [(-a - 0.06, level + 0.04), (-0.01, lowest)], zorder=5)


def stresses(view: View, pressure: Points, tension: float) -> None:
    """Draw the pressure as a dome below the contact that pushes up, and the tension of its edge.

    Parameters
    ----------
    view
        In multiples of the radius of the contact.
    pressure
        A row per point from the left: abscissa, and pressure, GPa.
    tension
        Ring tension, N/m.
    """
    ax = view.ax
    rho, share = (pressure / pressure.max(axis=0)).T
    height = PEAK * share
    profile = _seen(rho, 0.0, -height)
    ax.fill(*profile.T, color=HERTZ, alpha=0.1, linewidth=0.0, zorder=2)
    ax.plot(*profile.T, color=HERTZ, linewidth=1.2, zorder=5)
    _dome(view, rho, height)
    edge = _around(1.0, 0.0, DEGREES)
    ax.fill(*edge.T, color="white", alpha=0.65, linewidth=0.0, zorder=3)
    ax.plot(*edge.T, color=RING, linewidth=1.4, zorder=6)
    parts.guide(ax, [(-1.0, 0.0), (1.0, 0.0)], color=HERTZ, linewidth=MEDIUM, zorder=6)
    for x in np.linspace(-1.0, 1.0, ARROWS + 2)[1:-1]:
        parts.arrow(ax, (x, -np.interp(x, rho, height)), (x, 0.0), 0.7, color=HERTZ)
    for turn in 360.0 * (np.arange(RINGS) + 0.5) / RINGS:
        foot, behind = _around(1.0, 0.0, turn), turn < 180.0
        if not (behind and abs(foot[0]) > SIDE):
            layer = 1 if behind else 7
            parts.arrow(ax, foot, foot - np.array([0.0, PULL]), 0.8, color=RING, zorder=layer)
    _values(view, float(pressure[:, 1].max()), tension)


def _seen(x: ArrayLike, y: ArrayLike, z: ArrayLike) -> Points:
    """Return points in space as they are drawn: x across, y into the depth, z up."""
    across, depth, up = np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in (x, y, z)))
    return np.stack([across, DEPTH * depth + up], axis=-1)


def _around(radius: float, height: float, turn: ArrayLike) -> Points:
    """Return points of a level circle as they are drawn, at angles in degrees."""
    circle = radius * parts.unit(turn)
    return _seen(circle[..., 0], circle[..., 1], height)


def _dome(view: View, rho: Points, height: Points) -> None:
    """Draw the dome of pressure: its outline as it is seen, and lines of equal radius."""
    half = np.sqrt(np.maximum(1.0 - rho**2, 0.0))
    depth = half[:, None] * np.linspace(-1.0, 1.0, 201)
    dome = _seen(rho[:, None], depth, -np.interp(np.hypot(rho[:, None], depth), rho, height))
    outline = np.stack([rho, dome[..., 1].min(axis=1)], axis=-1)
    view.ax.fill(*outline.T, color=HERTZ, alpha=0.1, linewidth=0.0, zorder=2)
    view.ax.plot(*outline.T, color=HERTZ, linewidth=0.6, zorder=2)
    for radius in (0.35, 0.65, 0.88):
        circle = _around(radius, -float(np.interp(radius, rho, height)), DEGREES)
        view.ax.plot(*circle.T, color=HERTZ, linewidth=0.4, alpha=0.6, zorder=2)


def _values(view: View, peak: float, tension: float) -> None:
    """Write the greatest pressure (GPa) and the ring tension (N/m) beside them; name the radius."""
    ax = view.ax
    text = f"{view.word('pressure')} = {peak:.3f} GPa"
    parts.label(ax, (0.0, -PEAK - 0.12), text, color=HERTZ, va="top")
    text = f"{view.word('ring tension')} =\n{tension:.2f} N/m"
    parts.label(ax, (-1.08, -PULL / 2), text, color=RING, ha="right")
    level = DEPTH + 0.18
    parts.guide(ax, [(1.0, 0.0), (1.0, level + 0.04)], zorder=6)
    parts.dimension(
        ax, ((0.0, level), (1.0, level)), view.word("contact radius"), (0.5, level + 0.12)
    )
    parts.axis(ax, (0.0, 0.0), (0.0, 0.66), "$n$", gap=0.07)
