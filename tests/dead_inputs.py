"""Change every declared value, one at a time, and list those whose change moves no output.

    python -m tests.dead_inputs [RESULTS] [--processes N] [--only TEXT] [--output FILE]

All 5,400 values take about five hours of one processor: two seconds for a value of a figure, which
half of them are, and from one to fifteen for the others, most for those of the campaign. ``--only``
takes the values whose key holds a text.

A value is dead if every study, ledger and figure rests on the same parameters after the change, or
if those that do not give the same tables, to the last bit. The values are those of the
configuration with the small settings merged, the numbers of the declared tables, and those of the
criteria of the claims, which must decide a verdict. Changes are tried in turn until one moves
something: a few per cent or one more, then a tenth and ten times, since a bound may lie far off; a
flag turned; another name that stands under the same key. A change that is refused counts for
nothing; a value all of whose changes are refused is told as not tested. One whose changes stop the
study is needed.

Left out are evidence and sources, paths, and words of figures that pages show as they stand. A
figure is drawn anew where its entry changed; words that show a parameter count as an output of it.
The table of declared inputs, which repeats every value, does not.

Tables of earlier studies come from RESULTS, a small run of the same state, which is checked first.
``dead_inputs.yaml`` names the dead values that are meant to be, with the reason. Ends with 1 if
there is any other, or if one of these is not dead; with 2 if the run is of another state.
"""

from __future__ import annotations

import argparse
import functools
import itertools
import json
import multiprocessing
import os
import re
import signal
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
import yaml
from rich.console import Console
from rich.progress import MofNCompleteColumn, Progress, TimeElapsedColumn, TimeRemainingColumn

from microimpact.core.tables import parse_table, read_figure_data, read_table
from microimpact.declared.documents import load
from microimpact.declared.parameters import build
from microimpact.declared.provenance import as_text, is_declaration
from microimpact.declared.references import is_reference, merged
from microimpact.declared.selection import DeclaredTable, NamedTables, read_all
from microimpact.figures.registry import FigureSpec, figure_spec
from microimpact.figures.style import save
from microimpact.ledgers import claims, equations
from microimpact.run.config import read_configuration, validate
from microimpact.run.inputs import read_inputs
from microimpact.studies import homes, needs, study
from microimpact.studies.claims import claim_numbers

ROOT = Path(__file__).parents[1]
EXCEPTIONS = Path(__file__).with_suffix(".yaml")

Key = tuple[str | int, ...]
Document = dict[str, Any]
Tables = Mapping[str, pd.DataFrame]


class Value(NamedTuple):
    """A declared value: its dotted key, and where it stands in the document."""

    key: str
    place: Key
    value: Any


class Rests(NamedTuple):
    """What a study or ledger is made from: its branch, and rows of declared tables as CSV."""

    branch: Any
    rows: Mapping[str, str]


# ---- What is known of the project: the declared document, what rests on it, and how to run that.

TABLES = ("materials", "contacts", "printed_values", "external")
NUMBERS = ("value", "low", "high", "at", "reading_error")
# The columns that name a row of each table.
NAMES = {
    "materials": ("material", "property"),
    "contacts": ("particle", "surface", "property"),
    "printed_values": ("key",),
    "external": ("name", "quantity", "reading", "at"),
}
# It repeats all values.
REPEATING = "declared_inputs"
# What of a figure is drawn; the other words stand beside it.
DRAWN = ("width", "height_mm", "evidence_labels", "panels")
FIGURES = "figures."
NUMBERS_OF_CLAIMS, DIGITISED = "claim_numbers", "digitised"
# The column of the ledger that repeats the criteria.
CRITERION = "criterion"


def declared() -> Document:
    """Return everything that is declared: the merged configuration, tables and claims."""
    config = merged(read_configuration(ROOT / "config"), load(ROOT / "config/ci.yaml"))
    document: Document = {"config": config}
    document |= {name: load(ROOT / config[name]) for name in ("claims", "figures")}
    found = read_all(*(str(ROOT / config[name]) for name in TABLES))
    for name in TABLES:
        rows = document[name] = {}
        for row in getattr(found, name).rows:
            label = ".".join(row[column] for column in NAMES[name])
            rows[label] = {k: float(v) if k in NUMBERS and v else v for k, v in row.items()}
    return document


def values(document: Document) -> Iterator[Value]:
    """Yield every declared value."""
    for key, node in document["config"].items():
        if key != "pathvars" and not isinstance(node, str):
            yield from _values(node, key, ("config", key))
    for name in TABLES:
        for label, row in document[name].items():
            for column in NUMBERS:
                if isinstance(row.get(column), float):
                    key = f"{name}: {label}.{column}"
                    yield Value(key, (name, label, column), row[column])
    for each in _values(document["claims"], "claims", ("claims",), with_provenance=False):
        if isinstance(each.value, int | float):
            yield each
    for figure, entry in document["figures"].items():
        yield from _drawn(figure, entry)


def _drawn(figure: str, entry: Mapping[str, Any]) -> Iterator[Value]:
    for part in sorted({*DRAWN} & {*entry}):
        key, place = f"{FIGURES}{figure}.{part}", ("figures", figure, part)
        yield from _values(entry[part], key, place, with_provenance=False)


def _values(node: Any, key: str, place: Key, *, with_provenance: bool = True) -> Iterator[Value]:
    inner = functools.partial(_values, with_provenance=with_provenance)
    if with_provenance and (is_declaration(node) or is_reference(node)):
        for part in node:
            if part not in {"evidence", "source"}:
                own = key if part in {"value", "values"} else f"{key}.{part}"
                yield from inner(node[part], own, (*place, part))
    elif isinstance(node, Mapping):
        for name, child in node.items():
            yield from inner(child, f"{key}.{name}", (*place, name))
    elif isinstance(node, list):
        for i, child in enumerate(node):
            yield from inner(child, f"{key}[{i}]", (*place, i))
    else:
        yield Value(key, place, node)


def resolved(document: Document) -> dict[str, Rests]:
    """Return what each study, ledger and figure rests on.

    Raises
    ------
    ValueError
        If the document is refused.
    """
    with tempfile.TemporaryDirectory() as folder:
        config = document["config"] | {
            name: _written(document[name], Path(folder) / f"{name}.csv") for name in TABLES
        }
        entries = Path(folder) / "figures.yaml"
        entries.write_text(json.dumps(document["figures"]), encoding="utf-8")
        config |= {"figures": str(entries), DIGITISED: str(ROOT / config[DIGITISED])}
        settings = validate(config, config)
        inputs = read_inputs(settings)
    rests = {name: Rests(branch, inputs.rows[name]) for name, branch in settings.branches.items()}
    del rests[REPEATING]
    steel = settings.tables.of_pair("stainless-steel-316", "silicon")
    rests["equations"] = Rests(None, steel)
    for name, claim in document["claims"].items():
        rests[f"claims.{name}"] = Rests({name: claim}, {})
    for name, entry in inputs.figure_entries.items():
        rests[f"{FIGURES}{name}"] = Rests(entry, {})
    return rests


def _written(rows: Mapping[str, Any], path: Path) -> str:
    """Write a declared table and return its path."""
    table = DeclaredTable("", tuple(next(iter(rows.values()))), tuple(map(_row, rows.values())))
    path.write_text(table.text(), encoding="utf-8")
    return str(path)


def _row(row: Mapping[str, Any]) -> dict[str, str]:
    return {column: as_text(cell) for column, cell in row.items()}


class Inputs(NamedTables):
    """Tables that a study is given: declared rows, and those of a run that it needs.

    A ledger, which needs whatever it asks for, is given that when it asks.
    """

    def __init__(self, name: str, rows: Mapping[str, str], results: Path) -> None:
        super().__init__({name: parse_table(text) for name, text in rows.items()})
        self.results = results
        if name in homes():
            self.update((table, self[table]) for table in needs(name))

    def __missing__(self, name: str) -> Any:
        path = self.results / f"tables/{name}.csv"
        return read_table(path) if path.exists() else super().__missing__(name)


def made(name: str, rests: Rests, results: Path) -> Tables:
    """Return the tables of a study that comes in one piece, or of a ledger; or a drawn figure."""
    if name.startswith(FIGURES):
        return {name: _picture(figure_spec(name.removeprefix(FIGURES), rests.branch), results)}
    inputs = Inputs(name, rests.rows, results)
    if name == "equations":
        return {name: equations.judge(inputs)}
    if name.startswith("claims."):
        return {name: _verdict(name.removeprefix("claims."), rests.branch, inputs)}
    of = study(name)
    tables: Tables = of.run(build(of.Params, rests.branch), inputs)
    return tables


def _picture(spec: FigureSpec, results: Path) -> pd.DataFrame:
    tables = {
        name: read_figure_data(results / f"data/{name}.csv", unit.x, unit.y)
        for name, unit in spec.data.items()
    }
    with tempfile.TemporaryDirectory() as folder:
        picture = Path(folder) / "figure.svg"
        save(getattr(import_module(spec.module), spec.function)(tables, spec), picture)
        words = spec.title, spec.caption, spec.article, *spec.tables.values()
        return pd.DataFrame([picture.read_text(encoding="utf-8"), *words])


def _verdict(name: str, criteria: Document, inputs: Inputs) -> pd.DataFrame:
    numbers = inputs[NUMBERS_OF_CLAIMS]
    inputs[NUMBERS_OF_CLAIMS] = numbers[numbers["claim"] == name]
    with tempfile.NamedTemporaryFile("w", suffix=".yaml", encoding="utf-8") as file:
        yaml.safe_dump({DIGITISED: load(ROOT / "config/claims.yaml")[DIGITISED], **criteria}, file)
        file.flush()
        judged = claims.judge(inputs, file.name)
    return judged.drop(columns=CRITERION)


# ---- Changes of a value.

# Each is tried in turn; so many that are not refused must move nothing before a value is dead, or
# stop the study before it is needed.
FACTORS = (1.05, 0.1, 10.0, 0.95)
TRIED = 3
# Names that are looked through.
MANY = 30
# A criterion decides if any bound whatever would give another verdict.
EXTREMES = (1e9, -1e9, 0.0)
OTHER_END = {"low": "high", "high": "low"}
SECONDS = 180


def changed(document: Any, place: Key, value: Any) -> Any:
    """Return a copy of a document in which another value stands at a place."""
    if not place:
        return value
    copy = document.copy()
    copy[place[0]] = changed(document[place[0]], place[1:], value)
    return copy


def at(document: Any, place: Key) -> Any:
    """Return what stands at a place."""
    for part in place:
        document = document[part]
    return document


def name_of(place: Key) -> str:
    """Return the last name of a place that is no number of an item."""
    parts = {"value", "values", "from"}
    names = [part for part in place if isinstance(part, str) and part not in parts]
    return names[-1]


def changes(each: Value, document: Document, refused: Sequence[str]) -> Iterator[tuple[Key, Any]]:
    """Yield what to put where, in place of a value; reads meanwhile what was refused, in words."""
    value = each.value
    if isinstance(value, bool):
        others: Iterator[Any] = iter([not value])
    elif isinstance(value, int | float):
        others = _numbers(each, document, refused)
    else:
        others = itertools.islice(_texts(each, document, refused), MANY)
    for other in others:
        yield each.place, other
    if isinstance(each.place[-1], int):  # without the item
        items = at(document, each.place[:-1])
        yield each.place[:-1], items[: each.place[-1]] + items[each.place[-1] + 1 :]
    elif isinstance(value, str):  # a kind of thing has keys of its own
        own = at(document, each.place[:-1])
        for other in itertools.islice(_likes(document["config"], str(each.place[-1]), value), MANY):
            yield each.place[:-1], own | {k: v for k, v in other.items() if isinstance(v, str)}
            yield each.place[:-1], other


def _numbers(each: Value, document: Document, refused: Sequence[str]) -> Iterator[float]:
    value = each.value
    if isinstance(value, int):
        others = dict.fromkeys((value + 1, value // 10, 10 * value, value - 1))
        yield from (other for other in others if other != value)
    elif value:
        yield from (factor * value for factor in FACTORS)
    else:
        yield from (0.05, 1.0, -0.05)
    for name in _allowed(refused, r"-?\d+(?:\.\d+)?"):
        if float(name) != value:
            yield type(value)(float(name))
    yield 2 * value  # where a power of two is asked for
    if each.place[0] == "claims":
        end = at(document, each.place[:-1]).get(OTHER_END.get(name_of(each.place)))
        yield from (*EXTREMES, *([] if end is None else [value + 0.999 * (end - value)]))


def _texts(each: Value, document: Document, refused: Sequence[str]) -> Iterator[str]:
    told = {each.value}
    branch = each.place[:2]
    alike = [one for one in _all(document) if name_of(one.place) == name_of(each.place)]
    alike.sort(key=lambda one: one.place[:2] != branch)
    for one in alike:
        if isinstance(one.value, str) and one.value not in told:
            told.add(one.value)
            yield one.value
    section, dot, _ = each.value.partition(".")
    if dot and "from" in each.place:
        names = document["printed_values"] if section == "printed" else document["config"][section]
        yield from (f"{section}.{name}" for name in names if f"{section}.{name}" not in told)
    for names in document["config"].values():  # of what a name is declared among
        if isinstance(names, Mapping) and each.value in names:
            yield from (name for name in names if name not in told)
    yield f"{each.value} changed"
    for name in _allowed(refused, "(?<=')[^',]+(?=')"):
        if name not in told:
            told.add(name)
            yield name


def _allowed(refused: Sequence[str], pattern: str) -> list[str]:
    """Return what a refusal says that a value must be."""
    return [name for line in refused for name in re.findall(pattern, line.partition("must be ")[2])]


_ALL: list[tuple[Document, list[Value]]] = []


def _all(document: Document) -> list[Value]:
    """Return all values, listed once for one document."""
    if not _ALL or _ALL[0][0] is not document:
        _ALL[:] = [(document, list(values(document)))]
    return _ALL[0][1]


def _likes(node: Any, name: str, value: str) -> Iterator[Any]:
    """Yield every mapping that has another text under the same name."""
    if isinstance(node, Mapping):
        if isinstance(node.get(name), str) and node[name] != value:
            yield node
        node = list(node.values())
    if isinstance(node, list):
        for child in node:
            yield from _likes(child, name, value)


# ---- What a change does.

# A study that comes in parts is first compared with one of them made anew: most changes show there.
PARTS = 8


VERDICTS = ("moved", "dead", "needed", "not tested")


@dataclass(frozen=True, slots=True, kw_only=True)
class Before:
    """What a study or ledger gives without any change, and how long it takes, s."""

    tables: Tables
    parts: Sequence[Any]
    seconds: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """What came of the changes of a value: one of `VERDICTS`, and what moved or refused it."""

    key: str
    value: Any
    verdict: str
    by: str = ""
    seconds: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class World:
    """The unchanged state, and the functions that lead from a document to tables."""

    document: Document
    results: Path
    resolve: Callable[[Document], Mapping[str, Rests]] = resolved
    rests: Mapping[str, Rests]
    before: dict[str, Before] = field(default_factory=dict)


def unchanged(name: str, world: World) -> Before:
    """Return what a study or ledger gives without any change."""
    start, rests = time.perf_counter(), world.rests[name]
    if not _in_parts(name):
        tables = made(name, rests, world.results)
        parts = _claims_by_cost(rests, world) if name == NUMBERS_OF_CLAIMS else []
    else:
        of, (params, inputs) = study(name), _given(name, rests, world)
        parts = [of.part(params, inputs, i, PARTS) for i in range(PARTS)]
        tables = of.gather(params, inputs, parts)
    return Before(tables=tables, parts=parts, seconds=time.perf_counter() - start)


def _claims_by_cost(rests: Rests, world: World) -> list[tuple[str, str]]:
    """Return every claim with its numbers as text, the quickest first."""
    params, inputs = _given(NUMBERS_OF_CLAIMS, rests, world)
    found = []
    for claim in claim_numbers.CLAIMS:
        start = time.perf_counter()
        text = claim_numbers.numbers_of(claim, params, inputs).to_csv()
        found.append((time.perf_counter() - start, claim, text))
    return [(claim, text) for _, claim, text in sorted(found)]


def _given(name: str, rests: Rests, world: World) -> tuple[Any, Inputs]:
    """Return what a study is run with."""
    return build(study(name).Params, rests.branch), Inputs(name, rests.rows, world.results)


def _in_parts(name: str) -> bool:
    return name in homes() and name != NUMBERS_OF_CLAIMS and hasattr(study(name), "gather")


def moved(name: str, rests: Rests, world: World) -> bool:
    """Tell whether a study or ledger gives other tables from what it rests on after a change."""
    before = world.before[name]
    if not before.parts:
        return _differ(made(name, rests, world.results), before.tables)
    of, (params, inputs) = study(name), _given(name, rests, world)
    if name == NUMBERS_OF_CLAIMS:  # one claim that moves is enough, or else a draw
        return any(
            of.numbers_of(claim, params, inputs).to_csv() != text for claim, text in before.parts
        ) or _differ(made(name, rests, world.results), before.tables)
    first = of.part(params, inputs, 0, PARTS)
    try:
        if _differ(of.gather(params, inputs, [first, *before.parts[1:]]), before.tables):
            return True
    except Exception:  # noqa: BLE001  parts before and after a change may not fit together
        pass
    rest = [of.part(params, inputs, i, PARTS) for i in range(1, PARTS)]
    return _differ(of.gather(params, inputs, [first, *rest]), before.tables)


def _differ(now: Tables, before: Tables) -> bool:
    return set(now) != set(before) or not all(table.equals(before[n]) for n, table in now.items())


def tried(each: Value, world: World) -> Found:
    """Change a value until an output moves."""
    start = time.perf_counter()
    refused: list[str] = []
    stopped: list[str] = []
    unmoved, most = 0, TRIED if each.place[0] != "claims" else sys.maxsize
    same = False  # nothing rests on a change: another place may have the same value
    verdict, by = "", ""
    for place, other in changes(each, world.document, refused):
        try:
            after = world.resolve(changed(world.document, place, other))
        except Exception as error:  # noqa: BLE001  whatever is raised refuses the value
            refused.append(f"{other!r}: {error}")
            continue
        others = {name: after[name] for name in after if after[name] != world.rests[name]}
        same = same or not others
        if lines := [line for name in others for line in _made_known(name, world)]:
            return Found(key=each.key, value=each.value, verdict="stale", by="\n".join(lines))
        signal.alarm(SECONDS)
        try:
            by = _mover(others, world)
        except Exception as error:  # noqa: BLE001  whatever a study raises stops it
            stopped.append(f"{other!r}: {type(error).__name__}: {error}")
        else:
            unmoved += not by and (bool(others) or "from" not in each.place)
        finally:
            signal.alarm(0)
        if by or most in {unmoved, len(stopped)}:
            break
    if by:
        verdict = "moved"
    elif unmoved or (same and not stopped):
        verdict = "dead"
    elif stopped:
        verdict, by = "needed", stopped[0]
    else:
        verdict, by = "not tested", "; ".join(refused)[:200]
    seconds = time.perf_counter() - start
    return Found(key=each.key, value=each.value, verdict=verdict, by=by, seconds=seconds)


def _made_known(name: str, world: World) -> list[str]:
    """Make a study or ledger without a change, once; return what contradicts that in the run."""
    if name in world.before:
        return []
    before = unchanged(name, world)
    if not (lines := stale(before, world.results)):
        world.before[name] = before
    return lines


def stale(before: Before, results: Path) -> list[str]:
    """Return the tables of a run that are not what a study gives."""
    return [
        f"{path} is not of this state; make the run anew"
        for name, table in before.tables.items()
        for path in (results / f"{folder}/{name}.csv" for folder in ("tables", "data"))
        if path.exists()
        and path.read_text(encoding="utf-8") != table.to_csv(index=False, lineterminator="\n")
    ]


def _mover(others: Mapping[str, Rests], world: World) -> str:
    """Return the first study or ledger that gives other tables; the quickest are asked first.

    Last come the words of figures: a value that moves nothing else is told.
    """
    for name in sorted(others, key=lambda n: (n.startswith(FIGURES), world.before[n].seconds)):
        if moved(name, others[name], world):
            return name
    return ""


# ---- The list.


def exceptions(path: Path = EXCEPTIONS) -> dict[str, str]:
    """Return the reason of each pattern of keys, in which * stands for any text."""
    return {str(pattern): str(reason) for pattern, reason in load(path).items()}


def fits(pattern: str, key: str) -> bool:
    """Tell whether a key is of a pattern."""
    return re.fullmatch(".*".join(map(re.escape, pattern.split("*"))), key) is not None


def faults(found: Sequence[Found], meant: Mapping[str, str]) -> list[str]:
    """Return a line for each dead value that is not meant to be, and each that is and is not."""
    lines = [
        f"{one.key}: {one.value!r} moves no output"
        for one in found
        if one.verdict == "dead" and not any(fits(pattern, one.key) for pattern in meant)
    ]
    for pattern in meant:
        own = [one for one in found if fits(pattern, one.key)]
        if not own:
            lines.append(f"{EXCEPTIONS.name}, {pattern}: no such value")
        lines += [
            f"{EXCEPTIONS.name}, {pattern}: {one.key} is {one.verdict}, not dead"
            for one in own
            if one.verdict != "dead"
        ]
    return lines


def kind(value: object) -> str:
    """Return what kind of value it is, in a word."""
    return {bool: "flag", int: "whole number", float: "number"}.get(type(value), "text")


def report(found: Sequence[Found], seconds: float) -> str:
    """Return the counts, and all values that were not moved, in words."""
    counts = Counter((kind(one.value), one.verdict) for one in found)
    lines = [f"{'':14}{'values':>8}" + "".join(f"{verdict:>12}" for verdict in VERDICTS)]
    for name in (*sorted({kind(one.value) for one in found}), "all"):
        own = [sum(n for (k, v), n in counts.items() if name in {k, "all"} and v == verdict)
               for verdict in VERDICTS]  # fmt: skip
        lines.append(f"{name:14}{sum(own):>8}" + "".join(f"{n:>12}" for n in own))
    lines.append(f"{seconds:.0f} s")
    words = [
        one.key for one in found if one.by.startswith(FIGURES) and not one.key.startswith(FIGURES)
    ]
    lines += ["", f"Moved, but words of figures alone: {len(words)}", *words]
    for verdict in VERDICTS[1:]:
        unmoved = [one for one in found if one.verdict == verdict]
        lines += ["", f"{verdict.capitalize()}: {len(unmoved)}"]
        lines += [f"{o.key}: {o.value!r}{f'  ({o.by})' if o.by else ''}" for o in unmoved]
    return "\n".join(lines) + "\n"


# Workers are forked with it.
_WORLD: list[World] = []


def _tried(each: Value) -> Found:
    return tried(each, _WORLD[0])


def _too_long(*_: object) -> None:
    raise TimeoutError(f"more than {SECONDS} s")


def _begin() -> None:
    warnings.simplefilter("ignore")
    signal.signal(signal.SIGALRM, _too_long)


def all_of(work: Callable[[Value], Found], items: Sequence[Value], processes: int) -> list[Found]:
    """Return what came of each value, in any order, with a bar for the progress."""
    columns = (*Progress.get_default_columns()[:2], MofNCompleteColumn(), TimeElapsedColumn())
    with (
        multiprocessing.get_context("fork").Pool(processes, _begin) as pool,
        Progress(*columns, TimeRemainingColumn(), console=Console(stderr=True)) as bar,
    ):
        found = pool.imap_unordered(work, items)
        return list(bar.track(found, len(items), description="one change at a time"))


def main(arguments: Sequence[str] | None = None) -> int:
    """Try all values and print the list."""
    parser = argparse.ArgumentParser(prog="python -m tests.dead_inputs", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("results", type=Path, nargs="?", default=ROOT / "build/ci")
    parser.add_argument("--processes", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--only", default="", help="values whose key holds this text")
    parser.add_argument("--output", type=Path, help="write the list here, too")
    given = parser.parse_args(arguments)
    start = time.perf_counter()
    document = declared()
    rests = resolved(document)
    world = World(document=document, results=given.results, rests=rests)
    _WORLD[:] = [world]
    wanted = [each for each in values(document) if given.only in each.key]
    order = {each.key: i for i, each in enumerate(wanted)}
    found = all_of(_tried, wanted, given.processes)
    if lines := sorted(
        {line for one in found if one.verdict == "stale" for line in one.by.split("\n")}
    ):
        sys.stderr.write("\n".join(lines) + "\n")
        return 2
    found.sort(key=lambda one: order[one.key])
    text = report(found, time.perf_counter() - start)
    sys.stdout.write(text)
    if given.output:
        given.output.write_text(text, encoding="utf-8")
    meant = {
        pattern: reason
        for pattern, reason in exceptions().items()
        if not given.only or any(fits(pattern, one.key) for one in found)
    }
    lines = faults(found, meant)
    sys.stderr.write("".join(f"{line}\n" for line in lines))
    return bool(lines)


if __name__ == "__main__":
    sys.exit(main())
