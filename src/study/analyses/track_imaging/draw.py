"""Figures ptis_frame and ptis_accuracy: a frame of the imaging system, and its errors."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import Series, figure, stated

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd

    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves


def one_frame_shows_both_legs(y: Curves) -> Stated:
    """Enough dashes of both legs are found for a path each."""
    return stated(all(y(f"{leg} centroids").nunique() > 2 for leg in ("incident", "rebound")))


@figure(
    "ptis_frame",
    "A rendered frame of the imaging system and the track found in it",
    """
        Part of a rendered video field: a sphere of [[particles.diameter_um:.0f]] µm falls at
        [[frame.speed_m_per_s:.2f]] m/s on a surface inclined to an angle of incidence of
        [[frame.angle_deg:.0f]]° and rebounds to the right. The chopped light sheet shows its
        path as dashes. Circles, squares: centroids used. Lines: fitted paths under gravity.
    """,
    {"frame": ""},
    data=("ptis_frame", "ptis_pixels"),
    equations="6, 7",
    finding="One frame gives both speeds and both angles of an impact.",
    holds=one_frame_shows_both_legs,
    method="""
        Dashes near the surface are left out, as the impact bends them. Each path is fitted to
        all dashes of its leg and followed to the instant at which the sphere's centre is half a
        diameter above the surface.
    """,
    width="single",
    height_mm=100.0,
)
def draw_ptis_frame(sheet: Sheet) -> None:
    """A part of a frame with the centroids and paths found in it; rows count downwards.

    ``ptis_pixels`` holds grey levels over columns, one series per row of the frame.
    """
    (ax,) = sheet.panels(
        xlim=(0.0, 640.0), ylim=(0.0, 480.0), xlabel="Column (px)", ylabel="Row (px)"
    )
    image, extent = grey_levels(sheet.tables["ptis_pixels"])
    shown = ax.imshow(image, cmap="gray", vmin=0, vmax=255, extent=extent, zorder=0)
    sheet.figure.colorbar(shown, ax=ax, label="Grey level (counts)", shrink=0.85)
    tracks = {
        "incident centroids": Series("incident dashes", 5),
        "incident path": Series("incident path", 5),
        "rebound centroids": Series("rebound dashes", 4, mark="square"),
        "rebound path": Series("rebound path", 4, line="dashdot"),
        "surface": Series("surface", 2, line="dashed"),
    }
    sheet.draw(ax, tracks)
    ax.set(xlim=extent[:2], ylim=extent[2:], aspect="equal")
    for line in ax.lines:
        if line.get_linestyle() != "None":
            line.set_linewidth(0.8)
        elif line.get_marker() in {"o", "s"}:  # open and small: the dashes show behind them
            line.set(markersize=3.0, markerfacecolor="none", markeredgewidth=0.8)
    # Marks inside the axes would be lost on the picture.
    ax.tick_params(which="both", direction="out", top=False, right=False)
    sheet.keys()


def grey_levels(pixels: pd.DataFrame) -> tuple[np.ndarray, tuple[float, float, float, float]]:
    """Return an image and its extent (left, right, bottom, top) from rows of grey levels."""
    rows = pixels.assign(row=pixels["series"].astype(int))
    table = rows.pivot_table(index="row", columns="x_px", values="y_counts", sort=True)
    lines, columns = table.index.to_numpy(float), table.columns.to_numpy(float)
    left, right = columns[0] - 0.5, columns[-1] + 0.5
    top, bottom = lines[0] - 0.5, lines[-1] + (lines[1] - lines[0]) - 0.5
    return table.to_numpy(), (left, right, bottom, top)


def gravity_matters(y: Curves) -> Stated:
    """Straight lines err at least ten times as much."""
    path, line = (
        max(y(method, leg).abs().max() for leg in ("incident", "rebound"))
        for method in ("path under gravity", "straight line")
    )
    return stated(line > 10.0 * path, path=path, line=line)


@figure(
    "ptis_accuracy",
    "Errors of the speeds measured by the particle trajectory imaging system",
    """
        Mean relative error of the measured speed at the surface, and scatter of single events
        to either side, against the speed of incidence at [[drawn_angle_deg:.0f]]°, from
        rendered frames. Paths under gravity, straight lines at constant speed, and the error
        model that replaces frames in the virtual experiments. The axis is linear up to 0.1 %.
    """,
    {"incident": "incident leg", "rebound": "rebound leg"},
    data=("ptis_accuracy",),
    equations="6, 7",
    finding="""
        Paths under gravity measure the mean speed within {path:.1g} %; straight lines err
        by up to {line:.0f} % at low speed.
    """,
    holds=gravity_matters,
    method="""
        Errors that all events of an experiment share are left out. For each speed the field of
        view and chopper rate are chosen to show most events; where there is no mark, no setting
        could measure the speed. Marks of one speed are drawn side by side.
    """,
    tables={
        "ptis_range": "Events observed, and errors of their speeds, by speed, angle and field of view.",
    },
    height_mm=78.0,
)
def draw_ptis_accuracy(sheet: Sheet) -> None:
    """Errors of both legs against the speed."""
    from study.figures import style

    methods = {
        "path under gravity": Series("path under gravity", 0),
        "straight line": Series("straight line", 1, mark="square"),
        "error model": Series("error model", 2),
    }
    error = "Error of the speed (%), linear to ±0.1"
    for ax in sheet.panels(xscale="log", xlabel="Speed of incidence $v$ (m/s)", ylabel=error):
        ax.set_yscale("symlog", linthresh=0.1)
        ax.set(xlim=(0.1, 50.0), ylim=(-20.0, 20.0))
        style.plain_numbers(ax.yaxis)
        sheet.ticks(ax.xaxis, (1,), decades=True)
        sheet.level(ax, 0.0)
        sheet.draw(ax, methods, apart=1.1)
        sheet.legend(ax, "lower right")
    sheet.keys()
