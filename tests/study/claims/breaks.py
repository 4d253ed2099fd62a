"""Breaks of claims that are wrong forms of the code, or other contacts of a study, by claim."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from microimpact.lab import experiment, surface
from microimpact.lab.surface import simulated
from microimpact.model import contact as contact_module
from microimpact.model.calibration import damping_factor_for, dissipation_ratio_for
from microimpact.model.contact import Contact
from microimpact.model.dynamics import impact as impact_module
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.rigid_body.roughness import measured_restitution
from study import analyses
from study.analyses.calibration import compute as calibration_study
from study.analyses.claim_numbers import Params, numbers_of
from study.analyses.fig24_25_doe import compute as doe
from study.analyses.fig24_25_doe.factors import realistic_levels
from study.analyses.mechanisms import compute as mechanisms
from study.analyses.mechanisms import spore as spore_mechanism
from study.analyses.mechanisms.shallow import adhesion_or_roughness, shallow_curves
from study.claims import designs, dynamics, oblique, rigid_body
from study.contacts import DRAWN, calibrated_contact
from study.declared.documents import load
from study.declared.parameters import build
from study.report.claim import Judged, judged

# Columns of tables that hold properties of contacts, by property.
COLUMNS = {name: column for column, name in DRAWN.items()} | {"friction_basis": "friction_basis"}

STEEL = ("steel-silicon, n = 0", "steel-silicon, n = 1")
MOLYBDENUM = "fluorescein-molybdenum, nominal"
FORMICA_SPORE = "lycopodium-formica"


@dataclass(frozen=True)
class Break:
    """One changed input or misprinted equation, and the verdict that must then come out."""

    change: str
    expect: str = "not reproduced"
    set: Mapping[str, Any] = field(default_factory=dict)
    contacts: Mapping[str, Any] = field(default_factory=dict)

    @property
    def is_data(self) -> bool:
        """Whether the change can be made without other code."""
        return bool(self.set or self.contacts)


def read_breaks() -> dict[str, Break]:
    """Return the break of every claim, from the table beside this module."""
    entries = load(Path(__file__).with_suffix(".yaml"))
    return {name: Break(**entry) for name, entry in entries.items()}


def judged_with(name: str, control: Break) -> Judged:
    """Judge a claim with its break made, all tables computed."""
    return judged(name, control.set, contacts=partial(with_contacts, changes=control.contacts))


def with_contacts(table: pd.DataFrame, changes: Mapping[str, float | str]) -> pd.DataFrame:
    """Multiply properties of the contacts of a table by factors, or replace their basis.

    Contacts by a law without the property are left out.
    """
    table = table.copy()
    for name, change in changes.items():
        column = COLUMNS[name]
        if column in table:
            table = table[table[column].notna()].copy()
            table[column] = change if isinstance(change, str) else table[column] * change
        elif "role" in table and not isinstance(change, str):
            rows = (table["role"] == "parameter") & (table["quantity"] == name)
            table.loc[rows, "value"] *= change
    return table


@dataclass
class World:
    """Inputs of the claims, other studies, and a patch for wrong forms."""

    run_study: Any
    settings: Any
    inputs: Mapping[str, pd.DataFrame]  # Declared rows and tables of earlier studies
    patch: pytest.MonkeyPatch

    def numbers(self, claim, tables=None):
        """Compute the numbers of one claim, maybe with other tables."""
        params = build(Params, self.settings.branches["claim_numbers"])
        return numbers_of(claim, params, {**self.inputs, **(tables or {})})

    def contact(self, case):
        """Return the contact of a calibrated case."""
        return calibrated_contact(self.inputs, case)

    def calibration(self, case, **factors):
        """Return the calibration with parameters of one case multiplied."""
        table = self.inputs["calibration"]
        changed = with_contacts(table, factors)
        return {"calibration": changed.where(table["case"] == case, table)}

    def study(self, name, tables, **changes):
        """Run another study with some tables changed."""
        known = {
            table: self.inputs[table] for table in analyses.needs(name) if table in self.inputs
        }
        return dict(self.run_study(name, known | tables, **changes))


def patched(claim, world, where, **names):
    for name, new in names.items():
        world.patch.setattr(where, name, new)
    return world.numbers(claim)


minus_in_eq_35 = partial(patched, measured_restitution=partial(measured_restitution, printed=True))


def earlier_work_of_adhesion(v_n, R, rho):
    return np.square(v_n) * np.square(R) * rho * (1.0 - rho) / 2.0


def effect_mixed_with_bd(claim, world):
    """The effect of A for BD, which a quarter of the design with D = AB does not tell from it."""
    plain = designs.effect

    def mixed(effects, word):
        return plain(effects, "A" if word == "BD" else word)

    return patched(claim, world, designs, effect=mixed)


def strong_spore(claim, world):
    """Twice the work of adhesion after the calibration, so that the damping stays as it is."""
    plain = spore_mechanism.met_at

    def doubled(restitution, sample, angle):
        met = plain(restitution, sample, angle)
        factor = 2.0 if sample.dropped.case.startswith("lycopodium") else 1.0
        work = factor * met.contact.work_of_adhesion
        return met.with_contact(met.contact.replace(work_of_adhesion=work))

    world.patch.setattr(spore_mechanism, "met_at", doubled)
    return world.numbers(claim, world.study("mechanisms", {}))


def on_formica(claim, world, **factors):
    """The spore on Formica with properties of its contact multiplied."""
    tables = world.calibration(FORMICA_SPORE, **factors)
    table = world.study("mechanisms", tables)["formica_mechanism"]
    return world.numbers(claim, {**tables, "formica_mechanism": table})


def elastic_spore(claim, world):
    """The contact of the spore with the restitution of steel at normal incidence."""
    aim = float(normal_impact(world.contact("steel-formica"), 1.66).coefficient_of_restitution)
    contact = world.contact(FORMICA_SPORE)
    scaled = damping_factor_for(contact, 1.48, aim)
    factor = float(scaled.adhesion_damping / contact.adhesion_damping)
    return on_formica(claim, world, hertz_damping=factor, adhesion_damping=factor)


def net_force(claim, world):
    def by_net_force(contact, speed):
        impact = normal_impact(contact, speed)
        net = contact.mass * (1.0 + impact.coefficient_of_restitution) * speed
        return replace(impact, compressive_impulse=net)

    world.patch.setattr(surface, "normal_impact", by_net_force)
    # Without tables of the law, every contact is integrated.
    world.patch.setattr(experiment, "simulated", lambda contact, n, law: simulated(contact, n))
    params = build(mechanisms.Params, world.settings.branches["mechanisms"])
    curves = shallow_curves(params.shallow, params.sampling, world.inputs)
    table = pd.DataFrame(adhesion_or_roughness(params.shallow, curves))
    return world.numbers(claim, {"adhesion_or_roughness": table})


def exponent_5_2(claim, world):
    def printed(self):
        return dynamics.damping_group(self) ** -2.5

    return patched(claim, world, Contact, damping_unit=property(printed))


def force_history(claim, world, **factors):
    """The contact behind Fig. 20 with one property multiplied."""
    case = world.settings.branches["fig20_force_history"]["case"]
    return world.numbers(
        claim, world.study("fig20_force_history", world.calibration(case, **factors))
    )


def squared_sum_in_eq_20(claim, world):
    """The printed ring force is turned into work where the case is calibrated."""
    plain, right = contact_module.hertz_stiffness, world.contact(MOLYBDENUM)

    def printed(particle, surface):
        # 4/(3 pi (k_1 + k_2)^2), in SI units
        return 0.75 * np.pi * np.square(plain(particle, surface))

    world.patch.setattr(contact_module, "hertz_stiffness", printed)
    work = right.replace(ring_force=right.ring_force).work_of_adhesion
    factor = float(work / right.work_of_adhesion)
    return world.numbers(claim, world.calibration(MOLYBDENUM, work_of_adhesion=factor))


def no_material_damping(claim, world):
    """Without the search for material damping the greatest dissipation alone ends the interval."""

    def undamped(contact, speed, adhesion_ratio, dissipation_ratio):
        return dissipation_ratio_for(contact, speed, dissipation_ratio)

    world.patch.setattr(calibration_study, "hertz_damping_for_adhesion_ratio", undamped)
    branch = world.settings.branches["calibration"]
    family = {"works_of_adhesion_J_per_m2": [3.5], "rate_exponents": [0.0]}
    targets = branch["by_work_of_adhesion"].items()
    works = {case: None for case, target in targets if target["surface"] != "mica"}
    changes = {
        "by_work_of_adhesion": works,
        "by_restitution": dict.fromkeys(branch["by_restitution"]),
    }
    two = branch["two_stage"] | family
    return world.numbers(claim, dict(world.run_study("calibration", two_stage=two, **changes)))


def printed_sign_of_eq_29(claim, world):
    # A moment of the other sign is a negative moment of inertia: slip grows.
    return patched(claim, world, impact_module, INERTIA=-0.4, SLIP_PER_IMPULSE=1.0 - 1.0 / 0.4)


def scale_of_the_group(elastic, speed):
    return elastic.hertz_radius * elastic.replace(reference_velocity=speed).damping_unit


def effects(world, **levels):
    """Return the tables of the designs with other realistic levels."""

    def other_levels(*arguments):
        return replace(realistic_levels(*arguments), **levels)

    world.patch.setattr(doe, "realistic_levels", other_levels)
    return world.study("fig24_25_doe", {})


def levels(claim, world, factor, half):
    return world.numbers(claim, effects(world, **{factor: (1.0 - half, 1.0 + half)}))


def small_levels_of_damping(claim, world):
    half, names = 0.00005, ("stiffness", "work_of_adhesion", "radius", "hertz_dissipation")
    damping = {"adhesion_dissipation": (1.0 - half, 1.0 + half)}
    tables = effects(world, **dict.fromkeys(names, (0.95, 1.05)), **damping)
    # the declared levels stand in for the printed ones, which have one width for all factors
    levels = tables["doe_levels"]
    levels = levels[levels["variation"] == "realistic"].assign(variation="uniform")
    return world.numbers(claim, tables | {"doe_levels": levels})


BREAKS = {
    "C11": partial(minus_in_eq_35, where=oblique),
    "C14": partial(patched, where=oblique, inverse_tangent=np.arctan),
    "C25": exponent_5_2,
    "C30": partial(force_history, adhesion_damping=0.0),
    "C31": squared_sum_in_eq_20,
    "C32": partial(force_history, work_of_adhesion=2.0),
    "C33": partial(force_history, adhesion_damping=2.0),
    "C34": no_material_damping,
    "C39": printed_sign_of_eq_29,
    "C42": partial(patched, where=dynamics, MOMENTS=("bound_over_friction",)),
    "C53": partial(levels, factor="adhesion_dissipation", half=0.05),
    "C54": small_levels_of_damping,
    "C55": effect_mixed_with_bd,
    "C56": partial(levels, factor="radius", half=0.0005),
    "C81": strong_spore,
    "C88": elastic_spore,
    "C89": partial(on_formica, work_of_adhesion=0.0),
    "C92": net_force,
    "C101": partial(patched, where=rigid_body, adhesion_work=earlier_work_of_adhesion),
    "C103": partial(patched, where=dynamics, hertz_period=scale_of_the_group),
}
