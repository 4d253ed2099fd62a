"""Differences of two tables, found in both directions."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from microimpact.declared.parameters import NonNegative

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
    "structure",
    "picture",
]
KINDS: tuple[Kind, ...] = get_args(Kind)

# What its keys say, and which one of those that say the same it is.
RowName = tuple[tuple[str, ...], int]


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerance:
    """Numbers agree if ``|found - reference| <= atol + rtol |reference|``."""

    rtol: NonNegative = 1e-8
    atol: NonNegative = 0.0

    def admits(self, reference: float, found: float) -> bool:
        """Tell whether two numbers agree; missing ones (NaN) agree with each other."""
        if math.isfinite(reference) and math.isfinite(found):
            return abs(found - reference) <= self.atol + self.rtol * abs(reference)
        return reference == found or (math.isnan(reference) and math.isnan(found))


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """One difference: where, what the reference says, what was found.

    `relative` is the relative difference of two numbers, infinite if it has no bound, as
    beside zero or a missing number; it is NaN for all else. `share` is the difference over the
    largest number of the column, by which differences are ranked: numbers that are all but zero
    differ by any factor.
    """

    file: str
    kind: Kind
    row: str = ""
    column: str = ""
    reference: str = ""
    found: str = ""
    relative: float = math.nan
    share: float = field(default=math.nan, compare=False)


def number(cell: str) -> float | None:
    """Return the number in a cell, NaN for an empty one, None for any other text."""
    try:
        return float(cell) if cell else math.nan
    except ValueError:
        return None


def compare_tables(
    file: str,
    reference: pd.DataFrame,
    found: pd.DataFrame,
    *,
    keys: Sequence[str] = (),
    tolerance: Callable[[str], Tolerance] = lambda _: Tolerance(),
    renamed: bool = True,
) -> list[Difference]:
    """Return all differences of two tables.

    Rows are matched by what their key columns say, and rows that say the same in the order in
    which they occur. If equally many rows of either table remain, a key was changed, and they
    are matched in order; otherwise, and if `renamed` is false, they are missing or extra.

    `file`: name of the table in the differences; `reference`, `found`: tables of text, shapes (n,
    m) and (k, l); `keys`: columns that name a row. Without any, all columns that hold words do;
    `tolerance`: gives the tolerance of a column by its name; `renamed`: whether rows whose keys
    differ may be the same.
    """
    columns = [c for c in reference.columns if c in found.columns]
    by = [c for c in keys if c in columns] or [
        c for c in columns if _has_words(reference[c]) or _has_words(found[c])
    ]
    rows = _match(_named_rows(reference, by), _named_rows(found, by), renamed=renamed)
    gone, new = ([c for c in table.columns if c not in columns] for table in (reference, found))
    differences = [Difference(file=file, kind="missing column", column=c) for c in gone]
    differences += [Difference(file=file, kind="extra column", column=c) for c in new]
    for label, place in rows.missing:
        told = _told(reference, place, by)
        differences.append(Difference(file=file, kind="missing row", row=label, reference=told))
    for label, place in rows.extra:
        told = _told(found, place, by)
        differences.append(Difference(file=file, kind="extra row", row=label, found=told))
    for column in columns:
        before = reference[column].to_numpy()[rows.before]
        after = found[column].to_numpy()[rows.after]
        accepted, largest = tolerance(column), _largest(reference[column])
        for i in np.flatnonzero(before != after):
            changed = _changed(before[i], after[i], accepted)
            if changed is not None:
                kind, relative = changed
                where = {"file": file, "row": rows.labels[i], "column": column}
                cells = {"reference": before[i], "found": after[i]}
                share = _share(before[i], after[i], largest) if kind == "number" else math.nan
                differences.append(
                    Difference(kind=kind, relative=relative, share=share, **where, **cells)
                )
    return differences


def _has_words(column: pd.Series) -> bool:
    return any(number(cell) is None for cell in set(column) - {"True", "False"})


def _named_rows(table: pd.DataFrame, by: Sequence[str]) -> dict[RowName, int]:
    seen: Counter[tuple[str, ...]] = Counter()
    named = {}
    keys = table[list(by)].itertuples(index=False, name=None) if by else [()] * len(table)
    for i, key in enumerate(keys):
        seen[key] += 1
        named[key, seen[key]] = i
    return named


@dataclass(frozen=True, slots=True)
class _Rows:
    """Positions of matched rows in both tables with their labels, and the unmatched rows."""

    before: NDArray[np.intp]
    after: NDArray[np.intp]
    labels: list[str]
    missing: list[tuple[str, int]]
    extra: list[tuple[str, int]]


def _match(left: Mapping[RowName, int], right: Mapping[RowName, int], *, renamed: bool) -> _Rows:
    missing, extra = [n for n in left if n not in right], [n for n in right if n not in left]
    pairs = [(name, name) for name in left if name in right]
    if renamed and len(missing) == len(extra):
        pairs += zip(missing, extra, strict=True)
        missing, extra = [], []
    repeated = {key for key, n in (*left, *right) if n > 1}
    # A column that is the same in every row distinguishes none.
    values = list(zip(*(key for key, _ in (*left, *right)), strict=True))
    telling = [i for i, column in enumerate(values) if len(set(column)) > 1]

    def label(name: RowName) -> str:
        key, n = name
        words = ", ".join(key[i] for i in telling)
        if not words:
            return f"row {n}"
        return f"{words} #{n}" if key in repeated else words

    return _Rows(
        np.array([left[name] for name, _ in pairs], dtype=np.intp),
        np.array([right[name] for _, name in pairs], dtype=np.intp),
        [label(name) for name, _ in pairs],
        [(label(name), left[name]) for name in missing],
        [(label(name), right[name]) for name in extra],
    )


def _told(table: pd.DataFrame, row: int, by: Sequence[str]) -> str:
    cells = table.iloc[row].drop(by)
    return ", ".join(f"{column} {cell}" for column, cell in cells.items() if cell)


def _changed(before: str, after: str, tolerance: Tolerance) -> tuple[Kind, float] | None:
    a, b = number(before), number(after)
    if a is None or b is None:
        return "text", math.nan
    if tolerance.admits(a, b):
        return None
    if not (math.isfinite(a) and math.isfinite(b)) or a == 0:
        return "number", math.inf
    return "number", abs(b - a) / abs(a)


def _largest(column: pd.Series) -> float:
    numbers = (number(cell) for cell in set(column))
    return max((abs(n) for n in numbers if n is not None and math.isfinite(n)), default=0.0)


def _share(before: str, after: str, largest: float) -> float:
    """Return a difference over the largest number of its column; infinite if it has no bound."""
    difference = abs(float(after or "nan") - float(before or "nan"))
    return difference / largest if math.isfinite(difference) and largest else math.inf
