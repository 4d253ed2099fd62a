"""Check of results against committed references, and the explicit renewal of these.

A folder of references holds ``tables/``, ``data/`` and ``figures/`` (see `figures.content`), all
CSV, and ``tolerances.yaml``. Nothing is thinned: every number is compared.
"""

from __future__ import annotations

import gzip
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from microimpact.core.files import write_file
from study.declared.documents import load
from study.report.check.differences import Difference, Tolerance, compare_tables
from study.report.check.results import (
    INPUTS,
    ResultsError,
    built,
    read_cells,
    require_results,
    table_files,
)

FILE = "tolerances.yaml"
# Digits kept: far below the tolerance, so that another machine leaves the history alone.
DIGITS = 12
# More changed inputs than these are other settings.
FEW_CHANGES = 20
# Larger tables, long curves and images, are read by nobody and kept compressed.
PLAIN_BYTES = 100_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerances:
    """The tolerances of a folder of references."""

    columns: tuple[Tolerance, ...] = ()


def verify(results: Path, reference: Path) -> list[Difference]:
    """Return all differences of results from their references, in both directions.

    Raises ResultsError if either folder or a file in it is missing or malformed, or a tolerance
    fits no column of any reference.
    """
    require_results(results)
    if not reference.is_dir():
        raise ResultsError(f"{reference}: no such folder")
    path = reference / FILE
    rules = built(Tolerances, load(path), str(path)).columns if path.exists() else ()
    before, after = table_files(reference), table_files(results)
    differences = [
        *(Difference(name, "missing file") for name in before if name not in after),
        *(Difference(name, "extra file") for name in after if name not in before),
    ]
    unused = {*rules}
    for name in before:
        table = read_cells(before[name])
        unused -= {rule for rule in unused if any(rule.fits(name, str(column)) for column in table)}
        if name in after:
            differences += compare_tables(name, table, read_cells(after[name]), rules)
    for rule in unused:  # one that fits nothing has outlived its reason
        raise ResultsError(f"{path}: no table has a column {rule.column!r} in {rule.file!r}")
    return differences


def require_same_settings(differences: Sequence[Difference]) -> None:
    """Refuse results of a run with other settings altogether than the references come from.

    A few changed inputs are differences to report; a full run beside the references of a small one
    differs everywhere. Raises ResultsError, naming one of the inputs that differ and their number.
    """
    changed = [
        each
        for each in differences
        if (each.file, each.column) == (INPUTS, "value") and each.row.startswith("config, ")
    ]
    if len(changed) > FEW_CHANGES:
        first = changed[0]
        raise ResultsError(
            f"{len(changed)} inputs differ, as {first.row.removeprefix('config, ')}: "
            f"{first.result} where the references have {first.reference}; these are of the small "
            "run: snakemake --configfile config/ci.yaml"
        )


def renew(
    results: Path, reference: Path, differences: Sequence[Difference], *, remove: bool = False
) -> list[Path]:
    """Write the references that differ anew; those within tolerance stay as they are.

    `remove` drops references of files that the results lack; without it they raise ResultsError,
    and nothing is written.
    """
    missing = [d.file for d in differences if d.kind == "missing file"]
    if missing and not remove:
        raise ResultsError(
            f"{results}: lacks {len(missing)} files that have references "
            f"({', '.join(missing[:3])}{', ...' if len(missing) > 3 else ''}); "
            "build everything, or give --remove to drop these references"
        )
    tables, changed = table_files(results), list[Path]()
    for name in dict.fromkeys(d.file for d in differences):
        old = [p for p in (reference / name, reference / f"{name}.gz") if p.exists()]
        for path in old:
            path.unlink()
        changed += old
        if name in tables:
            cells = read_cells(tables[name]).map(_rounded)
            text = cells.to_csv(index=False, lineterminator="\n").encode()
            is_large = len(text) > PLAIN_BYTES
            changed.append(reference / (f"{name}.gz" if is_large else name))
            # Without a date in it, equal tables give equal bytes.
            write_file(changed[-1], gzip.compress(text, mtime=0) if is_large else text)
    return list(dict.fromkeys(changed))


def _rounded(cell: str) -> str:
    try:
        short = f"{float(cell):.{DIGITS}g}"
    except ValueError:
        return cell
    return short if len(short) < len(cell) else cell
