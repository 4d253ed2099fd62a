"""Check of results against committed references, and the explicit renewal of these.

A folder of references holds ``tables/`` and ``data/`` (CSV), ``figures/`` (one JSON per figure,
see `shapes`) and ``tolerances.yaml``. Nothing is thinned: every number is compared.
"""

from __future__ import annotations

import gzip
import io
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path

import pandas as pd

from microimpact.core.files import altered_files, write_file
from microimpact.declared.documents import load
from microimpact.declared.parameters import Name
from microimpact.report.check.differences import Difference, Tolerance, compare_tables, number
from microimpact.report.check.results import (
    INPUTS,
    TABLE_FOLDERS,
    ResultsError,
    built,
    figure_files,
    key_columns,
    read_cells,
    read_json,
    require_results,
    table_files,
)
from microimpact.report.check.shapes import (
    PictureTolerance,
    as_json,
    compare_shapes,
    from_json,
    read_shape,
)

FILE = "tolerances.yaml"

# Far below the tolerance, and a third less to store; the noise of the last digits of another
# machine stays out of the history.
DIGITS = 12

# More changed inputs than these are other settings.
FEW_CHANGES = 20

# Larger tables, long curves and images, are read by nobody and kept compressed.
PLAIN_BYTES = 100_000


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnTolerance(Tolerance):
    """A wider tolerance of some columns of some tables (patterns with ``*``), and why."""

    file: Name
    column: Name
    reason: Name


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerances:
    """All tolerances; of several for one column the first counts."""

    default: Tolerance = field(default_factory=Tolerance)
    pictures: PictureTolerance = field(default_factory=PictureTolerance)
    columns: tuple[ColumnTolerance, ...] = ()

    def of(self, file: str) -> Callable[[str], Tolerance]:
        """Return the tolerance of each column of a table, by the column's name."""
        rules = [rule for rule in self.columns if fnmatchcase(file, rule.file)]
        return lambda column: next(
            (rule for rule in rules if fnmatchcase(column, rule.column)), self.default
        )

    def require_use(self, columns: Mapping[str, Iterable[str]], name: str) -> None:
        """Refuse a tolerance that fits no column of any table: it has outlived its reason.

        `columns`: columns of all tables, those of the references and those found; `name`: name of
        the file of tolerances. Raises ResultsError, naming the tolerance.
        """
        for i, rule in enumerate(self.columns):
            tables = [c for file, c in columns.items() if fnmatchcase(file, rule.file)]
            if not any(fnmatchcase(column, rule.column) for c in tables for column in c):
                raise ResultsError(
                    f"{name}: columns[{i}]: no table has a column {rule.column!r} in {rule.file!r}"
                )


def read_tolerances(path: Path) -> Tolerances:
    """Read the file of tolerances; without one, the default counts everywhere.

    Raises ResultsError: one line per problem, with the dotted key.
    """
    return built(Tolerances, load(path), str(path)) if path.exists() else Tolerances()


def require_same_settings(results: Path, reference: Path) -> None:
    """Refuse results of a run with other settings altogether than the references come from.

    One or a few changed inputs are differences to be told; a full run beside the references of a
    small one differs everywhere. Raises ResultsError, naming one of the inputs that differ and how
    many there are.
    """
    if not all(INPUTS in table_files(root) for root in (results, reference)):
        return
    before, after = (_configured(root) for root in (reference, results))
    other = [key for key in before if key in after and before[key] != after[key]]
    if len(other) > FEW_CHANGES:
        key = other[0]
        raise ResultsError(
            f"{results}: made with other settings than {reference}: {len(other)} inputs differ, as "
            f"{key}: {after[key]} where the references have {before[key]}; these are of the small "
            "run: snakemake --configfile config/ci.yaml"
        )


def _configured(root: Path) -> dict[str, str]:
    table = read_cells(table_files(root)[INPUTS])
    own = table[table["file"] == "config"]
    return dict(zip(own["key"], own["value"], strict=True))


def verify(results: Path, reference: Path) -> list[Difference]:
    """Return all differences of results from their references, in both directions.

    Raises ResultsError if either folder or a file in it is missing or malformed.
    """
    require_results(results)
    if not reference.is_dir():
        raise ResultsError(f"{reference}: no such folder")
    tolerances = read_tolerances(reference / FILE)
    return [
        *_altered(results),
        *_tables(results, reference, tolerances),
        *_figures(results, reference, tolerances),
    ]


def _altered(results: Path) -> list[Difference]:
    paths = [path.relative_to(results) for path in altered_files(results)]
    names = dict.fromkeys(
        (path.with_suffix("") if path.parts[0] == "figures" else path).as_posix() for path in paths
    )
    return [Difference(file=name, kind="altered file") for name in names]


def _tables(results: Path, reference: Path, tolerances: Tolerances) -> list[Difference]:
    expected, found = table_files(reference), table_files(results)
    differences, columns = [], {}
    for name in dict.fromkeys((*found, *expected)):
        tables = [read_cells(files[name]) for files in (expected, found) if name in files]
        columns[name] = [column for table in tables for column in table.columns]
        if len(tables) == 2:
            differences += compare_tables(
                name, *tables, keys=key_columns(name), tolerance=tolerances.of(name)
            )
    tolerances.require_use(columns, str(reference / FILE))
    return [*_lone_files(expected, found), *differences]


def _figures(results: Path, reference: Path, tolerances: Tolerances) -> list[Difference]:
    kept = {path.stem: path for path in sorted((reference / "figures").glob("*.json"))}
    expected = {f"figures/{name}": path for name, path in kept.items()}
    found = {f"figures/{name}": path for name, path in figure_files(results).items()}
    differences = _lone_files(expected, found)
    for name, path in expected.items():
        if name in found:
            before = from_json(read_json(path), str(path))
            differences += compare_shapes(
                name, before, read_shape(found[name]), tolerances.pictures
            )
    return differences


def _lone_files(expected: Iterable[str], found: Iterable[str]) -> list[Difference]:
    before, after = set(expected), set(found)
    return [
        *(Difference(file=name, kind="missing file") for name in expected if name not in after),
        *(Difference(file=name, kind="extra file") for name in found if name not in before),
    ]


def concerned(
    differences: Iterable[Difference], drawn_from: Mapping[str, Sequence[str]]
) -> tuple[list[str], list[str]]:
    """Return the names of all figures and of all tables that differences concern.

    `drawn_from`: for each figure the tables of figure data it is drawn from.
    """
    files = {d.file for d in differences}
    data = {Path(name).stem for name in files if name.startswith("data/")}
    figures = {name.removeprefix("figures/") for name in files if name.startswith("figures/")}
    figures |= {figure for figure, tables in drawn_from.items() if data & set(tables)}
    return sorted(figures), sorted(Path(n).stem for n in files if n.startswith("tables/"))


def renew(
    results: Path, reference: Path, differences: Sequence[Difference], *, remove: bool = False
) -> list[Path]:
    """Write the references that differ anew; those within tolerance stay as they are.

    Parameters
    ----------
    remove
        Whether references of files that the results lack are removed.

    Raises
    ------
    ResultsError
        If results are missing and `remove` is not set, or some are not as the run wrote them;
        then nothing is written.
    """
    missing = [d.file for d in differences if d.kind == "missing file"]
    if missing and not remove:
        raise ResultsError(
            f"{results}: lacks {len(missing)} files that have references "
            f"({', '.join(missing[:3])}{', ...' if len(missing) > 3 else ''}); "
            "build everything, or give --remove to drop these references"
        )
    if altered := [d.file for d in differences if d.kind == "altered file"]:
        raise ResultsError(
            f"{results}: not as the run wrote them: {', '.join(altered)}; delete them and run again"
        )
    tables, figures = table_files(results), figure_files(results)
    changed: list[Path] = []
    for name in dict.fromkeys(d.file for d in differences):
        folder = name.partition("/")[0]
        plain = reference / (name if folder in TABLE_FOLDERS else f"{name}.json")
        packed = plain.with_name(plain.name + ".gz")
        for path in (plain, packed):
            if path.exists():
                path.unlink()
                changed.append(path)
        if name in tables:
            text = _stored(read_cells(tables[name]))
            small = len(text) <= PLAIN_BYTES
            # Without a date in it, equal tables give equal bytes.
            target, content = (plain, text) if small else (packed, gzip.compress(text, mtime=0))
            write_file(target, content)
            changed.append(target)
        elif folder == "figures" and name not in missing:
            write_file(plain, as_json(read_shape(figures[plain.stem])))
            changed.append(plain)
    return list(dict.fromkeys(changed))


def _stored(table: pd.DataFrame) -> bytes:
    """Return a table as CSV, its numbers rounded to `DIGITS` digits."""
    buffer = io.StringIO()
    table.map(_rounded).to_csv(buffer, index=False, lineterminator="\n")
    return buffer.getvalue().encode()


def _rounded(cell: str) -> str:
    value = number(cell)
    if value is None:
        return cell
    short = f"{value:.{DIGITS}g}"
    return short if len(short) < len(cell) else cell
