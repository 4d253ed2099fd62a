"""Write the report of a run, a static site, from its tables and figures."""

from pathlib import Path
from typing import Any

from job import run

from study.report.site.build import REPORT, write_site
from study.report.site.record import read_record, write_record


def main(job: Any) -> str:
    """Write the record of the run and all pages, and return a line on them.

    The rule gives the record as ``params.record`` and ``record.json`` in the report as an output.
    """
    results = Path(job.output.record).parents[1]
    write_record(results, job.params.record)
    pages = write_site(results, read_record(results))
    return f"{job.rule}: {len(pages)} pages in {results / REPORT}\n"


if __name__ == "__main__":
    run(main, snakemake)  # type: ignore[name-defined]  # noqa: F821
