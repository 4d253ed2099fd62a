"""One study run from Python, with the declared inputs or some of one's own."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

from microimpact import studies
from microimpact.core.materials import declared_file
from microimpact.core.nearest import nearest
from microimpact.core.tables import parse_table
from microimpact.declared.documents import load
from microimpact.declared.parameters import build
from microimpact.declared.selection import NamedTables
from microimpact.run.config import Settings, checked_branch, validate
from microimpact.run.inputs import declared_tables, study_rows

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
        Name of the study and of its branch in ``config/config.yaml``.
    tables
        Tables of earlier studies by name, to be taken in place of computed ones.
    **changes
        Parameters of the study that differ from the declared ones, with the unit in their name as
        there; within a mapping the keys that are given.

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
    >>> smaller = run_study("force_history", diameter_um=2.58)
    >>> sorted(smaller)
    ['fig20', 'force_ratios']
    """
    settings = _settings()
    if name not in settings.branches:
        raise ValueError(f"{name!r} is no study{nearest(name, settings.branches)}")
    branch = checked_branch(name, _merged(settings.branches[name], changes))
    rows = study_rows(name, branch, settings, declared_tables(_paths()), {})
    given = dict(tables or {})
    for table, maker in studies.needs(name).items():
        if table not in given:
            given[table] = _made(maker)[table].copy()
    return run_with(name, branch, rows, given)


def run_with(
    name: str,
    branch: Mapping[str, Any],
    rows: Mapping[str, str],
    tables: Mapping[str, pd.DataFrame],
) -> dict[str, pd.DataFrame]:
    """Run one study with all that it is given.

    Parameters
    ----------
    name
        Name of the study.
    branch
        Plain values of its parameters.
    rows
        Rows of declared tables, as CSV by table.
    tables
        Tables of earlier studies by name.

    Returns
    -------
    dict of pandas.DataFrame
        The study's tables by name.
    """
    study = studies.study(name)
    inputs = NamedTables({key: parse_table(text) for key, text in rows.items()})
    inputs.update(tables)
    found: dict[str, pd.DataFrame] = dict(study.run(build(study.Params, branch), inputs))
    return found


@cache
def _made(name: str) -> dict[str, pd.DataFrame]:
    return run_study(name)


@cache
def _settings() -> Settings:
    base = load(declared_file("config.yaml"))
    return validate(base, base)


def _paths() -> tuple[str, str, str]:
    """Return where the declared tables stand, in a project or in an installed package."""
    names = (path.rpartition("/")[2] for path in _settings().general.tables)
    materials, contacts, printed_values = (str(declared_file(name)) for name in names)
    return materials, contacts, printed_values


def _merged(before: Any, after: Any) -> Any:
    """Put changes into a mapping; a distribution of another kind is replaced as a whole."""
    if not (isinstance(before, Mapping) and isinstance(after, Mapping)):
        return after
    if "kind" in after and after["kind"] != before.get("kind"):
        return after
    kept = {key: _merged(before[key], after[key]) for key in before if key in after}
    return {**before, **after, **kept}
