"""Checked numbers: scalars and arrays that are finite and in range, or one clear error."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from numbers import Integral
from typing import Any, ClassVar, Protocol, Self, cast

import numpy as np
import numpy.typing as npt

from microimpact.core.computable import NotComputable

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
ObjectArray = npt.NDArray[np.object_]
Real = float | FloatArray


class Quantity(Protocol):
    """A number with a unit, as of pint."""

    def to(self, unit: Any, /) -> Any:
        """Return it in another unit."""


# What a user may give for numbers: no text, of which NumPy's ``ArrayLike`` would admit any.
Numbers = float | npt.NDArray[Any] | Sequence[float] | Sequence[Sequence[float]] | Quantity


@dataclass(frozen=True, slots=True)
class Range:
    """An interval of finite numbers; each bound is open unless said to be closed."""

    lower: float = -math.inf
    upper: float = math.inf
    lower_closed: bool = False
    upper_closed: bool = False

    def contains(self, values: Real) -> bool | BoolArray:
        """Tell for each value whether it lies inside."""
        above = values >= self.lower if self.lower_closed else values > self.lower
        below = values <= self.upper if self.upper_closed else values < self.upper
        inside: bool | BoolArray = above & below
        return inside

    def __str__(self) -> str:
        if math.isinf(self.lower) and math.isinf(self.upper):
            return "finite"
        if math.isinf(self.lower):
            return f"finite and {'<=' if self.upper_closed else '<'} {self.upper:g}"
        if math.isinf(self.upper):
            return f"finite and {'>=' if self.lower_closed else '>'} {self.lower:g}"
        left = "[" if self.lower_closed else "("
        right = "]" if self.upper_closed else ")"
        return f"in {left}{self.lower:g}, {self.upper:g}{right}"


class Columns:
    """Base of dataclasses whose fields are arrays alike in their first axis, as of n events."""

    __slots__ = ()
    __dataclass_fields__: ClassVar[dict[str, Any]]

    def __len__(self) -> int:
        return len(getattr(self, next(iter(self.__dataclass_fields__))))

    def select(self, which: slice | npt.NDArray[np.integer] | BoolArray | tuple[Any, ...]) -> Self:
        """Return some of the events, all in another order, or as several axes are indexed."""
        return type(self)(**{k: getattr(self, k)[which] for k in self.__dataclass_fields__})

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """Return the events of one or more parts in one."""
        names = cls.__dataclass_fields__
        return cls(**{k: np.concatenate([getattr(part, k) for part in parts]) for k in names})


FINITE = Range()
POSITIVE = Range(lower=0.0)
NON_NEGATIVE = Range(lower=0.0, lower_closed=True)


def checked(name: str, value: object, allowed: Range = FINITE) -> Real:
    """Return ``value`` as a float or a read-only float array.

    Parameters
    ----------
    value
        A real number or an array of them, any shape; a quantity with a unit, as of pint, is
        converted.

    Raises
    ------
    TypeError
        If ``value`` does not hold real numbers (text, booleans, None, complex), or its unit does
        not measure what the name says.
    ValueError
        If a number is masked, not finite or not in range.
    """
    if isinstance(value, float) and math.isfinite(value) and allowed.contains(value):
        return float(value)  # most often, and unchanged
    if hasattr(value, "magnitude") and hasattr(value, "to"):
        value = _plain(name, value)
    if np.ma.is_masked(value):
        raise ValueError(f"{name} must have no masked values; drop them or fill them first")
    try:
        array = np.asarray(value)
    except ValueError:
        array = np.asarray(None)
    if array.dtype.kind == "O" and all(type(number) is int for number in array.flat):
        # Whole numbers beyond 64 bits, or even beyond double precision.
        array = np.array([_as_float(number) for number in array.flat]).reshape(array.shape)
    if array.dtype.kind not in "iuf":
        raise TypeError(f"{name} must be a real number or an array of them, got {value!r}")
    with np.errstate(over="ignore"):
        array = array.astype(np.float64)
    # NaN is least and greatest wherever it stands.
    ends = np.array([array.min(), array.max()]) if array.size else array
    if not np.all(np.isfinite(ends) & allowed.contains(ends)):
        good = np.isfinite(array) & allowed.contains(array)
        first = np.argwhere(~good)[0]
        where = f" at index {', '.join(map(str, first))}" if array.ndim else ""
        shortest = repr(float(array[tuple(first)])).removesuffix(".0")
        raise NotComputable(f"{name} must be {_finite(allowed)}, got {shortest}{where}")
    if array.ndim == 0:
        return float(array)
    array.setflags(write=False)
    return array


def _as_float(number: int) -> float:
    try:
        return float(number)
    except OverflowError:
        return math.inf


def whole(name: str, value: object, least: int) -> int:
    """Return ``value`` as an integer.

    Raises
    ------
    TypeError, ValueError
        If it is no whole number, or below ``least``.
    """
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise TypeError(f"{name} must be a whole number, got {value!r}")
    if value < least:
        raise ValueError(f"{name} must be at least {least}, got {value}")
    return int(value)


# Units of arguments and outcomes that have one; angles are degrees, as everywhere.
_UNITS = {
    "m": (
        *("diameter", "radius", "surface_radius", "partner_diameter", "equivalent_radius"),
        *("compression", "maximum_compression"),
    ),
    "m/s": (
        *("v", "v_n", "v_t", "v_c", "speed", "velocity", "reference_velocity", "slowest"),
        *("fastest", "high_speed", "capture_speed", "k", "kappa"),
        *("normal_velocity", "tangential_velocity", "slip", "law.edge_speed"),
    ),
    "rad/s": ("omega", "spin", "partner_spin"),
    "degree": ("angle", "tilt"),
    "Pa": ("youngs_modulus", "law.yield_pressure"),
    "kg/m**3": ("density",),
    "J/m**2": ("work_of_adhesion", "law.unloading_work"),
    "N/m": ("ring_force",),
    "s/m": ("hertz_damping", "adhesion_damping"),
    "s": ("time", "contact_time", "law.viscous_time"),
    "N": (
        *("hertz_force", "hertz_damping_force", "adhesion_force", "adhesion_damping_force"),
        *("normal_force", "friction_force"),
    ),
}
UNIT_OF = {name: unit for unit, names in _UNITS.items() for name in names}


def _plain(name: str, quantity: Any) -> Any:
    """Return the number of a quantity in the unit of the argument."""
    unit = UNIT_OF.get(name, "")
    try:
        return quantity.to(unit).magnitude
    except (TypeError, ValueError) as error:  # of whatever package made the quantity
        raise TypeError(f"{name} must be in {unit or 'plain numbers'}, got {quantity}") from error


def _finite(allowed: Range) -> str:
    text = str(allowed)
    return text if text.startswith("finite") else f"finite and {text}"


def part_of(record: Any, index: Any) -> Any:
    """Return the part of an array, or of all arrays of a dataclass, at places of the last axis.

    What is no array stays as it is.
    """
    if is_dataclass(record):
        parts = {f.name: part_of(getattr(record, f.name), index) for f in fields(record)}
        return replace(cast("Any", record), **parts)
    return record[..., index][()] if np.ndim(record) else record


def common_shape(named: Mapping[str, object]) -> tuple[int, ...]:
    """Return the broadcast shape of named numbers or arrays.

    Raises ValueError if the shapes do not broadcast; the message gives each name with its shape.
    """
    shapes = {
        name: np.shape(value)  # type: ignore[call-overload]
        for name, value in named.items()
        if not isinstance(value, float)
    }
    if not shapes:
        return ()
    try:
        return np.broadcast_shapes(*filter(None, shapes.values()))
    except ValueError:
        listed = ", ".join(f"{name} {shape}" for name, shape in shapes.items() if shape)
        raise ValueError(f"shapes do not broadcast: {listed}") from None


def choice(name: str, value: object, allowed: tuple[str, ...]) -> str:
    """Return ``value`` if it is one of ``allowed``.

    Parameters
    ----------
    name
        Argument that is checked.
    value
        What was given.
    allowed
        Words among which it must be.

    Raises
    ------
    TypeError, ValueError
        If it is not text, or another word.
    """
    if not isinstance(value, str):
        raise TypeError(f"{name} must be one of {', '.join(map(repr, allowed))}, got {value!r}")
    if value not in allowed:
        raise ValueError(f"{name} must be one of {', '.join(map(repr, allowed))}, got {value!r}")
    return value
