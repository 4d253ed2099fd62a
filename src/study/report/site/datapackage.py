"""Description of a run's tables as a Data Package (frictionless), beside their copies."""

from __future__ import annotations

import json
from collections.abc import Iterable
from importlib.metadata import metadata
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

if TYPE_CHECKING:
    from study.report.site.build import Table

FILE = "files/datapackage.json"
# Ends of column names, the longest first, and their units; other columns are pure numbers or text.
UNITS = {
    "over_half_width": "1",
    "rad_per_s": "rad/s",
    "J_per_m2": "J/m2",
    "N_per_m": "N/m",
    "m_per_s": "m/s",
    "s_per_m": "s/m",
    "percent": "%",
    "counts": "1",
    "kHz": "kHz",
    "GPa": "GPa",
    "deg": "deg",
    "Pa": "Pa",
    "nm": "nm",
    "um": "um",
    "mm": "mm",
    "ns": "ns",
    "us": "us",
    "ms": "ms",
    "uN": "uN",
    "nN": "nN",
    "px": "px",
    "m": "m",
}
TYPES = {"b": "boolean", "i": "integer", "u": "integer", "f": "number"}


def datapackage(results: Path, tables: Iterable[Table]) -> str:
    """Return the content of every table, and type and unit of each of its columns."""
    about = metadata("microimpact")
    package = {
        "profile": "tabular-data-package",
        "name": "microimpact-results",
        "title": "Results of the microimpact study",
        "version": about["Version"],
        "licenses": [{"name": about["License-Expression"]}],
        "resources": [_resource(results, table) for table in tables],
    }
    return json.dumps(package, indent=1, ensure_ascii=False) + "\n"


def _resource(results: Path, table: Table) -> dict[str, object]:
    columns = pd.read_csv(results / table.file).dtypes
    return {
        "profile": "tabular-data-resource",
        "name": table.file.removesuffix(".csv").replace("/", "-").replace("_", "-"),
        "path": table.file,
        "description": table.words,
        "schema": {
            "fields": [
                {
                    "name": str(name),
                    "type": TYPES.get(kind.kind, "string"),
                    "description": title(str(name)),
                }
                | ({"unit": unit(str(name))} if kind.kind in "iuf" else {})
                for name, kind in columns.items()
            ],
            "missingValues": [""],
        },
    }


def unit(column: str) -> str:
    """Return the unit at the end of a column's name, 1 for a pure number."""
    return next((UNITS[end] for end in UNITS if f"_{column}".endswith(f"_{end}")), "1")


def title(column: str) -> str:
    """Return the name of a column in words, without its unit."""
    end = next((end for end in UNITS if column.endswith(f"_{end}")), "")
    return column.removesuffix(f"_{end}").replace("_", " ")
