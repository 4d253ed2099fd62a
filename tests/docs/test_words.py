"""Prose keeps British spelling and the field's terms; names and first lines say their content."""

from __future__ import annotations

import ast
import re
from collections import Counter

import pytest
from tests.docs.blocks import ROOT
from tests.shared import execute

# This file lists what is forbidden.
EXEMPT = {"tests/docs/test_words.py"}
CODE = {".py", ".yaml", ".smk", ".js", ".toml"}
PAGES = {".md", ".rst", ".jinja", ".html"}
# Pattern of what is not written, and the kinds of files in which.
RULES = {
    "American spelling": (
        r"(?i)analyz(?!e\.sobol|e$|e\()\w*(?<!analyze)|digitiz|behavior|favor|modeling|labeled|aluminum",
        CODE | PAGES,
    ),
    "American spelling, in code a name of other programs": (
        r"(?i)\b(?:colors?|centers?|neighbors?)\b",
        PAGES - {".html"},
    ),
    "no idiom of English": (
        r"\badmit(?:s|ted)?\b|\banew\b|\bof (?:its|their|your|one's) own\b|\btold\b|\bhanded\b",
        PAGES,
    ),
}


def written(kinds):
    listed = execute("git", "ls-files", cwd=ROOT, check=False).stdout.splitlines()
    names = [n for n in listed if n not in EXEMPT and not n.startswith("tests/reference")]
    return [ROOT / n for n in names if (ROOT / n).suffix in kinds and (ROOT / n).is_file()]


@pytest.mark.parametrize(("pattern", "kinds"), RULES.values(), ids=RULES)
def test_words(pattern, kinds):
    paths = written(kinds)
    if not paths:
        pytest.skip("no git checkout")
    assert not [
        f"{path.relative_to(ROOT)}:{number}: {match[0]}"
        for path in paths
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        for match in re.finditer(pattern, line)
    ]


# A variable is a noun for its content, and a first line names a quantity or an action.
EMPTY_NAMES = {"found", "own", "told", "one", "other", "of", "given", "some", "place"}
EMPTY_WORDS = re.compile(r"\b(?:what|that of|told)\b", re.IGNORECASE)
COMPREHENSIONS = (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)
DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def empty_words(text):
    """Return variables and first lines of docstrings that do not name their content, by line."""
    nodes = list(ast.walk(ast.parse(text)))
    loops = [c for node in nodes if isinstance(node, COMPREHENSIONS) for c in node.generators]
    exempt = {id(name) for loop in loops for name in ast.walk(loop.target)}
    for node in nodes:
        is_set = isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
        name = node.id if is_set else node.arg if isinstance(node, ast.arg) else ""
        if name in EMPTY_NAMES and id(node) not in exempt:
            yield f"{node.lineno}: {name}"
        first = (ast.get_docstring(node) or "" if isinstance(node, DOCUMENTED) else "").split("\n")[
            0
        ]
        if EMPTY_WORDS.search(first):
            yield f"{getattr(node, 'lineno', 1)}: {first}"


def test_names_and_first_lines_of_docstrings_say_their_content():
    paths = [*(ROOT / "src").rglob("*.py")]
    packages = Counter(path.relative_to(ROOT / "src").parts[0] for path in paths)
    assert min(packages["microimpact"], packages["study"]) > 50
    assert not [
        f"{path.relative_to(ROOT)}:{line}"
        for path in paths
        for line in empty_words(path.read_text(encoding="utf-8"))
    ]
