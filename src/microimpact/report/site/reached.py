"""Which functions of the package a study can come to call: names followed through the source.

From the body of ``run`` every name is followed to where it is defined, and so on. A method counts
if its class is reached and something reached has an attribute of its name. This may hold a
function that no case ever calls, and misses none but those looked up at run time: the functions of
the claims, which register themselves and must be named as starts.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

PACKAGE = "microimpact"
_ROOT = Path(__file__).parents[2]


@dataclass(slots=True)
class _Definition:
    """What a name of a module refers to: names and attributes in its text, and its methods."""

    chains: set[tuple[str, ...]] = field(default_factory=set)
    attributes: set[str] = field(default_factory=set)
    methods: set[str] = field(default_factory=set)

    def collect(self, nodes: Iterable[ast.AST]) -> None:
        """Add names and attributes in the text of some nodes."""
        for part in (part for node in nodes for part in ast.walk(node)):
            if isinstance(part, ast.Attribute):
                self.attributes.add(part.attr)
            if isinstance(part, ast.Attribute | ast.Name) and (chain := _chain(part)):
                self.chains.add(chain)


@dataclass(frozen=True, slots=True)
class _Module:
    imports: dict[str, str]
    definitions: dict[str, _Definition]


def reached(*starts: str) -> frozenset[str]:
    """Return the full names of all that can be called from functions of the package.

    `starts`: full names, as ``microimpact.studies.models.coulomb_friction.run``.
    """
    found, waiting, attributes = set[str](), list(starts), set[str]()
    possible = set[str]()
    while waiting:
        name = waiting.pop()
        definition = _definition(name)
        if name in found or definition is None:
            continue
        found.add(name)
        module = module_of(name)
        waiting += [n for chain in definition.chains if (n := _target(module, chain))]
        if definition.methods or not definition.attributes <= attributes:
            attributes |= definition.attributes
            possible |= {f"{name}.{method}" for method in definition.methods}
            waiting += [m for m in possible - found if m.rpartition(".")[2] in attributes]
    return frozenset(found)


@cache
def _target(module: str, chain: tuple[str, ...]) -> str | None:
    """Return the definition that a chain of attributes, as seen in a module, leads to."""
    known = _read(module)
    if known is None:
        return None
    if chain[0] in known.definitions:
        return f"{module}.{chain[0]}"
    if chain[0] in known.imports:
        path = ".".join((known.imports[chain[0]], *chain[1:]))
        # The longest part that is a module; what follows is a name in it.
        parts = path.split(".")
        for end in range(len(parts), 0, -1):
            inner = ".".join(parts[:end])
            if _read(inner) is not None:
                rest = tuple(parts[end:])
                return _target(inner, rest) if rest and inner != module else None
    return None


@cache
def module_of(name: str) -> str:
    """Return the module of the package in which a full name is defined."""
    while _read(name) is None:
        name = name.rpartition(".")[0]
    return name


def is_defined(name: str) -> bool:
    """Tell whether a full name is that of a function or class of the package."""
    return _definition(name) is not None


def source_file(module: str) -> Path:
    """Return the file of a module of the package."""
    stem = _ROOT.joinpath(*module.split(".")[1:])
    return stem / "__init__.py" if (stem / "__init__.py").is_file() else stem.with_suffix(".py")


def _definition(name: str) -> _Definition | None:
    if not name.startswith(f"{PACKAGE}."):
        return None
    module = module_of(name)
    known = _read(module)
    return known.definitions.get(name.removeprefix(f"{module}.")) if known else None


@cache
def _read(module: str) -> _Module | None:
    path = source_file(module)
    if module.partition(".")[0] != PACKAGE or not path.is_file():
        return None
    tree = ast.parse(path.read_text(encoding="utf-8"))
    imports = {
        alias.asname or alias.name: f"{node.module}.{alias.name}"
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)  # as the package imports its own
        for alias in node.names
    }
    found: dict[str, _Definition] = {}
    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            # Called by name: not ``__post_init__``.
            methods = [
                part
                for part in node.body
                if isinstance(part, ast.FunctionDef) and not part.name.startswith("__")
            ]
            for method in methods:
                found.setdefault(f"{node.name}.{method.name}", _Definition()).collect([method])
            own = found.setdefault(node.name, _Definition(methods={m.name for m in methods}))
            own.collect(part for part in ast.iter_child_nodes(node) if part not in methods)
        elif isinstance(node, ast.FunctionDef):
            found.setdefault(node.name, _Definition()).collect([node])
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                for name in (n.id for n in ast.walk(target) if isinstance(n, ast.Name)):
                    found.setdefault(name, _Definition()).collect([node])
    return _Module(imports, found)


def _chain(node: ast.expr) -> tuple[str, ...]:
    if isinstance(node, ast.Name):
        return (node.id,)
    if isinstance(node, ast.Attribute):
        inner = _chain(node.value)
        return (*inner, node.attr) if inner else ()
    return ()
