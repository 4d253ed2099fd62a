"""A program that is forked does what it does when it is started."""

from __future__ import annotations

import subprocess
import sys

import pytest

pytestmark = pytest.mark.workflow

PROGRAM = """
import os, sys
print(__name__, sys.argv[1:], os.getcwd(), os.environ["OWN"], "microimpact" in sys.modules)
print(sys.stdin.read(), file=sys.stderr)
if "raise" in sys.argv:
    raise ValueError("said so")
import beside
sys.exit(beside.CODE)
"""


@pytest.mark.parametrize("argument", ["return", "raise"])
def test_a_fork_is_told_from_a_start_by_time_alone(forked, tmp_path, argument):
    (tmp_path / "here").mkdir()
    (tmp_path / "there").mkdir()
    (tmp_path / "here/program.py").write_text(PROGRAM)
    (tmp_path / "there/beside.py").write_text("CODE = 7")

    def told(*python):
        done = subprocess.run(
            [*python, "-m", "program", "a b", argument],
            cwd=tmp_path / "here",
            env={"OWN": "ß", "PYTHONPATH": str(tmp_path / "there")},
            input="typed",
            capture_output=True,
            encoding="utf-8",
            check=False,
        )
        said = done.stderr.splitlines()
        return done.returncode, done.stdout, said[0], said[-1]

    started = told(sys.executable)
    assert told(*forked) == started
    code, _, first, last = started
    assert (code, first) == ((7 if argument == "return" else 1), "typed")
    assert argument == "return" or last == "ValueError: said so"
