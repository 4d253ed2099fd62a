"""Claims decided by simulated oblique impacts of the mean sphere."""

from __future__ import annotations

import numpy as np

from microimpact.core.arrays import FloatArray, Real
from microimpact.model.contact import Contact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import FRICTION_BASES, Impact, simulate
from microimpact.studies.claims.analysis_claims.context import Context

# Steps in which ranges of angles are walked, degrees.
COARSE, FINE = 1.0, 0.01
# Curves of rebounds begin so much above the normal speed of capture.
ABOVE_CAPTURE = 1e-6


def c68(context: Context, contact: Contact) -> dict[str, float]:
    """Return how far e strays from the printed plateau, and e at the grazing angle."""
    impacts = context.params.impacts
    low, high = sorted(impacts.plateau_angles_deg)
    level = at_angles(context, contact, np.arange(low, high + COARSE / 2, COARSE))
    grazing = at_angles(context, contact, impacts.grazing_angle_deg)
    stray = np.max(np.abs(level.coefficient_of_restitution - impacts.plateau))
    return {
        "largest_difference_from_plateau_15_to_85_deg": float(stray),
        "restitution_at_10_deg": float(grazing.coefficient_of_restitution),
    }


def c69(context: Context, contact: Contact) -> dict[str, float]:
    """Return ratios of impulse ratios between angles, friction following the declared force."""
    impacts = context.params.impacts
    rises = {
        basis: quotient(context, contact, impacts.rise_angles_deg, basis)
        for basis in (impacts.friction_basis, "hertz", "net")
    }
    return {
        "impulse_ratio_15_over_40_deg": quotient(context, contact, impacts.level_angles_deg),
        "impulse_ratio_8_over_15_deg": rises[impacts.friction_basis],
        "impulse_ratio_8_over_15_deg_hertz": rises["hertz"],
        "impulse_ratio_8_over_15_deg_net": rises["net"],
    }


def c93(context: Context, contact: Contact) -> dict[str, float]:
    """Return impulse and impulse ratio at a vanishing angle without adhesion, by all measures."""
    impacts = context.params.impacts
    work = np.asarray(contact.work_of_adhesion) * impacts.share_without_adhesion
    bare = contact.replace(work_of_adhesion=work)
    angle = impacts.limit_angle_deg
    limits = [
        simulate(bare, impacts.speed_m_per_s, angle, friction_basis=b) for b in FRICTION_BASES
    ]
    along = impacts.speed_m_per_s * np.cos(np.radians(angle))
    momentum = max(float(along - i.tangential_velocity) / impacts.speed_m_per_s for i in limits)
    difference = max(abs(float(i.impulse_ratio - contact.friction)) for i in limits)
    return {
        "tangential_impulse_over_momentum_at_0p1_deg": momentum,
        "largest_difference_of_impulse_ratio_from_friction": difference,
    }


def c95(context: Context, contact: Contact) -> dict[str, float]:
    """Return how far relative e of smooth silicon and smooth Formica differ after subtraction."""
    impacts = context.params.impacts
    low, high = sorted(impacts.relative_angles_deg)
    angle = np.append(np.arange(low, high + COARSE / 2, COARSE), impacts.reference_angle_deg)
    one, other = (
        at_angles(context, each, angle).coefficient_of_restitution
        for each in (contact, context.contact(context.params.formica.case))
    )
    residual = (one - one[-1]) - (other - other[-1])
    return {"largest_residual_difference_of_relative_restitution": float(np.max(np.abs(residual)))}


def c106(context: Context, contact: Contact) -> dict[str, float]:
    """Return -mu at the shallow angle less that at the steep one, at the slow speed."""
    impacts = context.params.impacts
    angle = np.array(impacts.slow_angles_deg)
    share = np.power(np.sin(np.radians(angle)), impacts.friction_speed_exponent)
    rubbing = contact.replace(friction=contact.friction * share)
    basis = impacts.friction_basis
    ratio = simulate(rubbing, impacts.slow_speed_m_per_s, angle, 0.0, basis).impulse_ratio
    return {"impulse_ratio_30_less_50_deg_at_0p45_m_per_s": float(ratio[0] - ratio[1])}


def c110(context: Context, contact: Contact) -> dict[str, float]:
    """Return the largest angle at which -mu of a rebound exceeds that at 40 deg by a share."""
    impacts = context.params.impacts
    start = impacts.from_angle_deg
    sine = float(capture_velocity(contact)) * (1.0 + ABOVE_CAPTURE) / impacts.speed_m_per_s
    least = max(float(np.degrees(np.arcsin(min(sine, 1.0)))), FINE)
    angle = np.append(np.arange(start, least, -FINE), least)
    ratio = at_angles(context, contact, angle).impulse_ratio
    risen = angle[ratio >= (1.0 + impacts.rise_share) * ratio[0]]
    return {"angle_of_rise": float(risen[0]) if risen.size else 0.0}


def at_angles(context: Context, contact: Contact, angle: Real, basis: str | None = None) -> Impact:
    """Return impacts at the nominal speed."""
    impacts = context.params.impacts
    return simulate(contact, impacts.speed_m_per_s, angle, 0.0, basis or impacts.friction_basis)


def quotient(
    context: Context, contact: Contact, angles: tuple[float, float], basis: str | None = None
) -> float:
    """Return the impulse ratio at one angle over that at another."""
    ratio: FloatArray = at_angles(context, contact, np.array(angles), basis).impulse_ratio
    return float(ratio[0] / ratio[1])
