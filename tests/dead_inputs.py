"""Change every declared value, one at a time, and list those whose change moves no output.

    python -m tests.dead_inputs [RESULTS] [--processes N] [--only TEXT]

All 4,300 values take about an hour and a half of one processor, after the run: half a second for
one of a figure, one or two for most others. ``--only`` takes the values whose key holds a text.

A value is dead if every study, ledger and figure rests on the same parameters after the change, or
if those that do not give the same tables, to the last bit. The values are those of the
configuration with the small settings merged, the numbers of the declared tables, and those of the
criteria of the claims, which must decide a verdict. Changes are tried in turn until one moves
something: a few per cent or one more, then a tenth and ten times, since a bound may lie far off; a
flag turned; another name that stands under the same key; in place of a reference a number, then
another place. A change that is refused counts for nothing; a value all of whose changes are
refused, or leave it as it is, is told as not tested. One whose changes stop the study is needed.

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
import io
import itertools
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
from contextlib import suppress
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import pandas as pd
import yaml
from rich.console import Console
from rich.progress import track

from microimpact.core.tables import parse_table, read_figure_data, read_table
from microimpact.declared.documents import load
from microimpact.declared.parameters import build
from microimpact.declared.provenance import as_text, finite_number, is_declaration
from microimpact.declared.references import is_reference, merged
from microimpact.declared.selection import TABLES, DeclaredTable, NamedTables, read_all
from microimpact.figures.registry import FigureSpec, figure_spec, filled
from microimpact.figures.style import UNDATED, context
from microimpact.ledgers import claims, equations
from microimpact.run.config import read_configuration, read_inputs, validate
from microimpact.studies import homes, needs, study
from microimpact.studies.claims import claim_numbers

ROOT = Path(__file__).parents[1]
EXCEPTIONS = Path(__file__).with_suffix(".yaml")

Key = tuple[str | int, ...]
Document = dict[str, Any]
Tables = Mapping[str, pd.DataFrame]


class Value(NamedTuple):
    """A declared value: its dotted key, and where it stands in the document.

    A text of the figure registry to which aliases refer stands in several places.
    """

    key: str
    places: tuple[Key, ...]
    value: Any

    @property
    def place(self) -> Key:
        """Its first place."""
        return self.places[0]


class Rests(NamedTuple):
    """What a study or ledger is made from: its branch, and rows of declared tables as CSV."""

    branch: Any
    rows: Mapping[str, str]


Rested = Mapping[str, Rests]


# ---- What is known of the project: the declared document, what rests on it, and how to run that.

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
DRAWN = ("width", "height_mm", "columns", "legend_columns", "evidence_labels", "panels")
FIGURES = "figures."
NUMBERS_OF_CLAIMS, DIGITISED = "claim_numbers", "digitised"
# The column of the ledger that repeats the criteria.
CRITERION = "criterion"


def declared() -> Document:
    """Return everything that is declared: the merged configuration, tables and claims."""
    config = merged(read_configuration(ROOT / "config"), load(ROOT / "config/ci.yaml"))
    document: Document = {"config": config}
    document |= {name: load(ROOT / config[name]) for name in ("claims", "figures")}
    document["places"] = written(ROOT / config["figures"])
    found = read_all(*(str(ROOT / config[name]) for name in TABLES))
    for name in TABLES:
        rows = document[name] = {}
        for row in getattr(found, name).rows:
            label = ".".join(row[column] for column in NAMES[name])
            rows[label] = {
                k: float(v) if k in NUMBERS and finite_number(v) else v for k, v in row.items()
            }
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
                    yield Value(key, ((name, label, column),), row[column])
    of_claims = _values(document["claims"], "claims", ("claims",), with_provenance=False)
    yield from (each for each in of_claims if isinstance(each.value, int | float))
    drawn = (places for places in document["places"] if places[0][2] in DRAWN)
    for places in drawn:
        parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in places[0])
        yield Value("".join(parts)[1:], places, at(document, places[0]))


def written(path: Path) -> list[tuple[Key, ...]]:
    """Return where each value of a YAML file stands once its aliases are followed."""
    found: dict[int, list[Key]] = {}

    def follow(node: Any, place: Key) -> None:
        if isinstance(node, yaml.MappingNode):
            loader.flatten_mapping(node)
            for name, child in {name.value: child for name, child in node.value}.items():
                follow(child, (*place, name))
        elif isinstance(node, yaml.SequenceNode):
            for i, child in enumerate(node.value):
                follow(child, (*place, i))
        else:
            found.setdefault(id(node), []).append(place)

    loader = yaml.SafeLoader(path.read_text(encoding="utf-8"))
    root = loader.get_single_node()
    follow(root, ("figures",))
    return [tuple(places) for places in found.values()]


def _values(node: Any, key: str, place: Key, *, with_provenance: bool = True) -> Iterator[Value]:
    inner = functools.partial(_values, with_provenance=with_provenance)
    if with_provenance and (is_declaration(node) or is_reference(node)):
        passed = {"evidence", "source"} | ({"from"} if {"value", "values"} & {*node} else set())
        for part in node:
            if part not in passed:  # what is beside a reference stands in place of what it names
                own = key if part in {"value", "values"} else f"{key}.{part}"
                yield from inner(node[part], own, (*place, part))
    elif isinstance(node, Mapping):
        for name, child in node.items():
            yield from inner(child, f"{key}.{name}", (*place, name))
    elif isinstance(node, list):
        for i, child in enumerate(node):
            yield from inner(child, f"{key}[{i}]", (*place, i))
    else:
        yield Value(key, (place,), node)


def resolved(
    document: Document, part: str = "config", known: Rested = MappingProxyType({})
) -> Rested:
    """Return what each study, ledger and figure rests on.

    Only claims or figures are read anew if they are the part that differs from a known document.

    Raises
    ------
    ValueError
        If the document is refused.
    """
    if part == "figures":
        branches = {name: rests.branch for name, rests in known.items()}
        entries = filled(document["figures"], branches)
        figures = {f"{FIGURES}{name}": Rests(entry, {}) for name, entry in entries.items()}
        for name, rests in figures.items():
            if rests != known[name]:
                figure_spec(name.removeprefix(FIGURES), rests.branch)
        return {**known, **figures}
    claimed = {f"claims.{name}": Rests({name: c}, {}) for name, c in document["claims"].items()}
    if part == "claims":
        return {**known, **claimed}
    with tempfile.TemporaryDirectory() as folder:
        config = document["config"] | {
            name: _table(document[name], Path(folder) / f"{name}.csv") for name in TABLES
        }
        settings = validate(config, config)
        inputs = read_inputs(settings)
    rests = {name: Rests(branch, inputs.rows[name]) for name, branch in settings.branches.items()}
    del rests[REPEATING]
    steel = settings.tables.of_pair("stainless-steel-316", "silicon")
    entries = inputs.figure_entries.items()
    figures = {f"{FIGURES}{name}": Rests(entry, {}) for name, entry in entries}
    return {**rests, "equations": Rests(None, steel), **claimed, **figures}


def _table(rows: Mapping[str, Any], path: Path) -> str:
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
        return {name: equations.judge(inputs)["equations"]}
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
    figure = getattr(import_module(spec.module), spec.function)(tables, spec)
    picture = io.StringIO()
    with context():
        figure.set_layout_engine(None)  # to find room for all takes longer than all else
        figure.savefig(picture, format="svg", metadata=dict.fromkeys(UNDATED["svg"]))
    words = spec.title, spec.caption, spec.article, *spec.tables.values()
    return pd.DataFrame([picture.getvalue(), *words])


def _verdict(name: str, criteria: Document, inputs: Inputs) -> pd.DataFrame:
    numbers = inputs[NUMBERS_OF_CLAIMS]
    inputs[NUMBERS_OF_CLAIMS] = numbers[numbers["claim"] == name]
    with tempfile.NamedTemporaryFile("w", suffix=".yaml", encoding="utf-8") as file:
        yaml.safe_dump({DIGITISED: load(ROOT / "config/claims.yaml")[DIGITISED], **criteria}, file)
        file.flush()
        judged = claims.judge(inputs, file.name)["claims"]
    return judged.drop(columns=CRITERION)


# ---- Changes of a value.

# Each is tried in turn; so many that are not refused must move nothing before a value is dead, or
# stop the study before it is needed.
FACTORS = (1.05, 0.1, 10.0, 0.95, 1.02)
TRIED = 3
# Names that are looked through.
MANY = 30
# A criterion decides if any bound whatever would give another verdict.
EXTREMES = (1e9, -1e9, 0.0)
NUMBER = r"-?\d+(?:\.\d+)?"
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


def changes(each: Value, world: World, refused: Sequence[str]) -> Iterator[tuple[int, Any]]:
    """Yield what to put in place of a value, or so many storeys above it.

    Reads meanwhile what was refused, in words.
    """
    value, document = each.value, world.document
    if each.place[-1] == "from":  # a number of the user's, as another place may have the same
        for number in _named(each, world.rests, refused):
            yield 1, merged(at(document, each.place[:-1]), number)
    if isinstance(value, bool):
        others: Iterator[Any] = iter([not value])
    elif isinstance(value, int | float):
        others = _numbers(each, document, refused)
    else:
        others = itertools.islice(_texts(each, world, refused), MANY)
    told = [value]
    for other in others:
        if other not in told:
            told.append(other)
            yield 0, other
    if isinstance(each.place[-1], int):  # without the item
        items = at(document, each.place[:-1])
        yield 1, items[: each.place[-1]] + items[each.place[-1] + 1 :]
    elif isinstance(value, str):  # a kind of thing has keys of its own
        own = at(document, each.place[:-1])
        for other in itertools.islice(_likes(document["config"], str(each.place[-1]), value), MANY):
            yield 1, own | {k: v for k, v in other.items() if isinstance(v, str)}
            yield 1, other


def _numbers(each: Value, document: Document, refused: Sequence[str]) -> Iterator[float]:
    value = each.value
    if isinstance(value, int):
        yield from (value + 1, value // 10, 10 * value, value - 1)
    elif value:
        yield from (factor * value for factor in FACTORS)
    else:
        yield from (0.05, 1.0, -0.05)
    yield from (type(value)(float(name)) for name in _allowed(refused, NUMBER))
    yield 2 * value  # where a power of two is asked for
    if each.place[0] == "claims":
        end = at(document, each.place[:-1]).get(OTHER_END.get(name_of(each.place)))
        yield from (*EXTREMES, *([] if end is None else [value + 0.999 * (end - value)]))


def _named(each: Value, rests: Rested, refused: Sequence[str]) -> Iterator[Any]:
    """Yield numbers beside those that a study is given by a reference, and any that are allowed."""
    with suppress(KeyError, IndexError, TypeError, StopIteration, ValueError):
        found: Any = rests[str(each.place[1])].branch
        for part in each.place[2:-1]:  # items of a list may stand by their names
            named = isinstance(found, list) and isinstance(part, str)
            found = next(i for i in found if part in i.values()) if named else found[part]
        *others, last = found if isinstance(found, list) else [found]
        if all(type(number) in {int, float} for number in (*others, last)):
            for factor in FACTORS:  # the last alone, since only ratios may count
                other = type(last)(factor * last)
                yield [*others, other] if isinstance(found, list) else other
    yield from map(float, _allowed(refused, NUMBER))


def _texts(each: Value, world: World, refused: Sequence[str]) -> Iterator[str]:
    branch, config = each.place[:2], world.document["config"]
    alike = world.texts[name_of(each.place)]
    yield from sorted(alike, key=lambda text: branch not in alike[text])
    section, dot, _ = each.value.partition(".")
    if dot and "from" in each.place:
        names = world.document["printed_values"] if section == "printed" else config[section]
        yield from (f"{section}.{name}" for name in names)
    for names in config.values():  # of what a name is declared among
        if isinstance(names, Mapping) and each.value in names:
            yield from names
    yield f"{each.value} changed"
    yield from _allowed(refused, "(?<=')[^',]+(?=')")


def _allowed(refused: Sequence[str], pattern: str) -> list[str]:
    """Return what a refusal says that a value must be."""
    return [name for line in refused for name in re.findall(pattern, line.partition("must be ")[2])]


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

# A study that comes in parts is compared whenever one more of them is made anew.
PARTS = 8

VERDICTS = ("moved", "dead", "needed", "not tested")


class StaleRunError(Exception):
    """A run that is of another state: a line for each table that differs."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Before:
    """What a study or ledger gives without any change, and how long it takes, s.

    One that comes in parts has these by index or claim, the order in which to look at them, and
    the last that moved.
    """

    tables: Tables
    parts: Mapping[Any, Any] = field(default_factory=dict)
    order: Sequence[Any] = ()
    last: list[Any] = field(default_factory=list)
    seconds: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """What came of the changes of a value: one of `VERDICTS`, and what moved or refused it."""

    key: str
    value: Any
    verdict: str
    by: str = ""


@dataclass(frozen=True, kw_only=True)
class World:
    """The unchanged state, and the functions that lead from a document to tables."""

    document: Document
    results: Path
    resolve: Callable[[Document, str, Rested], Rested] = resolved
    rests: Rested
    before: dict[str, Before] = field(default_factory=dict)

    @functools.cached_property
    def texts(self) -> Mapping[str, dict[str, set[Key]]]:
        """The branches in which each text stands, by the last name of its place."""
        found: dict[str, dict[str, set[Key]]] = {}
        for one in values(self.document):
            if isinstance(one.value, str):
                own = found.setdefault(name_of(one.place), {}).setdefault(one.value, set())
                own.add(one.place[:2])
        return found


def unchanged(name: str, world: World) -> Before:
    """Return what a study or ledger gives without any change."""
    start, rests = time.perf_counter(), world.rests[name]
    parts: dict[Any, Any] = {}
    if pieces := _pieces(name):
        of, given = study(name), _given(name, rests, world)
        times = {}
        for piece in pieces:
            begun = time.perf_counter()
            parts[piece] = _part(name, piece, given)
            times[piece] = time.perf_counter() - begun
        pieces.sort(key=times.__getitem__)
    if pieces and name != NUMBERS_OF_CLAIMS:
        tables = of.gather(*given, list(parts.values()))
    else:
        tables = made(name, rests, world.results)
    seconds = time.perf_counter() - start
    before = Before(tables=tables, parts=parts, order=pieces, seconds=seconds)
    return check(before, world.results)


def _pieces(name: str) -> list[Any]:
    """Return what a study comes in: parts by their index, claims by their names, or nothing."""
    if name == NUMBERS_OF_CLAIMS:
        return list(claim_numbers.CLAIMS)
    return list(range(PARTS)) if name in homes() and hasattr(study(name), "gather") else []


def _part(name: str, piece: Any, given: tuple[Any, Inputs]) -> Any:
    if name == NUMBERS_OF_CLAIMS:
        return claim_numbers.numbers_of(piece, *given).to_csv()
    return study(name).part(*given, piece, PARTS)


def _given(name: str, rests: Rests, world: World) -> tuple[Any, Inputs]:
    """Return what a study is run with."""
    return build(study(name).Params, rests.branch), Inputs(name, rests.rows, world.results)


def moved(name: str, rests: Rests, world: World) -> bool:
    """Tell whether a study or ledger gives other tables from what it rests on after a change.

    One part that moves is enough, and the next value is likely to move it, too.
    """
    before = world.before[name]
    if not before.parts:
        return _differ(made(name, rests, world.results), before.tables)
    given = _given(name, rests, world)
    now = dict(before.parts)
    for piece in dict.fromkeys((*before.last, *before.order)):
        now[piece] = _part(name, piece, given)
        differs = False
        if name == NUMBERS_OF_CLAIMS:
            differs = now[piece] != before.parts[piece]
        else:
            with suppress(Exception):  # parts before and after a change may not fit together
                differs = _differ(study(name).gather(*given, list(now.values())), before.tables)
        if differs:
            before.last[:] = [piece]
            return True
    if name == NUMBERS_OF_CLAIMS:  # or else a draw
        return _differ(made(name, rests, world.results), before.tables)
    return _differ(study(name).gather(*given, list(now.values())), before.tables)


def _differ(now: Tables, before: Tables) -> bool:
    return set(now) != set(before) or not all(table.equals(before[n]) for n, table in now.items())


def tried(each: Value, world: World) -> Found:
    """Change a value until an output moves."""
    refused: list[str] = []
    stopped: list[str] = []
    unmoved, most = 0, TRIED if each.place[0] != "claims" else sys.maxsize
    same = False  # nothing rests on a change: another place may have the same value
    bound = False  # but no other number may stand in place of a reference
    verdict, by = "", ""
    for above, other in changes(each, world, refused):
        places = [place[: len(place) - above] for place in each.places]
        document = functools.reduce(
            lambda d, place: changed(d, place, other), places, world.document
        )
        try:
            after = world.resolve(document, each.place[0], world.rests)
        except Exception as error:  # noqa: BLE001  whatever is raised refuses the value
            refused.append(f"{other!r}: {error}")
            bound = bound or (is_reference(other) and bool({"value", "values"} & {*other}))
            continue
        others = {name: after[name] for name in after if after[name] != world.rests[name]}
        same = same or not others
        for name in {*others} - {*world.before}:
            world.before[name] = unchanged(name, world)
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
    elif unmoved or (same and not stopped and not bound):
        verdict = "dead"
    elif stopped:
        verdict, by = "needed", stopped[0]
    else:
        verdict, by = "not tested", "; ".join(refused)[:200]
    return Found(key=each.key, value=each.value, verdict=verdict, by=by)


def check(before: Before, results: Path) -> Before:
    """Return what a study gives if the run has the same; otherwise raise `StaleRunError`."""
    if lines := [
        f"{path} is not of this state; make the run anew"
        for name, table in before.tables.items()
        for path in (results / f"{folder}/{name}.csv" for folder in ("tables", "data"))
        if path.exists()
        and path.read_text(encoding="utf-8") != table.to_csv(index=False, lineterminator="\n")
    ]:
        raise StaleRunError("\n".join(lines))
    return before


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
    return {pattern: reason for reason, patterns in load(path).items() for pattern in patterns}


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


def report(found: Sequence[Found], seconds: float) -> str:
    """Return the counts by branch or table, and all values that were not moved, in words."""
    groups = {one.key: re.split(r"[.:\[]", one.key)[0] for one in found}
    counts = Counter((group, one.verdict) for one in found for group in (groups[one.key], "all"))
    lines = [f"{'':24}{'values':>8}" + "".join(f"{verdict:>12}" for verdict in VERDICTS)]
    for group in (*sorted({*groups.values()}), "all"):
        own = [counts[group, verdict] for verdict in VERDICTS]
        lines.append(f"{group:24}{sum(own):>8}" + "".join(f"{n:>12}" for n in own))
    lines.append(f"{seconds:.0f} s")
    words = [
        one.key for one in found if one.by.startswith(FIGURES) and not one.key.startswith(FIGURES)
    ]
    lines += ["", f"Moved, but words of figures alone: {len(words)}", *words]
    for verdict in VERDICTS[1:]:
        unmoved = [one for one in found if one.verdict == verdict]
        lines += ["", f"{verdict.capitalize()}: {len(unmoved)}"]
        lines += map(line, unmoved)
    return "\n".join(lines) + "\n"


def line(one: Found) -> str:
    """Return what is told of one value."""
    return f"{one.key}: {one.value!r}{f'  ({one.by})' if one.by else ''}"


# Workers are forked with it.
_WORLD: list[World] = []


def _tried(each: Value) -> Found:
    return tried(each, _WORLD[0])


def _too_long(*_: object) -> None:
    raise TimeoutError(f"more than {SECONDS} s")


def _begin() -> None:
    warnings.simplefilter("ignore")
    signal.signal(signal.SIGALRM, _too_long)


def main(arguments: Sequence[str] | None = None) -> int:
    """Try all values and print the list."""
    parser = argparse.ArgumentParser(prog="python -m tests.dead_inputs", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("results", type=Path, nargs="?", default=ROOT / "build/ci")
    parser.add_argument("--processes", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--only", default="", help="values whose key holds this text")
    given = parser.parse_args(arguments)
    start = time.perf_counter()
    document = declared()
    rests = resolved(document)
    _WORLD[:] = [World(document=document, results=given.results, rests=rests)]
    wanted = [each for each in values(document) if given.only in each.key]
    found: list[Found] = []
    console = Console(stderr=True, soft_wrap=True, highlight=False, markup=False)
    bar: dict[str, Any] = {"total": len(wanted), "console": console}
    try:
        with multiprocessing.get_context("fork").Pool(given.processes, _begin) as pool:
            for one in track(pool.imap(_tried, wanted), "one change at a time", **bar):
                found.append(one)
                if one.verdict != "moved":  # told at once: a long search may be broken off
                    console.print(f"{one.verdict}: {line(one)}")
    except StaleRunError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    sys.stdout.write(report(found, time.perf_counter() - start))
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
