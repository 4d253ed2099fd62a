"""References of analyses to declared values: the configuration merged, references resolved.

A mapping with the key ``from`` is a reference to a place of the laboratory, or to several. It
stands for the field of its own name there, or else for those fields that its parameter has.
Further keys beside it replace what is named for this analysis alone, and that is recorded.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any
from zlib import crc32

import numpy as np

from microimpact.core.nearest import nearest
from study.declared.documents import entries
from study.declared.parameters import KIND, bare, classes, fields, item, kinds
from study.declared.provenance import KEPT, Declared, as_declared, as_text, is_declaration, problems

FROM, SEED = "from", "seed"
# Figures in the name of an analysis; one more of them moves no number that it draws.
_FIGURES = re.compile(r"^fig(\d\d_)+")


def merged(old: Any, new: Any) -> Any:
    """Merge changes over a configuration.

    Mappings are merged by name, and a name given as null is taken away; it stays null, to be
    refused as an unknown key, where there is no such name. A value with its provenance is replaced
    as a whole, and so is a distribution by one that states its kind; a reference keeps the place
    it names beside what replaces its value.
    """
    if is_reference(old) and new is not None and not isinstance(new, Mapping):
        return {FROM: old[FROM], "values" if isinstance(new, list) else "value": new}
    if not (isinstance(old, Mapping) and isinstance(new, Mapping)):
        return new
    if _is_one_value(new):
        if is_reference(old):
            return {FROM: old[FROM], **new}
        # A distribution that named a place for one of its numbers still tells it.
        named = old if KIND in new and KIND in old else {}
        return {name: merged(named.get(name), child) for name, child in new.items()}
    if FROM not in old and is_declaration(old):
        return new
    laid = {name: merged(old.get(name), child) for name, child in new.items()}
    every = {**old, **laid}.items()
    return {name: child for name, child in every if child is not None or name not in old}


def is_reference(node: object) -> bool:
    """Tell whether a node of the configuration names a place of the laboratory."""
    return isinstance(node, Mapping) and FROM in node


def _is_one_value(node: Mapping[str, Any]) -> bool:
    return FROM not in node and (KIND in node or is_declaration(node))


@dataclass(frozen=True, slots=True)
class _Reference:
    """Places, the override beside them, and the key of the reference itself."""

    places: tuple[str, ...]
    beside: Any
    key: str


class _FaultyError(ValueError):
    """A reference to nothing, with the key under which it stands."""

    def __init__(self, key: str, line: str) -> None:
        super().__init__(f"{key}.{FROM}: {line}")
        self.key = key


class Resolver:
    """A configuration whose branches refer to values that its sections declare.

    Parameters
    ----------
    config
        The merged configuration.
    base
        As it comes with the project: what differs from it is the user's.
    sections
        Top-level keys that can be referred to.

    Attributes
    ----------
    problems
        One line per malformed declaration, or reference to nothing, found so far.
    rows
        Every value resolved so far, as it is used.
    aliases
        Where a value stands in the files, by its key in the parameters.
    """

    def __init__(
        self, config: Mapping[str, Any], base: Mapping[str, Any], sections: Collection[str]
    ) -> None:
        self.base = base
        self.problems: list[str] = []
        self.rows: list[Declared] = []
        self.aliases: dict[str, str] = {}
        self._nodes = {
            str(k): self._parsed(node, base.get(k), str(k)) for k, node in config.items()
        }
        # All that can be referred to.
        self._shared = {name: self._nodes[name] for name in sections if name in self._nodes}
        self._places = {place for node in self._shared.values() for place in _places(node)}

    def resolved(self, kind: Any, key: str) -> Any:
        """Return the plain values of a top-level key, its references resolved.

        By the type of its parameters: a reference gives the fields that this has.
        """
        return self._plain(kind, self._nodes.get(key), key)

    def declare(self, section: str, names: Mapping[str, Any]) -> None:
        """Add a section of declared tables, by the name that references use."""
        self._shared[section] = dict(names)

    def unused(self) -> list[str]:
        """Return the places of the sections that no resolved value comes from."""
        return sorted(self._places - {row.origin.partition("[")[0] for row in self.rows})

    def _parsed(self, node: Any, base: Any, key: str, *, beside: bool = False) -> Any:
        """Return a node with its values as `Declared` and its references as `_Reference`.

        Its dotted `key`, and the same node as shipped, tell where a value comes from; what stands
        `beside` a reference may give words alone.
        """
        before = entries(base)
        if is_reference(node):
            places = node[FROM] if isinstance(node[FROM], list) else [node[FROM]]
            override = {name: child for name, child in node.items() if name != FROM}
            shipped = {n: c for n, c in before.items() if n != FROM} if FROM in before else {}
            parsed = self._parsed(override, shipped, key, beside=True) if override else None
            return _Reference(tuple(map(str, places)), parsed, key)
        if is_declaration(node):
            malformed = [f"{key}{line}" for line in problems(node, beside=beside)]
            self.problems += malformed
            return Declared(None, "user", "", key) if malformed else as_declared(node, base, key)
        if isinstance(node, Mapping):
            return {
                str(name): self._parsed(child, before.get(name), f"{key}.{name}")
                for name, child in node.items()
            }
        if isinstance(node, list) and any(isinstance(each, Mapping) for each in node):
            items = dict(enumerate(base)) if isinstance(base, list) else {}
            return [self._parsed(c, items.get(i), f"{key}[{i}]") for i, c in enumerate(node)]
        return as_declared(node, base, key)

    def _plain(self, kind: Any, node: Any, key: str) -> Any:
        """Return the plain values of a node, and record the place of each."""
        try:
            node = self._wanted(kind, node, key)
        except _FaultyError as fault:
            self.problems.append(str(fault))
            node = Declared(None, "user", "", fault.key)
        if isinstance(node, Declared):
            if node.value == [] and bare(item(kind)) in {int, float}:
                self.problems.append(f"{node.origin}: [] must hold at least one number")
            self.rows += node.rows(key)
            self._alias(key, node.origin)
            return node.value
        if isinstance(node, list):
            return [self._plain(item(kind), c, f"{key}[{i}]") for i, c in enumerate(node)]
        if not isinstance(node, dict):
            return None
        # where one value or a distribution is wanted
        if kinds(kind) or (item(kind) is object and not classes(kind)):
            self._alias(key, _stands(node))
        known = fields(kind, _tag(node))
        if SEED in known and SEED not in node:
            node = {**node, SEED: self._seed(known[SEED], key)}
        return {
            name: self._plain(known.get(name, item(kind)), child, f"{key}.{name}")
            for name, child in node.items()
        }

    def _alias(self, key: str, target: str) -> None:
        if target not in {"", key}:
            self.aliases[key] = target

    def _seed(self, hint: Any, key: str) -> Any:
        """Return the seed of an analysis without its own, from the root seed and a name."""
        root = self._nodes.get(SEED)
        if not isinstance(root, Declared) or not isinstance(root.value, int) or root.value < 0:
            return root or Declared(0, "user", "", f"{key}.{SEED}")
        marks = (mark for mark in getattr(hint, "__metadata__", ()) if isinstance(mark, str))
        stream = next(marks, _FIGURES.sub("", key.partition(".")[0]))
        words = np.random.SeedSequence(root.value, spawn_key=(crc32(stream.encode()),))
        value = int(words.generate_state(1)[0])
        source = f"from the root seed, {root.value}, and the name {stream!r}"
        return Declared(value, "derived", source, f"{key}.{SEED}")

    def _wanted(self, kind: Any, node: Any, key: str) -> Any:
        """Return the field of a reference that bears its key, or those that a kind has."""
        if not isinstance(node, _Reference):
            return node
        target, field = self._named(node), key.rpartition(".")[2]
        # An entry may name the one that it stands in, for other fields of it.
        if isinstance(target, dict) and target.get(field, node) is not node:
            target = self._wanted(kind, target[field], key)
        elif isinstance(target, dict):
            known = fields(kind, _tag(target))
            chosen = {name: child for name, child in target.items() if name in known}
            if not chosen:
                line = f"no {field} in {' or '.join(node.places)}{nearest(field, target)}"
                raise _FaultyError(node.key, line)
            target = chosen
        return self._overlaid(target, node.beside)

    def _named(self, node: _Reference, opened: tuple[str, ...] = ()) -> Any:
        """Return the target of a reference: several mappings merged, the first goes before."""
        if again := [path for path in node.places if path in opened]:
            raise _FaultyError(node.key, f"{again[0]!r} refers to itself")
        nodes = [self._at(path, node.key, (*opened, path)) for path in node.places]
        if all(isinstance(each, dict) for each in nodes):
            return {name: child for each in reversed(nodes) for name, child in each.items()}
        return next(each for each in nodes if not isinstance(each, dict))

    def _at(self, path: str, key: str, opened: tuple[str, ...]) -> Any:
        """Return the node at a dotted place, references on the way opened; names may hold dots."""
        node, rest = self._shared, path
        while rest:
            known = entries(node)
            name = max((n for n in known if f"{rest}.".startswith(f"{n}.")), key=len, default=None)
            if name is None:
                near = nearest(rest.partition(".")[0], known)
                raise _FaultyError(key, f"{path!r} is not declared{near}")
            node, rest = known[name], rest[len(name) + 1 :]
            if isinstance(node, _Reference):
                node = self._overlaid(self._named(node, opened), node.beside)
        return node

    def _overlaid(self, below: Any, above: Any) -> Any:
        """Merge the keys beside a reference over its target."""
        if above is None or below is None:
            return below if above is None else above
        if not isinstance(above, dict):
            return self._overriding(above, below)
        if KIND in above:  # a distribution is replaced as a whole
            return {name: self._overriding(child, below) for name, child in above.items()}
        if isinstance(below, _Reference):
            return replace(below, beside=self._overlaid(below.beside, above))
        if isinstance(below, dict):
            return below | {n: self._overlaid(below.get(n), child) for n, child in above.items()}
        self.problems += [f"{place}: unknown key" for place in _places(above)]
        return below

    def _overriding(self, above: Any, below: Any) -> Any:
        """Record in a value of an analysis the value of the laboratory that it replaces."""
        if not isinstance(above, Declared):
            return above
        if above.value is KEPT and isinstance(below, Declared):
            return replace(above, value=below.value)
        if above.origin.partition(".")[0] in self._shared:
            return above
        if isinstance(below, Declared):
            return replace(above, overrides=f"{below.origin} = {as_text(below.value)}")
        places = below.places if isinstance(below, _Reference) else ()
        return replace(above, overrides=", ".join(places) or _stands(below))


def _tag(node: Mapping[str, Any]) -> object:
    """Return the kind that a mapping says it is of."""
    tag = node.get(KIND)
    return tag.value if isinstance(tag, Declared) and isinstance(tag.value, str) else None


def _stands(node: Any) -> str:
    """Return the place of a mapping: where its first value stands."""
    return next(_places(node), "").rpartition(".")[0]


def _places(node: Any) -> Iterator[str]:
    """Yield the place of every value at or below a node."""
    if isinstance(node, Declared):
        yield node.origin
    elif isinstance(node, _Reference):
        yield from _places(node.beside)
    elif isinstance(node, dict | list):
        for child in node.values() if isinstance(node, dict) else node:
            yield from _places(child)
