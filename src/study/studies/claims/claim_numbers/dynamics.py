"""Numbers of the claims of Section 3.2: the simulation of an impact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from microimpact.core.arrays import FloatArray, Real
from microimpact.core.computable import NotComputable
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.dynamics.normal import losses, normal_impact
from microimpact.model.rigid_body.algebra import INERTIA
from microimpact.statistics.intervals import student_half_width
from study.declared.parameters import (
    AngleDegrees,
    CaseName,
    Fraction,
    Name,
    Positive,
    PositiveRange,
)
from study.studies.claims.claim_numbers.claim import claim
from study.studies.claims.claim_numbers.context import (
    Context,
    Estimate,
    Numbers,
    without_adhesion,
)
from study.studies.claims.claim_numbers.experiments import ABOVE_CAPTURE
from study.studies.claims.claim_numbers.experiments import POINTS as CURVE_POINTS
from study.studies.claims.claim_numbers.oblique import sampled
from study.studies.claims.claim_numbers.rigid_body import farthest
from study.studies.contacts import DRAWN, calibrated_contact
from study.studies.samples import Dropped, reduce_to

# Factor by which each base unit (mass, length, time) is changed: a power of two is exact.
UNIT_FACTOR = 2.0
# Tabor (1951): representative strain of an indentation over its radius in sphere radii.
TABOR_STRAIN = 0.2
# Columns of the moments that can arise during an impact, over the moment of friction: from all that
# the impact loses, and from the model's own damping. Those of steady rolling and the bound are none
# of these: an impact rolls through an eighth of the contact radius at most.
MOMENTS = ("impact_over_friction", "damping_over_friction")
# Points of curves over speed.
POINTS = 60
# Columns in which members of the calibrated family differ.
FAMILY = (
    "work_of_adhesion_J_per_m2",
    "hertz_damping_s_per_m",
    "adhesion_damping_s_per_m",
    "rate_exponent",
)


@claim("C25")
def c25(context: Context) -> Numbers:
    """Exponents of the base units in zeta of Eqs. (23), (24), and the exponent that leaves none.

    Found by changing each base unit in all inputs of the contact.
    """
    steel = context.steel
    zeta = unit_exponents(lambda c: c.adhesion_damping / c.damping_unit, steel)
    damping = unit_exponents(lambda c: c.adhesion_damping, steel)
    group = unit_exponents(damping_group, steel)
    return {
        "largest_exponent_of_a_base_unit": zeta[np.argmax(np.abs(zeta))],
        "exponent_that_makes_zeta_dimensionless": -(damping @ group) / (group @ group),
    }


def damping_group(contact: Contact) -> Real:
    """Return the base of the powers in Eqs. (23), (24): ``r^3 K v_N^(1/2)/m``."""
    speed = np.sqrt(np.asarray(contact.reference_velocity, dtype=np.float64))
    cube: Real = np.power(contact.hertz_radius, 3) * contact.stiffness * speed / contact.mass
    return cube


def unit_exponents(value: Callable[[Contact], Real], contact: Contact) -> FloatArray:
    """Return the exponents of mass, length and time in a number that a contact gives."""
    before = np.asarray(value(contact))
    logarithms = [np.log(value(in_other_units(contact, *powers)) / before) for powers in np.eye(3)]
    exponents: FloatArray = np.array(logarithms) / np.log(UNIT_FACTOR)
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


@claim("C26")
def c26(context: Context) -> Numbers:
    """Contact radius at rest with the ring force over the JKR radius, ``a^3 = 6 pi w r^2/K``."""
    ratios = []
    for steel in (case.steel for case in context.cases()):
        load = 6.0 * np.pi * np.asarray(steel.work_of_adhesion) * np.square(steel.hertz_radius)
        ratios.append(steel.equilibrium_contact_radius / np.cbrt(load / steel.stiffness))
    return {"ratio_of_contact_radii_at_rest": farthest(np.array(ratios))}


@claim("C27", by_contact=True)
def c27(context: Context, *, capture_velocities: tuple[Positive, Positive, Positive]) -> Numbers:
    """Share of the adhesion's damping in all that is lost, at multiples of the capture velocity.

    The capture velocity is that which the calibration met.
    """
    speeds = np.array(capture_velocities)[:, None] * context.calibrated_capture_velocity
    shares = losses(context.steel, speeds).adhesion_share
    names = (f"adhesion_share_at_{speed}_speed" for speed in ("low", "middle", "high"))
    return dict(zip(names, shares, strict=True))


@claim("C28", by_case=True)
def c28(context: Context) -> Numbers:
    """Restitution at the high speed and capture velocity, less the printed ones."""
    e = simulate(context.steel, context.speed).coefficient_of_restitution
    limit = capture_velocity(context.steel)
    return {
        "residual_of_restitution": e - context.printed("restitution_sst76_silicon"),
        "residual_of_capture_velocity": limit - context.printed("capture_velocity_sst_silicon"),
    }


@claim("C29", by_contact=True)
def c29(context: Context, *, slow_speed_m_per_s: Positive) -> Numbers:
    """Greatest compression with the ring force over that without: the least over speeds."""
    speeds = np.geomspace(slow_speed_m_per_s, context.speed, CURVE_POINTS)[:, None]
    both = context.steel, without_adhesion(context.steel)
    deep, bare = (normal_impact(contact, speeds).maximum_compression for contact in both)
    return {"least_ratio_of_compression_with_to_without_adhesion": np.min(deep / bare, axis=0)}


@claim("C30")
def c30(context: Context) -> Numbers:
    """Least normal force before and after the greatest compression, over the greatest force."""
    force = context.table("force_ratios").set_index("quantity")["value"]
    peak, first, second = force[["peak_normal_force", "dip_on_approach", "dip_on_rebound"]]
    return {
        "first_dip_over_peak_force": first / peak,
        "second_dip_over_peak_force": second / peak,
        "ratio_of_second_to_first_dip": second / first,
    }


@claim("C31")
def c31(context: Context, *, case: CaseName) -> Numbers:
    """Work of adhesion that gives the printed ring force by Eq. (30)."""
    return {"work_of_adhesion_by_eq_30": calibrated_contact(context.inputs, case).work_of_adhesion}


@claim("C32")
def c32(context: Context) -> Numbers:
    """Greatest ring force over greatest Hertz force."""
    ratio = "peak_adhesion_over_peak_hertz"
    return {ratio: context.number("force_ratios", "value", quantity=ratio)}


@claim("C33")
def c33(context: Context) -> Numbers:
    """Greatest damping force of adhesion over greatest ring force."""
    ratio = "peak_adhesion_dissipation_over_adhesion"
    return {ratio: context.number("force_ratios", "value", quantity=ratio)}


@claim("C34")
def c34(context: Context, *, diameter_um: Positive) -> Numbers:
    """Ends of the interval of capture velocities over the contacts that both ratios admit."""
    rows = context.table("molybdenum_capture", diameter_um=diameter_um)
    low, high = rows[["low_m_per_s", "high_m_per_s"]].iloc[0]
    return {
        "least_capture_velocity": low,
        "greatest_capture_velocity": high,
        "greatest_over_least_capture_velocity": high / low,
    }


@claim("C35")
def c35(context: Context, *, on_mica: CaseName, on_molybdenum: CaseName) -> Numbers:
    """Capture velocity of the calibrated contact on mica, and its work over that on molybdenum."""
    mica, molybdenum = (
        calibrated_contact(context.inputs, case) for case in (on_mica, on_molybdenum)
    )
    ratio = np.asarray(mica.work_of_adhesion) / np.asarray(molybdenum.work_of_adhesion)
    return {
        "capture_velocity": capture_velocity(mica),
        "work_of_adhesion_over_that_on_molybdenum": ratio,
    }


@claim("C36", by_case=True)
def c36(context: Context) -> Numbers:
    """Capture velocity of the calibrated contact."""
    return {"capture_velocity": capture_velocity(context.steel)}


@claim("C37", by_contact=True)
def c37(
    context: Context, *, diameters_um: dict[Name, Positive], speeds_m_per_s: PositiveRange
) -> Numbers:
    """Shortest and longest contact of the rebounds over a range of speeds, by size class."""
    sizes = np.array(list(diameters_um.values()))[:, None] * 1e-6
    spheres = resized(context.steel, sizes)
    # Just above its capture velocity contact lasts longest: that speed is added.
    limit = np.clip(capture_velocity(spheres) * (1.0 + ABOVE_CAPTURE), *speeds_m_per_s)
    speeds = np.geomspace(*speeds_m_per_s, CURVE_POINTS)[:, None, None]
    speeds = np.concatenate([np.broadcast_to(speeds, (CURVE_POINTS, *limit.shape)), limit[None]])
    impact = normal_impact(spheres, speeds)
    times = np.where(impact.captured, np.nan, impact.contact_time * 1e9)
    shortest, longest = np.fmin.reduce(times), np.fmax.reduce(times)
    if np.isnan(shortest).any(axis=0).all():
        raise NotComputable("C37.speeds_m_per_s: no sphere rebounds at them")
    return {
        name: {"shortest_contact": least, "longest_contact": most}
        for name, least, most in zip(diameters_um, shortest, longest, strict=True)
    }


@claim("C38", by_contact=True)
def c38(context: Context) -> Numbers:
    """Strain of a normal impact over half its duration, by two measures of strain."""
    steel = context.steel
    impact = context.impacts(context.speed)
    reach = steel.radius * impact.contact_time / 2.0
    contact_radius = np.sqrt(steel.hertz_radius * impact.maximum_compression)
    return {
        "rate_of_radius_strain": contact_radius / reach,
        "rate_of_tabor_strain": TABOR_STRAIN * contact_radius / reach,
    }


@claim("C39", by_contact=True)
def c39(context: Context, *, angle_deg: AngleDegrees) -> Numbers:
    """Spin after the impact at 50 deg."""
    return {"final_spin": context.impacts(context.speed, angle_deg).spin}


@claim("C41", by_case=True)
def c41(context: Context, *, dropped: Dropped, angle_deg: AngleDegrees) -> Numbers:
    """Excess of the loss without rotation over the true one, and the share of rotation.

    The gap of the means over the half-width of the 95 % interval that an experiment has for the
    loss without rotation, the largest over the declared angles; the least gap, and the share of
    rotation in the final energy at 50 deg, of the mean sphere.
    """
    steel, angles = context.steel, context.params.steel.angles_deg
    oblique = np.array([angle for angle in angles if angle < 90.0])
    gaps = [gap_over_half_width(context, dropped, float(angle)) for angle in oblique]
    impact = context.rebounds(oblique)
    loss = impact.translational_energy_loss - impact.energy_loss
    after = context.hit(steel, context.speed, angle_deg)
    rotation = INERTIA * np.square(steel.radius * after.spin)
    moving = np.square(after.normal_velocity) + np.square(after.tangential_velocity)
    return {
        "largest_gap_of_losses_over_half_width": max(gaps),
        "least_gap_of_losses": np.min(loss[~impact.captured]),
        "rotational_share_of_final_energy": rotation / (rotation + moving),
    }


def gap_over_half_width(context: Context, dropped: Dropped, angle: float) -> float:
    """Return the gap of both losses over the half-width of that which is measured.

    It is 0 where so few rebound that there is no such experiment.
    """
    params = context.params
    impacts = sampled(context, replace(dropped, friction=params.steel.friction), angle)
    free = impacts.select(~impacts.captured)
    if len(free) < params.sampling.events:
        return 0.0
    loss = reduce_to(free.in_plane, len(impacts), params.sampling).means["energy_loss"]
    # Rotational energy gained over the translational energy before.
    gained = np.sum(np.square(free.rebound_spin) - np.square(free.spin), axis=1)
    before = np.sum(np.square(free.velocity), axis=1)
    gap = np.mean(INERTIA * np.square(0.5 * free.diameter) * gained / before)
    return float(gap / student_half_width(loss.sd, params.sampling.events, loss.systematic))


@claim("C42", by_case=True)
def c42(context: Context, *, stiffness_error: Fraction) -> Numbers:
    """Greatest impulse of the moments possible in an impact over the impulse of friction.

    Over all rebounds of the table; beside it what steady rolling would give and what no moment
    exceeds, the greatest contact radius over the radius, which goes as the fifth root of the
    stiffness, and the distance rolled over it.
    """
    table = context.table("rolling_dissipation")
    rows = table[table["captured"].astype(str) == "False"]
    if rows.empty:
        raise NotComputable("rolling_dissipation: no rebound")
    largest = rows.max(numeric_only=True)
    arm = largest["contact_radius_over_r"]
    return {
        "largest_rolling_moment_over_friction_moment": largest[list(MOMENTS)].max(),
        "largest_contact_radius_over_radius": Estimate(arm, stiffness_error / 5.0 * arm),
        "largest_moment_of_steady_rolling_over_friction_moment": largest["steady_over_friction"],
        "largest_bound_of_moment_over_friction_moment": largest["bound_over_friction"],
        "largest_distance_rolled_over_contact_radius": largest["rolled_over_contact_radius"],
    }


@claim("C70", by_contact=True)
def c70(context: Context) -> Numbers:
    """Share of the loss at the nominal speed that goes into damped adhesion."""
    return {"adhesion_share_of_normal_loss": losses(context.steel, context.speed).adhesion_share}


@claim("C99", by_case=True)
def c99(
    context: Context,
    *,
    held_out_speeds_m_per_s: tuple[Positive, ...],
    open_speed_m_per_s: Positive,
    flat_within: Positive,
) -> Numbers:
    """Error of e at speeds not fitted, and how far members of the family differ.

    Members that keep e flat enough, of all rate exponents.
    """
    contact = context.steel
    e = simulate(contact, np.array(held_out_speeds_m_per_s)).coefficient_of_restitution
    table = context.table("calibration_family")
    flat = table[table["deviation_from_plateau"] <= flat_within]
    if flat.empty:
        raise NotComputable("flat_within: no member of the calibrated family is so flat")
    fields = {DRAWN[name]: flat[name].to_numpy(float) for name in FAMILY}
    members = contact.replace(**fields)
    at_open_speed = simulate(members, open_speed_m_per_s).coefficient_of_restitution
    error = np.max(np.abs(e - context.params.steel.restitution))
    return {"largest_error": error, "spread_of_members": np.ptp(at_open_speed)}


@claim("C100", by_case=True)
def c100(context: Context, *, speeds_m_per_s: PositiveRange) -> Numbers:
    """Change of e if the zeta of Eqs. (23) and (24) is held, with v_N the speed of each impact."""
    contact = context.steel
    speed = np.geomspace(*speeds_m_per_s, POINTS)
    unit = contact.replace(reference_velocity=speed).damping_unit / contact.damping_unit
    held = contact.replace(
        hertz_damping=contact.hertz_damping * unit, adhesion_damping=contact.adhesion_damping * unit
    )
    e, each = (simulate(c, speed).coefficient_of_restitution for c in (contact, held))
    return {"largest_change_of_restitution_with_each_speed": np.max(np.abs(each - e))}


@claim("C103")
def c103(context: Context) -> Numbers:
    """Ratio of r/T_H to the group of Eqs. (23) and (24), for an elastic sphere."""
    elastic = context.steel.replace(
        work_of_adhesion=0.0,
        hertz_damping=0.0,
        adhesion_damping=0.0,
        reference_velocity=context.speed,
    )
    period = hertz_period(elastic, context.speed)
    return {"ratio_of_expressions": elastic.hertz_radius / period * elastic.damping_unit}


def hertz_period(elastic: Contact, speed: float) -> Real:
    """Return the duration of an elastic impact without adhesion, s."""
    return float(simulate(elastic, speed).contact_time)
