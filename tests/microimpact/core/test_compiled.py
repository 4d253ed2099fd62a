"""Compilation is announced once a process, and only the first time on a machine."""

from __future__ import annotations

import sys

from tests.shared import execute

MODULE = """
from microimpact.core.compiled import jit

@jit()
def twice(x):
    return 2.0 * x

print(twice(2.0))
"""


def test_the_first_compilation_says_so_and_the_next_does_not(tmp_path):
    (tmp_path / "module.py").write_text(MODULE)
    runs = [execute(sys.executable, tmp_path / "module.py") for _ in range(2)]
    assert [run.stdout for run in runs] == ["4.0\n", "4.0\n"]
    assert "warm-up" in runs[0].stderr
    assert runs[0].stderr.count("\n") == 1
    assert not runs[1].stderr
