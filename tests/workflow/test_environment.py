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
    (clone / "src").mkdir()
    for name in (".environment", "bin/uv", ".run"):
        (clone / ".venv" / name).touch()
    return clone


def make(folder, *arguments, **environment):
    # As a shell in that folder would call it.
    environment = {**os.environ, "PWD": str(folder), **environment}
    return execute("make", *arguments, cwd=folder, env=environment, check=False)


def test_what_cannot_be_installed_leaves_the_old_environment(clone):
    (clone / ".venv/bin/old").touch()
    done = make(clone, PYTHON, "UV=", ".venv/.run", PIP_NO_INDEX="1", PIP_FIND_LINKS="")
    assert done.returncode
    assert "make: not installed" in done.stderr
    assert (clone / ".venv/bin/old").exists()
    assert not (clone / ".venv-before").exists()


@pytest.mark.parametrize(
    ("name", "environment", "told"),
    [
        ("a b", {}, "No job can start in"),
        ("l'essai", {}, "No job can start in"),
        ("Maße", {"LC_ALL": "C"}, "set LC_ALL=C.UTF-8"),
        ("Maße", {"LC_ALL": "C.UTF-8"}, ""),
        ("clone", {"HOME": "/dev/null", "XDG_CACHE_HOME": ""}, "XDG_CACHE_HOME="),
        ("clone", {"HOME": "/dev/null"}, ""),
    ],
)
def test_what_would_fail_in_every_job_is_told_at_once(clone, tmp_path, name, environment, told):
    place = {"XDG_CACHE_HOME": str(tmp_path / "cache")}
    done = make(clone.rename(tmp_path / name), "help", **place | environment)
    assert bool(done.returncode) == bool(told)
    assert told in done.stderr
    assert len(done.stderr.splitlines()) == bool(told)
