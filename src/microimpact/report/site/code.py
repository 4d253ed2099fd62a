"""Pages of code: every function that a claim or an equation names, one click away."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from microimpact.report.site.reached import is_defined, module_of, source_file

FOLDER = "code"


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
    """Return where the report shows a function, by its full name; nothing if there is none."""
    if not is_defined(code):
        return ""
    module = module_of(code)
    return f"{FOLDER}/{module}.html#{code.removeprefix(f'{module}.')}"


def modules(codes: Iterable[str]) -> list[Module]:
    """Return the modules that define functions, by the functions' full names."""
    names = sorted({module_of(code) for code in codes if is_defined(code)})
    return [_module(name) for name in names]


def _module(name: str) -> Module:
    path = source_file(name)
    text = path.read_text(encoding="utf-8")
    begins: dict[int, list[str]] = {}
    ends: dict[int, int] = {}
    for anchor, first, last in _definitions(ast.parse(text)):
        begins.setdefault(first, []).append(anchor)
        ends[last] = ends.get(last, 0) + 1
    lines = enumerate(text.splitlines(), 1)
    return Module(
        name=name,
        file=f"src/{'/'.join(name.split('.')[:-1])}/{path.name}",
        lines=tuple(
            Line(text=line, begins=tuple(begins.get(i, ())), ends=ends.get(i, 0))
            for i, line in lines
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
