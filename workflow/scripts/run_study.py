"""Run a study, or one part of it, and write the tables it returns."""

from pathlib import Path
from typing import Any

from job import run
from parts import part_from_text, part_text

from microimpact import studies
from microimpact.core.files import write_file
from microimpact.core.tables import parse_table, read_table, write_table
from microimpact.declared.parameters import build
from microimpact.declared.selection import NamedTables

# Inputs of the rule that are no tables of earlier studies.
OTHERS = {"parts", "samples"}


def main(job: Any) -> str:
    """Run one study and return a line on what was written.

    The rule names it as ``params.study``, with its branch of the configuration as
    ``params.branch``, rows of declared tables as ``params.rows`` (name -> CSV text), and tables of
    earlier studies as named input files. The rule ``STUDY_part`` makes part ``chunk``, as in
    ``1-of-2``, of a study that comes in parts; the study's own rule gathers the files ``parts``.
    """
    study = studies.study(job.params.study)
    inputs = NamedTables({name: parse_table(text) for name, text in job.params.rows.items()})
    inputs |= {name: read_table(path) for name, path in job.input.items() if name not in OTHERS}
    params = build(study.Params, job.params.branch)
    if chunk := job.wildcards.get("chunk"):
        number, count = map(int, chunk.split("-of-"))
        write_file(job.output[0], part_text(study.part(params, inputs, number - 1, count)))
        return f"{job.rule}: part {chunk}\n"
    if parts := job.input.get("parts"):
        pieces = [part_from_text(Path(path).read_text(encoding="utf-8")) for path in parts]
        tables = study.gather(params, inputs, pieces)
    else:
        tables = study.run(params, inputs)
    outputs = dict(job.output.items())
    if set(tables) != set(outputs):
        raise ValueError(f"returned the tables {sorted(tables)}, the rule has {sorted(outputs)}")
    for name, path in outputs.items():
        write_table(tables[name], path)
    rows = ", ".join(f"{name} {len(tables[name])}" for name in outputs)
    return f"{job.rule}: rows written: {rows}\n"


if __name__ == "__main__":
    run(main, snakemake)  # type: ignore[name-defined]  # noqa: F821
