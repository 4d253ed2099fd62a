"""Numbers of the claims of Section 3.1: the algebraic model of the rigid body."""

from __future__ import annotations

import numpy as np

from microimpact.core.arrays import FloatArray
from microimpact.model.contact import Contact
from microimpact.model.dynamics.impact import simulate
from microimpact.model.dynamics.normal import losses
from microimpact.model.rigid_body.algebra import (
    adhesion_work,
)
from study.declared.parameters import AngleDegrees, Finite, Positive
from study.studies.claims.claim_numbers.claim import claim
from study.studies.claims.claim_numbers.context import Context, Numbers, greatest, without_adhesion


@claim("C19", by_contact=True)
def c19(context: Context) -> Numbers:
    """Impulse ratio over the coefficient of friction, the largest over all rebounds.

    Friction follows the declared force; beside it, that of Hertz.
    """
    impact = context.rebounds()
    hertz = context.impacts(context.speed, context.all_angles(), "hertz")
    friction, free = context.steel.friction, ~impact.captured
    return {
        "largest_impulse_ratio_over_friction": greatest(impact.impulse_ratio, free) / friction,
        "largest_impulse_ratio_over_friction_hertz": greatest(hertz.impulse_ratio, free) / friction,
    }


@claim("C21", by_case=True)
def c21(context: Context, *, above_capture: Positive, rest_speed_m_per_s: Positive) -> Numbers:
    """Restitution and adhesion coefficient at 1e-4 above the calibrated capture velocity.

    The adhesion coefficient by Eq. (16), 1 - e/R, R from the same impact without ring force.
    """
    steel = context.steel
    speed = context.calibrated_capture_velocity * (1.0 + above_capture)
    bare = without_adhesion(steel)
    e, body = (simulate(c, speed).coefficient_of_restitution for c in (steel, bare))
    at_rest = simulate(bare, rest_speed_m_per_s).coefficient_of_restitution
    return {
        "restitution_just_above_capture": e,
        "adhesion_coefficient_just_above_capture": 1.0 - e / body,
        "restitution_without_adhesion": at_rest,
    }


@claim("C22", by_contact=True)
def c22(context: Context, *, spin_ratio: Finite) -> Numbers:
    """Signed impulse ratio of Eq. (2) at normal incidence with spin of either sign and without."""
    steel, spins = context.steel, spin_ratio * np.array([[1.0], [-1.0], [0.0]])
    spin = spins * context.speed / steel.radius
    impact = simulate(steel, context.speed, 90.0, spin, "compressive")
    positive, negative, none = -impact.impulse_ratio
    return {
        "signed_impulse_ratio_positive_spin": positive,
        "signed_impulse_ratio_negative_spin": negative,
        "signed_impulse_ratio_no_spin": none,
    }


@claim("C23", by_contact=True)
def c23(context: Context, *, plateau_deg: AngleDegrees) -> Numbers:
    """Impulse ratio at the shallowest angle of adhesive rebound over that at 15 deg.

    With adhesion, and without at the same two angles.
    """
    shallowest = context.shallowest_rebounds()
    angles = np.stack([shallowest, np.full_like(shallowest, plateau_deg)])
    both = context.steel, without_adhesion(context.steel)
    impacts = [context.hit(contact, context.speed, angles) for contact in both]
    adhesive, bare = (
        np.where(impacts[0].captured[0], np.nan, shallow / level)
        for shallow, level in (impact.impulse_ratio for impact in impacts)
    )
    return {
        "rise_to_shallowest_rebound_with_adhesion": adhesive,
        "rise_to_shallowest_rebound_without_adhesion": bare,
    }


@claim("C91")
def c91(context: Context, *, angle_error_deg: Positive) -> Numbers:
    """Spin, or tilt, that gives a mean impulse ratio of 0.01 at normal incidence.

    Of the calibrated contacts the greatest spin, and the least tilt, over the uncertainty of the
    printed angles.
    """
    table = context.table("spin_or_tilt")
    tilt = table["tilt_deg"].min()
    return {
        "spin_over_speed_needed": table["spin_over_speed"].max(),
        "tilt_needed": tilt,
        "tilt_over_its_uncertainty": tilt / angle_error_deg,
    }


@claim("C92", by_case=True)
def c92(context: Context, *, plateau_deg: AngleDegrees) -> Numbers:
    """Rise by adhesion, and spread at equal normal speed of two speeds, by adhesion or slopes.

    The rise with friction by the compressive force, and by the net force.
    """
    table = context.table("adhesion_or_roughness").set_index("cause")
    spread = table["spread_at_equal_normal_speed"]
    angles = np.array([context.shallowest_rebounds()[0], plateau_deg])
    shallow, level = np.ravel(context.impacts(context.speed, angles, basis="net").impulse_ratio)
    rises = {
        "compressive force": table["rise_at_shallowest_rebound"]["adhesion"],
        "net force": shallow / level,
    }
    return {
        name: {
            "spread_over_speeds_at_equal_normal_speed_by_adhesion": spread["adhesion"],
            "spread_over_speeds_at_equal_normal_speed_by_slopes": spread["slopes"],
            "rise_at_shallowest_rebound_by_adhesion": rise,
        }
        for name, rise in rises.items()
    }


@claim("C101", by_contact=True)
def c101(context: Context, *, speeds_m_per_s: tuple[Positive, ...]) -> Numbers:
    """W_A of Eq. (18), R from impacts without adhesion, over the simulated adhesion loss."""
    speed, steel = np.array(speeds_m_per_s)[:, None], context.steel
    body = body_restitution(steel, speed)
    e = simulate(steel, speed).coefficient_of_restitution
    work = losses(steel, speed).adhesion / steel.mass
    ratio = np.asarray(adhesion_work(speed, body, 1.0 - e / body) / work)
    return {"least_ratio_of_works": ratio.min(axis=0), "greatest_ratio_of_works": ratio.max(axis=0)}


@claim("C102", by_contact=True)
def c102(context: Context, *, speeds_m_per_s: tuple[Positive, ...]) -> Numbers:
    """Loss (1 - R^2) v^2/2, R from impacts without adhesion, over the simulated material loss."""
    speed, steel = np.array(speeds_m_per_s)[:, None], context.steel
    body = 0.5 * (1.0 - np.square(body_restitution(steel, speed))) * np.square(speed)
    ratio = np.asarray(body / (losses(steel, speed).bulk / steel.mass))
    return {
        "least_ratio_of_material_losses": ratio.min(axis=0),
        "greatest_ratio_of_material_losses": ratio.max(axis=0),
    }


def body_restitution(contact: Contact, speed: FloatArray) -> FloatArray:
    """Return R, the restitution of the same contact without ring force."""
    return simulate(without_adhesion(contact), speed).coefficient_of_restitution
