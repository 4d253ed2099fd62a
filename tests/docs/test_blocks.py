"""Every code block of the documentation is what it says: quoted, valid, or run."""

from __future__ import annotations

import re
from pathlib import PurePosixPath

import pytest
from tests.docs.blocks import MARKERS, PAGES, ROOT, blocks, blocks_of

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


def test_an_analysis_is_shown_in_every_kind_of_file_it_is_made_of():
    quoted = {b.path for b in blocks("quoted") if b.page == "docs/adding-an-analysis.md"}
    assert quoted >= {
        "src/microimpact/model/separation.py",
        "src/study/studies/analyses/particle_separation.py",
        "src/study/figures/analyses/separation.py",
        "config/analyses/analyses.yaml",
        "config/printed_values.csv",
        "config/figures.yaml",
        "workflow/rules/analyses.smk",
        "tests/study/article/test_separation.py",
    }


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


def test_a_file_is_written_inside_the_project():
    for block in blocks("written", "appended"):
        path = PurePosixPath(block.path)
        assert not path.is_absolute()
        assert ".." not in path.parts
    assert not [b for b in blocks("written") if (ROOT / b.path).exists()]
    assert all((ROOT / block.path).exists() for block in blocks("appended"))


def test_markers_say_what_is_done_with_a_block():
    text = "".join(f"{word} `a.txt`:\n\n```text\n{word}\n```\n\n" for word in MARKERS)
    assert [(b.task, b.path) for b in blocks_of("page", text)] == [
        (task, "a.txt") for task in MARKERS.values()
    ]
    text = "So:\n\n```sh\nls\n```\n\n```text\na\n```\n\n- in a list\n\n  ```sh\n  ls\n  ```\n"
    found = blocks_of("page", text)
    tasks = [("command", "ls\n"), ("output", "a\n"), ("command", "ls\n")]
    assert [(b.task, b.text) for b in found] == tasks


@pytest.mark.parametrize("kind", ["", "text", "yaml", "console"])
def test_a_block_without_a_purpose_is_refused(kind):
    with pytest.raises(ValueError, match=r"^page:3: say what a block of"):
        blocks_of("page", f"So:\n\n```{kind}\na: 1\n```\n")
