"""Differences in words: counts per file and the few worst of each kind, as Markdown."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import groupby
from os.path import commonprefix

from study.report.check.differences import KINDS, Difference

HEADER = ("row", "column", "reference", "result", "relative")
# Differences of each kind that are shown per file.
FEW = 5
# Characters of a cell; the name of a row is never cut.
WIDTH = 60


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


def worst(differences: Sequence[Difference], few: int = FEW) -> list[Difference]:
    """Return a few differences of every kind; of numbers those largest beside their column."""
    ranked = sorted(
        differences,
        key=lambda d: (KINDS.index(d.kind), -(0.0 if math.isnan(d.share) else d.share)),
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
    cut = (f"{'…' * (start > 0)}{shortened(text[start:], width)}" for text in texts)
    return (difference.row, difference.column or difference.kind, *cut, relative)


def shortened(text: str, width: int) -> str:
    """Return a text of at most so many characters."""
    return text if len(text) <= width else f"{text[: width - 1]}…"


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
