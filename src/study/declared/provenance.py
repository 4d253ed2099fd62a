"""Declared values: a value together with its evidence class and its source.

In the configuration a number is written as ``{value: 62, evidence: printed, source: "..."}``
(``values:`` for a list). A bare number, as an overlay may give it, is the user's own.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from microimpact.core.nearest import nearest
from microimpact.core.plausible import PLACES

# Classes of declared values, with their meaning.
EVIDENCE = {
    "printed": "given in the article's text",
    "found": "taken from a public source, which is named",
    "textbook": "a handbook value",
    "derived": "follows from printed, found and textbook values",
    "assumed": "unknown, chosen for a stated reason",
    "calibrated": "fitted to a printed or derived target",
    "chosen": "numerical choice without physical content, as a number of points",
    "user": "given by an overlay or on the command line",
}

_WORDS = ("evidence", "source")
_PARTS = ("value", "values", *_WORDS)
# In place of a value: the one that is named, in other words.
KEPT = object()

# Numbers of a distribution that are in the unit of its key.
_OF_DISTRIBUTION = {*PLACES, "sd"}
_SYMBOL = r"(?:um|mm|nm|ms|us|ns|px|counts|kHz|deg|rad|GPa|MPa|Pa|kg|mN|uN|uC|[mgsNJKV])\d?"
_SUFFIX = re.compile(rf"_({_SYMBOL}(?:_per_{_SYMBOL})*|per_s)$")


@dataclass(frozen=True, slots=True)
class Declared:
    """A value with its evidence and source: number, choice, name or list of these."""

    value: Any
    evidence: str
    source: str
    # Dotted key under which it stands; of a value in use, if the analysis names it there.
    origin: str
    # The origin whose value it replaces, and that value, if the analysis departs from it.
    overrides: str = ""
    # Of a value in use: dotted key in the configuration, analysis, then parameter.
    key: str = ""
    # As its table says it; that of a key of the configuration is in its name.
    given_unit: str = ""

    @property
    def unit(self) -> str:
        """Unit of a number in use, by the name of its key, or of its distribution's."""
        number = isinstance(self.value, int | float) and not isinstance(self.value, bool)
        return unit_of(self.key) if number else ""

    def rows(self, key: str) -> Iterator[Declared]:
        """Yield it as used under a key, one row per item of a list."""
        several = isinstance(self.value, list)
        for i, value in enumerate(self.value if several else [self.value]):
            item = f"[{i}]" if several else ""
            origin = "" if self.origin == key else f"{self.origin}{item}"
            yield replace(self, value=value, key=f"{key}{item}", origin=origin)


def is_declaration(node: object) -> bool:
    """Tell whether a node of the configuration is a value with its provenance."""
    # A reference and a distribution may have a key `value`, too.
    if not isinstance(node, Mapping) or "from" in node or "kind" in node:
        return False
    return any(p in node for p in _PARTS)


def plain(node: Any) -> Any:
    """Return the configuration with every declaration replaced by its value."""
    if is_declaration(node):
        return node["value"] if "value" in node else node.get("values")
    if isinstance(node, Mapping):
        return {key: plain(value) for key, value in node.items()}
    if isinstance(node, list | tuple):
        return [plain(value) for value in node]
    return node


def problems(node: Mapping[str, object], *, beside: bool) -> Iterator[str]:
    """Yield the errors of a declaration, each with the part that it concerns.

    Where it stands `beside` a reference to another value, value or words may be left out.
    """
    for name in node:
        if name not in _PARTS:
            yield f".{name}: unknown key{nearest(str(name), _PARTS)}"
    has_value, has_words = ("value" in node) + ("values" in node), any(p in node for p in _WORDS)
    if has_value != 1 and not (beside and not has_value):
        yield ": give either value (one) or values (a list)"
    elif isinstance(node.get("value"), Mapping | list):
        yield f".value: {node['value']!r} must be a single value (a list goes under values)"
    elif "values" in node and not isinstance(node["values"], list):
        yield f".values: {node['values']!r} must be a list"
    if beside and not has_words:
        return
    if node.get("evidence") not in list(EVIDENCE):
        yield f".evidence: {node.get('evidence')!r} must be one of {', '.join(EVIDENCE)}"
    source = node.get("source")
    if not isinstance(source, str) or not source.strip():
        yield f".source: {source!r} must say where the value comes from"


def as_declared(node: Any, base: object, origin: str) -> Declared:
    """Return a well-formed declaration, or a bare value, with its provenance.

    Parameters
    ----------
    base
        The same node as shipped. A value that differs from it while evidence and source were left
        as they stood belongs to the user, and so does a bare number.
    origin
        Dotted key of both.
    """
    value, before = plain(node), plain(base)
    if is_declaration(node) and "evidence" in node:
        words = str(node["evidence"]), str(node["source"])
        left = isinstance(base, Mapping) and words == (base.get("evidence"), base.get("source"))
        if left and before != value:
            words = "user", f"changed from the shipped {before}"
        if "value" not in node and "values" not in node:
            value = KEPT
    elif value == before and not is_declaration(base) and not _has_number(value):
        words = "chosen", "as shipped"
    else:
        words = "user", "given without a source"
    return Declared(value, *words, origin)


def _has_number(value: object) -> bool:
    values = value if isinstance(value, list) else [value]
    return any(isinstance(v, int | float) and not isinstance(v, bool) for v in values)


def unit_of(key: str) -> str:
    """Return the unit in the suffix of a key: ``speed_m_per_s`` gives ``m/s``, else ``-``.

    So does ``speed_m_per_s.mean``, of a distribution.
    """
    above, _, name = re.sub(r"\[\d+\]", "", key).rpartition(".")
    if name in _OF_DISTRIBUTION:
        name = above.rpartition(".")[2]
    suffix = _SUFFIX.search(name)
    if not suffix:
        return "-"
    return suffix[1].replace("_per_", "/").replace("per_", "1/")


def as_text(value: object) -> str:
    """Return a value as in a table: the same for 30 and 30.0."""
    return repr(value).removesuffix(".0") if isinstance(value, float) else str(value)
