"""Commands for authors of other codes: the reference of adhesive impacts, and codes against it."""

from __future__ import annotations

import csv
import io
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from microimpact.cli.measured import TABLE, table_options
from microimpact.cli.output import Command, echo, print_json, print_table, warn
from microimpact.core.arrays import POSITIVE, checked
from microimpact.core.files import require_writable, write_file

if TYPE_CHECKING:
    from microimpact.model.reference import Row

IMPACTS, CONTACTS = "adhesive_impacts.csv", "adhesive_impacts_contacts.csv"
LAMMPS = "dem01-jkr-twosphere-restitution-3d-si.yaml"


@click.command("reference", short_help="Adhesive impacts to test other codes by.")
@click.option("-o", "--output", default=".", show_default=True, help="Folder of the files.")
def reference_command(output: str) -> None:
    """Write the reference of adhesive impacts, for tests of other codes.

    Two tables, of impacts and of their contacts, closed forms beside the numbers; and one impact as
    a test of LAMMPS's granular suite.
    """
    from microimpact.model.reference import contacts, impacts, lammps_test

    for name in (IMPACTS, CONTACTS, LAMMPS):
        require_writable(Path(output) / name)
    contents = {IMPACTS: _csv(impacts()), CONTACTS: _csv(contacts()), LAMMPS: lammps_test()}
    for name, content in contents.items():
        path = Path(output) / name
        write_file(path, content)
        echo(path)


def _csv(rows: Sequence[Row]) -> str:
    target = io.StringIO()
    writer = csv.DictWriter(target, rows[0], lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({name: "" if str(value) == "nan" else value for name, value in row.items()})
    return target.getvalue()


@click.command("verify", cls=Command, short_help="A code's restitutions against the reference.")
@click.argument("results")
@table_options({flag: words for flag, words in TABLE.items() if flag != "--size-unit"})
@click.option("--tolerance", type=float, default=0.005, show_default=True, help="Of e.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def verify_command(
    results: str, reading: Mapping[str, Any], tolerance: float, as_json: bool
) -> None:
    """Compare a code's restitutions with the reference, and name known mistakes.

    RESULTS is a text file, read as that of 'microimpact fit', with the columns case,
    normal_speed_m_per_s (or v) and restitution (or e; 0 where the sphere stays), for cases of
    'microimpact reference' at any speeds. Ends with 1 if one differs.
    """
    from microimpact.measured.rebounds import read_cases
    from microimpact.model.verification import verify

    limit = float(checked("tolerance", tolerance, POSITIVE))
    cases, notes = read_cases(results, **reading)
    warn(notes)
    try:
        verdicts = [verify(case, v, e, limit) for case, (v, e) in cases.items()]
    except ValueError as error:
        raise ValueError(f"{results}: {error}") from None
    if as_json:
        print_json({"verdicts": [asdict(verdict) for verdict in verdicts]})
    else:
        lines = [
            (
                v.case,
                str(v.impacts),
                f"{v.difference:+.2g} at {v.speed:g} m/s",
                "agrees" if v.agrees else " | or: ".join(words for words, _ in v.causes),
            )
            for v in verdicts
        ]
        print_table(results, ("case", "impacts", "largest difference of e", "looks like"), lines)
    sys.exit(0 if all(verdict.agrees for verdict in verdicts) else 1)
