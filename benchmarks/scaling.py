"""Cost of an event where there are many: direct impacts, those by the table, and Monte Carlo.

    python -m benchmarks.scaling [--most 1e7] [--threads 1 2]

Times per event from a thousand events to ``--most``: if they stay, the cost is linear in the
events. They are the least of three rounds, by the clock and by the processor. Impacts are oblique,
with friction and spin and all their outcomes; restitution is e of normal ones alone. Monte Carlo
comes first, so that the greatest memory of the process until then is its own.
"""

from __future__ import annotations

import argparse
import resource
import sys
import time
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from microimpact import Contact, Material
from microimpact.model.dynamics.impact import simulate
from microimpact.model.law.table import tabulate
from microimpact.statistics.distributions import Normal, TruncatedNormal, Uniform
from study.analyses.fig23_monte_carlo.ensembles import (
    Ensemble,
    Plan,
    Process,
    RigidBody,
    Rules,
    estimate,
)

ANGLE_DEG = 20.0
SEED = 20011
ROUNDS = 3
BLOCK = 2**14  # Events of a replicate
# Monte Carlo draws whole replicates; more direct impacts would tell nothing new.
COUNTS = {
    "Monte Carlo": (10**5, 10**9),
    "direct": (10**3, 10**6),
    "restitution": (10**3, 10**8),
    "table": (10**3, 10**8),
}
SHARED = ("table",)  # among threads


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.scaling", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--most", type=float, default=1e7, help="largest number of events")
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    options = parser.parse_args(arguments)
    print("| method | threads | events | ns, clock | ns, processor | MiB |")
    print("| --- | ---: | ---: | ---: | ---: | ---: |")
    for method, (fewest, most) in COUNTS.items():
        for exponent in range(3, 10):
            if fewest <= 10**exponent <= min(most, options.most):
                threads = options.threads if method in SHARED else [1]
                for row in rows(method, 10**exponent, threads):
                    print(row)


def rows(method: str, count: int, threads: Sequence[int]) -> list[str]:
    """Rows of the table, one for each number of threads, which take turns."""
    if method == "Monte Carlo":
        runs = [monte_carlo(count)]
    else:
        runs = [impacts(method, count, n) for n in threads]
    for _, run in runs:
        run()
    times = np.min([[timed(run) for _, run in runs] for _ in range(ROUNDS)], axis=0)
    # Kilobytes on Linux, bytes on macOS.
    unit = 1024.0 ** (2 if sys.platform == "darwin" else 1)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit
    return [
        f"| {method} | {n} | {events} | {clock / events:.1f} | {own / events:.1f} | {memory:.0f} |"
        for n, (events, _), (clock, own) in zip(threads, runs, 1e9 * times, strict=True)
    ]


def timed(run: Callable[[], object]) -> tuple[float, float]:
    clock, processor = time.perf_counter(), time.process_time()
    run()
    return time.perf_counter() - clock, time.process_time() - processor


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


def monte_carlo(events: int) -> tuple[int, Callable[[], object]]:
    """Steel on a rough silicon surface, as in the article's Monte Carlo analysis (Fig. 23)."""
    process = Process(
        speed_m_per_s=Uniform(low=1.61, high=1.71),
        diameter_um=TruncatedNormal(mean=62.0, sd=4.5, low=45.0, high=76.0),
        spin_ratio=0.0,
        friction=0.15,
    )
    rough = Ensemble(
        process=process,
        slope=Normal(sd=0.223),
        two_axes=False,
        rules=Rules(facets="facing", must_leave=True, most_contacts=1),
        body=RigidBody.of(steel_on_silicon(), process),
        plan=Plan(replicates=max(2, -(-events // BLOCK)), events=BLOCK),
        seed=(SEED,),
    )
    return rough.plan.replicates * BLOCK, partial(estimate, rough, ANGLE_DEG)


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


if __name__ == "__main__":
    main()
