"""`make` keeps a working environment until it has a better one."""

from __future__ import annotations

import os
import shutil
import sys

import pytest
from tests.shared import ROOT, execute

PYTHON = f"PYTHON={sys.executable}"


@pytest.fixture
def clone(tmp_path):
    """A folder with the Makefile and an environment that passes for a finished one."""
    clone = tmp_path / "clone"
    shutil.copytree(ROOT / "requirements", clone / "requirements")
    for name in ("Makefile", "pyproject.toml"):
        shutil.copy2(ROOT / name, clone)
    (clone / ".venv/bin").mkdir(parents=True)
    (clone / ".venv/.origin").write_text(f"{clone.resolve()}\npython3\n")
    for name in (".environment", "bin/uv", ".run"):
        (clone / ".venv" / name).touch()
    return clone


def make(folder, *arguments, **environment):
    # As a shell in that folder would call it.
    environment = {**os.environ, "PWD": str(folder), **environment}
    return execute("make", *arguments, ".venv/.run", cwd=folder, env=environment, check=False)


def test_what_cannot_be_installed_leaves_the_old_environment(clone):
    (clone / ".venv/bin/old").touch()
    done = make(clone, PYTHON, "UV=", PIP_NO_INDEX="1", PIP_FIND_LINKS="")
    assert done.returncode
    assert "make: not installed" in done.stderr
    assert (clone / ".venv/bin/old").exists()
    assert not (clone / ".venv-before").exists()
