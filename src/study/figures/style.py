"""One look for all figures, and one way to save them that gives the same bytes each time."""

from __future__ import annotations

import io
import math
import re
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any, Literal
from xml.sax.saxutils import escape

import numpy as np
import pandas as pd
from cycler import cycler
from matplotlib import rc_context, rcParams
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
from study.declared.documents import filled
from study.figures.declaration import Figure as Words
from study.figures.declaration import Series
from study.tables import POINTS, Tables, points_parts

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
    "left": ((-5.0, 0.0), "right", "center"),
}

# In ends of the axis: a point beyond has another unit.
FAR = 20.0
# Part of an axis in which no word fits.
NARROW = 0.04
# The series of both ends of the speeds at which particles piled up.
PILE_UP = "printed pile-up"

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
    "assumed": {"linestyle": "none", "marker": "+", "markersize": 7.0, "markeredgewidth": 1.2},
}
EVIDENCE_LABEL = {
    "printed": "printed in the article",
    "virtual experiment": "virtual experiment",
    "assumed": "assumed",
}


@contextmanager
def context(palette: Sequence[str] = ()) -> Iterator[None]:
    """Return the context in which figures are drawn, saved and measured.

    It is the same whatever the user's own settings of matplotlib are. The colours of series are
    those of a palette, if there is one: they are asked for by number until a figure is saved.
    """
    with rc_context(fname=STYLE_FILE):
        if palette:
            rcParams["axes.prop_cycle"] = cycler(color=palette)
        yield


def _empty(words: Words) -> Figure:
    """Return an empty figure of the size declared."""
    return Figure(figsize=(WIDTH_MM[words.width] / MM_PER_INCH, words.height_mm / MM_PER_INCH))


def without_data(words: Words, reason: str) -> Figure:
    """Return the figure in place of one whose data could not be computed: the reason in words."""
    figure = _empty(words)
    figure.set_layout_engine("none")
    letters = int(WIDTH_MM[words.width] / KEY_LETTER_MM)
    figure.text(0.5, 0.5, textwrap.fill(reason, letters), ha="center", va="center")
    return figure


class Sheet:
    """A figure that is being drawn: its panels, its tables, its words filled in.

    Parameters
    ----------
    words
        What is declared of the figure.
    tables
        Figure data by name, with the user's points as further rows, if there are any.
    values, pairs
        Parameters of the analysis and materials of its cases, for the words, see
        `documents.filled`.
    """

    def __init__(
        self,
        words: Words,
        tables: Tables,
        values: Mapping[str, Any],
        pairs: Mapping[str, tuple[str, str]],
    ) -> None:
        self.declared = words
        self.tables = tables
        self._values, self._pairs = values, pairs
        self._points: list[Line2D] = []  # Entries of the user's points for the key
        self._drawn: list[Axes] = []
        self._taken: list[str] = []
        self.figure = _empty(words)

    def fill(self, text: str) -> str:
        """Return a text with parameters of the analysis in it, the rate exponent as a symbol."""
        words: str = filled(text, self._values, self.declared.name, self._pairs)
        return re.sub(r"(?<!\$)\bn = ", "$n$ = ", words)

    def panels(self, titles: Mapping[str, str] | None = None, **look: Any) -> list[Axes]:
        """Add the panels in rows of `columns`, with their titles, and return their axes.

        Parameters
        ----------
        titles
            By panel, if they are others than those declared.
        look
            Properties that all of them have, as for `Axes.set`.
        """
        titles = titles or self.declared.panels
        columns = self.declared.columns or len(titles)
        rows = -(-len(titles) // columns)
        for number, (name, title) in enumerate(titles.items()):
            ax = self.figure.add_subplot(rows, columns, number + 1, label=name)
            ax.set(**look)
            prefix = f"({'abcdefgh'[number]}) " if len(titles) > 1 else ""
            if prefix or title:
                ax.set_title(prefix + self.fill(title))
        return self.figure.axes

    def take(self, ax: Axes, series: str) -> pd.DataFrame:
        """Return the rows of a series of a panel that the figure draws by itself.

        With them are those whose names continue it after a blank. `draw` leaves them out from here
        on, and so does the key of evidence.
        """
        self._taken.append(series)
        panel = str(ax.get_label())
        rows = self._table(panel)
        return rows[(rows["panel"] == panel) & _is(series, rows)]

    def _table(self, panel: str) -> pd.DataFrame:
        """Return the tables that have a panel as one; all tables, if none has it."""
        parts = [t for t in self.tables.values() if panel in t["panel"].unique()]
        return pd.concat(parts or list(self.tables.values()), ignore_index=True)

    def _without_taken(self, table: pd.DataFrame) -> pd.DataFrame:
        for series in self._taken:
            table = table[~_is(series, table)]
        return table

    def draw(
        self,
        ax: Axes,
        series: Mapping[str, Series],
        *,
        fixed: bool = False,
        joined: bool = False,
        apart: float = 1.0,
    ) -> None:
        """Draw all series of one panel, each in the manner of its evidence.

        Axes grow where data lie outside.

        Parameters
        ----------
        ax
            Axes of the panel, their scales and ends set.
        series
            Words and looks by series, in the order of the legend; one that is not among them is
            drawn under its own name, and one that the panel does not have is passed over.
        fixed
            The upright axis does not grow: simulated values above it are written at its edge.
        joined
            A thin line guides the eye along simulated marks.
        apart
            Marks of one abscissa stand apart by this factor.
        """
        series = {name: replace(each, label=self.fill(each.label)) for name, each in series.items()}
        name = str(ax.get_label())
        panel = self.declared.views.get(name, name)
        table = self._without_taken(self._table(panel))
        x, y = table.columns[3], table.columns[4]
        rows = table[table["panel"] == panel]
        is_point = rows["evidence"].isin(POINTS)
        all_points = table.loc[table["evidence"].isin(POINTS), "series"].unique()
        enlarged = fixed and name in self.declared.views
        points, rows = rows[is_point], rows[~is_point]
        self.overlay(ax, points, series, list(all_points), rows, enlarged=enlarged)
        if rows.empty:
            raise ValueError(f"figure data: no rows for panel {panel!r}")
        _grow(ax, rows, upright=not fixed, along=not enlarged)
        present = list(rows["series"].unique())
        names = [s for s in series if s in present]
        names += [s for s in present if s not in series]
        is_simulated = rows["evidence"] == "virtual experiment"
        rows = pd.concat([rows[~is_simulated], _apart(rows[is_simulated], names, apart)])
        looks = _with_colours({s: series.get(s, Series(self.fill(s))) for s in names})
        colours = {name: f"C{spec.colour}" for name, spec in looks.items()}
        for each, spec in looks.items():
            colour = colours[each]
            curve = rows[rows["series"] == each]
            label: str | None = spec.label if spec.beside is None else f"_{spec.label}"
            for evidence, part in curve.groupby("evidence", sort=False):
                if joined and evidence == "virtual experiment":
                    line = "dashed" if spec.open else "solid"
                    ax.plot(part[x], part[y], color=colour, linestyle=line, **GUIDE)
                _draw_series(ax, part, (x, y), str(evidence), spec, colour, label)
                label = None  # one entry per series; the key below the figure names the evidence
            if spec.beside is not None:
                _name_beside(ax, curve, spec, colour)
        if fixed:
            _write_above(ax, rows[rows["evidence"] == "virtual experiment"], colours)
        self._drawn.append(ax)

    def overlay(
        self,
        ax: Axes,
        points: pd.DataFrame,
        series: Mapping[str, Series],
        names: Sequence[str],
        curves: pd.DataFrame | None = None,
        *,
        enlarged: bool = False,
    ) -> None:
        """Draw the user's points of one panel, above all else; the axes grow to show them.

        Parameters
        ----------
        ax
            Axes of the panel, their scales as they will be.
        points
            Figure data of digitised or measured series alone; may be empty.
        series
            Those of the same name, or beginning with it and a comma, give points their colour.
        names
            All series of points of the figure, for their marks.
        curves
            Figure data of the panel: the key tells how far points are from the curve of their name.
        enlarged
            Whether the axes stay as they are: an enlarged view.
        """
        if points.empty:
            return
        x, y = points.columns[3], points.columns[4]
        for axis, values in ((ax.xaxis, points[x]), (ax.yaxis, points[y])):
            _require_on(axis, values, f"points of {self.declared.name}")
        if enlarged:
            points = points[points[x].between(*ax.get_xlim())]
        else:
            _grow(ax, points)
        for name_in_data, rows in points.groupby("series", sort=False):
            evidence, name = points_parts(str(name_in_data))
            colour = _points_colour(name, series)
            marks = POINT_MARKS[evidence]
            order = names.index(str(name_in_data))  # the first lies on top
            look = EVIDENCE[evidence] | {"marker": marks[order % len(marks)]}
            look["zorder"] = 5 - 0.1 * order
            _draw_series(ax, rows, (x, y), evidence, Series(name), colour, None, look)
            far = "" if curves is None else _distance(rows, curves, name)
            label = f"{name_in_data}{far}".replace("$", r"\$")  # as it was written
            self._points.append(Line2D([], [], color=colour, label=label, **look))

    def level(self, ax: Axes, height: float) -> None:
        """Draw a thin line across a panel."""
        ax.axhline(height, color="0.6", linewidth=0.6, zorder=1)

    def ticks(self, axis: Axis, places: Sequence[float], *, decades: bool = False) -> None:
        """Put plain numbers on a logarithmic axis: at some places, or in all decades at these."""
        if decades:
            axis.set_major_locator(LogLocator(subs=places))
        else:
            axis.set_ticks(places)
        plain_numbers(axis)

    def legend(self, ax: Axes, loc: str, title: str = "") -> None:
        """Name the lines and marks of one panel inside it."""
        named = _entries([ax])
        look: dict[str, Any] = {"title": self.fill(title), "loc": loc}
        ax.legend(named.values(), named.keys(), **look)

    def captured(self, ax: Axes, series: str) -> None:
        """Shade a panel from zero to the last abscissa of a series: the sphere does not rebound."""
        limit = self.take(ax, series).iloc[:, 3].max()
        if not limit > 0.0:
            return
        ax.axvspan(0.0, limit, color="0.93", linewidth=0, zorder=0)
        if limit > NARROW * ax.get_xlim()[1]:
            look: dict[str, Any] = {"rotation": 90, "ha": "center", "va": "center"}
            ax.text(limit / 2, 0.5, "captured", transform=ax.get_xaxis_transform(), **look)

    def piled_up(self, ax: Axes) -> None:
        """Shade the speeds at which the article saw particles pile up: the series `PILE_UP`."""
        speeds = self.take(ax, PILE_UP).iloc[:, 3]
        if speeds.empty:
            return
        low, high = speeds.min(), speeds.max()
        ax.axvspan(low, high, color="0.9", linewidth=0, zorder=0)
        look: dict[str, Any] = {"fontsize": "small", "ha": "center", "va": "bottom"}
        across = ax.get_xaxis_transform()
        ax.text((low + high) / 2, 1.01, "piles up (article)", transform=across, **look)

    def keys(self) -> None:
        """Name lines and marks above all panels that have no legend; the evidence below."""
        if above := [ax for ax in self._drawn if ax.get_legend() is None]:
            legend_above(self.figure, above)
        self.evidence_key()

    def evidence_key(
        self,
        entries: Iterable[Line2D] = (),
        loc: Literal["outside lower center", "outside upper center"] = "outside lower center",
    ) -> None:
        """Name the evidence of marks and lines below the figure, then further entries.

        Where all marks are of one class there is nothing to tell apart, and no key. Entries of
        series of points name their evidence themselves, each name and colour once.
        """
        table = self._without_taken(pd.concat(self.tables.values(), ignore_index=True))
        known = set(table["evidence"])
        lines = {} if "computed" in known else {"calibrated": "computed, calibrated"}
        labels = {name: self.fill(text) for name, text in self.declared.evidence_labels.items()}
        handles = [
            Line2D([], [], color="black", label=words, **EVIDENCE[name])
            for name, words in (lines | EVIDENCE_LABEL | labels).items()
            if name in known
        ]
        entries = [*self._points, *entries]
        if len(handles) < 2 and not entries:
            return
        handles += {(str(e.get_label()), str(e.get_color())): e for e in entries}.values()
        columns = _columns(self.figure, [str(handle.get_label()) for handle in handles])
        self.figure.legend(handles=handles, loc=loc, ncols=columns)


def _require_on(axis: Axis, values: pd.Series[float], points: str) -> None:
    """Refuse points that an axis cannot show, or that have another unit, as percent."""
    ends = axis.get_view_interval()
    for value in values:
        if axis.get_scale() == "log" and value <= 0.0:
            raise ValueError(f"{points}: {value:g} must be positive, as its axis is")
        if abs(value) > FAR * max(map(abs, ends)):
            shown = f"{min(ends):g} to {max(ends):g}"
            raise ValueError(f"{points}: {value:g} is far off the axis, {shown}")


def _is(series: str, table: pd.DataFrame) -> pd.Series[bool]:
    """Return which rows are of a series, or of those whose names continue it after a blank."""
    names = table["series"].astype(str)
    return (names == series) | names.str.startswith(f"{series} ")


def _grow(ax: Axes, rows: pd.DataFrame, *, upright: bool = True, along: bool = True) -> None:
    """Move the ends of the axes out where values and bars, but not bands, lie outside."""
    x, y = rows.columns[3], rows.columns[4]
    if along:
        ax.set_xlim(widened(ax.get_xlim(), rows[x].to_numpy(float), log=ax.get_xscale() == "log"))
    if upright:
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


def _with_colours(looks: Mapping[str, Series]) -> dict[str, Series]:
    """Return the series with a colour each; those without one take colours that no other has."""
    used = {spec.colour for spec in looks.values()}
    free = (number for number in count() if number not in used)
    return {
        name: spec if spec.colour is not None else replace(spec, colour=next(free))
        for name, spec in looks.items()
    }


def _name_beside(ax: Axes, rows: pd.DataFrame, spec: Series, colour: str) -> None:
    """Write the name of a curve beside it, at the declared abscissa or the end next to it."""
    x, y = rows.iloc[:, 3:5].dropna().sort_values(rows.columns[3]).to_numpy(float).T
    at = float(np.clip(spec.beside or 0.0, x[0], x[-1]))
    shift, ha, va = SIDES[spec.side]
    look: dict[str, Any] = {"fontsize": "small", "color": colour, "ha": ha, "va": va}
    anchor = at, float(np.interp(at, x, y))
    ax.annotate(spec.label, anchor, shift, textcoords="offset points", **look)


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


def _points_colour(name: str, looks: Mapping[str, Series]) -> str:
    for index, (series, spec) in enumerate(looks.items()):
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
    spec: Series,
    colour: str,
    label: str | None,
    mark: Mapping[str, Any] | None = None,
) -> None:
    x, y = (rows[column].to_numpy() for column in columns)
    look = {"zorder": 3, **(mark or EVIDENCE[evidence]), "color": colour}
    is_line = look["linestyle"] != "none"
    if is_line:
        look["linestyle"] = spec.line
        if spec.thin:
            look["linewidth"] = GUIDE["linewidth"]
    elif evidence == "virtual experiment":
        # An open mark lets one below it be seen.
        look["markerfacecolor"] = "none" if spec.open else half_tone(colour)
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
    spec: Series,
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
        ax.plot(x, end, linewidth=0.6, linestyle=spec.line, label=words, **look)


def _write_above(ax: Axes, rows: pd.DataFrame, colours: Mapping[str, str]) -> None:
    """Write values that lie above an axis at its upper edge, in the colours of their series."""
    x, y = rows.columns[3:5]
    for name, points in rows[rows[y] > ax.get_ylim()[1]].groupby("series"):
        for at, value in zip(points[x], points[y], strict=True):
            ax.annotate(
                f"{value:.1f} ↑",
                (at, 0.97),
                xycoords=ax.get_xaxis_transform(),
                rotation=90,
                ha="center",
                va="top",
                fontsize="small",
                color=colours[str(name)],
                bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.8},
            )


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


def save(figure: Figure, *paths: Path | str, title: str = "", description: str = "") -> None:
    """Save a figure, in a `context`, in the format of each suffix; equal figures give equal bytes.

    Its title goes into each file, the description into an SVG, for those who search or cannot see
    it. Each file is written in one step; neither dates nor program versions go into it. The layout
    is made once, with the text as wide as in an SVG, so that all files agree.
    """
    if engine := figure.get_layout_engine():
        FigureCanvasSVG(figure)
        engine.execute(figure)
    with rc_context({"figure.constrained_layout.use": False}):
        figure.set_layout_engine(None)
        for path in map(Path, paths):
            _save(figure, path, title, description)


def _save(figure: Figure, path: Path, title: str, description: str) -> None:
    buffer = io.BytesIO()
    kind = path.suffix.removeprefix(".")
    options: dict[str, Any] = {"pil_kwargs": PACKED} if kind == "png" else {}
    metadata = dict.fromkeys(UNDATED[kind]) | ({"Title": title} if title else {})
    figure.savefig(buffer, format=kind, metadata=metadata, **options)
    content = buffer.getvalue()
    if kind == "svg" and description:
        words = f"</title>\n <desc>{escape(description)}</desc>"
        content = content.replace(b"</title>", words.encode(), 1)
    write_file(path, content)
