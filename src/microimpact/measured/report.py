"""A fit as one page: data, models, interval, picture, residuals and warnings."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import Any

import jinja2
import numpy as np

from microimpact.core.files import write_file
from microimpact.measured.picture import picture
from microimpact.measured.rebounds import Rebounds
from microimpact.model.empirical.classes import Classes
from microimpact.model.empirical.comparison import Comparison

PAGE = "index.html"


def write_report(
    folder: Path | str, data: Rebounds, fit: Comparison | Classes, command: str
) -> None:
    """Write a fit as one HTML page that needs no other file.

    Parameters
    ----------
    folder
        Folder of the page, `PAGE`.
    data, fit
        The measurements, and the models fitted to them or to their classes.
    command
        Command that did it.

    Raises
    ------
    OSError
        If the page cannot be written.
    """
    text = files(__package__).joinpath("report.html.jinja").read_text(encoding="utf-8")
    environment = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    page = environment.from_string(text).render(
        command=command,
        version=version("microimpact"),
        read=data.read,
        notes=data.notes,
        summary=fit.summary(),
        warnings=fit.warnings,
        parts=[*_parts(data, fit)],
    )
    write_file(Path(folder) / PAGE, page)


def _parts(data: Rebounds, fit: Comparison | Classes) -> Iterator[dict[str, Any]]:
    """Name, summary, picture and table of the data, and of each class that was fitted."""
    if isinstance(fit, Comparison):
        yield _part("Data and models", "", data, fit)
        return
    assert data.classes is not None
    for name, comparison in fit.compared.items():
        if isinstance(comparison, Comparison):
            rows = np.flatnonzero(data.classes == name)
            yield _part(name, comparison.summary(), data.select(rows), comparison)


def _part(name: str, summary: str, data: Rebounds, fit: Comparison) -> dict[str, Any]:
    columns = {"v (m/s)": data.v, "e": data.e, "sigma": data.sigma, "sigma_v (m/s)": data.sigma_v}
    columns["d (um)"] = None if data.d is None else 1e6 * data.d
    columns["e less model"] = data.e - fit.models[0].law(data.v)
    known = {head: np.broadcast_to(x, data.v.shape) for head, x in columns.items() if x is not None}
    svg = picture(data, fit, "svg").decode()
    return {
        "name": name,
        "summary": summary,
        "picture": svg[svg.index("<svg") :],
        "best": fit.models[0].name,
        "header": [*known],
        "rows": [[f"{x:.4g}" for x in row] for row in zip(*known.values(), strict=True)],
    }
