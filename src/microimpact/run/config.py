"""The configuration: its files read, overlays merged, references resolved, all of it checked.

A top-level key is one of `General`, a section of `lab.laboratory.Laboratory`, or the branch of an
analysis: it bears the name of a module of `microimpact.studies` and is checked against that
module's ``Params``. All problems of a configuration are reported together, one line each.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, make_dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any, get_type_hints

from pydantic import Field, ValidationError

from microimpact import studies
from microimpact.core.nearest import nearest
from microimpact.declared.documents import ConfigError, load
from microimpact.declared.parameters import Count, Known, Name, build, explain
from microimpact.declared.provenance import Declared
from microimpact.declared.references import Resolver
from microimpact.declared.selection import TABLES, DeclaredTables, read_all
from microimpact.lab.laboratory import Laboratory


@dataclass(frozen=True, slots=True, kw_only=True)
class Pathvars:
    """Where the results go."""

    results: Name = "results"


@dataclass(frozen=True, slots=True, kw_only=True)
class General:
    """Top-level keys that belong to no single analysis."""

    seed: Annotated[int, Field(ge=0)]
    chunks: Count
    materials: Name
    contacts: Name
    printed_values: Name
    external: Name
    figures: Name
    claims: Name
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
    declared: tuple[Declared, ...]  # Every value as it is used
    unused: tuple[str, ...]  # Places of the laboratory on which no analysis rests


CALIBRATION = "calibration"
GENERAL = tuple(f.name for f in fields(General))
_BODIES = ("particle", "surface")
SECTIONS = tuple(f.name for f in fields(Laboratory))


def read_configuration(folder: Path | str) -> dict[str, Any]:
    """Read a folder of configuration: general keys, the laboratory, and the analyses by section.

    Raises ConfigError, in one line, if a file is no proper YAML, or a key stands in two of them.
    """
    folder, found = Path(folder), dict[str, Any]()
    analyses = sorted((folder / "analyses").glob("*.yaml"))
    for path in (folder / "config.yaml", folder / "laboratory.yaml", *analyses):
        content = load(path)
        if twice := set(found) & set(content):
            raise ConfigError(f"{path}: {', '.join(sorted(twice))}: stands in another file, too")
        found |= content
    return found


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
    resolver = Resolver(config, base, SECTIONS)
    known_keys = [*GENERAL, *SECTIONS, *studies.homes()]
    unknown = [key for key in config if key not in known_keys]
    found = [f"{key}: unknown key{nearest(str(key), known_keys)}" for key in unknown]
    check = _Check(config, resolver, found)
    general = check.sections(General, GENERAL)
    shown = list(resolver.rows)
    tables = _tables(resolver, found)
    if tables is None:  # nothing can be named
        raise ConfigError("\n".join([*resolver.problems, *_others(found, resolver.problems)]))
    resolver.declare("printed", tables.printed())
    tables = tables.resolved(resolver.at)
    cases = [*(config.get("cases") or ()), *tables.contacts.known("particle", "surface")]
    check.known = Known({**tables.names(), "cases": ("cases", cases)})
    laboratory = check.sections(Laboratory, SECTIONS)
    stands = {row.key: row.place or row.key for row in resolver.rows}
    resolver.rows = shown
    params, named = {}, {}
    branches = _branches(tuple(only or studies.homes()))
    for name in only or studies.homes():
        check.known.named.clear()
        params[name] = check.branch(branches, name)
        named[name] = list(check.known.named)
    wanted = {name for each in named.values() for sort, name in each if sort == "cases"}
    if laboratory and params.get(CALIBRATION):
        calibrated = params[CALIBRATION].calibrated
        found += [
            f"cases.{case}: is named, but {CALIBRATION} does not calibrate it"
            for case in sorted(wanted & set(laboratory.cases) - calibrated)
        ]
    for name, own in params.items():
        disagreements = getattr(studies.study(name), "disagreements", None)
        if own and disagreements:
            found += [f"{name}.{line}" for line in disagreements(own, params)]
    found = [*resolver.problems, *_others(found, resolver.problems)]
    if found:
        raise ConfigError("\n".join(dict.fromkeys(found)))
    bodies = {name: (case.particle, case.surface) for name, case in laboratory.cases.items()}
    used = {stands[f"cases.{case}.{body}"] for case in wanted & set(bodies) for body in _BODIES}
    return Settings(
        general=general,
        tables=tables,
        branches={name: json.loads(json.dumps(asdict(each))) for name, each in params.items()},
        rows={name: tables.named(each, bodies) for name, each in named.items()},
        # Where the results go is no input: the same study has the same table anywhere.
        declared=tuple(row for row in resolver.rows if not row.key.startswith("pathvars.")),
        unused=tuple(place for place in resolver.unused() if place not in used),
    )


@dataclass(slots=True)
class _Check:
    """Builds what a configuration declares, and gathers what is wrong with it."""

    config: Mapping[str, Any]
    resolver: Resolver
    found: list[str]
    known: Known = field(default_factory=lambda: Known({}))

    def branch(self, kind: type[Any], key: str) -> Any:
        """Return one branch of `_branches`, or None, with what is wrong added to the lines."""
        values = self.resolver.resolved(get_type_hints(kind)[key], key)
        if isinstance(values, Mapping):
            return getattr(self._built(kind, {key: values}), key, None)
        given = f"{self.config[key]!r} must be a mapping" if key in self.config else "missing"
        self.found.append(f"{key}: {given}")
        return None

    def sections(self, kind: type[Any], keys: Sequence[str]) -> Any:
        """Return an instance of a dataclass whose fields are top-level keys, or None."""
        hints = get_type_hints(kind, include_extras=True)
        given = [key for key in keys if key in self.config]
        return self._built(kind, {k: self.resolver.resolved(hints[k], k) for k in given})

    def _built(self, kind: type[Any], values: Mapping[str, Any]) -> Any:
        try:
            return build(kind, values, self.known if self.known.names else None)
        except ValidationError as error:
            self.found += explain(error, kind, "", self.resolver.aliases)
            return None


@cache
def _branches(names: tuple[str, ...]) -> type[Any]:
    """Return a dataclass of branches: one validator for what they share takes half the time."""
    own = [(name, studies.study(name).Params, field(default=None)) for name in names]
    return make_dataclass("Branches", own, frozen=True)


def _tables(resolver: Resolver, found: list[str]) -> DeclaredTables | None:
    """Read the declared tables, whatever is wrong with other general keys."""
    paths = {name: resolver.resolved(str, name) for name in TABLES}
    missing = [
        f"{name}: {path!r} must be a file; there is none"
        for name, path in paths.items()
        if isinstance(path, str) and not Path(path).is_file()
    ]
    found += missing
    try:
        usable = not missing and all(isinstance(path, str) for path in paths.values())
        return read_all(*paths.values()) if usable else None
    except (ValueError, OSError) as error:
        found.append(str(error))
        return None


def _others(lines: Iterable[str], malformed: Sequence[str]) -> list[str]:
    """Leave out what is refused only because its declaration is malformed."""

    def follows(line: str) -> bool:
        key = line.partition(": ")[0]
        return any(other.startswith((f"{key}.", f"{key}:")) for other in malformed)

    return [line for line in lines if not follows(line)]
