"""Inputs of a run that are not as shipped, by the studies that rest on them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from study import analyses
from study.declared.selection import IN_STUDIES, TABLES
from study.run.config import Settings

# Keys that say how finely an analysis computes, not what.
SAMPLING = {
    *("seed", "points", "events", "replicates", "samples", "resamples", "draws", "rounds"),
    *("impacts", "simulated", "experiments"),
}


def changed_inputs(used: Settings, shipped: Settings) -> dict[str, dict[str, str]]:
    """Return the inputs of every study, and of those it needs, that differ from the shipped.

    Parameters
    ----------
    used, shipped
        What the configuration of the run, and the shipped one, make of all studies.

    Returns
    -------
    dict
        By study: keys of parameters, as ``pile_up.case``, each with the key under which
        its value is declared. A case of another pair has the keys ``case.particle`` and
        ``case.surface``, too.
    """
    stand = {row.key: row.origin or row.key for row in (*shipped.declared, *used.declared)}
    differing = {
        name: dict([*_parameters(name, used, shipped, stand), *_rows(name, used, shipped)])
        for name in used.branches
    }
    return {
        name: {key: place for each in _resting(name) for key, place in differing[each].items()}
        for name in differing
    }


def of_other_impacts(changed: Mapping[str, Mapping[str, str]]) -> list[str]:
    """Return the analyses of `changed_inputs` that compute something else, not only more finely."""
    return [
        name
        for name, inputs in changed.items()
        if any(key.rpartition(".")[2] not in SAMPLING for key in inputs)
    ]


def _resting(name: str) -> dict[str, None]:
    """Return a study and all that it needs."""
    makers = dict.fromkeys(analyses.needs(name).values())
    return {name: None} | {each: None for maker in makers for each in _resting(maker)}


def _parameters(
    name: str, used: Settings, shipped: Settings, stand: Mapping[str, str]
) -> Iterator[tuple[str, str]]:
    """Yield the keys of a study's parameters that differ, and where each is declared."""
    before, after = (
        dict(_leaves(each.branches[name], name, each.pairs)) for each in (shipped, used)
    )
    for key in dict.fromkeys((*before, *after)):
        if before.get(key) != after.get(key):
            # A list is declared item by item; materials are those of the case above them.
            above = key.rpartition(".")[0]
            places = (stand[k] for k in (key, f"{key}[0]", above, f"{above}[0]") if k in stand)
            yield key, "seed" if key.endswith(".seed") else next(places, key).removesuffix("[0]")


def _leaves(node: Any, key: str, pairs: Mapping[str, tuple[str, str]]) -> Iterator[tuple[str, Any]]:
    """Yield every value below a node with its key; a case with its particle and surface."""
    if isinstance(node, Mapping):
        for name, child in node.items():
            yield from _leaves(child, f"{key}.{name}", pairs)
        return
    yield key, node
    if key.rpartition(".")[2] in {"case", "cases"}:
        several = map(str, node if isinstance(node, list) else [node])
        named = [pairs[name] for name in several if name in pairs]
        for i, body in enumerate(("particle", "surface") if named else ()):
            yield f"{key}.{body}", sorted({pair[i] for pair in named})


def _rows(name: str, used: Settings, shipped: Settings) -> Iterator[tuple[str, str]]:
    """Yield the rows of declared tables that a study is given and that are not as shipped."""
    for table in TABLES:
        as_used, as_shipped = getattr(used.tables, table), getattr(shipped.tables, table)
        if as_used.rows != as_shipped.rows:
            text = used.rows[name].get(IN_STUDIES.get(table, table), "")
            for line in set(text.splitlines()) - set(as_shipped.text().splitlines()):
                yield f"{name}.{table}.{line}", f"{table}.{line.partition(',')[0]}"
