"""Table of every declared number with its unit, evidence class and source."""

from __future__ import annotations

from dataclasses import dataclass

import pandas as pd

from study.tables import Tables

WHOLE_TABLES = ("declared", "materials", "contacts", "printed_values", "external")
COLUMNS = [
    *("file", "key", "value", "low", "high", "unit", "evidence", "source"),
    *("origin", "overrides"),
]


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """No parameter: the table shows the inputs of all other analyses."""


def run(params: Params, inputs: Tables) -> Tables:
    """Return the table of declared inputs.

    ``inputs``: columns file, key, value, low, high, unit, evidence, source.

    Parameters
    ----------
    params
        Not used.
    inputs
        ``declared``: rows of the merged configuration (key, value, unit, evidence, source);
        ``materials``, ``contacts``, ``printed_values``, ``external``: the declared tables in full.
    """
    printed, materials, contacts, external = (
        inputs[name].copy() for name in ("printed_values", "materials", "contacts", "external")
    )
    names = external[["name", "quantity", "reading", "at"]].to_numpy()
    external["key"] = [".".join(_text(v) for v in row if pd.notna(v)) for row in names]
    materials["key"] = materials["material"] + "." + materials["property"]
    contacts["key"] = (
        contacts["particle"] + " on " + contacts["surface"] + "." + contacts["property"]
    )
    printed["evidence"] = "printed"
    printed["source"] = printed["where"]
    parts = {
        "config": inputs["declared"],
        "materials": materials,
        "contacts": contacts,
        "printed_values": printed,
        "external": external,
    }
    rows = [part.assign(file=name).reindex(columns=COLUMNS) for name, part in parts.items()]
    table = pd.concat([row.astype(object) for row in rows], ignore_index=True)
    for column in ("value", "low", "high"):
        table[column] = pd.Series([_whole(v) for v in table[column]], dtype=object)
    return {"inputs": table}


def _text(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _whole(value: object) -> object:
    """Return a whole number without a point, all else as it is."""
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return int(value)
    return value
