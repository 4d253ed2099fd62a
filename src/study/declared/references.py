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
from study.declared.parameters import KIND, Shape, shape
from study.declared.provenance import Declared, as_declared, as_text, is_declaration, problems

FROM, SEED = "from", "seed"
NOTHING = "names nothing"
# Figures in the name of an analysis; one more of them moves no number that it draws.
_FIGURES = re.compile(r"^fig(\d\d_)+")


def merged(old: Any, new: Any) -> Any:
    """Merge changes over a configuration.

    Mappings are merged by name, and a name given as null is taken away; it stays null, to be
    refused as an unknown key, where there is no such name. A value with its provenance and a
    distribution are one value each, replaced as a whole; a reference keeps the place it names
    beside what replaces its value.
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
    if _is_one_value(old):
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


class Resolver:
    """A configuration whose branches refer to values that its sections declare.

    Parameters
    ----------
    config
        The merged configuration.
    shipped
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
        self, config: Mapping[str, Any], shipped: Mapping[str, Any], sections: Collection[str]
    ) -> None:
        self.base = shipped
        self.problems: list[str] = []
        self.rows: list[Declared] = []
        self.aliases: dict[str, str] = {}
        self._laboratory = frozenset(sections)
        self._sections = set(sections)  # All that can be referred to
        self._nodes = {
            str(key): self._parsed(node, shipped.get(key), str(key)) for key, node in config.items()
        }

    def resolved(self, kind: Any, key: str) -> Any:
        """Return the plain values of a top-level key, its references resolved.

        By the type of its parameters: a reference gives the fields that this has.
        """
        return self._plain(shape(kind), self._nodes.get(key), key)

    def declare(self, section: str, names: Mapping[str, Any]) -> None:
        """Add a section of declared tables, by the name that references use."""
        self._nodes[section] = dict(names)
        self._sections.add(section)

    def unused(self) -> list[str]:
        """Return the places of the sections that no resolved value comes from."""
        used = {row.origin.partition("[")[0] for row in self.rows}
        every = {place for name in self._laboratory for place in _places(self._nodes.get(name))}
        return sorted(every - used)

    def _parsed(self, node: Any, base: Any, key: str, *, beside: bool = False) -> Any:
        """Return a node with its values as `Declared` and its references as `_Reference`.

        Parameters
        ----------
        base
            The same node as shipped.
        key
            Dotted key of both.
        beside
            Whether the node stands beside a reference.
        """
        before = base if isinstance(base, Mapping) else {}
        if is_reference(node):
            places = node[FROM] if isinstance(node[FROM], list) else [node[FROM]]
            override, shipped = (
                {name: child for name, child in each.items() if name != FROM}
                for each in (node, before if is_reference(base) else {})
            )
            parsed = self._parsed(override, shipped, key, beside=True) if override else None
            return _Reference(tuple(map(str, places)), parsed, key)
        if is_declaration(node):
            malformed = [f"{key}{line}" for line in problems(node, beside=beside)]
            self.problems += malformed
            return _absent(key) if malformed else as_declared(node, base, key)
        if isinstance(node, Mapping):
            return {
                str(name): self._parsed(child, before.get(name), f"{key}.{name}")
                for name, child in node.items()
            }
        if isinstance(node, list) and any(isinstance(item, Mapping) for item in node):
            items = dict(enumerate(base)) if isinstance(base, list) else {}
            return [self._parsed(c, items.get(i), f"{key}[{i}]") for i, c in enumerate(node)]
        return as_declared(node, base, key)

    def _plain(self, kind: Shape, node: Any, key: str) -> Any:
        """Return the plain values of a node, and record the place of each."""
        if isinstance(node, _Reference):
            node = self._wanted(kind, node, key)
        if isinstance(node, Declared):
            if node.value == [] and kind.is_numbers:
                self.problems.append(f"{node.origin}: [] must hold at least one number")
            self.rows += node.rows(key)
            if node.origin != key:
                self.aliases[key] = node.origin
            return node.value
        if isinstance(node, list):
            return [self._plain(kind.item, item, f"{key}[{i}]") for i, item in enumerate(node)]
        if not isinstance(node, dict):
            return None
        stands = next(_places(node), "").rpartition(".")[0]
        # where one value or a distribution is wanted
        if (kind == Shape() or kind.kinds) and stands not in {"", key}:
            self.aliases[key] = stands
        fields = kind.fields(node.get(KIND))
        if SEED in fields and SEED not in node:
            stream = fields[SEED].stream or _FIGURES.sub("", key.partition(".")[0])
            node = {**node, SEED: self._seed(stream, key)}
        return {
            name: self._plain(fields.get(name, kind.item), child, f"{key}.{name}")
            for name, child in node.items()
        }

    def _seed(self, stream: str, key: str) -> Any:
        """Return the seed of an analysis without its own, from the root seed and a name."""
        root = self._nodes.get(SEED)
        if not isinstance(root, Declared) or not isinstance(root.value, int) or root.value < 0:
            return root or _absent(f"{key}.{SEED}", 0)
        words = np.random.SeedSequence(root.value, spawn_key=(crc32(stream.encode()),))
        value = int(words.generate_state(1)[0])
        source = f"from the root seed, {root.value}, and the name {stream!r}"
        return Declared(value, "derived", source, f"{key}.{SEED}")

    def _wanted(self, kind: Shape, node: _Reference, key: str) -> Any:
        """Return the field of a reference that bears its key, or those that a kind has."""
        base, field = self._named(node), key.rpartition(".")[2]
        if isinstance(base, dict) and field in base:
            base = base[field]
            if isinstance(base, _Reference):
                base = self._wanted(kind, base, key)
        elif isinstance(base, dict):
            fields = kind.fields(base.get(KIND))
            chosen = {name: child for name, child in base.items() if name in fields}
            if not chosen:
                line = f"{node.key}.{FROM}: no {field} in {' or '.join(node.places)}"
                self.problems.append(f"{line}{nearest(field, base)}")
            base = chosen or _absent(node.key)
        return self._overlaid(base, node.beside)

    def _named(self, node: _Reference, opened: tuple[str, ...] = ()) -> Any:
        """Return the target of a reference: several mappings merged, the first goes before."""
        nodes = []
        for path in node.places:
            if path in opened:
                self.problems.append(f"{node.key}.{FROM}: {path!r} refers to itself")
                return _absent(node.key)
            nodes.append(self._at(path, node.key, (*opened, path)))
        if all(isinstance(each, dict) for each in nodes):
            return {name: child for each in reversed(nodes) for name, child in each.items()}
        return next(each for each in nodes if not isinstance(each, dict))

    def _at(self, path: str, key: str, opened: tuple[str, ...]) -> Any:
        """Return the node at a dotted place, references on the way opened; names may hold dots."""
        node: Any = {name: self._nodes[name] for name in self._sections if name in self._nodes}
        rest = path
        while rest:
            known = node if isinstance(node, dict) else {}
            name = max((n for n in known if f"{rest}.".startswith(f"{n}.")), key=len, default=None)
            if name is None:
                near = nearest(rest.partition(".")[0], known)
                self.problems.append(f"{key}.{FROM}: {path!r} is not declared{near}")
                return _absent(key)
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
        if below.source != NOTHING:
            self.problems += [f"{place}: unknown key" for place in _places(above)]
        return below

    def _overriding(self, above: Any, below: Any) -> Any:
        """Record in a value of an analysis the value of the laboratory that it replaces."""
        if isinstance(above, Declared) and above.is_kept and isinstance(below, Declared):
            return replace(above, value=below.value)
        if not isinstance(above, Declared) or above.origin.partition(".")[0] in self._laboratory:
            return above
        if isinstance(below, Declared):
            return replace(above, overrides=f"{below.origin} = {as_text(below.value)}")
        places = below.places if isinstance(below, _Reference) else ()
        entry = ", ".join(places) or next(_places(below), "").rpartition(".")[0]
        return replace(above, overrides=entry)


def _absent(key: str, value: object = None) -> Declared:
    """Return a placeholder for a missing value, which is reported once."""
    return Declared(value, "user", NOTHING, key)


def _places(node: Any) -> Iterator[str]:
    """Yield the place of every value at or below a node."""
    if isinstance(node, Declared):
        yield node.origin
    elif isinstance(node, _Reference):
        yield from _places(node.beside)
    elif isinstance(node, dict | list):
        for child in node.values() if isinstance(node, dict) else node:
            yield from _places(child)
