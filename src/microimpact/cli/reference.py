"""Commands for authors of other codes: the reference of adhesive impacts, and codes against it."""

from __future__ import annotations

import csv
import io
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from microimpact.cli.output import print_json, print_table
from microimpact.core.arrays import POSITIVE, checked
from microimpact.core.files import write_file
from microimpact.core.materials import read_rows

if TYPE_CHECKING:
    from microimpact.model.reference import Row

IMPACTS, CONTACTS = "adhesive_impacts.csv", "adhesive_impacts_contacts.csv"
LAMMPS = "dem01-jkr-twosphere-restitution-3d-si.yaml"


@click.command("reference")
@click.option("-o", "--output", default=".", show_default=True, help="Folder of the files.")
def reference_command(output: str) -> None:
    """Write the reference of adhesive impacts, for tests of other codes.

    Two tables, of impacts and of their contacts, closed forms beside the numbers; and one impact as
    a test of LAMMPS's granular suite.
    """
    from microimpact.model.reference import contacts, impacts, lammps_test

    contents = {IMPACTS: _csv(impacts()), CONTACTS: _csv(contacts()), LAMMPS: lammps_test()}
    for name, content in contents.items():
        path = Path(output) / name
        write_file(path, content)
        click.echo(path)


def _csv(rows: Sequence[Row]) -> str:
    target = io.StringIO()
    writer = csv.DictWriter(target, rows[0], lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({name: "" if str(value) == "nan" else value for name, value in row.items()})
    return target.getvalue()


@click.command("verify")
@click.argument("results")
@click.option("--tolerance", type=float, default=0.005, show_default=True, help="Of e.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def verify_command(results: str, tolerance: float, as_json: bool) -> None:
    """Compare a code's restitutions with the reference, and name known mistakes.

    RESULTS is a CSV file with the columns case, normal_speed_m_per_s and restitution (0 where the
    sphere stays), for cases of 'microimpact reference' at any speeds. Ends with 1 if one differs.
    """
    from microimpact.model.verification import verify_table

    limit = float(checked("tolerance", tolerance, POSITIVE))
    rows = read_rows(results, ("case", "normal_speed_m_per_s", "restitution"))
    try:
        verdicts = verify_table(rows, limit)
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
