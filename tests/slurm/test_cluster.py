"""A part of the study as jobs of a real Slurm on this machine: same bytes, failures repaired.

Run by `make test-slurm`, which installs what is needed and sets MICROIMPACT_SLURM.
"""

from __future__ import annotations

import re
import signal
import time
from contextlib import contextmanager
from dataclasses import replace

import pytest
from tests.faults.projects import copied, finished, kill
from tests.shared import ROOT
from tests.slurm.cluster import slurm_cluster
from tests.slurm.test_profile import PROFILE

# One impact, a Monte Carlo analysis after a calibration, and an analysis scattered into chunks.
TARGETS = ("fig20", "fig23", "capture_recovery")
CHUNKS = 3
ON_SLURM = (
    "--verbose",
    "--profile",
    "profiles/slurm",
    "--slurm-init-seconds-before-status-checks",
    "1",
)
PATIENCE = 900  # seconds


def overlay(project, *, chunks):
    path = project.root / f"chunks-{chunks}.yaml"
    path.write_text(f"chunks: {chunks}\n", encoding="utf-8")
    return path.name


@pytest.fixture(scope="module")
def cluster():
    with slurm_cluster() as cluster:
        yield cluster


@pytest.fixture(scope="module")
def local(tmp_path_factory):
    """The same part of the study on one core of this machine, in two chunks."""
    python = str(ROOT / ".venv-slurm/bin/python")
    project = copied(tmp_path_factory.mktemp("local") / "project", python=(python,))
    also = [overlay(project, chunks=2)]
    project.told = project.run("--verbose", *TARGETS, also=also, timeout=PATIENCE)
    return project


@pytest.fixture(scope="module")
def on_slurm(local, cluster, tmp_path_factory):
    """That part on the cluster, in three chunks."""
    out = str(tmp_path_factory.mktemp("slurm") / "out")
    project = replace(local, out=out, environment=dict(cluster.environment))
    also = [overlay(project, chunks=CHUNKS)]
    project.told = project.run(*ON_SLURM, *TARGETS, also=also, timeout=PATIENCE)
    return project


def jobs(cluster):
    """Return of every job that the cluster knows: its comment, state, memory and time limit."""
    text = cluster.output("squeue", "--states=all", "--noheader", "--format=%k|%T|%m|%l")
    return [tuple(line.strip().split("|")) for line in text.splitlines()]


def test_every_job_went_through_sbatch(cluster, local, on_slurm):
    found = jobs(cluster)
    assert {state for _, state, _, _ in found} == {"COMPLETED"}
    comments = [comment for comment, *_ in found]
    rules = set(re.findall(r"^(?:local)?rule (\w+):$", local.told, flags=re.MULTILINE))
    rules -= set(TARGETS)  # these have nothing to run
    assert {"monte_carlo", "fit_coverage_part", "force_history_figures"} <= rules
    expected = [rule for rule in rules for _ in range(CHUNKS if rule.endswith("_part") else 1)]
    assert sorted(comment.partition("_wildcards")[0] for comment in comments) == sorted(
        f"rule_{rule}" for rule in expected
    )
    assert on_slurm.told.count("has been submitted with SLURM jobid") == len(found)


def test_each_job_asks_for_what_the_profile_says(cluster, on_slurm):
    limits = {}
    for comment, _, memory, limit in jobs(cluster):
        rule = comment.removeprefix("rule_").partition("_wildcards")[0]
        asked = PROFILE["default-resources"] | PROFILE["set-resources"].get(rule, {})
        assert memory == f"{asked['mem_mb']}M"
        limits[rule] = limit
    assert limits["fit_coverage_part"] == "1:00:00"
    assert limits["force_history_figures"] == "15:00"


def test_bytes_are_those_of_one_core_and_other_chunks(local, on_slurm):
    expected, found = local.results(), on_slurm.results()
    assert {"data/fig23.csv", "figures/fig20.png", "tables/fit_coverage.csv"} <= set(expected)
    declared = found.pop("tables/inputs.csv")  # which tells the number of chunks
    other = declared.replace(f"config,chunks,{CHUNKS},".encode(), b"config,chunks,2,")
    assert declared != other == expected.pop("tables/inputs.csv")
    assert found == expected


def test_the_stamp_is_written_once_by_the_head_of_the_run(on_slurm):
    assert (on_slurm.root / on_slurm.out / "run.json").is_file()


@contextmanager
def held(project, study, marker):
    """Make a study wait for ever the first time, and leave a marker when it does so."""
    path = next(project.root.glob(f"src/microimpact/studies/*/{study}.py"))
    before = path.read_text(encoding="utf-8")
    path.write_text(
        before
        + f"""

_run = run


def run(params, inputs):
    import pathlib, time

    marker = pathlib.Path({str(marker)!r})
    if not marker.exists():
        marker.touch()
        time.sleep(3600)
    return _run(params, inputs)
""",
        encoding="utf-8",
    )
    try:
        yield
    finally:
        path.write_text(before, encoding="utf-8")


@pytest.fixture
def elsewhere(on_slurm, tmp_path):
    return replace(on_slurm, out=str(tmp_path / "out"))


def running(cluster, marker, run):
    """Wait until the marker tells that a job computes; return the ids of running jobs."""
    deadline = time.monotonic() + 120
    while not marker.exists():
        assert run.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.2)
    return cluster.output("squeue", "--states=RUNNING", "--noheader", "--format=%i").split()


def test_a_job_that_the_cluster_ends_is_submitted_again(
    cluster, local, on_slurm, elsewhere, tmp_path
):
    marker = tmp_path / "waits"
    with held(elsewhere, "force_history", marker):
        run = elsewhere.start(*ON_SLURM, "force_history")
        try:
            (lost,) = running(cluster, marker, run)
            cluster.output("scancel", lost)
            told = finished(run, timeout=PATIENCE)
        finally:
            kill(run)
    assert f"SLURM-job '{lost}' failed, SLURM status is: 'CANCELLED'" in told
    expected = local.results()
    assert elsewhere.results()["data/fig20.csv"] == expected["data/fig20.csv"]


def test_a_run_that_is_interrupted_cancels_its_jobs(cluster, on_slurm, elsewhere, tmp_path):
    marker = tmp_path / "waits"
    with held(elsewhere, "force_history", marker):
        run = elsewhere.start(*ON_SLURM, "force_history")
        try:
            (job,) = running(cluster, marker, run)
            run.send_signal(signal.SIGINT)
            finished(run, check=False)
        finally:
            kill(run)
    deadline = time.monotonic() + 60
    while job in cluster.output("squeue", "--noheader", "--format=%i").split():
        assert time.monotonic() < deadline
        time.sleep(0.2)
    assert "data/fig20.csv" not in elsewhere.results()
