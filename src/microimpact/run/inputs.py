"""The files of declared inputs of a run, read and checked before anything is made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from microimpact.core.materials import materials_from_rows
from microimpact.declared.documents import load
from microimpact.declared.selection import DeclaredTables, read_all
from microimpact.figures.registry import FigureSpec, filled, registry
from microimpact.model.pairs import pairs_from_rows
from microimpact.run.config import Settings
from microimpact.run.digitised import Digitized, read_folder


@dataclass(frozen=True, slots=True, kw_only=True)
class Inputs:
    """What a run is made from besides its configuration.

    Attributes
    ----------
    tables
        Materials, contacts and printed values.
    rows
        Rows of these that each branch names, as CSV by table.
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
    tables = read_all(*general.tables)
    materials_from_rows(tables.materials.rows)
    pairs_from_rows(tables.contacts.rows)
    entries = filled(load(general.figures), settings.branches)
    figures = registry(entries)
    return Inputs(
        tables=tables,
        rows={name: tables.named_in(branch) for name, branch in settings.branches.items()},
        figure_entries=entries,
        figures=figures,
        digitized=read_folder(general.digitized, figures),
    )
