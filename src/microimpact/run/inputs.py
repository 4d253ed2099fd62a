"""The files of declared inputs of a run, read and checked before anything is made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from microimpact.core.materials import materials_from_rows
from microimpact.declared.documents import load
from microimpact.declared.selection import DeclaredTables, read_all
from microimpact.figures.registry import FigureSpec, filled, registry
from microimpact.model.pairs import pairs_from_rows
from microimpact.run.config import Settings
from microimpact.run.digitised import Digitized, as_rows, read_folder


@dataclass(frozen=True, slots=True, kw_only=True)
class Inputs:
    """What a run is made from besides its configuration.

    Attributes
    ----------
    tables
        Materials, contacts and printed values.
    rows
        Rows of these that each study is given, as CSV by table.
    figure_entries, figures
        The figure registry with values filled in, plain and checked.
    digitized
        Digitised points by figure.
    """

    tables: DeclaredTables
    rows: Mapping[str, Mapping[str, str]]
    figure_entries: Mapping[str, Any]
    figures: Mapping[str, FigureSpec]
    digitized: Mapping[str, Digitized]


def read_inputs(settings: Settings) -> Inputs:
    """Read and check every file that a checked configuration names.

    Raises
    ------
    ValueError
        With one line per problem that names the key, or the file and its line or column.
    OSError
        If a file cannot be read.
    """
    general = settings.general
    tables = declared_tables(general.tables)
    entries = filled(load(general.figures), settings.branches)
    figures = registry(entries)
    digitized = read_folder(general.digitized, figures)
    return Inputs(
        tables=tables,
        rows={
            name: study_rows(name, branch, settings, tables, digitized)
            for name, branch in settings.branches.items()
        },
        figure_entries=entries,
        figures=figures,
        digitized=digitized,
    )


@cache
def declared_tables(paths: tuple[str, str, str]) -> DeclaredTables:
    """Return the tables of materials, contacts and printed values, read and checked.

    Raises
    ------
    ValueError
        With one line per problem that names the file and its line or column.
    """
    tables = read_all(*paths)
    materials_from_rows(tables.materials.rows)
    pairs_from_rows(tables.contacts.rows)
    return tables


def study_rows(
    name: str,
    branch: Mapping[str, Any],
    settings: Settings,
    tables: DeclaredTables,
    digitized: Mapping[str, Digitized],
) -> dict[str, str]:
    """Return the declared rows that a study is given, as CSV by table.

    That are the rows its branch names; but the study of all contacts has all, and the table of
    declared inputs everything. Digitised points go to the studies that compare with them.
    """
    if name == "declared_inputs":
        return tables.everything(settings.declared)
    if name == "contact_properties":
        return tables.contact_rows()
    if name == "digitised_comparison":
        return as_rows(digitized, digitized)
    if name == "restitution_fits":
        return tables.named_in(branch) | as_rows(digitized, ("fig15", "fig16"))
    return tables.named_in(branch)
