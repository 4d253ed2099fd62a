"""Units of the declared tables: what each property may be given in, and its SI factor."""

from __future__ import annotations

PRESSURE = {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9}
DENSITY = {"kg/m3": 1.0, "g/cm3": 1e3}
LENGTH = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}
SPEED = {"m/s": 1.0, "mm/s": 1e-3}
ENERGY_PER_AREA = {"J/m2": 1.0, "mJ/m2": 1e-3}
FORCE_PER_LENGTH = {"N/m": 1.0, "mN/m": 1e-3}
SLOWNESS = {"s/m": 1.0}
NUMBER = {"-": 1.0}


def si_factor(unit: str, allowed: dict[str, float], where: str) -> float:
    """Return the factor that turns ``unit`` into SI.

    Raises ValueError if the unit is not one of ``allowed``; the message begins with ``where``.
    """
    if unit not in allowed:
        raise ValueError(f"{where}: unit {unit!r} must be one of {', '.join(allowed)}")
    return allowed[unit]
