"""Every code block of the documentation is what it says: quoted, valid, or run."""

from __future__ import annotations

import re

import pytest
from tests.docs.blocks import PAGES, ROOT, blocks

TEXTS = {page: (ROOT / page).read_text(encoding="utf-8") for page in PAGES}
# docs/python.md runs where only the physics is installed: tests/test_imports.py.
WITH_PYTHON = sorted({block.page for block in blocks("python")} - {"docs/python.md"})


@pytest.mark.parametrize("block", blocks("quoted"), ids=str)
def test_a_quotation_stands_in_its_file(block):
    assert block.text.strip()
    assert block.text in (ROOT / block.path).read_text(encoding="utf-8")


@pytest.mark.parametrize("page", WITH_PYTHON)
def test_python_runs_block_after_block(page, made, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {"__name__": "__main__"}
    for block in blocks("python"):
        if block.page == page:
            exec(compile("\n" * block.line + block.text, page, "exec"), names)


@pytest.mark.parametrize("page", PAGES)
def test_files_that_are_named_exist(page):
    named = re.findall(r"`((?:src|config|workflow|tests|docs|\.ci)/[\w/.-]+)`", TEXTS[page])
    made = {block.path for block in blocks("written")}
    assert not [path for path in named if path not in made and not (ROOT / path).exists()]


@pytest.mark.parametrize("page", PAGES)
def test_code_stands_in_fences(page):
    """An indented block would be seen by no test."""
    without = re.sub(r"(?ms)^( *)```.*?^\1```$", "", TEXTS[page])
    assert not re.findall(r"\n\n(?: {4}|\t)\S.*", without)


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)]+)\)", TEXTS[page]):
        path, _, anchor = target.partition("#")
        if "://" in path:
            continue
        place = (ROOT / page).parent / path if path else ROOT / page
        assert place.exists(), target
        if anchor:
            heads = re.findall(r"^#+ (.+)$", place.read_text(encoding="utf-8"), flags=re.MULTILINE)
            assert anchor in {
                re.sub(r"[^\w -]", "", h).strip().lower().replace(" ", "-") for h in heads
            }
