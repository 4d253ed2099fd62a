"""Wrong forms of what few tests hold, put into a copy of the project one at a time.

    python -m tests.mutants [TEXT...]

A wrong form is noticed if a test of its modules fails. The misprints of the article are not among
them: the ledger of equations compares code, derivation and print. Compiled code comes along with
the copy; it rests on its own file alone, so none of it is stale. Ends with 1 if a wrong form
survived, or if the tests fail without it. TEXT: those whose name holds it.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from tests.shared import ROOT, copy_project, execute


class Mutant(NamedTuple):
    """A wrong form: its name, file in ``src``, text there once and in its place, test modules."""

    name: str
    path: str
    right: str
    wrong: str
    tests: str

    @property
    def modules(self) -> list[str]:
        """Files of the test modules, from the project's root."""
        paths = (path for name in self.tests.split() for path in ROOT.glob(f"tests/*/{name}.py"))
        return [str(path.relative_to(ROOT)) for path in paths]

    def apply(self, text: str) -> str:
        """Return a file's text with the wrong form in it."""
        if (count := text.count(self.right)) != 1:
            raise ValueError(f"{self.name}: {self.right!r} occurs {count} times in {self.path}")
        return text.replace(self.right, self.wrong)


INTERVALS = "lab/test_dispenser lab/test_reduction statistics/test_intervals"
MUTANTS = [Mutant(*row) for row in (
    ("pairs: each rebound one record late", "microimpact/lab/pdpa/pairing.py",
     "up[np.repeat(first, number) + within]",
     "up[np.minimum(np.repeat(first, number) + within + 1, up.size - 1)]", "lab/pdpa/test_pairing"),
    ("pairs: the last candidate of each left out", "microimpact/lab/pdpa/pairing.py",
     "number = last - first\n", "number = np.maximum(last - first - 1, 0)\n",
     "lab/pdpa/test_pairing"),
    ("pairs: sizes not compared", "microimpact/lab/pdpa/pairing.py",
     "np.square(growth[inside]) + ", "", "lab/pdpa/test_pairing"),
    ("interval: as many degrees of freedom as events", "microimpact/statistics/intervals.py",
     "stdtrit(events - 1 if", "stdtrit(events if", INTERVALS),
    ("interval: one-sided", "microimpact/statistics/intervals.py",
     "0.5 * (1.0 + level))", "level)", INTERVALS),
    ("camera: gravity upwards", "microimpact/lab/ptis/system.py",
     "[np.cos(alpha), 0.0, -np.sin(alpha)]", "[np.cos(alpha), 0.0, np.sin(alpha)]",
     "lab/ptis/test_ptis lab/ptis/test_tracks"),
    ("camera: no noise of the light itself", "microimpact/lab/ptis/frames.py",
     "level / instrument.electrons_per_count", "0.0 * level", "lab/ptis/test_ptis"),
    ("spots: pixels that touch by a corner are apart", "microimpact/lab/ptis/tracks.py",
     "bright[box], np.ones((3, 3))", "bright[box]", "lab/ptis/test_spots"),
    ("tracks: gravity gains speed after the surface", "microimpact/lab/ptis/tracks.py",
     "self.velocity - self.contact", "self.velocity + self.contact", "lab/ptis/test_tracks"),
    ("error model of imaging: no jitter of the pulses", "microimpact/lab/ptis/errors.py",
     "[jitter * velocity", "[0.0 * velocity", "lab/ptis/test_ptis_model"),
    ("drop height: factor 2 missing", "microimpact/lab/dispenser.py",
     "/ (2.0 * gravity)", "/ gravity", "lab/test_dispenser"),
    ("design: runs in the library's order", "microimpact/statistics/effects.py",
     "= design[order]", "= design[order[::-1]]", "statistics/test_designs"),
    ("design: half effects", "microimpact/statistics/effects.py",
     "2.0 / len(design)", "1.0 / len(design)", "studies/test_doe"),
    ("design: product of words as their union", "microimpact/statistics/effects.py",
     "set(first) ^ set(second)", "set(first) | set(second)", "studies/test_doe"),
    ("design: Lenth's degrees of freedom m for m/3", "microimpact/statistics/effects.py",
     "sizes.size / 3.0", "sizes.size", "studies/test_doe"),
    ("Monte Carlo: scatter of the sums for that of their ratio",
     "study/studies/analyses/monte_carlo/ensembles.py",
     "average * sums.accepted", "np.mean(values)", "studies/test_monte_carlo"),
    ("random numbers: parts of an analysis share one stream",
     "microimpact/statistics/distributions.py",
     "SeedSequence(seed, spawn_key=key)", "SeedSequence(seed)",
     "statistics/test_distributions studies/test_campaign lab/test_dispenser lab/pdpa/test_pdpa"),
    ("fits: constants left in the units of the fit", "microimpact/model/empirical/search.py",
     "parameters[:, [0, 2, V_C]] *=", "parameters[:, [V_C]] *=",
     "model/empirical/test_restitution_fit"),
    ("fits: captured spheres miss below v_c, as by the printed form",
     "microimpact/model/empirical/kernel.py",
     "kept if rebounds else 0.0", "kept if rebounds else 0.5", "model/empirical/test_search"),
)]  # fmt: skip


def failing(root: Path, modules: list[str]) -> str:
    """Return the first test that fails in a copy, or an empty text."""
    # Compiled code of other files may hold what the wrong form replaces.
    for compiled in (root / "src").rglob("*.nb[ci]"):
        compiled.unlink()
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    environment["PYTHONPATH"] = str(root / "src")
    command = (sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *modules)
    done = execute(*command, cwd=root, env=environment, check=False)
    lines = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return (lines or ["no collection"])[0] if done.returncode else ""


def noticed(root: Path, mutant: Mutant) -> bool:
    """Put a wrong form into a copy, see whether a test fails, and take it out again."""
    path, begin = root / "src" / mutant.path, time.perf_counter()
    right = path.read_text(encoding="utf-8")
    path.write_text(mutant.apply(right), encoding="utf-8")
    by = failing(root, mutant.modules)
    path.write_text(right, encoding="utf-8")
    print(f"{mutant.name}: {by or 'SURVIVED'} ({time.perf_counter() - begin:.0f} s)", flush=True)
    return bool(by)


def main() -> int:
    """Try the wrong forms and return the number of survivors."""
    mutants = [m for m in MUTANTS if all(text in m.name for text in sys.argv[1:])]
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        copy_project(root, "tests", "pyproject.toml")
        if by := failing(root, sorted({name for m in mutants for name in m.modules})):
            sys.exit(f"fails without any wrong form: {by}")
        return sum(not noticed(root, mutant) for mutant in mutants)


if __name__ == "__main__":
    sys.exit(min(main(), 1))
