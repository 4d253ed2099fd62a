"""Differences of two tables, by the names of their rows and within tolerances; in lines."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby

import numpy as np
import pandas as pd

from study.declared.parameters import NonNegative
from study.report.check.results import KEYS

# Differences of a kind that are shown of a file, and characters of a cell.
FEW, WIDTH = 5, 60
NUMBER = "number"


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerance:
    """Numbers agree if ``|result - reference| <= atol + rtol |reference|``."""

    rtol: NonNegative = 1e-8
    atol: NonNegative = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
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
    file: str,
    reference: pd.DataFrame,
    result: pd.DataFrame,
    tolerance: Callable[[str], Tolerance] = lambda _: Tolerance(),
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
    tolerance
        Tolerance of a column by its name.
    """
    tables = reference, result
    common = [str(column) for column in reference if column in result]
    declared = next((names for start, names in KEYS.items() if file.startswith(start)), ())
    keys = [name for name in declared if name in common]
    keys = keys or [
        name for name in common if any(_has_words(table[name].to_numpy()) for table in tables)
    ]
    before, after = (_named(table, keys) for table in tables)
    label = _labels([*before, *after])
    at, words = partial(Difference, file=file), partial(_words, keys=keys)
    differences = []
    for kind, side, here, there in (
        ("missing", "reference", before, after),
        ("extra", "result", after, before),
    ):
        table, counterpart = tables if kind == "missing" else tables[::-1]
        differences += [
            at(kind=f"{kind} column", column=str(c)) for c in table if c not in counterpart
        ]
        differences += [
            at(kind=f"{kind} row", row=label(name), **{side: words(table.iloc[i])})
            for name, i in here.items()
            if name not in there
        ]
    names = [name for name in before if name in after]
    places = [[rows[name] for name in names] for rows in (before, after)]
    for column in common:
        a, b = (t[column].to_numpy()[p] for t, p in zip(tables, places, strict=True))
        for i, kind in _unequal(a, b, tolerance(column)):
            cells = {"reference": a[i], "result": b[i]}
            differences.append(at(kind=kind, row=label(names[i]), column=column, **cells))
    return differences


def _numbers(cells: np.ndarray) -> np.ndarray:
    return np.asarray(pd.to_numeric(cells, errors="coerce"), dtype=float)


def _is_text(cells: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    text: np.ndarray = np.isnan(numbers)
    text[text] = [cell.lower() not in {"", "nan"} for cell in cells[text]]
    return text


def _has_words(cells: np.ndarray) -> bool:
    return not {"True", "False"}.issuperset(cells[_is_text(cells, _numbers(cells))])


def _named(table: pd.DataFrame, keys: Sequence[str]) -> dict[tuple[str, ...], int]:
    """Return the place of each row by its keys and its number among rows of the same keys."""
    seen, rows = Counter[tuple[str, ...]](), {}
    for i, name in enumerate(map(tuple, table[list(keys)].to_numpy())):
        seen[name] += 1
        rows[*name, str(seen[name])] = i
    return rows


def _labels(names: Sequence[tuple[str, ...]]) -> Callable[[tuple[str, ...]], str]:
    """Return the function that labels a row by the keys in which rows differ."""
    columns = list(zip(*names, strict=True))[:-1]
    telling = [i for i, column in enumerate(columns) if len({*column}) > 1]
    repeated = {name[:-1] for name in names if name[-1] != "1"}

    def label(name: tuple[str, ...]) -> str:
        words = ", ".join(name[i] for i in telling)
        if not words:
            return f"row {name[-1]}"
        return f"{words} #{name[-1]}" if name[:-1] in repeated else words

    return label


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


def by_file(differences: Iterable[Difference]) -> dict[str, list[Difference]]:
    """Return the differences by file, in the order in which the files first occur."""
    files: dict[str, list[Difference]] = {}
    for difference in differences:
        files.setdefault(difference.file, []).append(difference)
    return files


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
    for file, members in by_file(differences).items():
        shown = []
        for _, group in groupby(sorted(members, key=lambda d: d.kind), lambda d: d.kind):
            shown += sorted(group, key=relative, reverse=True)[:few]
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
