"""Check of results against committed references, and the explicit renewal of these.

A folder of references holds ``tables/``, ``data/`` and ``figures/`` (see `figures.content`), all
CSV, and ``tolerances.yaml``. Nothing is thinned: every number is compared.
"""

from __future__ import annotations

import gzip
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path

import pandas as pd

from microimpact.core.files import write_file
from study.declared.documents import load
from study.declared.parameters import Name
from study.report.check.differences import Difference, Tolerance, compare_tables
from study.report.check.results import (
    INPUTS,
    ResultsError,
    built,
    read_cells,
    require_results,
    table_files,
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
    columns: tuple[ColumnTolerance, ...] = ()

    def of(self, file: str) -> Callable[[str], Tolerance]:
        """Return the tolerance of each column of a table, by the column's name."""
        rules = [rule for rule in self.columns if fnmatchcase(file, rule.file)]
        return lambda column: next(
            (rule for rule in rules if fnmatchcase(column, rule.column)), self.default
        )


def read_tolerances(path: Path) -> Tolerances:
    """Read the file of tolerances; without one, the default counts everywhere.

    Raises ResultsError: one line per problem, with the dotted key.
    """
    return built(Tolerances, load(path), str(path)) if path.exists() else Tolerances()


def verify(results: Path, reference: Path) -> list[Difference]:
    """Return all differences of results from their references, in both directions.

    Raises ResultsError if either folder or a file in it is missing or malformed.
    """
    require_results(results)
    if not reference.is_dir():
        raise ResultsError(f"{reference}: no such folder")
    tolerances = read_tolerances(reference / FILE)
    before, after = table_files(reference), table_files(results)
    differences = [
        *(Difference(file=name, kind="missing file") for name in before if name not in after),
        *(Difference(file=name, kind="extra file") for name in after if name not in before),
    ]
    seen: set[tuple[str, str]] = set()
    for name in before:
        table = read_cells(before[name])
        seen |= {(name, str(column)) for column in table}
        if name in after:
            differences += compare_tables(name, table, read_cells(after[name]), tolerances.of(name))
    for rule in tolerances.columns:  # one that fits nothing has outlived its reason
        if not any(fnmatchcase(n, rule.file) and fnmatchcase(c, rule.column) for n, c in seen):
            column = f"a column {rule.column!r} in {rule.file!r}"
            raise ResultsError(f"{reference / FILE}: no table has {column}")
    return differences


def require_same_settings(differences: Sequence[Difference]) -> None:
    """Refuse results of a run with other settings altogether than the references come from.

    A few changed inputs are differences to report; a full run beside the references of a small one
    differs everywhere. Raises ResultsError, naming one of the inputs that differ and their number.
    """
    changed = [
        d
        for d in differences
        if d.file == INPUTS and d.column == "value" and d.row.startswith("config, ")
    ]
    if len(changed) > FEW_CHANGES:
        first = changed[0]
        raise ResultsError(
            f"{len(changed)} inputs differ, as {first.row.removeprefix('config, ')}: "
            f"{first.result} where the references have {first.reference}; these are of the small "
            "run: snakemake --configfile config/ci.yaml"
        )


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
        If results are missing and `remove` is not set; then nothing is written.
    """
    missing = [d.file for d in differences if d.kind == "missing file"]
    if missing and not remove:
        raise ResultsError(
            f"{results}: lacks {len(missing)} files that have references "
            f"({', '.join(missing[:3])}{', ...' if len(missing) > 3 else ''}); "
            "build everything, or give --remove to drop these references"
        )
    tables = table_files(results)
    changed = []
    for name in dict.fromkeys(d.file for d in differences):
        plain, packed = reference / name, reference / f"{name}.gz"
        changed += [path for path in (plain, packed) if path.exists()]
        for path in (plain, packed):
            path.unlink(missing_ok=True)
        if name in tables:
            text = _stored(read_cells(tables[name]))
            # Without a date in it, equal tables give equal bytes.
            is_small = len(text) <= PLAIN_BYTES
            changed.append(plain if is_small else packed)
            write_file(changed[-1], text if is_small else gzip.compress(text, mtime=0))
    return list(dict.fromkeys(changed))


def _stored(table: pd.DataFrame) -> bytes:
    """Return a table as CSV, its numbers rounded to `DIGITS` digits."""
    buffer = io.StringIO()
    table.map(_rounded).to_csv(buffer, index=False, lineterminator="\n")
    return buffer.getvalue().encode()


def _rounded(cell: str) -> str:
    try:
        short = f"{float(cell):.{DIGITS}g}"
    except ValueError:
        return cell
    return short if len(short) < len(cell) else cell
