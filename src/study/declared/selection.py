"""Declared tables, and the rows of them that one branch of the configuration names.

An analysis depends on the rows it names and on no others, so that a new value for one
material leaves the analyses of all other materials as they are. What of its parameters are names,
and of what, their types say (`declared.parameters.Names`).
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, fields, make_dataclass, replace
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_args, get_type_hints

from pydantic import AfterValidator, ValidationError

from study.declared.documents import ConfigError
from study.declared.parameters import Finite, NonNegative, build, explain
from study.declared.provenance import EVIDENCE, Declared, as_text
from study.tables import NotComputedError, computed, read_table

T = TypeVar("T")
Row = dict[str, str]

# The impact that a printed value is of; empty where it is general.
IMPACT = ("particle", "surface", "diameter_um", "speed_m_per_s", "angle_deg")
# The values of the configuration, as a table.
DECLARED = "declared"
# What a table is called in a study, where that is not the name of its file.
IN_STUDIES = {"printed_values": "printed"}


def _words(text: str) -> str:
    if not text.strip():
        raise ValueError(f"{text!r} must not be empty")
    return text


def _evidence(text: str) -> str:
    if text not in EVIDENCE:
        raise ValueError(f"{text!r} must be one of {', '.join(EVIDENCE)}")
    return text


def _numbers(text: str) -> str:
    for part in re.split("; | to ", text) if text else ():
        number = _number(part)
        if not isinstance(number, float) or not math.isfinite(number):
            raise ValueError(f"{text!r} must be numbers, as 49; 62 or 15 to 85, or empty")
    return text


def _number(text: str) -> float | str | None:
    """Return a number, None for an empty text, and any other text unchanged."""
    try:
        return float(text) if text.strip() else None
    except ValueError:
        return text


def _in_order(row: Any) -> None:
    """Refuse a row without value and range, and a value out of its range."""
    low, high = getattr(row, "low", None), getattr(row, "high", None)
    if row.value is None and None in (low, high):
        raise ValueError("value: None must be a number, or low and high both")
    if low is not None and high is not None:
        if low >= high:
            raise ValueError(f"low: {low:g} must be below high, {high:g}")
        if row.value is not None and not low <= row.value <= high:
            raise ValueError(f"value: {row.value:g} must be from low to high, {low:g} to {high:g}")


Words = Annotated[str, AfterValidator(_words)]
# Types of the columns that are no mere texts, in all tables.
TYPES: dict[str, Any] = {
    **dict.fromkeys(("value", "low", "high", "at"), Finite | None),
    "reading_error": NonNegative | None,
    "unit": Words,
    "evidence": Annotated[str, AfterValidator(_evidence)],
    "source": Words,
    **dict.fromkeys(IMPACT[2:], Annotated[str, AfterValidator(_numbers)]),
}


def _table(columns: str, *named_by: str) -> tuple[type[Any], tuple[str, ...]]:
    types = [(name, TYPES.get(name, str)) for name in columns.split()]
    kind = make_dataclass("Row", types, kw_only=True, namespace={"__post_init__": _in_order})
    return kind, named_by


# The declared tables: a dataclass of their columns, and the columns whose texts name a row.
TABLES = {
    "materials": _table("material property value unit low high evidence source", "material"),
    "contacts": _table(
        "particle surface property value unit evidence source", "particle", "surface"
    ),
    "printed_values": _table(f"key value low high unit {' '.join(IMPACT)} where note", "key"),
    "external": _table(
        "name quantity reading at at_unit value low high unit reading_error evidence source", "name"
    ),
}


def read_rows(path: str, kind: type[T]) -> tuple[dict[int, tuple[Row, T]], list[str], list[str]]:
    """Read a CSV file whose columns are the fields of a dataclass.

    Returns
    -------
    rows
        By line: its texts, and the dataclass.
    comments
        Lines that begin with ``#``.
    problems
        One for each row that is refused, with its line and column.

    Raises
    ------
    ConfigError
        If the file is no CSV table in UTF-8 with these columns.
    """
    try:
        lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path}: must be a text in UTF-8, byte {error.start} is not") from None
    columns = [field.name for field in fields(kind)]  # type: ignore[arg-type]
    hints = get_type_hints(kind)
    numbers = {name for name in columns if float in (hints[name], *get_args(hints[name]))}
    # Comments become blank lines, so that the reader counts all.
    reader = csv.reader(["" if line.startswith("#") else line for line in lines], strict=True)
    rows, problems = dict[int, tuple[Row, T]](), list[str]()
    try:
        header = next(filter(None, reader), [])
        if header != columns:
            names = f"{', '.join(header)}; it must be {', '.join(columns)}"
            raise ConfigError(f"{path}: the header is {names}")
        for cells in filter(None, reader):
            line = reader.line_num
            if len(cells) != len(columns):
                wanted = f"must have {len(columns)} fields, has {len(cells)}"
                problems.append(f"line {line}: {wanted}; one with a comma needs double quotes")
                continue
            texts = dict(zip(columns, cells, strict=True))
            values = {name: _number(t) if name in numbers else t for name, t in texts.items()}
            try:
                rows[line] = texts, build(kind, values)
            except ValidationError as error:
                faults = (fault.removeprefix(": ") for fault in explain(error, kind, ""))
                problems += [f"line {line}, {fault}" for fault in faults]
    except csv.Error as error:
        problems.append(f"line {reader.line_num}: {error}")
    return rows, [line for line in lines if line.startswith("#")], problems


@dataclass(frozen=True, slots=True)
class DeclaredTable:
    """One declared table as text: file, columns, rows, and the columns that name a row."""

    path: str
    columns: tuple[str, ...]
    rows: tuple[Row, ...]
    named_by: tuple[str, ...] = ()

    def text(self, names: Collection[str] | None = None) -> str:
        """Return the rows of some names, or all, as CSV with the header."""
        buffer = io.StringIO()
        writer = csv.DictWriter(buffer, self.columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(row for row in self.rows if names is None or self.name(row) in names)
        return buffer.getvalue()

    def name(self, row: Row) -> str:
        """Return the name of a row."""
        return " on ".join(row[column] for column in self.named_by)

    @property
    def names(self) -> set[str]:
        """Names of the rows."""
        return set(map(self.name, self.rows))

    def with_properties(self, by_name: Mapping[str, Mapping[str, float | str]]) -> DeclaredTable:
        """Return the table with a user's properties by name, in place of those it has.

        A value is a number, or one with its unit, as ``2329 kg/m3``.
        """
        rows = {}
        for name, properties in by_name.items():
            named = dict(zip(self.named_by, name.split(" on "), strict=True))
            for key, text in properties.items():
                value, _, unit = str(text).partition(" ")
                amount = {"property": key, "value": value, "unit": unit or "-"}
                user = {"evidence": "user", "source": "given without a source"}
                rows[name, key] = dict.fromkeys(self.columns, "") | named | amount | user
        kept = (row for row in self.rows if (self.name(row), row["property"]) not in rows)
        path = f"{self.path} and properties" if by_name else self.path
        return replace(self, path=path, rows=(*kept, *rows.values()))


def read_declared(path: str, table: str) -> DeclaredTable:
    """Read a declared table, one of `TABLES`.

    Raises ConfigError: one line per problem, with the file, the line and the column.
    """
    kind, named_by = TABLES[table]
    rows, _, problems = read_rows(path, kind)
    if problems:
        raise ConfigError("\n".join(f"{path}, {problem}" for problem in problems))
    columns = tuple(field.name for field in fields(kind))
    return DeclaredTable(path, columns, tuple(texts for texts, _ in rows.values()), named_by)


class NamedTables(dict[str, Any]):
    """Tables of a study by name, given as they are or as files; a missing one says why."""

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
        raise ConfigError(f"no rows of {name!r}: the study's branch must name some")


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
            numbers: dict[str, Any] = {n: _exact(row[n]) for n in ("value", "low", "high")}
            numbers["range"] = [numbers["low"], numbers["high"]]
            words = "printed", row["where"], f"printed.{row['key']}"
            parts = {n: Declared(v, *words, given_unit=row["unit"]) for n, v in numbers.items()}
            printed[row["key"]] = parts["value"] if row["value"] else parts
        return printed

    def pairs(self) -> dict[str, dict[str, Declared]]:
        """Return the contacts to be referred to, by pair and property."""
        pairs: dict[str, dict[str, Declared]] = {}
        for row in self.contacts.rows:
            pair, name = f"{row['particle']} on {row['surface']}", row["property"]
            words = row["evidence"], row["source"], f"contacts.{pair}.{name}"
            value = Declared(_exact(row["value"]), *words, given_unit=row["unit"])
            pairs.setdefault(pair, {})[name] = value
        return pairs

    def names(self) -> dict[str, tuple[str, set[str]]]:
        """Return the names that can be referred to, by sort: their file, and the names."""
        tables = {name: getattr(self, name) for name in TABLES}
        return {name: (table.path, table.names) for name, table in tables.items()}

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
            IN_STUDIES.get(name, name): getattr(self, name).text(wanted[name]) for name in TABLES
        }
        return {name: text for name, text in rows.items() if text.count("\n") > 1}

    def of_pair(self, particle: str, surface: str) -> dict[str, str]:
        """Return the rows of a pair and of its materials, as `named` does."""
        named = ("materials", particle), ("materials", surface)
        return self.named([*named, ("contacts", f"{particle} on {surface}")], {})

    def whole(self, names: Collection[str], declared: Iterable[Declared] = ()) -> dict[str, str]:
        """Return all rows of some tables as CSV; of `DECLARED`, those of the configuration."""
        texts = {name: getattr(self, name).text() for name in names if name != DECLARED}
        if DECLARED in names:
            columns = ("key", "value", "unit", "evidence", "source", "origin", "overrides")
            rows = ({name: as_text(getattr(row, name)) for name in columns} for row in declared)
            texts[DECLARED] = DeclaredTable("", columns, tuple(rows)).text()
        return texts


def _exact(text: str) -> int | float | None:
    """Return a number as it is written: 62 is an integer."""
    try:
        return int(text)
    except ValueError:
        return float(text) if text else None


def read_all(paths: Mapping[str, str]) -> DeclaredTables:
    """Read the declared tables, each from its path.

    Raises ConfigError if one of them is not of the agreed form.
    """
    return DeclaredTables(**{name: read_declared(paths[name], name) for name in TABLES})
