"""Time and error of one impact by several methods, side by side on one core.

    python -m benchmarks.compare [--quick] [--rounds N] [--output DIRECTORY] [--docs]

Every round runs every method at every setting once, so that whatever else the machine does hits all
alike; the shortest time over the rounds counts. Errors are differences from an integration in
80-bit numbers or from a closed form. Compare the ratios, not the times: those depend on the
machine. A method whose package is missing is named as absent.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks import report
from benchmarks.cases import make_cases, make_hertz_cases, make_jkr_cases
from benchmarks.measure import measure, use_one_core

ADHESIVE = (
    *("own:Package", "own:Kernel", "own:Table", "taylor:Scalar", "taylor:Batch"),
    *("solvers:DOP853", "solvers:RK45"),
)
HERTZ = ("own:Hertz", "granular:Hertz")
JKR = ("own:Jkr", "taylor:Jkr", "granular:Jkr")

PER_GROUP, PER_GROUP_QUICK, OTHERS = 6667, 1000, 2000
ROUNDS, ROUNDS_QUICK = 5, 2
PROJECT = Path(__file__).parents[1]


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.compare", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--quick", action="store_true", help="fewer impacts and rounds")
    parser.add_argument("--rounds", type=int, help="how often every method runs")
    parser.add_argument("--output", type=Path, default=PROJECT / "build" / "benchmarks",
                        help="folder of tables and plot")  # fmt: skip
    parser.add_argument("--docs", action="store_true", help="renew docs/performance.md, too")
    options = parser.parse_args(arguments)
    rounds = options.rounds or (ROUNDS_QUICK if options.quick else ROUNDS)

    use_one_core()
    try:
        from benchmarks.taylor import JkrReference, Reference
    except ImportError as error:
        parser.exit(1, f"heyoka makes the reference, and cannot be loaded: {error}\n")

    cases = make_cases(PER_GROUP_QUICK if options.quick else PER_GROUP)
    reference = Reference(cases, *Reference.settings)()
    undamped = (cases.hertz == 0.0) & (cases.adhesion == 0.0)
    captured, largest = np.count_nonzero(reference == 0.0), np.abs(reference[undamped] - 1.0).max()
    sets = [
        report.Set(
            "ring force",
            f"Ring force, damped ({len(cases):,} impacts, of which {captured:,} end in capture; "
            f"{rounds} rounds; the reference has e = 1 to {largest:.0e} where nothing is damped). "
            "Error: largest difference of e.",
            measure(ADHESIVE, cases, reference, rounds),
            report.KERNEL,
        )
    ]
    contacts = make_hertz_cases(OTHERS)
    sets.append(
        report.Set(
            "Hertz pair",
            f"Two Hertz spheres, undamped ({OTHERS:,}). Error: largest relative difference of the "
            "contact time from Hertz's.",
            measure(HERTZ, contacts, np.ones(OTHERS), rounds),
        )
    )
    for name, loss in (("jkr-pair", "without"), ("viscous-jkr-pair", "with")):
        pairs = make_jkr_cases(OTHERS, name)
        e = JkrReference(pairs, *JkrReference.settings)()
        title = (
            f"Two JKR spheres {loss} viscous loss ({OTHERS:,}; none stick). Error: largest "
            "difference of e; LAMMPS's from its law, which breaks early."
        )
        sets.append(report.Set(name, title, measure(JKR, pairs, e, rounds)))
    report.write(options.output, sets)
    if options.docs:
        report.renew_docs(PROJECT / "docs", options.output)


if __name__ == "__main__":
    main()
