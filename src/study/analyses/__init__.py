"""Analyses, each from a branch of the configuration to tables and figures.

The listing is the index: an analysis bears one name, which begins with the figures of the article
that it makes. It is that of its folder or module here, of its file in ``config/analyses``, of its
rule and of its test. Its module, or ``compute`` in its folder, defines a frozen dataclass
``Params`` and a pure function ``run(params, inputs)`` that returns its tables by name; ``draw`` in
its folder declares its figures beside the functions that draw them. If it takes tables of earlier
analyses, ``NEEDS`` names them by the analysis that makes them. They are among the inputs by their
names, and so are declared rows: ``materials`` and ``contacts`` of what the parameters name, and as
``printed`` the printed values that they name or that ``PRINTED_VALUES`` lists; in whole, those of
``WHOLE_TABLES``.

What an analysis says of the inputs is told before anything is made, a line for each that is wrong:
``disagreements(params, others, laboratory)`` where its parameters must agree with those of an
analysis that it needs, or with the laboratory; ``lacking(params, cases)`` of contacts that others
name and it does not make. ``declared_names(branch)`` are names that others may refer to.
"""

from __future__ import annotations

import pkgutil
from functools import cache
from importlib import import_module
from types import MappingProxyType, ModuleType


@cache
def homes() -> MappingProxyType[str, str]:
    """Return the full name of the module that computes each analysis, in order of the names."""
    places = {
        module.name: f"{__name__}.{module.name}{'.compute' if module.ispkg else ''}"
        for module in pkgutil.iter_modules(__path__)
    }
    return MappingProxyType(dict(sorted(places.items())))


def analysis(name: str) -> ModuleType:
    """Return the module that computes an analysis, given its name.

    Raises KeyError if there is no such analysis.
    """
    return import_module(homes()[name])


def needs(name: str, *makers: str) -> dict[str, str]:
    """Return the tables of earlier analyses that one takes: the maker of each by its name.

    Those of some makers, if any are named.

    Raises KeyError if there is no such analysis.
    """
    needed = getattr(analysis(name), "NEEDS", {})
    of_makers = {maker: tables for maker, tables in needed.items() if maker in (makers or needed)}
    return {table: maker for maker, tables in of_makers.items() for table in tables}


def printed(name: str) -> tuple[str, ...]:
    """Return the keys of the printed values that an analysis reads whatever its parameters are.

    Raises KeyError if there is no such analysis.
    """
    return tuple(getattr(analysis(name), "PRINTED_VALUES", ()))


def whole(name: str) -> tuple[str, ...]:
    """Return the declared tables that an analysis is given in whole.

    Raises KeyError if there is no such analysis.
    """
    return tuple(getattr(analysis(name), "WHOLE_TABLES", ()))
