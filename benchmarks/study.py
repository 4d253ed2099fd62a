"""What the whole study costs: time, processor time, memory and disk.

    python -m benchmarks.study [--cores 2] [--rounds 3] [--docs]

Runs the study into a folder of its own with kernels compiled, then looks for something to be done,
changes one value of one analysis, and draws one figure anew. Times of the short runs are the least
over the rounds; the processor's time is given beside the clock's, which other work on the machine
lengthens. With `--docs` the numbers go into docs/performance.md.
"""

from __future__ import annotations

import argparse
import csv
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import yaml

from benchmarks.report import renew

PROJECT = Path(__file__).parents[1]
# A cheap analysis with one figure: what is left is what any change costs.
CHANGED, FIGURE = {"fig14_restitution_trends": {"body_speed_m_per_s": 25.0}}, "fig14"


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.study")
    parser.add_argument("--cores", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--docs", action="store_true", help="renew docs/performance.md, too")
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as name:
        text = _measured(Path(name), options.cores, options.rounds)
    print(text)
    if options.docs:
        renew(PROJECT / "docs" / "performance.md", "study", text)


def _measured(folder: Path, cores: int, rounds: int) -> str:
    """Return the table as Markdown, and memory and disk in words."""
    results = folder / "results"
    plain = _overlay(folder / "plain.yaml", results, {})
    costs = {"the whole study": _run(plain, cores)}
    memory, disk = _largest_memory(results), _megabytes(results)
    costs["nothing to be done"] = _least([_run(plain, cores) for _ in range(rounds)])
    changed = [_overlay(folder / f"{k}.yaml", results, _shifted(k)) for k in range(rounds)]
    costs["one value changed: its analysis, figure and the report"] = _least(
        [_run(overlay, cores) for overlay in changed]
    )
    figure = results / "figures" / f"{FIGURE}.svg"
    drawn = []
    for _ in range(rounds):
        figure.unlink()
        drawn.append(_run(changed[-1], cores, FIGURE))
    costs["one figure drawn anew"] = _least(drawn)
    return "\n".join(
        [
            f"| on {cores} cores | time / s | processor time / s |",
            "| --- | ---: | ---: |",
            *(f"| {name} | {wall:.1f} | {own:.1f} |" for name, (wall, own) in costs.items()),
            "",
            f"The largest job takes {memory:.0f} MB of memory, the results {disk:.0f} MB of disk "
            f"and the environment {_megabytes(Path(sys.prefix)):.0f} MB.",
        ]
    )


def _shifted(number: int) -> dict[str, dict[str, float]]:
    """Return the change with another value in each round, so that none finds nothing to be done."""
    return {
        name: {key: value + number for key, value in values.items()}
        for name, values in CHANGED.items()
    }


def _overlay(path: Path, results: Path, changes: dict[str, dict[str, float]]) -> Path:
    path.write_text(yaml.safe_dump({"pathvars": {"results": str(results)}} | changes))
    return path


def _run(overlay: Path, cores: int, *targets: str) -> tuple[float, float]:
    """Return the times of the clock and of the processors that a run takes, in s."""
    command = ["snakemake", f"-c{cores}", "--configfile", str(overlay), "--", *targets]
    began, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, cwd=PROJECT, check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)  # fmt: skip
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    own = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    return time.perf_counter() - began, own


def _least(costs: Sequence[tuple[float, float]]) -> tuple[float, float]:
    return min(wall for wall, _ in costs), min(own for _, own in costs)


def _megabytes(folder: Path) -> float:
    files = (Path(root) / name for root, _, names in os.walk(folder) for name in names)
    return sum(path.lstat().st_size for path in files) / 1e6


def _largest_memory(results: Path) -> float:
    """Return the greatest memory of a job, MB, as Snakemake has measured it."""
    memory = []
    for path in (results / "benchmarks").glob("*.tsv"):
        with path.open(encoding="utf-8", newline="") as file:
            (job,) = csv.DictReader(file, delimiter="\t")
        memory += [float(job["max_rss"])] if job["max_rss"] != "NA" else []
    return max(memory)


if __name__ == "__main__":
    main()
