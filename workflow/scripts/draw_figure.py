"""Draw the figure that bears the rule's name from its tables, as SVG and PNG."""

from importlib import import_module
from typing import Any

from microimpact.run.job import run


def main(job: Any) -> str:
    """Draw one figure and return a line on what was written.

    The rule gives the registry entry as ``params.entry`` and the tables as named inputs, and so
    the file of digitised points, ``digitised``, if there is one.
    """
    from microimpact.core.tables import read_figure_data
    from microimpact.figures.registry import figure_spec
    from microimpact.figures.style import save
    from microimpact.run.digitised import overlaid, read_points

    spec = figure_spec(job.rule, job.params.entry)
    tables = {
        name: read_figure_data(job.input[name], unit.x, unit.y) for name, unit in spec.data.items()
    }
    origin = ""
    if path := job.input.get("digitised"):
        points = read_points(path, spec)
        tables = overlaid(tables, spec, points)
        origin = f", digitised points from {points.source}"
    draw = getattr(import_module(spec.module), spec.function)
    save(draw(tables, spec), job.output.svg, job.output.png)
    return f"{job.rule}: drawn from {', '.join(tables)}{origin}\n"


if __name__ == "__main__":
    run(main, snakemake)  # type: ignore[name-defined]  # noqa: F821
