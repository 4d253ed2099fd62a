"""Run an analysis, or one part of it, and write the tables it returns."""

import sys
from typing import Any

import pandas as pd
from job import run

from microimpact.core.computable import NotComputable
from study import analyses
from study.declared.parameters import build
from study.declared.selection import NamedTables
from study.tables import (
    NOT_COMPUTED,
    NotComputedError,
    lacking,
    not_computed,
    parse_table,
    read_table,
    reason,
    write_table,
)

# Inputs of the rule that are no tables of earlier analyses.
OTHERS = {"parts", "samples"}


def main(job: Any) -> str:
    """Run one analysis and return a line on what was written.

    The rule names it as ``params.analysis``, with its branch of the configuration as
    ``params.branch``, rows of declared tables as ``params.rows`` (name -> CSV text), and tables of
    earlier analyses as named input files. ``params.function`` makes the tables, if it is not
    ``run``. The rule of its parts makes one, such as 1-of-2; what is made of the files ``parts`` is
    among the inputs of the analysis as one table. In place of what changed inputs do not allow,
    tables that say why are written: it stops neither claims nor report. Inputs as shipped, with
    ``params.is_shipped``, allow all.
    """
    analysis = analyses.analysis(job.params.analysis)
    declared = {name: parse_table(text) for name, text in job.params.rows.items()}
    made = {name: path for name, path in job.input.items() if name not in OTHERS}
    inputs = NamedTables(declared | made)
    params = build(analysis.Params, job.params.branch)
    outputs = dict(job.output.items())
    try:
        if item := job.wildcards.get("scatteritem"):
            number, count = map(int, item.split("-of-"))
            tables = {"part": analysis.part(params, inputs, number - 1, count)}
        else:
            if parts := job.input.get("parts"):
                inputs["parts"] = pd.concat(map(read_table, parts))
            make = getattr(job.params, "function", "run")
            tables = getattr(analysis, make)(params, inputs)
    except NotComputable as error:
        why = reason(job.params.analysis, error)
        sys.stderr.write(f"{NOT_COMPUTED}: {why}\n")
        tables = dict.fromkeys(outputs, not_computed(why))
    if job.params.is_shipped and (reasons := lacking(tables)):
        raise NotComputedError(f"with the inputs as shipped, {NOT_COMPUTED}: {'; '.join(reasons)}")
    if set(tables) != set(outputs):
        raise ValueError(f"returned the tables {sorted(tables)}, the rule has {sorted(outputs)}")
    for name, path in outputs.items():
        write_table(tables[name], path)
    rows = ", ".join(f"{name} {len(tables[name])}" for name in outputs)
    return f"{job.rule}: rows written: {rows}\n"


if __name__ == "__main__":
    run(main, snakemake)  # type: ignore[name-defined]  # noqa: F821
