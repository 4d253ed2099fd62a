"""The contact that a study's parameters name, from the declared rows handed to it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import pandas as pd

from microimpact.core.arrays import Real
from microimpact.core.materials import Material, materials_from_rows
from microimpact.core.nearest import nearest
from microimpact.model.contact import Contact, resized
from microimpact.model.contact_laws import (
    JKR,
    PARAMETERS,
    ContactLaw,
    Hysteresis,
    MaugisBarquins,
    ThorntonNing,
)
from microimpact.model.pairs import Pairs, pair_contact, pairs_from_rows
from study.declared.parameters import InferredName, LawName, ScenarioName
from study.declared.selection import IMPACT
from study.tables import NOT_COMPUTED, NotComputedError, Tables

# Columns of drawn contacts with a ring force, and the fields of a contact that they are.
DRAWN = {
    "diameter_um": "diameter",
    "work_of_adhesion_J_per_m2": "work_of_adhesion",
    "hertz_damping_s_per_m": "hertz_damping",
    "adhesion_damping_s_per_m": "adhesion_damping",
    "rate_exponent": "adhesion_rate_exponent",
    "reference_velocity_m_per_s": "reference_velocity",
    "friction": "friction",
}


# Laws of contact.
Kind = Literal["ring force", "jkr", "thornton-ning", "hysteresis", "maugis-barquins"]
# Printed numbers have two or three digits.
DIGITS = 0.01
CAPTURE_VELOCITIES = (
    "capture_velocity_psl_quartz",
    "capture_velocity_af_molybdenum",
    "capture_velocity_af_mica",
    "capture_velocity_sst_silicon",
)


def printed_values_for(inputs: Tables, *pair: str, **impact: float) -> pd.DataFrame:
    """Return the printed values that are of an impact, by key.

    Parameters
    ----------
    inputs
        ``printed``: rows of the printed values, each with the impact that it is of.
    *pair
        Materials of particle and surface.
    **impact
        ``diameter_um``, ``speed_m_per_s``, ``angle_deg``.

    Returns
    -------
    pandas.DataFrame
        Rows whose cells are empty or name this impact; a cell that is not asked for counts as
        empty. ``value``, ``low`` and ``high`` are numbers.
    """
    rows = inputs["printed"].set_index("key")
    rows[["value", "low", "high"]] = rows[["value", "low", "high"]].astype(float)
    cells = rows[list(IMPACT)].astype(object).fillna("").astype(str)
    quantities: dict[str, str | float] = {**dict(zip(IMPACT, pair, strict=False)), **impact}
    for column, quantity in quantities.items():
        cells = cells[
            cells[column].map(lambda cell, q=quantity: cell_matches(cell, q)).astype(bool)
        ]
    return rows.loc[cells.index]


def intervals(cell: Any) -> list[tuple[float, ...]]:
    """Return the numbers, and pairs of ends, in a cell like ``49; 62`` or ``85 to 15``."""
    parts = [] if pd.isna(cell) else str(cell).split("; ")
    return [tuple(map(float, part.split(" to "))) for part in parts]


def cell_matches(cell: str, quantity: str | float) -> bool:
    """Return whether a cell is empty, or holds a name, or a number within its `DIGITS`."""
    if not cell or isinstance(quantity, str):
        return not cell or quantity in cell.split("; ")
    low, high = quantity / (1 + DIGITS), quantity * (1 + DIGITS)
    return any(min(ends) <= high and max(ends) >= low for ends in intervals(cell))


def all_printed(inputs: Tables) -> pd.Series:
    """Return the printed values that a study reads, by key."""
    return printed_values_for(inputs)["value"]


def printed_capture_velocity(inputs: Tables, contact: Contact) -> float:
    """Return the capture velocity (m/s) printed of a contact, nan if there is none."""
    pair, diameter = (contact.particle.name, contact.surface.name), 1e6 * float(contact.diameter)
    values = printed_values_for(inputs, *pair, diameter_um=diameter)["value"]
    values = values[values.index.isin(CAPTURE_VELOCITIES)]
    return float(values.iloc[0]) if len(values) else np.nan


def fitted_to(inputs: Tables, case: str, quantity: str) -> bool:
    """Return whether a case was calibrated to a quantity: a target of the table ``calibration``."""
    table = inputs["calibration"]
    rows = table[(table["case"] == case) & (table["role"] == "target")]
    return quantity in set(rows["quantity"])


# Contacts by every law of the inference together, each law with its weight.
ALL_LAWS = "all laws"


@dataclass(frozen=True, slots=True, kw_only=True)
class Posterior:
    """Contacts drawn from a posterior: those of a case, scenario and law of the inference."""

    case: InferredName
    scenario: ScenarioName
    law: LawName


def posterior_rows(inputs: Tables, case: str, scenario: str, law: str = "") -> pd.DataFrame:
    """Return the rows of ``posterior_contacts`` of a case and scenario, of one law or of all.

    Raises ValueError if there are none; the message names the nearest.
    """
    table = inputs["posterior_contacts"]
    for column, name in {"case": case, "scenario": scenario, "law": law}.items():
        if name and name not in set(table[column]):
            raise ValueError(f"no contacts of {column} {name!r}{nearest(name, set(table[column]))}")
        table = table[table[column] == name] if name else table
    return table


def solved_contacts(inputs: Tables, cases: Iterable[str]) -> dict[str, Contact]:
    """Return the contacts of those cases whose calibration has a solution."""
    contacts = {}
    for case in cases:
        with suppress(NotComputedError):
            contacts[case] = calibrated_contact(inputs, case)
    return contacts


def posterior_contact(inputs: Tables, rows: pd.DataFrame) -> Contact:
    """Return contacts of one law, rows of ``posterior_contacts``, as one of arrays (draws,)."""
    of_ring: dict[str, Any] = {field: rows[name].to_numpy(float) for name, field in DRAWN.items()}
    of_ring["diameter"] = of_ring["diameter"] * 1e-6
    kind = rows["contact_law"].iloc[0]
    if kind != "ring force":
        of_ring |= dict.fromkeys(("hertz_damping", "adhesion_damping"), 0.0)
        of_ring["adhesion_rate_exponent"] = 0.0
    contact = _of_rows(inputs, rows, of_ring)
    if kind != "ring force":
        numbers = rows.dropna(axis=1).select_dtypes("number")
        contact = of_kind(contact, kind, {str(name): numbers[name].to_numpy() for name in numbers})
    return contact


def posterior_contacts_at(
    inputs: Tables, posterior: Posterior, case: str, diameter: float
) -> dict[str, Contact]:
    """Return the contacts of a posterior at a diameter (m), none if they are of another pair.

    Parameters
    ----------
    inputs
        Tables of `calibrated_contact` and `posterior_rows`.
    posterior, case
        The contacts, and the case beside which they are shown.

    Returns
    -------
    dict
        One contact of arrays for each normal force in Coulomb's law that some were drawn with.
    """
    rows = posterior_rows(inputs, posterior.case, posterior.scenario, posterior.law)
    if pair_of({"calibration": rows}, posterior.case) != pair_of(inputs, case):
        return {}
    contacts = {}
    for basis, draws in rows.groupby("friction_basis"):
        contacts[str(basis)] = resized(posterior_contact(inputs, draws), diameter)
    return contacts


def pair_of(inputs: Tables, case: str) -> tuple[str, str]:
    """Return the particle and the surface of a case, as `calibrated_contact` takes it."""
    table = inputs["calibration"]
    rows = table[table["case"] == case]
    if rows.empty:
        particle, _, surface = case.partition(" on ")
        return particle, surface
    return str(rows["particle"].iloc[0]), str(rows["surface"].iloc[0])


def declared_contact(inputs: Tables, particle: str, surface: str, **changes: Any) -> Contact:
    """Return the contact of a declared pair.

    Parameters
    ----------
    inputs
        ``materials`` and ``contacts``, declared rows as tables.
    particle, surface
        Names of the materials.
    **changes
        Fields of `Contact` in place of the declared ones.
    """
    return pair_contact(particle, surface, *declared(inputs), **changes)


def calibrated_contact(inputs: Tables, case: str, **changes: Any) -> Contact:
    """Return the contact of a case: a calibrated one, or a declared pair, as ``glass on silicon``.

    Parameters
    ----------
    inputs
        ``calibration``, the table of that study, and ``materials``, declared rows;
        ``contacts``, if the case is a declared pair.
    case
        Name of the case.
    **changes
        Fields of `Contact` in place of those of the case.

    Raises
    ------
    ValueError
        If there is no such case; the message names the nearest.
    NotComputedError
        If its calibration has no solution.
    """
    table = inputs["calibration"]
    rows = table[table["case"] == case]
    if NOT_COMPUTED in set(rows["role"]):
        raise NotComputedError(rows["problem"].iloc[0])
    rows = rows[rows["role"] == "parameter"]
    if rows.empty and "contacts" in inputs and " on " in case:
        return declared_contact(inputs, *case.split(" on "), **changes)
    if rows.empty:
        raise ValueError(f"no calibrated case {case!r}{nearest(case, set(table['case']))}")
    fields: dict[str, Any] = dict(zip(rows["quantity"], rows["value"].astype(float), strict=True))
    for name in PARAMETERS.keys() & fields.keys():
        fields["law"] = PARAMETERS[name](**{name: fields.pop(name)})
    return _of_rows(inputs, rows, fields).replace(**changes)


def of_kind(bare: Contact, kind: Kind, parameters: Mapping[str, Real]) -> Contact:
    """Return the contact of a law; parameters that are not named are as in the bare one.

    Parameters
    ----------
    bare
        The bodies.
    kind
        The law.
    parameters
        Numbers or arrays by their names in tables, with units.
    """
    if kind == "ring force":
        return bare.replace(**{DRAWN[name]: value for name, value in parameters.items()})
    work = parameters["work_of_adhesion_J_per_m2"]
    law: ContactLaw
    if kind == "jkr":
        law = JKR(viscous_time=parameters["viscous_time_ns"] * 1e-9)
    elif kind == "maugis-barquins":
        law = MaugisBarquins(
            edge_speed=parameters["edge_speed_m_per_s"],
            edge_exponent=parameters["edge_exponent"],
            viscous_time=parameters["viscous_time_ns"] * 1e-9,
        )
    elif kind == "thornton-ning":
        law = ThorntonNing(yield_pressure=parameters["yield_pressure_GPa"] * 1e9)
    else:
        law = Hysteresis(unloading_work=work * parameters["unloading_over_loading_work"])
    return bare.by_law(law, work).replace(friction=parameters["friction"])


def _of_rows(inputs: Tables, rows: pd.DataFrame, fields: Mapping[str, Any]) -> Contact:
    """Return the contact of the pair that the rows are about, from fields that say all of it."""
    materials: Any = inputs["materials"].to_dict("records")
    particle, surface = rows["particle"].iloc[0], rows["surface"].iloc[0]
    return pair_contact(particle, surface, materials_from_rows(materials), {}, **fields)


def declared(inputs: Tables) -> tuple[dict[str, Material], Pairs]:
    """Return the declared materials and pairs of a study's inputs."""
    rows: dict[str, Any] = {
        name: inputs[name].to_dict("records") for name in ("materials", "contacts")
    }
    return materials_from_rows(rows["materials"]), pairs_from_rows(rows["contacts"])
