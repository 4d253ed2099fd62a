"""Pictures of the pages, small, from a finished run: ``python docs/gallery.py results``."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import matplotlib.pyplot as plt
from PIL import Image

from study.figures.style import context
from study.judge.counts import verdicts
from study.tables import text_rows

DOCS = Path(__file__).parent
WIDTH = 900
COLOURS = 256
# What the verdicts on claims come to, with colours that differ in grey, too.
OUTCOMES = {
    "hold": ("reproduced", "reproduced with a correction"),
    "hold by construction": ("calibrated",),
    "cannot be decided": ("not identified", "undecided", "not testable"),
    "do not hold": ("not reproduced",),
}
SHADES = ("#0b6e4f", "#8fc1a9", "#d9d9d9", "#b3261e")


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


def draw_outcomes(results: Path, target: Path) -> None:
    """Draw the verdicts of a run as one bar."""
    given = verdicts(row["verdict"] for row in text_rows(results / "tables/claims.csv"))
    number = {name: sum(given.pop(v, 0) for v in of) for name, of in OUTCOMES.items()}
    if given:
        raise ValueError(f"{results}: no outcome has the verdicts {sorted(given)}")
    with context():
        figure, ax = plt.subplots(figsize=(7.0, 0.75))
        end = 0
        for (name, count), shade in zip(number.items(), SHADES, strict=True):
            ax.barh(0, count, left=end, color=shade, height=1.0)
            dark = shade in SHADES[::3]
            ax.text(end + count / 2, 0, str(count), ha="center", va="center",
                    color="white" if dark else "black", fontsize=13)  # fmt: skip
            ax.text(end + count / 2, -0.65, name, ha="center", va="top", fontsize=9)
            end += count
        ax.set(xlim=(0, end), ylim=(-1.2, 0.5))
        ax.set_axis_off()
        figure.savefig(target, metadata={"Date": None})
    plt.close(figure)


def main(results: Path, docs: Path = DOCS) -> int:
    """Renew all pictures of the pages from a results folder, but those of the benchmarks."""
    pages = [docs.parent / "README.md", *sorted(docs.glob("*.md"))]
    texts = (page.read_text(encoding="utf-8") for page in pages if page.name != "performance.md")
    draw_outcomes(results, docs / "images/outcomes.svg")
    for name in dict.fromkeys(name for text in texts for name in shown(text)):
        shrink(results / f"figures/{name}.png", docs / f"images/{name}.png")
    return 0


if __name__ == "__main__":
    sys.exit(main(*map(Path, sys.argv[1:])))
