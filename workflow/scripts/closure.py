"""Source files of a module: its import closure, with parent packages and data files."""

from __future__ import annotations

import ast
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import grimp

import microimpact
import study

PACKAGES = {package.__name__: Path(package.__file__).parent for package in (microimpact, study)}
CODE = {".py", ".pyc", ".pyi", ".typed"}


@cache
def _graph() -> grimp.ImportGraph:
    # Imports for type checkers only cannot change what a module computes.
    return grimp.build_graph(*PACKAGES, cache_dir=None, exclude_type_checking_imports=True)


def closure(modules: Iterable[str]) -> list[str]:
    """Return the names of modules and of all others of the package that they import, at any depth.

    Imports inside functions count, and so do the packages that a module stands in. Raises
    ModuleNotFoundError if one is not part of the package.
    """
    modules_seen, waiting = set[str](), list(modules)
    while waiting:
        module = waiting.pop()
        if module not in modules_seen:
            modules_seen.add(module)
            waiting += _needed_by(module)
    return sorted(modules_seen)


@cache
def _needed_by(module: str) -> list[str]:
    if module not in _graph().modules:
        raise ModuleNotFoundError(f"no module named {module!r} in {', '.join(PACKAGES)}")
    package = [module.rpartition(".")[0]] if "." in module else []
    return [*_graph().find_modules_directly_imported_by(module), *package]


def source_files(*modules: str, scripts: Iterable[Path] = ()) -> list[str]:
    """Return the absolute paths of scripts, and of the closure of modules and scripts.

    With the data files beside the modules of the closure.
    """
    imported = [name for script in scripts for name in imports_of(script)]
    files = {_file(module) for module in closure([*modules, *imported])}
    data = {path for folder in {file.parent for file in files} for path in _data_files(folder)}
    return sorted(map(str, {*map(Path.resolve, scripts), *files, *data}))


@cache
def _file(module: str) -> Path:
    name, *parts = module.split(".")
    stem = PACKAGES[name].joinpath(*parts)
    package = stem / "__init__.py"
    return package if package.exists() else stem.with_suffix(".py")


@cache
def _data_files(folder: Path) -> list[Path]:
    visible = [path for path in folder.iterdir() if path.is_file() and path.name[0] != "."]
    return [path for path in visible if path.suffix not in CODE]


@cache
def imports_of(script: Path) -> list[str]:
    """Return the package modules that a Python file names in its import statements."""
    names = set[str]()
    for node in ast.walk(ast.parse(script.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names.add(node.module)
            names.update(f"{node.module}.{alias.name}" for alias in node.names)
    return sorted(names & _graph().modules)
