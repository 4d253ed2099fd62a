"""A part of the study as jobs of a real Slurm on this machine gives the bytes of one core.

Run by `make test-slurm`, which installs what is needed and sets MICROIMPACT_SLURM.
"""

from __future__ import annotations

from dataclasses import replace

from tests.faults.projects import copied
from tests.shared import ROOT
from tests.slurm.cluster import slurm_cluster

# One impact, and a Monte Carlo analysis in parts after a calibration.
TARGETS = ("fig20", "fig23")
PARTS = 3
ON_SLURM = (
    "--verbose",
    *("--profile", "profiles/slurm"),
    *("--set-scatter", f"monte_carlo={PARTS}"),
    *("--slurm-init-seconds-before-status-checks", "1"),
)


def test_the_bytes_are_those_of_one_core(tmp_path):
    python = str(ROOT / ".venv-slurm/bin/python")
    local = copied(tmp_path / "project", python=(python,))
    local.run(*TARGETS, timeout=900)
    with slurm_cluster() as output:
        project = replace(local, out=str(tmp_path / "out"), environment=output.environment)
        message = project.run(*ON_SLURM, *TARGETS, timeout=900)
        jobs = output("squeue", "--states=all", "--noheader", "--format=%k|%T")
    jobs = [line.strip() for line in jobs.splitlines()]
    assert {job.partition("|")[2] for job in jobs} == {"COMPLETED"}
    rules = [job.removeprefix("rule_").partition("_wildcards")[0] for job in jobs]
    assert rules.count("fig23_monte_carlo_part") == PARTS
    assert message.count("has been submitted with SLURM jobid") == len(jobs)
    results = project.results()
    assert {"data/fig23.csv", "figures/fig20.png"} <= set(results)
    assert results == local.results()
