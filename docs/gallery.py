"""Pictures of README.md, small, from a finished run: ``python docs/gallery.py results``."""

from __future__ import annotations

import re
import sys
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).parent
WIDTH = 900
COLOURS = 64


def shown(readme: str) -> list[str]:
    """Return the names of the figures that a text shows from ``docs/images``."""
    return re.findall(r"docs/images/(\w+)\.png", readme)


def shrink(source: Path, target: Path) -> None:
    """Write a picture no wider than `WIDTH`, with a palette of its own."""
    with Image.open(source) as picture:
        small = picture.convert("RGB")
    small.thumbnail((WIDTH, small.height))
    target.parent.mkdir(parents=True, exist_ok=True)
    small.quantize(COLOURS).save(target, optimize=True)


def main(results: Path, docs: Path = DOCS) -> int:
    """Renew all pictures of the README from a results folder."""
    for name in shown((docs.parent / "README.md").read_text(encoding="utf-8")):
        shrink(results / f"figures/{name}.png", docs / f"images/{name}.png")
    return 0


if __name__ == "__main__":
    sys.exit(main(*map(Path, sys.argv[1:])))
