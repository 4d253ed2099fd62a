"""The report of a run as a static site: pages that need no network and no server."""

import shutil
from pathlib import Path

PAGES = ("index", "figures", "claims", "equations", "tables", "run", "glossary")


def remove(report: Path) -> None:
    """Remove the pages of a report that shows results of other inputs; the explorer stays."""
    for name in (*(f"{page}.html" for page in PAGES), "record.json"):
        (report / name).unlink(missing_ok=True)
    shutil.rmtree(report / "figures", ignore_errors=True)
