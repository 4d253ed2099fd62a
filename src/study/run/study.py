"""One study run from Python, with the declared inputs or some of one's own."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from microimpact.core.materials import declared_file
from microimpact.core.nearest import nearest
from study import analyses
from study.declared.parameters import build
from study.declared.references import merged
from study.declared.selection import TABLES, NamedTables
from study.run.config import SECTIONS, Settings, read_configuration, validate
from study.tables import parse_table, read_table

if TYPE_CHECKING:
    import pandas as pd


def run_study(
    name: str, tables: Mapping[str, pd.DataFrame] | None = None, /, **changes: Any
) -> dict[str, pd.DataFrame]:
    """Run one study with the declared inputs and return its tables.

    Tables of earlier studies that it needs are computed first, with the inputs as declared, and
    kept for the next call.

    Parameters
    ----------
    name
        Name of the study and of its branch in ``config/analyses``.
    tables
        Tables of earlier studies by name, to be taken in place of computed ones.
    **changes
        Keys of its branch that differ from the declared ones, as in an overlay: with the unit in
        their name, and within a mapping those that are given.

    Returns
    -------
    dict of pandas.DataFrame
        The study's tables by name, as they stand in ``results/tables`` and ``results/data``.

    Raises
    ------
    ValueError
        If there is no such study, or no such parameter, or a value is not allowed: one line per
        problem.

    Examples
    --------
    >>> smaller = run_study("fig20_force_history", diameter_um=2.58)
    >>> sorted(smaller)
    ['fig20', 'force_ratios']
    """
    if name not in analyses.homes():
        raise ValueError(f"{name!r} is no study{nearest(str(name), analyses.homes())}")
    frames: Any = tables or {}
    if not isinstance(frames, Mapping) or not all(hasattr(t, "columns") for t in frames.values()):
        raise ValueError(f"{tables!r} must be tables of studies by name; parameters are keywords")
    parameters = {field.name for field in fields(analyses.analysis(name).Params)}
    for key in changes:
        if key in SECTIONS and key not in parameters:
            raise ValueError(f"{key}: is shared by all studies: an overlay changes it, not {name}")
    made = Made(name, {name: changes} if changes else {}, only=(name,))
    made.update(frames)
    return made.run(name)


def _plain(value: object) -> object:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"{value!r} must be a number, a text, a list or a mapping")


def run_with(
    name: str,
    branch: Mapping[str, Any],
    rows: Mapping[str, str],
    tables: Mapping[str, pd.DataFrame],
) -> dict[str, pd.DataFrame]:
    """Run one study with plain parameters, declared rows as CSV, and tables of earlier studies."""
    study = analyses.analysis(name)
    inputs = NamedTables({key: parse_table(text) for key, text in rows.items()} | {**tables})
    made: dict[str, pd.DataFrame] = dict(study.run(build(study.Params, branch), inputs))
    return made


class Made(dict[str, "pd.DataFrame"]):
    """Tables of earlier studies, each read or computed when it is first asked for.

    Parameters
    ----------
    name
        Study that takes them.
    changes
        Keys of the configuration that differ from the shipped ones, at every depth; a study
        whose parameters or needs they change is computed anew.
    results
        Folder of a run of the shipped configuration, from which the other tables are read; without
        one, they are computed, and kept for the next call.
    only
        The studies whose branches are changed, if they are known; the others are not looked at.

    Raises
    ------
    ValueError
        If a key is unknown or a value not allowed: one line per problem.
    """

    def __init__(
        self,
        name: str,
        changes: Mapping[str, Any],
        results: Path | None = None,
        only: tuple[str, ...] = (),
    ) -> None:
        super().__init__()
        text = json.dumps(changes, default=_plain)
        self.settings = _settings(text, only) if changes else settings_as_shipped()
        self.results = results
        self.makers = dict(analyses.needs(name))

    def __missing__(self, table: str) -> pd.DataFrame:
        """Return a table, and keep it with all others of its study."""
        maker = self.makers[table]
        if self.moved(maker):
            self.update(self.run(maker))
        elif self.results:
            self[table] = read_table(self.results / f"tables/{table}.csv")
        else:
            self.update({name: made.copy() for name, made in _made(maker).items()})
        return self[table]

    def moved(self, name: str) -> bool:
        """Return whether a study, or one that it needs, has changed parameters."""
        branch = self.settings.branches.get(name)
        changed = branch is not None and branch != settings_as_shipped().branches[name]
        return changed or any(self.moved(maker) for maker in set(analyses.needs(name).values()))

    def run(self, name: str) -> dict[str, pd.DataFrame]:
        """Run a study with the tables that it needs."""
        self.makers |= analyses.needs(name)
        needed = {table: self[table] for table in analyses.needs(name)}
        return run_with(name, self.settings.branches[name], self.settings.rows[name], needed)


@cache
def _made(name: str) -> dict[str, pd.DataFrame]:
    return run_study(name)


@cache
def settings_as_shipped() -> Settings:
    """Return the parameters of all studies by the shipped configuration."""
    base = shipped_configuration()
    return validate(base, base)


@cache
def _settings(changes: str, only: tuple[str, ...]) -> Settings:
    base = shipped_configuration()
    return validate(merged(base, json.loads(changes)), base, only)


@cache
def shipped_configuration() -> dict[str, Any]:
    """Return the configuration of a project or of an installed package, wherever that is."""
    base = read_configuration(declared_file("config.yaml").parent)
    return base | {key: str(declared_file(Path(base[key]).name)) for key in TABLES}
