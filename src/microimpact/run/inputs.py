"""The files of declared inputs of a run, read and checked before anything is made."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from microimpact.core.materials import Material, materials_from_rows
from microimpact.declared.documents import load
from microimpact.declared.selection import DeclaredTable
from microimpact.figures.registry import FigureSpec, filled, registry
from microimpact.model.pairs import Pair, Pairs, pair_contact, pairs_from_rows
from microimpact.model.plausibility import LARGEST, SMALLEST, doubt_of_input, doubts_of_material
from microimpact.run.config import Settings
from microimpact.run.digitised import Digitised, as_rows, read_folder


@dataclass(frozen=True, slots=True, kw_only=True)
class Inputs:
    """What a run is made from besides its configuration."""

    # Rows of the declared tables that each study is given, as CSV by table.
    rows: Mapping[str, Mapping[str, str]]
    # The figure registry with values filled in, plain and checked.
    figure_entries: Mapping[str, Any]
    figures: Mapping[str, FigureSpec]
    digitised: Mapping[str, Digitised]  # Digitised points by figure


def read_inputs(settings: Settings) -> Inputs:
    """Read and check every file that a checked configuration names.

    Raises ValueError: with one line per problem that names the key, or the file and its line or
    column. Raises OSError if a file cannot be read.
    """
    general = settings.general
    tables = settings.tables
    materials = _materials(tables.materials)
    pairs = pairs_from_rows(tables.contacts.rows)
    for key in ("figures", "claims"):
        if not Path(path := getattr(general, key)).is_file():
            raise ValueError(f"{key}: {path!r} must be a file; there is none")
    inputs = (doubt_of_input(row.key, row.value) for row in settings.declared)
    wrong = [line for line in inputs if line]
    wrong += [
        f"{general.materials}: {name}: {line}"
        for name, material in materials.items()
        for line in doubts_of_material(material)
    ]
    wrong += [
        f"{general.contacts}: {line}"
        for pair in pairs
        for line in _out_of_range(pair, materials, pairs)
    ]
    if wrong:
        raise ValueError("\n".join(wrong))
    entries = filled(load(general.figures), settings.branches)
    figures = registry(entries)
    digitised = read_folder(general.digitised, figures)
    return Inputs(
        rows={name: study_rows(name, settings, digitised) for name in settings.branches},
        figure_entries=entries,
        figures=figures,
        digitised=digitised,
    )


def _materials(table: DeclaredTable) -> dict[str, Material]:
    """Return the materials; those of the ends of what is uncertain must be possible, too."""
    try:
        for end in ("low", "high"):
            materials_from_rows({**row, "value": row[end] or row["value"]} for row in table.rows)
        return materials_from_rows(table.rows)
    except ValueError as error:
        raise ValueError(f"{table.path}: {error}") from None


def study_rows(name: str, settings: Settings, digitised: Mapping[str, Digitised]) -> dict[str, str]:
    """Return the declared rows that a study is given, as CSV by table.

    That are the rows its branch names; but the study of all contacts has all, and the table of
    declared inputs everything. Digitised points go to the studies that compare with them.
    """
    if name == "declared_inputs":
        return settings.tables.everything(settings.declared)
    if name == "contact_properties":
        return settings.tables.contact_rows()
    if name == "digitised_comparison":
        return as_rows(digitised, digitised)
    compared = ("fig15", "fig16") if name == "restitution_fits" else ()
    return {**settings.rows[name], **as_rows(digitised, compared)}


def _out_of_range(pair: Pair, materials: Mapping[str, Material], pairs: Pairs) -> Iterator[str]:
    try:
        contact = pair_contact(*pair, materials, pairs)
        if not SMALLEST <= contact.diameter <= LARGEST:
            allowed = f"from {SMALLEST:g} to {LARGEST:g} m"
            raise ValueError(f"diameter {contact.diameter:.3g} m must be {allowed}")
    except ValueError as error:
        yield f"{pair[0]} on {pair[1]}: {error}"
