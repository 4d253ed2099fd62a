"""Finished results on disk, as they are compared: tables as text, figures, the run stamp."""

from __future__ import annotations

import gzip
import io
import json
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import ValidationError

from study.declared.parameters import build, explain
from study.tables import require_whole_rows

if TYPE_CHECKING:
    import pandas as pd

T = TypeVar("T")

# Folders with tables; those of figures tell what each figure shows.
TABLE_FOLDERS = ("tables", "data", "figures")
INPUTS = "tables/inputs.csv"
CLAIMS = "tables/claims.csv"

# Columns that name a row of a table, or of those in a folder; else all columns of text do.
KEYS = {
    INPUTS: ("file", "key"),
    CLAIMS: ("id",),
    "tables/claim_results.csv": ("id", "case", "quantity", "test"),
    "tables/equations.csv": ("equation",),
    "data/": ("panel", "series", "evidence"),
    "figures/": ("panel", "artist"),
}


class ResultsError(ValueError):
    """Results that cannot be compared: not there, or not of the agreed form."""


def require_results(root: Path) -> None:
    """Raise ResultsError, naming the folder, if it is missing or no run has written it."""
    if not root.is_dir():
        raise ResultsError(f"{root}: no such folder")
    if not table_files(root) and not figure_files(root):
        folders = ", ".join(f"{name}/" for name in TABLE_FOLDERS)
        raise ResultsError(f"{root}: not a results folder: no files in {folders}")


def table_files(root: Path) -> dict[str, Path]:
    """Return the tables below a root by name (``data/fig14.csv``), declared inputs first.

    A table may be compressed, then its file ends in ``.csv.gz``.
    """
    tables = {
        f"{folder}/{path.name.removesuffix('.gz')}": path
        for folder in TABLE_FOLDERS
        for path in sorted((root / folder).glob("[!.]*.csv*"))
        if path.suffix in {".csv", ".gz"}
    }
    return {name: tables[name] for name in sorted(tables, key=INPUTS.__ne__)}


def figure_files(root: Path) -> dict[str, Path]:
    """Return the SVG files of all figures below a root by the figure's name."""
    return {path.stem: path for path in sorted((root / "figures").glob("[!.]*.svg"))}


def read_cells(path: Path) -> pd.DataFrame:
    """Read a CSV table as text, every cell as in the file.

    Raises TableError, naming the file and the line that is malformed.
    """
    import pandas as pd

    text = read_text(path)
    require_whole_rows(text, str(path))
    return pd.read_csv(
        io.StringIO(text), dtype=object, keep_default_na=False, skip_blank_lines=False
    )


def read_text(path: Path) -> str:
    """Read a text file, compressed or not.

    Raises ResultsError if it is missing, broken or no text.
    """
    try:
        raw = path.read_bytes()
        return (gzip.decompress(raw) if path.suffix == ".gz" else raw).decode("utf-8")
    except (OSError, EOFError, zlib.error, UnicodeDecodeError) as error:
        raise ResultsError(f"{path}: cannot be read: {error}") from None


def read_json(path: Path) -> dict[str, Any]:
    """Read a JSON object.

    Raises ResultsError, naming the file, and the line that is malformed.
    """
    try:
        content = json.loads(read_text(path))
    except json.JSONDecodeError as error:
        raise ResultsError(f"{path}, line {error.lineno}: {error.msg}") from None
    if not isinstance(content, dict):
        raise ResultsError(f"{path}: must hold a JSON object")
    return content


def built(kind: type[T], content: Mapping[str, Any], where: str) -> T:
    """Return a dataclass from plain values.

    Raises ResultsError: one line per problem, with the place and the dotted key.
    """
    try:
        return build(kind, content)
    except ValidationError as error:
        lines = explain(error, kind, "")
        raise ResultsError("\n".join(f"{where}: {line}" for line in lines)) from None
