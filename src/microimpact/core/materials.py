"""Materials: elastic constants and density, and the tables they are declared in."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from microimpact.core.arrays import POSITIVE, Range, Real, checked, common_shape
from microimpact.core.nearest import nearest
from microimpact.core.plausible import warn_caller
from microimpact.core.readable import Readable

# Units that declared values may be given in, with their SI factors.
PRESSURE = {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9}
DENSITY = {"kg/m3": 1.0, "g/cm3": 1e3}
LENGTH = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}
SPEED = {"m/s": 1.0, "mm/s": 1e-3}
ENERGY_PER_AREA = {"J/m2": 1.0, "mJ/m2": 1e-3}
FORCE_PER_LENGTH = {"N/m": 1.0, "mN/m": 1e-3}
SLOWNESS = {"s/m": 1.0}
NUMBER = {"-": 1.0}

POISSON_RANGE = Range(lower=-1.0, upper=0.5, upper_closed=True)

# Names are written into comments of C and of CSV: there `*/` ends a comment, and a backslash or a
# trigraph joins it to the next line; after a comma, a spreadsheet computes `=1+1`.
_UNSAFE = re.compile(r"""\*/|/\*|\\|\?\?|(?:^|[,;])[\s"']*[=+@-]""")

Row = Mapping[str, Any]
Item = TypeVar("Item")

_UNITS = {"youngs_modulus": PRESSURE, "poissons_ratio": NUMBER, "density": DENSITY}
_RANGES = {"youngs_modulus": POSITIVE, "poissons_ratio": POISSON_RANGE, "density": POSITIVE}


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Material(Readable):
    """An isotropic elastic material.

    Parameters
    ----------
    name
        One line of printable text, safe in a comment of C and in a table.
    youngs_modulus
        E, Pa.
    poissons_ratio
        nu, in (-1, 0.5].
    density
        rho, kg/m3.

    Raises
    ------
    TypeError, ValueError
        If the name is no such text, or a property is not a number (or array of numbers), not
        finite or out of range.

    Warns
    -----
    UserWarning
        If a number is hardly meant, as one in GPa.
    """

    name: str
    youngs_modulus: Real
    poissons_ratio: Real
    density: Real

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise TypeError(f"name must be text, got {self.name!r}")
        if not self.name.isprintable() or _UNSAFE.search(self.name):
            raise ValueError(
                r"name must be one line of printable text without */, /*, \, ?? or a formula, "
                f"got {self.name!r}"
            )
        for key, allowed in _RANGES.items():
            object.__setattr__(self, key, checked(key, getattr(self, key), allowed))
        common_shape({key: getattr(self, key) for key in _RANGES})
        warn_caller(self, depth=3, whose=f"{self.name}: ")


def declared_file(name: str) -> Path:
    """Return a shipped table of declared inputs: packaged, or the project's ``config`` folder."""
    package = Path(__file__).parents[1]
    packaged = package / "config" / name
    return packaged if packaged.exists() else package.parents[1] / "config" / name


def read_rows(path: Path | str, columns: Sequence[str]) -> list[dict[str, str]]:
    """Read the rows of a CSV file.

    Parameters
    ----------
    path
        The file, with a header.
    columns
        Columns that it must have, among others.

    Raises
    ------
    ValueError
        If the file is no such table, by its name and line.
    """
    rows = []
    with Path(path).open(encoding="utf-8-sig", newline="") as file:
        reader = csv.DictReader(file, strict=True)
        try:
            for row in reader:
                if None in row or None in row.values():
                    count = len(reader.fieldnames or ())
                    raise ValueError(f"{path}, line {reader.line_num}: must have {count} fields")
                rows.append(row)
            header = reader.fieldnames or ()
        except csv.Error as error:
            raise ValueError(f"{path}, line {reader.line_num + 1}: {error}") from None
        except UnicodeDecodeError as error:
            raise ValueError(
                f"{path}: must be a text in UTF-8, byte {error.start} is not"
            ) from None
    if missing := [column for column in columns if column not in header]:
        raise ValueError(
            f"{path}: the header must have {', '.join(missing)}, too; it is {', '.join(header)}"
        )
    return rows


def read_materials(path: Path | str) -> dict[str, Material]:
    """Read a table of materials, see `read_rows` and `materials_from_rows`."""
    rows = read_rows(path, ("material", "property", "value", "unit"))
    try:
        return materials_from_rows(rows)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def quantity(row: Row, units: Mapping[str, dict[str, float]], where: str) -> float:
    """Return the SI value of one declared row (keys property, value, unit).

    Parameters
    ----------
    row
        Declared row with the keys property, value and unit.
    units
        SI value of each permitted unit, by property.
    where
        What the row belongs to, for messages.

    Raises
    ------
    ValueError
        If the property is unknown, its unit another or its value no number.
    """
    name = row["property"]
    if name not in units:
        raise ValueError(f"{where}: property {name!r} unknown{nearest(name, units)}")
    where = f"{where}, {name}"
    try:
        value = float(row["value"])
    except ValueError:
        raise ValueError(f"{where}: value {row['value']!r} must be a number") from None
    if row["unit"] not in units[name]:
        raise ValueError(f"{where}: unit {row['unit']!r} must be one of {', '.join(units[name])}")
    return value * units[name][row["unit"]]


def materials_from_rows(rows: Iterable[Row]) -> dict[str, Material]:
    """Build every material of a declared table (columns material, property, value, unit, ...).

    Raises ValueError if a property is unknown, declared twice or missing, or has a wrong unit or
    value.
    """
    declared: dict[str, dict[str, float]] = {}
    for row in rows:
        properties = declared.setdefault(row["material"], {})
        where = f"material {row['material']!r}"
        if row["property"] in properties:
            raise ValueError(f"{where}: {row['property']} is declared twice")
        properties[row["property"]] = quantity(row, _UNITS, where)
    built = {}
    for name, properties in declared.items():
        missing = [key for key in _UNITS if key not in properties]
        if missing:
            raise ValueError(f"material {name!r}: {', '.join(missing)} not declared")
        try:
            built[name] = Material(name=name, **properties)
        except ValueError as problem:
            raise ValueError(f"material {name!r}: {problem}") from None
    return built


class Declared(dict[str, Item]):
    """Materials or contacts by name; one that is not declared is an error with the nearest."""

    def __init__(self, kind: str, items: Mapping[str, Item]) -> None:
        super().__init__(items)
        self.kind = kind

    def __missing__(self, name: str) -> Item:
        raise KeyError(f"unknown {self.kind} {name!r}{nearest(name, self)}")


def find_material(name: str, materials: Mapping[str, Material]) -> Material:
    """Return one material by name.

    Raises ValueError if it is not declared; the message names the nearest.
    """
    if name not in materials:
        raise ValueError(f"unknown material {name!r}{nearest(name, materials)}")
    return materials[name]
