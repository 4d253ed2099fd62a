"""Measured rebounds from text files as laboratories write them, and from tables in memory."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from microimpact.core.arrays import FloatArray
from microimpact.core.materials import LENGTH, SPEED
from microimpact.core.nearest import nearest

SPEED_UNITS = {**SPEED, "cm/s": 1e-2, "um/s": 1e-6, "km/h": 1.0 / 3.6}
SHARE_UNITS = {"": 1.0, "1": 1.0, "-": 1.0, "%": 1e-2}
ANGLE_UNITS = dict.fromkeys(("", "deg", "degree", "degrees", "°"), 1.0) | {"rad": 180.0 / np.pi}
COLUMNS = {
    "v": "normal speed before impact",
    "e": "coefficient of restitution",
    "V": "normal speed after impact, in place of e",
    "sigma": "standard deviation of e",
    "sigma_v": "standard deviation of v, or in % of v",
    "d": "diameter of the sphere",
    "sigma_d": "standard deviation of d, or in %",
    "captured": "yes or no",
    "angle": "of incidence, degrees from the surface: v is then the total speed",
}
UNITS = {
    **dict.fromkeys(("v", "V"), SPEED_UNITS),
    **dict.fromkeys(("e", "sigma"), SHARE_UNITS),
    "sigma_v": SPEED_UNITS,
    **dict.fromkeys(("d", "sigma_d"), LENGTH),
    **dict.fromkeys(("sigma_v in %", "sigma_d in %"), SHARE_UNITS),
    "angle": ANGLE_UNITS,
    "captured": {"": 1.0},
}
# Columns that may be in % of another; they are then called so: "sigma_v in %".
OF = {"sigma_v": "v", "sigma_d": "d"}
_YES, _NO = {"yes", "true", "1", "captured"}, {"no", "false", "0", "", "rebound"}
# Cells without a number, as people and programs write them.
MISSING = {"", "-", "--", "n.d.", "nd", "n/a", "na", "<na>", "nan", "nat", "none", "null"}
MISSING |= {"#n/a", "#nv", "k.a."}
SEPARATORS = {"comma": ",", "semicolon": ";", "tab": "\t", "bar": "|", "space": " "}
COMMENTS = ("#", "%")
_OTHER = {".": ",", ",": "."}
# "v", "v (cm/s)", "v [cm/s]", "v in cm/s", "v / cm/s" or "v_cm_per_s".
_HEADER = re.compile(
    r"(.+?)\s*(?:[(\[]\s*([^()\[\]]*?)\s*[)\]]|\s(?:in|/)\s+(\S.*)|_([a-z]+)_per_([a-z]+))?"
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rebounds:
    """Measured normal impacts."""

    v: FloatArray  # Normal speeds before impact (n,), m/s
    e: FloatArray  # Coefficients of restitution (n,); 0 where captured
    sigma: FloatArray | None  # Standard deviations of e (n,), or None
    sigma_v: FloatArray | None = None  # Those of v (n,), m/s
    d: FloatArray | None = None  # Diameters (n,), m
    # Relative standard deviations of the diameters (n,); "free": one for all, to be found.
    size_scatter: FloatArray | Literal["free"] | None = None
    notes: tuple[str, ...] = ()  # What was left out of the file, a sentence each


@dataclass(frozen=True, slots=True)
class _Table:
    """Cells as text, and names of the table and its rows for messages."""

    name: str
    header: Sequence[str]
    rows: Sequence[tuple[str, Sequence[str]]]  # where, cells


def read_rebounds(
    source: Path | str | Mapping[str, Any],
    unit: str | None = None,
    *,
    columns: Mapping[str, str] | None = None,
    delimiter: str | None = None,
    decimal: str | None = None,
    encoding: str | None = None,
) -> Rebounds:
    """Read measured rebounds: a text file, a data frame, or a mapping of arrays.

    Parameters
    ----------
    source
        The file, or the table, with the columns `COLUMNS`, of which v and e or V are needed; others
        are left out. Lines that begin with ``#`` or ``%`` are comments, rows without their numbers
        are skipped; ``notes`` says so. A captured sphere has ``captured`` yes, or e (or V) 0.
    unit
        Unit of the speeds, one of `SPEED_UNITS`, where the header has none; None: m/s.
    columns
        Headers in the file by the names of `COLUMNS`: ``{"v": "Impact speed [cm/s]"}``.
    delimiter
        Between cells, a character or a name of `SEPARATORS`; None: the one that parts the header
        into most cells.
    decimal
        ``"."`` or ``","``; None: as the numbers are written.
    encoding
        Of the file; None: UTF-8, and Latin-1 where it is not.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        With file, line, column, value and the allowed values.
    """
    if isinstance(source, str | Path):
        table = _file(Path(source), delimiter, encoding)
    else:
        table = _in_memory(source)
        decimal = "."
    places, factors = _columns(table, unit, columns or {})
    if "sigma_d" in places and "d" not in places:
        raise ValueError(f"{table.name}: sigma_d needs the column d, or is in %: 'sigma_d (%)'")
    used = set(places.values())
    ignored = [cell for at, cell in enumerate(table.header) if at not in used and cell]
    named = [
        (where, {column: cells[at] for column, at in places.items()}) for where, cells in table.rows
    ]
    mark = _decimal(table.name, named, decimal)
    rows, skipped = [], []
    for where, cells in named:
        if _lacks_numbers(cells):
            skipped.append(where.rpartition(", ")[2])
        else:
            rows.append(_row(where, cells, factors, mark))
    if not rows:
        raise ValueError(f"{table.name}: no data below the header")
    notes = []
    if ignored:
        notes.append(f"{table.name}: columns not used: {', '.join(map(repr, ignored))}")
    if skipped:
        notes.append(
            f"{table.name}: {len(skipped)} of {len(named)} rows lack a number and are skipped: "
            f"{', '.join(skipped[:10])}{' ...' if len(skipped) > 10 else ''}; a captured sphere "
            "is e = 0 or captured = yes"
        )
    arrays = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    sigma = arrays.pop("sigma", None)
    return Rebounds(**arrays, sigma=sigma, notes=tuple(notes))


def _file(path: Path, delimiter: str | None, encoding: str | None) -> _Table:
    """Cells of a text file."""
    name = path.name
    lines = [
        (f"{name}, line {at}", line)
        for at, line in enumerate(_text(path, encoding).splitlines(), 1)
        if line.strip() and not line.lstrip().startswith(COMMENTS)
    ]
    if not lines:
        raise ValueError(f"{name}: no header; columns are {', '.join(COLUMNS)}")
    separator = _separator(*lines[0], delimiter)
    header, *rows = [(where, _cells(where, line, separator)) for where, line in lines]
    # Spreadsheets end lines with separators of empty columns.
    width = max((at for at, cell in enumerate(header[1], 1) if cell), default=0)
    for where, cells in rows:
        if len(cells) < width or any(cells[len(header[1]) :]):
            raise ValueError(
                f"{where}: {len(cells)} cells, but {len(header[1])} columns in the header"
            )
    return _Table(name, header[1], rows)


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


def _separator(where: str, header: str, delimiter: str | None) -> str:
    if delimiter is not None:
        separator = SEPARATORS.get(delimiter, delimiter)
        if separator not in SEPARATORS.values():
            allowed = ", ".join(SEPARATORS)
            raise ValueError(f"delimiter must be one of {allowed}, got {delimiter!r}")
        return separator
    # Of two that part it alike the first: commas also stand in numbers and names.
    best = max((";", "\t", "|", ","), key=lambda mark: len(_cells(where, header, mark)))
    return best if len(_cells(where, header, best)) > 1 else " "


def _cells(where: str, line: str, separator: str) -> list[str]:
    if separator == " ":  # any white space, but none before a unit in brackets
        return re.sub(r"\s+(?=[(\[])", "", line).split()
    try:
        row = next(csv.reader([line], delimiter=separator, skipinitialspace=True, strict=True))
    except csv.Error as error:
        raise ValueError(f"{where}: {error}") from None
    return [cell.strip() for cell in row]


def _in_memory(source: Any) -> _Table:
    """Cells of a data frame or a mapping of arrays."""
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
    return _Table(
        "data", list(arrays), [(f"data, row {at}", [*map(str, row)]) for at, row in enumerate(rows)]
    )


def _columns(
    table: _Table, unit: str | None, renamed: Mapping[str, str]
) -> tuple[dict[str, int], dict[str, float]]:
    """Place of each column in the table, and its factor to SI."""
    if unit is not None and unit not in SPEED_UNITS:
        raise ValueError(f"unit must be one of {', '.join(SPEED_UNITS)}, got {unit!r}")
    for column, header in renamed.items():
        if column not in COLUMNS:
            allowed = ", ".join(COLUMNS)
            raise ValueError(f"columns: {column!r} is none of {allowed}{nearest(column, COLUMNS)}")
        if not any(header in {cell, _split(cell)[0]} for cell in table.header):
            raise ValueError(
                f"{table.name}: no column {header!r}{nearest(header, filter(None, table.header))}"
            )
    places: dict[str, int] = {}
    factors: dict[str, float] = {}
    for at, cell in enumerate(table.header):
        name, written = _split(cell)
        chosen = [column for column, header in renamed.items() if header in {cell, name}]
        # "Sigma" is sigma, but "V" is not "v", and "E" may be a modulus.
        plain = name if name in COLUMNS or len(name) == 1 else name.lower()
        if not chosen and (plain not in COLUMNS or plain in renamed):
            continue
        for column in chosen or [plain]:
            if column in places:
                raise ValueError(f"{table.name}: the column {column} stands there twice")
            key = f"{column} in %" if column in OF and written == "%" else column
            places[key], factors[key] = at, _factor(table.name, key, written, unit)
    if "v" not in factors or ("e" in factors) == ("V" in factors):
        raise ValueError(
            f"{table.name}: the columns v and either e or V are needed, got "
            f"{', '.join(map(repr, table.header))}; other names go by "
            "--columns v=NAME,e=NAME"
        )
    return places, factors


def _split(header: str) -> tuple[str, str]:
    """Name and unit of a header; the unit is empty where it has none."""
    match = _HEADER.fullmatch(header.strip())
    if match is None:
        return header, ""
    name, bracketed, written, above, below = match.groups()
    unit = f"{above}/{below}" if above else (bracketed or written or "")
    unit = unit.strip("()[] ").replace("µ", "u").replace("μ", "u")
    return name, re.sub(r"(\w+)[ ·*]?s(?:\^?-1|⁻¹)", r"\1/s", unit)


def _factor(name: str, column: str, written: str, unit: str | None) -> float:
    allowed = UNITS[column]
    if allowed is SPEED_UNITS:
        written = written or unit or "m/s"
    if written not in allowed:
        units = ", ".join(filter(None, allowed)) or "none"
        raise ValueError(f"{name}: the unit of {column} must be one of {units}, got {written!r}")
    return allowed[written]


def _decimal(name: str, rows: Iterable[tuple[str, Mapping[str, str]]], decimal: str | None) -> str:
    """Decimal mark of the numbers."""
    if decimal is not None:
        if decimal not in {".", ","}:
            raise ValueError(f"decimal must be '.' or ',', got {decimal!r}")
        return decimal
    numbers = [
        cell
        for _, cells in rows
        for column, cell in cells.items()
        if column != "captured" and cell.lower() not in MISSING
    ]
    commas = [cell for cell in numbers if "," in cell]
    points = [cell for cell in numbers if "." in cell]
    if commas and points:
        raise ValueError(
            f"{name}: numbers have commas ({commas[0]!r}) and points ({points[0]!r}); give "
            "--decimal"
        )
    return "," if commas else "."


def _lacks_numbers(cells: Mapping[str, str]) -> bool:
    """Whether a number is missing, other than e of a captured sphere."""
    captured = cells.get("captured", "").lower() in _YES
    return any(
        cell.lower() in MISSING
        for column, cell in cells.items()
        if column != "captured" and not (captured and column in {"e", "V"})
    )


def _row(
    where: str, cells: Mapping[str, str], factors: Mapping[str, float], mark: str
) -> dict[str, float]:
    """Parse the numbers of a row that `Rebounds` has, in SI units."""

    def value(column: str) -> float:
        return factors[column] * _number(where, column, cells[column], mark)

    said = cells.get("captured", "").lower()
    if said not in _YES | _NO | MISSING:
        raise ValueError(f"{where}: captured must be yes or no, got {cells['captured']!r}")
    v = total = value("v")
    if v <= 0.0:
        raise ValueError(f"{where}: v must be positive, got {cells['v']}")
    if "angle" in cells:
        angle = value("angle")
        if not 0.0 < angle <= 90.0:
            raise ValueError(
                f"{where}: angle must be above 0 and at most 90 degrees, got {cells['angle']}"
            )
        v *= np.sin(np.radians(angle))
    captured = said in _YES
    after = "e" if "e" in cells else "V"
    e = 0.0 if captured and cells[after].lower() in MISSING else value(after)
    if after == "V":
        e = abs(e) / v
    if captured and e > 0.0:
        raise ValueError(f"{where}: captured, but {after} is {cells[after]}; it must be 0 or empty")
    if not 0.0 <= e <= 1.0:
        percent = "; are these percent? Then the header is 'e (%)'" if 2.0 < e <= 100.0 else ""
        got = cells[after] + percent if after == "e" else f"V/v = {e:.3g}"
        raise ValueError(f"{where}: e must be from 0 to 1, got {got}")
    return {"v": v, "e": e} | _spreads(where, cells, value, v, v / total)


def _spreads(
    where: str,
    cells: Mapping[str, str],
    value: Callable[[str], float],
    v: float,
    normal: float,
) -> dict[str, float]:
    """Parse sigma, sigma_v and the diameter of a row, of which v is the normal speed.

    ``normal`` is the share of that in the speed as it stands.
    """
    numbers = {name: value(name) for name in ("sigma", "d") if name in cells}
    for name, below in (("sigma", 1.0), ("d", np.inf)):
        if not 0.0 < numbers.get(name, 0.5) < below:
            least = "positive" if name == "d" else "above 0 and below 1"
            raise ValueError(f"{where}: {name} must be {least}, got {cells[name]}")
    wholes = {"sigma_v": v / normal, "sigma_d": numbers.get("d", 1.0)}
    for column in cells:
        name = column.removesuffix(" in %")
        if name in wholes:
            relative = value(column) / (wholes[name] if column == name else 1.0)
            if not 0.0 <= relative < 0.5:
                raise ValueError(
                    f"{where}: {name} must be from 0 to half of {OF[name]}, got {cells[column]}"
                )
            key, unit = ("sigma_v", v) if name == "sigma_v" else ("size_scatter", 1.0)
            numbers[key] = unit * relative
    return numbers


def _number(where: str, column: str, cell: str, mark: str) -> float:
    try:
        number = float(cell.translate({ord(mark): ".", ord(_OTHER[mark]): "?"}))
    except ValueError:
        number = np.nan
    if not np.isfinite(number):
        raise ValueError(f"{where}: {column} must be a number, got {cell!r}")
    return number
