"""Code blocks of the documentation, and what the words before a block say is to be done with it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

ROOT = Path(__file__).parents[2]
PAGES = (
    "README.md",
    "config/README.md",
    *sorted(f"docs/{path.name}" for path in (ROOT / "docs").glob("*.md")),
)

Task = Literal["quoted", "written", "appended", "python", "command", "output"]
# The end of the paragraph before a block: a file that it quotes, is written into or is added to.
MARKERS: dict[str, Task] = {"From": "quoted", "Create": "written", "Add to": "appended"}

_MARKER = re.compile(r"(From|Create|Add to)\s+`([^`\s]+)`:$")
_FENCE = re.compile(r"(?ms)^(?P<indent> *)```(?P<kind>\w*|\{[^\n]*)\n(?P<text>.*?)^(?P=indent)```$")


@dataclass(frozen=True, slots=True)
class Block:
    """A code block: where it stands, its language and text, what is to be done with which file."""

    page: str
    line: int
    kind: str
    text: str
    task: Task
    path: str = ""

    def __str__(self) -> str:
        return f"{self.page}:{self.line}"


def blocks_of(page: str, text: str) -> list[Block]:
    """Return the blocks of a page in their order.

    Directives show examples, which ``test_examples`` runs. Without a marker, ``python`` and ``sh``
    are run, and ``text`` right after ``sh`` is what the command prints. Anything else is refused,
    so that no block goes untested.
    """
    found: list[Block] = []
    end = 0
    for match in _FENCE.finditer(text):
        before = text[end : match.start()].rstrip()
        line = text.count("\n", 0, match.start()) + 1
        kind, marker = match["kind"], _MARKER.search(before)
        end = match.end()
        if kind.startswith("{"):  # an example, which has a test
            continue
        # In a list a block stands to the right, with all of its lines.
        content = re.sub(f"(?m)^{match['indent']}", "", match["text"])
        if marker:
            task, path = MARKERS[marker[1]], marker[2]
        elif kind == "text" and not before and found and found[-1].task == "command":
            task, path = "output", ""
        elif kind in {"python", "sh"}:
            task, path = ("python" if kind == "python" else "command"), ""
        else:
            raise ValueError(f"{page}:{line}: say what a block of {kind or 'no language'} is for")
        found.append(Block(page, line, kind, content, task, path))
    return found


def blocks(*tasks: Task) -> list[Block]:
    """Return the blocks of all pages that have one of these tasks."""
    pages = ((page, (ROOT / page).read_text(encoding="utf-8")) for page in PAGES)
    return [block for page, text in pages for block in blocks_of(page, text) if block.task in tasks]
