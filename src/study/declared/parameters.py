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
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
    with_config,
)
from pydantic_core import CoreSchema, core_schema

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

    names: Mapping[str, tuple[str, Iterable[str]]]  # By sort: where it is declared, and the names
    named: list[tuple[str, str]] = field(default_factory=list)  # Sort and name, in order


@dataclass(frozen=True, slots=True)
class Names:
    """Marks a text that names something declared: ``Annotated[str, Names("cases")]``.

    With the name of another field `beside` it, both together name it: ``one on other``.
    """

    sort: str
    beside: str = ""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Check the name against the declared ones where they are known."""
        return core_schema.with_info_wrap_validator_function(self._checked, handler(source))

    def _checked(self, name: Any, handler: Callable[[Any], str], info: ValidationInfo) -> Any:
        if info.context is None:
            return handler(name)
        where, known = info.context.names[self.sort]
        if not isinstance(name, str):
            likely = nearest(str(name), known)
            raise ValueError(f"{name!r} must be a name that is declared in {where}{likely}")
        name = handler(name)
        if self.beside and self.beside not in info.data:  # refused with a line of its own
            return name
        full = f"{info.data.get(self.beside)} on {name}" if self.beside else name
        if full not in known:
            raise ValueError(f"{full!r} is not declared in {where}{nearest(full, known)}")
        info.context.named.append((self.sort, full))
        return name


_RELATIONS: dict[str, Callable[[Any, Any], bool]] = {
    "above": operator.gt,
    "at least": operator.ge,
    "at most": operator.le,
    "one of": lambda value, allowed: value in allowed,
    "within": lambda value, ends: ends[0] <= value <= ends[1],
}


@dataclass(frozen=True, slots=True)
class Must:
    """Marks a value by another field of the same dataclass, one that is declared before it.

    ``Annotated[Positive, Must("above", "capture_speed_m_per_s")]``; `be` is the relation.
    """

    be: Literal["above", "at least", "at most", "one of", "within"]
    field: str

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Check the value where the other one was not refused."""
        return core_schema.with_info_after_validator_function(self._checked, handler(source))

    def _checked(self, value: Any, info: ValidationInfo) -> Any:
        bound = info.data.get(self.field, value)
        if self.field in info.data and not _RELATIONS[self.be](value, bound):
            raise ValueError(f"{_text(value)} must be {self.be} {self.field}, {_text(bound)}")
        return value


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


@dataclass(frozen=True, slots=True)
class Stream:
    """Marks a seed that several analyses share, where none of them has its own."""

    name: str


Seed = Annotated[int, Field(ge=0, lt=2**63)]
# Experiments are drawn by what they are: the same one gives the same number in every analysis.
ExperimentSeed = Annotated[int, Field(ge=0), Stream("experiments")]

T = TypeVar("T")

# Field that tells which of several dataclasses a mapping stands for.
KIND = "kind"

STRICT = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)


@cache
def adapter(kind: Any) -> TypeAdapter[Any]:
    """Return the strict validator of a dataclass and of the dataclasses nested in it."""
    with_config(STRICT)(kind)
    return TypeAdapter(kind)


@dataclass(frozen=True, slots=True)
class Shape:
    """Form of a type in the files: its dataclasses or its items."""

    classes: tuple[type, ...] = ()
    hint: Any = object  # Of its items, if it holds some
    stream: str = ""  # Name of the random numbers of a seed, if not that of its analysis

    @property
    def item(self) -> Shape:
        """The shape of one item."""
        return shape(self.hint)

    @property
    def is_numbers(self) -> bool:
        """Whether its items are numbers."""
        return getattr(self.hint, "__origin__", self.hint) in {int, float}

    @property
    def kinds(self) -> Mapping[object, Shape]:
        """The dataclasses, if there are several, each by its kind."""
        several = [Shape((each,)) for each in self.classes] if len(self.classes) > 1 else []
        return {
            kind: each for each in several for kind in typing.get_args(each.fields()[KIND].hint)
        }

    def fields(self, kind: object = None) -> Mapping[str, Shape]:
        """Return the shape of every field, of the dataclass of that kind if there are several."""
        if len(self.classes) == 1:
            return _fields(self.classes[0])
        variant = self.kinds.get(getattr(kind, "value", kind))
        return variant.fields() if variant else {}


@cache
def _fields(kind: type) -> dict[str, Shape]:
    hints = typing.get_type_hints(kind, include_extras=True)
    return {name: shape(hint) for name, hint in hints.items()}


@cache
def shape(hint: Any) -> Shape:
    """Return the form of a type in the files."""
    marks: tuple[Any, ...] = ()
    while typing.get_origin(hint) is Annotated:
        marks += hint.__metadata__
        hint = hint.__origin__
    if isinstance(hint, type) and is_dataclass(hint):
        return Shape(classes=(hint,))
    arguments = [a for a in typing.get_args(hint) if a is not Ellipsis and a is not types.NoneType]
    if typing.get_origin(hint) in {typing.Union, types.UnionType}:
        parts = [shape(a) for a in arguments]
        classes = tuple(c for part in parts for c in part.classes)
        return Shape(classes=classes) if classes else parts[0]
    if typing.get_origin(hint) is typing.Literal:
        return Shape(hint=hint)
    stream = next((mark.name for mark in marks if isinstance(mark, Stream)), "")
    return Shape(hint=arguments[-1] if arguments else object, stream=stream)


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
    inner = {item["loc"][:-1] for item in errors}
    return [
        _line(item, kind, key, aliases or {})
        for item in errors
        if item["type"] != "too_short" or item["loc"] not in inner
    ]


def _line(item: Mapping[str, Any], kind: type, key: str, aliases: Mapping[str, str]) -> str:
    here, dotted, written = shape(kind), key, key
    fields: Iterable[str] = ()
    for part in item["loc"]:
        if part in here.kinds:  # which variant the validator took stands in no file
            here = here.kinds[part]
            continue
        if part == "[key]":  # the name of an item itself
            continue
        fields = here.fields()
        here = here.item if isinstance(part, int) else here.fields().get(part, here.item)
        written = dotted + (f"[{part}]" if isinstance(part, int) else f".{part}")
        written = written.removeprefix(".")
        dotted = _file_key(written, aliases)
    if item["type"] in {"extra_forbidden", "unexpected_keyword_argument"}:
        return f"{written}: unknown key{nearest(str(item['loc'][-1]), fields)}"
    if item["type"] in {"missing", "missing_keyword_only_argument", "missing_argument"}:
        return f"{dotted}: missing"
    if item["type"] in {"union_tag_invalid", "union_tag_not_found"}:
        tag = item.get("ctx", {}).get("tag")
        fault = "missing, it" if tag is None else repr(tag)
        where = _file_key(f"{dotted}.{KIND}", aliases)
        return f"{where}: {fault} must be one of {', '.join(map(str, here.kinds))}"
    if item["type"] != "value_error":
        return f"{dotted}: {item['input']!r} {_wanted(item, here)}"
    message = item["msg"].removeprefix("Value error, ")
    name, colon, rest = message.partition(": ")
    if colon and name in here.fields():  # of a field, seen with the others
        return f"{_file_key(f'{dotted}.{name}'.removeprefix('.'), aliases)}: {rest}"
    return f"{dotted}: {message}"


def _file_key(key: str, aliases: Mapping[str, str]) -> str:
    while key in aliases:
        key = aliases[key]
    return key


_LENGTHS = {"too_short": ("at least", "min_length"), "too_long": ("at most", "max_length")}


def _wanted(item: Mapping[str, Any], here: Shape) -> str:
    """Describe the values that are allowed."""
    problem = item["type"]
    if problem in {"tuple_type", "list_type"}:
        return f"must be a list, as [{item['input']}]"
    if problem in _LENGTHS:
        words, bound = _LENGTHS[problem]
        return f"must hold {words} {item['ctx'][bound]}"
    if problem == "string_too_short":
        return "must not be empty"
    if here.kinds:
        return f"must be a mapping with the key {KIND}: {', '.join(map(str, here.kinds))}"
    if here.classes:
        return "must be a mapping"
    wanted = str(item["msg"]).replace("Input should", "must").replace("String should", "must")
    wanted = wanted.replace("an object", "a mapping")
    return f"{wanted}{_hint(item['input'], problem)}"


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
