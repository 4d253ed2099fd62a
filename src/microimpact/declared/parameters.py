"""Parameters of an analysis: frozen dataclasses with constraints, built from plain values.

A study declares its parameters as a standard dataclass whose annotations carry
the admissible range (``diameter_um: Positive``). `build` turns a mapping of
plain values into an instance, strictly: no unknown key, no missing key, no text
where a number belongs. `explain` turns a failure into one line per key.
"""

from __future__ import annotations

import json
import types
import typing
from collections.abc import Hashable, Iterable, Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Annotated, Any, TypeVar, cast

from pydantic import ConfigDict, Field, TypeAdapter, ValidationError, with_config

from microimpact.core.nearest import nearest

Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Fraction = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
AngleDegrees = Annotated[float, Field(gt=0, le=90, allow_inf_nan=False)]
Count = Annotated[int, Field(ge=1)]
Name = Annotated[str, Field(min_length=1)]

T = TypeVar("T")

STRICT = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)


def adapter(kind: type[T]) -> TypeAdapter[T]:
    """Return the strict validator of a dataclass and of the dataclasses nested in it."""
    known: TypeAdapter[T] = _adapter(cast(Hashable, kind))
    return known


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    for member in (kind, *nested(kind)):
        with_config(STRICT)(member)
    return TypeAdapter(kind)


def nested(kind: type) -> Iterable[type]:
    """Yield every dataclass that stands, at any depth, in the annotations of another."""
    for hint in typing.get_type_hints(kind).values():
        for found in _dataclasses_in(hint):
            yield found
            yield from nested(found)


def _dataclasses_in(hint: Any) -> Iterable[type]:
    if isinstance(hint, type) and is_dataclass(hint):
        yield hint
    for argument in typing.get_args(hint):
        yield from _dataclasses_in(argument)


def build(kind: type[T], values: Mapping[str, Any]) -> T:
    """Build a parameter dataclass from plain values.

    Parameters
    ----------
    kind
        The dataclass to build.
    values
        Its fields as plain values: numbers, strings, lists, nested mappings.

    Returns
    -------
    object
        An instance of `kind`; lists have become tuples.

    Raises
    ------
    pydantic.ValidationError
        If a key is unknown or missing or a value is not admissible
        (see `explain` for readable lines).
    """
    # JSON is the strict mode in which lists may become tuples and mappings dataclasses.
    return adapter(kind).validate_json(json.dumps(values, default=str))


def explain(error: ValidationError, kind: type, key: str) -> list[str]:
    """Describe a failed `build` in one line per offending key.

    Parameters
    ----------
    error
        What `build` raised.
    kind
        The dataclass that was to be built.
    key
        Dotted key of the mapping in its file, put before every line.
    """
    return [_line(item, kind, key) for item in error.errors(include_url=False)]


def _line(item: Mapping[str, Any], kind: type, key: str) -> str:
    location = _without_tags(kind, item["loc"])
    dotted = key + "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in location)
    dotted = dotted.removeprefix(".")
    if item["type"] in {"extra_forbidden", "unexpected_keyword_argument"}:
        return f"{dotted}: unknown key{nearest(str(location[-1]), _keys(kind, item['loc'][:-1]))}"
    if item["type"] in {"missing", "missing_keyword_only_argument", "missing_argument"}:
        return f"{dotted}: missing"
    wanted = item["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
    if item["type"] == "value_error":
        return f"{dotted}: {wanted}"
    return f"{dotted}: {item['input']!r} {wanted}{_hint(item['input'], item['type'])}"


def _hint(value: object, problem: str) -> str:
    """Explain a number that arrived as text: the commonest mistake."""
    if not isinstance(value, str) or problem not in {"float_type", "int_type"}:
        return ""
    try:
        float(value)
    except ValueError:
        return ""
    return (
        " (it is text: write it without quotes, an exponent as in 1.0e-6 or 1.0e+6, in a file"
        " given by --configfile; nested values on --config always arrive as text)"
    )


def _keys(kind: Any, location: Iterable[str | int]) -> list[str]:
    for part in location:
        kind = _member(kind, part)
    while not (isinstance(kind, type) and is_dataclass(kind)):
        inner = list(_dataclasses_in(kind))
        if not inner:
            return []
        kind = inner[0]
    return [field.name for field in fields(kind)]


def _without_tags(kind: Any, location: Iterable[str | int]) -> list[str | int]:
    """Return a location as it stands in the file: the validator adds which variant it took."""
    parts: list[str | int] = []
    for part in location:
        if _variant(kind, part) is None:
            parts.append(part)
        kind = _member(kind, part)
    return parts


def _variant(kind: Any, tag: str | int) -> type | None:
    """Return the dataclass of a union whose ``kind`` is the tag."""
    if typing.get_origin(kind) not in {typing.Union, types.UnionType}:
        return None
    members = [a for a in typing.get_args(kind) if is_dataclass(a) and isinstance(a, type)]
    kinds = {typing.get_args(typing.get_type_hints(m).get("kind", Name)): m for m in members}
    return kinds.get((tag,))


def _member(kind: Any, part: str | int) -> Any:
    if isinstance(kind, type) and is_dataclass(kind):
        return typing.get_type_hints(kind).get(str(part), object)
    if typing.get_origin(kind) in {typing.Union, types.UnionType}:
        return _variant(kind, part) or kind
    arguments = [a for a in typing.get_args(kind) if a is not Ellipsis]
    return arguments[-1] if arguments else object
