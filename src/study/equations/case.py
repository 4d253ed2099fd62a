"""The one impact at which formulas of the equation ledger meet functions of the model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from microimpact.core.constants import gravity
from microimpact.core.materials import Material, materials_from_rows
from microimpact.model.contact import Contact
from microimpact.model.dynamics.impact import planar, velocity_components
from microimpact.model.dynamics.trajectory import trajectory
from microimpact.model.pairs import pair_contact, pairs_from_rows
from microimpact.model.rigid_body.algebra import INERTIA, rigid_body_rebound
from study.equations.contact import TRACED_MOMENT, TRACED_POINTS
from study.equations.records import ReferenceCase

Numbers = dict[str | tuple[str, str], float]

# Section 2.4.1, steel on silicon: 1.66 m/s, e = 0.70, f = 0.15; at 30 degrees it slides.
SPEED, ANGLE, RESTITUTION, FRICTION, SPIN = 1.66, 30.0, 0.70, 0.15, 5e3

# Any other values serve to compare a formula with a function; none is a result.
CHOSEN: Numbers = {
    "R": 0.9,
    "rho": 0.3,
    "v_probe": 1.5,
    "V_probe": 1.0,
    "h": 1e-3,
    "g": gravity,
    "s": 1.0,
    "p": 1.1,
    "q": 1.3,
    "v_c": -0.18,
    "mu_c": 0.1,
    "r_S": 1e-4,
    **{(name, "m/s"): 30.0 for name in ("k", "k_1", "k_2")},
    **dict.fromkeys(("kappa", "kappa_1", "kappa_2"), 0.5),
    "alpha": float(np.radians(20.0)),
    "phi": float(np.radians(5.0)),
}


def reference_case(tables: Mapping[str, pd.DataFrame]) -> ReferenceCase:
    """Return the impact, of the declared contact.

    Parameters
    ----------
    tables
        ``materials`` and ``contacts``, declared rows of one pair, steel on silicon.
    """
    rows: dict[str, Any] = {
        name: tables[name].to_dict("records") for name in ("materials", "contacts")
    }
    v_n, _ = velocity_components(SPEED, ANGLE)
    pairs = pairs_from_rows(rows["contacts"])
    ((particle, surface),) = pairs
    contact = pair_contact(
        particle,
        surface,
        materials_from_rows(rows["materials"]),
        pairs,
        # Every term of Eq. (19) has to count, so the material is damped too.
        hertz_damping=0.05,
        adhesion_rate_exponent=0.0,
        friction=FRICTION,
        reference_velocity=float(-v_n),
    )
    return ReferenceCase(
        contact=contact, numbers={**CHOSEN, **_rigid(contact), **_elastic(contact)}
    )


def _rigid(contact: Contact) -> Numbers:
    """State before and after, of the rigid body model, and along a slope."""
    v_n, v_t = (float(value) for value in velocity_components(SPEED, ANGLE))
    m, r = float(contact.mass), float(contact.radius)
    after = rigid_body_rebound(v_n, v_t, SPIN, r, RESTITUTION, FRICTION)
    local = float(CHOSEN["alpha"] + CHOSEN["phi"])
    return {
        "v": SPEED,
        "angle": ANGLE,
        "v_n": v_n,
        "v_t": v_t,
        "omega": SPIN,
        "e": RESTITUTION,
        "f": FRICTION,
        "mu": -FRICTION,
        "m": m,
        "r": r,
        ("R", "m"): r,
        "V_n": float(after.V_n),
        "V_t": float(after.V_t),
        "Omega": float(after.Omega),
        "V": float(np.hypot(after.V_n, after.V_t)),
        "eta": (v_t - r * SPIN) / v_n,
        "I": INERTIA * m * r**2,
        "k": float(np.sqrt(INERTIA)) * r,
        "vp_n": -SPEED * float(np.sin(local)),
        "vp_t": SPEED * float(np.cos(local)),
        "Vp_t": 0.8 * SPEED * float(np.cos(local)),
    }


def _elastic(contact: Contact) -> Numbers:
    """Properties of the contact, and one moment of the impact."""
    path = trajectory(contact, SPEED, ANGLE, points=TRACED_POINTS)
    n = -float(path.compression[TRACED_MOMENT])
    v_n, v_t = velocity_components(SPEED, ANGLE)
    unit = contact.damping_unit
    numbers = {
        "K": contact.stiffness,
        "f_0": contact.ring_force,
        "w_A": contact.work_of_adhesion,
        "c_H": contact.hertz_damping,
        "c_A": contact.adhesion_damping,
        "R_S": contact.radius,
        "zeta_H": contact.hertz_damping / unit,
        "zeta_A": contact.adhesion_damping / unit,
        "k_1": _compliance(contact.particle),
        "k_2": _compliance(contact.surface),
        "n": n,
        "n_dot": path.velocity[TRACED_MOMENT],
        "t_dot": path.tangential_velocity[TRACED_MOMENT],
        "theta_dot": path.spin[TRACED_MOMENT],
        "F_n": path.normal_force[TRACED_MOMENT],
        # Per second: the tangential impulse of the whole impact.
        "F_t": contact.mass * (planar(contact, v_n, v_t, SPIN).tangential_velocity - v_t),
        "a": np.sqrt(-n * contact.hertz_radius),
        "a_c": contact.equilibrium_contact_radius,
    }
    return {name: float(value) for name, value in numbers.items()}


def _compliance(material: Material) -> float:
    """Return k of Eq. (21), 1/Pa."""
    return float((1.0 - material.poissons_ratio**2) / (np.pi * material.youngs_modulus))
