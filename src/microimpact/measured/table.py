"""Tables of numbers with units, from text files as laboratories write them, or from memory.

What stands behind the name of a column is understood as its unit, or refused. Speeds, and sizes,
without a unit of their own are in that of the option, else in that which another column of their
kind states, else in SI units.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from microimpact.core.materials import LENGTH, SPEED
from microimpact.core.nearest import nearest

SPEED_UNITS = {**SPEED, "cm/s": 1e-2, "um/s": 1e-6, "km/h": 1.0 / 3.6}
SIZE_UNITS = {**LENGTH, "cm": 1e-2}
SHARE_UNITS = {"": 1.0, "1": 1.0, "-": 1.0, "%": 1e-2}
ANGLE_UNITS = {"deg": 1.0, "rad": 180.0 / np.pi}
# Kinds of columns whose unit may be that of another one, or of an option.
SPEEDS, SIZES = "speeds", "sizes"
OPTIONS = {SPEEDS: ("m/s", SPEED_UNITS), SIZES: ("m", SIZE_UNITS)}

# Cells without a number, as people and programs write them.
MISSING = {"", "-", "--", "n.d.", "nd", "n/a", "na", "<na>", "nan", "nat", "none", "null"}
MISSING |= {"#n/a", "#nv", "k.a."}
SEPARATORS = {"comma": ",", "semicolon": ";", "tab": "\t", "bar": "|", "space": " "}
COMMENTS = ("#", "%")
# Bad or missing rows that a message names at most.
NAMED = 10
_OTHER = {".": ",", ",": "."}
_WORDS = {"percent": "%", "degree": "deg", "degrees": "deg", "°": "deg", "radians": "rad"}
_WORDS |= dict.fromkeys(("micron", "microns", "micrometer", "micrometre", "micrometers"), "um")
_PER_TIME = re.compile(
    r"([cmku]?m)(?:[\s_.·*/]*|[\s_]*per[\s_]*|p)(s|sec|h)\s*(?:\^?-1|⁻¹|\*\*-1)?"
)
_BRACKETS = re.compile(r"(.+?)[\s_/]*[(\[]([^()\[\]]*|\([^()]*\))[)\]]")
# What may part a name from its unit; behind the stated ones nothing but a unit may stand.
_PARTED = re.compile(r"\s*:\s*|\s+(?:in|/)\s+|[\s_,/]+")
_STATED = {":", "in", "/"}

Kept = TypeVar("Kept")


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """A column of numbers, or of words.

    Attributes
    ----------
    units
        Factors to SI; none for words.
    names
        Usual names beside its own, in lower case; those of one letter as they are.
    kind
        `SPEEDS` or `SIZES`, whose unit may stand elsewhere.
    """

    units: Mapping[str, float] = field(default_factory=dict)
    names: tuple[str, ...] = ()
    kind: str = ""


@dataclass(frozen=True, slots=True)
class Row:
    """One row: where it is, its cells as they are written, and its numbers in SI units.

    A number that is missing is not there.
    """

    where: str
    cells: Mapping[str, str]
    numbers: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Table:
    """Rows by their columns.

    Attributes
    ----------
    name
        Of the file.
    columns
        Columns that it has, of those looked for.
    units
        Unit of each column of numbers.
    stated
        Columns whose unit was given, by the header, a row of units, an option or a neighbour.
    rows, bad
        Rows, and what is wrong with the others.
    ignored
        Headers of columns that are not used.
    """

    name: str
    columns: Sequence[str]
    units: Mapping[str, str]
    stated: frozenset[str]
    rows: Sequence[Row]
    bad: Sequence[str]
    ignored: Sequence[str]

    def kept(
        self, build: Callable[[Row], Kept | None], *, skip_bad_rows: bool
    ) -> tuple[list[Kept], list[str]]:
        """Build an item of each row, with notes on the rows left out.

        Parameters
        ----------
        build
            Returns None if the row lacks a number; raises ValueError if it has a wrong one.
        skip_bad_rows
            Whether wrong rows are left out, too.

        Raises
        ------
        ValueError
            Naming all wrong rows, or that none is left.
        """
        built, bad, skipped = [], list(self.bad), []
        for row in self.rows:
            try:
                made = build(row)
            except ValueError as error:
                bad.append(f"{row.where}: {error}")
                continue
            if made is None:
                skipped.append(row.where)
            else:
                built.append(made)
        bad.sort(key=lambda words: int(words.partition(":")[0].split()[1]))
        wrong = f"{self.name}, {_listed(bad, '; ')}"
        if bad and not skip_bad_rows:
            many = f"; {len(bad)} bad rows" if len(bad) > 1 else ""
            raise ValueError(f"{wrong}{many}; --skip-bad-rows leaves them out")
        notes = [f"bad rows are left out: {wrong}"] if bad else []
        if skipped:
            notes.append(
                f"{self.name}: {len(skipped)} of {len(self.rows)} rows lack a number and are "
                f"skipped: {_listed(skipped, ', ')}"
            )
        if not built:
            raise ValueError("; ".join([f"{self.name}: no data below the header", *notes]))
        return built, notes


def _listed(words: Sequence[str], between: str) -> str:
    return between.join(words[:NAMED]) + (" ..." if len(words) > NAMED else "")


def read_table(
    source: Path | str | Mapping[str, Any],
    wanted: Mapping[str, Column],
    *,
    units: Mapping[str, str | None],
    columns: Mapping[str, str] | None = None,
    delimiter: str | None = None,
    decimal: str | None = None,
    encoding: str | None = None,
) -> Table:
    """Read a text file, a data frame, or a mapping of arrays.

    Parameters
    ----------
    source
        The file or the table. Lines that begin with ``#`` or ``%`` are comments. The first row may
        hold the units.
    wanted
        Columns that are looked for, by their names.
    units
        Units by kind where the header has none; None: not given.
    columns
        Headers in the source by the names of columns.
    delimiter, decimal, encoding
        As of `microimpact.measured.rebounds.read_rebounds`.

    Raises
    ------
    OSError
        If the file cannot be read.
    TypeError, ValueError
        With file, line, column, value and the allowed values.
    """
    options = {kind: _option(kind, unit) for kind, unit in units.items() if unit is not None}
    if isinstance(source, str | Path):
        name, header, rows = _file(Path(source), delimiter, encoding)
    else:
        name, header, rows = _in_memory(source)
        decimal = "."
    places, stated = _places(name, header, wanted, columns or {}, options)
    width = max((at for at, cell in enumerate(header, 1) if cell), default=0)
    named, bad = [], []
    for where, cells in rows:
        # Spreadsheets end lines with separators of empty columns.
        if len(cells) < width or any(cells[len(header) :]):
            bad.append(f"{where}: {len(cells)} cells, but {len(header)} columns in the header")
        else:
            named.append((where, {column: cells[at] for column, at in places.items()}))
    numeric = [column for column in places if wanted[column].units]
    if named and (below := _row_of_units(name, *named[0], numeric, wanted)):
        if twice := [each for each in below if stated.get(each, below[each]) != below[each]]:
            raise ValueError(f"{name}: the units of {', '.join(twice)} must be the same twice")
        stated |= below
        named = named[1:]
    mark = _decimal(name, [cells[c] for _, cells in named for c in numeric], decimal)
    units_of, known = _units(numeric, wanted, stated, options)
    built = []
    for where, texts in named:
        try:
            numbers = {
                column: number * wanted[column].units[units_of[column]]
                for column in numeric
                if (number := _number(column, texts[column], mark)) is not None
            }
        except ValueError as error:
            bad.append(f"{where}: {error}")
        else:
            built.append(Row(where, texts, numbers))
    ignored = [cell for at, cell in enumerate(header) if cell and at not in places.values()]
    return Table(name, [*places], units_of, known, built, bad, ignored)


def _file(
    path: Path, delimiter: str | None, encoding: str | None
) -> tuple[str, list[str], list[tuple[str, list[str]]]]:
    """Name, header, and rows with their places, of a text file."""
    lines = [
        (f"line {at}", line)
        for at, line in enumerate(_text(path, encoding).splitlines(), 1)
        if line.strip() and not line.lstrip().startswith(COMMENTS)
    ]
    if not lines:
        raise ValueError(f"{path.name}: no header and no data")
    separator = _separator(lines[0][1], delimiter)
    header, *rows = [
        (where, _cells(f"{path.name}, {where}", line, separator)) for where, line in lines
    ]
    return path.name, header[1], rows


def _text(path: Path, encoding: str | None) -> str:
    data = path.read_bytes()
    if data.startswith(b"PK\x03\x04"):
        raise ValueError(f"{path.name}: must be a text, got a workbook or archive; save it as CSV")
    try:
        if encoding:
            return data.decode(encoding)
        if data.startswith((b"\xff\xfe", b"\xfe\xff")):
            return data.decode("utf-16")
        try:
            return data.decode("utf-8-sig")
        except UnicodeDecodeError:
            return data.decode("latin-1")
    except LookupError:
        raise ValueError(f"encoding must be one that Python knows, got {encoding!r}") from None
    except UnicodeDecodeError as error:
        raise ValueError(
            f"{path.name}: must be a text in {encoding or 'UTF-16'}, byte {error.start} is not"
        ) from None


def _separator(header: str, delimiter: str | None) -> str:
    """Separator that is stated, or that parts the header into most cells."""
    if delimiter is not None:
        separator = SEPARATORS.get(delimiter, delimiter)
        if separator not in SEPARATORS.values():
            allowed = ", ".join(SEPARATORS)
            raise ValueError(f"delimiter must be one of {allowed}, got {delimiter!r}")
        return separator

    def parts(mark: str) -> int:
        try:
            return len(_cells("", header, mark))
        except ValueError:  # of quotes that this one does not part
            return 0

    # Of two that part it alike the first: commas also stand in numbers and names.
    best = max((";", "\t", "|", ","), key=parts)
    return best if parts(best) > 1 else " "


def _cells(where: str, line: str, separator: str) -> list[str]:
    if separator == " ":  # any white space, but none before a unit in brackets
        words: list[str] = re.findall(r'"[^"]*"|\S+', re.sub(r"\s+(?=[(\[])", "", line))
        return [word.strip('" ') for word in words]
    try:
        row = next(csv.reader([line], delimiter=separator, skipinitialspace=True, strict=True))
    except csv.Error as error:
        raise ValueError(f"{where}: {error}") from None
    return [cell.strip() for cell in row]


def _in_memory(source: Any) -> tuple[str, list[str], list[tuple[str, list[str]]]]:
    """Name, header and rows of a data frame or a mapping of arrays."""
    try:
        arrays = {str(key): np.ravel(source[key]).tolist() for key in source}
    except (TypeError, KeyError, IndexError):
        raise TypeError(
            f"source must be a file, a data frame or a mapping of arrays, got {source!r}"
        ) from None
    lengths = {name: len(values) for name, values in arrays.items()}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise ValueError(f"data: columns must be of one length, got {listed}")
    rows = zip(*arrays.values(), strict=True)
    return "data", [*arrays], [(f"row {at}", [*map(str, row)]) for at, row in enumerate(rows)]


def _places(
    table: str,
    header: Sequence[str],
    columns: Mapping[str, Column],
    renamed: Mapping[str, str],
    options: Mapping[str, str],
) -> tuple[dict[str, int], dict[str, str]]:
    """Place of each column, and the units that the header states."""
    usual = {name: name for name in columns} | {
        alias: name for name, column in columns.items() for alias in column.names
    }
    usual = {alias: name for alias, name in usual.items() if name not in renamed}
    for name in renamed:
        if name not in columns:
            raise ValueError(
                f"columns: {name!r} is none of {', '.join(columns)}{nearest(name, columns)}"
            )
    titles = {wanted.strip(): name for name, wanted in renamed.items()}
    places: dict[str, int] = {}
    stated: dict[str, str] = {}
    for at, cell in enumerate(header):
        meaning = _meaning(table, cell, titles, usual, columns, options)
        if meaning is None:
            continue
        name, unit = meaning
        if name in places:
            raise ValueError(
                f"{table}: the column {name} stands there twice, {header[places[name]]!r} and "
                f"{cell!r}; choose by --columns {name}=NAME"
            )
        places[name] = at
        if unit:
            stated[name] = unit
    for name, wanted in renamed.items():
        if name not in places:
            raise ValueError(
                f"{table}: no column {wanted!r}{nearest(wanted, filter(None, header))}"
            )
    return places, stated


def _meaning(
    table: str,
    cell: str,
    titles: Mapping[str, str],
    usual: Mapping[str, str],
    columns: Mapping[str, Column],
    options: Mapping[str, str],
) -> tuple[str, str] | None:
    """Column that a header names, and its unit; None if it is no column that is looked for."""
    refused = ""
    whole = titles.get(cell)
    for name, tail, must in _readings(cell):
        column = whole or titles.get(name) or usual.get(_plain(name))
        if column is None:
            continue
        if not tail:
            # Many a quantity has a name of one letter: but for ours, it needs a unit.
            if whole is None and (len(name) > 1 or name in {*columns, *titles}):
                return column, ""
            continue
        unit = unit_of(tail, columns[column].units)
        if unit is not None:
            return column, unit
        if must and not (whole and columns[column].kind in options):
            allowed = ", ".join(filter(None, columns[column].units)) or "none"
            refused = f"{table}: the unit of {column} must be one of {allowed}, got {tail!r}"
    if refused:
        raise ValueError(refused)
    return (whole, "") if whole else None


def _readings(cell: str) -> Iterator[tuple[str, str, bool]]:
    """Names and the texts behind them, the longest first, and whether these must be units."""
    yield cell, "", False
    if match := _BRACKETS.fullmatch(cell):
        yield match[1], match[2].strip(), True
    for mark in reversed([*_PARTED.finditer(cell)]):
        name, tail = cell[: mark.start()], cell[mark.end() :]
        if name and tail:
            yield name, tail, mark[0].strip() in _STATED and mark[0] != "/"


def _plain(name: str) -> str:
    """Name in lower case, but for one letter: "V" is not "v", and "E" may be a modulus."""
    name = name.strip()
    return name if len(name) == 1 else re.sub(r"[\s.-]+", "_", name.lower())


def unit_of(text: str, units: Mapping[str, float]) -> str | None:
    """Return the unit that a text means, of those given; None if it is none of them."""
    plain = re.sub(r"[(){}\[\]$\\]", "", text).strip(" _.:").lower()
    for mark, letter in {"µ": "u", "μ": "u", "−": "-"}.items():
        plain = plain.replace(mark, letter)
    plain = _WORDS.get(plain, plain)
    if match := _PER_TIME.fullmatch(plain):
        plain = f"{match[1]}/{match[2][0]}"
    return plain if plain in units else None


def _option(kind: str, unit: str) -> str:
    """Unit of a kind as it is meant; raises ValueError if there is none like it."""
    known = unit_of(unit, OPTIONS[kind][1])
    if known is None:
        raise ValueError(
            f"unit of {kind} must be one of {', '.join(OPTIONS[kind][1])}, got {unit!r}"
        )
    return known


def _row_of_units(
    table: str,
    where: str,
    cells: Mapping[str, str],
    numeric: Sequence[str],
    columns: Mapping[str, Column],
) -> dict[str, str]:
    """Units in the first row, by column; empty if that is no row of units.

    Raises ValueError if it has words in all columns of numbers, of which one is no unit.
    """
    words = {name: cells[name] for name in numeric if cells[name].lower() not in MISSING}
    units = {name: unit_of(word, columns[name].units) for name, word in words.items()}
    figures = {name for name, word in words.items() if _is_number(word)}
    if figures == {*words} or any(units[name] is None for name in figures):
        return {}
    stated = {}
    for name, word in words.items():
        unit = units[name]
        if unit is None:
            allowed = ", ".join(filter(None, columns[name].units))
            raise ValueError(
                f"{table}, {where}: {name} must be a number, or one of the units {allowed}, "
                f"got {word!r}"
            )
        stated[name] = unit
    return stated


def _units(
    numeric: Sequence[str],
    columns: Mapping[str, Column],
    stated: Mapping[str, str],
    options: Mapping[str, str],
) -> tuple[dict[str, str], frozenset[str]]:
    """Unit of each column of numbers, and which of them are stated somewhere."""
    of_kind: dict[str, str] = {}
    for name, unit in stated.items():
        if unit in OPTIONS.get(columns[name].kind, ("", {}))[1]:
            of_kind.setdefault(columns[name].kind, unit)
    of_kind |= options
    units, known = {}, set()
    for name in numeric:
        column = columns[name]
        shared = stated.get(name) or of_kind.get(column.kind, "")
        usual = OPTIONS[column.kind][0] if column.kind else next(iter(column.units))
        units[name] = shared or usual
        known |= {name} if shared else set()
    return units, frozenset(known)


def _decimal(table: str, cells: Sequence[str], decimal: str | None) -> str:
    """Decimal mark of the numbers."""
    if decimal is not None:
        if decimal not in _OTHER:
            raise ValueError(f"decimal must be '.' or ',', got {decimal!r}")
        return decimal
    numbers = [cell for cell in cells if cell.lower() not in MISSING]
    commas = [cell for cell in numbers if "," in cell]
    points = [cell for cell in numbers if "." in cell]
    if commas and points:
        raise ValueError(
            f"{table}: numbers have commas ({commas[0]!r}) and points ({points[0]!r}); give "
            "--decimal"
        )
    return "," if commas else "."


def _is_number(word: str) -> bool:
    try:
        float(word.replace(",", "."))
    except ValueError:
        return False
    return True


def _number(column: str, cell: str, mark: str) -> float | None:
    """Number of a cell, None where it is missing."""
    if cell.lower() in MISSING:
        return None
    try:
        number = float(cell.translate({ord(mark): ".", ord(_OTHER[mark]): "?"}))
    except ValueError:
        number = np.nan
    if not np.isfinite(number):
        raise ValueError(f"{column} must be a number, got {cell!r}")
    return number
