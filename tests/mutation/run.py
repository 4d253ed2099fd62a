"""Put wrong forms into copies of the project, one at a time, and see whether the tests notice.

    python -m tests.mutation.run [--workers N] [--only TEXT] [--output FILE]

A wrong form is caught if one of its test modules fails, or if its table differs from the reference.
Ends with 1 if any survived, or if the tests fail without it.
"""

from __future__ import annotations

import argparse
import csv
import os
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue

from tests.mutation.mutants import MUTANTS, Mutant

ROOT = Path(__file__).parents[2]
PARTS = (
    "Snakefile", "config", "profiles", "pyproject.toml", "src", "tests", "workflow",
)  # fmt: skip
COMPARE = """
import sys
from pathlib import Path
from microimpact.report.check.differences import compare_tables
from microimpact.report.check.results import read_cells
from microimpact.report.check.verify import FILE, read_tolerances
name, kept = sys.argv[1], Path("tests/reference")
tables = [read_cells(root / "tables" / f"{name}.csv") for root in (kept, Path("build/ci"))]
accepted = read_tolerances(kept / FILE).of(f"tables/{name}.csv")
sys.exit(bool(compare_tables(f"tables/{name}.csv", *tables, accepted)))
"""
# What pytest says of tests that failed; anything else is a fault of the run itself.
PASSED, FAILED = 0, 1
# Snakemake, too, ends with 1 where a job failed.
TIMEOUT = 900.0


@dataclass(frozen=True, slots=True)
class Outcome:
    """Whether one wrong form was caught, by what, and how long that took."""

    mutant: Mutant
    caught: bool
    by: str
    seconds: float


def call(root: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run Python in a copy of the project, with that copy's package."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    environment["PYTHONPATH"] = str(root / "src")
    return subprocess.run(
        [sys.executable, *arguments],
        cwd=root,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=TIMEOUT,
    )


def failing(root: Path, tests: tuple[str, ...]) -> str:
    """Return the first test that fails, or an empty text."""
    files = [f"tests/{name}.py" for name in tests]
    done = call(root, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *files)
    if done.returncode not in {PASSED, FAILED}:
        # A module that cannot even be imported has noticed, too.
        return f"no collection: {done.stdout.strip().splitlines()[-1]}"
    failed = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return failed[0].split(" ")[1] if failed else ""


def moved(root: Path, table: str) -> str:
    """Return the table if it can no longer be made or differs from its reference."""
    done = call(
        root, "-m", "snakemake", "--cores", "1", "--quiet", "all", "--configfile",
        "config/ci.yaml", "--", f"build/ci/tables/{table}.csv",
    )  # fmt: skip
    if done.returncode:
        return f"{table}: not made"
    return table if call(root, "-c", COMPARE, table).returncode else ""


def noticed(root: Path, mutant: Mutant) -> str:
    """Return what notices the state of a copy, or an empty text."""
    return failing(root, mutant.tests) if mutant.tests else moved(root, mutant.table)


def attempt(copies: SimpleQueue[Path], mutant: Mutant) -> Outcome:
    """Put one wrong form into a free copy, see what notices, and take it out again."""
    root, begin = copies.get(), time.perf_counter()
    file = root / mutant.path
    right = file.read_text(encoding="utf-8")
    try:
        file.write_text(mutant.apply(right), encoding="utf-8")
        by = noticed(root, mutant)
    finally:
        file.write_text(right, encoding="utf-8")
        copies.put(root)
    outcome = Outcome(mutant, bool(by), by, time.perf_counter() - begin)
    print(
        f"{'caught' if by else 'SURVIVED':9}{outcome.seconds:6.1f} s  {mutant.name}  {by}",
        flush=True,
    )
    return outcome


def unaltered(copies: SimpleQueue[Path], mutants: list[Mutant]) -> list[str]:
    """Return what fails without any wrong form: such tests would catch everything."""
    root = copies.get()
    modules = tuple(sorted({name for mutant in mutants for name in mutant.tests}))
    tables = sorted({mutant.table for mutant in mutants if mutant.table})
    found = [failing(root, modules)] if modules else []
    found += [moved(root, table) for table in tables]
    copies.put(root)
    return [name for name in found if name]


def main() -> int:
    """Run all wrong forms and report the survivors."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--only", default="", help="only those whose name holds this text")
    parser.add_argument("--output", type=Path, default=ROOT / "build/mutants.csv")
    options = parser.parse_args()
    mutants = [mutant for mutant in MUTANTS if options.only in mutant.name]
    with tempfile.TemporaryDirectory() as folder:
        copies: SimpleQueue[Path] = SimpleQueue()
        for number in range(options.workers):
            root = Path(folder) / str(number)
            root.mkdir()
            for part in PARTS:
                source = ROOT / part
                (shutil.copytree if source.is_dir() else shutil.copy2)(source, root / part)
            copies.put(root)
        if broken := unaltered(copies, mutants):
            print(f"fails without any wrong form: {', '.join(broken)}", file=sys.stderr)
            return 1
        with ThreadPoolExecutor(options.workers) as pool:
            outcomes = list(pool.map(lambda mutant: attempt(copies, mutant), mutants))
    options.output.parent.mkdir(parents=True, exist_ok=True)
    with options.output.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(("wrong form", "file", "caught", "by", "seconds"))
        for each in outcomes:
            rows.writerow(
                (each.mutant.name, each.mutant.path, each.caught, each.by, f"{each.seconds:.1f}")
            )
    survivors = [each.mutant.name for each in outcomes if not each.caught]
    print(f"{len(outcomes) - len(survivors)} of {len(outcomes)} caught; see {options.output}")
    for name in survivors:
        print(f"survived: {name}")
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
