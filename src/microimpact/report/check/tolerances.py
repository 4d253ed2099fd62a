"""The tolerances of the check, read from the file beside the references."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path

from microimpact.declared.documents import load
from microimpact.declared.parameters import Name, NonNegative
from microimpact.report.check.differences import Tolerance
from microimpact.report.check.results import ResultsError, built
from microimpact.report.check.shapes import PictureTolerance

FILE = "tolerances.yaml"


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnTolerance:
    """A wider tolerance of some columns of some tables (patterns with ``*``), and why."""

    file: Name
    column: Name
    rtol: NonNegative = 1e-8
    atol: NonNegative = 0.0
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

        def tolerance(column: str) -> Tolerance:
            for rule in rules:
                if fnmatchcase(column, rule.column):
                    return Tolerance(rtol=rule.rtol, atol=rule.atol)
            return self.default

        return tolerance

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
