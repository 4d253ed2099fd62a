"""What a run has made, what did not hold, and which page to open: a few lines at its end."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

# Files that are named; of more only their number is told.
FEW = 6


def summary(results: Path, made: Sequence[str], outdated: Sequence[str] = ()) -> str:
    """Return a few lines on a run.

    `results`: results root; `made`: results that the run has made, by their names below the root;
    `outdated`: results that stand there from an earlier run with other inputs.
    """
    lines = [f"In {results}: {_told(made)}."] if made else [f"In {results} nothing was made anew."]
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


def _told(made: Sequence[str]) -> str:
    shown = [n for n in made if not n.startswith("figures/") or n.endswith(".svg")]
    if len(shown) <= FEW:
        return ", ".join(shown)
    figures = [name for name in shown if name.startswith("figures/")]
    counts = Counter(name.partition("/")[0] for name in shown)
    told = figures if len(figures) <= FEW else [f"{len(figures)} figures"]
    for key, words in {"data": " of figure data", "tables": ""}.items():
        if counts[key]:
            told.append(f"{counts[key]} table{'s' if counts[key] > 1 else ''}{words}")
    return ", ".join(told)


def _verdicts(ledger: Path) -> str:
    """Return how often each verdict stands in a ledger, the most frequent first."""
    if not ledger.is_file():
        return ""
    with ledger.open(encoding="utf-8", newline="") as file:
        counts = Counter(row["verdict"] for row in csv.DictReader(file))
    return ", ".join(f"{count} {verdict}" for verdict, count in counts.most_common())
