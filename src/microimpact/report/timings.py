"""What each job of a run has cost: time, processor time and memory, as each measured itself."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from microimpact.report.site.graph import needs
from microimpact.report.site.record import Rule, read_record

BENCHMARKS = "benchmarks"
# Jobs of a rule in parts are called as the rule, with the number of the part.
_PART = re.compile(r"-\d+-of-\d+$")


@dataclass(frozen=True, slots=True, kw_only=True)
class Timing:
    """Cost of one job."""

    job: str  # Name of its rule, with the part where the rule comes in parts
    wall: float  # Time from beginning to end, s
    processor: float  # Time of processors, s
    memory: float  # Largest resident memory, MB

    @property
    def rule(self) -> str:
        """Name of the rule whose results the job serves."""
        return _PART.sub("", self.job)


def read_timings(results: Path) -> list[Timing]:
    """Return the cost of all jobs of a run, the longest first.

    Raises ValueError if nothing was measured there, or a file is not as the workflow writes it.
    """
    found = [_timing(path) for path in sorted((results / BENCHMARKS).glob("*.tsv"))]
    if not found:
        raise ValueError(f"{results}: no measured times in {BENCHMARKS}/")
    return sorted(found, key=lambda timing: -timing.wall)


def _timing(path: Path) -> Timing:
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file, delimiter="\t"))
    try:
        (row,) = rows
        wall, processor, memory = (float(row[name]) for name in ("s", "cpu_time", "max_rss"))
    except (ValueError, KeyError, TypeError):
        raise ValueError(f"{path}: not a file of measured times") from None
    return Timing(job=path.stem, wall=wall, processor=processor, memory=memory)


def critical_path(timings: Sequence[Timing], rules: Sequence[Rule]) -> list[Timing]:
    """Return the chain of jobs that no number of processors can shorten, in order.

    `timings`: of the jobs; of a rule in parts the longest part precedes the rule's own job;
    `rules`: what each rule reads and makes.
    """
    jobs: dict[str, list[Timing]] = {}
    for timing in timings:
        jobs.setdefault(timing.rule, []).append(timing)
    before = {rule: {*own} - {rule} for rule, own in needs(rules).items()}

    @cache
    def chain(rule: str) -> list[Timing]:
        """Return the longest chain that ends with a rule."""
        earlier = [chain(name) for name in sorted(before.get(rule, ()))]
        own = jobs.get(rule, [])
        parts = sorted((job for job in own if job.job != rule), key=lambda job: -job.wall)[:1]
        last = [job for job in own if job.job == rule]
        return [*max(earlier, key=_wall, default=[]), *parts, *last]

    return max(map(chain, jobs), key=_wall, default=[])


def _wall(chain: Sequence[Timing]) -> float:
    return sum(timing.wall for timing in chain)


def as_text(results: Path) -> str:
    """Return a table of all jobs, the longest first, their sum and the critical path."""
    timings = read_timings(results)
    lines = [f"{'job':32}{'time, s':>10}{'CPU, s':>10}{'memory, MB':>12}"]
    lines += [
        f"{timing.job:32}{timing.wall:10.1f}{timing.processor:10.1f}{timing.memory:12.0f}"
        for timing in timings
    ]
    processor = sum(timing.processor for timing in timings)
    lines.append(f"{f'all {len(timings)} jobs':32}{_wall(timings):10.1f}{processor:10.1f}")
    rules: Sequence[Rule] = ()
    with suppress(OSError, ValueError):  # a run may keep no record of its rules
        rules = read_record(results).rules
    if rules:
        path = critical_path(timings, rules)
        names = ", ".join(timing.job for timing in path)
        lines.append(f"\nCritical path, {_wall(path):.1f} s: {names}")
    return "\n".join(lines)
