"""Points of the article's figures, digitised or measured, dropped in as one file per figure.

The form of a file stands in ``config/digitised/README.md``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from pydantic import AfterValidator, Field

from microimpact.core.nearest import nearest
from study.declared.documents import ConfigError
from study.declared.parameters import Finite
from study.declared.selection import read_rows
from study.figures.declaration import Figure
from study.tables import POINTS, points_series

# Loaded where there are points.
if TYPE_CHECKING:
    import pandas as pd

# Characters of the name of a series: more would not fit below the narrowest figure.
LONGEST = 40

_ARTICLE_FIGURE = re.compile(r"fig\d\d")


def _printable(text: str) -> str:
    if not text.isprintable() or text != text.strip():
        raise ValueError(f"{text!r} must be printable characters without space around them")
    return text


Words = Annotated[str, Field(min_length=1), AfterValidator(_printable)]


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
        if self.y_low is None or self.y_high is None:
            if self.y_low is not self.y_high:
                raise ValueError("y_low and y_high must be given both or neither")
        elif not self.y_low <= self.y <= self.y_high:
            raise ValueError(f"y: {self.y:g} must lie within y_low and y_high")


def files_of(folder: str, figures: Mapping[str, Figure]) -> dict[str, str]:
    """Return the file of points of each figure in a folder, read and checked.

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
    files, problems = {}, []
    for file in sorted(Path(folder).iterdir()):
        if file.name == "README.md" or file.name.startswith(".") or file.name.endswith("~"):
            continue
        try:
            if file.name not in plots:
                near = nearest(file.name, plots)
                raise ConfigError(f"{file}: must be named for a plot of the article{near}")
            _read(str(file), plots[file.name])
            files[file.stem] = str(file)
        except ConfigError as error:
            problems.append(str(error))
        except OSError as error:
            problems.append(f"{file}: {error.strerror}")
    if problems:
        raise ConfigError("\n".join(problems))
    return files


def overlaid(
    tables: Mapping[str, pd.DataFrame], spec: Figure, path: str
) -> dict[str, pd.DataFrame]:
    """Return the figure data with the points of a file as further rows of the first table.

    Raises ConfigError with file and line of its problems; OSError if the file cannot be read.
    """
    import pandas as pd

    evidence, points = _read(path, spec)
    rows = [
        (panel, points_series(evidence, name), evidence, *astuple(point)[1:])
        for panel, name, point in points
    ]
    first = tables[spec.data[0]]
    table = pd.DataFrame(rows, columns=first.columns)
    table = table.astype(dict.fromkeys(first.columns[3:], float))
    return {**tables, spec.data[0]: pd.concat([first, table], ignore_index=True)}


def _read(path: str, spec: Figure) -> tuple[str, list[tuple[str, str, Point]]]:
    """Return the evidence of a file, and panel, name of the series and point of each row."""
    rows, comments, problems = read_rows(path, Point)
    kinds = [kind for kind in POINTS for line in comments if line.startswith(f"# {kind}_by: ")]
    if len(kinds) != 1:
        problems.append("a comment must say who: '# digitised_by: ...' or '# measured_by: ...'")
    points = []
    for line, (_, point) in rows.items():
        try:
            panel, name = _panel_and_name(point.series, spec)
        except ValueError as error:
            problems.append(f"line {line}, series: {error}")
            continue
        points.append((spec.views.get(panel, panel), name, point))
    if not rows and not problems:
        problems.append("at least one point must follow")
    if problems:
        raise ConfigError("\n".join(f"{path}, {problem}" for problem in problems))
    return kinds[0], points


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
