"""Time and error of one normal impact by several methods, side by side on one core.

    python -m benchmarks.compare [--quick] [--rounds N] [--output DIRECTORY]

Every round runs every method once, so that whatever else the machine does hits all alike; times are
the minimum and the median over the rounds. Errors are relative errors of the coefficient of
restitution against an integration in 80-bit numbers. The table is printed and written as CSV, and
plotted as error against time. Compare the ratios, not the times: those depend on the machine.
"""

from __future__ import annotations

import argparse
import csv
import os
import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import heyoka as hy
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from benchmarks.cases import Cases, Errors, judge, make_cases
from benchmarks.solvers import Kernel, Package, ScipyRegularForm, ScipyTimeForm
from benchmarks.taylor import Batch, Reference, Scalar

# Method, and the share of the cases it computes: one in so many.
METHODS = (
    (Package, 1),
    (Kernel, 1),
    (Scalar, 1),
    (Batch, 1),
    (ScipyRegularForm, 100),
    (ScipyTimeForm, 100),
)
PER_GROUP, PER_GROUP_QUICK = 6667, 1000
ROUNDS, ROUNDS_QUICK = 9, 3
OUTPUT = Path(__file__).parents[1] / "build" / "benchmarks"

COLUMNS = (
    "method", "tolerance", "impacts", "microseconds_min", "microseconds_median", "ratio",
    "error_median", "error_max", "wrong_captures",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Result:
    """Times per impact in microseconds, one per round, and errors of one method."""

    method: str
    tolerance: float
    impacts: int
    times: np.ndarray
    errors: Errors

    @property
    def best(self) -> float:
        return float(self.times.min())

    def row(self, ours: float) -> tuple[str | float, ...]:
        errors = self.errors
        return (
            self.method, self.tolerance, self.impacts, self.best, float(np.median(self.times)),
            self.best / ours, errors.median, errors.largest, errors.wrong,
        )  # fmt: skip


def use_one_core() -> None:
    """Keep this process on one core and every library on one thread."""
    hy.set_nthreads(1)
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def timed(run: Callable[[], np.ndarray]) -> float:
    start = time.perf_counter()
    run()
    return time.perf_counter() - start


def measure(cases: Cases, rounds: int) -> tuple[list[Result], np.ndarray]:
    """Run all methods in turn, ``rounds`` times; the reference e comes with the results."""
    reference = Reference(cases)()
    runs, results = [], []
    for method, stride in METHODS:
        part = cases.every(stride)
        run = method(part)
        errors = judge(np.array(run()), reference[stride // 2 :: stride])
        runs.append((run, len(part), errors))
    seconds = np.array([[timed(run) for run, _, _ in runs] for _ in range(rounds)])
    for (run, count, errors), times in zip(runs, seconds.T, strict=True):
        results.append(Result(run.name, run.tolerance, count, times / count * 1e6, errors))
    return results, reference


def print_table(rows: Sequence[tuple[str | float, ...]]) -> None:
    print(
        f"{'':28}{'':>10}{'':>8}{'us per impact':>18}{'':>9}{'relative error of e':>21}{'wrong':>9}"
    )
    print(
        f"{'method':28}{'tolerance':>10}{'impacts':>8}{'min':>9}{'median':>9}{'ratio':>9}"
        f"{'median':>11}{'max':>10}{'captures':>9}"
    )
    for name, tolerance, impacts, best, median, ratio, middle, largest, wrong in rows:
        print(
            f"{name:28}{tolerance:10.0e}{impacts:8d}{best:9.2f}{median:9.2f}{ratio:9.2f}"
            f"{middle:11.1e}{largest:10.1e}{wrong:9d}"
        )


def write_csv(path: Path, rows: Sequence[tuple[str | float, ...]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows)


def plot(path: Path, results: Sequence[Result]) -> None:
    """Error against time, each method a bar from its median to its largest error."""
    figure = Figure(figsize=(7.0, 4.5), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    for index, result in enumerate(results):
        errors = (max(result.errors.median, 1e-17), result.errors.largest)
        best = (result.best, result.best)
        colour = f"C{index}"
        axes.plot(best, errors, color=colour, linewidth=1.0)
        axes.plot(*best[:1], errors[0], "o", color=colour, label=result.method)
        axes.plot(*best[:1], errors[1], "_", color=colour, markersize=12.0)
    axes.set(xscale="log", yscale="log", xlabel="time per impact / µs (one core)")
    axes.set_ylabel("relative error of e: median (dot), largest (bar)")
    axes.grid(visible=True, alpha=0.3)
    axes.legend(loc="upper center", frameon=False, fontsize="small")
    figure.savefig(path, dpi=200)


def machine() -> str:
    """Versions, processor and load: what a reader needs to judge the times."""
    versions = ", ".join(f"{name} {version(name)}" for name in ("numba", "heyoka", "scipy"))
    processor = platform.processor() or platform.machine()
    load = f", load {os.getloadavg()[0]:.2f}" if hasattr(os, "getloadavg") else ""
    return f"Python {platform.python_version()}, {versions}, {processor}{load}"


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.compare", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--quick", action="store_true", help="fewer impacts and rounds")
    parser.add_argument("--rounds", type=int, help="how often every method runs")
    parser.add_argument("--output", type=Path, default=OUTPUT, help="folder of table and plot")
    options = parser.parse_args(arguments)
    rounds = options.rounds or (ROUNDS_QUICK if options.quick else ROUNDS)

    use_one_core()
    before = machine()
    cases = make_cases(PER_GROUP_QUICK if options.quick else PER_GROUP)
    results, reference = measure(cases, rounds)
    rows = [result.row(results[0].best) for result in results]

    undamped = (cases.hertz == 0.0) & (cases.adhesion == 0.0)
    error = float(np.abs(reference[undamped] - 1.0).max())
    print(before)
    print(
        f"{len(cases)} normal impacts, {np.count_nonzero(reference == 0.0)} of them captured; "
        f"{rounds} rounds; the reference has e = 1 to {error:.0e} without damping\n"
    )
    print_table(rows)
    options.output.mkdir(parents=True, exist_ok=True)
    write_csv(options.output / "compare.csv", rows)
    plot(options.output / "compare.png", results)
    print(f"\n{options.output / 'compare.csv'}\n{options.output / 'compare.png'}")


if __name__ == "__main__":
    main()
