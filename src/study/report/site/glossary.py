"""Terms of the study: each defined once, and linked to it where a page first uses the term."""

from __future__ import annotations

import re
from functools import cache
from html import escape
from pathlib import Path

from study.declared.documents import load
from study.declared.provenance import EVIDENCE
from study.report.site.ledgers import anchor

FILE = Path(__file__).parent / "templates/glossary.yaml"
# Elements whose words stay as they are: links, names, headings and the controls of a form.
LEFT = frozenset(
    (
        *("a", "button", "caption", "code", "h1", "h2", "h3", "label", "legend", "math", "nav"),
        *("pre", "script", "select", "summary", "svg", "th"),
    )
)

# A class of evidence, in a place of its kind alone: some are everyday words.
CLASS = '<span class="evidence">'


@cache
def definitions() -> dict[str, str]:
    """Return the meaning of every term, by name."""
    meanings = {term: entry["means"] for term, entry in load(FILE).items()} | {
        name: f"Of a number: {meaning}." for name, meaning in EVIDENCE.items()
    }
    return dict(sorted(meanings.items(), key=lambda item: item[0].lower()))


@cache
def _forms() -> tuple[dict[str, str], re.Pattern[str]]:
    forms = {
        form.lower(): term for term, entry in load(FILE).items() for form in entry.get("forms", ())
    }
    longest_first = sorted(map(re.escape, forms), key=len, reverse=True)
    return forms, re.compile(rf"\b(?:{'|'.join(longest_first)})\b", re.IGNORECASE)


def marked(page: str, root: str) -> str:
    """Return a page that links each term, where its text first has it, to the definition.

    Parameters
    ----------
    page
        HTML; what is outside ``<main>`` stays.
    root
        Path from the page to the report's folder.
    """
    meanings = definitions()
    forms, pattern = _forms()
    waiting = set(meanings)

    def link(term: str, words: str) -> str:
        waiting.discard(term)
        href, title = f"{root}glossary.html#{anchor('term', term)}", escape(meanings[term])
        return f'<a class="term" href="{href}" title="{title}">{words}</a>'

    def first(match: re.Match[str]) -> str:
        term = forms[match[0].lower()]
        return link(term, match[0]) if term in waiting else match[0]

    head, opening, main = page.partition("<main")
    depth, parts = 0, re.split(r"(<[^>]*>)", main)
    for i, part in enumerate(parts):
        if tag := re.match(r"<(/?)(\w+)", part):
            depth += (-1 if tag[1] else 1) * (tag[2] in LEFT)
        elif parts[i - 1] == CLASS:
            parts[i] = link(part, part) if part in waiting else part
        elif not depth:
            parts[i] = pattern.sub(first, part)
    return head + opening + "".join(parts)
