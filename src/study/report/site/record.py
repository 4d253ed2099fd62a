"""Record of a run for its site, beyond its tables and figures: registry, versions, commit.

The workflow writes it to ``report/record.json``, so that the site of a finished run can be made
again without the workflow engine.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from microimpact.core.files import write_file
from study.report.check.results import built, read_json
from study.run.stamp import Change, changes, origin

RECORD = "report/record.json"
# Columns that name a row of a declared table.
_ROW_NAMES = ("material", "particle", "surface", "key", "name")


@dataclass(frozen=True, slots=True, kw_only=True)
class Record:
    """Stamp and registry of a run, as its site shows them."""

    # As in the run stamp.
    seed: int
    git: Mapping[str, str | bool | None]
    python: str
    platform: str
    packages: Mapping[str, str | None]
    changes: tuple[Change, ...]  # Where the configuration differs from the shipped one
    impact: str  # What is dropped on what, in words
    figures: Mapping[str, Mapping[str, Any]]  # The registry, words filled in
    rows: Mapping[str, Mapping[str, tuple[str, ...]]]  # Declared, by study and table: names

    def plain(self) -> dict[str, Any]:
        """Return the record as JSON would hold it."""
        content: dict[str, Any] = json.loads(json.dumps(asdict(self)))
        return content


def record_of(
    *,
    config: Mapping[str, Any],
    shipped: Mapping[str, Any],
    impact: str,
    figures: Mapping[str, Mapping[str, Any]],
    rows: Mapping[str, Mapping[str, str]],
    project: Path,
) -> Record:
    """Return the record of a run that is being made.

    Parameters
    ----------
    config, shipped
        The merged configuration, and the one that the project comes with.
    impact
        What is dropped on what, in words.
    figures
        The registry, words filled in.
    rows
        Declared rows that each study is given, as CSV by table.
    project
        Root of the project, whose commit is recorded.
    """
    return Record(
        **origin(config, project),
        changes=changes(config, shipped),
        impact=impact,
        figures=figures,
        rows={study: row_names(tables) for study, tables in rows.items()},
    )


def row_names(rows: Mapping[str, str]) -> dict[str, tuple[str, ...]]:
    """Return which rows of each declared table a study is given, from the tables as CSV.

    A material, a printed value and a source have their name, a contact ``particle on surface``.
    """
    names = {}
    for table, text in rows.items():
        rows_of_table = csv.DictReader(io.StringIO(text))
        keys = [column for column in _ROW_NAMES if column in (rows_of_table.fieldnames or ())]
        named = (" on ".join(row[key] for key in keys) for row in rows_of_table)
        names[table] = tuple(dict.fromkeys(named))
    return names


def write_record(results: Path, plain: Mapping[str, Any]) -> None:
    """Write ``report/record.json``, see `Record.plain`."""
    text = json.dumps(plain, indent=1, ensure_ascii=False, sort_keys=True)
    write_file(results / RECORD, text + "\n")


def read_record(results: Path) -> Record:
    """Return the record of a run.

    Raises ResultsError if the folder has none, or one with a key that is missing, unknown or of
    another kind.
    """
    return built(Record, read_json(results / RECORD), str(results / RECORD))
