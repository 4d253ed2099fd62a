"""Cost against the number of events: direct impacts, those by the table, and Monte Carlo.

    python -m benchmarks.scaling [--quick] [--most 1e7] [--threads 1 2] [--output DIRECTORY]
    python -m benchmarks.scaling --events 1e9 --threads 2

The first form measures times per event from a thousand events to ``--most`` and writes a table and
a plot: a flat line is a cost that is linear in the events. Times are the least over the rounds; the
processor's time is given beside the clock's, which other work on the machine lengthens. Impacts are
oblique, with friction and spin and all their outcomes; restitution is e of normal ones alone. Monte
Carlo comes first, so that the greatest memory of the process until then is its own. How many times
faster two or more threads are than one is told apart, beside as many separate processes, which is
the limit of the machine: of runs in turn, the median of ratios within each round, so that a machine
whose speed drifts does not matter. The second form makes one long Monte Carlo run on a rough
surface, with a bar on the terminal, and says its rate and the memory it took.
"""

from __future__ import annotations

import argparse
import csv
import multiprocessing
import resource
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import astuple, dataclass, fields
from functools import cache, partial
from itertools import product
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from microimpact import Contact, Material
from microimpact.model.dynamics.impact import simulate
from microimpact.model.law.table import tabulate
from microimpact.statistics.distributions import Constant, Normal, TruncatedNormal, Uniform
from study.studies.analyses.monte_carlo.ensembles import (
    Ensemble,
    Estimate,
    Plan,
    Process,
    Rules,
    estimate,
    long_run,
    progress,
)
from study.studies.analyses.monte_carlo.impacts import RigidBody

ANGLE_DEG = 20.0
SEED = 20011
FEWEST = 1000
ROUNDS, ROUNDS_QUICK = 3, 1
# Of runs on one thread, on more, and in processes, in turn.
TURNS, TURNS_QUICK = 10, 3
# Monte Carlo draws whole replicates. More direct impacts would tell nothing new, and there is the
# long run for Monte Carlo.
FEWEST_OF = {"direct": FEWEST, "table": FEWEST, "restitution": FEWEST, "Monte Carlo": 10**5}
SHARED = ("Monte Carlo", "table")  # among threads
MOST = {"direct": 10**6, "table": 10**8, "restitution": 10**8, "Monte Carlo": 10**9}
OUTPUT = Path(__file__).parents[1] / "build" / "benchmarks"


@dataclass(frozen=True, slots=True)
class Row:
    method: str
    threads: int
    events: int
    nanoseconds_clock: float
    nanoseconds_processor: float
    memory_mib: float


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.scaling", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--quick", action="store_true", help="to 1e5 events, one round")
    parser.add_argument("--most", type=float, default=1e7, help="largest number of events")
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--events", type=float, help="one Monte Carlo run of so many events")
    parser.add_argument("--output", type=Path, default=OUTPUT, help="folder of table and plot")
    options = parser.parse_args(arguments)
    if options.events:
        for threads in options.threads:
            one_run(int(options.events), threads)
        return
    most = 10**5 if options.quick else int(options.most)
    rows = measure(most, options.threads, ROUNDS_QUICK if options.quick else ROUNDS)
    options.output.mkdir(parents=True, exist_ok=True)
    write(options.output / "scaling.csv", rows)
    for threads in filter(lambda n: n > 1, options.threads):
        turns = TURNS_QUICK if options.quick else TURNS
        ratios = np.array([*sharing(most, threads, turns)])
        shared, apart = np.median(ratios, axis=0)
        print(
            f"Monte Carlo on {threads} threads {shared:.2f} times as fast as on one, "
            f"{threads} processes {apart:.2f} times: median of {turns} rounds of {most:.0e} events"
        )
        head = f"ratio_{threads}_threads,ratio_{threads}_processes"
        path = options.output / f"sharing_{threads}.csv"
        np.savetxt(path, ratios, delimiter=",", header=head, comments="", fmt="%.3f")
    plot(options.output / "scaling.png", rows)
    report(rows)
    print(f"\n{options.output / 'scaling.csv'}\n{options.output / 'scaling.png'}")


def steel_on_silicon() -> Contact:
    """A contact near the calibrated one: captured below 0.18 m/s, e of 0.7 at 1.66 m/s."""
    return Contact(
        particle=Material(name="steel", youngs_modulus=193e9, poissons_ratio=0.28, density=8000.0),
        surface=Material(name="silicon", youngs_modulus=169e9, poissons_ratio=0.25, density=2330.0),
        diameter=62e-6,
        work_of_adhesion=3.5,
        hertz_damping=0.00295,
        adhesion_damping=1.39,
    )


def rough_surface() -> Ensemble:
    """Steel on a rough silicon surface, as in the article's Monte Carlo analysis (Fig. 23)."""
    neutral = dict.fromkeys(
        ("restitution_factor", "work_of_adhesion_factor", "hertz_damping_factor"), Constant(at=1.0)
    ) | dict.fromkeys(("angle_offset_deg", "cross_slope", "spin_ratio"), Constant(at=0.0))
    process = Process(
        **neutral,
        speed_m_per_s=Uniform(low=1.61, high=1.71),
        diameter_um=TruncatedNormal(mean=62.0, sd=4.5, low=45.0, high=76.0),
        slope=Normal(sd=0.223),
        friction=Constant(at=0.15),
        restitution_offset=Constant(at=0.0),
        adhesion_damping_factor=Constant(at=1.0),
    )
    return Ensemble(
        process=process,
        rules=Rules(facets="facing", must_leave=True, most_contacts=1),
        impact=RigidBody.of(steel_on_silicon(), process),
        plan=Plan(replicates=2, events=2),
        seed=(SEED,),
    )


def one_run(events: int, threads: int) -> None:
    """Run Monte Carlo once and say what it took."""
    ensemble = long_run(rough_surface(), events)
    total = ensemble.plan.replicates * ensemble.plan.events
    clock, processor = time.perf_counter(), time.process_time()
    with progress(f"{events:.0e} events", total) as done:
        found = estimate(ensemble, ANGLE_DEG, threads=threads, done=done)
    clock, processor = time.perf_counter() - clock, time.process_time() - processor
    print(
        f"{total} events, {threads} thread(s): {clock:.1f} s, {total / clock:.3g} events/s; "
        f"processor {processor:.1f} s, {total / processor:.3g} events/s; "
        f"largest memory {memory():.0f} MiB"
    )
    print(f"e_m = {found.restitution:.17g} +- {found.restitution_error:.1g} at {ANGLE_DEG:g} deg")


def memory() -> float:
    """Greatest memory of the process until now, MiB."""
    # Kilobytes on Linux, bytes on macOS.
    unit = 1024.0 if sys.platform == "darwin" else 1.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit / 1024.0


@cache
def monte_carlo(events: int, threads: int) -> tuple[int, Callable[[], object]]:
    rough = long_run(rough_surface(), events)
    run = partial[Estimate](estimate, rough, ANGLE_DEG, threads=threads)
    return rough.plan.replicates * rough.plan.events, run


def impacts(method: str, events: int, threads: int) -> tuple[int, Callable[[], object]]:
    """What is timed; tables and compiled code are made before."""
    contact, rng = steel_on_silicon(), np.random.default_rng(SEED)
    ranges = (0.2, 3.0), (10.0, 90.0), (-1e4, 1e4)
    speed, angle, spin = (rng.uniform(*ends, events) for ends in ranges)
    law = tabulate(contact, 0.02, 3.0)
    if method == "direct":
        return events, partial(simulate, contact, speed, angle, spin)
    if method == "table":
        return events, partial(law.simulate, speed, angle, spin, threads=threads)
    return events, partial(law.restitution, *law.family.coordinates(contact, speed))


def measure(most: int, threads: Sequence[int], rounds: int) -> list[Row]:
    counts = [FEWEST * 10**k for k in range(8) if FEWEST * 10**k <= most]
    rows = []
    for method, count in product(("Monte Carlo", "direct", "restitution", "table"), counts):
        if not FEWEST_OF[method] <= count <= MOST[method]:
            continue
        made = monte_carlo if method == "Monte Carlo" else partial(impacts, method)
        numbers = threads if method in SHARED else (1,)
        runs = [made(count, n) for n in numbers]
        for _, run in runs:
            run()
        # In turn, so that whatever else the machine does hits all alike.
        times = np.min([[timed(run) for _, run in runs] for _ in range(rounds)], axis=0)
        for n, (events, _), best in zip(numbers, runs, times, strict=True):
            rows.append(Row(method, n, events, *(best / events * 1e9).tolist(), memory()))
    return rows


def sharing(events: int, threads: int, turns: int) -> Iterator[tuple[float, float]]:
    """Yield the rate on threads, and that of as many processes, by the rate on one thread.

    One of each turn; the rate on one thread is the mean of a run before and a run after.
    """
    (_, one), (_, more) = monte_carlo(events, 1), monte_carlo(events, threads)
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(threads, context, monte_carlo_alone, (events,)) as pool:

        def apart() -> object:
            return list(pool.map(monte_carlo_alone, [events] * threads))

        for run in (one, more, apart):
            run()
        for _ in range(turns):
            before, together, processes, after = (timed(run)[0] for run in (one, more, apart, one))
            alone = 0.5 * (before + after)
            yield alone / together, threads * alone / processes


def monte_carlo_alone(events: int) -> None:
    """Run Monte Carlo on one thread; of a process of its own."""
    monte_carlo(events, 1)[1]()


def timed(run: Callable[[], object]) -> tuple[float, float]:
    clock, processor = time.perf_counter(), time.process_time()
    run()
    return time.perf_counter() - clock, time.process_time() - processor


def write(path: Path, rows: Sequence[Row]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(field.name for field in fields(Row))
        writer.writerows(astuple(row) for row in rows)


def report(rows: Sequence[Row]) -> None:
    heads = f"{'ns, clock':>12}{'ns, processor':>15}{'MiB':>8}"
    print(f"{'method':14}{'threads':>8}{'events':>12}{heads}")
    for row in rows:
        print(
            f"{row.method:14}{row.threads:8d}{row.events:12d}{row.nanoseconds_clock:12.1f}"
            f"{row.nanoseconds_processor:15.1f}{row.memory_mib:8.0f}"
        )


def plot(path: Path, rows: Sequence[Row]) -> None:
    """Time per event by the processor's clock and by the one on the wall, and memory."""
    figure = Figure(figsize=(12.0, 4.5), layout="constrained")
    FigureCanvasAgg(figure)
    *both, kept = figure.subplots(1, 3)
    both[1].sharey(both[0])
    series = sorted({(row.method, row.threads) for row in rows})
    panels = [
        (axes, f"nanoseconds_{c}") for axes, c in zip(both, ("processor", "clock"), strict=True)
    ]
    for axes, column in [*panels, (kept, "memory_mib")]:
        for method, threads in series:
            if axes is kept and method != "Monte Carlo":
                continue
            chosen = [row for row in rows if (row.method, row.threads) == (method, threads)]
            axes.plot(
                [row.events for row in chosen],
                [getattr(row, column) for row in chosen],
                "o-" if threads == 1 else "s--",
                color=f"C{sorted(MOST).index(method)}",
                label=f"{method}, {threads} thread" + ("s" if threads > 1 else ""),
            )
        axes.set(xscale="log", xlabel="events")
        axes.grid(visible=True, alpha=0.3)
    for axes, clock in zip(both, ("processor", "clock"), strict=True):
        axes.set(yscale="log", title=f"by the {clock}", ylabel="time per event / ns")
    kept.set(title="greatest memory of the process", ylabel="MiB")
    kept.set_ylim(0.0, 1.2 * kept.get_ylim()[1])
    figure.legend(*both[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    figure.savefig(path, dpi=200)


if __name__ == "__main__":
    main()
