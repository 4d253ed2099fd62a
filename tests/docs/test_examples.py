"""Examples and notebooks run as they stand, and print or draw."""

from __future__ import annotations

import json
import re

import matplotlib.pyplot as plt
import pytest
from tests.docs.blocks import ROOT

EXAMPLES = sorted((ROOT / "docs/examples").glob("*.py"))
NOTEBOOKS = sorted((ROOT / "docs/notebooks").glob("*.ipynb"))


def code_of(path):
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".py":
        return text
    cells = json.loads(text)["cells"]
    return "\n".join("".join(c["source"]) for c in cells if c["cell_type"] == "code")


@pytest.mark.slow
@pytest.mark.parametrize("path", [*EXAMPLES, *NOTEBOOKS], ids=lambda path: path.name)
def test_an_example_runs(path, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("DISPLAY", raising=False)
    plt.switch_backend("Agg")
    exec(compile(code_of(path), path, "exec"), {"__name__": "__main__"})
    assert plt.get_fignums() or capsys.readouterr().out
    plt.close("all")


def test_the_pages_show_all_examples():
    pages = (ROOT / "docs/python.md").read_text(encoding="utf-8")
    assert len(EXAMPLES) == 10
    assert all(re.search(f"(::|}}) examples/{path.name}\n", pages) for path in EXAMPLES)
