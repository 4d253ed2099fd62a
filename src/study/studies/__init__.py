"""Studies: one per analysis, each from a branch of the configuration to tables, by section.

A study bears the name of its branch in ``config/analyses``. It is a module, or a package whose
parts are its own, that is directly in one of the folders here, and defines a frozen dataclass
``Params`` and a pure function ``run(params, inputs)`` that returns its tables by name. If it takes
tables of earlier studies, ``NEEDS`` names them by the study that makes them. They are among the
inputs by their names, and so are declared rows: ``materials`` and ``contacts`` of what the
parameters name, and as ``printed`` the printed values that they name or that ``PRINTED_VALUES``
lists. If its parameters must agree with those of a study that it needs,
``disagreements(params, others)`` yields a line for each that does not, which is told before
anything is made. Studies are found by name; nothing is registered here.
"""

from __future__ import annotations

import pkgutil
from functools import cache
from importlib import import_module
from types import MappingProxyType, ModuleType


@cache
def homes() -> MappingProxyType[str, str]:
    """Return the full module name of every study by the study's name, in order of the names."""
    sections = [module.name for module in pkgutil.iter_modules(__path__) if module.ispkg]
    modules = {
        module.name: f"{__name__}.{section}.{module.name}"
        for section in sections
        for module in pkgutil.iter_modules([f"{place}/{section}" for place in __path__])
    }
    return MappingProxyType(dict(sorted(modules.items())))


def study(name: str) -> ModuleType:
    """Return the module of a study, given its name.

    Raises KeyError if there is no such study.
    """
    return import_module(homes()[name])


def needs(name: str) -> dict[str, str]:
    """Return the tables of earlier studies that a study takes: the maker of each by its name.

    Raises KeyError if there is no such study.
    """
    needed = getattr(study(name), "NEEDS", {})
    return {table: maker for maker, tables in needed.items() for table in tables}


def printed(name: str) -> tuple[str, ...]:
    """Return the keys of the printed values that a study reads whatever its parameters are.

    Raises KeyError if there is no such study.
    """
    return tuple(getattr(study(name), "PRINTED_VALUES", ()))
