"""Numbers of the claims of Sections 4.1 and 4.2: measurements on a slope, and on many."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from microimpact.core.arrays import FloatArray, Real
from microimpact.lab.dispenser import InitialSpin
from microimpact.model.calibration import damping_factor_for
from microimpact.model.contact import Contact
from microimpact.model.rigid_body.algebra import rigid_body_rebound
from microimpact.model.rigid_body.roughness import measured_impulse_ratio, measured_restitution
from microimpact.statistics.distributions import Constant, mean
from study.studies.analyses.roughness_expansions import EQUATIONS, FORMS, SlopedImpacts
from study.studies.claims.claim_numbers.claim import claim
from study.studies.claims.claim_numbers.context import Context, Numbers
from study.studies.claims.claim_numbers.oblique import at_angles
from study.studies.claims.claim_numbers.spores import rise
from study.studies.contacts import calibrated_contact

SOURCES = ("slope", "diameter", "speed", "spin")
# Steps in which a range of angles is walked, degrees.
COARSE = 1.0


@claim("C44")
def c44(context: Context) -> Numbers:
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


@claim("C45")
def c45(context: Context) -> Numbers:
    """Measured over true restitution on a facet as steep as the angle of incidence, by Eq. (35)."""
    true = context.params.steel.restitution
    return {"measured_over_true_restitution": steep_restitution(context) / true}


@claim("C46")
def c46(context: Context) -> Numbers:
    """Measured restitution itself on that facet."""
    return {"measured_restitution": steep_restitution(context)}


def steep_restitution(context: Context) -> float:
    """Return e_m by Eq. (35) on the facet as steep as the angle of incidence."""
    slopes = context.params.slopes
    case = on_slope(context, slopes.angle_deg, slopes.steep_slope_deg)
    return float(EQUATIONS["35"].value(case, slopes.form))


@claim("C47")
def c47(context: Context) -> Numbers:
    """By how much a facing slope changes the exact e_m, mu_m and -mu_m from no slope."""
    slopes = context.params.slopes
    facing, level = (
        on_slope(context, slopes.angle_deg, degrees).rebound
        for degrees in (slopes.facing_slope_deg, 0.0)
    )
    change = facing.measured_impulse_ratio - level.measured_impulse_ratio
    return {
        "change_of_restitution": facing.measured_restitution - level.measured_restitution,
        "change_of_signed_impulse_ratio": change,
        "change_of_impulse_ratio_as_plotted": -change,
    }


@claim("C48")
def c48(context: Context) -> Numbers:
    """Coefficient of phi^2 in the exact e_m at normal incidence over the printed one, less 1.

    The largest error over all restitutions, and that of the corrected expansion after Eq. (40).
    """
    slopes = context.params.slopes
    e = np.array(slopes.restitutions)
    case = on_slope(context, 90.0, slopes.small_slope_deg, e=e)
    exact = case.rebound.measured_restitution
    printed, corrected = (EQUATIONS["after 40"].value(case, form) for form in FORMS)
    errors = (e - exact) / (e - printed) - 1.0, (corrected - exact) / np.square(case.slope)
    return {
        "largest_relative_error_of_printed_coefficient": np.max(np.abs(errors[0])),
        "largest_error_of_corrected_coefficient": np.max(np.abs(errors[1])),
    }


@claim("C49")
def c49(context: Context) -> Numbers:
    """Error of the coefficient of phi in mu_m (Eq. 41), and mu_m without a slope."""
    slopes = context.params.slopes
    sloped, flat = (
        on_slope(context, 90.0, degrees, e=np.array(slopes.restitutions))
        for degrees in (slopes.small_slope_deg, 0.0)
    )
    exact, level = (case.rebound.measured_impulse_ratio for case in (sloped, flat))
    first_order = EQUATIONS["41"].value(replace(sloped, spin_ratio=0.0), slopes.form)
    errors = (exact - level - first_order) / sloped.slope
    return {
        "largest_error_of_coefficient_of_slope": np.max(np.abs(errors)),
        "impulse_ratio_without_slope": np.max(np.abs(level)),
    }


@claim("C50")
def c50(context: Context) -> Numbers:
    """Exact bias by spin over the bias of Eq. (41), and over (2/7) (r omega / v) phi."""
    slopes = context.params.slopes
    spun, bare = (
        on_slope(context, 90.0, slopes.small_slope_deg, spin_ratio=spin)
        for spin in (slopes.biasing_spin_ratio, 0.0)
    )
    exact, unbiased = spun.rebound, bare.rebound
    of_mu = exact.measured_impulse_ratio - unbiased.measured_impulse_ratio
    of_e = exact.measured_restitution - unbiased.measured_restitution
    by_41, bare_41 = (EQUATIONS["41"].value(case, slopes.form) for case in (spun, bare))
    return {
        "bias_of_impulse_ratio_over_that_of_eq_41": of_mu / (by_41 - bare_41),
        "bias_of_restitution_over_first_order": of_e / (2.0 / 7.0 * spun.spin_ratio * spun.slope),
    }


def on_slope(
    context: Context, angle_deg: float, slope_deg: float, **changes: Real
) -> SlopedImpacts:
    """Return an impact on a slope, angles in degrees; changed are ``e`` or ``spin_ratio``."""
    steel = context.params.steel
    impact: dict[str, Any] = {"e": steel.restitution, "spin_ratio": steel.spin_ratio} | changes
    return SlopedImpacts(
        angle=np.radians(angle_deg),
        slope=np.radians(slope_deg),
        friction=steel.friction,
        **impact,
    )


@claim("C51")
def c51(context: Context) -> Numbers:
    """Rise of e_m on Formica, and the change of e on the smooth surface of Fig. 23."""
    formica = context.params.formica
    steep, shallow = (
        context.number("monte_carlo", "smooth_relative_restitution", angle_deg=angle)
        for angle in formica.trend_deg
    )
    risen = rise(context, "restitution", formica.steel)
    return {
        "rise_on_rough_surface_over_half_width": risen,
        "change_on_smooth_surface": shallow - steep,
    }


@claim("C52")
def c52(context: Context) -> Numbers:
    """Return -mu of the smooth surface of Fig. 23, and the rise of -mu_m on Formica."""
    formica, name = context.params.formica, "smooth_impulse_ratio"
    smooth = context.number("monte_carlo", name, angle_deg=formica.trend_deg[1])
    risen = rise(context, "impulse_ratio", formica.steel)
    return {
        "impulse_ratio_of_smooth_surface": smooth,
        "rise_on_rough_surface_over_half_width": risen,
    }


@claim("C60")
def c60(context: Context) -> Numbers:
    """Largest declared angle at which e_m exceeds that without slopes significantly."""
    samples = context.params.roughness
    back = samples.silicon_back
    flat = replace(back, surface_slope=samples.smooth_slope)
    # nothing to compare with where the smooth surface keeps the spheres
    biased = (
        angle
        for angle in sorted(context.params.steel.angles_deg, reverse=True)
        if context.over_half_width("restitution", (back, angle), (flat, angle)).value > 1.0
    )
    return {"largest_angle_with_bias_of_restitution": next(biased, 0.0)}


@claim("C94")
def c94(context: Context) -> Numbers:
    """Differences of relative e_m, Formica with slopes less the same without."""
    samples = context.params.roughness
    alike = [abs(departure(context, angle)) for angle in samples.alike_angles_deg]
    return {
        "largest_difference_at_steep_angles": max(alike),
        "difference_at_shallow_angle": abs(departure(context, samples.differ_angle_deg)),
    }


def departure(context: Context, angle: float) -> float:
    """Return e_m with slopes less that without, each less its value at the reference angle."""
    samples, sloped = context.params.roughness, context.params.formica.steel
    flat = replace(sloped, surface_slope=samples.smooth_slope)
    angles = (angle, samples.reference_angle_deg)
    (e, start), (flat_e, flat_start) = (
        [context.mean("restitution", dropped, at).value for at in angles]
        for dropped in (sloped, flat)
    )
    return float((e - start) - (flat_e - flat_start))


@claim("C95", by_case=True)
def c95(context: Context) -> Numbers:
    """How far relative e of smooth silicon and smooth Formica differ after subtraction.

    With the contact supposed of Formica, and with that of silicon, its damping scaled to the
    restitution on Formica at the reference angle.
    """
    samples = context.params.roughness
    low, high = sorted(samples.relative_angles_deg)
    angle = np.append(np.arange(low, high + COARSE / 2, COARSE), samples.reference_angle_deg)

    def relative(contact: Contact) -> FloatArray:
        e = at_angles(context, contact, angle[:, None]).coefficient_of_restitution
        return np.asarray(e - e[-1])

    def residuals(steel: Contact) -> FloatArray:
        supposed = calibrated_contact(context.inputs, context.params.formica.steel.case)
        aim = at_angles(context, supposed, 90.0).coefficient_of_restitution
        scaled = damping_factor_for(steel, context.speed, float(aim))
        others = np.broadcast_arrays(relative(supposed), relative(scaled))
        left = relative(steel) - np.stack(others)
        return np.asarray(np.max(np.abs(left), axis=1))

    supposed, like_silicon = context.of_steel(("C95",), residuals)
    quantity = "largest_residual_difference_of_relative_restitution"
    return {
        "Formica as supposed": {quantity: supposed},
        "Formica like silicon": {quantity: like_silicon},
    }


@claim("C96")
def c96(context: Context) -> Numbers:
    """Share of the departure of e_m that some sources explain, by angle.

    The departure is that of a sample in which slope, diameter, speed and spin vary from one in
    which none does; the others are at their means, or at none.
    """
    pair, angles = context.params.roughness.pair, context.params.roughness.explained_angles_deg
    larger, smaller = angles
    return {
        "share_explained_by_pair": share(context, pair, larger),
        "share_explained_by_pair_at_shallow_angle": share(context, pair, smaller),
        **{f"share_explained_by_{name}": share(context, (name,), larger) for name in SOURCES},
    }


def share(context: Context, sources: tuple[str, ...], angle: float) -> float:
    """Return the departure that sources alone give over that which all give."""
    bare, partial, whole = (
        varied_restitution(context, kept, angle) for kept in ((), sources, SOURCES)
    )
    return (partial - bare) / (whole - bare)


def varied_restitution(context: Context, sources: tuple[str, ...], angle: float) -> float:
    """Return the mean measured restitution with only some sources of scatter."""
    samples, sampling = context.params.roughness, context.params.sampling
    dropped = replace(
        context.params.formica.steel,
        spin=InitialSpin(mean=0.0, sd=samples.spin_sd if "spin" in sources else 0.0),
    )
    if "slope" not in sources:
        dropped = replace(dropped, surface_slope=samples.smooth_slope)
    if "diameter" not in sources:
        dropped = replace(dropped, diameter_um=Constant(at=mean(dropped.diameter_um)))
    if "speed" not in sources:
        still = replace(sampling.dispenser, exit_speed_m_per_s=0.0)
        sampling = replace(sampling, dispenser=still)
    return float(context.mean("restitution", dropped, angle, sampling).value)
