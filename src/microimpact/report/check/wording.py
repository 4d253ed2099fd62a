"""Differences in words: counts per file and the few worst of each kind, as Markdown."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import groupby

from microimpact.report.check.differences import KINDS, Difference

WORST = 5
WIDTH = 60

# Columns of standard errors, deviations, and ends of intervals.
_UNCERTAINTY = re.compile(r"(standard_error|deviation|_low|_high|interval)")

_COLUMNS = ("row", "column", "reference", "found", "relative")
# Kind -> what is said of one, and of several.
_NOUNS = {
    "missing file": ("the file is missing", ""),
    "extra file": ("the file has no reference", ""),
    "altered file": ("the file is not as the run wrote it", ""),
    "missing column": ("column is missing", "columns are missing"),
    "extra column": ("column is extra", "columns are extra"),
    "missing row": ("row is missing", "rows are missing"),
    "extra row": ("row is extra", "rows are extra"),
    "text": ("text differs", "texts differ"),
    "number": ("number differs", "numbers differ"),
    "structure": ("part differs", "parts differ"),
    "picture": ("the picture looks different", ""),
}


def by_file(differences: Iterable[Difference]) -> dict[str, list[Difference]]:
    """Return the differences by file, in the order in which the files first occur."""
    found: dict[str, list[Difference]] = {}
    for difference in differences:
        found.setdefault(difference.file, []).append(difference)
    return found


def summary(differences: Sequence[Difference]) -> str:
    """Say in one line how many differences of each kind there are in one file."""
    counts = Counter(d.kind for d in differences)
    parts = []
    for kind in KINDS:
        n = counts[kind]
        one, many = _NOUNS[kind]
        if n and not many:
            parts.append(one)
        elif n:
            parts.append(f"{n} {one if n == 1 else many}")
    relative = [d.relative for d in differences if math.isfinite(d.relative)]
    if relative:
        parts.append(f"largest relative difference {max(relative):.1e}")
    return ", ".join(parts)


def worst(differences: Sequence[Difference], few: int = WORST) -> list[Difference]:
    """Return a few differences of every kind; of numbers those that differ most.

    Most is meant beside the largest number of the column, and how well a number is known comes
    after the numbers themselves.
    """

    def order(d: Difference) -> tuple[int, bool, float]:
        share = -1.0 if math.isnan(d.share) else d.share
        return KINDS.index(d.kind), _UNCERTAINTY.search(d.column) is not None, -share

    ranked = sorted(differences, key=order)
    return [d for _, group in groupby(ranked, lambda d: d.kind) for d in list(group)[:few]]


def cells(difference: Difference, width: int = WIDTH) -> tuple[str, ...]:
    """Return row, column, both values and the relative difference as short texts."""
    relative = "" if math.isnan(difference.relative) else f"{difference.relative:.1e}"
    what = difference.column or difference.kind
    texts = (difference.row, what, difference.reference, difference.found, relative)
    return tuple(text if len(text) <= width else text[: width - 1] + "…" for text in texts)


def markdown(
    differences: Iterable[Difference],
    few: int = WORST,
    *,
    names: tuple[str, str] = ("reference", "found"),
) -> str:
    """Return the differences as Markdown: a heading per file, and a table of the worst.

    `differences`: of one file or of many; `few`: how many of each kind are shown per file; `names`:
    what the two sides are called.
    """
    sections = []
    for file, found in by_file(differences).items():
        shown = [d for d in worst(found, few) if not d.kind.endswith("file")]
        lines = [f"### {file}: {summary(found)}"]
        if shown:
            lines += ["", *_table([(*_COLUMNS[:2], *names, _COLUMNS[4]), *map(cells, shown)])]
        left = len(found) - len(shown)
        if shown and left:
            lines += ["", f"and {left} more"]
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
