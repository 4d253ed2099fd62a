"""Rows of the declared tables that one branch of the configuration names.

An analysis depends on the rows it names and on no others, so that a new value for one
material leaves the analyses of all other materials as they are. A branch names a material
by the keys ``particle`` and ``surface`` (together they name a contact) and printed values by
the key ``anchors``, at any depth.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from microimpact.core.nearest import nearest
from microimpact.declared.provenance import EVIDENCE, Declared, as_text, finite_number

Row = dict[str, str]

MATERIAL_COLUMNS = (
    "material",
    "property",
    "value",
    "unit",
    "low",
    "high",
    "evidence",
    "source",
)
CONTACT_COLUMNS = ("particle", "surface", "property", "value", "unit", "evidence", "source")
PRINTED_COLUMNS = ("key", "value", "low", "high", "unit", "where", "note")


class SelectionError(ValueError):
    """A declared table of the wrong form, or a name it does not hold."""


@dataclass(frozen=True, slots=True)
class DeclaredTable:
    """One declared table as text: file, columns and rows."""

    path: str
    columns: tuple[str, ...]
    rows: tuple[Row, ...]

    def text(self, rows: Iterable[Row] | None = None) -> str:
        """Return some rows, or all, as CSV with the header."""
        buffer = io.StringIO()
        writer = csv.DictWriter(buffer, self.columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(self.rows if rows is None else rows)
        return buffer.getvalue()

    def where(self, wanted: Sequence[tuple[str, ...]], *columns: str) -> str:
        """Return as CSV the rows whose columns hold one of the wanted combinations.

        Raises
        ------
        SelectionError
            Naming a combination that no row holds, and the most similar one.
        """
        known = {" on ".join(row[column] for column in columns) for row in self.rows}
        for names in wanted:
            if " on ".join(names) not in known:
                name = " on ".join(names)
                raise SelectionError(f"{self.path}: no rows for {name!r}{nearest(name, known)}")
        chosen = set(wanted)
        return self.text(row for row in self.rows if tuple(row[c] for c in columns) in chosen)


class NamedTables(dict[str, Any]):
    """Tables of a study by name; one that is missing is told in words."""

    def __missing__(self, name: str) -> Any:
        raise SelectionError(
            f"no rows of {name!r}: the study's branch must name some, by its keys particle and "
            "surface or anchors"
        )


def read_declared(
    path: str, columns: Sequence[str], numbers: Sequence[str] = ("value",)
) -> DeclaredTable:
    """Read a declared table and check its form.

    Parameters
    ----------
    path
        CSV file.
    columns
        The header it must have, in this order.
    numbers
        Columns that hold numbers; ``low`` and ``high`` may be empty, and ``value`` beside both.

    Raises
    ------
    SelectionError
        One line per problem, with the file, the line and the column.
    """
    with Path(path).open(encoding="utf-8-sig", newline="") as file:
        reader = csv.DictReader(file, strict=True)
        try:
            header = reader.fieldnames or []
            rows = [(reader.line_num, row) for row in reader]
        except csv.Error as error:
            raise SelectionError(f"{path}, line {reader.line_num + 1}: {error}") from None
        except UnicodeDecodeError as error:
            raise SelectionError(
                f"{path}: must be a text in UTF-8, byte {error.start} is not"
            ) from None
    if list(header) != list(columns):
        raise SelectionError(
            f"{path}: the header is {', '.join(header)}; it must be {', '.join(columns)}"
        )
    found = [f"{path}, line {n}: {line}" for n, row in rows for line in _problems(row, numbers)]
    if found:
        raise SelectionError("\n".join(found))
    return DeclaredTable(path, tuple(columns), tuple(row for _, row in rows))


def _problems(row: Mapping[Any, Any], numbers: Sequence[str]) -> Iterator[str]:
    if None in row or None in row.values():
        yield f"must have {len([key for key in row if key is not None])} fields"
        return
    is_range = bool(row.get("low") and row.get("high"))
    for column in numbers:
        may_be_empty = column in {"low", "high"} or is_range
        if not (may_be_empty and not row[column]) and not finite_number(row[column]):
            yield f"{column} {row[column]!r} must be a finite number"
    if "evidence" in row and row["evidence"] not in EVIDENCE:
        yield f"evidence {row['evidence']!r} must be one of {', '.join(EVIDENCE)}"
    for column in ("source", "unit"):
        if column in row and not row[column].strip():
            yield f"{column} is empty"


def named_materials(branch: object) -> list[tuple[str]]:
    """Return the materials a branch names as particle or surface, in order."""
    found: dict[tuple[str], None] = {}
    for mapping in _mappings(branch):
        for key in ("particle", "surface"):
            if isinstance(mapping.get(key), str):
                found[(mapping[key],)] = None
    return list(found)


def named_contacts(branch: object) -> list[tuple[str, str]]:
    """Return the pairs (particle, surface) that stand side by side in a branch, in order."""
    found: dict[tuple[str, str], None] = {}
    for mapping in _mappings(branch):
        pair = mapping.get("particle"), mapping.get("surface")
        if isinstance(pair[0], str) and isinstance(pair[1], str):
            found[(pair[0], pair[1])] = None
    return list(found)


def named_anchors(branch: object) -> list[tuple[str]]:
    """Return the keys of the printed values that a branch names, in order."""
    found: dict[tuple[str], None] = {}
    for mapping in _mappings(branch):
        for name in mapping.get("anchors", ()):
            found[(name,)] = None
    return list(found)


def _mappings(node: Any) -> Iterator[Mapping[str, Any]]:
    if isinstance(node, Mapping):
        yield node
        for child in node.values():
            yield from _mappings(child)
    elif isinstance(node, list | tuple):
        for child in node:
            yield from _mappings(child)


@dataclass(frozen=True, slots=True)
class DeclaredTables:
    """The declared tables of a configuration."""

    materials: DeclaredTable
    contacts: DeclaredTable
    printed_values: DeclaredTable

    def named_in(self, branch: object) -> dict[str, str]:
        """Return the rows a branch names, by the name its study knows them by, as CSV.

        Raises
        ------
        SelectionError
            If the branch names a material, a contact or a printed value that is not declared.
        """
        tables = {
            "materials": self.materials.where(named_materials(branch), "material"),
            "contacts": self.contacts.where(named_contacts(branch), "particle", "surface"),
            "anchors": self.printed_values.where(named_anchors(branch), "key"),
        }
        return {name: text for name, text in tables.items() if text.count("\n") > 1}

    def contact_rows(self) -> dict[str, str]:
        """Return all materials and all contacts as CSV."""
        return {"materials": self.materials.text(), "contacts": self.contacts.text()}

    def everything(self, declared: Iterable[Declared]) -> dict[str, str]:
        """Return all rows of all tables, and those declared in the configuration, as CSV."""
        columns = tuple(field.name for field in fields(Declared))
        rows = tuple({name: as_text(getattr(d, name)) for name in columns} for d in declared)
        return {
            "declared": DeclaredTable("", columns, rows).text(),
            **self.contact_rows(),
            "printed_values": self.printed_values.text(),
        }


def read_all(materials: str, contacts: str, printed_values: str) -> DeclaredTables:
    """Read the declared tables.

    Raises
    ------
    SelectionError
        If one of them is not of the agreed form.
    """
    bounded = ("value", "low", "high")
    return DeclaredTables(
        read_declared(materials, MATERIAL_COLUMNS, bounded),
        read_declared(contacts, CONTACT_COLUMNS),
        read_declared(printed_values, PRINTED_COLUMNS, bounded),
    )
