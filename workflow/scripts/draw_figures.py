"""Draw the figures of an analysis, each in the formats wanted and as table of its content."""

from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

from job import run

from study.figures.content import content
from study.figures.declaration import FIGURES, Figure
from study.figures.style import Sheet, context, save, without_data
from study.run.digitised import overlaid
from study.tables import NOT_COMPUTED, NotComputedError, read_figure_data, write_table


def main(job: Any) -> str:
    """Draw the figures and return a line on what was drawn.

    The rule gives the words of each figure as ``params.entries``, the parameters of the analysis as
    ``params.branch`` and the materials of its cases as ``params.pairs``, ``params.scale`` of sizes
    and ``params.palette``, the tables as named inputs and so the files of digitised points, as
    ``fig17_digitised``, if there are any; the outputs of each bear its name.
    """
    account = []
    with context(job.params.palette):
        for name, entry in job.params.entries.items():
            import_module(entry["drawing"].rpartition(".")[0])
            figure = FIGURES[name].with_texts(entry)
            try:
                sheet, words = drawn(figure, job)
                figure, picture = sheet.declared, sheet.figure
            except NotComputedError as why:
                words = f"{NOT_COMPUTED}: {why}"
                figure, picture = replace(figure, finding=""), without_data(figure, words)
            picture.set_size_inches(job.params.scale * picture.get_size_inches())
            *pictures, table = (path for path in map(Path, job.output) if path.stem == name)
            save(picture, *pictures, title=figure.title, description=figure.description)
            write_table(content(picture, figure), table)
            account.append(f"{name}: {words}\n")
    return "".join(account)


def drawn(figure: Figure, job: Any) -> tuple[Sheet, str]:
    """Return a figure, its finding checked, and a line on what it was drawn from.

    Raises NotComputedError if one of its tables could not be computed.
    """
    tables = {name: read_figure_data(job.input[name]) for name in figure.data}
    origin = ""
    if path := job.input.get(f"{figure.name}_digitised"):
        tables = overlaid(tables, figure, path)
        origin = f", points of {path}"
    figure = figure.checked(tables)
    sheet = Sheet(figure, tables, job.params.branch, job.params.pairs)
    figure.draw(sheet)
    return sheet, f"drawn from {', '.join(tables)}{origin}"


if __name__ == "__main__":
    run(main, snakemake)  # type: ignore[name-defined]  # noqa: F821
