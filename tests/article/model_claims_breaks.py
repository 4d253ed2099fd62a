"""Breaks of the claims on the models: what is changed before numbers are computed again."""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd
import pytest
from tests.article.claim_worlds import STEEL, ClaimWorld, by, changed, nothing, to
from tests.article.conftest import ROOT

from microimpact.lab.contacts import calibrated_contact
from microimpact.model import contact as contact_module
from microimpact.model.calibration import (
    NoSolutionError,
    adhesion_damping_for,
    damping_factor_for,
    dissipation_ratio_for,
    two_stage,
)
from microimpact.model.contact import Contact
from microimpact.model.dynamics import impact as impact_module
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.rigid_body.roughness import measured_restitution
from microimpact.studies.claims.model_claims import algebra, oblique
from microimpact.studies.claims.model_claims import tables as from_tables
from microimpact.studies.models import calibration as calibration_study

MICA = "ammonium-fluorescein-mica"


def calibration(run_study, settings):
    """Run the calibrations that are needed, with one member of the family around them."""
    branch = settings.branches["calibration"]
    family = {"works_of_adhesion_J_per_m2": [3.5], "rate_exponents": [0.0]}
    works = [target for target in branch["by_work_of_adhesion"] if target["surface"] == "mica"]
    changes = {"by_work_of_adhesion": works, "by_restitution": []}
    return dict(run_study("calibration", two_stage=branch["two_stage"] | family, **changes))


def steel_fits(settings, **changes):
    """Return the cases of the fits that are needed: steel, and one that the study asks for."""
    wanted = {*STEEL, MICA}
    cases = settings.branches["restitution_fits"]["cases"]
    return [
        {**case, **(changes if case["case"] in STEEL else {})}
        for case in cases
        if case["case"] in wanted
    ]


class World(ClaimWorld):
    """Numbers behind the claims on the models."""

    study = "model_claims"

    def calibrated(self, case):
        """Return the contact of a calibrated case."""
        return calibrated_contact(self.inputs(), case)

    def contacts(self, quantity, factor):
        """Return the declared contact behind Fig. 20 with one property multiplied."""
        table = pd.read_csv(ROOT / self.settings.general.contacts)
        row = (table["particle"] == "ammonium-fluorescein") & (table["surface"] == "molybdenum")
        row &= table["property"] == quantity
        table.loc[row, "value"] *= factor
        return {"contacts": table}


def with_work(claim, world, factor, cases=STEEL):
    return world.numbers(claim, world.calibration(cases, work_of_adhesion=by(factor)))


without_ring_force = partial(with_work, factor=0.0)


def patched(claim, world, where, **names):
    for name, new in names.items():
        world.patch.setattr(where, name, new)
    return world.numbers(claim)


minus_in_eq_35 = partial(patched, measured_restitution=partial(measured_restitution, printed=True))


def restitution_of_0_90(claim, world):
    """Scale both damping coefficients of each case until e = 0.90 at the speed of the claim."""
    for case in STEEL:
        mended = damping_factor_for(world.calibrated(case), 1.60, 0.90)
        dampings = {
            name: to(float(getattr(mended, name))) for name in ("hertz_damping", "adhesion_damping")
        }
        world.tables = world.tables | world.calibration((case,), **dampings)
    return world.numbers(claim)


def earlier_work_of_adhesion(claim, world):
    def earlier(v_n, R, rho):
        return np.square(v_n) * np.square(R) * rho * (1.0 - rho) / 2.0

    return patched(claim, world, algebra, adhesion_work=earlier)


def exponent_5_2(claim, world):
    def printed(self):
        return algebra.damping_group(self) ** -2.5

    return patched(claim, world, Contact, damping_unit=property(printed))


def equal_pull_off_forces(claim, world):
    """Ring force of greatest pull (4/3) pi f_0 (2 pi f_0 r/(3 K))^(1/2) as JKR's, (3/2) pi w r."""

    def ring_force(work, radius, stiffness):
        return (9.0 / 8.0 * work * np.sqrt(1.5 * stiffness * radius / np.pi)) ** (2.0 / 3.0)

    return patched(claim, world, contact_module, ring_force_from_work=ring_force)


def without_adhesion_damping(claim, world):
    return world.numbers(claim, world.calibration(adhesion_damping=nothing))


def weak_adhesion(claim, world):
    """The method finds no pair at 0.05 J/m2; the nearest that has the capture velocity."""
    bare = world.calibrated(STEEL[0]).replace(work_of_adhesion=0.05, hertz_damping=0.0)
    with pytest.raises(NoSolutionError):
        two_stage(bare, 1.66, 0.70, 0.18)
    nearest = adhesion_damping_for(bare, 0.18)
    assert float(capture_velocity(nearest)) == pytest.approx(0.18)
    return world.numbers(
        claim,
        world.calibration(
            work_of_adhesion=to(0.05),
            hertz_damping=nothing,
            adhesion_damping=to(float(nearest.adhesion_damping)),
            adhesion_rate_exponent=nothing,
        ),
    )


def other_force_history(claim, world, quantity, factor):
    return world.numbers(
        claim, dict(world.run_study("force_history", world.contacts(quantity, factor)))
    )


def squared_sum_in_eq_20(claim, world):
    plain = contact_module.hertz_stiffness

    def printed(particle, surface):
        # 4/(3 pi (k_1 + k_2)^2), in SI units
        return 0.75 * np.pi * np.square(plain(particle, surface))

    return patched(claim, world, contact_module, hertz_stiffness=printed)


def no_material_damping(claim, world):
    """Without the search for material damping the greatest dissipation alone ends the interval."""

    def undamped(contact, speed, adhesion_ratio, dissipation_ratio):
        return dissipation_ratio_for(contact, speed, dissipation_ratio)

    world.patch.setattr(calibration_study, "hertz_damping_for_adhesion_ratio", undamped)
    return world.numbers(claim, calibration(world.run_study, world.settings))


def printed_sign_of_eq_29(claim, world):
    # A moment of the other sign is a negative moment of inertia: slip grows.
    return patched(claim, world, impact_module, INERTIA=-0.4, SLIP_PER_IMPULSE=1.0 - 1.0 / 0.4)


def fast_data_only(claim, world):
    cases = steel_fits(world.settings, fitted_from=5.0)
    return world.numbers(
        claim, dict(world.run_study("restitution_fits", world.tables, cases=cases))
    )


BREAKS = {
    "C05": without_ring_force,
    "C06": partial(changed, steel={"spin_ratio": 0.4}),
    "C07": partial(changed, normal={"adhesion_size_exponent": 1.0}),
    "C09": partial(changed, oblique={"facet_slope_deg": 10.0}),
    "C10": partial(changed, steel={"friction": 0.30}),
    "C11": partial(minus_in_eq_35, where=oblique),
    "C12": restitution_of_0_90,
    "C13": partial(changed, steel={"friction": 0.05}),
    "C14": partial(patched, where=algebra, inverse_tangent=np.arctan),
    "C16": without_ring_force,
    "C17": partial(changed, algebra={"spore_angles_deg": [42.0, 52.0]}),
    "C18": partial(patched, where=algebra, loading_impulse=algebra.approach_impulse),
    "C19": without_ring_force,
    "C20": earlier_work_of_adhesion,
    "C21": partial(with_work, factor=0.9),
    "C22": partial(changed, oblique={"normal_spin_ratio": -0.1}),
    "C23": partial(changed, steel={"friction_basis": "net"}),
    "C24": partial(patched, where=algebra, WORKS=("hertz_work",)),
    "C25": exponent_5_2,
    "C26": equal_pull_off_forces,
    "C27": without_adhesion_damping,
    "C28": weak_adhesion,
    "C29": without_ring_force,
    "C30": partial(other_force_history, quantity="adhesion_damping", factor=0.0),
    "C31": squared_sum_in_eq_20,
    "C32": partial(other_force_history, quantity="ring_force", factor=2.0),
    "C33": partial(other_force_history, quantity="adhesion_damping", factor=2.0),
    "C34": no_material_damping,
    "C35": partial(with_work, factor=0.5, cases=(MICA,)),
    "C36": partial(with_work, factor=0.8),
    "C37": partial(changed, normal={"lasting_diameters_um": [80.0, 90.0]}),
    "C38": partial(changed, steel={"diameter_um": 62e3}),
    "C39": printed_sign_of_eq_29,
    "C40": partial(changed, steel={"diameter_um": 620.0}),
    "C41": partial(changed, steel={"friction": 0.0}),
    "C42": partial(patched, where=from_tables, COUPLES=("steady_over_friction",)),
    "C43": fast_data_only,
    "C44": partial(minus_in_eq_35, where=algebra),
    "C58": partial(changed, steel={"speed_m_per_s": 0.01}),
    "C59": partial(changed, steel={"friction": 0.0}),
}
