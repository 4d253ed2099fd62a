"""One undisturbed run, which every disturbed one must equal."""

from __future__ import annotations

import shutil
import time
from dataclasses import replace

import pytest
from tests.faults.projects import TARGETS, copied


@pytest.fixture(scope="session")
def project(tmp_path_factory):
    """A copy of the project with one undisturbed run of a few targets on one core."""
    project = copied(tmp_path_factory.mktemp("undisturbed") / "project")
    project.run(*TARGETS)
    return project


@pytest.fixture(scope="session")
def undisturbed(project):
    """The results of the undisturbed run: bytes by name."""
    results = project.results()
    assert {"data/fig17.csv", "data/ptis_pixels.csv", "tables/inputs.csv"} <= set(results)
    assert {"figures/fig17.svg", "figures/fig17.png"} <= set(results)
    return results


@pytest.fixture(scope="session")
def another(tmp_path_factory):
    """Another copy, run on two cores: in another zone, without other tools such as git.

    Its path has blanks and letters beyond ASCII, none of which the locale knows.
    """
    place = tmp_path_factory.mktemp("another")
    tools = place / "tools"
    tools.mkdir()
    for name in ("sh", "bash", "env", "uname"):
        (tools / name).symlink_to(shutil.which(name))
    environment = {"LC_ALL": "C", "TZ": "Pacific/Kiritimati", "COLUMNS": "40", "PATH": str(tools)}
    project = copied(place / "Maße und Stöße" / "ein Projekt", out=str(place / "Größe 5 µm"))
    begin = time.monotonic()
    replace(project, environment=environment).run(*TARGETS, cores=2)
    project.seconds = time.monotonic() - begin
    return project


@pytest.fixture
def elsewhere(project, tmp_path):
    """The same project with an empty results root of its own."""
    return replace(project, out=str(tmp_path / "out"))
