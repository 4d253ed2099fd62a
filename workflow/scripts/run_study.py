"""Run the study that bears the rule's name, or one part of it, and write what it gives."""

import time
from pathlib import Path
from typing import Any

from microimpact import studies
from microimpact.core.files import write_file
from microimpact.run.job import run


def main(job: Any) -> str:
    """Run one study and return a line on what was written.

    The rule gives plain parameter values as ``params.branch``, rows of declared tables as
    ``params.rows`` (name -> CSV text), and tables of earlier studies as named input files. The
    rule ``STUDY_part`` makes part ``chunk``, as in ``1-of-2``, of a study that comes in parts;
    the study's own rule gathers the files ``parts``.
    """
    from microimpact.core.tables import parse_table, read_table, write_table
    from microimpact.declared.parameters import build
    from microimpact.declared.selection import NamedTables
    from microimpact.run.parts import part_from_text, part_text

    begin = time.perf_counter()
    study = studies.study(job.rule.removesuffix("_part"))
    files = {name: path for name, path in job.input.items() if name not in {"parts", "samples"}}
    inputs = NamedTables({name: parse_table(text) for name, text in job.params.rows.items()})
    inputs.update({name: read_table(path) for name, path in files.items()})
    params = build(study.Params, job.params.branch)
    if chunk := job.wildcards.get("chunk"):
        number, count = map(int, chunk.split("-of-"))
        write_file(job.output[0], part_text(study.part(params, inputs, number - 1, count)))
        return f"{job.rule}: part {chunk}; {time.perf_counter() - begin:.2f} s\n"
    if parts := job.input.get("parts"):
        found = [part_from_text(Path(path).read_text(encoding="utf-8")) for path in parts]
        tables = study.gather(params, inputs, found)
    else:
        tables = study.run(params, inputs)
    outputs = dict(job.output.items())
    if set(tables) != set(outputs):
        raise ValueError(f"returned the tables {sorted(tables)}, the rule has {sorted(outputs)}")
    for name, path in outputs.items():
        write_table(tables[name], path)
    rows = ", ".join(f"{name} {len(tables[name])}" for name in outputs)
    return f"{job.rule}: rows written: {rows}; {time.perf_counter() - begin:.2f} s\n"


if __name__ == "__main__":
    run(main, snakemake)  # type: ignore[name-defined]  # noqa: F821
