"""The same bytes, figures included: run twice, on one core or two, killed and resumed, elsewhere.

Each run has another seed of Python's hashes, since none of the caller's PYTHON* variables is kept.
"""

from __future__ import annotations

import json
import shutil
import subprocess
from contextlib import suppress

import numpy as np
import pytest
from tests.faults.projects import TARGETS, copied, kill

pytestmark = [pytest.mark.workflow, pytest.mark.slow]


def test_two_runs_on_one_core_and_on_two(undisturbed, on_two_cores):
    assert on_two_cores.results() == undisturbed


def test_a_run_killed_at_random_moments_and_finished_by_the_next(project, undisturbed, elsewhere):
    for share in np.random.default_rng(20011).uniform(0.4, 0.9, 2):
        run = elsewhere.start("--nolock", *TARGETS)
        with suppress(subprocess.TimeoutExpired):
            run.communicate(timeout=share * project.seconds)
        kill(run)
        # Whatever a reader can see is whole.
        assert elsewhere.results().items() <= undisturbed.items()
    elsewhere.run("--nolock", *TARGETS)
    assert elsewhere.results() == undisturbed


def test_another_place_and_zone_without_other_tools(undisturbed, tmp_path):
    """A path with blanks and letters beyond ASCII, none of which the locale knows; no git."""
    tools = tmp_path / "tools"
    tools.mkdir()
    for name in ("sh", "bash", "env", "uname"):
        (tools / name).symlink_to(shutil.which(name))
    project = copied(
        tmp_path / "Maße und Stöße" / "ein Projekt",
        out=str(tmp_path / "Größe 5 µm"),
        environment={
            "PATH": str(tools),
            "LC_ALL": "C",
            "TZ": "Pacific/Kiritimati",
            "COLUMNS": "40",
        },
    )
    project.run(*TARGETS)
    assert project.results() == undisturbed


def test_the_checksums_are_those_of_the_same_bytes(project, undisturbed, on_two_cores):
    assert on_two_cores.results("checksums") == project.results("checksums")
    recorded = {name.removeprefix("checksums/") for name in project.results("checksums")}
    assert {name.removesuffix(".sha256") for name in recorded} == set(undisturbed)


def test_the_stamp_tells_where_the_second_run_went(project, on_two_cores):
    first, second = (
        json.loads((root.root / root.out / "run.json").read_text(encoding="utf-8"))
        for root in (project, on_two_cores)
    )
    assert first["config"].pop("pathvars") != second["config"].pop("pathvars")
    assert first["config"] == second["config"]
    assert first["packages"] == second["packages"]
