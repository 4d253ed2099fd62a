"""Declared numbers: a value together with its evidence class and its source.

In the configuration a number stands as ``{value: 62, evidence: printed, source: "..."}``
(``values:`` for a list). A bare number, as an overlay may give it, is the user's own.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from microimpact.core.nearest import nearest

EVIDENCE = (
    "printed",  # stands in the article's text
    "found",  # taken from a public source, which is named
    "textbook",  # a handbook value
    "derived",  # follows from the classes above
    "assumed",  # unknown, chosen for a stated reason
    "calibrated",  # fitted to a printed or derived target
    "chosen",  # numerical choice without physical content, as a number of points
    "user",  # given by an overlay or on the command line
)

_PARTS = ("value", "values", "evidence", "source")

_SYMBOL = r"(?:um|mm|nm|ms|us|ns|px|counts|kHz|deg|rad|GPa|MPa|Pa|kg|mN|uN|uC|[mgsNJKV])\d?"
_SUFFIX = re.compile(rf"_({_SYMBOL}(?:_per_{_SYMBOL})*|per_s)$")


@dataclass(frozen=True, slots=True, kw_only=True)
class Declared:
    """One declared value: dotted key, value, unit, evidence class and source."""

    key: str
    value: object
    unit: str
    evidence: str
    source: str


def is_declaration(node: object) -> bool:
    """Tell whether a node of the configuration is a value with its provenance."""
    return isinstance(node, Mapping) and any(part in node for part in _PARTS)


def plain(node: Any) -> Any:
    """Return the configuration with every declaration replaced by its value."""
    if is_declaration(node):
        return plain(node["value"] if "value" in node else node.get("values"))
    if isinstance(node, Mapping):
        return {key: plain(value) for key, value in node.items()}
    if isinstance(node, list | tuple):
        return [plain(value) for value in node]
    return node


def problems(node: object, key: str) -> list[str]:
    """Return one line per badly formed declaration at or below a key."""
    if is_declaration(node):
        assert isinstance(node, Mapping)
        return [f"{key}{line}" for line in _declaration_problems(node)]
    if isinstance(node, Mapping):
        return [line for name, child in node.items() for line in problems(child, f"{key}.{name}")]
    if isinstance(node, list | tuple):
        return [line for i, child in enumerate(node) for line in problems(child, f"{key}[{i}]")]
    return []


def _declaration_problems(node: Mapping[str, object]) -> Iterator[str]:
    for name in node:
        if name not in _PARTS:
            yield f".{name}: unknown key{nearest(str(name), _PARTS)}"
    if ("value" in node) == ("values" in node):
        yield ": give either value (one) or values (a list)"
    elif isinstance(node.get("value"), Mapping | list):
        yield f".value: {node['value']!r} must be a single value (a list goes under values)"
    elif "values" in node and not isinstance(node["values"], list):
        yield f".values: {node['values']!r} must be a list"
    if node.get("evidence") not in EVIDENCE:
        yield f".evidence: {node.get('evidence')!r} must be one of {', '.join(EVIDENCE)}"
    source = node.get("source")
    if not isinstance(source, str) or not source.strip():
        yield f".source: {source!r} must say where the value comes from"


def declared(node: object, base: object, key: str = "") -> Iterator[Declared]:
    """Yield every declared value at or below a key.

    Parameters
    ----------
    node
        The merged configuration (or a part of it).
    base
        The same part of the configuration as shipped. A value that differs from it
        while its evidence and source were left as they stood belongs to the user.
    key
        Dotted key of `node`.

    Yields
    ------
    Declared
        One row per number, and per text that carries a provenance.
    """
    if is_declaration(node):
        assert isinstance(node, Mapping)
        evidence, source = _provenance(node, base)
        yield from _rows(plain(node), key, evidence, source)
    elif isinstance(node, Mapping):
        shipped = base if isinstance(base, Mapping) else {}
        for name, child in node.items():
            yield from declared(child, shipped.get(name), f"{key}.{name}".removeprefix("."))
    elif isinstance(node, list | tuple):
        shipped_list = base if isinstance(base, list) else []
        for i, child in enumerate(node):
            before = shipped_list[i] if i < len(shipped_list) else None
            yield from declared(child, before, f"{key}[{i}]")
    elif isinstance(node, int | float) and not isinstance(node, bool):
        yield from _rows(node, key, "user", "given without a source")


def _provenance(node: Mapping[str, Any], base: object) -> tuple[str, str]:
    evidence, source = str(node["evidence"]), str(node["source"])
    if isinstance(base, Mapping) and is_declaration(base):
        same_words = base.get("evidence") == evidence and base.get("source") == source
        if same_words and plain(base) != plain(node):
            return "user", f"changed from the shipped {plain(base)}"
    return evidence, source


def _rows(value: Any, key: str, evidence: str, source: str) -> Iterator[Declared]:
    if isinstance(value, list):
        for i, item in enumerate(value):
            yield from _rows(item, f"{key}[{i}]", evidence, source)
    else:
        unit = unit_of(key) if isinstance(value, int | float) else ""
        yield Declared(key=key, value=value, unit=unit, evidence=evidence, source=source)


def unit_of(key: str) -> str:
    """Return the unit in the suffix of a key: ``speed_m_per_s`` gives ``m/s``, else ``-``."""
    name = re.sub(r"\[\d+\]", "", key).rpartition(".")[2]
    found = _SUFFIX.search(name)
    if not found:
        return "-"
    return found[1].replace("_per_", "/").replace("per_", "1/")


def as_text(value: object) -> str:
    """Return a value as it stands in a table: the same for 30 and 30.0."""
    return repr(value).removesuffix(".0") if isinstance(value, float) else str(value)


def finite_number(text: str) -> bool:
    """Tell whether a text reads as a finite number."""
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False
