"""Sphinx: the guide and the reference of the package, without any use of the network."""

from __future__ import annotations

import json
import tempfile
from contextlib import chdir, redirect_stdout
from importlib.metadata import version as version_of
from io import StringIO
from textwrap import indent

from docutils.nodes import SkipNode
from docutils.utils.math.latex2mathml import tex2mathml

project = "microimpact"
author = "microimpact contributors"
version = release = version_of("microimpact")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "matplotlib.sphinxext.plot_directive",
]
source_suffix = {".rst": "restructuredtext", ".md": "markdown", ".ipynb": "markdown"}
exclude_patterns = ["images", "examples"]
# Pictures of the examples; the files that these write are of no use.
plot_formats = [("png", 120)]
plot_html_show_formats = False
plot_html_show_source_link = False
plot_working_directory = tempfile.mkdtemp()
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
html_math_renderer = "mathml"

html_theme = "furo"
html_title = "microimpact"
html_show_copyright = False
html_copy_source = False

autosummary_generate = False
autodoc_default_options = {"members": True, "member-order": "bysource"}
autodoc_preserve_defaults = True
# Fields are described once, in the docstring of their class.
napoleon_use_ivar = True
napoleon_google_docstring = False
default_role = "code"

# Names of types instead of what they stand for.
autodoc_type_aliases = {
    name: name
    for name in (
        "ArrayLike",
        "BoolArray",
        "Distribution",
        "FloatArray",
        "IntArray",
        "ObjectArray",
        "Real",
    )
}


def _formula(writer, node) -> None:
    """Write a formula as MathML, which browsers draw without a script from the network."""
    block = node.tagname == "math_block"
    formula = tex2mathml(node.astext(), as_block=block)
    # Room above and below, so that the theme's frame does not scroll.
    writer.body.append(f'<div style="padding: 0.5em 0">{formula}</div>' if block else formula)
    raise SkipNode


def _notebook(app, page: str, source: list[str]) -> None:
    """Turn a notebook into Markdown with what its code prints; plots are drawn from that."""
    if app.env.doc2path(page).suffix == ".ipynb":
        cells = json.loads(source[0])["cells"]
        texts = ["".join(cell["source"]) for cell in cells]
        names: dict[str, object] = {}
        for k, cell in enumerate(cells):
            if cell["cell_type"] == "code":
                with chdir(plot_working_directory), redirect_stdout(StringIO()) as printed:
                    exec(texts[k], names)
                texts[k] = CELL.format(cell["id"], indent(texts[k], "   "))
                if printed.getvalue():
                    texts[k] += f"\n\n```text\n{printed.getvalue()}```"
        source[0] = "\n\n".join(texts)


CELL = """```{{eval-rst}}
.. plot::
   :context: close-figs
   :include-source:
   :filename-prefix: {}

{}
```"""


def setup(app) -> None:
    """Read notebooks, and make formulas independent of the network."""
    app.connect("source-read", _notebook)
    app.add_html_math_renderer("mathml", (_formula, None), (_formula, None))
