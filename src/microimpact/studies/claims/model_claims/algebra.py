"""Numbers behind the claims that are identities, or follow from algebra or dimensions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from microimpact.core.arrays import FloatArray, Real
from microimpact.model.contact import Contact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import velocity_components
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.rigid_body.algebra import (
    adhesion_impulse,
    adhesion_work,
    deformation_impulse,
    energy_loss,
    restitution_with_adhesion,
    rigid_body_rebound,
)
from microimpact.model.rigid_body.roughness import measured_impulse_ratio, measured_restitution
from microimpact.studies.claim_numbers import Numbers
from microimpact.studies.claims.model_claims.context import Context, between

# Entries of the energy ledger that are lost.
WORKS = ("hertz_work", "adhesion_work")

# Factor by which each base unit (mass, length, time) is changed: a power of two is exact.
UNIT_FACTOR = 2.0


def c06(context: Context) -> dict[str, float]:
    """Loss at normal incidence against 1 - e^2: simulated, and by Eq. (14) at the same e."""
    largest = 0.0
    for case in context.cases():
        steel, speeds = case.steel, rebounding_speeds(case)
        impact = case.hit(steel, speeds)
        e = impact.coefficient_of_restitution
        spin = context.params.steel.spin_ratio * speeds / steel.radius
        rigid = energy_loss(-speeds, 0.0, spin, steel.radius, e, -impact.impulse_ratio)
        for loss in (impact.translational_energy_loss, rigid.translational):
            largest = max(largest, np.max(np.abs(loss - (1.0 - np.square(e)))))
    return {"largest_difference": largest}


def rebounding_speeds(case: Context) -> FloatArray:
    """Return normal speeds in m/s from just above capture to the one that is meant."""
    normal = case.params.normal
    least = float(capture_velocity(case.steel)) * (1.0 + normal.above_capture)
    return between((least, case.speed), normal.points)


def c14(context: Context) -> dict[str, float]:
    """Eta of Eq. (13) against the inverse tangent, and the latter and its square below 45 deg."""
    angles = context.all_angles()
    v_n, v_t = velocity_components(context.speed, angles)
    eta = inverse_tangent(np.radians(angles))
    # The signed eta of Eq. (13) is negative: the sphere approaches.
    below = eta[angles < 45.0]
    return {
        "largest_difference_from_eq_13": np.max(np.abs(-v_t / v_n - eta)),
        "least_eta_below_45_deg": np.min(below),
        "least_ratio_of_square_to_eta_below_45_deg": np.min(np.square(below) / below),
    }


def inverse_tangent(angle: FloatArray) -> FloatArray:
    """Return the printed tan^-1 of an angle (rad), read as the reciprocal of the tangent."""
    cotangent: FloatArray = np.sin(0.5 * np.pi - angle) / np.sin(angle)
    return cotangent


def c17(context: Context) -> dict[str, float]:
    """Total speeds that the two printed normal speeds of the spores mean."""
    angles = np.radians(context.params.algebra.spore_angles_deg)
    keys = ("normal_speed_lycopodium_48deg", "normal_speed_lycopodium_38deg")
    speeds = np.array([context.printed(key) for key in keys]) / np.sin(angles)
    return {
        "difference_of_total_speeds": speeds[0] - speeds[1],
        "total_speed": speeds.mean(),
    }


def c18(context: Context) -> dict[str, float]:
    """Restitution from momentum with the adhesion impulse of Eqs. (5) and (10), and by Eq. (16)."""
    R, rho = body_and_adhesion(context)
    v_n = -context.speed
    impulses = (-rho * loading_impulse(v_n, R), adhesion_impulse(v_n, R, rho))
    # e from V_n = v_n + P_D + P_A, impulses per mass.
    found = [-(v_n + deformation_impulse(v_n, R) + adhesive) / v_n for adhesive in impulses]
    found.append(restitution_with_adhesion(R, rho))
    return {"largest_difference_of_restitution": np.max(np.ptp(np.array(found), axis=0))}


def loading_impulse(v_n: float, R: Real) -> Real:
    """Deformation impulse per mass of which adhesion takes the share rho in Eq. (5): rebound's."""
    return deformation_impulse(v_n, R) - approach_impulse(v_n, R)


def approach_impulse(v_n: float, R: Real) -> Real:
    """Deformation impulse per mass of the approach, which stops the sphere, of the shape of R."""
    return deformation_impulse(v_n, np.zeros_like(R))


def body_and_adhesion(context: Context) -> tuple[FloatArray, FloatArray]:
    """Return all pairs of body restitution and adhesion coefficient."""
    algebra = context.params.algebra
    R, rho = np.meshgrid(algebra.restitutions, algebra.adhesion_coefficients)
    return R, rho


def c20(context: Context) -> dict[str, float]:
    """Work of Eq. (18) at rho = 1 over the energy that deformation gives back; farthest from 1."""
    R = np.array(context.params.algebra.restitutions)
    given_back = 0.5 * np.square(restitution_with_adhesion(R, 0.0) * context.speed)
    ratio = adhesion_work(-context.speed, R, 1.0) / given_back
    return {"work_ratio_at_capture": farthest(ratio)}


def farthest(ratios: Real) -> float:
    """Return the ratio that is farthest from 1."""
    flat = np.ravel(ratios)
    return float(flat[np.argmax(np.abs(flat - 1.0))])


def c24(context: Context) -> dict[str, float]:
    """What both works leave of the loss of kinetic energy: simulated rebounds, and Eq. (17)."""
    R, rho = body_and_adhesion(context)
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


def c25(context: Context) -> dict[str, float]:
    """Exponents of the base units in zeta of Eqs. (23), (24), and the exponent that leaves none.

    Found by changing each base unit in all inputs of the contact.
    """
    steel = next(context.cases()).steel
    zeta = unit_exponents(lambda c: c.adhesion_damping / c.damping_unit, steel)
    damping = unit_exponents(lambda c: c.adhesion_damping, steel)
    group = unit_exponents(damping_group, steel)
    return {
        "largest_exponent_of_a_base_unit": float(zeta[np.argmax(np.abs(zeta))]),
        "exponent_that_makes_zeta_dimensionless": float(-(damping @ group) / (group @ group)),
    }


def damping_group(contact: Contact) -> Real:
    """Return what is raised to a power in Eqs. (23), (24): ``r^3 K v_N^(1/2)/m``."""
    speed = np.sqrt(np.asarray(contact.reference_velocity, dtype=np.float64))
    cube: Real = np.power(contact.hertz_radius, 3) * contact.stiffness * speed / contact.mass
    return cube


def unit_exponents(value: Callable[[Contact], Real], contact: Contact) -> FloatArray:
    """Return the exponents of mass, length and time in a number that a contact gives."""
    before = np.asarray(value(contact))
    found = [np.log(value(in_other_units(contact, *powers)) / before) for powers in np.eye(3)]
    exponents: FloatArray = np.array(found) / np.log(UNIT_FACTOR)
    return exponents


def in_other_units(contact: Contact, mass: float, length: float, time: float) -> Contact:
    """Return the contact with its numbers in units smaller by 2 to these powers."""
    m, x, t = UNIT_FACTOR ** np.array([mass, length, time])
    bodies = {
        role: replace(
            body,
            youngs_modulus=body.youngs_modulus * m / (x * t**2),
            density=body.density * m / x**3,
        )
        for role, body in (("particle", contact.particle), ("surface", contact.surface))
    }
    assert contact.work_of_adhesion is not None
    assert contact.reference_velocity is not None
    return contact.replace(
        **bodies,
        diameter=contact.diameter * x,
        work_of_adhesion=contact.work_of_adhesion * m / t**2,
        hertz_damping=contact.hertz_damping * t / x,
        adhesion_damping=contact.adhesion_damping * t / x,
        reference_velocity=contact.reference_velocity * x / t,
    )


def c26(context: Context) -> dict[str, float]:
    """Contact radius at rest with the ring force over that of JKR, ``a^3 = 6 pi w r^2/K``."""
    ratios = []
    for steel in (case.steel for case in context.cases()):
        load = 6.0 * np.pi * np.asarray(steel.work_of_adhesion) * np.square(steel.hertz_radius)
        ratios.append(steel.equilibrium_contact_radius / np.cbrt(load / steel.stiffness))
    return {"ratio_of_contact_radii_at_rest": farthest(np.array(ratios))}


def c44(context: Context) -> dict[str, float]:
    """Eqs. (35), (36) against velocities turned to the slope, rebounded there and turned back."""
    algebra, friction = context.params.algebra, context.params.steel.friction
    angle, slope, e = np.meshgrid(
        np.radians(context.params.steel.angles_deg),
        np.radians(algebra.slopes_deg),
        algebra.restitutions,
    )
    facing = angle + slope > 0.0
    angle, slope, e = angle[facing], slope[facing], e[facing]
    local = rigid_body_rebound(-np.sin(angle + slope), np.cos(angle + slope), 0.0, 1.0, e, friction)
    normal = local.V_n * np.cos(slope) + local.V_t * np.sin(slope)
    along = local.V_t * np.cos(slope) - local.V_n * np.sin(slope)
    restitution = normal / np.sin(angle)
    ratio = (along - np.cos(angle)) / (normal + np.sin(angle))
    differences = (
        measured_restitution(angle, slope, e, local.mu) - restitution,
        measured_impulse_ratio(slope, local.mu) - ratio,
    )
    return {"largest_difference": max(np.max(np.abs(part)) for part in differences)}


_SPEEDS = ("difference_of_total_speeds", "total_speed")

CLAIMS = {
    "C06": Numbers(of=c06),
    "C14": Numbers(of=c14),
    "C17": Numbers(of=c17, units=dict.fromkeys(_SPEEDS, "m/s")),
    "C18": Numbers(of=c18),
    "C20": Numbers(of=c20),
    "C24": Numbers(of=c24),
    "C25": Numbers(of=c25),
    "C26": Numbers(of=c26),
    "C44": Numbers(of=c44),
}
