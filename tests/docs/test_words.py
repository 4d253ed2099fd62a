"""Prose keeps British spelling and the field's terms."""

from __future__ import annotations

import re

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
# This file lists what is forbidden; a library has an American name.
EXEMPT = {"tests/docs/test_words.py", "tests/studies/test_sensitivity.py"}
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


@pytest.mark.parametrize("word", ["analyzer", "Digitized", "a couple of", "HOPELESS_GROUP"])
def test_the_rule_finds_a_forbidden_word(word):
    assert FORBIDDEN.search(word)


@pytest.mark.parametrize("word", ["analyser", "decoupled", "digitised", "from SALib.analyze.sobol"])
def test_the_rule_leaves_good_words(word):
    assert not FORBIDDEN.search(word)
