"""The configuration: files read, overlays merged, references resolved, all of it checked.

A top-level key is one of `General`, a section of `studies.laboratory`, or the branch of an
analysis: it bears the name of a module of `study.analyses` and is checked against that
module's ``Params``. All problems of a configuration are reported together, one line each;
those of the files that it names after them.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, make_dataclass, replace
from functools import cache
from pathlib import Path
from typing import Annotated, Any, get_args, get_type_hints

import numpy as np
from pydantic import AfterValidator, ValidationError

from microimpact.core.materials import Material, materials_from_rows
from microimpact.core.nearest import nearest
from microimpact.core.plausible import implausible
from microimpact.model.pairs import Pair, Pairs, pair_contact, pairs_from_rows
from microimpact.model.plausibility import doubt_of_input
from microimpact.statistics.distributions import SampleFile, TruncatedNormal
from study import analyses
from study.declared.documents import ConfigError, entries, load, located
from study.declared.parameters import (
    Known,
    Name,
    Positive,
    Seed,
    adapter,
    bare,
    build,
    explain,
)
from study.declared.parameters import (
    fields as types_of_fields,
)
from study.declared.provenance import Declared
from study.declared.references import Resolver
from study.declared.selection import TABLES, DeclaredTables, read_all
from study.figures.declaration import Figure, Format, all_figures
from study.laboratory import Laboratory
from study.run.digitised import files_of
from study.run.stamp import changes

# That one figure needs.
COLOURS = 7


@dataclass(frozen=True, slots=True, kw_only=True)
class Pathvars:
    """Where the results go."""

    results: Name = "results"


def _colours(palette: tuple[str, ...]) -> tuple[str, ...]:
    wrong = [colour for colour in palette if not re.fullmatch("#[0-9a-fA-F]{6}", colour)]
    if wrong or 0 < len(palette) < COLOURS:
        what = f"{wrong[0]!r}" if wrong else f"{len(palette)} of them"
        raise ValueError(f"{what}: must be {COLOURS} colours or more, as '#0072b2'")
    return palette


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawn:
    """Which figures are drawn, and how: always as SVG, too, which the report shows.

    Sizes are multiplied by the scale. A palette replaces the colours of series.
    """

    formats: tuple[Format, ...]
    leave_out: tuple[Name, ...] = ()
    scale: Positive = 1.0
    palette: Annotated[tuple[Name, ...], AfterValidator(_colours)] = ()


def _amount(text: float | str) -> float | str:
    number, _, unit = str(text).partition(" ")
    try:
        is_number = math.isfinite(float(number))
    except ValueError:
        is_number = False
    if not is_number or unit != unit.strip():
        raise ValueError(f"{text!r}: must be a number with its unit, as 2329 kg/m3")
    return text


def _pair(name: str) -> str:
    if len(name.split(" on ")) != len(TABLES["contacts"][1]):
        raise ValueError(f"{name!r}: must be particle and surface, as glass on silicon")
    return name


Amounts = Mapping[Name, Annotated[float | str, AfterValidator(_amount)]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Properties:
    """Properties that a run adds to the declared tables, or replaces there."""

    materials: Mapping[Name, Amounts] = field(default_factory=dict)
    contacts: Mapping[Annotated[Name, AfterValidator(_pair)], Amounts] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class General:
    """Top-level keys that belong to no single analysis."""

    seed: Seed
    materials: Name
    contacts: Name
    printed_values: Name
    external: Name
    digitised: Name
    figures: Drawn
    properties: Properties = field(default_factory=Properties)
    pathvars: Pathvars = field(default_factory=Pathvars)


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """A valid configuration."""

    general: General
    tables: DeclaredTables
    # By analysis: its parameters as plain values, with all that it names in place, and the rows of
    # the tables that it names, as CSV by table.
    branches: Mapping[str, Mapping[str, Any]]
    rows: Mapping[str, Mapping[str, str]]
    pairs: Mapping[str, tuple[str, str]]  # Materials of particle and surface of every case
    declared: tuple[Declared, ...]  # Every value as it is used

    def pairs_of(self, name: str) -> dict[str, tuple[str, str]]:
        """Return particle and surface of the cases that an analysis names."""
        text = json.dumps(self.branches[name], ensure_ascii=False)
        return {case: bodies for case, bodies in self.pairs.items() if case in text}


GENERAL = tuple(f.name for f in fields(General))
# What a cut must leave of a normal distribution; less is a slip.
SMALLEST_SHARE = 1e-4
_ENDS = np.array([0.0, 1.0])
SECTIONS = tuple(f.name for f in fields(Laboratory))
# General keys that name a file or a folder.
FILES = (*TABLES, "digitised")


def read_configuration(folder: Path | str) -> dict[str, Any]:
    """Read a folder of configuration: general keys, laboratory, analyses.

    Raises ConfigError, in one line, if a file is no proper YAML, or a key stands in two of them.
    """
    folder, configuration = Path(folder), dict[str, Any]()
    analyses = sorted((folder / "analyses").glob("*.yaml"))
    for path in (folder / "config.yaml", folder / "laboratory.yaml", *analyses):
        content = load(path)
        if twice := set(configuration) & set(content):
            raise ConfigError(f"{path}: {', '.join(sorted(twice))}: stands in another file, too")
        configuration |= content
    return configuration


def validate(
    config: Mapping[str, Any], base: Mapping[str, Any], only: Collection[str] = ()
) -> Settings:
    """Check a merged configuration.

    Parameters
    ----------
    base
        The configuration as shipped: what differs from it is the user's.
    only
        The analyses to look at; all, if none are given.

    Raises
    ------
    ConfigError
        Naming the dotted key of every problem, one line each.
    """
    _refuse(_no_mappings(config, SECTIONS))
    names = tuple(only or analyses.homes())
    reader = _Reader(config, base)
    reader.problems += [*_unknown_keys(config), *_no_mappings(config, names)]
    general = reader.part(General)
    rows = list(reader.resolver.rows)
    tables = reader.tables(names, general.properties if general else Properties())
    laboratory = reader.part(Laboratory)
    reader.resolver.rows = rows  # those of the laboratory count where they are used
    branches = _branches(names)
    params, named = dict[str, Any](), dict[str, list[tuple[str, str]]]()
    for name in names:
        params[name], named[name] = reader.branch(branches, name)
        lacking = {*analyses.printed(name)} - tables.printed_values.names
        path = tables.printed_values.path
        reader.problems += [f"{path}: {key}: missing; {name} reads it" for key in sorted(lacking)]
    cases = {entry for each in named.values() for sort, entry in each if sort == "cases"}
    reader.problems += _lacking(laboratory, params, cases)
    _refuse(reader.lines())
    _refuse(
        f"figures.leave_out: {name!r} is no figure{nearest(name, all_figures())}"
        for name in general.figures.leave_out
        if name not in all_figures()
    )
    _refuse(_out_of_unit(rows))
    _refuse(_contradictions(laboratory, params, rows))
    if not only:
        _refuse(_idle(reader.resolver, laboratory, cases, {c.key for c in changes(config, base)}))
    bodies = {name: (case.particle, case.surface) for name, case in laboratory.cases.items()}
    # Where the results go, and what is drawn of them, is no input; properties are in their tables.
    apart = "pathvars.", "figures.", "properties."
    declared = tuple(row for row in rows if not row.key.startswith(apart))
    return Settings(
        general=general,
        tables=tables,
        branches=adapter(branches).dump_python(  # type: ignore[arg-type]
            branches(**params), mode="json"
        ),
        rows={
            name: tables.named(each, bodies) | tables.whole(analyses.whole(name), declared)
            for name, each in named.items()
        },
        pairs={
            tables.contacts.name(row): (row["particle"], row["surface"])
            for row in tables.contacts.rows
        }
        | bodies,
        declared=declared,
    )


class _Reader:
    """The parts of a configuration, built one after another; their problems are kept."""

    def __init__(self, config: Mapping[str, Any], base: Mapping[str, Any]) -> None:
        self.config = config
        self.resolver = Resolver(config, base, SECTIONS)
        self.problems: list[str] = []
        self.known = Known({})

    def part(self, kind: type[Any], *only: str) -> Any:
        """Return an instance of a dataclass whose fields are top-level keys, or None."""
        hints = get_type_hints(kind, include_extras=True)
        keys = [key for key in only or hints if key in self.config]
        try:
            values = {key: self.resolver.resolved(hints[key], key) for key in keys}
            return build(kind, values, self.known)
        except ValidationError as error:
            self.problems += explain(error, kind, "", self.resolver.aliases)
            return None

    def tables(self, names: Iterable[str], properties: Properties) -> DeclaredTables:
        """Read the declared tables, whatever is wrong elsewhere, and declare all names."""
        paths = {name: self.resolver.resolved(str, name) for name in TABLES}
        texts = {name: path for name, path in paths.items() if isinstance(path, str)}
        missing = [name for name, path in texts.items() if not Path(path).is_file()]
        self.problems += [f"{n}: {texts[n]!r} must be a file; there is none" for n in missing]
        try:
            tables = read_all(texts) if texts == paths and not missing else None
        except (ValueError, OSError) as error:
            self.problems.append(str(error))
            tables = None
        if tables is None:  # nothing can be named
            raise _error(self.lines())
        tables = replace(
            tables,
            materials=tables.materials.with_properties(properties.materials),
            contacts=tables.contacts.with_properties(properties.contacts),
        )
        self.resolver.declare("printed", tables.printed())
        self.resolver.declare("contacts", tables.pairs())
        self.known = Known(tables.names())
        self.known.names["cases"] = "cases", {*self.config["cases"], *tables.contacts.names}
        makers = {maker for name in names for maker in analyses.needs(name).values()}
        for name, declared_names in _hooks({*names, *makers}, "declared_names"):
            self.known.names |= declared_names(entries(self.config.get(name)))
        return tables

    def branch(self, branches: type[Any], name: str) -> tuple[Any, list[tuple[str, str]]]:
        """Return the parameters of an analysis, or None, and sort and name of all that it names."""
        self.known.named.clear()
        is_there = isinstance(self.config.get(name), Mapping)
        params = getattr(self.part(branches, name), name, None) if is_there else None
        return params, self.known.named + [("printed_values", k) for k in analyses.printed(name)]

    def lines(self) -> list[str]:
        """Return the problems, but for those that follow from a malformed declaration."""
        malformed = self.resolver.problems

        def follows(line: str) -> bool:
            key = line.partition(": ")[0]
            return any(fault.startswith((f"{key}.", f"{key}:")) for fault in malformed)

        return [*malformed, *(line for line in self.problems if not follows(line))]


def _no_mappings(config: Mapping[str, Any], keys: Iterable[str]) -> Iterator[str]:
    for key in keys:
        if not isinstance(config.get(key), Mapping):
            is_there = key in config
            yield f"{key}: {config[key]!r} must be a mapping" if is_there else f"{key}: missing"


def _hooks(names: Iterable[str], hook: str) -> Iterator[tuple[str, Any]]:
    """Yield the function of a name of each analysis that has one."""
    for name in names:
        if function := getattr(analyses.analysis(name), hook, None):
            yield name, function


def _unknown_keys(config: Mapping[str, Any]) -> Iterator[str]:
    known = [*GENERAL, *SECTIONS, *analyses.homes()]
    return (f"{k}: unknown key{nearest(str(k), known)}" for k in config if k not in known)


def _lacking(
    laboratory: Laboratory | None, params: Mapping[str, Any], cases: Collection[str]
) -> Iterator[str]:
    """Yield a line for each declared case that is named, and not made by the analysis of cases."""
    for name, lacking in _hooks(params, "lacking"):
        if laboratory and params[name]:
            yield from lacking(params[name], sorted({*cases} & {*laboratory.cases}))


def _idle(
    resolver: Resolver, laboratory: Laboratory, cases: Collection[str], changed: Collection[str]
) -> Iterator[str]:
    """Yield a line for each changed key that no analysis names.

    A new entry that one does name may say more of itself than is asked for.
    """
    places = ["impact", *(f"drops.{name}" for name in laboratory.drops)]
    places += [f"cases.{case}" for case in {*cases} & {*laboratory.cases}]
    bodies = (f"{place}.{body}" for place in places for body in ("particle", "surface"))
    used = {resolver.aliases.get(key, key) for key in bodies}
    used |= {row.origin for row in resolver.rows}
    named = {
        entry
        for entry in map(_entry, used)
        if entry[-1] not in entries(resolver.base.get(entry[0]))
    }
    for key in resolver.unused():
        if key in changed and key not in used and _entry(key) not in named:
            yield f"{key}: changes nothing: no analysis names it"


def _entry(key: str) -> tuple[str, ...]:
    """Return section and name of the entry of the laboratory that a key is of."""
    return tuple(key.split(".")[:2])


def _contradictions(
    laboratory: Laboratory, params: Mapping[str, Any], rows: Iterable[Declared]
) -> Iterator[str]:
    """Yield a line for each input, allowed by itself, that contradicts another."""
    yield from laboratory.disagreements()
    origins = {row.key: row.origin or row.key for row in rows}
    for name, settings in params.items():
        yield from _slips(settings, name, origins)
    for name, disagreements in _hooks(params, "disagreements"):
        if params[name]:
            others = {maker: params.get(maker) for maker in analyses.needs(name).values()}
            lines = disagreements(params[name], others, laboratory)
            yield from (f"{name}.{line}" for line in lines)


def _slips(node: Any, key: str, origins: Mapping[str, str]) -> Iterator[str]:
    """Yield a line for each item that a list repeats, and each cut that leaves nothing."""
    if isinstance(node, Mapping):
        for name, child in node.items():
            yield from _slips(child, f"{key}.{name}", origins)
    if isinstance(node, TruncatedNormal) and node.share < SMALLEST_SHARE:
        normal, cut = f"mean {node.mean:g}, sd {node.sd:g}", f"{node.low:g} to {node.high:g}"
        yield f"{key}: from {cut}, only {node.share:.1g} of {normal} is left"
    if not is_dataclass(node) or type(node).__module__ == TruncatedNormal.__module__:
        return  # measured values may be equal
    for name, hint in types_of_fields(type(node)).items():  # type: ignore[arg-type]
        child, items = getattr(node, name), f"{key}.{name}"
        if get_args(bare(hint))[1:] == (Ellipsis,) and isinstance(child, tuple):
            # Facts that a list names may well be equal: it repeats what stands in one list only.
            keys = [f"{items}[{i}]" for i in range(len(child))]
            lists = [origins.get(each, each).rpartition("[")[0] for each in keys]
            named = list(zip(lists, child, strict=True))
            yield from (
                f"{where}: {item!r} is repeated"
                for i, (where, item) in enumerate(named)
                if where and (where, item) in named[:i]
            )
        yield from _slips(child, items, origins)


def _error(lines: Iterable[str]) -> ConfigError:
    """Return the error of some lines.

    What several analyses name is refused by each of them; the first line on a key is enough.
    """
    first = dict[str, str]()
    for line in lines:
        first.setdefault(line.partition(": ")[0], line)
    return ConfigError("\n".join(first.values()))


def _refuse(lines: Iterable[str]) -> None:
    if problems := list(lines):
        raise _error(problems)


def _out_of_unit(rows: Iterable[Declared]) -> Iterator[str]:
    """Yield a line for each value doubtful in its unit, or named for another unit."""
    for row in rows:
        is_shared = row.origin.partition(".")[0] in SECTIONS
        key, values = row.origin if is_shared else row.key, [row.value]
        if key.endswith(".path"):  # of a file of values
            key, values = key[:-5], SampleFile(path=row.value).quantile(_ENDS).tolist()
        yield from filter(None, (doubt_of_input(key, value) for value in values))
        if row.given_unit and row.unit not in {"", "-", row.given_unit}:
            allowed = f"{row.unit}, as that of {row.key}"
            yield f"{row.origin}: the unit {row.given_unit} must be {allowed}"


@cache
def _branches(names: tuple[str, ...]) -> type[Any]:
    """Return a dataclass of branches: a single validator of shared types takes half the time."""
    parts = [(name, analyses.analysis(name).Params, field(default=None)) for name in names]
    return make_dataclass("Branches", parts, frozen=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class Inputs:
    """Inputs of a run besides its configuration."""

    figures: Mapping[str, Figure]  # Words filled in
    digitised: Mapping[str, str]  # Files of the user's own points by figure


def read_inputs(settings: Settings, changed: Collection[str] = ()) -> Inputs:
    """Read and check every file that a checked configuration names.

    Parameters
    ----------
    changed
        Analyses of other impacts than the shipped ones.

    Raises
    ------
    ValueError
        With one line per problem that names the key, or the file and its line or column.
    OSError
        If a file cannot be read.
    """
    general, tables = settings.general, settings.tables
    rows = tables.materials.rows
    with located(tables.materials.path):
        for end in ("low", "high"):  # both ends of every uncertain property must be possible, too
            materials_from_rows({**row, "value": row[end] or row["value"]} for row in rows)
        materials = materials_from_rows(rows)
    with located(tables.contacts.path):
        contacts = pairs_from_rows(tables.contacts.rows)
    wrong = [
        f"{tables.materials.path}: {name}: {line}"
        for name, material in materials.items()
        for line in implausible(material)
    ]
    wrong += [
        f"{tables.contacts.path}: {line}"
        for pair in contacts
        for line in _out_of_range(pair, materials, contacts)
    ]
    if wrong:
        raise ValueError("\n".join(wrong))
    branches, pairs = settings.branches, settings.pairs
    figures = {
        name: each.filled(branches[each.analysis], pairs, changed=each.analysis in changed)
        for name, each in all_figures().items()
        if name not in general.figures.leave_out
    }
    return Inputs(figures=figures, digitised=files_of(general.digitised, figures))


def _out_of_range(pair: Pair, materials: Mapping[str, Material], pairs: Pairs) -> Iterator[str]:
    try:
        yield from implausible(pair_contact(*pair, materials, pairs), f"{pair[0]} on {pair[1]}: ")
    except ValueError as error:
        yield f"{pair[0]} on {pair[1]}: {error}"
