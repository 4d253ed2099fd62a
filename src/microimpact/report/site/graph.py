"""The rules of the workflow as a graph: what depends on what, and a picture of it in layers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from graphlib import TopologicalSorter

from microimpact.report.site.record import Rule

ROW = 22.0
NODE_HEIGHT = 17.0
CHARACTER = 6.0
GAP = 70.0
SWEEPS = 6


def needs(rules: Sequence[Rule]) -> dict[str, tuple[str, ...]]:
    """Return for each rule the rules that make its inputs, in order."""
    makers = {file: rule.name for rule in rules for file in rule.outputs}
    return {
        rule.name: tuple(dict.fromkeys(makers[file] for file in rule.inputs if file in makers))
        for rule in rules
    }


def users(needed: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
    """Return for each rule the rules that need it."""
    return {name: [other for other in needed if name in needed[other]] for name in needed}


def upstream(name: str, needed: Mapping[str, Sequence[str]]) -> tuple[str, ...]:
    """Return all rules that a rule depends on, the nearest first."""
    found: dict[str, None] = {}
    waiting = list(needed.get(name, ()))
    while waiting:
        rule = waiting.pop(0)
        if rule not in found:
            found[rule] = None
            waiting += needed.get(rule, ())
    return tuple(found)


@dataclass(frozen=True, slots=True, kw_only=True)
class Node:
    """A rule in the picture: words, upper left corner, width, kind (for its colour)."""

    name: str
    words: str
    x: float
    y: float
    width: float
    kind: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Edge:
    """A curve from a rule to one that reads its results."""

    start: str
    end: str
    path: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """Nodes and edges with the size of the whole."""

    nodes: tuple[Node, ...]
    edges: tuple[Edge, ...]
    width: float
    height: float


def picture(needed: Mapping[str, Sequence[str]], figures: Mapping[str, str]) -> Picture:
    """Lay out the rules from left to right, each to the right of all it needs.

    `needed`: the rules that each rule needs; `figures`: the words on each rule that draws a figure;
    these are together in the last layer.
    """
    layers = _ordered(_layers(needed, set(figures)), needed)
    tallest = max((len(layer) for layer in layers), default=0)
    nodes: dict[str, Node] = {}
    x = 0.0
    for layer in layers:
        words = {name: figures.get(name, name) for name in layer}
        width = max(map(len, words.values())) * CHARACTER + 14
        spread = tallest / len(layer)
        for i, name in enumerate(layer):
            y = (i + 0.5) * spread * ROW - NODE_HEIGHT / 2
            kind = "figure" if name in figures else "source" if not needed[name] else "study"
            nodes[name] = Node(
                name=name, words=words[name], x=x, y=round(y, 1), width=round(width, 1), kind=kind
            )
        x = round(x + width + GAP, 1)
    edges = tuple(
        Edge(start=start, end=end, path=_curve(nodes[start], nodes[end]))
        for end in needed
        for start in needed[end]
    )
    return Picture(
        nodes=tuple(nodes.values()), edges=edges, width=max(x - GAP, 0), height=tallest * ROW
    )


def _layers(needed: Mapping[str, Sequence[str]], figures: set[str]) -> list[list[str]]:
    """Return the rules by the longest way to them from one that needs none."""
    sorter = TopologicalSorter({name: needed[name] for name in needed if name not in figures})
    sorter.prepare()
    layers = []
    while ready := sorter.get_ready():
        layers.append([name for name in needed if name in ready])
        sorter.done(*ready)
    drawn = [name for name in needed if name in figures]
    return [*layers, drawn] if drawn else layers


def _ordered(layers: list[list[str]], needed: Mapping[str, Sequence[str]]) -> list[list[str]]:
    """Order each layer by the mean place of a rule's neighbours, so that curves cross less."""
    used = users(needed)
    neighbours = {name: [*needed[name], *used[name]] for name in needed}
    place = {name: (i + 0.5) / len(layer) for layer in layers for i, name in enumerate(layer)}

    def middle(name: str) -> float:
        around = [place[other] for other in neighbours[name]]
        # A rule without neighbours stays at the lower end.
        return sum(around) / len(around) if around else 2.0

    for _ in range(SWEEPS):
        for layer in layers:
            layer.sort(key=middle)
            place |= {name: (i + 0.5) / len(layer) for i, name in enumerate(layer)}
    return layers


def _curve(start: Node, end: Node) -> str:
    x_1, y_1 = start.x + start.width, start.y + NODE_HEIGHT / 2
    x_2, y_2 = end.x, end.y + NODE_HEIGHT / 2
    bend = min(GAP, (x_2 - x_1) / 2)
    return (
        f"M{x_1:.1f} {y_1:.1f}C{x_1 + bend:.1f} {y_1:.1f} {x_2 - bend:.1f} {y_2:.1f} "
        f"{x_2:.1f} {y_2:.1f}"
    )
