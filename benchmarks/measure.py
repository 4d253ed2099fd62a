"""Runs of all methods in turn: times per impact, errors, and what could not be run."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from benchmarks.cases import Cases, Errors, Method, judge

# Slow methods compute no fewer cases than this.
FEWEST = 10
# Quick methods run several times within a round, for about this long, seconds.
MOMENT = 0.15


@dataclass(frozen=True, slots=True)
class Result:
    """One method at one setting.

    Attributes
    ----------
    times
        Microseconds per impact, one per round.
    setup
        Seconds of preparation that the times leave out: building and compiling.
    """

    method: str
    source: str
    setting: float
    impacts: int
    times: np.ndarray
    setup: float
    errors: Errors

    @property
    def best(self) -> float:
        """Shortest time per impact, microseconds: the least disturbed one."""
        return float(self.times.min())


@dataclass(frozen=True, slots=True)
class Measurement:
    """What was found about a set of cases; ``absent`` gives methods and why they did not run."""

    results: tuple[Result, ...]
    absent: tuple[tuple[str, str], ...]


def use_one_core() -> None:
    """Keep this process, and all that its libraries start, on one core."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def _load(names: Sequence[str]) -> tuple[list[type[Method]], list[tuple[str, str]]]:
    """Import methods by "module:Class"; those whose package is missing come with the reason."""
    methods, absent = [], []
    for name in names:
        module, _, attribute = name.partition(":")
        try:
            methods.append(getattr(import_module(f"benchmarks.{module}"), attribute))
        except (ImportError, OSError) as error:
            absent.append((name, str(error)))
    return methods, absent


def _shortest(run: Callable[[], Any]) -> float:
    """Shortest of as many runs as fit into `MOMENT`, and of one at least."""
    first = shortest = _timed(run)[0]
    for _ in range(int(MOMENT / first)):
        shortest = min(shortest, _timed(run)[0])
    return shortest


def _timed(run: Callable[[], Any]) -> tuple[float, Any]:
    start = time.perf_counter()
    value = run()
    return time.perf_counter() - start, value


def _runs(methods: Sequence[type[Method]]) -> Iterator[tuple[type[Method], float]]:
    return ((method, setting) for method in methods for setting in method.settings)


def measure(names: Sequence[str], cases: Cases, reference: np.ndarray, rounds: int) -> Measurement:
    """Run every method at every setting once in each round, so that noise hits all alike.

    Parameters
    ----------
    names
        Methods as "module:Class".
    cases, reference
        The impacts and their results (n,).
    rounds
        Number of rounds.
    """
    methods, absent = _load(names)
    prepared = []
    for method, setting in _runs(methods):
        stride = min(method.share, max(len(cases) // FEWEST, 1))
        part = cases.every(stride)
        building, run = _timed(lambda m=method, p=part, s=setting: m(p, s))
        first, values = _timed(run)
        errors = judge(np.array(values), reference[stride // 2 :: stride])
        prepared.append((method, setting, run, len(part), building + first, errors))
    seconds = np.array([[_shortest(entry[2]) for entry in prepared] for _ in range(rounds)])
    results = [
        Result(
            method.name, method.source, setting, count, times / count * 1e6,
            max(once - float(times.min()), 0.0), errors,
        )
        for (method, setting, _, count, once, errors), times in zip(
            prepared, seconds.T, strict=True
        )
    ]  # fmt: skip
    return Measurement(tuple(results), tuple(absent))
