"""Rows of the declared tables that one branch of the configuration names.

An analysis depends on the rows it names and on no others, so that a new value for one
material leaves the analyses of all other materials as they are. What of its parameters are names,
and of what, their types say (`declared.parameters.Names`).
"""

from __future__ import annotations

import csv
import io
import re
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from study.declared.provenance import EVIDENCE, Declared, as_text, finite_number
from study.tables import NotComputedError, computed, read_table

Row = dict[str, str]

MATERIAL_COLUMNS = ("material", "property", "value", "unit", "low", "high", "evidence", "source")
CONTACT_COLUMNS = ("particle", "surface", "property", "value", "unit", "evidence", "source")
# The impact that a printed value is of; empty where it is general.
IMPACT = ("particle", "surface", "diameter_um", "speed_m_per_s", "angle_deg")
PRINTED_COLUMNS = ("key", "value", "low", "high", "unit", *IMPACT, "where", "note")
EXTERNAL_COLUMNS = (
    *("name", "quantity", "reading", "at", "at_unit"),
    *("value", "low", "high", "unit", "reading_error", "evidence", "source"),
)
# The declared tables, and the columns whose texts name a row.
TABLES = {
    "materials": ("material",),
    "contacts": ("particle", "surface"),
    "printed_values": ("key",),
    "external": ("name",),
}
# What a table is called in a study, where that is not the name of its file.
IN_STUDIES = {"printed_values": "printed"}
_BOUNDED = ("value", "low", "high")
# Columns of numbers that may be empty; so may a value beside both ends.
_OPTIONAL = {"low", "high", "at", "reading_error"}


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

    def known(self, *columns: str) -> set[str]:
        """Return the names of its rows, made of the texts in some columns."""
        return {" on ".join(row[column] for column in columns) for row in self.rows}

    def where(self, names: Collection[str], *columns: str) -> str:
        """Return as CSV the rows of some names."""
        return self.text(r for r in self.rows if " on ".join(r[c] for c in columns) in names)


class NamedTables(dict[str, Any]):
    """Tables of a study by name; asking for one that is missing says why.

    `tables`: as they are, or the files of some. One that could not be computed is missing.
    """

    def __init__(self, tables: Mapping[str, Any]) -> None:
        super().__init__()
        self.lacking = dict[str, NotComputedError]()
        for name, table in tables.items():
            try:
                self[name] = read_table(table) if isinstance(table, str | Path) else computed(table)
            except NotComputedError as why:
                self.lacking[name] = why

    def __missing__(self, name: str) -> Any:
        """Raise the reason why there is no such table."""
        if name in self.lacking:
            raise self.lacking[name]
        raise SelectionError(f"no rows of {name!r}: the study's branch must name some")


def read_declared(
    path: str, columns: Sequence[str], numbers: Sequence[str] = ("value",)
) -> DeclaredTable:
    """Read a declared table and check its form.

    Parameters
    ----------
    columns
        The header it must have, in this order.
    numbers
        Columns that hold numbers; those of `_OPTIONAL` may be empty, and ``value`` beside a range.

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
    problems = [f"{path}, line {n}: {line}" for n, row in rows for line in _problems(row, numbers)]
    if problems:
        raise SelectionError("\n".join(problems))
    return DeclaredTable(path, tuple(columns), tuple(row for _, row in rows))


def _problems(row: Mapping[Any, Any], numbers: Sequence[str]) -> Iterator[str]:
    if None in row or None in row.values():
        yield f"must have {len([key for key in row if key is not None])} fields"
        return
    is_range = bool(row.get("low") and row.get("high"))
    wrong = [
        f"{column} {row[column]!r} must be a finite number"
        for column in numbers
        if not finite_number(row[column]) and (row[column] or not (is_range or column in _OPTIONAL))
    ]
    yield from wrong or _out_of_order(row, is_range=is_range)
    for column in IMPACT[2:]:
        if "key" in row and not all(map(finite_number, _numbers(row[column]))):
            yield f"{column} {row[column]!r} must be numbers, as 49; 62 or 15 to 85, or empty"
    if "evidence" in row and row["evidence"] not in EVIDENCE:
        yield f"evidence {row['evidence']!r} must be one of {', '.join(EVIDENCE)}"
    for column in ("source", "unit"):
        if column in row and not row[column].strip():
            yield f"{column} is empty"


def _numbers(cell: str) -> list[str]:
    return re.split("; | to ", cell) if cell else []


def _out_of_order(row: Mapping[Any, Any], *, is_range: bool) -> Iterator[str]:
    if is_range:
        low, high = float(row["low"]), float(row["high"])
        if low >= high:
            yield f"low {low:g} must be below high, {high:g}"
        elif row["value"] and not low <= float(row["value"]) <= high:
            yield f"value {row['value']} must be from low to high, {low:g} to {high:g}"
    if float(row.get("reading_error") or 0.0) < 0.0:
        yield f"reading_error {row['reading_error']} must not be negative"


def _number(text: str) -> int | float | None:
    try:
        return int(text)
    except ValueError:
        return float(text) if text else None


@dataclass(frozen=True, slots=True)
class DeclaredTables:
    """The declared tables of a configuration."""

    materials: DeclaredTable
    contacts: DeclaredTable
    printed_values: DeclaredTable
    external: DeclaredTable

    def printed(self) -> dict[str, Declared | dict[str, Declared]]:
        """Return the printed values to be referred to; a range by its ends, or as a list."""
        printed: dict[str, Declared | dict[str, Declared]] = {}
        for row in self.printed_values.rows:
            numbers: dict[str, Any] = {column: _number(row[column]) for column in _BOUNDED}
            numbers["range"] = [numbers["low"], numbers["high"]]
            parts = {
                name: Declared(value, "printed", row["where"], f"printed.{row['key']}")
                for name, value in numbers.items()
            }
            printed[row["key"]] = parts["value"] if row["value"] else parts
        return printed

    def pairs(self) -> dict[str, dict[str, Declared]]:
        """Return the contacts to be referred to, by pair and property."""
        pairs: dict[str, dict[str, Declared]] = {}
        for row in self.contacts.rows:
            pair, name = f"{row['particle']} on {row['surface']}", row["property"]
            words = row["evidence"], row["source"], f"contacts.{pair}.{name}"
            pairs.setdefault(pair, {})[name] = Declared(_number(row["value"]), *words)
        return pairs

    def units(self) -> dict[str, str]:
        """Return the units of printed values and contacts, by dotted key."""
        printed = {f"printed.{row['key']}": row["unit"] for row in self.printed_values.rows}
        return printed | {
            f"contacts.{row['particle']} on {row['surface']}.{row['property']}": row["unit"]
            for row in self.contacts.rows
        }

    def names(self) -> dict[str, tuple[str, set[str]]]:
        """Return the names that can be referred to, by sort: their file, and the names."""
        tables = {name: getattr(self, name) for name in TABLES}
        return {name: (each.path, each.known(*TABLES[name])) for name, each in tables.items()}

    def named(
        self, named: Iterable[tuple[str, str]], bodies: Mapping[str, tuple[str, str]]
    ) -> dict[str, str]:
        """Return the rows a branch names, by the name that its study uses, as CSV.

        Parameters
        ----------
        named
            Sort and name of each.
        bodies
            Materials of particle and surface of each calibrated case.
        """
        wanted = defaultdict[str, set[str]](set)
        for sort, name in named:
            if sort == "cases":  # or a declared pair by its name
                wanted["materials"].update(bodies.get(name) or name.split(" on "))
                wanted["contacts"].add(name)
            else:
                wanted[sort].add(name)
        rows = {
            IN_STUDIES.get(name, name): getattr(self, name).where(wanted[name], *by)
            for name, by in TABLES.items()
        }
        return {name: text for name, text in rows.items() if text.count("\n") > 1}

    def of_pair(self, particle: str, surface: str) -> dict[str, str]:
        """Return the rows of a pair and of its materials, as `named` does."""
        named = ("materials", particle), ("materials", surface)
        return self.named([*named, ("contacts", f"{particle} on {surface}")], {})

    def contact_rows(self) -> dict[str, str]:
        """Return all materials and all contacts as CSV."""
        return {"materials": self.materials.text(), "contacts": self.contacts.text()}

    def everything(self, declared: Iterable[Declared]) -> dict[str, str]:
        """Return all rows of all tables, and those declared in the configuration, as CSV."""
        columns = ("key", "value", "unit", "evidence", "source", "origin", "overrides")
        rows = tuple({name: as_text(getattr(row, name)) for name in columns} for row in declared)
        return {
            "declared": DeclaredTable("", columns, rows).text(),
            **self.contact_rows(),
            "printed_values": self.printed_values.text(),
            "external": self.external.text(),
        }


def read_all(materials: str, contacts: str, printed_values: str, external: str) -> DeclaredTables:
    """Read the declared tables.

    Raises SelectionError if one of them is not of the agreed form.
    """
    return DeclaredTables(
        read_materials(materials),
        read_declared(contacts, CONTACT_COLUMNS),
        read_declared(printed_values, PRINTED_COLUMNS, _BOUNDED),
        read_declared(external, EXTERNAL_COLUMNS, (*_BOUNDED, "at", "reading_error")),
    )


def read_materials(path: str) -> DeclaredTable:
    """Read a table of materials, see `read_declared`."""
    return read_declared(path, MATERIAL_COLUMNS, _BOUNDED)
