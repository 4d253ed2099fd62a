"""What a run has built and where: ``python -m microimpact.run.summary results``."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from microimpact.figures.registry import FigureSpec, registry
from microimpact.run.config import load

FOLDERS = ("figures", "data", "tables", "report")


def built(results: Path) -> dict[str, list[Path]]:
    """Return the files under a results root by the name they share, figures first."""
    found: dict[str, list[Path]] = {}
    for folder in FOLDERS:
        for path in sorted((results / folder).glob("*")):
            if path.is_file() and not path.name.startswith("."):
                found.setdefault(path.stem, []).append(path)
    return found


def size(count: int) -> str:
    """Return a number of bytes in readable form."""
    for unit in ("B", "kB"):
        if count < 1000:
            return f"{count:.0f} {unit}"
        count = round(count / 1000)
    return f"{count} MB"


def summary(results: Path, figures: Mapping[str, FigureSpec]) -> Table:
    """Return a table of what stands under a results root.

    Raises
    ------
    FileNotFoundError
        If nothing was built there.
    """
    found = built(results)
    if not found:
        raise FileNotFoundError(f"nothing was built in {results}")
    table = Table(title=f"Built in {results}", title_justify="left")
    table.add_column("name", no_wrap=True)
    table.add_column("what")
    table.add_column("files", no_wrap=True)
    table.add_column("size", justify="right", no_wrap=True)
    for name, paths in found.items():
        title = figures[name].title if name in figures else name.replace("_", " ")
        files = "\n".join(str(path.relative_to(results)) for path in paths)
        table.add_row(name, title, files, size(sum(path.stat().st_size for path in paths)))
        if name in figures:
            table.add_section()
    return table


def _stamp_line(results: Path) -> str:
    path = results / "run.json"
    if not path.exists():
        return ""
    stamp: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    commit = stamp["git"]["commit"] or "no commit"
    changed = ", with changes" if stamp["git"]["dirty"] else ""
    return f"Run of {stamp['ended']} ({commit[:12]}{changed}); its stamp is {path}"


def main(arguments: Sequence[str] | None = None) -> int:
    """Print what was built."""
    parser = argparse.ArgumentParser(
        prog="python -m microimpact.run.summary", description=main.__doc__
    )
    parser.add_argument("results", type=Path, nargs="?", default=Path("results"))
    parser.add_argument("--figures", type=Path, default=Path("config/figures.yaml"))
    given = parser.parse_args(arguments)
    console = Console()
    try:
        figures = registry(load(given.figures)) if given.figures.exists() else {}
        console.print(summary(given.results, figures))
    except (FileNotFoundError, ValueError) as error:
        console.print(f"error: {error}", style="red", soft_wrap=True)
        return 1
    console.print(_stamp_line(given.results), soft_wrap=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
