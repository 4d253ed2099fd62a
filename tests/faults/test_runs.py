"""Runs: the same bytes however they are made; a disturbance is reported, the next run repairs it.

Twice, on one core or two, killed and resumed, elsewhere: figures included, all bytes are the same.
Each such run has another seed of Python's hashes, since none of the caller's PYTHON* variables is
kept. Another run, a damaged table or a full disk is told, and nothing is lost.
"""

from __future__ import annotations

import json
import os
import shlex
import signal
import time
from contextlib import suppress
from subprocess import TimeoutExpired

import numpy as np
import pytest
from tests.faults.places import mounted, read_only
from tests.faults.projects import TARGETS, finished, kill
from tests.shared import execute

pytestmark = [pytest.mark.workflow, pytest.mark.slow]


def test_two_runs_on_one_core_and_on_two_elsewhere(project, undisturbed, another):
    assert another.results() == undisturbed
    assert another.results("checksums") == project.results("checksums")
    recorded = {name.removeprefix("checksums/") for name in project.results("checksums")}
    assert {name.removesuffix(".sha256") for name in recorded} == set(undisturbed)


def test_the_lock_of_a_run_and_what_it_leaves_when_it_is_killed(
    project, undisturbed, another, elsewhere
):
    locks = project.root / ".snakemake/locks"
    first = elsewhere.start(*TARGETS)
    try:
        while not any(locks.glob("*")):
            assert first.poll() is None
            time.sleep(0.05)
        os.killpg(first.pid, signal.SIGSTOP)  # that it does not end too soon
        told = elsewhere.run("fig17", check=False)
    finally:
        kill(first)
    assert "Directory cannot be locked" in told
    assert "no other Snakemake process" in told
    assert "--unlock" in told  # which serves now that the first run is no more
    for share in np.random.default_rng(20011).uniform(0.4, 0.9, 2):
        run = elsewhere.start("--nolock", *TARGETS)
        with suppress(TimeoutExpired):
            run.communicate(timeout=share * another.seconds)
        kill(run)
        # Whatever a reader can see is whole.
        assert elsewhere.results().items() <= undisturbed.items()
    elsewhere.run("--unlock")
    elsewhere.run(*TARGETS)
    assert elsewhere.results() == undisturbed


def test_what_a_killed_run_has_started_ends_with_it(elsewhere):
    run = elsewhere.start("--nolock", "ptis_accuracy")
    part = elsewhere.root / elsewhere.out
    while not part.exists():
        assert run.poll() is None
        time.sleep(0.02)
    run.kill()
    # The end of what all of them write to is the end of the last of them.
    run.communicate(timeout=60)
    assert not (part / "figures/ptis_accuracy.svg").exists()


def test_the_stamp_tells_where_the_second_run_went(project, another):
    first, second = (
        json.loads((root.root / root.out / "run.json").read_text(encoding="utf-8"))
        for root in (project, another)
    )
    assert first["config"].pop("pathvars") != second["config"].pop("pathvars")
    assert first["config"] == second["config"]
    assert first["packages"] == second["packages"]


def test_a_table_that_lost_its_last_row_stops_its_readers_until_it_is_gone(undisturbed, another):
    project = another
    table = project.root / project.out / "data/fig17.csv"
    table.write_bytes(b"".join(table.read_bytes().splitlines(keepends=True)[:-1]))
    told = project.run("fig17", check=False)
    assert f"coulomb_friction_figures: {table}: not as it was written: cut short, damaged" in told
    command = (*project.python, "-m", "microimpact.report.commands", "check", project.out)
    environment = {"PYTHONPATH": str(project.root / "src")}
    checked = execute(*command, cwd=project.root, env=environment, check=False)
    assert checked.returncode
    table.unlink()
    project.run(*TARGETS)
    assert project.results() == undisturbed


def test_a_full_disk_is_told_and_with_more_room_the_run_is_finished(
    undisturbed, elsewhere, tmp_path
):
    """Of 40 kB, the data of Fig. 17 fit, its pictures do not."""
    out, kept = tmp_path / "out", tmp_path / "kept"
    out.mkdir()
    place = shlex.quote(str(out))
    prefix = mounted(
        f"mount -t tmpfs -o size=40k none {place}",
        'if "$@"; then exit 1; fi',
        f"mount -o remount,size=40m {place}",
        "echo MORE ROOM",
        '"$@"',
        f"exec cp -r {place} {shlex.quote(str(kept))}",
    )
    before, more, after = finished(elsewhere.start("fig17", prefix=prefix)).partition("MORE ROOM")
    assert "cannot be written: No space left on device" in before
    assert more
    assert "cannot" not in after
    elsewhere.out = str(kept)
    assert elsewhere.results().items() <= undisturbed.items()
    assert "figures/fig17.png" in elsewhere.results()


def test_results_that_are_read_only_are_told_and_kept(project, undisturbed, another):
    table = another.root / another.out / "data/fig17.csv"
    table.touch()
    with read_only(table.parents[1]) as prefix:
        command = ("--force", "coulomb_friction_figures")
        told = finished(another.start(*command, prefix=prefix), check=False)
    assert "Write-protected output files for rule coulomb_friction_figures" in told
    assert f"{another.out}/figures/fig17.svg" in told
    assert another.results() == undisturbed
