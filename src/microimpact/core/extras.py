"""Packages that only some functions need, and the extras of this package that bring them."""

from __future__ import annotations

from importlib import import_module
from typing import Any

EXTRAS = {"matplotlib": "plot", "jinja2": "report", "emcee": "calibrate"}


def optional(module: str) -> Any:
    """Return a module of an optional package; without it, say which extra brings it."""
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(missing(error), name=error.name) from error


def missing(error: ModuleNotFoundError) -> str:
    """Sentence on the package that an import lacks, and how to install it."""
    name = (error.name or "").partition(".")[0]
    return f"needs {name}: pip install '.[{EXTRAS.get(name, 'study')}]'"
