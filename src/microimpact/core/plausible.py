"""Numbers that are allowed but hardly meant, as a slip of the unit makes them."""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Iterator, Mapping
from functools import partial

from microimpact.core.arrays import FloatArray

# Least and greatest plausible value, the unit, and the unit that it is mistaken for.
PLAUSIBLE = {
    "youngs_modulus": (1e6, 2e12, "Pa", "GPa"),
    "density": (10.0, 30e3, "kg/m3", "g/cm3"),
    "diameter": (1e-9, 5e-3, "m", "um"),
    "work_of_adhesion": (0.0, 20.0, "J/m2", "mJ/m2"),
    "friction": (0.0, 3.0, "", "%"),
    # Of measured impacts, and of what captures a small sphere.
    "normal_speed": (1e-4, 150.0, "m/s", "mm/s"),
    "capture_velocity": (0.0, 10.0, "m/s", "mm/s"),
    # Of incidence: less in radians.
    "angle": (math.pi / 2, 90.0, "degrees", "radians"),
}

# Numbers of a distribution that are values of its quantity, in the unit of its key.
PLACES = {"at", "mean", "median", "low", "high", "edges"}

# Modules whose numbers were checked where they were given.
PASSING_ON = ("microimpact.", "study.")


def implausible(numbers: object, whose: str = "") -> Iterator[str]:
    """Doubts about numbers by name, each in a sentence with the likely slip.

    Parameters
    ----------
    numbers
        SI values, numbers or arrays: fields of a record, or a mapping.
    whose
        Words before the name of a field.
    """
    get = numbers.get if isinstance(numbers, Mapping) else partial(getattr, numbers)
    for name, (low, high, unit, slip) in PLAUSIBLE.items():
        value = get(name, None)
        if value is None:
            continue
        ends = (value,) if isinstance(value, float) else _ends(value)
        doubtful = [end for end in ends if not low <= end <= high]
        if doubtful:
            amount, allowed = f"{doubtful[0]:.3g} {unit}", f"{low:g} to {high:g} {unit}"
            yield f"{whose}{name} = {amount.strip()} is not from {allowed.strip()}: in {slip}?"


def _ends(values: FloatArray) -> tuple[float, ...]:
    return (float(values.min()), float(values.max())) if values.size else ()


def warn_caller(numbers: object, depth: int, whose: str = "") -> None:
    """Warn of implausible numbers, but not where package or study pass them on.

    Parameters
    ----------
    numbers, whose
        As of `implausible`.
    depth
        Frames from here to the caller that chose the numbers.
    """
    for doubt in implausible(numbers, whose):
        caller = sys._getframe(depth)  # noqa: SLF001
        while caller.f_globals.get("__name__") == "dataclasses" and caller.f_back:  # its `replace`
            caller, depth = caller.f_back, depth + 1
        if not str(caller.f_globals.get("__name__")).startswith(PASSING_ON):
            warnings.warn(doubt, UserWarning, stacklevel=depth + 1)
