"""The account of a run at its end: files made, verdicts, and the page to open."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

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
    files = f": {_listed(made)}" if made else " nothing was made anew"
    lines = [f"In {results}{files}."]
    tables = [results / name for name in made if name.startswith(("tables/", "data/"))]
    lines += dict.fromkeys(f"Not computed: {why}." for path in tables for why in _problems(path))
    if "report/index.html" in made:
        lines += [
            f"{words}: {counts}."
            for name, words in (("claims", "Claims of the article"), ("equations", "Its equations"))
            if (counts := _verdicts(results / f"tables/{name}.csv"))
        ]
    if outdated:
        number = f"{len(outdated)} results" if len(outdated) > 1 else outdated[0]
        lines.append(
            f"Made earlier, from other inputs: {number}. Without a target, all is renewed."
        )
    page = results / "report/index.html"
    if page.is_file():
        lines.append(f"Open {page}")
    return "\n".join(lines)


def _problems(table: Path) -> Iterator[str]:
    """Yield why a table, or rows of it, could not be computed."""
    if not table.is_file():
        return
    with table.open(encoding="utf-8", newline="") as file:
        rows = csv.DictReader(file)
        names = {NOT_COMPUTED, "problem"} & {*(rows.fieldnames or ())}
        if names:
            yield from (row[name] for row in rows for name in names if row[name])


def _listed(made: Sequence[str]) -> str:
    """Return the names of results, or their numbers by kind if they are many."""
    shown = [n for n in made if not n.startswith("figures/") or n.endswith(".svg")]
    if len(shown) <= FEW:
        return ", ".join(shown)
    figures = [name for name in shown if name.startswith("figures/")]
    counts = Counter(name.partition("/")[0] for name in shown)
    parts = figures if len(figures) <= FEW else [f"{len(figures)} figures"]
    for key, words in {"data": " of figure data", "tables": ""}.items():
        if counts[key]:
            parts.append(f"{counts[key]} table{'s' if counts[key] > 1 else ''}{words}")
    return ", ".join(parts)


def _verdicts(ledger: Path) -> str:
    """Return how often each verdict stands in a ledger, the most frequent first."""
    if not ledger.is_file():
        return ""
    with ledger.open(encoding="utf-8", newline="") as file:
        counts = Counter(row["verdict"] for row in csv.DictReader(file))
    return ", ".join(f"{count} {verdict}" for verdict, count in counts.most_common())
