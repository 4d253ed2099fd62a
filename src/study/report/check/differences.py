"""Differences of two tables, by the names of their rows and within tolerances."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Literal, TypeAlias, get_args

import numpy as np
import pandas as pd

from study.declared.parameters import NonNegative
from study.report.check.results import key_columns

# In the order in which they are reported.
Kind = Literal[
    "missing file",
    "extra file",
    "altered file",
    "missing column",
    "extra column",
    "missing row",
    "extra row",
    "text",
    "number",
]
KINDS: tuple[Kind, ...] = get_args(Kind)

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
    zero or a missing number, and NaN for all else. `share` is the difference over the largest
    number of the column, by which differences are ranked: numbers that are all but zero differ by
    any factor.
    """

    file: str
    kind: Kind
    row: str = ""
    column: str = ""
    reference: str = ""
    result: str = ""
    relative: float = math.nan
    share: float = field(default=math.nan, compare=False)


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
    declared = [column for column in key_columns(file) if column in columns]
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
        sizes = _sizes(a, b, tolerance(column))
        differences += [
            at(row=label(names[i]), column=column, reference=a.iloc[i], result=b.iloc[i], **size)
            for i, size in sizes.items()
        ]
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


def _sizes(before: pd.Series, after: pd.Series, tolerance: Tolerance) -> dict[int, dict[str, Any]]:
    """Return kind and size of each difference of two columns of cells, by its position."""
    if np.array_equal(before.to_numpy(), after.to_numpy()):
        return {}
    a, b = (_numbers(cells).to_numpy() for cells in (before, after))
    is_text = _is_text(before).to_numpy() | _is_text(after).to_numpy()
    agree = np.isclose(b, a, rtol=tolerance.rtol, atol=tolerance.atol, equal_nan=True) & ~is_text
    largest = np.max(np.abs(a), initial=0.0, where=np.isfinite(a))
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        sizes = np.stack((np.abs(b - a) / np.abs(a), np.abs(b - a) / largest))
    # A size without bound is infinite, and a text has none.
    sizes = np.where(is_text, np.nan, np.where(np.isfinite(sizes), sizes, np.inf))
    return {
        i: {
            "kind": "text" if is_text[i] else "number",
            "relative": float(sizes[0, i]),
            "share": float(sizes[1, i]),
        }
        for i in np.flatnonzero((before.to_numpy() != after.to_numpy()) & ~agree).tolist()
    }
