"""The account of a run at its end: files made, verdicts, and the page to open."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from study.judge.counts import verdicts
from study.tables import NOT_COMPUTED, text_rows

# Files that are named; of more only their number is told.
FEW = 6


def summary(results: Path, made: Sequence[str] = ()) -> str:
    """Return a few lines on a run, or on the results that stand.

    Parameters
    ----------
    results
        Results root.
    made
        Files made by the run, relative to the root; none if all was up to date.

    Returns
    -------
    str
        One line each on files, what could not be computed, and of a full run verdicts and the page
        to open.
    """
    stands = sorted(path.relative_to(results).as_posix() for path in results.glob("*/*"))
    names = made or [name for name in stands if (results / name).is_file()]
    shown = [n for n in names if not n.startswith("figures/") or n.endswith(".svg")]
    if len(shown) > FEW:
        figures = [name for name in shown if name.startswith("figures/")]
        others = [name for name in shown if name.startswith(("data/", "tables/"))]
        counts = Counter(name.partition("/")[0] for name in others + figures * (len(figures) > FEW))
        shown = figures * (len(figures) <= FEW)
        shown += [f"{count} in {folder}/" for folder, count in sorted(counts.items())]
    lines = [f"In {results}: {', '.join(shown) or 'nothing'}."]
    tables = [results / name for name in names if name.startswith(("tables/", "data/"))]
    reasons = (why for table in tables for why in _cells(table, NOT_COMPUTED, "problem"))
    lines += dict.fromkeys(f"Not computed: {why}." for why in reasons)
    if (page := results / "report/index.html").is_file():
        for name, words in (("claims", "Claims of the article"), ("equations", "Its equations")):
            judged = verdicts(_cells(results / f"tables/{name}.csv", "verdict"))
            numbers = ", ".join(f"{count} {verdict}" for verdict, count in judged.items())
            lines += [f"{words}: {numbers}."] if numbers else []
        lines.append(f"Open {page}")
    return "\n".join(lines)


def _cells(table: Path, *columns: str) -> Iterator[str]:
    """Yield the cells in some columns that are not empty, none if there is no such table."""
    yield from (row[name] for row in text_rows(table) for name in columns if row.get(name))
