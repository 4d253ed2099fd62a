"""The one validator of ``config/config.yaml`` and of every overlay merged into it.

A top-level branch bears the name of the module of `microimpact.studies` it belongs to and
is checked against that module's ``Params``; the other top-level keys are those of `General`.
All problems of a configuration are reported together, one line each.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Annotated, Any

from pydantic import Field, ValidationError

from microimpact import studies
from microimpact.core.nearest import nearest
from microimpact.declared.documents import ConfigError, load
from microimpact.declared.parameters import (
    AngleDegrees,
    Count,
    Finite,
    Fraction,
    Name,
    NonNegative,
    Positive,
    build,
    explain,
)
from microimpact.declared.provenance import Declared, declared, plain, problems

__all__ = [
    "AngleDegrees",
    "ConfigError",
    "Count",
    "Finite",
    "Fraction",
    "General",
    "Name",
    "NonNegative",
    "Pathvars",
    "Positive",
    "Settings",
    "load",
    "validate",
]


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
    figures: Name
    claims: Name
    digitized: Name
    pathvars: Pathvars = field(default_factory=Pathvars)

    @property
    def tables(self) -> tuple[str, str, str]:
        """Paths of the declared tables: materials, contacts and printed values."""
        return self.materials, self.contacts, self.printed_values


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """A valid configuration: general keys, plain values per branch, declared values."""

    general: General
    branches: Mapping[str, Mapping[str, Any]]
    declared: tuple[Declared, ...]


def validate(config: Mapping[str, Any], base: Mapping[str, Any]) -> Settings:
    """Check a merged configuration.

    Parameters
    ----------
    config
        The merged configuration, with the provenance of its values.
    base
        The configuration as shipped: what differs from it is the user's.

    Returns
    -------
    Settings
        Plain values, with defaults filled in and numbers in their proper type.

    Raises
    ------
    ConfigError
        Naming the dotted key of every problem, one line each.
    """
    names, general_keys = list(studies.homes()), [f.name for f in fields(General)]
    malformed = [line for key, node in config.items() for line in problems(node, key)]
    found = [
        f"{key}: unknown key{nearest(str(key), [*names, *general_keys])}"
        for key in config
        if key not in names and key not in general_keys
    ]
    values = {key: plain(node) for key, node in config.items()}
    given = {key: values[key] for key in general_keys if key in values}
    general = _checked(General, given, "", found)
    branches = {name: _branch(name, values.get(name), found) for name in names}
    found = malformed + [line for line in found if not _follows(line, malformed)]
    if found or general is None:
        raise ConfigError("\n".join(found))
    return Settings(
        general=general,
        branches={name: branch for name, branch in branches.items() if branch is not None},
        declared=tuple(declared(config, base)),
    )


def checked_branch(name: str, values: object) -> dict[str, Any]:
    """Return the plain values of a study's branch as JSON would hold them, checked.

    Raises
    ------
    ConfigError
        Naming the dotted key of every problem, one line each.
    """
    found: list[str] = []
    branch = _branch(name, values, found)
    if branch is None:
        raise ConfigError("\n".join(found))
    return branch


def _branch(name: str, values: object, found: list[str]) -> dict[str, Any] | None:
    """Return the checked values of a branch as JSON would hold them: lists, not tuples."""
    params = _checked(studies.study(name).Params, values, name, found)
    if params is None:
        return None
    branch: dict[str, Any] = json.loads(json.dumps(asdict(params)))
    return branch


def _follows(line: str, malformed: list[str]) -> bool:
    """Tell whether a value is refused only because its declaration is malformed."""
    key = line.partition(": ")[0]
    return any(other.startswith((f"{key}.", f"{key}:")) for other in malformed)


def _checked(kind: type[Any], values: object, key: str, found: list[str]) -> Any:
    """Return an instance of a dataclass, or None, with what is wrong added to the lines."""
    if not isinstance(values, Mapping):
        found.append(f"{key}: {'missing' if values is None else f'{values!r} must be a mapping'}")
        return None
    try:
        return build(kind, values)
    except ValidationError as error:
        found += explain(error, kind, key)
        return None
