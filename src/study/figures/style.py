"""One look for all figures, and one way to save them that gives the same bytes each time."""

from __future__ import annotations

import io
import math
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pandas as pd
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.colors import to_rgb
from matplotlib.container import Container
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from numpy.typing import NDArray

from microimpact.core.files import write_file
from study.figures.registry import FigureSpec, PanelSpec, SeriesSpec
from study.tables import POINTS, Tables, points_parts

# Kinds of lines by their names in the registry: as many as a panel has curves.
LINES: dict[str, str | tuple[int, tuple[float, ...]]] = {
    "solid": "solid",
    "dashed": "dashed",
    "dotted": "dotted",
    "dashdot": "dashdot",
    "long dashed": (0, (6.0, 1.5)),
    "dashdotdot": (0, (4.5, 1.2, 1.0, 1.2, 1.0, 1.2)),
    "loose dashed": (0, (3.0, 3.0)),
}
TINT: dict[str, Any] = {"alpha": 0.25}
GUIDE: dict[str, Any] = {"linewidth": 0.6, "alpha": 0.7, "zorder": 2}
HATCH: dict[str, Any] = {"facecolor": "none", "hatch": "//////", "alpha": 0.45}
MARKS = {"circle": "o", "square": "s", "triangle": "^"}
# Points of others and of the user, series by series: readings from a figure, and measurements.
POINT_MARKS = {"digitised": ("x", "+", "1", "2", "3"), "measured": ("o", "s", "^", "v", "P")}
# Where the name of a curve stands beside it: shift in points, and which part of it is there.
SIDES: dict[str, tuple[tuple[float, float], str, str]] = {
    "above": ((0.0, 2.5), "center", "bottom"),
    "below": ((0.0, -2.5), "center", "top"),
    "right": ((5.0, 0.0), "left", "center"),
}

# Up to here a logarithmic axis of either sign is linear.
LINEAR = 0.1

STYLE_FILE = Path(__file__).with_name("microimpact.mplstyle")

WIDTH_MM = {"single": 86.0, "double": 174.0}
MM_PER_INCH = 25.4
# Room that an entry of the key takes: its mark, and a letter of its label.
KEY_MARK_MM, KEY_LETTER_MM = 12.0, 1.2
# What each format would say of date and program: left out, as keys with the value None are.
UNDATED = {
    "svg": ("Date", "Creator"),
    "png": ("Software",),
    "pdf": ("CreationDate", "Creator", "Producer"),
}
# Packed lightly: a tenth larger, in two thirds of the time.
PACKED = {"compress_level": 1}

# How a mark shows its evidence; lines are computed, marks come from elsewhere. Simulated data are
# drawn in half-tone, so that nobody takes them for measured ones, which are the heaviest marks.
LIGHT = 0.35
HEAVY: dict[str, Any] = {"markersize": 5.0, "markeredgewidth": 1.2, "zorder": 4}
EVIDENCE: dict[str, dict[str, Any]] = {
    "computed": {"linestyle": "solid"},
    "calibrated": {"linestyle": "solid"},
    "printed": {"linestyle": "none", "marker": "D", "markerfacecolor": "white"},
    "virtual experiment": {"linestyle": "none", "marker": "o", "markerfacecolor": "0.75"},
    "digitised": {"linestyle": "none", "marker": "x", **HEAVY},
    "measured": {"linestyle": "none", "marker": "o", **HEAVY},
    "assumed": {"linestyle": "none", "marker": "+"},
}
EVIDENCE_LABEL = {
    "printed": "printed in the article",
    "virtual experiment": "virtual experiment",
    "assumed": "assumed",
}


@contextmanager
def context() -> Iterator[None]:
    """Return the context (also a decorator) in which figures are drawn and saved.

    It is the same whatever the user's own settings of matplotlib are.
    """
    with rc_context(fname=STYLE_FILE):
        yield


def _sheet(spec: FigureSpec) -> Figure:
    """Return an empty figure of the size declared."""
    return Figure(figsize=(WIDTH_MM[spec.width] / MM_PER_INCH, spec.height_mm / MM_PER_INCH))


def new_figure(spec: FigureSpec) -> tuple[Figure, dict[str, Axes]]:
    """Return an empty figure with its panels, by name, axes set up."""
    figure = _sheet(spec)
    columns = spec.columns or len(spec.panels)
    rows = -(-len(spec.panels) // columns)
    places = [figure.add_subplot(rows, columns, i + 1) for i in range(len(spec.panels))]
    axes = dict(zip(spec.panels, places, strict=True))
    for letter, (name, panel) in zip("abcdefgh", spec.panels.items(), strict=False):
        prefix = f"({letter}) " if len(spec.panels) > 1 else ""
        _set_axes(axes[name], panel, prefix)
    return figure, axes


@context()
def without_data(spec: FigureSpec, words: str) -> Figure:
    """Return the figure in place of one whose data could not be computed: the reason in words."""
    figure = _sheet(spec)
    figure.set_layout_engine("none")
    letters = int(WIDTH_MM[spec.width] / KEY_LETTER_MM)
    figure.text(0.5, 0.5, textwrap.fill(words, letters), ha="center", va="center")
    return figure


def _set_axes(ax: Axes, panel: PanelSpec, prefix: str) -> None:
    near_zero = {"linthresh": LINEAR} if panel.y_scale == "symlog" else {}
    ax.set_yscale(panel.y_scale, **near_zero)
    ax.set(xscale=panel.x_scale, xlim=panel.x_range, ylim=panel.y_range)
    ax.set(xlabel=panel.x_label, ylabel=panel.y_label)
    if prefix or panel.title:
        ax.set_title(f"{prefix}{panel.title}")
    for axis, ticks, steps in (
        (ax.xaxis, panel.x_ticks, panel.x_steps),
        (ax.yaxis, panel.y_ticks, panel.y_steps),
    ):
        if ticks:
            axis.set_ticks(ticks)
        elif steps:
            axis.set_major_locator(LogLocator(subs=steps))
        if axis.get_scale() == "symlog" or (axis.get_scale() == "log" and (ticks or steps)):
            plain_numbers(axis)
    if panel.level is not None:
        ax.axhline(panel.level, color="0.6", linewidth=0.6, zorder=1)


def draw_panel(ax: Axes, table: pd.DataFrame, panel: PanelSpec, name: str) -> list[Line2D]:
    """Draw all series of one panel, each in the manner of its evidence, with a legend.

    Entries of the series of points, for the key below the figure.

    Parameters
    ----------
    ax
        Axes of the panel.
    table
        Tidy figure data, of any number of panels.
    panel
        Words and styles; a series it does not name is drawn under its own name.
    name
        Which panel of the data to draw; points of the user's are laid over all else.
    """
    x, y = table.columns[3], table.columns[4]
    rows = table[table["panel"] == (panel.shows or name)]
    is_point = rows["evidence"].isin(POINTS)
    all_points = table.loc[table["evidence"].isin(POINTS), "series"].unique()
    entries = overlay(ax, rows, panel, list(all_points))
    rows = rows[~is_point]
    calibrated = " (calibrated)" if {"computed", "calibrated"} <= set(table["evidence"]) else ""
    if rows.empty:
        raise ValueError(f"figure data: no rows for panel {name!r}")
    _grow(ax, rows, panel)
    present = list(rows["series"].unique())
    names = [s for s in panel.series if s in present]
    names += [s for s in present if s not in panel.series]
    is_simulated = rows["evidence"] == "virtual experiment"
    rows = pd.concat([rows[~is_simulated], _apart(rows[is_simulated], names, panel.apart)])
    for number, series in enumerate(names):
        spec = panel.series.get(series, SeriesSpec(label=series))
        colour = f"C{number if spec.colour is None else spec.colour}"
        curve = rows[rows["series"] == series]
        is_fitted = "calibrated" in set(curve["evidence"]) and not spec.band
        words = spec.label + (calibrated if is_fitted else "")
        label: str | None = words if spec.beside is None else f"_{words}"
        for evidence, part in curve.groupby("evidence", sort=False):
            if panel.joined and evidence == "virtual experiment":
                line = "dashed" if spec.open else "solid"
                ax.plot(part[x], part[y], color=colour, linestyle=line, **GUIDE)
            _draw_series(ax, part, (x, y), str(evidence), spec, colour, label)
            label = None  # one entry per series; the key below the figure names the evidence
        if spec.beside is not None:
            _name_beside(ax, curve, spec, words, colour)
    if panel.fixed:
        _write_above(ax, rows[rows["evidence"] == "virtual experiment"])
    if panel.legend_place != "above":
        named = _entries([ax])
        ax.legend(named.values(), named.keys(), title=panel.legend, loc=panel.legend_place)
    return entries


def _grow(ax: Axes, rows: pd.DataFrame, panel: PanelSpec) -> None:
    """Move the ends of the axes out where values and bars, but not bands, lie outside."""
    x, y = rows.columns[3], rows.columns[4]
    if not (panel.fixed and panel.shows):  # an enlarged view stays one
        ax.set_xlim(widened(ax.get_xlim(), rows[x].to_numpy(float), log=ax.get_xscale() == "log"))
    if not panel.fixed:
        is_mark = rows["evidence"].map(lambda evidence: EVIDENCE[evidence]["linestyle"] == "none")
        bars = rows.loc[is_mark, ["y_low", "y_high"]].to_numpy(float)
        heights = np.append(rows[y].to_numpy(float), bars)
        ax.set_ylim(widened(ax.get_ylim(), heights, log=ax.get_yscale() == "log"))


def _apart(rows: pd.DataFrame, names: Sequence[str], factor: float) -> pd.DataFrame:
    """Sort marks, moved sideways by series on a logarithmic abscissa, that none hides another."""
    x, present = rows.columns[3], set(rows["series"])
    order = [name for name in names if name in present]
    places = {name: i - 0.5 * (len(order) - 1) for i, name in enumerate(order)}
    moved = rows[x] * factor ** rows["series"].map(places).to_numpy(float)
    return rows.assign(**{x: moved}).sort_values(x, kind="stable")


def _name_beside(ax: Axes, rows: pd.DataFrame, spec: SeriesSpec, words: str, colour: str) -> None:
    """Write the name of a curve beside it, at the declared abscissa or the end next to it."""
    x, y = rows.iloc[:, 3:5].dropna().sort_values(rows.columns[3]).to_numpy(float).T
    at = float(np.clip(spec.beside or 0.0, x[0], x[-1]))
    shift, ha, va = SIDES[spec.side]
    look: dict[str, Any] = {"fontsize": "small", "color": colour, "ha": ha, "va": va}
    anchor = at, float(np.interp(at, x, y))
    ax.annotate(words, anchor, shift, textcoords="offset points", **look)


def overlay(ax: Axes, rows: pd.DataFrame, panel: PanelSpec, names: Sequence[str]) -> list[Line2D]:
    """Draw the user's points of one panel, above all else; the axes grow to show them.

    Entries for the key, one per series: its name as it was written, never as mathematics, and how
    far it is from the curve of that name, if there is one.

    Parameters
    ----------
    ax
        Axes of the panel, their scales as they will be.
    rows
        Figure data of the panel, with digitised or measured series or none.
    panel
        Series of the same name, or beginning with it and a comma, give a series its colour.
    names
        All series of points of the figure, for their marks.
    """
    is_point = rows["evidence"].isin(POINTS)
    points, curves = rows[is_point], rows[~is_point]
    if points.empty:
        return []
    x, y = points.columns[3], points.columns[4]
    if panel.fixed and panel.shows:  # an enlarged view stays one
        points = points[points[x].between(*ax.get_xlim())]
    else:
        _grow(ax, points, replace(panel, fixed=False))
    entries = []
    for series, own in points.groupby("series", sort=False):
        evidence, name = points_parts(str(series))
        colour = _points_colour(name, panel)
        marks = POINT_MARKS[evidence]
        order = names.index(str(series))  # the first lies on top
        look = EVIDENCE[evidence] | {"marker": marks[order % len(marks)], "zorder": 5 - 0.1 * order}
        _draw_series(ax, own, (x, y), evidence, SeriesSpec(label=name), colour, None, look)
        label = f"{series}{_distance(own, curves, name)}".replace("$", r"\$")
        entries.append(Line2D([], [], color=colour, label=label, **look))
    return entries


def _is_named(series: str, name: str) -> bool:
    """Tell whether a series has the name of points, alone or before a comma."""
    return series == name or series.startswith(f"{name}, ")


def _distance(points: pd.DataFrame, curves: pd.DataFrame, name: str) -> str:
    """Return the rms difference of points from the first curve of their name, empty without one.

    The curve is interpolated linearly, and not continued beyond its ends or over a gap.
    """
    at, height = points.iloc[:, 3:5].to_numpy(float).T
    for series, curve in curves.groupby("series", sort=False):
        x, y = curve.iloc[:, 3:5].to_numpy(float).T
        x, y = (x, y) if x[0] < x[-1] else (x[::-1], y[::-1])
        # An upright line, or one that turns back, is no function of x.
        if _is_named(str(series), name) and np.all(np.diff(x) > 0.0):
            difference = height - np.interp(at, x, y, left=np.nan, right=np.nan)
            known = difference[np.isfinite(difference)]
            if known.size:
                return f", rms {np.sqrt(np.mean(np.square(known))):.2g}"
    return ""


def _points_colour(name: str, panel: PanelSpec) -> str:
    for index, (series, spec) in enumerate(panel.series.items()):
        if _is_named(series, name):
            return f"C{index if spec.colour is None else spec.colour}"
    return "black"


def widened(
    limits: tuple[float, float], values: NDArray[np.float64], *, log: bool = False
) -> tuple[float, float]:
    """Return the ends of an axis, moved out where values of a changed configuration lie outside."""
    if log:
        low, high = np.log10(limits)
        low, high = widened((low, high), np.log10(values))
        return float(10.0**low), float(10.0**high)
    low, high = min(np.nanmin(values), limits[0]), max(np.nanmax(values), limits[1])
    margin = 0.05 * (high - low)
    return (
        low - margin if low < limits[0] else limits[0],
        high + margin if high > limits[1] else limits[1],
    )


def _draw_series(
    ax: Axes,
    rows: pd.DataFrame,
    columns: tuple[str, str],
    evidence: str,
    spec: SeriesSpec,
    colour: str,
    label: str | None,
    mark: Mapping[str, Any] | None = None,
) -> None:
    x, y = (rows[column].to_numpy() for column in columns)
    look = {"zorder": 3, **(mark or EVIDENCE[evidence]), "color": colour}
    is_line = look["linestyle"] != "none"
    if is_line:
        look["linestyle"] = LINES[spec.line]
    elif spec.open and evidence not in POINTS:
        look["markerfacecolor"] = "white"
    elif evidence == "virtual experiment":
        look["markerfacecolor"] = half_tone(colour)
    if look.get("marker") == MARKS["circle"]:
        look["marker"] = MARKS[spec.mark]
    bounds = rows[["y_low", "y_high"]].to_numpy(float).T
    error = None if np.isnan(bounds).all() else np.abs(bounds - y)
    if is_line and error is not None:
        _draw_band(ax, x, bounds, spec, colour, label if spec.band else None)
        if spec.band:
            return
        error = None
    # A mark that lies on the frame is shown whole; one beyond it, and the bars, end at the frame.
    low, high = ax.get_ylim()
    marks = y if is_line else np.where((y < low) | (y > high), np.nan, y)
    drawn = ax.errorbar(x, marks, yerr=error, label=label, clip_on=is_line, **look)
    for bar in (*drawn.lines[1], *drawn.lines[2]):
        bar.set_clip_on(True)


def half_tone(colour: str) -> tuple[float, float, float]:
    """Return the colour in which marks of simulated data are filled: opaque, and light."""
    red, green, blue = (1.0 - LIGHT * (1.0 - part) for part in to_rgb(colour))
    return red, green, blue


def _draw_band(
    ax: Axes,
    x: NDArray[np.float64],
    bounds: NDArray[np.float64],
    spec: SeriesSpec,
    colour: str,
    label: str | None,
) -> None:
    """Draw the bounds of a curve as a band: tinted, hatched if its line is dashed, or outlined.

    Two tints would mix to a third where bands overlap; a hatched one lets the other be seen. A
    dotted band is its outline alone, and hides nothing.
    """
    look: dict[str, Any] = {"color": colour, "zorder": 1}
    if is_filled := spec.line != "dotted":
        fill = TINT if spec.line == "solid" else HATCH
        low, high = bounds
        ax.fill_between(x, low, high, linewidth=0, label=label, **look, **fill)
    for end, words in zip(bounds, (None if is_filled else label, None), strict=True):
        ax.plot(x, end, linewidth=0.6, linestyle=LINES[spec.line], label=words, **look)


def _write_above(ax: Axes, rows: pd.DataFrame) -> None:
    """Write values that lie above an axis at its upper edge, at their abscissae."""
    x, y = rows.columns[3:5]
    for at, points in rows[rows[y] > ax.get_ylim()[1]].groupby(x):
        words = ", ".join(f"{value:.1f}" for value in sorted(points[y]))
        ax.annotate(
            f"{words} ↑",
            (float(str(at)), 0.97),
            xycoords=ax.get_xaxis_transform(),
            rotation=90,
            ha="center",
            va="top",
            fontsize="small",
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.8},
        )


def evidence_key(
    figure: Figure,
    evidence: Iterable[str],
    entries: Iterable[Line2D] = (),
    loc: Literal["outside lower center", "outside upper center"] = "outside lower center",
    labels: Mapping[str, str] | None = None,
) -> None:
    """Name the evidence of marks and lines below the figure.

    Entries of series of points follow, each name and colour once; they name their evidence
    themselves. ``loc`` may be another place, and ``labels`` replace words, as of what was printed
    elsewhere than in the article.
    """
    known = set(evidence)
    lines = {} if "computed" in known else {"calibrated": "computed, calibrated"}
    words = {**lines, **EVIDENCE_LABEL, **(labels or {})}
    present = [name for name in words if name in known]
    handles = [
        Line2D([], [], color="black", label=words[name], **EVIDENCE[name]) for name in present
    ]
    handles += {(str(e.get_label()), str(e.get_color())): e for e in entries}.values()
    columns = _columns(figure, [str(handle.get_label()) for handle in handles])
    figure.legend(handles=handles, loc=loc, ncols=columns)


def line_figure(tables: Tables, spec: FigureSpec) -> tuple[Figure, dict[str, Axes]]:
    """Draw every panel of a figure from the tables that have it, legends and key of evidence.

    The figure and its axes by panel, for what a figure adds of its own.
    """
    figure, axes = new_figure(spec)
    entries: list[Line2D] = []
    for name, panel in spec.panels.items():
        parts = [t for t in tables.values() if (panel.shows or name) in t["panel"].unique()]
        table = pd.concat(parts or list(tables.values()), ignore_index=True)
        entries += draw_panel(axes[name], table, panel, name)
    if above := [axes[name] for name, p in spec.panels.items() if p.legend_place == "above"]:
        legend_above(figure, above)
    evidence = pd.concat([table["evidence"] for table in tables.values()])
    evidence_key(figure, evidence, entries, labels=spec.evidence_labels)
    return figure, axes


def _tick(value: float) -> str:
    """Label of a tick of a logarithmic axis: far powers of ten as powers."""
    exponent = round(math.log10(value)) if value > 0.0 else 0
    if abs(exponent) > 3 and math.isclose(value, 10.0**exponent):
        return f"$10^{{{exponent}}}$"
    return f"{value:g}".replace("-", "−")


def plain_numbers(*axes: Axis) -> None:
    """Write the major ticks of logarithmic axes as plain numbers, and nothing at the minor ones."""
    for axis in axes:
        axis.set_major_formatter(FuncFormatter(lambda value, _: _tick(value)))
        axis.set_minor_formatter(NullFormatter())


def _entries(axes: Iterable[Axes]) -> dict[str, Any]:
    """Return the entries of a legend by label: a curve and marks of one label in one entry."""
    entries: dict[str, dict[object, Any]] = {}
    for ax in axes:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            line = handle[0] if isinstance(handle, Container) else handle
            is_line = isinstance(line, Line2D) and line.get_linestyle() != "None"
            entries.setdefault(label, {}).setdefault(is_line, handle)
    return {
        label: tuple(parts.values()) if len(parts) > 1 else next(iter(parts.values()))
        for label, parts in entries.items()
    }


def legend_above(figure: Figure, axes: Iterable[Axes], **look: Any) -> None:
    """Name every line and mark of some axes once, above all panels or where ``loc`` says."""
    entries = _entries(axes)
    look = {"loc": "outside upper center", "ncols": _columns(figure, entries), **look}
    figure.legend(entries.values(), entries.keys(), **look)


def _columns(figure: Figure, labels: Iterable[str]) -> int:
    """Return how many columns of entries find room beside each other."""
    letters = [sum(letter not in "$\\{}_^" for letter in label) for label in labels]
    width, most = figure.get_figwidth() * MM_PER_INCH, len(letters)
    for number in range(most, 1, -1):
        longest = [column.max() for column in np.array_split(letters, number)]
        if number * KEY_MARK_MM + KEY_LETTER_MM * sum(longest) < width:
            return number
    return 1


def save(figure: Figure, *paths: Path | str) -> None:
    """Save a figure in the format of each suffix; equal figures give equal bytes.

    Each file is written in one step; neither dates nor program versions go into it. The layout is
    made once, with the text as wide as in an SVG, so that all files agree.
    """
    with context():
        if engine := figure.get_layout_engine():
            FigureCanvasSVG(figure)
            engine.execute(figure)
        with rc_context({"figure.constrained_layout.use": False}):
            figure.set_layout_engine(None)
            for path in map(Path, paths):
                _save(figure, path)


def _save(figure: Figure, path: Path) -> None:
    buffer = io.BytesIO()
    kind = path.suffix.removeprefix(".")
    options: dict[str, Any] = {"pil_kwargs": PACKED} if kind == "png" else {}
    figure.savefig(buffer, format=kind, metadata=dict.fromkeys(UNDATED[kind]), **options)
    write_file(path, buffer.getvalue())
