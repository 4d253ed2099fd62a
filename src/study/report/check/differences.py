"""Differences of two tables, by the names of their rows and within tolerances; in words."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from os.path import commonprefix
from typing import Literal, TypeAlias, get_args

import numpy as np
import pandas as pd

from study.declared.parameters import NonNegative
from study.report.check.results import KEYS

# In the order in which they are reported.
Kind = Literal[
    "missing file",
    "extra file",
    "missing column",
    "extra column",
    "missing row",
    "extra row",
    "text",
    "number",
]
KINDS: tuple[Kind, ...] = get_args(Kind)
HEADER = ("row", "column", "reference", "result", "relative")
# Differences of each kind that are shown, and characters of a cell; the name of a row is never cut.
FEW, WIDTH = 5, 60

# Keys of a row, and its number among the rows of these keys.
RowName: TypeAlias = tuple[tuple[str, ...], int]


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerance:
    """Numbers agree if ``|result - reference| <= atol + rtol |reference|``."""

    rtol: NonNegative = 1e-8
    atol: NonNegative = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """One difference: its place, and the cells of the reference and the result.

    `relative` is the relative difference of two numbers, infinite if it has no bound, as beside
    zero or a missing number, and NaN for all else.
    """

    file: str
    kind: Kind
    row: str = ""
    column: str = ""
    reference: str = ""
    result: str = ""
    relative: float = math.nan


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
    columns = [str(column) for column in reference if column in result]
    named = next((names for start, names in KEYS.items() if file.startswith(start)), ())
    declared = [column for column in named if column in columns]
    keys = declared or [c for c in columns if _has_words(reference[c]) or _has_words(result[c])]
    before, after = (_named_rows(table, keys) for table in (reference, result))
    label = _labels([*before, *after])
    at = partial(Difference, file=file)
    differences = [
        *(at(kind="missing column", column=str(c)) for c in reference if c not in result),
        *(at(kind="extra column", column=str(c)) for c in result if c not in reference),
        *(
            at(kind="missing row", row=label(name), reference=_cells(reference, i, keys))
            for name, i in before.items()
            if name not in after
        ),
        *(
            at(kind="extra row", row=label(name), result=_cells(result, i, keys))
            for name, i in after.items()
            if name not in before
        ),
    ]
    names = [name for name in before if name in after]
    for column in columns:
        a = reference[column].iloc[[before[name] for name in names]]
        b = result[column].iloc[[after[name] for name in names]]
        differences += [
            at(
                row=label(names[i]), column=column, reference=a.iloc[i], result=b.iloc[i],
                kind="text" if math.isnan(size) else "number", relative=size,
            )
            for i, size in _sizes(a, b, tolerance(column)).items()
        ]  # fmt: skip
    return differences


def _has_words(cells: pd.Series) -> bool:
    return bool((~cells.isin(["True", "False"]) & _is_text(cells)).any())


def _is_text(cells: pd.Series) -> pd.Series:
    return _numbers(cells).isna() & ~cells.str.lower().isin(["", "nan"])


def _numbers(cells: pd.Series) -> pd.Series:
    return pd.to_numeric(cells, errors="coerce").astype(float)


def _named_rows(table: pd.DataFrame, keys: Sequence[str]) -> dict[RowName, int]:
    """Return the position of each row by its keys and its number among rows of the same keys."""
    counts: Counter[tuple[str, ...]] = Counter()
    rows = {}
    cells = table[list(keys)].itertuples(index=False, name=None) if keys else [()] * len(table)
    for i, key in enumerate(cells):
        counts[key] += 1
        rows[key, counts[key]] = i
    return rows


def _labels(names: Sequence[RowName]) -> Callable[[RowName], str]:
    """Return the function that labels a row by the keys that distinguish rows."""
    columns = enumerate(zip(*(key for key, _ in names), strict=True))
    telling = [i for i, column in columns if len(set(column)) > 1]
    repeated = {key for key, number in names if number > 1}

    def label(name: RowName) -> str:
        key, number = name
        words = ", ".join(key[i] for i in telling)
        if not words:
            return f"row {number}"
        return f"{words} #{number}" if key in repeated else words

    return label


def _cells(table: pd.DataFrame, row: int, keys: Sequence[str]) -> str:
    cells = table.iloc[row].drop(list(keys))
    return ", ".join(f"{column} {cell}" for column, cell in cells.items() if cell)


def _sizes(before: pd.Series, after: pd.Series, tolerance: Tolerance) -> dict[int, float]:
    """Return the relative difference of the cells that differ, by position; NaN of texts."""
    if np.array_equal(before.to_numpy(), after.to_numpy()):
        return {}
    a, b = (_numbers(cells).to_numpy() for cells in (before, after))
    is_text = _is_text(before).to_numpy() | _is_text(after).to_numpy()
    agree = np.isclose(b, a, rtol=tolerance.rtol, atol=tolerance.atol, equal_nan=True) & ~is_text
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        sizes = np.abs(b - a) / np.abs(a)
    # A size without bound is infinite, and a text has none.
    sizes = np.where(is_text, np.nan, np.where(np.isfinite(sizes), sizes, np.inf))
    differ = (before.to_numpy() != after.to_numpy()) & ~agree
    return {i: float(sizes[i]) for i in np.flatnonzero(differ).tolist()}


def by_file(differences: Iterable[Difference]) -> dict[str, list[Difference]]:
    """Return the differences by file, in the order in which the files first occur."""
    files: dict[str, list[Difference]] = {}
    for difference in differences:
        files.setdefault(difference.file, []).append(difference)
    return files


def summary(differences: Sequence[Difference]) -> str:
    """Count the differences of each kind in one line, and give the largest of numbers."""
    counts = Counter(difference.kind for difference in differences)
    parts = [f"{counts[k]} {k}{'s' if counts[k] > 1 else ''}" for k in KINDS if counts[k]]
    relative = [d.relative for d in differences if math.isfinite(d.relative)]
    if relative:
        parts.append(f"largest relative difference {max(relative):.1e}")
    return ", ".join(parts)


def worst(differences: Sequence[Difference], few: int) -> list[Difference]:
    """Return a few differences of every kind; of numbers the largest."""
    ranked = sorted(
        differences,
        key=lambda d: (KINDS.index(d.kind), -(0.0 if math.isnan(d.relative) else d.relative)),
    )
    kinds = groupby(ranked, lambda difference: difference.kind)
    return [d for _, group in kinds for d in list(group)[:few] if not d.kind.endswith("file")]


def cells(difference: Difference, width: int = WIDTH) -> tuple[str, ...]:
    """Return row, column, both values and the relative difference as short texts."""
    relative = "" if math.isnan(difference.relative) else f"{difference.relative:.1e}"
    texts = [difference.reference, difference.result]
    # Long texts begin shortly before the first letter that differs.
    same = len(commonprefix(texts))  # noqa: RUF071 (letters are meant)
    start = max(0, same - width // 3) if max(map(len, texts)) > width else 0
    cut = (
        f"{'…' * (start > 0)}{text[start : start + width]}{'…' * (len(text) > start + width)}"
        for text in texts
    )
    return (difference.row, difference.column or difference.kind, *cut, relative)


def markdown(
    differences: Iterable[Difference], few: int = FEW, *, names: tuple[str, str] = HEADER[2:4]
) -> str:
    """Return the differences as Markdown: a heading per file, and a table of the worst.

    Parameters
    ----------
    few
        How many of each kind are shown per file.
    names
        Of the two sides.
    """
    sections = []
    for file, members in by_file(differences).items():
        shown = worst(members, few)
        lines = [f"### {file}: {summary(members)}"]
        if shown:
            lines += ["", *_table([(*HEADER[:2], *names, HEADER[4]), *map(cells, shown)])]
            if len(members) > len(shown):
                lines += ["", f"and {len(members) - len(shown)} more"]
        sections.append("\n".join(lines))
    return "\n\n".join(sections)


def _table(rows: Sequence[Sequence[str]]) -> list[str]:
    clean = [[" ".join(cell.split()).replace("|", "\\|") for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*clean, strict=True)]
    lines = [
        "| " + " | ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)) + " |"
        for row in clean
    ]
    return [lines[0], "|" + "|".join("-" * (w + 2) for w in widths) + "|", *lines[1:]]
