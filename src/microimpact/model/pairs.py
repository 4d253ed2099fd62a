"""Declared particle-surface pairs: rows of ``contacts.csv`` to `Contact`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from microimpact.core.materials import (
    ENERGY_PER_AREA,
    FORCE_PER_LENGTH,
    LENGTH,
    NUMBER,
    SLOWNESS,
    SPEED,
    Material,
    Row,
    declared_file,
    find_material,
    quantity,
    read_rows,
)
from microimpact.core.nearest import nearest
from microimpact.model.contact import Contact

UNITS = {
    "diameter": LENGTH,
    "surface_radius": LENGTH,
    "work_of_adhesion": ENERGY_PER_AREA,
    "ring_force": FORCE_PER_LENGTH,
    "hertz_damping": SLOWNESS,
    "adhesion_damping": SLOWNESS,
    "zeta_hertz": NUMBER,
    "zeta_adhesion": NUMBER,
    "friction": NUMBER,
    "adhesion_rate_exponent": NUMBER,
    "reference_velocity": SPEED,
}

Pair = tuple[str, str]
Pairs = Mapping[Pair, Mapping[str, float]]


def pairs_from_rows(rows: Iterable[Row]) -> dict[Pair, dict[str, float]]:
    """Collect the properties of every declared pair, in SI units.

    Raises ValueError if a property is unknown or declared twice, or has a wrong unit or value.
    """
    declared: dict[Pair, dict[str, float]] = {}
    for row in rows:
        pair = row["particle"], row["surface"]
        where = f"contact {pair[0]!r} on {pair[1]!r}"
        properties = declared.setdefault(pair, {})
        if row["property"] in properties:
            raise ValueError(f"{where}: {row['property']} is declared twice")
        properties[row["property"]] = quantity(row, UNITS, where)
    return declared


def declared_pairs() -> dict[Pair, dict[str, float]]:
    """Return the properties of the shipped pairs."""
    columns = ("particle", "surface", "property", "value", "unit")
    return pairs_from_rows(read_rows(declared_file("contacts.csv"), columns))


def pair_contact(
    particle: str, surface: str, materials: Mapping[str, Material], pairs: Pairs, **changes: Any
) -> Contact:
    """Build the contact of two declared materials.

    Parameters
    ----------
    particle, surface
        Names of the materials.
    materials, pairs
        The declared ones.
    **changes
        Fields of `Contact`, or ``zeta_hertz`` and ``zeta_adhesion``, that replace the pair's;
        a None is no change. A pair that is not declared needs its adhesion, damping and diameter.

    Raises
    ------
    ValueError
        If a material is unknown, or the pair is not declared and the changes do not suffice.
    """
    bodies: dict[str, Any] = {
        "particle": find_material(particle, materials),
        "surface": find_material(surface, materials),
    }
    declared = dict(pairs.get((particle, surface), {}))
    replaced = {name: value for name, value in changes.items() if value is not None}
    alternatives = (
        ("work_of_adhesion", "ring_force"),
        ("hertz_damping", "zeta_hertz"),
        ("adhesion_damping", "zeta_adhesion"),
    )
    for names in alternatives:
        if set(names) & set(replaced):
            for name in names:
                declared.pop(name, None)
    fields = declared | replaced
    missing = ["diameter"] if "diameter" not in fields else []
    missing += [names[0] for names in alternatives if not set(names) & set(fields)]
    if missing:
        known = [" on ".join(pair) for pair in pairs if pair == (surface, particle)]
        name = f"{particle} on {surface}"
        state = "is incomplete" if (particle, surface) in pairs else "is not declared"
        near = nearest(name, known) if known else ""
        raise ValueError(f"the pair {name!r} {state}; give {', '.join(missing)}{near}")
    if {"zeta_hertz", "zeta_adhesion"} & set(fields):
        if {"hertz_damping", "adhesion_damping"} & set(fields):
            raise ValueError(
                f"the pair {particle!r} on {surface!r}: give both zetas or both dampings"
            )
        return Contact.from_zeta(**bodies, **fields)
    return Contact(**bodies, **fields)
