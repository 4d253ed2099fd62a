"""Output of the commands: tables for people, JSON for programs, warnings on standard error."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from threading import Timer
from typing import Any, TypeVar

import click
import numpy as np

from microimpact.core.readable import table

PATIENCE = 2.0  # s
Wrapped = TypeVar("Wrapped", bound=Callable[..., Any])


def echo(text: object, *, nl: bool = True, err: bool = False) -> None:
    """Print text; control characters, which a file may bring, as their escape sequences."""
    plain = (c if c.isprintable() or c in "\n\t" else repr(c)[1:-1] for c in str(text))
    click.echo("".join(plain), nl=nl, err=err)


def number(value: Any, factor: float = 1.0) -> str:
    """Format a number in four digits, or as yes or no."""
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    return f"{float(f'{value * factor:.4g}'):g}"


class Option(click.Option):
    """An option that the help lists below the name of its group."""

    def __init__(self, *names: Any, group: str, **settings: Any) -> None:
        super().__init__(*names, **settings)
        self.group = group


def option(group: str, *names: str, **settings: Any) -> Callable[[Wrapped], Wrapped]:
    """Return a decorator that gives a command an option of a group."""
    return click.option(*names, cls=Option, group=group, **settings)


class Command(click.Command):
    """A command whose help has the options in groups."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options, the groups in the order of their first ones, the others last."""
        groups: dict[str, list[tuple[str, str]]] = {}
        params = [param for param in self.get_params(ctx) if isinstance(param, click.Option)]
        for param in sorted(params, key=lambda param: not isinstance(param, Option)):
            if (record := param.get_help_record(ctx)) is not None:
                groups.setdefault(getattr(param, "group", "Options"), []).append(record)
        for name, records in groups.items():
            with formatter.section(name):
                formatter.write_dl(records)


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
    echo(json.dumps(record, indent=2, allow_nan=False))


def print_table(title: str, columns: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print a table below its title."""
    echo(f"{title}\n{table(rows, columns)}")


@contextmanager
def patience(work: str) -> Iterator[Callable[[str], None]]:
    """Name work that takes longer than `PATIENCE`; yield a function that says how far it is.

    Both on standard error, and only if that is a terminal.
    """
    terminal = sys.stderr.isatty()

    def say(text: str) -> None:
        if terminal:
            click.echo(f"microimpact: {text} ...", err=True)

    timer = Timer(PATIENCE, say, (work,))
    timer.daemon = True
    timer.start()
    try:
        yield say
    finally:
        timer.cancel()


def warn(sentences: Iterable[str]) -> None:
    """Print warnings to standard error."""
    for sentence in sentences:
        echo(f"Warning: {sentence}.", err=True)


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
            first, last, count = value.split(":") if ":" in value else (value, value, "1")
            ends, steps = (float(first), float(last)), int(count)
            if not 1 <= steps <= MOST or (":" in value and not np.all(np.isfinite(ends))):
                raise ValueError(count)
            return np.linspace(*ends, steps) if steps > 1 else np.array(ends[:1])
        except ValueError:
            self.fail(
                f"{value!r} is neither a number nor first:last:count of finite numbers, the count "
                f"from 1 to {MOST}",
                param,
                ctx,
            )
