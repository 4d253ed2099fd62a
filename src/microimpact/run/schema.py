"""JSON schemas (draft 2020-12) of the configuration, figures, claims and equations.

They are generated from the same dataclasses that check the files, for editors and for readers:

    python -m microimpact.run.schema workflow/schemas

All files of the configuration, and every overlay, have one schema, in which any key may be left
out: whether all is there shows in the merged configuration alone.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from microimpact import studies
from microimpact.core.files import write_file
from microimpact.declared.parameters import KEYED, adapter
from microimpact.declared.provenance import EVIDENCE
from microimpact.declared.references import FROM
from microimpact.figures.registry import FIGURE_NAME, FigureSpec
from microimpact.ledgers.claims.criteria import CLAIM_NAME, DIGITISED, Claim
from microimpact.ledgers.claims.digitised import DigitisedCriteria
from microimpact.ledgers.equations.forms import ERRATA, SYMBOLS
from microimpact.ledgers.equations.records import EQUATION_NAME, Equation
from microimpact.run.config import General
from microimpact.studies.laboratory import Laboratory

DIALECT = "https://json-schema.org/draft/2020-12/schema"
# What fits into a line of a schema stands in one.
WIDTH = 120

Schema = dict[str, Any]


def schemas() -> dict[str, Schema]:
    """Return the schemas by file name."""
    claims = _registry("Claims of the article", CLAIM_NAME, Claim, "id")
    criteria = _without_titles(adapter(DigitisedCriteria).json_schema())
    equations = _registry("Relations of the article", EQUATION_NAME, Equation, "id")
    return {
        "config.schema.json": config_schema(),
        "figures.schema.json": _registry("Figure registry", FIGURE_NAME, FigureSpec, "name"),
        "claims.schema.json": claims
        | {"properties": {DIGITISED: criteria}, "required": [DIGITISED]},
        "equations.schema.json": equations
        | {"properties": {SYMBOLS: {"type": "object"}, ERRATA: {"type": "array"}}},
    }


def config_schema() -> Schema:
    """Return the schema of every file of the configuration, and of every overlay."""
    names = list(studies.homes())
    kinds = [General, Laboratory, *(studies.study(name).Params for name in names)]
    refs, bundle = TypeAdapter.json_schemas(
        [(str(i), "validation", adapter(kind)) for i, kind in enumerate(kinds)]
    )
    objects = _without_titles(bundle["$defs"])
    general, laboratory, *branches = (
        ref["$ref"].rpartition("/")[2]
        for ref in (refs[str(i), "validation"] for i in range(len(kinds)))
    )
    leaves: dict[str, Schema] = {}
    definitions = {name: _object(node, objects, leaves) for name, node in objects.items()}
    tops = [definitions.pop(name)["properties"] for name in (general, laboratory)]
    for top in tops:
        top.pop(FROM)
    references = {
        name: {"$ref": f"#/$defs/{branch}"} for name, branch in zip(names, branches, strict=True)
    }
    return {
        "$schema": DIALECT,
        "title": "Configuration, or an overlay of it",
        "type": "object",
        "additionalProperties": False,
        "properties": tops[0] | tops[1] | references,
        "$defs": _PARTS | leaves | definitions,
    }


_PARTS: Schema = {
    "evidence": {"enum": list(EVIDENCE)},
    "source": {"type": "string", "minLength": 1},
    FROM: {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]},
    "declaration": {
        "type": "object",
        "properties": {
            "value": {"type": ["number", "string", "boolean"]},
            "values": {"type": "array"},
            **{key: {"$ref": f"#/$defs/{key}"} for key in ("evidence", "source", FROM)},
        },
    },
}


def _object(node: Schema, objects: Schema, leaves: dict[str, Schema]) -> Schema:
    """Return the definition of a dataclass as it stands in a file: in part, or by reference."""
    if "properties" not in node:
        return node
    own = {name: _declarable(child, objects, leaves) for name, child in node["properties"].items()}
    reference = {FROM: {"$ref": f"#/$defs/{FROM}"}}
    return {"type": "object", "additionalProperties": False, "properties": own | reference}


def _declarable(node: Schema, objects: Schema, leaves: dict[str, Schema]) -> Schema:
    """Let a value stand bare, with its provenance, or by reference; name what that takes."""
    if "$ref" in node:
        return node
    if node.get("type") == "object":
        item = node.get("additionalProperties")
        if item and (name := node.pop(KEYED, "")):
            objects[item["$ref"].rpartition("/")[2]]["properties"].pop(name, None)
        return (
            {**node, "additionalProperties": _declarable(item, objects, leaves)} if item else node
        )
    members = [each for each in node.get("anyOf", ()) if each != {"type": "null"}]
    if len(members) == 1:
        return _declarable(members[0], objects, leaves)
    name = _name(node)
    part = "values" if node.get("type") == "array" else "value"
    declared = {"$ref": "#/$defs/declaration", "properties": {part: node}}
    if "#/$defs/" in json.dumps(node):
        declared = {"type": "object", "required": [FROM]}
    forms = [node, declared]
    if part == "values" and declared.get("$ref"):  # each item with a provenance of its own
        forms.append({"type": "array", "items": {"$ref": "#/$defs/declaration"}})
    leaves[name] = {"anyOf": forms}
    return {"$ref": f"#/$defs/{name}"}


def _name(node: Schema) -> str:
    """Return a name for a type of values: ``number, exclusiveMinimum 0``."""
    words = {key: value for key, value in node.items() if key != "type"}
    kind = node.get("type", "choice")
    return ", ".join([kind, *(f"{key} {_words(value)}" for key, value in words.items())])


def _words(value: Any) -> str:
    text = json.dumps(value)
    return "".join(c for c in text.replace("#/$defs/", "") if c not in '{}[]"$:/').strip()


def _registry(title: str, pattern: str, kind: type[Any], name: str) -> Schema:
    """Return the schema of a file of named entries, whose names match a pattern."""
    entry = _without_titles(adapter(kind).json_schema())  # type: ignore[arg-type]
    definitions = entry.pop("$defs", {})
    entry["properties"].pop(name)
    entry["required"].remove(name)
    return {
        "$schema": DIALECT,
        "title": title,
        "type": "object",
        "additionalProperties": False,
        "patternProperties": {pattern: entry},
        "$defs": definitions,
    }


def _without_titles(node: Any) -> Any:
    """Leave out what is generated for readers who do not see the docstrings."""
    if isinstance(node, list):
        return [_without_titles(item) for item in node]
    if not isinstance(node, dict):
        return node
    told = {"title", "default", "description"}
    return {
        key: {name: _without_titles(child) for name, child in value.items()}
        if key in {"properties", "$defs"}
        else _without_titles(value)
        for key, value in node.items()
        if key not in told or isinstance(value, dict)
    }


def text(node: Any, indent: int = 0) -> str:
    """Return a schema as it stands in its file: what fits into a line stands in one."""
    line = json.dumps(node)
    if not isinstance(node, dict | list) or (indent and len(line) + indent <= WIDTH):
        return line
    pad = " " * (indent + 1)
    if isinstance(node, list):
        parts, ends = [text(item, indent + 1) for item in node], "[]"
    else:
        parts = [f"{json.dumps(key)}: {text(value, indent + 1)}" for key, value in node.items()]
        ends = "{}"
    inner = f",\n{pad}".join(parts)
    return f"{ends[0]}\n{pad}{inner}\n{' ' * indent}{ends[1]}" + ("" if indent else "\n")


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the schemas into a folder."""
    parser = argparse.ArgumentParser(
        prog="python -m microimpact.run.schema", description=main.__doc__
    )
    parser.add_argument("folder", type=Path, help="where to write them: workflow/schemas")
    folder = parser.parse_args(arguments).folder
    for name, schema in schemas().items():
        write_file(folder / name, text(schema))


if __name__ == "__main__":
    main()
