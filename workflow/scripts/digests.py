"""Digests of what a result rests on: the engine makes it anew where one has changed."""

from __future__ import annotations

import ast
import hashlib
import json
import os
import platform
from collections.abc import Iterable, Mapping
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from microimpact.core.files import write_file

# Syntax trees take a second to read: their digests are kept, by those of the texts.
KEPT = Path(".snakemake/syntax.json")
# Packages that decide numbers and pictures.
NUMERICAL = ("numpy", "scipy", "numba", "pandas", "matplotlib", "SALib", "sympy")


class Digested(dict[str, Any]):
    """A mapping that is shown, compared and recorded as a digest; a job is given the contents."""

    def __repr__(self) -> str:
        """Return the digest of the contents."""
        return digest(json.dumps(self).encode())

    def __reduce__(self) -> tuple[type, tuple[dict[str, Any]]]:
        """Return a plain mapping to whom it is sent."""
        return dict, (dict(self),)


def digest(content: bytes) -> str:
    """Return the SHA-256 of a content, its first 32 hexadecimal digits."""
    return hashlib.sha256(content).hexdigest()[:32]


def of_files(root: Path, code: Iterable[str], texts: Iterable[Path | str] = ()) -> Digested:
    """Return the digest of each file by its name below a root.

    Of Python code without comments, docstrings and layout, which decide no result; of texts, as
    templates and code that is itself shown, with all that is in them. Raises OSError if one cannot
    be read.
    """
    found = {os.path.relpath(file, root): _of_code(Path(file)) for file in code}
    return Digested(found | {os.path.relpath(file, root): _of_text(Path(file)) for file in texts})


def changed(root: Path, recorded: Mapping[str, str]) -> list[str]:
    """Return the files whose digests are no longer those of `of_files`."""
    return [
        name
        for name, known in recorded.items()
        if known not in {_of_text.__wrapped__(root / name), _of_code.__wrapped__(root / name)}
    ]


@cache
def _of_text(file: Path) -> str:
    return digest(file.read_bytes())


@cache
def _of_code(file: Path) -> str:
    text = file.read_bytes()
    if file.suffix != ".py":
        return digest(text)
    key = digest(text)
    if key not in _kept():
        _kept()[key] = digest(_syntax(text).encode())
    return _kept()[key]


def _syntax(text: bytes) -> str:
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            node.body = node.body[ast.get_docstring(node, clean=False) is not None :]
    return ast.dump(tree)


@cache
def _kept() -> dict[str, str]:
    try:
        kept: dict[str, str] = json.loads(KEPT.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return kept


def keep() -> None:
    """Keep digests of syntax trees for the next start, where that is allowed."""
    with suppress(OSError):
        write_file(KEPT, json.dumps(_kept()))


@cache
def versions() -> str:
    """Return the versions of Python and of the packages that decide numbers and pictures."""
    packages = [f"{name} {version(name)}" for name in NUMERICAL]
    return ", ".join([f"python {platform.python_version()}", *packages])
