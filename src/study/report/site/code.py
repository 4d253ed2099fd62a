"""Pages of code: every function that a claim or an equation names, one click away."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

FOLDER = "code"
ROOT = Path(__file__).parents[3]


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """A line of code, the definitions that begin there, and how many end there."""

    text: str
    begins: tuple[str, ...]
    ends: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Module:
    """A module of the package by its full name and its file in the project."""

    name: str
    file: str
    lines: tuple[Line, ...]


def place(code: str) -> str:
    """Return the address of a function in the report, by its full name; none if there is none."""
    module, _, name = _split(code)
    return f"{FOLDER}/{module}.html#{name}" if name else ""


def modules(codes: Iterable[str]) -> list[Module]:
    """Return the modules that define functions, by the functions' full names."""
    files = {module: file for module, file, name in map(_split, codes) if name}
    return [_module(name, files[name]) for name in sorted(files)]


@cache
def _split(code: str) -> tuple[str, Path, str]:
    """Return module, file, and name in the module of a function; no name if it has none."""
    parts = code.split(".")
    for end in range(len(parts) - 1, 0, -1):
        stem = ROOT.joinpath(*parts[:end])
        for file in (stem.with_suffix(".py"), stem / "__init__.py"):
            if file.is_file():
                name = ".".join(parts[end:])
                names = {each for each, _, _ in _definitions(ast.parse(file.read_text("utf-8")))}
                return ".".join(parts[:end]), file, name if name in names else ""
    return "", ROOT, ""


def _module(name: str, file: Path) -> Module:
    text = file.read_text(encoding="utf-8")
    begins, ends = defaultdict[int, list[str]](list), defaultdict[int, int](int)
    for anchor, first, last in _definitions(ast.parse(text)):
        begins[first].append(anchor)
        ends[last] += 1
    return Module(
        name=name,
        file=f"src/{file.relative_to(ROOT).as_posix()}",
        lines=tuple(
            Line(text=line, begins=tuple(begins[number]), ends=ends[number])
            for number, line in enumerate(text.splitlines(), 1)
        ),
    )


def _definitions(
    tree: ast.Module | ast.ClassDef, within: str = ""
) -> Iterator[tuple[str, int, int]]:
    """Return functions, classes and methods with their first and last lines, outer ones first."""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            name = within + node.name
            first = min(part.lineno for part in (node, *node.decorator_list))
            yield name, first, node.end_lineno or node.lineno
            if isinstance(node, ast.ClassDef):
                yield from _definitions(node, f"{name}.")
