"""Run the study that bears the rule's name and write each of its tables."""

import sys
import time
from importlib import import_module
from typing import Any

import pandas as pd

from microimpact.job import logged
from microimpact.parameters import build
from microimpact.tables import parse_table, read_table, write_table


def main(job: Any) -> str:
    """Run one study and return a line on what was written.

    The rule gives plain parameter values as ``params.branch``, rows of declared tables as
    ``params.rows`` (name -> CSV text), and tables of earlier studies as named input files.
    """
    begin = time.perf_counter()
    study = import_module(f"microimpact.studies.{job.rule}")
    inputs: dict[str, pd.DataFrame] = {
        name: parse_table(text) for name, text in job.params.rows.items()
    }
    inputs |= {name: read_table(path) for name, path in job.input.items() if name != "code"}
    tables = study.run(build(study.Params, job.params.branch), inputs)
    outputs = dict(job.output.items())
    if set(tables) != set(outputs):
        raise ValueError(f"returned the tables {sorted(tables)}, the rule has {sorted(outputs)}")
    for name, path in outputs.items():
        write_table(tables[name], path)
    rows = ", ".join(f"{name} {len(tables[name])}" for name in outputs)
    return f"{job.rule}: rows written: {rows}; {time.perf_counter() - begin:.2f} s\n"


if __name__ == "__main__":
    sys.exit(logged(main, snakemake))  # type: ignore[name-defined]  # noqa: F821
