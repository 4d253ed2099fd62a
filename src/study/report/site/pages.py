"""Pages from templates: one look, one navigation, no network.

Another module's page uses the same base. Its template, in a folder of its own, begins with
``{% extends "base.html" %}`` and fills the blocks ``title`` (text of the tab), ``head`` (further
``<link>`` and ``<script>``, by address) and ``main`` (the content below the navigation)::

    text = render("explorer.html", templates=Path(__file__).parent / "templates", here="explorer")
    write_file(report / "explorer.html", text)

* ``here`` names the entry of `NAVIGATION` that is marked as the present page.
* ``root`` is the way from the page to the report's folder: ``""``, or ``"../"`` in a folder below.
* ``wide=True`` lets the page use the whole width of the window.
* In ``.html`` variables are escaped. Text becomes markup only through the filter ``safe``: never
  for data.
* The policy in the base allows scripts, styles and pictures of the report's own folder (and
  ``data:`` pictures) and nothing else: no inline ``<script>``, no ``style`` attribute, no request
  (``fetch`` included). Numbers for a script go into a ``.js`` file, or into the page as
  ``<script type="application/json" id="numbers">{{ numbers | tojson }}</script>``: that is not run.
  Setting ``element.style`` from a script is allowed.
* Colours come from the properties at the head of ``assets/style.css`` (``--ink``, ``--paper``,
  ``--accent``, ``--line``, ...), in a light and a dark form that follow the reader's choice.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape

from study.report.site.glossary import marked

HERE = Path(__file__).parent
TEMPLATES = HERE / "templates"
ASSETS = HERE / "assets"

# Key, file and words of each entry of the navigation.
NAVIGATION = (
    ("index", "index.html", "Overview"),
    ("figures", "figures.html", "Figures"),
    ("claims", "claims.html", "Claims"),
    ("equations", "equations.html", "Equations"),
    ("explorer", "explorer.html", "Explorer"),
    ("tables", "tables.html", "Tables"),
    ("run", "run.html", "This run"),
)

# The page that another rule writes: the site links to it where it is there.
EXPLORER = "explorer"


def render(template_name: str, *, templates: Path | None = None, **context: Any) -> str:
    """Return a page.

    Parameters
    ----------
    template_name
        File name of the template.
    templates
        A folder that is searched before that of the site.
    context
        What the template shows; see the module's text for ``here``, ``root`` and ``wide``.

    Raises
    ------
    jinja2.UndefinedError
        If the template shows something that is not given.
    """
    text = _environment(templates).get_template(template_name).render(**context)
    return text if template_name == "glossary.html" else marked(text, context.get("root", ""))


@cache
def _environment(templates: Path | None) -> Environment:
    folders = [TEMPLATES] if templates is None else [templates, TEMPLATES]
    environment = Environment(
        loader=FileSystemLoader(folders),
        autoescape=select_autoescape(["html"], default=False),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.globals |= {"navigation": NAVIGATION, "root": "", "here": "", "wide": False}
    return environment
