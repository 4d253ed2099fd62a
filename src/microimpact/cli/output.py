"""Output of the commands: tables for people, JSON for programs, warnings on standard error."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from threading import Timer
from typing import Any

import click
import numpy as np

from microimpact.core.readable import table

PATIENCE = 2.0  # s


def number(value: Any, factor: float = 1.0) -> str:
    """Format a number in six digits, or as yes or no."""
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    return f"{value * factor:.6g}"


def print_json(values: Mapping[str, Any]) -> None:
    """Print JSON; infinite numbers, which JSON does not have, are null and named ``infinite``."""
    infinite: list[str] = []

    def plain(node: Any, name: str = "") -> Any:
        if isinstance(node, np.ndarray | np.generic):
            node = node.tolist()
        if isinstance(node, float) and not np.isfinite(node):
            infinite.append(name)
            return None
        if isinstance(node, Mapping):
            return {key: plain(child, str(key)) for key, child in node.items()}
        return [plain(child, name) for child in node] if isinstance(node, list | tuple) else node

    record = plain(values)
    if infinite:
        record["infinite"] = sorted(set(infinite))
    click.echo(json.dumps(record, indent=2, allow_nan=False))


def print_table(title: str, columns: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print a table below its title."""
    click.echo(f"{title}\n{table(rows, columns)}")


@contextmanager
def patience(work: str) -> Iterator[None]:
    """Name work on a terminal's standard error if it takes longer than `PATIENCE`."""
    timer = Timer(PATIENCE, click.echo, (f"microimpact: {work} ...",), {"err": True})
    timer.daemon = True
    if sys.stderr.isatty():
        timer.start()
    try:
        yield
    finally:
        timer.cancel()


def warn(sentences: Iterable[str]) -> None:
    """Print warnings to standard error."""
    for sentence in sentences:
        click.echo(f"Warning: {sentence}.", err=True)


# Numbers of a sweep.
MOST = 1_000_000


class Sweep(click.ParamType):  # type: ignore[type-arg]
    """One number, or ``first:last:count`` in equal steps."""

    name = "number or first:last:count"

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        """Parse the numbers as an array."""
        if not isinstance(value, str):
            return np.atleast_1d(np.asarray(value, dtype=float))
        try:
            if ":" in value:
                first, last, count = value.split(":")
                if 1 <= int(count) <= MOST:
                    return np.linspace(float(first), float(last), int(count))
                raise ValueError(count)
            return np.array([float(value)])
        except ValueError:
            self.fail(
                f"{value!r} is neither a number nor first:last:count, the count from 1 to {MOST}",
                param,
                ctx,
            )
