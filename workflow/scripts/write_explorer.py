"""Write the page of the explorer and its scripts from declared and calibrated contacts."""

from pathlib import Path
from typing import Any

from job import run

from microimpact.core.files import write_file
from study.report.explorer.build import page_files
from study.tables import parse_table, read_table


def main(job: Any) -> str:
    """Write the page and return a line on its size.

    The rule gives declared rows as ``params.rows`` (name -> CSV text) and the table of the
    calibration as a named input; the page is the output ``page``, its scripts stand beside it.
    """
    inputs = {name: parse_table(text) for name, text in job.params.rows.items()}
    inputs |= {name: read_table(path) for name, path in job.input.items()}
    files = page_files(inputs)
    report = Path(job.output.page).parent
    for name, text in files.items():
        write_file(report / name, text)
    size = sum(len(text.encode()) for text in files.values())
    return f"{job.rule}: {len(files)} files, {size / 1000:.0f} kB, in {report}\n"


if __name__ == "__main__":
    run(main, snakemake)  # type: ignore[name-defined]  # noqa: F821
