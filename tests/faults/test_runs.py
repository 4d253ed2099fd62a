"""Runs: killed or damaged, they are resumed to the same bytes.

The undisturbed run is on one core, another on two, in another zone and language, with another seed
of Python's hashes and a path with letters beyond ASCII. All load the same compiled code: where it
is compiled anew, the last digits may differ.
"""

from __future__ import annotations

import os
import signal
import time
from contextlib import suppress
from dataclasses import replace
from subprocess import TimeoutExpired

import numpy as np
import pytest
from tests.faults.projects import TARGETS, copied, kill

pytestmark = [pytest.mark.workflow, pytest.mark.slow]


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    """A copy of the project with one undisturbed run of a few targets on one core."""
    project = copied(tmp_path_factory.mktemp("undisturbed") / "project")
    begin = time.monotonic()
    project.run(*TARGETS)
    project.seconds = time.monotonic() - begin
    return project


@pytest.fixture(scope="module")
def undisturbed(project):
    """The results of the undisturbed run: bytes by name."""
    results = project.results()
    assert {"data/fig17.csv", "data/ptis_pixels.csv", "tables/inputs.csv"} <= set(results)
    assert {"figures/fig17.svg", "figures/fig17.png"} <= set(results)
    return results


@pytest.fixture
def elsewhere(project, tmp_path):
    """The same project with an empty results root of its own."""
    return replace(project, out=str(tmp_path / "out"))


def test_two_cores_another_place_and_language_give_the_same_bytes(undisturbed, tmp_path):
    place = {"LC_ALL": "C", "TZ": "Pacific/Kiritimati", "COLUMNS": "40"}
    project = copied(tmp_path / "Maße und Stöße", out=str(tmp_path / "Größe"), environment=place)
    project.run(*TARGETS, cores=2)
    assert project.results() == undisturbed


def test_a_run_is_locked_and_resumed_where_it_was_killed(project, undisturbed, elsewhere):
    locks = project.root / ".snakemake/locks"
    first = elsewhere.start(*TARGETS)
    try:
        while not any(locks.glob("*")):
            assert first.poll() is None
            time.sleep(0.05)
        os.killpg(first.pid, signal.SIGSTOP)  # that it does not end too soon
        message = elsewhere.run("fig17", check=False)
    finally:
        kill(first)
    assert "Directory cannot be locked" in message
    assert "--unlock" in message  # which serves now that the first run is no more
    for share in np.random.default_rng(20011).uniform(0.4, 0.9, 2):
        run = elsewhere.start("--nolock", *TARGETS)
        with suppress(TimeoutExpired):
            run.communicate(timeout=share * project.seconds)
        kill(run)
        # Whatever a reader can see is whole.
        assert elsewhere.results().items() <= undisturbed.items()
    elsewhere.run("--unlock")
    elsewhere.run(*TARGETS)
    assert elsewhere.results() == undisturbed
