"""Parameters of an analysis: frozen dataclasses with constraints, built from plain values.

A study declares its parameters as a standard dataclass whose annotations carry
the admissible range (``diameter_um: Positive``). `build` turns a mapping of
plain values into an instance, strictly: no unknown key, no missing key, no text
where a number belongs. `explain` turns a failure into one line per key.
"""

from __future__ import annotations

import json
import operator
import types
import typing
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, is_dataclass
from functools import cache
from typing import Annotated, Any, Literal, TypeVar

from pydantic import (
    AfterValidator,
    ConfigDict,
    Field,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
    with_config,
)

from microimpact.core import bounds
from microimpact.core.nearest import nearest

# Floats are finite: STRICT refuses the rest.
Finite = float
AboveOne = bounds.AboveOne
AngleDegrees = bounds.AngleDegrees
Ascending = bounds.Ascending
Count = bounds.Count
Fraction = bounds.Fraction
Name = bounds.Name
NonNegative = bounds.NonNegative
ObliqueDegrees = bounds.ObliqueDegrees
OpenShare = bounds.OpenShare
Positive = bounds.Positive
PositiveRange = bounds.PositiveRange


@dataclass(slots=True)
class Known:
    """Names that references may use, and those used so far."""

    names: dict[str, tuple[str, set[str]]]  # By sort: where it is declared, and the names
    named: list[tuple[str, str]] = field(default_factory=list)  # Sort and name, in order


def Names(sort: str, beside: str = "") -> AfterValidator:
    """Mark a text that names something declared: ``Annotated[str, Names("cases")]``.

    With the name of another field `beside` it, both together name it: ``one on other``.
    """

    def checked(name: str, info: ValidationInfo) -> str:
        # Of a pair whose other name is refused, with a line of its own, nothing can be said.
        if info.context is not None and (not beside or beside in info.data):
            where, known = info.context.names[sort]
            full = f"{info.data[beside]} on {name}" if beside else name
            if full not in known:
                raise ValueError(f"{full!r} is not declared in {where}{nearest(full, known)}")
            info.context.named.append((sort, full))
        return name

    return AfterValidator(checked)


_RELATIONS: dict[str, Callable[[Any, Any], bool]] = {
    "above": operator.gt,
    "at most": operator.le,
    "one of": lambda value, allowed: value in allowed,
    "within": lambda value, ends: ends[0] <= value <= ends[1],
}


def Must(be: Literal["above", "at most", "one of", "within"], field: str) -> AfterValidator:
    """Mark a value by another field of the same dataclass, one that is declared before it.

    ``Annotated[Positive, Must("above", "capture_speed_m_per_s")]``; `be` is the relation.
    """

    def checked(value: Any, info: ValidationInfo) -> Any:
        if field in info.data and not _RELATIONS[be](value, info.data[field]):
            raise ValueError(f"{_text(value)} must be {be} {field}, {_text(info.data[field])}")
        return value

    return AfterValidator(checked)


def _text(value: Any) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(map(_text, value))}]"
    return repr(value) if isinstance(value, str) else f"{value:g}"


# Of a curve.
Points = Annotated[int, Field(ge=5, le=100_000)]
MaterialName = Annotated[Name, Names("materials")]
# The surface of a pair whose adhesion and damping are declared, beside the particle.
CounterpartName = Annotated[Name, Names("contacts", beside="particle"), Names("materials")]
CaseName = Annotated[Name, Names("cases")]
PrintedName = Annotated[Name, Names("printed_values")]
ExternalName = Annotated[Name, Names("external")]
# Of contacts drawn by the inference.
InferredName = Annotated[Name, Names("inference.pairs")]
ScenarioName = Annotated[Name, Names("scenarios")]
LawName = Annotated[Name, Names("laws")]


Seed = Annotated[int, Field(ge=0, lt=2**63)]
# Experiments are drawn by what they are: the same one gives the same number in every analysis. The
# text names the stream that these analyses share, where none of them has a seed of its own.
ExperimentSeed = Annotated[int, Field(ge=0), "experiments"]

T = TypeVar("T")

# Field that tells which of several dataclasses a mapping stands for.
KIND = "kind"

STRICT = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)


@cache
def adapter(kind: Any) -> TypeAdapter[Any]:
    """Return the strict validator of a dataclass and of the dataclasses nested in it."""
    with_config(STRICT)(kind)
    return TypeAdapter(kind)


def bare(hint: Any) -> Any:
    """Return a type without its constraints."""
    return hint.__origin__ if typing.get_origin(hint) is Annotated else hint


def _arguments(hint: Any) -> tuple[list[Any], bool]:
    """Return the types that make up a type, and whether it is a union of these."""
    plain = bare(hint)
    arguments = [a for a in typing.get_args(plain) if a is not Ellipsis and a is not types.NoneType]
    return arguments, typing.get_origin(plain) in {typing.Union, types.UnionType}


@cache
def classes(hint: Any) -> tuple[type, ...]:
    """Return the dataclasses that a type stands for: one, several that a kind tells, or none."""
    arguments, is_union = _arguments(hint)
    if is_union:
        return tuple(found for each in arguments for found in classes(each))
    return (bare(hint),) if is_dataclass(bare(hint)) else ()


@cache
def kinds(hint: Any) -> dict[object, type]:
    """Return the dataclasses, if there are several, each by its kind."""
    several = classes(hint)
    if len(several) < 2:
        return {}
    return {kind: each for each in several for kind in typing.get_args(fields(each)[KIND])}


@cache
def fields(hint: Any, kind: object = None) -> dict[str, Any]:
    """Return the types of the fields, of the dataclass of that kind if there are several."""
    several = classes(hint)
    cls = several[0] if len(several) == 1 else kinds(hint).get(kind)
    return typing.get_type_hints(cls, include_extras=True) if cls else {}


@cache
def item(hint: Any) -> Any:
    """Return the type of the items of a list or mapping; ``object`` if it is neither."""
    arguments, is_union = _arguments(hint)
    if is_union:
        return item(arguments[0])
    return arguments[-1] if arguments else object


def build(kind: type[T], values: Mapping[str, Any], known: Known | None = None) -> T:
    """Build a parameter dataclass from plain values.

    Parameters
    ----------
    values
        Its fields as plain values: numbers, strings, lists, nested mappings.
    known
        Names that can be referred to; without it names are not checked.

    Raises
    ------
    pydantic.ValidationError
        If a key is unknown or missing or a value is not admissible
        (see `explain` for readable lines).
    """
    # JSON is the strict mode in which lists may become tuples and mappings dataclasses.
    text = json.dumps(values, default=str)
    built: T = adapter(kind).validate_json(text, context=known)  # type: ignore[arg-type]
    return built


def explain(
    error: ValidationError, kind: type, key: str, aliases: Mapping[str, str] | None = None
) -> list[str]:
    """Describe a failed `build` in one line per offending key.

    Parameters
    ----------
    key
        Dotted key of the mapping in its file, put before every line.
    aliases
        Where something stands in the files, by its dotted key here.
    """
    errors = error.errors(include_url=False)
    # A list counts as too short without the items that are refused in lines of their own.
    inner = {each["loc"][:-1] for each in errors}
    return [
        _line(each, kind, key, aliases or {})
        for each in errors
        if each["type"] != "too_short" or each["loc"] not in inner
    ]


def _line(error: Mapping[str, Any], kind: Any, key: str, aliases: Mapping[str, str]) -> str:
    here, dotted, written = kind, key, key
    known: Iterable[str] = ()
    for part in error["loc"]:
        if part in kinds(here):  # which variant the validator took stands in no file
            here = kinds(here)[part]
            continue
        if part == "[key]":  # the name of an item itself
            continue
        known = fields(here)
        here = known.get(part, item(here))
        written = dotted + (f"[{part}]" if isinstance(part, int) else f".{part}")
        written = written.removeprefix(".")
        dotted = _file_key(written, aliases)
    if error["type"] in {"extra_forbidden", "unexpected_keyword_argument"}:
        return f"{written}: unknown key{nearest(str(error['loc'][-1]), known)}"
    if error["type"] in {"missing", "missing_keyword_only_argument", "missing_argument"}:
        return f"{dotted}: missing"
    if error["type"] in {"union_tag_invalid", "union_tag_not_found"}:
        tag = error.get("ctx", {}).get("tag")
        fault = "missing, it" if tag is None else repr(tag)
        where = _file_key(f"{dotted}.{KIND}", aliases)
        return f"{where}: {fault} must be one of {', '.join(map(str, kinds(here)))}"
    if error["type"] != "value_error":
        return f"{dotted}: {error['input']!r} {_wanted(error, here)}"
    message = error["msg"].removeprefix("Value error, ")
    name, colon, rest = message.partition(": ")
    if colon and name in fields(here):  # of a field, seen with the others
        return f"{_file_key(f'{dotted}.{name}'.removeprefix('.'), aliases)}: {rest}"
    return f"{dotted}: {message}"


def _file_key(key: str, aliases: Mapping[str, str]) -> str:
    while key in aliases:
        key = aliases[key]
    return key


_LENGTHS = {"too_short": ("at least", "min_length"), "too_long": ("at most", "max_length")}


def _wanted(error: Mapping[str, Any], here: Any) -> str:
    """Describe the values that are allowed."""
    problem = error["type"]
    if problem in {"tuple_type", "list_type"}:
        return f"must be a list, as [{error['input']}]"
    if problem in _LENGTHS:
        words, bound = _LENGTHS[problem]
        return f"must hold {words} {error['ctx'][bound]}"
    if problem == "string_too_short":
        return "must not be empty"
    if kinds(here):
        return f"must be a mapping with the key {KIND}: {', '.join(map(str, kinds(here)))}"
    if classes(here):
        return "must be a mapping"
    wanted = str(error["msg"]).replace("Input should", "must").replace("String should", "must")
    wanted = wanted.replace("an object", "a mapping")
    return f"{wanted}{_hint(error['input'], problem)}"


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
