"""The report of a run as a static site: pages that need no network and no server."""

import shutil
from pathlib import Path

PAGES = ("index", "figures", "claims", "equations", "tables", "run", "glossary")
# Made anew each time: pages of figures, copies of results and of code.
FOLDERS = ("figures", "files")


def remove(report: Path) -> None:
    """Remove the pages of a report that shows other results than there are; the explorer stays."""
    for name in (*(f"{page}.html" for page in PAGES), "record.json"):
        (report / name).unlink(missing_ok=True)
    for folder in FOLDERS:
        shutil.rmtree(report / folder, ignore_errors=True)
