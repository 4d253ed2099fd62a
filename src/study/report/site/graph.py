"""The rules of the workflow as a graph: each with those whose results it reads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from study.report.site.record import Rule


def needs(rules: Sequence[Rule]) -> dict[str, tuple[str, ...]]:
    """Return for each rule the rules that make its inputs, in order."""
    makers = {file: rule.name for rule in rules for file in rule.outputs}
    return {
        rule.name: tuple(dict.fromkeys(makers[file] for file in rule.inputs if file in makers))
        for rule in rules
    }


def upstream(name: str, needed: Mapping[str, Sequence[str]]) -> tuple[str, ...]:
    """Return all rules that a rule depends on, the nearest first."""
    rules: dict[str, None] = {}
    waiting = list(needed.get(name, ()))
    while waiting:
        rule = waiting.pop(0)
        if rule not in rules:
            rules[rule] = None
            waiting += needed.get(rule, ())
    return tuple(rules)
