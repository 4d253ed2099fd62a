"""Figure campaign_map: all experiments of the campaign."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from study.figures.declaration import ANGLE, figure, stated

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable

    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves

FloatArray = NDArray[np.float64]

FEW = "too few events"
# Marks of one cell stand in rows of at most five, this far apart, in cells.
IN_A_ROW = 5
STEP = 0.17, 0.30
AREA = 9.0
# Numbers of the scale; its small ticks are the speeds that occur.
TICKS = (0.1, 0.2, 0.3, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0)


def all_fail_at_shallow_angles(y: Curves) -> Stated:
    """Experiments not completed are at lower normal speeds than most experiments."""
    (table,) = y.tables.values()
    angle, speed = table.iloc[:, 3], table.iloc[:, 4]
    normal, is_few = speed * np.sin(np.radians(angle)), table["panel"] == FEW
    few, steepest = int(is_few.sum()), angle[is_few].max()
    slow = normal[is_few].max() < normal[~is_few].quantile(0.25)
    return stated(slow, few=few, all=len(table) - few, steepest=steepest)


@figure(
    "campaign_map",
    "All experiments of the campaign",
    """
        The virtual experiments of the campaign by particles and surface, angle of incidence and
        nominal speed (colour). At 90° the phase Doppler analyser observes, at other angles the
        imaging system. Open marks: fewer than [[stop.fewest_events]] events although all
        particles allowed were dropped.
    """,
    {"all": ""},
    data=("campaign_map",),
    finding="""
        The {few} experiments of {all} that cannot be completed are at {steepest:.0f}° or
        less, where the normal velocity is low and spheres are captured.
    """,
    holds=all_fail_at_shallow_angles,
    method="""
        The article counts its experiments and their levels (Section 2) and does not list them;
        this selection is declared. Experiments fail because nearly all spheres are captured or
        arrive outside the light sheet.
    """,
    tables={
        "campaign": "Every experiment of the campaign.",
    },
    height_mm=110.0,
)
def draw_campaign_map(sheet: Sheet) -> None:
    """A mark for every experiment: particles on a surface against angle, coloured by speed.

    In a cell the speed grows from left to right. Those with too few events are in panel `FEW`
    again, and drawn open.
    """
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, LogNorm
    from matplotlib.lines import Line2D

    from study.figures.style import EVIDENCE

    (table,) = sheet.tables.values()
    (ax,) = sheet.panels(xlabel=ANGLE, ylabel="Particles and surface")
    x, y = table.columns[3:5]
    few = set(zip(*(table.loc[table["panel"] == FEW, k] for k in ("series", x, y)), strict=True))
    rows = table[table["panel"] != FEW]
    pairs, angles = list(dict.fromkeys(rows["series"])), sorted(set(rows[x]))
    # No colour as light as the paper.
    colours = ListedColormap(colormaps["viridis"](np.linspace(0.0, 0.88, 256)))
    scale = ScalarMappable(LogNorm(rows[y].min(), rows[y].max()), colours)
    for (pair, angle), cell in rows.groupby(["series", x], sort=False):
        at = float(str(angle))
        speeds = np.sort(cell[y].to_numpy())
        across, down = _places(speeds.size)
        edges = scale.to_rgba(speeds)
        is_open = np.array([(pair, at, speed) in few for speed in speeds])
        ax.scatter(
            angles.index(at) + across,
            pairs.index(str(pair)) + down,
            s=AREA,
            edgecolors=[tuple(edge) for edge in edges],
            facecolors=np.where(is_open[:, None], 1.0, edges),
            zorder=3,
        )
    _set_cells(ax, [f"{angle:g}" for angle in angles], pairs)
    _add_scale(ax, scale, sorted(set(rows[y])))
    words = sheet.fill("fewer than [[stop.fewest_events]] events")
    look = EVIDENCE["virtual experiment"] | {"color": "black", "markerfacecolor": "white"}
    sheet.evidence_key([Line2D([], [], label=words, **look)] if few else [])


def _places(number: int) -> tuple[FloatArray, FloatArray]:
    """Return the places of a cell's marks around its middle, in cells."""
    index = np.arange(number)
    row, lines = index // IN_A_ROW, -(-number // IN_A_ROW)
    wide = np.minimum(number - row * IN_A_ROW, IN_A_ROW)
    across = STEP[0] * (index % IN_A_ROW - 0.5 * (wide - 1))
    down = STEP[1] * (row - 0.5 * (lines - 1))
    return across.astype(float), down.astype(float)


def _set_cells(ax: Axes, angles: list[str], pairs: list[str]) -> None:
    ax.set_xticks(range(len(angles)), angles)
    ax.set_yticks(range(len(pairs)), pairs)
    ax.set(xlim=(-0.5, len(angles) - 0.5), ylim=(len(pairs) - 0.5, -0.5))
    ax.tick_params(which="both", length=0)
    for edge in np.arange(0.5, len(pairs) - 1):
        ax.axhline(edge, color="0.88", linewidth=0.5, zorder=1)
    for edge in np.arange(0.5, len(angles) - 1):
        ax.axvline(edge, color="0.88", linewidth=0.5, zorder=1)


def _add_scale(ax: Axes, scale: ScalarMappable, speeds: list[float]) -> None:
    bar = ax.figure.colorbar(scale, ax=ax, pad=0.015, fraction=0.03)
    bar.set_label("Nominal speed (m/s)")
    low, high = min(speeds), max(speeds)
    ticks = [tick for tick in TICKS if low <= tick <= high]
    bar.set_ticks(ticks, labels=[f"{tick:g}" for tick in ticks])
    bar.set_ticks(speeds, labels=[""] * len(speeds), minor=True)
