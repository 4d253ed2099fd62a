"""Measured rebounds from a CSV file."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from microimpact.core.arrays import FloatArray
from microimpact.core.materials import SPEED
from microimpact.core.nearest import nearest

SPEED_UNITS = {**SPEED, "cm/s": 1e-2, "um/s": 1e-6, "km/h": 1.0 / 3.6}
COLUMNS = {
    "v": "normal speed before impact",
    "e": "coefficient of restitution",
    "V": "normal speed after impact, in place of e",
    "sigma": "standard deviation of e",
    "captured": "yes or no",
}
_YES, _NO = {"yes", "true", "1", "captured"}, {"no", "false", "0", "", "rebound"}
# "v", "v (cm/s)", "v [cm/s]" or "v_cm_per_s".
_HEADER = re.compile(r"\s*(\w+?)(?:\s*[(\[]\s*([^)\]]*?)\s*[)\]]|_([a-z]+)_per_([a-z]+))?\s*$")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rebounds:
    """Measured normal impacts."""

    v: FloatArray  # Speeds before impact (n,), m/s
    e: FloatArray  # Coefficients of restitution (n,); 0 where captured
    sigma: FloatArray | None  # Standard deviations of e (n,), or None


def read_rebounds(path: Path | str, unit: str | None = None) -> Rebounds:
    """Read a CSV file with the columns `COLUMNS`, of which v and e or V are needed.

    Parameters
    ----------
    path
        The file; lines that begin with ``#`` are comments. A captured sphere has ``captured`` yes,
        or e (or V) 0.
    unit
        Unit of the speeds, one of `SPEED_UNITS`, where the header has none; None: m/s.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        With file, line, column, value and the allowed values.
    """
    name = Path(path).name
    try:
        lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise ValueError(f"{name}: must be a text in UTF-8, byte {error.start} is not") from None
    data_lines = [(at, line) for at, line in enumerate(lines, 1) if line.strip() and line[0] != "#"]
    if not data_lines:
        raise ValueError(f"{name}: no header; columns are {', '.join(COLUMNS)}")
    table = [_cells(f"{name}, line {at}", line) for at, line in data_lines]
    if len(table[0]) == 1 and (separator := re.search(r"[;\t|]|(?<=\w) (?=\w)", data_lines[0][1])):
        raise ValueError(
            f"{name}, line {data_lines[0][0]}: the columns must be separated by commas, got "
            f"{separator[0]!r}; numbers have a decimal point"
        )
    units = _columns(name, table[0], unit)
    rows = []
    for (at, _), cells in zip(data_lines[1:], table[1:], strict=True):
        if len(cells) != len(table[0]):
            raise ValueError(
                f"{name}, line {at}: {len(cells)} cells, but {len(table[0])} columns in the header"
            )
        named = dict(zip(units, map(str.strip, cells), strict=True))
        rows.append(_row(f"{name}, line {at}", named, units))
    if not rows:
        raise ValueError(f"{name}: no data below the header")
    v, e, sigma = zip(*rows, strict=True)
    return Rebounds(
        v=np.array(v), e=np.array(e), sigma=np.array(sigma) if "sigma" in units else None
    )


def _cells(where: str, line: str) -> list[str]:
    try:
        return next(csv.reader([line], strict=True))
    except csv.Error as error:
        raise ValueError(f"{where}: {error}") from None


def _columns(name: str, header: list[str], unit: str | None) -> dict[str, float]:
    """Factors from the units of the columns to SI."""
    if unit is not None and unit not in SPEED_UNITS:
        raise ValueError(f"unit must be one of {', '.join(SPEED_UNITS)}, got {unit!r}")
    factors: dict[str, float] = {}
    for cell in header:
        match = _HEADER.match(cell)
        column = match[1] if match else cell
        if match is None or column not in COLUMNS:
            raise ValueError(
                f"{name}: the column {cell.strip()!r} is none of {', '.join(COLUMNS)}"
                f"{nearest(column, COLUMNS)}"
            )
        if column in factors:
            raise ValueError(f"{name}: the column {column} stands there twice")
        written = f"{match[3]}/{match[4]}" if match[3] else match[2]
        if column in {"v", "V"}:
            written = written or unit or "m/s"
            if written not in SPEED_UNITS:
                raise ValueError(
                    f"{name}: the unit of {column} must be one of {', '.join(SPEED_UNITS)}, "
                    f"got {written!r}"
                )
            factors[column] = SPEED_UNITS[written]
        elif written not in {None, "", "1", "-"}:
            raise ValueError(f"{name}: {column} has no unit, got {written!r}; give fractions")
        else:
            factors[column] = 1.0
    if "v" not in factors or ("e" in factors) == ("V" in factors):
        got = ", ".join(factors)
        raise ValueError(f"{name}: the columns v and either e or V are needed, got {got}")
    return factors


def _row(where: str, cells: dict[str, str], units: dict[str, float]) -> tuple[float, float, float]:
    """Parse v in m/s, e and sigma of a row."""
    said = cells.get("captured", "").lower()
    if said not in _YES | _NO:
        raise ValueError(f"{where}: captured must be yes or no, got {cells['captured']!r}")
    v = _number(where, "v", cells["v"]) * units["v"]
    if v <= 0.0:
        raise ValueError(f"{where}: v must be positive, got {cells['v']}")
    captured = said in _YES
    after = "e" if "e" in cells else "V"
    e = 0.0 if captured and not cells[after] else _number(where, after, cells[after])
    if after == "V":
        e = abs(e) * units["V"] / v
    if captured and e > 0.0:
        raise ValueError(f"{where}: captured, but {after} is {cells[after]}; it must be 0 or empty")
    if not 0.0 <= e <= 1.0:
        percent = "; divide percent by 100" if after == "e" and 1.0 < e <= 100.0 else ""
        got = cells[after] if after == "e" else f"V/v = {e:.3g}"
        raise ValueError(f"{where}: e must be from 0 to 1, got {got}{percent}")
    sigma = _number(where, "sigma", cells["sigma"]) if "sigma" in cells else 0.5
    if not 0.0 < sigma < 1.0:
        raise ValueError(f"{where}: sigma must be above 0 and below 1, got {cells['sigma']}")
    return v, e, sigma


def _number(where: str, column: str, cell: str) -> float:
    try:
        number = float(cell)
    except ValueError:
        number = np.nan
    if not np.isfinite(number):
        raise ValueError(f"{where}: {column} must be a number, got {cell!r}")
    return number
