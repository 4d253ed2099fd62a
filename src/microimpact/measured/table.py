"""Tables of numbers with units, from text files as laboratories write them, or from memory.

What stands behind the name of a column is understood as its unit, or refused. Speeds, and sizes,
without a unit of their own are in that of the option, else in that which the first column of their
kind states, else in SI units.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.materials import LENGTH, SPEED
from microimpact.core.nearest import nearest

SPEED_UNITS = {**SPEED, "cm/s": 1e-2, "um/s": 1e-6, "km/h": 1.0 / 3.6}
SIZE_UNITS = {**LENGTH, "cm": 1e-2}
SHARE_UNITS = {"": 1.0, "1": 1.0, "-": 1.0, "%": 1e-2}
ANGLE_UNITS = {"deg": 1.0, "rad": 180.0 / np.pi}
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
# Pixels are told from metres by the unit.
PLACE_UNITS = {"px": 1.0, **SIZE_UNITS}
# Kinds of columns whose unit may be that of another one, or of an option.
SPEEDS, SIZES, PLACES = "speeds", "sizes", "places"
OPTIONS = {SPEEDS: ("m/s", SPEED_UNITS), SIZES: ("m", SIZE_UNITS), PLACES: ("px", PLACE_UNITS)}
# Lines above the numbers that may be the header, and others that repeat it.
HEADERS = 4

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
_WORDS |= {"pixel": "px", "pixels": "px", "sec": "s", "seconds": "s", "msec": "ms"}
_PER_TIME = re.compile(
    r"([cmku]?m)(?:[\s_.·*/]*|[\s_]*per[\s_]*|p)(s|sec|h)\s*(?:\^?-1|⁻¹|\*\*-1)?"
)
_BRACKETS = re.compile(r"(.+?)[\s_/]*[(\[]([^()\[\]]*|\([^()]*\))[)\]]")
# What may part a name from its unit; behind the stated ones nothing but a unit may stand.
_PARTED = re.compile(r"\s*:\s*|\s+(?:in|/)\s+|[\s_,/]+")
_STATED = {":", "in", "/"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """A column of numbers, or of words.

    Attributes
    ----------
    units
        Factors to SI; none for words.
    names
        Usual names beside its own, in lower case; those of one letter as they are.
    letters
        Names of one letter that need no unit.
    kind
        `SPEEDS` or `SIZES`, whose unit may stand elsewhere.
    """

    units: Mapping[str, float] = field(default_factory=dict)
    names: tuple[str, ...] = ()
    letters: tuple[str, ...] = ()
    kind: str = ""


@dataclass(frozen=True, slots=True)
class Table:
    """Rows by their columns.

    Attributes
    ----------
    name
        Of the file.
    where
        Places of the rows (n,).
    cells, numbers
        Columns as they are written, and as numbers in SI units, nan where there is none, (n,).
    units
        Unit of each column of numbers.
    stated
        Columns whose unit was given, by the header, a row of units, an option or a neighbour.
    ignored
        Headers of columns that are not used.
    bad
        Complaint of each bad row, by its number.
    """

    name: str
    where: Sequence[str]
    cells: Mapping[str, Sequence[str]]
    numbers: Mapping[str, FloatArray]
    units: Mapping[str, str]
    stated: frozenset[str]
    ignored: Sequence[str]
    bad: dict[int, str]

    @property
    def unused(self) -> tuple[str, ...]:
        """Note on the columns that are not used, if any."""
        names = ", ".join(map(repr, self.ignored))
        return (f"{self.name}: columns not used: {names}",) if names else ()

    def require(
        self, column: str, good: BoolArray, allowed: str, got: Sequence[str] | None = None
    ) -> None:
        """Take rows for bad whose number is there and not good.

        Parameters
        ----------
        column
            The column.
        good
            Whether the number is (n,).
        allowed
            Words for what is.
        got
            Words for the numbers (n,); None: the cells.
        """
        words = got or self.cells[column]
        for i in np.flatnonzero(~good & np.isfinite(self.numbers[column])).tolist():
            self.bad.setdefault(i, f"{column} must be {allowed}, got {words[i]}")

    def kept(self, lacking: BoolArray, *, skip_bad_rows: bool) -> tuple[BoolArray, list[str]]:
        """Return the rows to be used (n,), and notes on the others.

        Parameters
        ----------
        lacking
            Rows that lack a number (n,).
        skip_bad_rows
            Whether bad rows are left out.

        Raises
        ------
        ValueError
            Naming all bad rows, or that none is left.
        """
        numbers = sorted(self.bad)
        complaints = [f"{self.where[i]}: {self.bad[i]}" for i in numbers]
        wrong, notes = f"{self.name}, {_listed(complaints, '; ')}", []
        if numbers and not skip_bad_rows:
            many = f"; {len(numbers)} bad rows" if len(numbers) > 1 else ""
            raise ValueError(f"{wrong}{many}; --skip-bad-rows leaves them out")
        if numbers:
            notes.append(f"bad rows are left out: {wrong}")
        good = np.ones(len(self.where), bool)
        good[numbers] = False
        skipped = [self.where[i] for i in np.flatnonzero(good & lacking).tolist()]
        if skipped:
            notes.append(
                f"{self.name}: {len(skipped)} of {good.size} rows lack a number and are skipped: "
                f"{_listed(skipped, ', ')}"
            )
        if not np.any(good & ~lacking):
            raise ValueError("; ".join([f"{self.name}: no data below the header", *notes]))
        return good & ~lacking, notes


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
) -> Table:
    """Read a text file, a data frame, or a mapping of arrays.

    Parameters
    ----------
    source
        The file or the table. Lines that begin with ``#`` or ``%`` are comments. A title may stand
        above the header; the rows below it may repeat it, or hold the units.
    wanted
        Columns that are looked for, by their names.
    units
        Units by kind where the header has none; None: not given.
    columns
        Headers in the source by the names of columns.
    delimiter, decimal
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
        name, header, rows = _file(Path(source), delimiter, wanted, columns or {})
    else:
        name, header, rows = _in_memory(source)
        decimal = "."
    places, stated = _places(name, header, wanted, columns or {}, options)
    width = max((at for at, cell in enumerate(header, 1) if cell), default=0)
    numeric = [column for column in places if wanted[column].units]
    while len(rows) > 1 and _repeats(rows[0][1], {k: places[k] for k in numeric}, wanted):
        rows = rows[1:]
    first = {column: rows[0][1][at] for column, at in places.items() if at < len(rows[0][1])}
    if below := _row_of_units(f"{name}, {rows[0][0]}", first, numeric, wanted):
        if twice := [each for each in below if stated.get(each, below[each]) != below[each]]:
            raise ValueError(f"{name}: the units of {', '.join(twice)} must be the same twice")
        stated |= below
        rows = rows[1:]
    bad = {
        i: f"{len(cells)} cells, but {len(header)} columns in the header"
        for i, (_, cells) in enumerate(rows)
        # Spreadsheets end lines with separators of empty columns.
        if len(cells) < width or any(cells[len(header) :])
    }
    texts = {
        column: ["" if i in bad else cells[at] for i, (_, cells) in enumerate(rows)]
        for column, at in places.items()
    }
    mark = _decimal(name, [cell for column in numeric for cell in texts[column]], decimal)
    units_of, known = _units(numeric, wanted, stated, options)
    numbers = {column: np.full(len(rows), np.nan) for column in numeric}
    for column, values in numbers.items():
        for i, cell in enumerate(texts[column]):
            try:
                values[i] = wanted[column].units[units_of[column]] * _number(cell, mark)
            except ValueError:
                bad.setdefault(i, f"{column} must be a number, got {cell!r}")
    ignored = [cell for at, cell in enumerate(header) if cell and at not in places.values()]
    where = [place for place, _ in rows]
    return Table(name, where, texts, numbers, units_of, known, ignored, bad)


def _file(
    path: Path, delimiter: str | None, wanted: Mapping[str, Column], renamed: Mapping[str, str]
) -> tuple[str, list[str], list[tuple[str, list[str]]]]:
    """Name, header, and rows with their places, of a text file."""
    lines = [
        (f"line {at}", line)
        for at, line in enumerate(_text(path).splitlines(), 1)
        if line.strip() and not line.lstrip().startswith(COMMENTS)
    ]
    if len(lines) < 2:
        what = "data below the header" if lines else "header"
        raise ValueError(f"{path.name}: no {what}")
    names = {*renamed.values(), *wanted}.union(*(of.names + of.letters for of in wanted.values()))

    def named(at: int) -> int:
        """How many columns a line names."""
        try:
            cells = _cells("", lines[at][1], _separator(lines[at][1], delimiter))
        except ValueError:
            return 0
        return sum(any({name, _plain(name)} & names for name, *_ in _readings(c)) for c in cells)

    title = max(range(min(HEADERS, len(lines) - 1)), key=named)
    separator = _separator(lines[title][1], delimiter)
    header, *rows = [
        (where, _cells(f"{path.name}, {where}", line, separator)) for where, line in lines[title:]
    ]
    return path.name, header[1], rows


def _repeats(
    cells: Sequence[str], places: Mapping[str, int], columns: Mapping[str, Column]
) -> bool:
    """Tell whether a row has the names of its columns in place of numbers."""
    words = {k: cells[at] for k, at in places.items() if at < len(cells)}
    words = {k: word for k, word in words.items() if word.lower() not in MISSING}
    return bool(words) and all(
        _plain(word) in {k, *columns[k].names, *columns[k].letters} for k, word in words.items()
    )


def _text(path: Path) -> str:
    data = path.read_bytes()
    if data.startswith(b"PK\x03\x04"):
        raise ValueError(f"{path.name}: must be a text, got a workbook or archive; save it as CSV")
    wide = data.startswith((b"\xff\xfe", b"\xfe\xff"))
    try:
        return data.decode("utf-16" if wide else "utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


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
    if not any(lengths.values()):
        raise ValueError("data: no rows")
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
    usual = {
        alias: name
        for name, column in columns.items()
        for alias in (name, *column.names, *column.letters)
        if name not in renamed
    }
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
            letters = {*columns, *titles, *columns[column].letters}
            if whole is None and (len(name) > 1 or name in letters):
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
    if plain not in units and (match := _PER_TIME.fullmatch(plain)):
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
    where: str, cells: Mapping[str, str], numeric: Sequence[str], columns: Mapping[str, Column]
) -> dict[str, str]:
    """Units in the first row, by column; empty if that is no row of units.

    Raises ValueError if it has words in all columns of numbers, of which one is no unit.
    """
    words = {name: cells[name] for name in numeric if cells.get(name, "").lower() not in MISSING}
    units = {name: unit_of(word, columns[name].units) for name, word in words.items()}
    figures = {name for name, word in words.items() if re.match(r"[-+.,]*\d", word)}
    if figures == {*words} or any(units[name] is None for name in figures):
        return {}
    for name, unit in units.items():
        if unit is None:
            allowed = ", ".join(filter(None, columns[name].units))
            raise ValueError(
                f"{where}: {name} must be a number, or one of the units {allowed}, got "
                f"{words[name]!r}"
            )
    return {name: unit for name, unit in units.items() if unit}


def _units(
    numeric: Sequence[str],
    columns: Mapping[str, Column],
    stated: Mapping[str, str],
    options: Mapping[str, str],
) -> tuple[dict[str, str], frozenset[str]]:
    """Unit of each column of numbers, and which of them are stated somewhere."""
    first: dict[str, str] = {}
    units, known = {}, set()
    for name in (name for name in columns if name in numeric):
        kind = columns[name].kind
        unit = stated.get(name) or options.get(kind) or first.get(kind, "")
        first.setdefault(kind, unit if kind else "")
        known |= {name} if unit else set()
        units[name] = unit or (OPTIONS[kind][0] if kind else next(iter(columns[name].units)))
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


def _number(cell: str, mark: str) -> float:
    """Number of a cell, nan where it is missing; raises ValueError if it is no finite one."""
    if cell.lower() in MISSING:
        return np.nan
    number = float(cell.translate({ord(mark): ".", ord(_OTHER[mark]): "?", ord("_"): "?"}))
    if not np.isfinite(number):
        raise ValueError(cell)
    return number
