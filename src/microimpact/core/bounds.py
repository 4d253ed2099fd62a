"""Numbers with bounds, as annotations of fields.

They tell a reader the admissible range, and a validator that knows `annotated_types`, as pydantic
does, to enforce it; it also refuses numbers that are not finite. By themselves they check nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any

from annotated_types import Ge, Gt, Le, Lt, MinLen

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler
    from pydantic_core import CoreSchema

Positive = Annotated[float, Gt(0)]
NonNegative = Annotated[float, Ge(0)]
Fraction = Annotated[float, Ge(0), Le(1)]
OpenShare = Annotated[float, Gt(0), Lt(1)]
AboveOne = Annotated[float, Gt(1)]
AngleDegrees = Annotated[float, Gt(0), Le(90)]
# Of incidence, without the normal one.
ObliqueDegrees = Annotated[float, Gt(0), Lt(90)]
Count = Annotated[int, Ge(1)]
Name = Annotated[str, MinLen(1)]


@dataclass(frozen=True, slots=True)
class ByKind:
    """Marks a union of dataclasses that their field ``kind`` tells apart."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Choose the dataclass by its kind."""
        from pydantic import Field

        return handler(Annotated[source, Field(discriminator="kind")])


@dataclass(frozen=True, slots=True)
class Ascends:
    """Marks a tuple each of whose numbers is above the one before."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Refuse numbers that do not ascend."""
        from pydantic_core import core_schema

        return core_schema.no_info_after_validator_function(_in_order, handler(source))


def _in_order(values: tuple[float, ...]) -> tuple[float, ...]:
    if any(lower >= upper for lower, upper in pairwise(values)):
        numbers = ", ".join(f"{value:g}" for value in values)
        raise ValueError(f"[{numbers}] must ascend")
    return values


Ascending = Ascends()
PositiveRange = Annotated[tuple[Positive, Positive], Ascending]
