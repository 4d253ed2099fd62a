"""Draw the figures of one study from its tables, each as SVG, PNG, PDF and table of its content."""

from importlib import import_module
from pathlib import Path
from typing import Any

from job import run
from matplotlib.figure import Figure

from study.figures.content import content
from study.figures.registry import FORMATS, FigureSpec, figure_spec
from study.figures.style import save, without_data
from study.run.digitised import overlaid
from study.tables import NOT_COMPUTED, NotComputedError, read_figure_data, write_table


def main(job: Any) -> str:
    """Draw the figures and return a line on what was drawn.

    The rule gives the registry entries by figure as ``params.entries``, the tables as named inputs
    and so the files of digitised points, as ``fig17_digitised``, if there are any.
    """
    folder, account = Path(job.output[0]).parent, []
    for figure, entry in job.params.entries.items():
        spec = figure_spec(figure, entry)
        try:
            picture, words = drawn(spec, job)
        except NotComputedError as why:
            words = f"{NOT_COMPUTED}: {why}"
            picture = without_data(spec, words)
        save(picture, *(folder / f"{figure}.{kind}" for kind in FORMATS))
        write_table(content(picture, spec), folder / f"{figure}.csv")
        account.append(f"{figure}: {words}\n")
    return "".join(account)


def drawn(spec: FigureSpec, job: Any) -> tuple[Figure, str]:
    """Return a figure, and a line on what it was drawn from.

    Raises NotComputedError if one of its tables could not be computed.
    """
    tables = {name: read_figure_data(job.input[name]) for name in spec.data}
    origin = ""
    if path := job.input.get(f"{spec.name}_digitised"):
        tables = overlaid(tables, spec, path)
        origin = f", points of {path}"
    draw = getattr(import_module(spec.module), spec.function)
    return draw(tables, spec), f"drawn from {', '.join(tables)}{origin}"


if __name__ == "__main__":
    run(main, snakemake)  # type: ignore[name-defined]  # noqa: F821
