"""Differences of two tables, by the names of their rows and within tolerances; in lines."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from itertools import groupby
from operator import attrgetter
from typing import NamedTuple

import numpy as np
import pandas as pd

from study.declared.parameters import Name, NonNegative
from study.report.check.results import KEYS

# Differences of a kind that are shown of a file, and characters of a cell.
FEW, WIDTH = 5, 60
NUMBER = "number"


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerance:
    """How closely numbers agree in some columns of some tables (patterns with ``*``), and why.

    They agree if ``|result - reference| <= atol + rtol |reference|``.
    """

    file: Name
    column: Name
    reason: Name
    rtol: NonNegative = 1e-8
    atol: NonNegative = 0.0

    def fits(self, file: str, column: str) -> bool:
        """Return whether it is of a column of a table."""
        return fnmatchcase(file, self.file) and fnmatchcase(column, self.column)


# Where no other is declared.
ROUNDING = Tolerance(file="*", column="*", reason="sums round otherwise on another machine")


class Difference(NamedTuple):
    """One difference: its file, kind and place, and the cells of the reference and the result.

    Its kind is ``number`` or ``text``, or says what is missing or extra: a file, column or row.
    """

    file: str
    kind: str
    row: str = ""
    column: str = ""
    reference: str = ""
    result: str = ""


def compare_tables(
    file: str, reference: pd.DataFrame, result: pd.DataFrame, tolerances: Sequence[Tolerance] = ()
) -> list[Difference]:
    """Return all differences of two tables.

    Rows are matched by their key columns, rows of the same keys by their order.

    Parameters
    ----------
    file
        Name of the table, which has its key columns; if none are declared, all columns of words
        are keys.
    reference, result
        Tables of text, shapes (n, m) and (k, l).
    tolerances
        Of several for one column the first counts.
    """
    columns = [str(name) for name in reference if name in result]
    declared = next((names for start, names in KEYS.items() if file.startswith(start)), ())
    keys = [name for name in columns if name in declared] or [
        name
        for name in columns
        if any(_has_words(table[name].to_numpy()) for table in (reference, result))
    ]
    telling = [name for name in keys if len({*reference[name], *result[name]}) > 1]
    before, after = (table.set_axis(_labels(table, telling)) for table in (reference, result))
    differences = []
    for kind, here, there in (("missing", before, after), ("extra", after, before)):
        side = "reference" if kind == "missing" else "result"
        differences += [
            Difference(file, f"{kind} column", column=str(name))
            for name in here.columns.difference(there.columns, sort=False)
        ]
        differences += [
            Difference(file, f"{kind} row", label, **{side: _words(here.loc[label], keys)})
            for label in here.index.difference(there.index, sort=False)
        ]
    both = before.index.intersection(after.index, sort=False)
    before, after = before.loc[both], after.loc[both]
    for name in columns:
        tolerance = next((each for each in tolerances if each.fits(file, name)), ROUNDING)
        a, b = before[name].to_numpy(), after[name].to_numpy()
        differences += [
            Difference(file, kind, both[i], name, a[i], b[i])
            for i, kind in _unequal(a, b, tolerance)
        ]
    return differences


def _numbers(cells: np.ndarray) -> np.ndarray:
    return np.asarray(pd.to_numeric(cells, errors="coerce"), dtype=float)


def _is_text(cells: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    text: np.ndarray = np.isnan(numbers)
    text[text] = [cell.lower() not in {"", "nan"} for cell in cells[text]]
    return text


def _has_words(cells: np.ndarray) -> bool:
    return not {"True", "False"}.issuperset(cells[_is_text(cells, _numbers(cells))])


def _labels(table: pd.DataFrame, keys: Sequence[str]) -> list[str]:
    """Return the name of each row: its keys, and its number if it is not the first of these."""
    seen, labels = Counter[str](), list[str]()
    for cells in table[[*keys]].itertuples(index=False):
        words = ", ".join(cells)
        seen[words] += 1
        number = f"#{seen[words]}" if keys else f"row {seen[words]}"
        labels.append(f"{words} {number}".strip() if seen[words] > 1 or not keys else words)
    return labels


def _words(row: pd.Series, keys: Sequence[str]) -> str:
    return ", ".join(f"{name} {cell}" for name, cell in row.drop(list(keys)).items() if cell)


def _unequal(a: np.ndarray, b: np.ndarray, tolerance: Tolerance) -> Iterator[tuple[int, str]]:
    """Yield the places of cells that differ, and whether they are numbers or text."""
    differ = np.flatnonzero(a != b)
    a, b = a[differ], b[differ]
    before, after = _numbers(a), _numbers(b)
    text = _is_text(a, before) | _is_text(b, after)
    near = np.isclose(after, before, rtol=tolerance.rtol, atol=tolerance.atol, equal_nan=True)
    for i in np.flatnonzero(text | ~near):
        yield int(differ[i]), "text" if text[i] else NUMBER


def relative(difference: Difference) -> float:
    """Return the size of a difference of two numbers over the first; infinite without bound."""
    if difference.kind != NUMBER:
        return 0.0
    before, after = (float(text or "nan") for text in (difference.reference, difference.result))
    size = abs(after - before) / abs(before) if before else np.inf
    return size if np.isfinite(size) else np.inf


def summary(differences: Sequence[Difference]) -> str:
    """Count the differences of each kind in one line, and give the largest of numbers."""
    counts = Counter(difference.kind for difference in differences)
    parts = [f"{count} {kind}{'s' if count > 1 else ''}" for kind, count in counts.items()]
    if counts[NUMBER]:
        parts.append(f"largest relative difference {max(map(relative, differences)):.1e}")
    return ", ".join(parts)


def as_text(differences: Iterable[Difference], few: int = FEW) -> str:
    """Return the differences as Markdown: a heading per file, and a line for each of the worst."""
    sections = []
    for file, group in groupby(differences, attrgetter("file")):
        members = sorted(group, key=attrgetter("kind"))
        shown = [
            each
            for _, of_kind in groupby(members, attrgetter("kind"))
            for each in sorted(of_kind, key=relative, reverse=True)[:few]
        ]
        lines = [f"- {_line(d)}" for d in shown if not d.kind.endswith("file")]
        if len(members) > len(shown):
            lines.append(f"- and {len(members) - len(shown)} more")
        sections.append("\n".join([f"### {file}: {summary(members)}", *lines]))
    return "\n\n".join(sections)


def _line(difference: Difference) -> str:
    """Return a difference in one line; of long cells the part where they begin to differ."""
    cells = difference.reference, difference.result
    same = next((i for i, (a, b) in enumerate(zip(*cells, strict=False)) if a != b), 0)
    start = max(0, same - WIDTH // 3) if max(map(len, cells)) > WIDTH else 0
    before, after = (
        "…" * (start > 0) + cell[start : start + WIDTH] + "…" * (len(cell) > start + WIDTH)
        for cell in cells
    )
    where = f"{difference.row}, {difference.column or difference.kind}".removeprefix(", ")
    return " ".join(f"{where}: {before} -> {after}".split())
