"""Tables on disk: CSV files written in one step, read back exactly, with checked headers."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from microimpact.core.computable import NotComputable
from microimpact.core.files import write_file
from microimpact.core.nearest import nearest

# Loaded where a table is made or read: the workflow, which asks for names alone, starts sooner.
if TYPE_CHECKING:
    import pandas as pd

# Tables by their names, as studies take and give them.
Tables: TypeAlias = "Mapping[str, pd.DataFrame]"
# Row of a table in the making, by column.
Row: TypeAlias = dict[str, object]

RESULT_EVIDENCE = (
    "computed",
    "printed",
    "virtual experiment",
    "digitised",
    "measured",
    "calibrated",
    "assumed",
)

# Evidence of points that a user drops in: read off the article, or measured.
POINTS = ("digitised", "measured")


# The only column of a table, and the quantity of a row, in place of what cannot be computed.
NOT_COMPUTED = "not computed"


class TableError(ValueError):
    """A table file that does not have the agreed form."""


class NotComputedError(NotComputable):
    """A result that the inputs do not allow; the message names the study, the case and why."""


def reason(study: str, error: Exception) -> str:
    """Return in one line why a study has no result; one that it takes over keeps its name."""
    line = " ".join(str(error).split())
    return line if isinstance(error, NotComputedError) else f"{study}: {line}"


def not_computed(why: str) -> pd.DataFrame:
    """Return the table in place of one that cannot be computed; `computed` raises its reason."""
    import pandas as pd

    return pd.DataFrame({NOT_COMPUTED: [why]})


def lacking(tables: Tables) -> list[str]:
    """Return why rows of tables, or whole tables, could not be computed, each reason once."""
    columns = [
        table[name].dropna()
        for table in tables.values()
        for name in (NOT_COMPUTED, "problem")
        if name in table
    ]
    return list(dict.fromkeys(str(why) for column in columns for why in column if why))


def computed(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table as it is; raises NotComputedError for one of `not_computed`."""
    if list(table.columns) == [NOT_COMPUTED]:
        raise NotComputedError(table[NOT_COMPUTED].iloc[0])
    return table


def points_series(evidence: str, name: str) -> str:
    """Prefix the name of a series of points with its evidence."""
    return f"{evidence}: {name}"


def points_parts(series: str) -> tuple[str, str]:
    """Return evidence and name of a series of points, as `points_series` has put them together."""
    evidence, _, name = series.partition(": ")
    if evidence not in POINTS:
        raise ValueError(f"series {series!r} must begin with {' or '.join(POINTS)} and a colon")
    return evidence, name


@dataclass(frozen=True, slots=True)
class Curves:
    """The series of the tables that one figure is drawn from."""

    tables: Tables

    def __call__(self, series: str, panel: str = "") -> pd.Series[float]:
        """Return the ordinates of a series by its abscissae, in their order.

        Raises KeyError if no table has the series, or not in this panel.
        """
        for table in self.tables.values():
            is_there = table["series"] == series
            if panel:
                is_there &= table["panel"] == panel
            if is_there.any():
                x, y = table.columns[3:5]
                curve: pd.Series[float] = table[is_there].set_index(x)[y].sort_index()
                return curve
        raise KeyError(f"{panel}: {series}")


def series_frame(
    panel: str,
    series: str,
    x: ArrayLike,
    y: ArrayLike,
    evidence: str = "computed",
    y_low: ArrayLike = np.nan,
    y_high: ArrayLike = np.nan,
    *,
    x_unit: str,
    y_unit: str,
) -> pd.DataFrame:
    """Return one series of a figure in the tidy form of the figure data.

    A study whose figures share their units takes them with `functools.partial`.

    Parameters
    ----------
    panel, series
        Where the series is drawn and what it is called in the legend.
    x, y
        Coordinates, which broadcast to shape (n,).
    y_low, y_high
        Ends of the interval around y, if there is one.
    x_unit, y_unit
        Units as in column names: ``deg``, ``m_per_s``, ``1`` for a pure number.

    Raises
    ------
    ValueError
        If the evidence is not one of the known classes.
    """
    import pandas as pd

    if evidence not in RESULT_EVIDENCE:
        raise ValueError(f"evidence: {evidence!r} must be one of {', '.join(RESULT_EVIDENCE)}")
    # Adding zero takes the sign off a zero that has one.
    columns = np.broadcast_arrays(*(np.atleast_1d(np.asarray(a, float)) + 0.0 for a in (x, y)))
    n = columns[0].size
    ends = (np.broadcast_to(np.asarray(end, float), n) for end in (y_low, y_high))
    values = [panel, series, evidence, *columns, *ends]
    names = figure_columns(x_unit, y_unit)
    return pd.DataFrame(dict(zip(names, values, strict=True)), index=range(n))


def result_evidence(quantity: str, calibration_targets: Sequence[str]) -> str:
    """Return the evidence class of a computed number: calibrated, if it fixed an input."""
    return "calibrated" if quantity in calibration_targets else "computed"


def figure_columns(x_unit: str, y_unit: str) -> list[str]:
    """Return the column names of figure data in the given units."""
    return ["panel", "series", "evidence", f"x_{x_unit}", f"y_{y_unit}", "y_low", "y_high"]


def write_table(table: pd.DataFrame, path: Path | str) -> None:
    """Write a table as CSV so that no reader ever meets half of it.

    Numbers are written with as many digits as bring back the same number.
    """
    write_file(path, table.to_csv(index=False, lineterminator="\n"))


def read_table(path: Path | str, columns: Sequence[str] | None = None) -> pd.DataFrame:
    """Read a CSV table; empty fields are missing values, all else is taken unchanged.

    Parameters
    ----------
    columns
        The header it must have, in this order.

    Raises
    ------
    TableError
        Naming the file and the header, or the line that is cut or has too many fields; also for a
        file that is no text.
    NotComputedError
        For a table of `not_computed`.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
        require_whole_rows(text, str(path))
    except (UnicodeDecodeError, csv.Error) as error:
        raise TableError(f"{path}: no CSV table in UTF-8: {error}") from None
    table = computed(parse_table(text))
    if columns is not None:
        _require_header(table, columns, path)
    return table


def _require_header(table: pd.DataFrame, columns: Sequence[str], path: Path | str) -> None:
    if list(table.columns) != list(columns):
        names = f"{', '.join(table.columns)}; it must be {', '.join(columns)}"
        raise TableError(f"{path}: the header is {names}")


def read_figure_data(path: Path | str) -> pd.DataFrame:
    """Read the data of a figure, in whatever units.

    Raises TableError as for `read_table`, and naming the row where x or y is missing or no number.
    """
    import pandas as pd

    table = read_table(path)
    x, y, *_ = [*table.columns[3:5], "x_", "y_"]
    columns = figure_columns(x[2:], y[2:])
    _require_header(table, columns, path)
    for column in columns[3:5]:
        numbers = pd.to_numeric(table[column], errors="coerce")
        if numbers.isna().any():
            row = int(numbers.isna().argmax())
            cell = table[column].iloc[row]
            shown = "nothing" if pd.isna(cell) else repr(cell)
            raise TableError(f"{path}, row {row + 1}: {column} must be a number, got {shown}")
    return table


def text_rows(path: Path | str) -> list[dict[str, str]]:
    """Return the rows of a table as text, every cell as in the file; none if there is no file."""
    if not Path(path).is_file():
        return []
    with Path(path).open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def parse_table(text: str) -> pd.DataFrame:
    """Return the table that a CSV text holds, read as `read_table` does."""
    import pandas as pd

    return pd.read_csv(io.StringIO(text), keep_default_na=False, na_values=[""])


def require_whole_rows(text: str, name: str) -> None:
    """Raise `TableError`, naming the line, unless each row of a CSV text is as long as its header.

    Missing fields at the end of a row would be read as missing values, a cut number as another.
    """
    rows = csv.reader(io.StringIO(text, newline=""))
    expected = len(next(rows, ()))
    for row in rows:
        if len(row) != expected:
            raise TableError(
                f"{name}, line {rows.line_num}: {len(row)} fields where the header has {expected}"
            )
    if not text.endswith("\n"):
        raise TableError(f"{name}: cut short: its last line does not end")


class Numbers:
    """One table as a page reads it: `table(column, **where)` is the only such number.

    `name`: of the table, for messages; `rows`: its rows.
    """

    def __init__(self, name: str, rows: pd.DataFrame) -> None:
        self.name, self.rows = name, rows

    def __call__(self, column: str, **where: Any) -> float:
        """Return the number of a column in the one row that meets all conditions.

        Raises TableError if there is no such column, or not exactly one such row with a number.
        """
        numbers = self.all(column, **where)
        if len(numbers) != 1:
            raise TableError(f"{self.name}.{column}: {len(numbers)} numbers at {where}, not one")
        return numbers[0]

    def all(self, column: str, **where: Any) -> list[float]:
        """Return all numbers of a column in rows that meet all conditions.

        A condition is a value, or the pair of ends between which a number must lie.

        Raises TableError if there is no such column or no such number.
        """
        chosen = np.ones(len(self.rows), bool)
        for key, value in where.items():
            cells = self._column(key)
            if isinstance(value, tuple):
                chosen &= cells.between(*value).to_numpy()
            elif isinstance(value, str):
                chosen &= (cells == value).to_numpy()
            else:
                chosen &= np.isclose(cells.to_numpy(float), value)
        numbers = self._column(column)[chosen].dropna().astype(float).to_list()
        if not numbers:
            raise TableError(f"{self.name}.{column}: no number at {where}")
        return numbers

    def _column(self, name: str) -> pd.Series:
        if name not in self.rows:
            raise TableError(f"{self.name}: no column {name!r}{nearest(name, self.rows.columns)}")
        return self.rows[name]


class ResultTables:
    """The tables of a run, each read when it is first asked for.

    `folder`: results; `read`: tables by the names asked for.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.read: dict[str, Numbers] = {}

    def __call__(self, name: str) -> Numbers:
        """Return a table; raises TableError if there is none, or if it could not be computed."""
        if name not in self.read:
            path = self.folder / self.file(name)
            if not path.is_file():
                raise TableError(f"{path}: no such table")
            self.read[name] = Numbers(name, read_table(path))
        return self.read[name]

    def file(self, name: str) -> str:
        """Return the file of a table in the folder; figure data are tables, too."""
        data = f"data/{name}.csv"
        return data if (self.folder / data).is_file() else f"tables/{name}.csv"
