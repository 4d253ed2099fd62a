"""JSON schemas (draft 2020-12) of configuration, overlays, figure registry and claims.

They are generated from the same dataclasses that check the files, for editors and for readers:

    python -m microimpact.run.schema workflow/schemas
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from microimpact import studies
from microimpact.core.files import write_file
from microimpact.declared.parameters import adapter
from microimpact.declared.provenance import EVIDENCE
from microimpact.figures.registry import FIGURE_NAME, FigureSpec
from microimpact.ledgers.claims.criteria import CLAIM_NAME, DIGITISED, Claim
from microimpact.ledgers.claims.digitised import DigitisedCriteria
from microimpact.run.config import General

DIALECT = "https://json-schema.org/draft/2020-12/schema"

# How a schema says that one of several things may stand somewhere.
UNIONS = ("anyOf", "oneOf")

Schema = dict[str, Any]


def schemas() -> dict[str, Schema]:
    """Return the schemas by file name."""
    return {
        "config.schema.json": config_schema(complete=True),
        "overlay.schema.json": config_schema(complete=False),
        "figures.schema.json": figures_schema(),
        "claims.schema.json": claims_schema(),
    }


def config_schema(*, complete: bool) -> Schema:
    """Return the schema of a configuration.

    Parameters
    ----------
    complete
        If false, that of an overlay, in which any key may be left out.
    """
    names = list(studies.homes())
    kinds: list[tuple[str, TypeAdapter[Any]]] = [("", adapter(General))]
    kinds += [(name, adapter(studies.study(name).Params)) for name in names]
    refs, bundle = TypeAdapter.json_schemas([(key, "validation", kind) for key, kind in kinds])
    definitions = bundle.get("$defs", {})
    branches = {key: _resolved(refs[key, "validation"], definitions) for key, _ in kinds}
    top = branches.pop("")
    schema = {
        "$schema": DIALECT,
        "title": "Configuration" if complete else "Overlay of the configuration",
        "type": "object",
        "additionalProperties": False,
        "properties": _declarable(top, complete)["properties"]
        | {name: _declarable(branch, complete) for name, branch in branches.items()},
    }
    if complete:
        schema["required"] = [*top.get("required", []), *names]
    definitions = {
        "evidence": {"enum": list(EVIDENCE)},
        "source": {"type": "string", "minLength": 1},
    }
    return _shortened(schema, definitions)


def figures_schema() -> Schema:
    """Return the schema of the figure registry."""
    entry = adapter(FigureSpec).json_schema()
    definitions = entry.pop("$defs", {})
    entry = _resolved(entry, definitions)
    entry["properties"].pop("name")
    entry["required"].remove("name")
    return {
        "$schema": DIALECT,
        "title": "Figure registry",
        "type": "object",
        "additionalProperties": False,
        "patternProperties": {FIGURE_NAME: entry},
    }


def claims_schema() -> Schema:
    """Return the schema of the file of claims."""
    entry = adapter(Claim).json_schema()
    definitions = entry.pop("$defs", {})
    entry = _resolved(entry, definitions)
    entry["properties"].pop("id")
    entry["required"].remove("id")
    return {
        "$schema": DIALECT,
        "title": "Claims of the article",
        "type": "object",
        "additionalProperties": False,
        "required": [DIGITISED],
        "properties": {DIGITISED: _resolved(adapter(DigitisedCriteria).json_schema(), {})},
        "patternProperties": {CLAIM_NAME: entry},
    }


def _resolved(node: Any, definitions: Schema) -> Any:
    """Replace references by what they refer to; leave out generated titles and defaults."""
    if isinstance(node, list):
        return [_resolved(item, definitions) for item in node]
    if not isinstance(node, dict):
        return node
    if "$ref" in node:
        return _resolved(definitions[node["$ref"].rpartition("/")[2]], definitions)
    resolved = {}
    for key, value in node.items():
        if key == "properties":
            resolved[key] = {name: _resolved(v, definitions) for name, v in value.items()}
        elif key not in {"title", "default"}:
            resolved[key] = _resolved(value, definitions)
    return resolved


def _declarable(node: Schema, complete: bool) -> Schema:
    """Let every number or choice below an object stand bare or with its provenance."""
    for union in UNIONS:
        if union in node and _structured(node):
            return {**node, union: [_declarable(member, complete) for member in node[union]]}
    if node.get("type") == "object" and "properties" in node:
        inner = {name: _declarable(v, complete) for name, v in node["properties"].items()}
        node = {**node, "properties": inner}
        if not complete:
            node.pop("required", None)
        return node
    if _structured(node.get("items", {})):
        return {**node, "items": _declarable(node["items"], complete)}
    if node.get("type") == "string" and "enum" not in node:
        return node
    return {"anyOf": [node, _declaration(node, complete)]}


def _structured(node: Schema) -> bool:
    """Tell whether an object with keys of its own may stand there."""
    return "properties" in node or any(
        _structured(member) for union in UNIONS for member in node.get(union, [])
    )


def _shortened(schema: Schema, definitions: Schema) -> Schema:
    """Name what stands more than once among the definitions, and refer to it."""
    seen: Counter[str] = Counter()
    first: dict[str, Schema] = {}

    def count(node: Any) -> None:
        if isinstance(node, dict) and "properties" in node:
            text = json.dumps(node)
            seen[text] += 1
            first.setdefault(text, node)
            if seen[text] > 1:
                return
        for child in _children(node):
            count(child)

    def referring(node: Any, *, itself: bool = False) -> Any:
        if isinstance(node, list):
            return [referring(child) for child in node]
        if not isinstance(node, dict):
            return node
        name = None if itself else names.get(json.dumps(node))
        if name:
            return {"$ref": f"#/$defs/{name}"}
        return {key: referring(child) for key, child in node.items()}

    count(schema)
    repeated = [text for text in first if seen[text] > 1]
    names = {text: f"part_{number}" for number, text in enumerate(repeated, 1)}
    parts = {names[text]: referring(first[text], itself=True) for text in repeated}
    shortened: Schema = referring(schema, itself=True) | {"$defs": definitions | parts}
    return shortened


def _children(node: Any) -> list[Any]:
    if isinstance(node, dict):
        return list(node.values())
    return node if isinstance(node, list) else []


def _declaration(node: Schema, complete: bool) -> Schema:
    part = "values" if node.get("type") == "array" else "value"
    schema: Schema = {
        "type": "object",
        "additionalProperties": False,
        "properties": {
            part: node,
            "evidence": {"$ref": "#/$defs/evidence"},
            "source": {"$ref": "#/$defs/source"},
        },
    }
    if complete:
        schema["required"] = [part, "evidence", "source"]
    return schema


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the schemas into a folder."""
    parser = argparse.ArgumentParser(
        prog="python -m microimpact.run.schema", description=main.__doc__
    )
    parser.add_argument("folder", type=Path, help="where to write them: workflow/schemas")
    folder = parser.parse_args(arguments).folder
    for name, schema in schemas().items():
        write_file(folder / name, text(schema))


def text(schema: Schema) -> str:
    """Return a schema as it stands in its file."""
    return json.dumps(schema, indent=2) + "\n"


if __name__ == "__main__":
    main()
