"""Points of the article's figures, digitised or measured, dropped in as one file per figure.

The form of a file stands in ``config/digitised/README.md``. Every problem is one line with the
file, the line and the column.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from microimpact.core.nearest import nearest
from microimpact.core.tables import TableError, check_columns, figure_columns, points_series
from microimpact.figures.registry import FigureSpec, PanelSpec

# Loaded where there are points.
if TYPE_CHECKING:
    import pandas as pd

HEADER_KEYS = ("source", "licence", "digitised_by", "measured_by")
# Who read points off the article, or measured them: one of both, which gives the evidence.
ORIGINS = {"digitised_by": "digitised", "measured_by": "measured"}
COLUMNS = ("series", "x", "y", "y_low", "y_high")
CANONICAL = ("panel", *COLUMNS)
# In ends of the axis: a point beyond has another unit, as percent.
FAR = 20.0
# More would not fit below the narrowest figure.
LONGEST_NAME = 48
# Of the problems of one file, so many are told.
TOLD = 20

_COMMENT = re.compile(r"#\s*(?P<key>[^:]*?)\s*:\s*(?P<text>.*?)\s*")
_LINE_END = re.compile(r"\r\n|\r|\n")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_ARTICLE_FIGURE = re.compile(r"fig\d\d")

Numbered = tuple[int, str]
Row = tuple[str, str, float, float, float | None, float | None]


class DigitisedError(ValueError):
    """Files of digitised points with problems: one line each."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Digitised:
    """Digitised points of one figure."""

    figure: str
    path: str
    source: str
    licence: str
    by: str  # Who read them off, or measured them
    evidence: str  # ``digitised`` or ``measured``
    # Columns `CANONICAL`: the panel whose data are drawn there, the series as `points_series` calls
    # it, x and y in the units of the figure, the ends of the bar, NaN where there is none.
    table: pd.DataFrame


def read_folder(folder: str, figures: Mapping[str, FigureSpec]) -> dict[str, Digitised]:
    """Read every file of digitised points in a folder.

    `folder`: holds ``figNN.csv`` files; its README and hidden or backup files do not count. Raises
    DigitisedError, naming every problem of every file, one line each; also for a file that belongs
    to no figure, or to a schematic.
    """
    if not Path(folder).is_dir():
        raise DigitisedError(f"digitised: {folder!r} must be a folder")
    found, problems = {}, []
    for file in sorted(Path(folder).iterdir()):
        if file.name == "README.md" or file.name.startswith(".") or file.name.endswith("~"):
            continue
        try:
            spec = _figure_of(file, figures)
            found[spec.name] = read_points(str(file), spec)
        except DigitisedError as error:
            problems.append(str(error))
        except OSError as error:
            problems.append(f"{file}: {error.strerror}")
    if problems:
        raise DigitisedError("\n".join(problems))
    return found


def _figure_of(file: Path, figures: Mapping[str, FigureSpec]) -> FigureSpec:
    """Return the figure that a file is named for."""
    plots = [
        name
        for name, spec in figures.items()
        if _ARTICLE_FIGURE.fullmatch(name) and not spec.is_schematic
    ]
    name = file.stem
    if file.suffix != ".csv":
        raise DigitisedError(f"{file}: must be named figNN.csv for a figure{nearest(name, plots)}")
    if name in plots:
        return figures[name]
    if name not in figures:
        raise DigitisedError(f"{file}: no figure {name!r}{nearest(name, plots)}")
    kind = "a schematic" if figures[name].is_schematic else "no figure of the article"
    raise DigitisedError(f"{file}: {name!r} is {kind} and takes no digitised points")


def read_points(path: str, spec: FigureSpec) -> Digitised:
    """Read the digitised points of one figure.

    `path`: CSV file in UTF-8, lines ending in any way. Raises DigitisedError, naming file, line and
    column of every problem (of many, the first), one line each; OSError if the file cannot be read.
    """
    comments, rows = _split(_text(path))
    problems: list[Numbered] = []
    header = _header(comments, problems)
    points = _points(rows, spec, problems)
    if problems:
        problems.sort(key=lambda problem: problem[0])
        lines = [f"{path}, line {number}, {problem}" for number, problem in problems[:TOLD]]
        if len(problems) > TOLD:
            lines.append(f"{path}: {len(problems) - TOLD} more problems")
        raise DigitisedError("\n".join(lines))
    import pandas as pd

    table = pd.DataFrame(points, columns=list(CANONICAL))
    table = table.astype(dict.fromkeys(COLUMNS[1:], float))
    key = next(key for key in ORIGINS if key in header)
    evidence = ORIGINS[key]
    table["series"] = [points_series(evidence, name) for name in table["series"]]
    return Digitised(
        figure=spec.name,
        path=path,
        source=header["source"],
        licence=header["licence"],
        by=header[key],
        evidence=evidence,
        table=table,
    )


def _text(path: str) -> str:
    data = Path(path).read_bytes()
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        number, column = before.count(b"\n") + 1, len(before) - before.rfind(b"\n")
        raise DigitisedError(
            f"{path}, line {number}, column {column} (bytes): must be UTF-8 text, "
            f"has the byte 0x{data[error.start]:02x}"
        ) from None


def _split(text: str) -> tuple[list[Numbered], list[Numbered]]:
    """Return the comments at the top, and all lines that follow; blank lines count for nothing."""
    lines = [pair for pair in enumerate(_LINE_END.split(text), 1) if pair[1].strip()]
    end = next((i for i, (_, line) in enumerate(lines) if not line.startswith("#")), len(lines))
    return lines[:end], lines[end:]


def _header(comments: list[Numbered], problems: list[Numbered]) -> dict[str, str]:
    """Return the values of the header block."""
    found: dict[str, str] = {}
    for number, line in comments:
        match = _COMMENT.fullmatch(line)
        if match is None:
            problems.append((number, f"header: {line!r} must be '# key: text'"))
            continue
        key, text = match["key"], match["text"]
        if key not in HEADER_KEYS:
            problems.append((number, f"header: unknown key {key!r}{nearest(key, HEADER_KEYS)}"))
        elif key in found:
            problems.append((number, f"header: {key!r} is given twice"))
        elif not text:
            problems.append((number, f"header: {key!r} is empty"))
        elif not text.isprintable():
            problems.append((number, f"header: {key!r} {text!r} must be printable"))
        found[key] = text
    missing = [key for key in HEADER_KEYS if key not in found and key not in ORIGINS]
    given = [key for key in ORIGINS if key in found]
    if not given:
        missing.append(" or ".join(ORIGINS))
    problems += [(1, f"header: '# {key}: ...' is missing") for key in missing]
    if len(given) > 1:
        problems.append((1, f"header: give either {' or '.join(ORIGINS)}, not both"))
    return found


def _points(rows: list[Numbered], spec: FigureSpec, problems: list[Numbered]) -> list[Row]:
    """Return the points below the line of column names."""
    if not rows:
        problems.append((1, f"column names: the line {','.join(COLUMNS)} is missing"))
        return []
    (number, names), *lines = rows
    try:
        check_columns(_fields(names), COLUMNS, "column names")
    except (TableError, DigitisedError) as error:
        problems.append((number, str(error)))
        return []
    if not lines:
        problems.append((number, "column series: at least one point must follow"))
    found: dict[Row, int] = {}
    for number, line in lines:
        row, wrong = _point(line, spec)
        if row in found:
            wrong.append(f"column series: repeats the point of line {found[row]}")
        problems += [(number, problem) for problem in wrong]
        if row is not None:
            found.setdefault(row, number)
    return list(found)


def _fields(line: str) -> list[str]:
    # A line at a time, so that a quote left open spoils no other.
    try:
        return next(csv.reader([line], strict=True))
    except csv.Error as error:
        raise DigitisedError(
            f"column series: quotes must enclose a whole field ({error})"
        ) from None


def _point(line: str, spec: FigureSpec) -> tuple[Row | None, list[str]]:
    """Return the point on a line, or none and what is wrong."""
    if line.startswith("#"):
        return None, ["column series: comments must stand above the column names"]
    try:
        fields = _fields(line)
    except DigitisedError as error:
        return None, [str(error)]
    if len(fields) != len(COLUMNS):
        hint = "; a series name with a comma must stand in double quotes"
        words = f"must have {len(COLUMNS)} fields, has {len(fields)}{hint}"
        return None, [f"column {COLUMNS[min(len(fields), len(COLUMNS)) - 1]}: {words}"]
    series, *numbers = fields
    problems: list[str] = []
    panel, name = _panel_and_name(series, spec, problems)
    x, y, low, high = (
        _number(text, column, problems) for column, text in zip(COLUMNS[1:], numbers, strict=True)
    )
    if problems or x is None or y is None:
        return None, problems
    problems += [*_wrong_bar(low, y, high), *_wrong_side(x, y, panel, spec)]
    shown = spec.panels[panel].shows or panel
    return (None if problems else (shown, name, x, y, low, high)), problems


def _panel_and_name(series: str, spec: FigureSpec, problems: list[str]) -> tuple[str, str]:
    """Return the panel and the name that a series is written with."""
    panel, colon, name = series.partition(": ")
    if len(spec.panels) == 1:
        (only,) = spec.panels
        if colon and panel == only:
            problems.append(f"column series: {spec.name} has one panel, write just {name!r}")
        panel, name = only, series
    elif not colon and len({own.shows or one for one, own in spec.panels.items()}) == 1:
        # Further panels are other views of the same data.
        panel, name = next(iter(spec.panels)), series
    elif not colon:
        known = ", ".join(spec.panels)
        problems.append(f"column series: {series!r} must be 'panel: name', panel one of {known}")
        return panel, name
    elif panel not in spec.panels:
        near = nearest(panel, spec.panels)
        problems.append(f"column series: {spec.name} has no panel {panel!r}{near}")
    if not name or name != name.strip() or not name.isprintable() or len(name) > LONGEST_NAME:
        problems.append(
            f"column series: name {name[: LONGEST_NAME + 1]!r} must be 1 to {LONGEST_NAME} "
            "printable characters without space around them"
        )
    return panel, name


def _number(text: str, column: str, problems: list[str]) -> float | None:
    """Return a number; none where a bar has none."""
    if not text.strip() and column in {"y_low", "y_high"}:
        return None
    number = float(text) if _NUMBER.fullmatch(text.strip()) else math.nan
    if not math.isfinite(number):
        problems.append(f"column {column}: {text!r} must be a finite number, as 0.5 or 1.2e-3")
    return number


def _wrong_bar(low: float | None, y: float, high: float | None) -> Iterator[str]:
    if (low is None) != (high is None):
        column = "y_low" if low is None else "y_high"
        yield f"column {column}: is empty, y_low and y_high must be given both or neither"
    if low is not None and low > y:
        yield f"column y_low: {low:g} must not exceed y, {y:g}"
    if high is not None and high < y:
        yield f"column y_high: {high:g} must not be below y, {y:g}"


def _wrong_side(x: float, y: float, panel: str, spec: FigureSpec) -> Iterator[str]:
    """Refuse what a logarithmic axis cannot show, and what is in another unit than the axis.

    The logarithmic axes of the registry begin above zero.
    """
    axes: PanelSpec = spec.panels[panel]
    for column, value, ends in (("x", x, axes.x_range), ("y", y, axes.y_range)):
        if ends[0] > 0.0 >= value:
            yield f"column {column}: {value:g} must be positive, as the axis of {panel!r} is"
        elif abs(value) > FAR * max(map(abs, ends)):
            shown = f"{ends[0]:g} to {ends[1]:g}"
            yield f"column {column}: {value:g} is far off the axis of {panel!r}, {shown}"


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

    name = next(iter(spec.data))
    unit = spec.data[name]
    rows = points.table.assign(evidence=points.evidence)
    rows = rows[["panel", "series", "evidence", *COLUMNS[1:]]]
    rows.columns = pd.Index(figure_columns(unit.x, unit.y))
    return {**tables, name: pd.concat([tables[name], rows], ignore_index=True)}
