"""Numbers of the claims of Section 3.1: the algebraic model of the rigid body."""

from __future__ import annotations

import numpy as np

from microimpact.core.arrays import FloatArray, Real
from microimpact.model.choices import FRICTION_BASES
from microimpact.model.contact import Contact
from microimpact.model.dynamics.impact import simulate
from microimpact.model.dynamics.normal import losses, normal_impact
from microimpact.model.dynamics.trajectory import trajectory
from microimpact.model.rigid_body.algebra import (
    adhesion_impulse,
    adhesion_work,
    deformation_impulse,
    restitution_with_adhesion,
)
from study.declared.parameters import AngleDegrees, Finite, Fraction, Positive
from study.studies.claims.claim_numbers.claim import claim
from study.studies.claims.claim_numbers.context import Context, Numbers, greatest, without_adhesion
from study.studies.claims.claim_numbers.experiments import rebounding_speeds

# Entries of the energy ledger that are lost.
WORKS = ("hertz_work", "adhesion_work")
# Instants of a trajectory whose works are added up.
INSTANTS = 4001
# At which identities are tried: over the range of the article, and from hardly any adhesion to
# capture.
RESTITUTIONS = (0.3, 0.5, 0.7, 0.9)
ADHESION_COEFFICIENTS = (0.05, 0.2, 0.5, 0.8, 1.0)


@claim("C18")
def c18(context: Context) -> Numbers:
    """Restitution from momentum with the adhesion impulse of Eqs. (5) and (10), and by Eq. (16)."""
    R, rho = body_and_adhesion()
    v_n = -context.speed
    impulses = (-rho * loading_impulse(v_n, R), adhesion_impulse(v_n, R, rho))
    # e from V_n = v_n + P_D + P_A, impulses per mass.
    restitutions = [-(v_n + deformation_impulse(v_n, R) + adhesive) / v_n for adhesive in impulses]
    restitutions.append(restitution_with_adhesion(R, rho))
    return {"largest_difference_of_restitution": np.max(np.ptp(np.array(restitutions), axis=0))}


def loading_impulse(v_n: float, R: Real) -> Real:
    """Deformation impulse per mass of which adhesion takes the share rho in Eq. (5): rebound's."""
    return deformation_impulse(v_n, R) - approach_impulse(v_n, R)


def approach_impulse(v_n: float, R: Real) -> Real:
    """Deformation impulse per mass of the approach, which stops the sphere, of the shape of R."""
    return deformation_impulse(v_n, np.zeros_like(R))


def body_and_adhesion() -> tuple[FloatArray, FloatArray]:
    """Return all pairs of body restitution and adhesion coefficient."""
    R, rho = np.meshgrid(RESTITUTIONS, ADHESION_COEFFICIENTS)
    return R, rho


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


@claim("C20")
def c20(context: Context) -> Numbers:
    """Work of Eq. (18) at rho = 1 over the energy that deformation gives back; farthest from 1."""
    R = np.array(RESTITUTIONS)
    given_back = 0.5 * np.square(restitution_with_adhesion(R, 0.0) * context.speed)
    ratio = adhesion_work(-context.speed, R, 1.0) / given_back
    return {"work_ratio_at_capture": farthest(ratio)}


def farthest(ratios: Real) -> float:
    """Return the ratio that is farthest from 1."""
    flat = np.ravel(ratios)
    return float(flat[np.argmax(np.abs(flat - 1.0))])


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


@claim("C24")
def c24(context: Context) -> Numbers:
    """Kinetic energy loss less both works: residuals of simulated rebounds, and of Eq. (17)."""
    R, rho = body_and_adhesion()
    half = 0.5 * context.speed**2
    e = restitution_with_adhesion(R, rho)
    works = (1.0 - np.square(R)) * half + adhesion_work(-context.speed, R, rho)
    residuals = [np.abs((1.0 - np.square(e)) * half - works) / half]
    for case in context.cases():
        ledger = normal_impact(case.steel, rebounding_speeds(case), ledger=True).ledger
        assert ledger is not None
        lost = ledger.kinetic_before - ledger.kinetic_after
        works = sum(getattr(ledger, work) for work in WORKS)
        residuals.append(np.abs(lost - works) / ledger.kinetic_before)
    return {"largest_relative_residual_of_energy": max(np.max(part) for part in residuals)}


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


@claim("C93", by_case=True)
def c93(context: Context, *, share_without_adhesion: Fraction, angle_deg: AngleDegrees) -> Numbers:
    """Impulse and impulse ratio at a vanishing angle without adhesion, by all measures.

    Parameters
    ----------
    share_without_adhesion
        Of the work of adhesion that is left.
    """
    contact = context.steel
    work = np.asarray(contact.work_of_adhesion) * share_without_adhesion
    impact = contact.replace(work_of_adhesion=work), context.speed, angle_deg
    limits = [simulate(*impact, friction_basis=basis) for basis in FRICTION_BASES]
    along = context.speed * np.cos(np.radians(angle_deg))
    momentum = max((along - i.tangential_velocity) / context.speed for i in limits)
    difference = max(abs(i.impulse_ratio - contact.friction) for i in limits)
    return {
        "tangential_impulse_over_momentum": momentum,
        "largest_difference_of_impulse_ratio_from_friction": difference,
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


@claim("C108", by_case=True)
def c108(context: Context, *, attachment_damped: bool) -> Numbers:
    """Share of the loss to damped adhesion that falls on the rebound.

    As the model supposes, with damping on rebound alone, and with damping on approach as well.
    """

    def rebound_share(damped: bool) -> float:
        contact = context.steel.replace(damped_attachment=damped)
        path = trajectory(contact, context.speed, points=INSTANTS)
        power = np.abs(path.adhesion_damping_force * path.velocity)
        rebound = np.trapezoid(np.where(path.velocity > 0.0, power, 0.0), path.time)
        return float(rebound / np.trapezoid(power, path.time))

    return {
        "rebound_share_of_adhesion_loss": rebound_share(attachment_damped),
        "rebound_share_if_approach_is_damped": rebound_share(damped=True),
    }
