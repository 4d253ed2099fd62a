"""Runs that meet another run, a damaged table, a full disk: told, nothing lost, and mended."""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
import time

import pytest
from tests.faults.places import mounted, read_only
from tests.faults.projects import TARGETS, finished, kill

pytestmark = [pytest.mark.workflow, pytest.mark.slow]


def test_two_runs_at_once_and_the_lock_that_a_killed_one_leaves(project, undisturbed, elsewhere):
    locks = project.root / ".snakemake/locks"
    first = elsewhere.start("fig17")
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
    elsewhere.run("--unlock")
    elsewhere.run("fig17")
    assert elsewhere.results().items() <= undisturbed.items()
    assert "figures/fig17.svg" in elsewhere.results()


def test_a_table_that_lost_its_last_row_stops_its_readers_until_it_is_gone(
    undisturbed, on_two_cores
):
    project = on_two_cores
    table = project.root / project.out / "data/fig17.csv"
    table.write_bytes(b"".join(table.read_bytes().splitlines(keepends=True)[:-1]))
    told = project.run("fig17", check=False)
    assert f"fig17: {table}: not as it was written: cut short, damaged or edited; delete" in told
    checked = subprocess.run(
        [project.python, "-m", "microimpact.cli", "check", project.out],
        cwd=project.root,
        env={"PYTHONPATH": str(project.root / "src")},
        capture_output=True,
        text=True,
        check=False,
    )
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


def test_results_that_are_read_only_are_told_and_kept(project, undisturbed, on_two_cores):
    table = on_two_cores.root / on_two_cores.out / "data/fig17.csv"
    table.touch()
    with read_only(table.parents[1]) as prefix:
        told = finished(on_two_cores.start("--force", "fig17", prefix=prefix), check=False)
    assert "Write-protected output files for rule fig17" in told
    assert f"{on_two_cores.out}/figures/fig17.svg" in told
    assert on_two_cores.results() == undisturbed
