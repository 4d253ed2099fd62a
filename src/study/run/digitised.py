"""Points of the article's figures, digitised or measured, dropped in as one file per figure.

The form of a file stands in ``config/digitised/README.md``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from pydantic import AfterValidator, Field, ValidationError

from microimpact.core.nearest import nearest
from study.declared.documents import ConfigError
from study.declared.parameters import Finite, build, explain
from study.declared.selection import read_rows
from study.figures.declaration import Figure
from study.tables import points_series

# Loaded where there are points.
if TYPE_CHECKING:
    import pandas as pd

COLUMNS = ("series", "x", "y", "y_low", "y_high")
# Characters of the name of a series: more would not fit below the narrowest figure.
LONGEST = 48
# Problems of one file that are reported.
MOST_LINES = 20

_ARTICLE_FIGURE = re.compile(r"fig\d\d")


def _printable(text: str) -> str:
    if not text.isprintable() or text != text.strip():
        raise ValueError(f"{text!r} must be printable characters without space around them")
    return text


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """One point, with both ends of its bar or none."""

    series: Words
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Digitised:
    """Digitised points of one figure."""

    figure: str
    path: str
    header: Header
    evidence: str  # ``digitised`` or ``measured``
    # The panel whose data are drawn there, the series as `points_series` calls it, x and y in the
    # units of the figure, the ends of the bar, NaN where there is none.
    table: pd.DataFrame


def read_folder(folder: str, figures: Mapping[str, Figure]) -> dict[str, Digitised]:
    """Read every file of digitised points in a folder, by figure.

    Its README and hidden or backup files do not count. Raises ConfigError with one line per
    problem of every file; also for a file that belongs to no plot of the article.
    """
    if not Path(folder).is_dir():
        raise ConfigError(f"digitised: {folder!r} must be a folder")
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
                raise ConfigError(f"{file}: must be named for a plot of the article{near}")
            points[file.stem] = read_points(str(file), plots[file.name])
        except ConfigError as error:
            problems.append(str(error))
        except OSError as error:
            problems.append(f"{file}: {error.strerror}")
    if problems:
        raise ConfigError("\n".join(problems))
    return points


def read_points(path: str, spec: Figure) -> Digitised:
    """Read the digitised points of one figure.

    Raises ConfigError with file and line of its problems, of many the first; OSError if the file
    cannot be read.
    """
    rows, comments, problems = read_rows(path, Point)
    header = _header(comments, problems)
    lines = dict[tuple[str | float | None, ...], int]()
    for line, (_, point) in rows.items():
        try:
            panel, name = _panel_and_name(point.series, spec)
        except ValueError as error:
            problems.append(f"line {line}, series: {error}")
            continue
        shown = spec.views.get(panel, panel)
        first = lines.setdefault((shown, name, *astuple(point)[1:]), line)
        if first != line:
            problems.append(f"line {line}, series: repeats the point of line {first}")
    if not rows and not problems:
        problems.append("at least one point must follow")
    if header is None or problems:
        raise ConfigError("\n".join(f"{path}, {problem}" for problem in problems[:MOST_LINES]))
    import pandas as pd

    evidence = "digitised" if header.digitised_by else "measured"
    table = pd.DataFrame(list(lines), columns=["panel", *COLUMNS])
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


def _panel_and_name(series: str, spec: Figure) -> tuple[str, str]:
    """Return the panel and the name in the text of a series."""
    panel, colon, name = series.partition(": ")
    if not (colon and panel in spec.panels and len(spec.panels) > 1):
        # Panels may be views of the same data.
        if len({spec.views.get(each, each) for each in spec.panels}) > 1:
            known = f"{', '.join(spec.panels)}{nearest(panel, spec.panels)}"
            raise ValueError(f"{series!r} must be 'panel: name', panel one of {known}")
        panel, name = next(iter(spec.panels)), series
    if len(name) > LONGEST:
        raise ValueError(f"{name!r} must have at most {LONGEST} characters")
    return panel, name


def as_rows(points: Mapping[str, Digitised], figures: Iterable[str]) -> dict[str, str]:
    """Return the points of some figures as a study is given declared rows.

    ``digitised``: CSV text with the columns figure, panel, series, x, y, y_low, y_high; nothing if
    there are no points.
    """
    tables = [points[name].table.assign(figure=name) for name in figures if name in points]
    if not tables:
        return {}
    import pandas as pd

    table = pd.concat(tables)[["figure", "panel", *COLUMNS]]
    return {"digitised": table.to_csv(index=False, lineterminator="\n")}


def overlaid(
    tables: Mapping[str, pd.DataFrame], spec: Figure, points: Digitised
) -> dict[str, pd.DataFrame]:
    """Return the figure data with the points as further rows of the first table."""
    import pandas as pd

    name = spec.data[0]
    rows = points.table.assign(evidence=points.evidence)
    rows = rows[["panel", "series", "evidence", *COLUMNS[1:]]]
    rows.columns = tables[name].columns
    return {**tables, name: pd.concat([tables[name], rows], ignore_index=True)}
