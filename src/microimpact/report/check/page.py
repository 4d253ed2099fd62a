"""The comparison of two runs as one HTML page that needs nothing else, figures side by side."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, tostring

from microimpact.report.check.compare import SAME, SIDES, Changes, lone_files, sections
from microimpact.report.check.differences import Difference
from microimpact.report.check.wording import by_file, cells, summary, worst

STYLE = """
:root { color-scheme: light dark; --line: #8886; --soft: #8882; }
body { font: 15px/1.45 system-ui, sans-serif; margin: 1.5rem auto; max-width: 76rem; }
body { padding: 0 1rem; }
h1 { font-size: 1.4rem; } h2 { font-size: 1.15rem; margin-top: 2rem; } h3 { font-size: 1rem; }
code { overflow-wrap: anywhere; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: 0.87rem; }
th, td { border-bottom: 1px solid var(--line); padding: 0.2rem 0.7rem 0.2rem 0; text-align: left; }
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(22rem, 1fr)); gap: 1rem; }
figure { background: var(--soft); border-radius: 6px; margin: 0; padding: 0.5rem; }
figcaption { padding-bottom: 0.3rem; }
img { background: white; display: block; width: 100%; }
"""

WIDTH = 120


def page(changes: Changes, few: int = 20) -> str:
    """Return the page.

    Parameters
    ----------
    changes
        What `compare` found.
    few
        How many differences of each kind are shown per table of numbers.
    """
    html = Element("html", lang="en")
    head = SubElement(html, "head")
    SubElement(head, "meta", charset="utf-8")
    SubElement(head, "meta", name="viewport", content="width=device-width, initial-scale=1")
    _text(head, "title", f"{changes.baseline} and {changes.changed}")
    _text(head, "style", STYLE)
    body = SubElement(html, "body")
    _text(body, "h1", "Two runs compared")
    for side, root in zip(SIDES, (changes.baseline, changes.changed), strict=True):
        line = _text(body, "p", f"{side}: ")
        _text(line, "code", str(root))
    for root, names in lone_files(changes):
        _text(body, "p", f"{len(names)} files were not built in {root}.")
    if changes.same:
        _text(body, "p", SAME)
    for title, found, shown in sections(changes, few):
        if found:
            _text(body, "h2", title)
            for file, differences in by_file(found).items():
                _text(body, "h3", f"{file}: {summary(differences)}")
                _table(body, differences, shown)
            if title == "Inputs" and changes.resting:
                _text(body, "p", f"Figures that rest on them: {', '.join(changes.resting)}.")
    _figures(body, changes)
    return "<!DOCTYPE html>\n" + tostring(html, encoding="unicode", method="html") + "\n"


def _text(parent: Element, tag: str, text: str) -> Element:
    element = SubElement(parent, tag)
    element.text = text
    return element


def _table(parent: Element, differences: Sequence[Difference], few: int) -> None:
    shown = [d for d in worst(differences, few) if not d.kind.endswith("file")]
    if not shown:
        return
    table = SubElement(SubElement(parent, "div", {"class": "wide"}), "table")
    header = SubElement(SubElement(table, "thead"), "tr")
    for name in ("row", "column", *SIDES, "relative"):
        _text(header, "th", name)
    body = SubElement(table, "tbody")
    for difference in shown:
        row = SubElement(body, "tr")
        for cell in cells(difference, WIDTH):
            _text(row, "td", cell)
    if len(shown) < len(differences):
        _text(parent, "p", f"and {len(differences) - len(shown)} more")


def _figures(body: Element, changes: Changes) -> None:
    if changes.figures:
        _text(body, "h2", "Figures")
    for figure in changes.figures:
        _text(body, "h3", f"{figure.name}: {figure.what}")
        pair = SubElement(body, "div", {"class": "pair"})
        for side, path in zip(SIDES, (figure.baseline, figure.changed), strict=True):
            card = SubElement(pair, "figure")
            _text(card, "figcaption", side)
            SubElement(card, "img", src=_inline(path), alt=f"{figure.name}, {side}")
    if changes.unchanged_figures:
        _text(body, "p", f"Unchanged figures: {', '.join(changes.unchanged_figures)}")


def _inline(svg: Path) -> str:
    # As an image, and not as part of the page: no script in it runs, no name in it clashes.
    return "data:image/svg+xml;base64," + base64.b64encode(svg.read_bytes()).decode("ascii")
