"""Pictures of the pages, small, from a finished run: ``python docs/gallery.py results``."""

from __future__ import annotations

import re
import sys
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).parent
WIDTH = 900
COLOURS = 256


def shown(text: str) -> list[str]:
    """Return the names of the figures that a text shows from ``docs/images``."""
    return re.findall(r"images/(\w+)\.png", text)


def shrink(source: Path, target: Path) -> None:
    """Write a picture no wider than `WIDTH`, with a palette of its own."""
    with Image.open(source) as picture:
        small = picture.convert("RGB")
    small.thumbnail((WIDTH, small.height))
    target.parent.mkdir(parents=True, exist_ok=True)
    # By coverage of all colours: the commonest alone would make thin lines grey.
    palette = Image.Quantize.MAXCOVERAGE
    small.quantize(COLOURS, palette).save(target, optimize=True)


def main(results: Path, docs: Path = DOCS) -> int:
    """Renew all pictures of the pages from a results folder, but those of the benchmarks."""
    pages = [docs.parent / "README.md", *sorted(docs.glob("*.md")), *sorted(docs.glob("*.rst"))]
    texts = (page.read_text(encoding="utf-8") for page in pages if page.name != "performance.md")
    for name in dict.fromkeys(name for text in texts for name in shown(text)):
        shrink(results / f"figures/{name}.png", docs / f"images/{name}.png")
    return 0


if __name__ == "__main__":
    sys.exit(main(*map(Path, sys.argv[1:])))
