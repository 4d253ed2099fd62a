"""Which files a module depends on: its import closure, parents and data files included."""

from __future__ import annotations

import ast
import hashlib
import os
from collections.abc import Iterable
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import grimp

PACKAGE = "microimpact"


@cache
def _graph() -> grimp.ImportGraph:
    # Imports for type checkers only cannot change what a module computes.
    return grimp.build_graph(PACKAGE, cache_dir=None, exclude_type_checking_imports=True)


@cache
def _root() -> Path:
    spec = find_spec(PACKAGE)
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError(f"package {PACKAGE} not found")
    return Path(spec.origin).parent


def closure(modules: Iterable[str]) -> list[str]:
    """Return the names of all package modules that the given ones depend on.

    Parameters
    ----------
    modules
        Full module names.

    Returns
    -------
    list of str
        Sorted names: the modules, all they import at any depth and anywhere in
        their text (also inside functions), and the packages these stand in with
        all that those import.

    Raises
    ------
    ModuleNotFoundError
        If a module is not part of the package.
    """
    found, waiting = set[str](), list(modules)
    while waiting:
        module = waiting.pop()
        if module not in found:
            found.add(module)
            waiting += _needed_by(module)
    return sorted(found)


@cache
def _needed_by(module: str) -> list[str]:
    if module not in _graph().modules:
        raise ModuleNotFoundError(f"no module named {module!r} in {_root()}")
    package = [module.rpartition(".")[0]] if "." in module else []
    return [*_graph().find_modules_directly_imported_by(module), *package]


def source_files(*modules: str, scripts: Iterable[Path | str] = ()) -> list[str]:
    """Return the files that decide what modules and scripts do.

    Parameters
    ----------
    modules
        Full module names.
    scripts
        Python files outside the package; what they import from it counts too.

    Returns
    -------
    list of str
        Absolute paths: the scripts, the source of the closure, and the data files
        that stand beside its modules (other than the typing marker).
    """
    imported = [name for script in scripts for name in imports_of(Path(script))]
    files = {str(Path(script).resolve()) for script in scripts}
    folders = set[Path]()
    for module in closure([*modules, *imported]):
        file = _file(module)
        files.add(str(file))
        folders.add(file.parent)
    files.update(data for folder in folders for data in _data_files(folder))
    return sorted(files)


@cache
def _file(module: str) -> Path:
    stem = _root().joinpath(*module.split(".")[1:])
    package = stem / "__init__.py"
    return package if package.exists() else stem.with_suffix(".py")


def digest(files: Iterable[Path | str], root: Path) -> str:
    """Return a word of 32 hexadecimal digits that tells files by their content and names.

    Parameters
    ----------
    files
        In any order; a file named twice counts once.
    root
        Folder that the names are relative to.

    Raises
    ------
    OSError
        If a file cannot be read.
    """
    return word("".join(sorted({_line(str(file), str(root)) for file in files})))


def word(text: str) -> str:
    """Return 32 hexadecimal digits that tell a text from any other."""
    return hashlib.sha256(text.encode()).hexdigest()[:32]


@cache
def _line(file: str, root: str) -> str:
    return f"{hashlib.sha256(Path(file).read_bytes()).hexdigest()} {os.path.relpath(file, root)}\n"


@cache
def _data_files(folder: Path) -> list[str]:
    found = []
    for path in folder.iterdir():
        known = path.suffix in {".py", ".pyc", ".pyi"} or path.name == "py.typed"
        if path.is_file() and not known and not path.name.startswith("."):
            found.append(str(path))
    return found


@cache
def imports_of(script: Path) -> list[str]:
    """Return the package modules that a Python file names in its import statements."""
    found = set[str]()
    for node in ast.walk(ast.parse(script.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found.add(node.module)
            found.update(f"{node.module}.{alias.name}" for alias in node.names)
    return sorted(found & _graph().modules)
