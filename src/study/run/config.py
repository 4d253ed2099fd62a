"""The configuration: files read, overlays merged, references resolved, all of it checked.

A top-level key is one of `General`, a section of `studies.laboratory`, or the branch of an
analysis: it bears the name of a module of `study.analyses` and is checked against that
module's ``Params``. All problems of a configuration are reported together, one line each;
those of the files that it names after them.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, make_dataclass
from functools import cache
from pathlib import Path
from typing import Any, get_args, get_type_hints

import numpy as np
from pydantic import ValidationError

from microimpact.core.materials import Material, materials_from_rows
from microimpact.core.nearest import nearest
from microimpact.core.plausible import implausible
from microimpact.model.pairs import Pair, Pairs, pair_contact, pairs_from_rows
from microimpact.model.plausibility import doubt_of_input
from microimpact.statistics.distributions import SampleFile, TruncatedNormal
from study import analyses
from study.contacts import ALL_LAWS
from study.declared.documents import ConfigError, load, located
from study.declared.parameters import Known, Name, Seed, adapter, build, explain
from study.declared.provenance import Declared, unit_of
from study.declared.references import Resolver
from study.declared.selection import TABLES, DeclaredTable, DeclaredTables, read_all
from study.figures.declaration import Figure
from study.laboratory import Laboratory
from study.run.digitised import files_of
from study.run.stamp import changes


@dataclass(frozen=True, slots=True, kw_only=True)
class Pathvars:
    """Where the results go."""

    results: Name = "results"


@dataclass(frozen=True, slots=True, kw_only=True)
class General:
    """Top-level keys that belong to no single analysis."""

    seed: Seed
    materials: Name
    contacts: Name
    printed_values: Name
    external: Name
    digitised: Name
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


CALIBRATION = "calibration"
GENERAL = tuple(f.name for f in fields(General))
# What a cut must leave of a normal distribution; less is a slip.
SMALLEST_SHARE = 1e-4
_ENDS = np.array([0.0, 1.0])
_BODIES = ("particle", "surface")
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
    resolver = Resolver(config, base, SECTIONS)
    known_keys = [*GENERAL, *SECTIONS, *analyses.homes()]
    problems = [
        *(f"{k}: unknown key{nearest(str(k), known_keys)}" for k in config if k not in known_keys),
        *_no_mappings(config, names),
    ]
    general = _sections(General, config, resolver, problems)
    shown = list(resolver.rows)
    tables = _tables(resolver, problems)
    if tables is None:  # nothing can be named
        raise ConfigError("\n".join([*resolver.problems, *_others(problems, resolver.problems)]))
    resolver.declare("printed", tables.printed())
    resolver.declare("contacts", tables.pairs())
    known = Known(tables.names() | _inferred(config))
    known.names["cases"] = "cases", {*config["cases"], *tables.contacts.names}
    laboratory = _sections(Laboratory, config, resolver, problems, known)
    stands = {row.key: row.origin or row.key for row in resolver.rows}
    resolver.rows = shown
    branches = _branches(names)
    params, named = dict[str, Any](), dict[str, list[tuple[str, str]]]()
    for name in names:
        known.named.clear()
        branch = {name: config[name]} if isinstance(config.get(name), Mapping) else {}
        params[name] = getattr(_sections(branches, branch, resolver, problems, known), name, None)
        problems += _unprinted(name, tables.printed_values)
        named[name] = known.named + [("printed_values", key) for key in analyses.printed(name)]
    wanted = {name for each in named.values() for sort, name in each if sort == "cases"}
    if laboratory and params.get(CALIBRATION):
        problems += [
            f"cases.{case}: is named, but {CALIBRATION} does not calibrate it"
            for case in sorted(wanted & set(laboratory.cases) - params[CALIBRATION].calibrated)
        ]
    _refuse([*resolver.problems, *_others(problems, resolver.problems)])
    _refuse(_out_of_unit(resolver.rows, tables.units()))
    _refuse(_contradictions(laboratory, params, resolver.rows))
    bodies = {name: (case.particle, case.surface) for name, case in laboratory.cases.items()}
    used = {stands[f"cases.{case}.{body}"] for case in wanted & set(bodies) for body in _BODIES}
    drops = ["impact", *(f"drops.{name}" for name in laboratory.drops)]
    used |= {stands[f"{drop}.{body}"] for drop in drops for body in _BODIES}
    if not only:
        unused = [key for key in resolver.unused() if key not in used]
        used |= {row.origin for row in resolver.rows}
        _refuse(_idle(unused, used, base, {change.key for change in changes(config, base)}))
    return Settings(
        general=general,
        tables=tables,
        branches=adapter(branches).dump_python(  # type: ignore[arg-type]
            branches(**params), mode="json"
        ),
        rows={name: tables.named(each, bodies) for name, each in named.items()},
        pairs={tables.contacts.name(row): _bodies(row) for row in tables.contacts.rows} | bodies,
        # Where the results go is no input: the same study has the same table anywhere.
        declared=tuple(row for row in resolver.rows if not row.key.startswith("pathvars.")),
    )


def _bodies(row: Mapping[str, str]) -> tuple[str, str]:
    return row["particle"], row["surface"]


def _sections(
    kind: type[Any],
    config: Mapping[str, Any],
    resolver: Resolver,
    problems: list[str],
    known: Known | None = None,
) -> Any:
    """Return an instance of a dataclass whose fields are top-level keys, or None."""
    hints = get_type_hints(kind, include_extras=True)
    values = {key: resolver.resolved(hints[key], key) for key in hints if key in config}
    try:
        return build(kind, values, known)
    except ValidationError as error:
        problems += explain(error, kind, "", resolver.aliases)
        return None


def _no_mappings(config: Mapping[str, Any], keys: Iterable[str]) -> Iterator[str]:
    for key in keys:
        if not isinstance(config.get(key), Mapping):
            is_there = key in config
            yield f"{key}: {config[key]!r} must be a mapping" if is_there else f"{key}: missing"


def _inferred(config: Mapping[str, Any]) -> dict[str, tuple[str, set[str]]]:
    """Return the names of pairs, scenarios and laws of the inference, where they are declared."""
    pairs = _entries(_entries(config.get("inference")).get("pairs"))
    names = {
        sort: (
            f"inference.pairs.{sort}",
            {n for each in pairs.values() for n in _entries(each).get(sort) or ()} | beyond,
        )
        for sort, beyond in (("scenarios", set[str]()), ("laws", {ALL_LAWS}))
    }
    return names | {"inference.pairs": ("inference.pairs", set(pairs))}


def _idle(
    unused: Iterable[str], used: Iterable[str], base: Mapping[str, Any], changed: Collection[str]
) -> Iterator[str]:
    """Yield a line for each changed key that no analysis names.

    A new entry that one does name may say more of itself than is asked for.
    """
    named = {entry for entry in map(_entry, used) if entry[-1] not in _entries(base.get(entry[0]))}
    for key in unused:
        if key in changed and _entry(key) not in named:
            yield f"{key}: changes nothing: no analysis names it"


def _entry(key: str) -> tuple[str, ...]:
    """Return section and name of the entry of the laboratory that a key is of."""
    return tuple(key.split(".")[:2])


def _entries(node: object) -> Mapping[str, Any]:
    return node if isinstance(node, Mapping) else {}


def _contradictions(
    laboratory: Laboratory, params: Mapping[str, Any], rows: Iterable[Declared]
) -> Iterator[str]:
    """Yield a line for each input, allowed by itself, that contradicts another."""
    yield from laboratory.disagreements()
    origins = {row.key: row.origin or row.key for row in rows}
    for name, settings in params.items():
        yield from _slips(settings, name, origins)
        disagreements = getattr(analyses.analysis(name), "disagreements", None)
        if settings and disagreements:
            others = {maker: params.get(maker) for maker in analyses.needs(name).values()}
            yield from (f"{name}.{line}" for line in disagreements(settings, others, laboratory))


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
    for name, hint in get_type_hints(type(node)).items():
        child, items = getattr(node, name), f"{key}.{name}"
        if get_args(hint)[1:] == (Ellipsis,) and isinstance(child, tuple):
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


def _unprinted(name: str, table: DeclaredTable) -> Iterator[str]:
    """Yield a line for each printed value that a study reads and the table lacks."""
    for key in analyses.printed(name):
        if key not in table.names:
            yield f"{table.path}: {key}: missing; {name} reads it"


def _refuse(lines: Iterable[str]) -> None:
    """Raise ConfigError if there are lines.

    What several analyses name is refused by each of them; the first line on a key is enough.
    """
    first = dict[str, str]()
    for line in lines:
        first.setdefault(line.partition(": ")[0], line)
    if first:
        raise ConfigError("\n".join(first.values()))


def _out_of_unit(rows: Iterable[Declared], units: Mapping[str, str]) -> Iterator[str]:
    """Yield a line for each value doubtful in its unit, or named for another unit."""
    for row in rows:
        is_shared = row.origin.partition(".")[0] in SECTIONS
        key, values = row.origin if is_shared else row.key, [row.value]
        if key.endswith(".path"):  # of a file of values
            key, values = key[:-5], SampleFile(path=row.value).quantile(_ENDS).tolist()
        yield from filter(None, (doubt_of_input(key, value) for value in values))
        # A number of a distribution has the unit of the distribution's key.
        wanted = {row.unit, unit_of(row.key.rpartition(".")[0])} - {"-"}
        unit = units.get(row.origin.partition("[")[0])
        if unit and wanted and unit not in wanted:
            allowed = " or ".join(sorted(wanted))
            yield f"{row.origin}: the unit {unit} must be {allowed}, as that of {row.key}"


@cache
def _branches(names: tuple[str, ...]) -> type[Any]:
    """Return a dataclass of branches: a single validator of shared types takes half the time."""
    parts = [(name, analyses.analysis(name).Params, field(default=None)) for name in names]
    return make_dataclass("Branches", parts, frozen=True)


def _tables(resolver: Resolver, problems: list[str]) -> DeclaredTables | None:
    """Read the declared tables, whatever is wrong with other general keys."""
    paths = {name: resolver.resolved(str, name) for name in TABLES}
    missing = [
        f"{name}: {path!r} must be a file; there is none"
        for name, path in paths.items()
        if isinstance(path, str) and not Path(path).is_file()
    ]
    problems += missing
    try:
        usable = not missing and all(isinstance(path, str) for path in paths.values())
        return read_all(paths) if usable else None
    except (ValueError, OSError) as error:
        problems.append(str(error))
        return None


def _others(lines: Iterable[str], malformed: Sequence[str]) -> list[str]:
    """Drop the problems that follow from a malformed declaration of the same key."""

    def follows(line: str) -> bool:
        key = line.partition(": ")[0]
        return any(fault.startswith((f"{key}.", f"{key}:")) for fault in malformed)

    return [line for line in lines if not follows(line)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Inputs:
    """Inputs of a run besides its configuration."""

    # Rows of the declared tables that each study is given, as CSV by table.
    rows: Mapping[str, Mapping[str, str]]
    figures: Mapping[str, Figure]  # Words filled in
    digitised: Mapping[str, str]  # Files of the user's own points by figure


def read_inputs(settings: Settings, changed: Collection[str] = ()) -> Inputs:
    """Read and check every file that a checked configuration names.

    Parameters
    ----------
    changed
        Analyses that rest on inputs which are not as shipped.

    Raises
    ------
    ValueError
        With one line per problem that names the key, or the file and its line or column.
    OSError
        If a file cannot be read.
    """
    general = settings.general
    tables = settings.tables
    materials = _materials(tables.materials)
    with located(general.contacts):
        contacts = pairs_from_rows(tables.contacts.rows)
    wrong = [
        f"{general.materials}: {name}: {line}"
        for name, material in materials.items()
        for line in implausible(material)
    ]
    wrong += [
        f"{general.contacts}: {line}"
        for pair in contacts
        for line in _out_of_range(pair, materials, contacts)
    ]
    if wrong:
        raise ValueError("\n".join(wrong))
    branches, pairs = settings.branches, settings.pairs
    figures = {
        name: each.filled(branches[each.analysis], pairs, changed=each.analysis in changed)
        for name, each in analyses.figures().items()
    }
    return Inputs(
        rows={name: study_rows(name, settings) for name in settings.branches},
        figures=figures,
        digitised=files_of(general.digitised, figures),
    )


def _materials(table: DeclaredTable) -> dict[str, Material]:
    """Return the materials; both ends of every uncertain property must be possible, too."""
    try:
        for end in ("low", "high"):
            materials_from_rows({**row, "value": row[end] or row["value"]} for row in table.rows)
        return materials_from_rows(table.rows)
    except ValueError as error:
        raise ValueError(f"{table.path}: {error}") from None


def study_rows(name: str, settings: Settings) -> Mapping[str, str]:
    """Return the declared rows that a study is given, as CSV by table.

    Rows named by its branch; for `contact_properties` all contacts, for `declared_inputs` all.
    """
    if name == "declared_inputs":
        return settings.tables.everything(settings.declared)
    if name == "contact_properties":
        return settings.tables.contact_rows()
    return settings.rows[name]


def _out_of_range(pair: Pair, materials: Mapping[str, Material], pairs: Pairs) -> Iterator[str]:
    try:
        yield from implausible(pair_contact(*pair, materials, pairs), f"{pair[0]} on {pair[1]}: ")
    except ValueError as error:
        yield f"{pair[0]} on {pair[1]}: {error}"
