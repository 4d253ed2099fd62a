"""Write the page of the explorer and its scripts from the tables of its study."""

from pathlib import Path
from typing import Any

from microimpact.core.files import write_file
from microimpact.run.job import run


def main(job: Any) -> str:
    """Write the page and return a line on its size.

    The rule gives the tables as named inputs and the end of their axis of damping as
    ``params.largest_damping``; the page is the output ``page``, its scripts stand beside it.
    """
    from microimpact.core.tables import read_table
    from microimpact.report.explorer.build import page_files

    tables = {name: read_table(path) for name, path in job.input.items()}
    files = page_files(tables, job.params.largest_damping)
    report = Path(job.output.page).parent
    for name, text in files.items():
        write_file(report / name, text)
    size = sum(len(text.encode()) for text in files.values())
    return f"{job.rule}: {len(files)} files, {size / 1000:.0f} kB, in {report}\n"


if __name__ == "__main__":
    run(main, snakemake)  # type: ignore[name-defined]  # noqa: F821
