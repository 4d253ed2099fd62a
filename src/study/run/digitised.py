"""Points of the article's figures, digitised or measured, dropped in as one file per figure.

The form of a file stands in ``config/digitised/README.md``.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import AfterValidator, Field, ValidationError

from microimpact.core.nearest import nearest
from study.declared.parameters import Finite, build, explain
from study.figures.registry import FigureSpec
from study.tables import points_series

# Loaded where there are points.
if TYPE_CHECKING:
    import pandas as pd

COLUMNS = ("series", "x", "y", "y_low", "y_high")
CANONICAL = ("panel", *COLUMNS)
# In ends of the axis: a point beyond has another unit, as percent.
FAR = 20.0
# Problems of one file that are reported.
MOST_LINES = 20

_ARTICLE_FIGURE = re.compile(r"fig\d\d")


class DigitisedError(ValueError):
    """Files of digitised points with problems: one line each."""


def _printable(text: str) -> str:
    if not text.isprintable() or text != text.strip():
        raise ValueError(f"{text!r} must be printable characters without space around them")
    return text


# More would not fit below the narrowest figure.
SeriesName = Annotated[str, Field(min_length=1, max_length=48), AfterValidator(_printable)]
Words = Annotated[str, Field(min_length=1), AfterValidator(_printable)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Header:
    """The comments above the points."""

    source: Words
    licence: Words
    digitised_by: Words | None = None
    measured_by: Words | None = None

    def __post_init__(self) -> None:
        """Ask for one maker."""
        if (self.digitised_by is None) == (self.measured_by is None):
            raise ValueError("give either digitised_by or measured_by")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Digitised:
    """Digitised points of one figure."""

    figure: str
    path: str
    header: Header
    evidence: str  # ``digitised`` or ``measured``
    # Columns `CANONICAL`: the panel whose data are drawn there, the series as `points_series` calls
    # it, x and y in the units of the figure, the ends of the bar, NaN where there is none.
    table: pd.DataFrame


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """One point, with both ends of its bar or none."""

    panel: str
    series: SeriesName
    x: Finite
    y: Finite
    y_low: Finite | None
    y_high: Finite | None

    def __post_init__(self) -> None:
        """Refuse half a bar, and one without the point."""
        if (self.y_low is None) != (self.y_high is None):
            raise ValueError("y_low and y_high must be given both or neither")
        if self.y_low is not None and self.y_low > self.y:
            raise ValueError(f"y_low: {self.y_low:g} must not exceed y, {self.y:g}")
        if self.y_high is not None and self.y_high < self.y:
            raise ValueError(f"y_high: {self.y_high:g} must not be below y, {self.y:g}")


def read_folder(folder: str, figures: Mapping[str, FigureSpec]) -> dict[str, Digitised]:
    """Read every file of digitised points in a folder, by figure.

    Its README and hidden or backup files do not count. Raises DigitisedError with one line per
    problem of every file; also for a file that belongs to no plot of the article.
    """
    if not Path(folder).is_dir():
        raise DigitisedError(f"digitised: {folder!r} must be a folder")
    plots = {
        f"{name}.csv": spec
        for name, spec in figures.items()
        if _ARTICLE_FIGURE.fullmatch(name) and not spec.is_schematic
    }
    points, problems = {}, []
    for file in sorted(Path(folder).iterdir()):
        if file.name == "README.md" or file.name.startswith(".") or file.name.endswith("~"):
            continue
        try:
            if file.name not in plots:
                near = nearest(file.name, plots)
                raise DigitisedError(f"{file}: must be named for a plot of the article{near}")
            points[file.stem] = read_points(str(file), plots[file.name])
        except DigitisedError as error:
            problems.append(str(error))
        except OSError as error:
            problems.append(f"{file}: {error.strerror}")
    if problems:
        raise DigitisedError("\n".join(problems))
    return points


def read_points(path: str, spec: FigureSpec) -> Digitised:
    """Read the digitised points of one figure.

    Raises DigitisedError with file and line of its problems, of many the first; OSError if the file
    cannot be read.
    """
    try:
        # Universal line ends; comments become blank lines, so that the reader counts all.
        lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise DigitisedError(f"{path}: must be UTF-8 text, byte {error.start} is not") from None
    comments = [line for line in lines if line.startswith("#")]
    rows = csv.reader(["" if line.startswith("#") else line for line in lines], strict=True)
    problems: list[str] = []
    header, points = _header(comments, problems), _points(rows, spec, problems)
    if header is None or problems:
        shown = [f"{path}, {problem}" for problem in problems[:MOST_LINES]]
        raise DigitisedError("\n".join(shown))
    import pandas as pd

    evidence = "digitised" if header.digitised_by else "measured"
    table = pd.DataFrame(list(map(asdict, points)), columns=list(CANONICAL))
    table = table.astype(dict.fromkeys(COLUMNS[1:], float))
    table["series"] = [points_series(evidence, name) for name in table["series"]]
    return Digitised(figure=spec.name, path=path, header=header, evidence=evidence, table=table)


def _header(comments: list[str], problems: list[str]) -> Header | None:
    """Return the header in comments of the form ``# key: text``."""
    pairs = [line.lstrip("# ").partition(":") for line in comments]
    values = {key.strip(): text.strip() for key, _, text in pairs}
    if len(values) < len(pairs):
        problems.append("header: a key is given twice")
    try:
        return build(Header, values)
    except ValidationError as error:
        problems += explain(error, Header, "header")
        return None


def _points(rows: Any, spec: FigureSpec, problems: list[str]) -> list[Point]:
    """Return the points below the column names."""
    lines: dict[Point, int] = {}
    try:
        names: list[str] = next(filter(None, rows), [])
        if tuple(names) != COLUMNS:
            raise csv.Error(f"column names {','.join(names)!r} must be {','.join(COLUMNS)}")
        for fields in filter(None, rows):
            try:
                point = _point(fields, spec)
                if point in lines:
                    raise ValueError(f"series: repeats the point of line {lines[point]}")
                lines[point] = rows.line_num
            except ValidationError as error:
                faults = [fault.removeprefix(": ") for fault in explain(error, Point, "")]
                problems += [f"line {rows.line_num}, {fault}" for fault in faults]
            except ValueError as error:
                problems.append(f"line {rows.line_num}, {error}")
    except csv.Error as error:
        problems.append(f"line {rows.line_num}: {error}")
    if not lines and not problems:
        problems.append(f"line {rows.line_num}: at least one point must follow")
    return list(lines)


def _point(fields: list[str], spec: FigureSpec) -> Point:
    """Return the point in the fields of a line."""
    if len(fields) != len(COLUMNS):
        words = f"must have {len(COLUMNS)} fields, has {len(fields)}"
        raise ValueError(f"series: {words}; a name with a comma must stand in double quotes")
    panel, name = _panel_and_name(fields[0], spec)
    numbers = dict(zip(COLUMNS[1:], map(_number, fields[1:]), strict=True))
    shown = spec.panels[panel].shows or panel
    point = build(Point, {"panel": shown, "series": name, **numbers})
    for line in _off_the_axes(point, panel, spec):
        raise ValueError(line)
    return point


def _number(text: str) -> float | str | None:
    """Return a number, None for an empty text, and any other text unchanged."""
    try:
        return float(text) if text.strip() else None
    except ValueError:
        return text


def _panel_and_name(series: str, spec: FigureSpec) -> tuple[str, str]:
    """Return the panel and the name in the text of a series."""
    panel, colon, name = series.partition(": ")
    if colon and panel in spec.panels and len(spec.panels) > 1:
        return panel, name
    # Panels may be views of the same data.
    if len({axes.shows or own for own, axes in spec.panels.items()}) == 1:
        return next(iter(spec.panels)), series
    known = ", ".join(spec.panels)
    near = nearest(panel, spec.panels)
    raise ValueError(f"series: {series!r} must be 'panel: name', panel one of {known}{near}")


def _off_the_axes(point: Point, panel: str, spec: FigureSpec) -> Iterator[str]:
    """Yield a line for a coordinate that its axis cannot show, or that has another unit.

    The logarithmic axes of the registry begin above zero.
    """
    axes = spec.panels[panel]
    for column, value, ends in (("x", point.x, axes.x_range), ("y", point.y, axes.y_range)):
        if ends[0] > 0.0 >= value:
            yield f"{column}: {value:g} must be positive, as the axis of {panel!r} is"
        elif abs(value) > FAR * max(map(abs, ends)):
            shown = f"{ends[0]:g} to {ends[1]:g}"
            yield f"{column}: {value:g} is far off the axis of {panel!r}, {shown}"


def as_rows(points: Mapping[str, Digitised], figures: Iterable[str]) -> dict[str, str]:
    """Return the points of some figures as a study is given declared rows.

    ``digitised``: CSV text with the columns figure, panel, series, x, y, y_low, y_high; nothing if
    there are no points.
    """
    tables = [points[name].table.assign(figure=name) for name in figures if name in points]
    if not tables:
        return {}
    import pandas as pd

    table = pd.concat(tables)[["figure", *CANONICAL]]
    return {"digitised": table.to_csv(index=False, lineterminator="\n")}


def overlaid(
    tables: Mapping[str, pd.DataFrame], spec: FigureSpec, points: Digitised
) -> dict[str, pd.DataFrame]:
    """Return the figure data with the points as further rows of the first table."""
    import pandas as pd

    name = spec.data[0]
    rows = points.table.assign(evidence=points.evidence)
    rows = rows[["panel", "series", "evidence", *COLUMNS[1:]]]
    rows.columns = tables[name].columns
    return {**tables, name: pd.concat([tables[name], rows], ignore_index=True)}
