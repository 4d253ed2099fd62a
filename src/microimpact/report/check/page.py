"""The comparison of two runs as one HTML page that needs nothing else, figures side by side."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from pathlib import Path

from microimpact.report.check.compare import SAME, SIDES, Changes, lone_files, sections
from microimpact.report.check.differences import Difference
from microimpact.report.check.wording import by_file, cells, summary, worst
from microimpact.report.site.pages import render

WIDTH = 120


def page(changes: Changes, few: int = 20) -> str:
    """Return the page.

    `changes`: what `compare` found; `few`: how many differences of each kind are shown per table of
    numbers.
    """
    return render(
        "compare.html",
        templates=Path(__file__).parent / "templates",
        changes=changes,
        sides=SIDES,
        same=SAME,
        lone_files=lone_files(changes),
        sections=[
            (title, [(file, *_table(each, shown)) for file, each in by_file(found).items()])
            for title, found, shown in sections(changes, few)
            if found
        ],
        inline=_inline,
    )


def _table(differences: Sequence[Difference], few: int) -> tuple[str, list[tuple[str, ...]], int]:
    """Return what is said of one file, its rows, and how many are not shown."""
    shown = [d for d in worst(differences, few) if not d.kind.endswith("file")]
    rows = [cells(difference, WIDTH) for difference in shown]
    return summary(differences), rows, len(differences) - len(shown)


def _inline(svg: Path) -> str:
    # As an image, and not as part of the page: no script in it runs, no name in it clashes.
    return "data:image/svg+xml;base64," + base64.b64encode(svg.read_bytes()).decode("ascii")
