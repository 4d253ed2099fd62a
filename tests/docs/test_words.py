"""Prose keeps British spelling and the field's terms; names and first lines say their content."""

from __future__ import annotations

import ast
import re
from collections import Counter

import pytest
from tests.docs.blocks import ROOT
from tests.shared import execute

# American spelling, and everyday words in place of technical terms; names of libraries' own
# parameters and options are not among them.
FORBIDDEN = re.compile(
    r"analyz(?!e\.sobol|e$)\w*(?<!analyze)|digitiz\w*|behavior\w*|favor\w*|modeling|labeled"
    r"|travel(?:ed|ing)|aluminum|sulfur|droplet\w*|doomed|hopeless\w*|\bmended\b"
    r"|(?<!de)couples?\b|film run",
    re.IGNORECASE,
)
# In words alone: in code these belong to other programs.
IN_PROSE = re.compile(r"\b(?:colors?|centers?|per cent|neighbors?)\b", re.IGNORECASE)
# Words and syntax at which a native reader of English stumbles.
UNIDIOMATIC = re.compile(
    r"\badmit(?:s|ted)?\b|\banew\b|\bof (?:its|their|your|one's) own\b|\btold\b|\bhanded\b"
    r"|\bstands? beside\b|\bWho (?:changes|wants|needs|uses|breaks|starts)\b"
)
# This file lists what is forbidden; a library has an American name.
EXEMPT = {"tests/docs/test_words.py", "tests/study/studies/test_sensitivity.py"}
KINDS = {".py", ".md", ".yaml", ".smk", ".html", ".js", ".rst", ".jinja", ".toml"}


def written():
    listed = execute("git", "ls-files", cwd=ROOT, check=False)
    paths = (ROOT / name for name in listed.stdout.splitlines())
    return [
        path
        for path in paths
        if path.suffix in KINDS
        and path.is_file()
        and str(path.relative_to(ROOT)) not in EXEMPT
        and "tests/reference" not in str(path)
    ]


def found(rule, paths):
    return [
        f"{path.relative_to(ROOT)}:{number}: {match[0]}"
        for path in paths
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        for match in rule.finditer(line)
    ]


def test_no_file_has_a_forbidden_word():
    paths = written()
    if not paths:
        pytest.skip("no git checkout")
    assert not found(FORBIDDEN, paths)


def test_pages_are_in_british_spelling():
    pages = [path for path in written() if path.suffix in {".md", ".rst", ".jinja"}]
    assert not found(IN_PROSE, pages)


def test_prose_is_idiomatic():
    prose = {"config/figures.yaml", "config/claims.yaml"}
    paths = [
        path
        for path in written()
        if path.suffix in {".md", ".rst", ".jinja", ".html"} or str(path.relative_to(ROOT)) in prose
    ]
    assert not found(UNIDIOMATIC, paths)


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
