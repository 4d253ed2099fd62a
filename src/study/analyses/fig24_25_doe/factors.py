"""The five factors of the sensitivity studies (Section 4.3), and their levels.

A = stiffness K, B = work of adhesion w_A, C = radius r, D and E = dissipation parameters zeta_A and
zeta_H of adhesion and material (Eqs. 23 and 24) at a fixed v_N.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import astuple, dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np
import pandas as pd

from microimpact.core.arrays import FloatArray, Real
from microimpact.core.computable import NotComputable
from microimpact.core.materials import Material, materials_from_rows
from microimpact.model.contact import Contact, hertz_stiffness
from microimpact.model.dynamics.capture import capture_velocity, threshold
from study.declared.parameters import Positive
from study.tables import Tables

# Letter of the article: name and unit here.
FACTORS = {
    "A": ("stiffness", "Pa"),
    "B": ("work_of_adhesion", "J/m2"),
    "C": ("radius", "m"),
    "D": ("adhesion_dissipation", "-"),
    "E": ("hertz_dissipation", "-"),
}
LETTERS = "".join(FACTORS)
NAMES = tuple(name for name, _ in FACTORS.values())

# v_N is held and drops out of all ratios, so a contact without one may take any.
ANY_SPEED = 1.0

# Step of central differences in logarithms of damping groups: errors below 1e-7.
STEP = 1e-4

Pair = tuple[Positive, Positive]


@dataclass(frozen=True, slots=True, kw_only=True)
class Levels:
    """Low and high level of every factor, as multiples of its nominal value."""

    stiffness: Pair
    work_of_adhesion: Pair
    radius: Pair
    adhesion_dissipation: Pair
    hertz_dissipation: Pair

    def __post_init__(self) -> None:
        """Refuse levels that do not ascend."""
        for name, (low, high) in zip(NAMES, astuple(self), strict=True):
            if low >= high:
                raise ValueError(f"{name}: the low level {low:g} must be below the high, {high:g}")

    @property
    def array(self) -> FloatArray:
        """Levels, shape (2, 5)."""
        return np.array(astuple(self), dtype=np.float64).T


def about_one(shares: Mapping[str, float]) -> dict[str, tuple[float, float]]:
    """Return levels a share below and above the nominal value, by factor."""
    return {name: (1.0 - share, 1.0 + share) for name, share in shares.items()}


def realistic_levels(
    contact: Contact,
    diameters: tuple[float, float],
    inputs: Tables,
    shares: Mapping[str, float] = MappingProxyType({}),
) -> Levels:
    """Return levels half the logarithmic range of each factor to either side of its nominal value.

    The stiffness ranges over the declared bounds of the materials, the radius over the sieve, and
    adhesion and damping over the calibrated contacts that keep the restitution level.

    Parameters
    ----------
    contact
        The nominal contact; its rate exponent says which end of the family is meant.
    diameters
        Ends of the sieve.
    inputs
        ``materials``: declared rows; ``calibration_family``: table of the calibration.
    shares
        Half-ranges of factors, by name, in place of the realistic ones.
    """
    flat = flat_family(contact, inputs)
    levels = Levels(
        stiffness=_either_side(_stiffness_ends(contact, inputs["materials"])),
        work_of_adhesion=_either_side(flat["work_of_adhesion_J_per_m2"]),
        radius=_either_side(diameters),
        adhesion_dissipation=_either_side(flat["zeta_adhesion"]),
        hertz_dissipation=_either_side(flat["zeta_hertz"]),
    )
    return replace(levels, **about_one(shares))


def flat_family(contact: Contact, inputs: Tables) -> pd.DataFrame:
    """Return the members of the calibrated family with a level restitution, of a rate exponent.

    Raises ValueError if there are fewer than two, between which nothing varies.
    """
    family = inputs["calibration_family"]
    exponent = float(contact.adhesion_rate_exponent)
    flat = family["solved"] & (family["plateau_of_e_holds"] == True)  # noqa: E712  or missing
    members = family[flat & (family["rate_exponent"] == exponent)]
    if len(members) < 2:
        raise NotComputable(
            "calibration.two_stage.works_of_adhesion_J_per_m2: must give two members or more with "
            f"n = {exponent:g} and a level restitution, gives {len(members)}"
        )
    return members


def _either_side(values: Iterable[float]) -> tuple[float, float]:
    extremes = list(values)
    half = float(np.sqrt(max(extremes) / min(extremes)))
    return 1.0 / half, half


def _stiffness_ends(contact: Contact, materials: pd.DataFrame) -> tuple[float, float]:
    """Return K with all elastic constants at their lower, and at their upper, declared bounds."""
    ends = []
    elastic = materials["property"] != "density"
    for end, opposite in (("low", "high"), ("high", "low")):
        # A larger modulus and a larger Poisson's ratio both stiffen.
        bound = materials[end].fillna(materials[opposite]).fillna(materials["value"])
        value = bound.where(elastic, materials["value"])
        rows: Any = materials.assign(value=value).to_dict("records")
        known = materials_from_rows(rows)
        bodies = (known[body.name] for body in (contact.particle, contact.surface))
        ends.append(float(hertz_stiffness(*bodies)))
    return ends[0], ends[1]


def coded(levels: FloatArray, design: FloatArray) -> FloatArray:
    """Return multiples of the nominal values for coded levels -1 and +1; 0 is nominal.

    Parameters
    ----------
    levels
        Shape (2, 5).
    design
        Shape (..., 5).
    """
    return np.where(design == 0.0, 1.0, np.where(design < 0.0, levels[0], levels[1]))


def at_levels(contact: Contact, multiples: FloatArray) -> Contact:
    """Return the contact with its five factors multiplied, shape of all but the last axis.

    With K both moduli are multiplied. At fixed zeta and v_N the damping coefficients follow
    Eqs. (23) and (24): ``c ~ zeta K^(-2/5)``, whatever the radius, as the mass grows with its cube.
    """
    stiffness, work, radius, zeta_a, zeta_h = np.moveaxis(np.asarray(multiples, float), -1, 0)
    moved = contact.replace(
        particle=_stiffened(contact.particle, stiffness),
        surface=_stiffened(contact.surface, stiffness),
        diameter=contact.diameter * radius,
        work_of_adhesion=contact.work_of_adhesion * work,
    )
    unit = damping_unit(moved) / damping_unit(contact)
    return moved.replace(
        hertz_damping=contact.hertz_damping * zeta_h * unit,
        adhesion_damping=contact.adhesion_damping * zeta_a * unit,
    )


def damping_unit(contact: Contact) -> Real:
    """Damping coefficient in s/m of zeta = 1 at the contact's v_N, at 1 m/s if it has none."""
    speed = ANY_SPEED if contact.reference_velocity is None else contact.reference_velocity
    return contact.replace(reference_velocity=speed).damping_unit


def factor_values(contact: Contact) -> dict[str, Real]:
    """Return the five factors of a contact in SI units, by letter."""
    unit = damping_unit(contact)
    return {
        "A": contact.stiffness,
        "B": contact.work_of_adhesion,  # type: ignore[dict-item]
        "C": contact.radius,
        "D": contact.adhesion_damping / unit,
        "E": contact.hertz_damping / unit,
    }


@dataclass(frozen=True, slots=True)
class Elasticities:
    """Elasticities d ln v_c / d ln x of the five factors, each of shape (5,)."""

    at_fixed_zeta: FloatArray  # Damping coefficients follow Eqs. (23) and (24).
    # Damping coefficients are held; the last two are those to c_A and c_H.
    at_fixed_damping: FloatArray


def elasticities(contact: Contact) -> Elasticities:
    """Elasticities of the capture velocity of one contact by its similarity law.

    ``v_c = V T(c_H V, c_A (v_N/v_c)^n V)`` with ``V ~ K^(-1/3) (w_A/r)^(5/6)``; with the slopes h
    and a of ln T by its logarithmic groups, ``(1 + n a) d ln v_c = (1 + h + a) d ln V + h d ln c_H
    + a d ln c_A``. At fixed zeta both c go as ``K^(-2/5)``; neither depends on r.

    Raises ValueError if the contact has no finite, positive capture velocity.
    """
    limit = float(capture_velocity(contact))
    if not 0.0 < limit < np.inf:
        raise NotComputable(f"an elasticity needs a finite, positive capture velocity, got {limit}")
    scale = contact.velocity_scale
    groups = np.array([contact.hertz_damping, contact.adhesion_damping_at(limit)]) * scale
    moves = np.array([[STEP, 0.0], [-STEP, 0.0], [0.0, STEP], [0.0, -STEP]])
    hertz, adhesion = (groups * np.exp(moves)).T
    logs = np.log(threshold(hertz, adhesion, contact.damped_attachment))
    h, a = (logs[0::2] - logs[1::2]) / (2.0 * STEP)
    damping = np.array([0.0, 0.0, 0.0, a, h])
    scale_exponents = np.array([-1.0 / 3.0, 5.0 / 6.0, -5.0 / 6.0, 0.0, 0.0])
    at_fixed_damping = (1.0 + h + a) * scale_exponents + damping
    at_fixed_zeta = at_fixed_damping + np.array([-0.4 * (h + a), 0.0, 0.0, 0.0, 0.0])
    stretch = 1.0 + float(contact.adhesion_rate_exponent) * a
    return Elasticities(at_fixed_zeta / stretch, at_fixed_damping / stretch)


def _stiffened(material: Material, multiple: FloatArray) -> Material:
    return replace(material, youngs_modulus=material.youngs_modulus * multiple)
