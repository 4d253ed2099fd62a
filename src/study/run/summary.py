"""The account of a run at its end: files made, verdicts, and the page to open."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from study.judge.counts import verdicts
from study.tables import NOT_COMPUTED

# Files that are named; of more only their number is told.
FEW = 6


def summary(results: Path, made: Sequence[str], outdated: Sequence[str] = ()) -> str:
    """Return a few lines on a run.

    Parameters
    ----------
    results
        Results root.
    made
        Files made by the run, relative to the root.
    outdated
        Files left by an earlier run with other inputs.

    Returns
    -------
    str
        One line each on files, what could not be computed, verdicts of a full run, outdated files,
        and the page to open.
    """
    shown = [n for n in made if not n.startswith("figures/") or n.endswith(".svg")]
    if len(shown) > FEW:
        figures = [name for name in shown if name.startswith("figures/")]
        others = [name for name in shown if name.startswith(("data/", "tables/"))]
        counts = Counter(name.partition("/")[0] for name in others + figures * (len(figures) > FEW))
        shown = figures * (len(figures) <= FEW)
        shown += [f"{count} in {folder}/" for folder, count in sorted(counts.items())]
    lines = [f"In {results}: {', '.join(shown) or 'nothing was made anew'}."]
    tables = [results / name for name in made if name.startswith(("tables/", "data/"))]
    reasons = (why for table in tables for why in _cells(table, NOT_COMPUTED, "problem"))
    lines += dict.fromkeys(f"Not computed: {why}." for why in reasons)
    if "report/index.html" in made:
        for name, words in (("claims", "Claims of the article"), ("equations", "Its equations")):
            judged = verdicts(_cells(results / f"tables/{name}.csv", "verdict"))
            numbers = ", ".join(f"{count} {verdict}" for verdict, count in judged.items())
            lines += [f"{words}: {numbers}."] if numbers else []
    if outdated:
        number = f"{len(outdated)} results" if len(outdated) > 1 else outdated[0]
        lines.append(
            f"Made earlier, from other inputs: {number}. Without a target, all is renewed."
        )
    if (page := results / "report/index.html").is_file():
        lines.append(f"Open {page}")
    return "\n".join(lines)


def _cells(table: Path, *columns: str) -> Iterator[str]:
    """Yield the cells in some columns that are not empty, none if there is no such table."""
    if table.is_file():
        with table.open(encoding="utf-8", newline="") as file:
            rows = csv.DictReader(file)
            if names := {*columns} & {*(rows.fieldnames or ())}:
                yield from (row[name] for row in rows for name in names if row[name])
