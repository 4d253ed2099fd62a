"""Properties of every declared contact, and its capture velocity."""

from __future__ import annotations

from dataclasses import dataclass

import pandas as pd

from microimpact.model.contact import Contact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.pairs import pair_contact
from study.contacts import declared
from study.tables import Tables

WHOLE_TABLES = ("materials", "contacts")


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """No parameter: the declared contacts say all."""


def run(params: Params, inputs: Tables) -> Tables:
    """Return the table of contact properties.

    ``contact_properties``: one row per declared pair, at the pair's diameter.
    """
    materials, pairs = declared(inputs)
    rows = []
    for particle, surface in pairs:
        contact = pair_contact(particle, surface, materials, pairs)
        rows.append(
            {"particle": particle, "surface": surface}
            | properties(contact)
            | {"evidence": "computed"}
        )
    return {"contact_properties": pd.DataFrame(rows)}


def properties(contact: Contact) -> dict[str, float]:
    """Return stiffness, adhesion, scales and groups of one contact, units in the names."""
    hertz_group, adhesion_group = contact.groups
    values = {
        "diameter_um": contact.diameter * 1e6,
        "mass_kg": contact.mass,
        "stiffness_GPa": contact.stiffness / 1e9,
        "reduced_stiffness_GPa": contact.replace(stiffness_model="reduced").stiffness / 1e9,
        "ring_force_N_per_m": contact.ring_force,
        "work_of_adhesion_J_per_m2": contact.work_of_adhesion,
        "equilibrium_compression_nm": contact.equilibrium_compression * 1e9,
        "equilibrium_contact_radius_nm": contact.equilibrium_contact_radius * 1e9,
        "velocity_scale_m_per_s": contact.velocity_scale,
        "hertz_damping_s_per_m": contact.hertz_damping,
        "adhesion_damping_s_per_m": contact.adhesion_damping,
        "hertz_group": hertz_group,
        "adhesion_group": adhesion_group,
        "capture_velocity_m_per_s": capture_velocity(contact),
    }
    return {name: float(value) for name, value in values.items()}  # type: ignore[arg-type]
