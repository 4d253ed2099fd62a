"""Records of cameras and clocks from text files, reduced to rebounds."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from microimpact.core.arrays import FloatArray, Range, checked
from microimpact.core.constants import gravity
from microimpact.core.nearest import nearest
from microimpact.lab.records import Reduced, reduce_heights, reduce_times, reduce_tracks
from microimpact.measured.table import PLACE_UNITS, PLACES, TIME_UNITS, Column, Table, read_table

_COUNTS = {"": 1.0, "frame": 1.0}


def _axis(name: str) -> tuple[str, ...]:
    """Usual names of a coordinate: of TrackMate, MOSAIC, DLTdv, ImageJ and others."""
    forms = ("{}_px", "pos_{}", "position_{}", "{}_pos", "{}_position", "centroid_{}", "{}_center")
    return tuple(form.format(name) for form in (*forms, "pt1_cam1_{}", "pt1_{}", "c{}"))


TIME = ("time", "position_t", "bounce", "bounce_time", "time_of_bounce", "t_bounce")
COLUMNS = {
    "frame": Column(
        units=_COUNTS,
        names=("frame_number", "frame_no", "frame_index", "image", "slice", "slice_n°", "slice_no"),
    ),
    "t": Column(units=TIME_UNITS, names=TIME, letters=("T",)),
    "x": Column(units=PLACE_UNITS, kind=PLACES, names=_axis("x"), letters=("X",)),
    "y": Column(units=PLACE_UNITS, kind=PLACES, names=_axis("y"), letters=("Y",)),
    "d": Column(units=PLACE_UNITS, kind=PLACES, names=("diameter", "d_p", "dp")),
    "radius": Column(units=PLACE_UNITS, kind=PLACES, names=("r_p", "rp"), letters=("R",)),
    "h0": Column(
        units=PLACE_UNITS, kind=PLACES, names=("drop_height", "h_drop", "height_of_drop", "h_0")
    ),
    "h1": Column(
        units=PLACE_UNITS,
        kind=PLACES,
        names=("rebound_height", "h_rebound", "bounce_height", "h_1"),
    ),
    "track": Column(
        names=("track_id", "tid", "track_n°", "track_no", "track_number", "trajectory", "particle",
               "particle_id", "track_name"),
    ),
}  # fmt: skip
# Options by what the columns hold.
OPTIONS = {
    "tracks": ("fps", "um_per_px", "wall", "tilt", "gravity", "y"),
    "heights": ("um_per_px", "drag", "sigma_h"),
    "times": ("sigma_t",),
}
DIRECTIONS = {"gravity": ("down", "none"), "y": ("down", "up")}
# Relative error up to which a fall is compared with g, and errors from which on it differs.
WELL_KNOWN, DIFFERENT = 0.2, 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Records:
    """Rebounds of a file.

    Attributes
    ----------
    reduced
        The rebounds; its ``columns`` go into `microimpact.read_rebounds`.
    read
        What was read, in a line.
    notes
        What was left out of the file or is doubtful, a sentence each.
    """

    reduced: Reduced
    read: str
    notes: tuple[str, ...]


def read_records(
    source: Path | str | Mapping[str, Any],
    *,
    fps: float | None = None,
    um_per_px: float | None = None,
    wall: float | str | None = None,
    tilt: float | None = None,
    gravity: str | None = None,
    y: str | None = None,
    drag: float | None = None,
    sigma_h: float | None = None,
    sigma_t: float | None = None,
    size_unit: str | None = None,
    skip_bad_rows: bool = False,
    **reading: Any,
) -> Records:
    """Read tracks, heights of drop and rebound, or times of bounces, and reduce them to rebounds.

    Parameters
    ----------
    source
        A text file, a data frame or a mapping of arrays with the columns x, y and frame or t (and
        track, d or radius); or h0 and h1 (and d); or t alone.
    fps
        Frames per second.
    um_per_px
        Size of a pixel, um.
    wall
        Direction of the wall in the picture, degrees from the horizontal, counterclockwise; two
        points of it, ``"x1,y1,x2,y2"``, as in the file; or ``"find"``.
    tilt
        Standard deviation of this direction, degrees.
    gravity
        ``"down"`` the picture, or ``"none"``, as of beams.
    y
        Direction in which y grows: ``"down"``, as in most pictures, or ``"up"``.
    drag
        Density of spheres that fall through air, kg/m3; None: in vacuum.
    sigma_h, sigma_t
        Standard deviations of heights, um, and of the clock, us.
    size_unit
        Of x, y and heights where the table states none; None: px.
    skip_bad_rows, **reading
        As of `microimpact.read_rebounds`.

    Raises
    ------
    OSError, TypeError, ValueError
        As of `microimpact.read_rebounds`, and for an option that lacks or does not belong here.
    """
    table = read_table(source, COLUMNS, units={PLACES: size_unit}, **reading)
    options = {"fps": fps, "um_per_px": um_per_px, "wall": wall, "tilt": tilt, "gravity": gravity}
    options |= {"y": y, "drag": drag, "sigma_h": sigma_h, "sigma_t": sigma_t}
    settings = {name: value for name, value in options.items() if value is not None}
    kind = _kind(table)
    if excess := [name for name in settings if name not in OPTIONS[kind]]:
        raise ValueError(f"{table.name} holds {kind}; leave out {', '.join(map(_flag, excess))}")
    _check(settings)
    notes = [*table.unused]
    columns = {"tracks": ("x", "y"), "heights": ("h0", "h1"), "times": ("t",)}[kind]
    columns += tuple(name for name in ("frame", "t") if kind == "tracks" and name in table.numbers)
    columns = tuple(name for name in columns if not (name == "t" and "frame" in columns and fps))
    if kind == "heights":
        table.require("h0", table.numbers["h0"] > 0.0, "positive")
        table.require("h1", table.numbers["h1"] >= 0.0, "0 or more")
    lacking = np.any([np.isnan(table.numbers[name]) for name in columns], axis=0)
    rows, others = table.kept(lacking, skip_bad_rows=skip_bad_rows)
    notes += others
    numbers = {name: x[rows] for name, x in table.numbers.items()}
    lengths = _lengths(table, numbers, um_per_px)
    names = [cell for cell, kept in zip(table.cells["track"], rows, strict=True) if kept] if (
        "track" in table.cells) else None  # fmt: skip
    if kind == "tracks":
        reduced = _tracks(table, numbers | lengths, names, np.flatnonzero(rows), settings, notes)
    elif kind == "heights":
        size = lengths.get("d", np.nan)
        if drag is not None and not np.all(size > 0.0):
            raise ValueError(f"{table.name}: --drag needs the column d, positive in each row")
        error = 1e-6 * (sigma_h or 0.0)
        reduced = reduce_heights(
            lengths["h0"], lengths["h1"], sigma=error, diameter=size, density=drag
        )
    else:
        reduced = _times(table, numbers["t"], names, rows, 1e-6 * (sigma_t or 0.0))
    return Records(reduced=reduced, read=_words(table, reduced, kind), notes=tuple(notes))


def _kind(table: Table) -> str:
    has = {*table.cells}
    if {"h0", "h1"} <= has:
        return "heights"
    if {"x", "y"} <= has:
        return "tracks"
    if "t" in has and not {"x", "y"} & has:
        return "times"
    names = [*table.cells, *table.ignored]
    near = "".join(nearest(name, table.ignored) for name in ("x", "y") if name not in has)
    raise ValueError(
        f"{table.name}: the columns x, y and frame or t are needed, or h0 and h1, or t alone, got "
        f"{', '.join(map(repr, names))}{near}; other names go by --columns x=NAME,y=NAME"
    )


def _flag(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def _check(settings: Mapping[str, Any]) -> None:
    """Raise ValueError for an option out of range."""
    for name, allowed in DIRECTIONS.items():
        if name in settings and settings[name] not in allowed:
            raise ValueError(
                f"{_flag(name)} must be {' or '.join(allowed)}, got {settings[name]!r}"
            )
    for name in ("fps", "um_per_px", "drag"):
        if name in settings:
            checked(_flag(name), settings[name], Range(lower=0.0))
    for name in ("tilt", "sigma_h", "sigma_t"):
        if name in settings:
            checked(_flag(name), settings[name], Range(lower=0.0, lower_closed=True))


def _lengths(
    table: Table, numbers: Mapping[str, FloatArray], um_per_px: float | None
) -> dict[str, FloatArray]:
    """Columns of lengths in m, those in pixels by their size; d from a radius."""
    lengths = {}
    for name in (name for name in numbers if COLUMNS[name].kind == PLACES):
        pixels = table.units[name] == "px"
        if name in {"d", "radius"} and name not in table.stated:
            raise ValueError(f"{table.name}: {name} needs a unit in the header: '{name} (um)'")
        if pixels and um_per_px is None:
            raise ValueError(
                f"{table.name}: {name} is in px; give --um-per-px, or --size-unit if it is not"
            )
        factor = 1e-6 * float(um_per_px or 1.0) if pixels else 1.0
        lengths[name] = factor * numbers[name]
    if "radius" in lengths and "d" in lengths:
        raise ValueError(f"{table.name}: either d or radius must be given, got both")
    if "radius" in lengths:
        lengths["d"] = 2.0 * lengths.pop("radius")
    return lengths


def _tracks(
    table: Table,
    numbers: Mapping[str, FloatArray],
    names: list[str] | None,
    row: Any,
    settings: Mapping[str, Any],
    notes: list[str],
) -> Reduced:
    """Reduce the tracks, and add notes on them."""
    fps = settings.get("fps")
    if fps is None and "t" not in numbers:
        raise ValueError(f"{table.name}: without a column t give --fps")
    if fps is None:
        time = numbers["t"]
    elif "frame" in numbers:
        time = numbers["frame"] / fps
    elif "t" in numbers:
        raise ValueError(f"{table.name} has times t and no frames; leave out --fps")
    else:
        time = row / fps
        notes.append(f"{table.name}: no column of frames; each row is taken for the next frame")
    sign = 1.0 if settings.get("y") == "up" else -1.0
    if "wall" not in settings:
        raise ValueError("give --wall: an angle in degrees, 'x1,y1,x2,y2' or find")
    reduced = reduce_tracks(
        *(time, numbers["x"], sign * numbers["y"], names),
        wall=_wall(settings["wall"], sign),
        diameter=numbers.get("d", np.nan),
        tilt=settings.get("tilt", 0.0),
        with_gravity=settings.get("gravity") != "none",
    )
    notes += _doubt(reduced, 0.0 if settings.get("gravity") == "none" else gravity)
    return reduced


def _wall(wall: float | str, sign: float) -> Any:
    """Direction of the wall, degrees, or ``"find"``."""
    if wall == "find":
        return wall
    try:
        numbers = [float(part) for part in str(wall).split(",")]
    except ValueError:
        numbers = []
    ends = np.array(numbers[2:]) - numbers[:2] if len(numbers) == 4 else np.zeros(2)
    if not np.all(np.isfinite(numbers)) or not (len(numbers) == 1 or np.any(ends)):
        raise ValueError(
            f"--wall must be an angle in degrees, two points 'x1,y1,x2,y2' or find, got {wall!r}"
        )
    if len(numbers) == 1:
        return numbers[0]
    return float(np.degrees(np.arctan2(sign * ends[1], ends[0])))


def _doubt(reduced: Reduced, expected: float) -> list[str]:
    """Compare the fall of all tracks with gravity, which sees a wrong scale, rate or direction."""
    known = np.isfinite(reduced.fall)
    weights = 1.0 / reduced.sigma_fall[known] ** 2
    if not weights.size or not np.all(np.isfinite(weights)):
        return []
    error = float(np.sum(weights) ** -0.5)
    fall = float(np.sum(weights * reduced.fall[known]) * error**2)
    if error > WELL_KNOWN * max(abs(fall), gravity) or abs(fall - expected) <= DIFFERENT * error:
        return []
    return [
        f"the paths fall with {fall:.3g} +- {error:.1g} m/s2, not {expected:.3g}: is it the scale, "
        "the rate of frames, the direction of y, or drag?"
    ]


def _times(
    table: Table, time: FloatArray, names: list[str] | None, rows: Any, error: float
) -> Reduced:
    """Reduce the bounces of one sphere, or of each that is named."""
    labels = names or [""] * time.size
    where = [place for place, kept in zip(table.where, rows, strict=True) if kept]
    parts = []
    for name in dict.fromkeys(labels):
        mine = [i for i, label in enumerate(labels) if label == name]
        wrong = [b for a, b in pairwise(mine) if time[b] <= time[a]]
        if wrong:
            raise ValueError(f"{table.name}, {where[wrong[0]]}: t must ascend, got "
                             f"{table.cells['t'][np.flatnonzero(rows)[wrong[0]]]}")  # fmt: skip
        if len(mine) < 3:
            raise ValueError(f"{table.name}: three bounces are needed of a sphere, got {len(mine)}")
        parts.append(reduce_times(time[mine], sigma=error))
    return Reduced.joined(parts)


def _words(table: Table, reduced: Reduced, kind: str) -> str:
    """Rows, impacts and reasons, in a line."""
    lost = Counter(reduced.reason[~reduced.used].tolist())
    left = "; ".join(f"{number} {reason}" for reason, number in lost.most_common())
    tracks = "" if kind != "tracks" else f" in {len({*reduced.track.tolist()})} tracks"
    return (
        f"{table.name}: {np.count_nonzero(reduced.used)} impacts{tracks}, "
        f"{np.count_nonzero(reduced.captured)} captured; {sum(lost.values())} left out"
        f"{': ' if left else ''}{left}"
    )
