"""One undisturbed run, which every disturbed one must equal."""

from __future__ import annotations

import time
from dataclasses import replace

import pytest
from tests.faults.projects import TARGETS, copied


@pytest.fixture(scope="session")
def project(tmp_path_factory, forked):
    """A copy of the project with one undisturbed run of a few targets on one core."""
    project = copied(tmp_path_factory.mktemp("undisturbed") / "project")
    begin = time.monotonic()
    replace(project, python=forked).run(*TARGETS)
    project.seconds = time.monotonic() - begin
    return project


@pytest.fixture(scope="session")
def undisturbed(project):
    """The results of the undisturbed run: bytes by name."""
    results = project.results()
    assert {"data/fig17.csv", "data/ptis_pixels.csv", "tables/inputs.csv"} <= set(results)
    assert {"figures/fig17.svg", "figures/fig17.png"} <= set(results)
    return results


@pytest.fixture(scope="session")
def on_two_cores(project, tmp_path_factory, forked):
    """The same project, run on two cores into a results root of its own."""
    other = replace(project, out=str(tmp_path_factory.mktemp("two") / "out"))
    replace(other, python=forked).run(*TARGETS, cores=2)
    return other


@pytest.fixture
def elsewhere(project, tmp_path):
    """The same project with an empty results root of its own."""
    return replace(project, out=str(tmp_path / "out"))
