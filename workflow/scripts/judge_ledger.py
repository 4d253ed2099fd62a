"""Judge a ledger and write its verdicts."""

from importlib import import_module
from typing import Any

from job import run

from study.declared.selection import NamedTables
from study.tables import parse_table, write_table


def main(job: Any) -> str:
    """Judge one ledger and return a line that counts its verdicts.

    The rule names it as ``params.ledger`` and gives rows of declared tables as ``params.rows``
    (name -> CSV text), tables of analyses as named input files and, for claims, the values in
    their words as ``params.branch`` and what is not as shipped as ``params.changed``; its outputs
    are the tables of the ledger by their names.
    """
    ledger = import_module(job.params.module)
    declared = {name: parse_table(text) for name, text in job.params.rows.items()}
    tables = NamedTables(declared | dict(job.input.items()))
    named = dict(job.params.items())
    settings = [named[key] for key in ("branch", "changed") if key in named]
    judged = ledger.judge(tables, *settings)
    for name, path in job.output.items():
        write_table(judged[name], path)
    counts = judged[job.params.ledger]["verdict"].value_counts().items()
    return f"{job.rule}: {', '.join(f'{count} {verdict}' for verdict, count in counts)}\n"


if __name__ == "__main__":
    run(main, snakemake)  # type: ignore[name-defined]  # noqa: F821
