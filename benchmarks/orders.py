"""Cost of direct integration against the order of its series and the impacts side by side.

    python -m benchmarks.orders [--rounds 20]

Copies of the kernel with other constants take turns on the same impacts; shortest times count.
"""

from __future__ import annotations

import argparse
import importlib.util
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

import numpy as np

from benchmarks.scaling import SEED, steel_on_silicon
from microimpact.model.dynamics import kernel
from microimpact.model.dynamics.normal import scaled_problems

IMPACTS = 2048
VARIANTS = (*((order, 32) for order in (14, 16, 18, 20, 22, 24, 26)), (20, 16), (20, 64))
REFERENCE = 26, 32, "1e-17"


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.orders", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--rounds", type=int, default=20)
    rounds = parser.parse_args(arguments).rounds
    speed = np.random.default_rng(SEED).uniform(0.2, 3.0, IMPACTS)
    problems = scaled_problems(steel_on_silicon(), speed)[0]
    with tempfile.TemporaryDirectory() as folder:
        exact = run(changed(Path(folder), *REFERENCE), problems)[1]
        variants = {v: changed(Path(folder), *v, str(kernel.TOLERANCE)) for v in VARIANTS}
        for module in variants.values():
            run(module, problems)  # compiled here
        times = dict.fromkeys(variants, np.inf)
        for _ in range(rounds):
            times = {v: min(times[v], run(m, problems)[0]) for v, m in variants.items()}
        print("| order | side by side | ns per impact | steps | ns per step | error of e |")
        print("| ---: | ---: | ---: | ---: | ---: | ---: |")
        for (order, lanes), module in variants.items():
            found = run(module, problems)[1]
            assert np.array_equal(found[:, kernel.STATUS], exact[:, kernel.STATUS])
            free = exact[:, kernel.STATUS] == kernel.REBOUND
            error = np.abs(found - exact)[free, kernel.END_U] / problems[free, kernel.START_U]
            each, steps = times[order, lanes] / IMPACTS * 1e9, found[:, kernel.STEPS].mean()
            print(
                f"| {order} | {lanes} | {each:.0f} | {steps:.1f} | {each / steps:.0f} "
                f"| {error.max():.0e} |"
            )


def changed(folder: Path, order: int, lanes: int, tolerance: str) -> ModuleType:
    """Return a copy of the kernel with other constants."""
    text = Path(kernel.__file__).read_text(encoding="utf-8")
    for name, value in (("ORDER", order), ("LANES", lanes), ("TOLERANCE", tolerance)):
        line = f"\n{name} = {getattr(kernel, name)}\n"
        assert line in text, line
        text = text.replace(line, f"\n{name} = {value}\n")
    path = folder / f"kernel_{order}_{lanes}_{tolerance.replace('-', '_')}.py"
    path.write_text(text, encoding="utf-8")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module
    spec.loader.exec_module(module)
    return module


def run(module: ModuleType, problems: np.ndarray) -> tuple[float, np.ndarray]:
    results = np.zeros((len(problems), kernel.RESULT_COLUMNS))
    start = time.perf_counter()
    module.integrate(problems, kernel.PLAIN, results)
    return time.perf_counter() - start, results


if __name__ == "__main__":
    main()
