"""Numbers of the claims of Sections 4.1 and 4.2: measurements on a slope, and on many."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from microimpact.core.arrays import FloatArray, Real
from microimpact.lab.dispenser import NO_SPIN, InitialSpin
from microimpact.model.contact import Contact
from microimpact.statistics.distributions import Constant, mean
from study.declared.parameters import AngleDegrees, CaseName, Fraction, NonNegative
from study.studies.analyses.roughness_expansions import EQUATIONS, FORMS, SlopedImpacts
from study.studies.claims.claim_numbers.claim import claim
from study.studies.claims.claim_numbers.context import AngleRange, Angles, Context, Numbers
from study.studies.claims.claim_numbers.spores import rise
from study.studies.contacts import calibrated_contact
from study.studies.samples import Dropped

SOURCES = ("slope", "diameter", "speed", "spin")
# Steps in which a range of angles is walked, degrees.
COARSE = 1.0
# Of expansions at normal incidence: terms of higher order are below a millionth.
SMALL_SLOPE_DEG = 0.1
# From which relative restitution counts (Section 4.2).
REFERENCE_DEG = 85.0

Source = Literal["slope", "diameter", "speed", "spin"]
SlopeForm = Literal["corrected", "printed"]
FacingDegrees = Annotated[float, Field(gt=-90, lt=90)]


@claim("C45")
def c45(
    context: Context, *, form: SlopeForm, angle_deg: AngleDegrees, slope_deg: FacingDegrees
) -> Numbers:
    """Measured over true restitution on a facet as steep as the angle of incidence, by Eq. (35)."""
    measured = EQUATIONS["35"].value(on_slope(context, angle_deg, slope_deg), form)
    return {"measured_over_true_restitution": measured / context.params.steel.restitution}


@claim("C46")
def c46(
    context: Context, *, form: SlopeForm, angle_deg: AngleDegrees, slope_deg: FacingDegrees
) -> Numbers:
    """Measured restitution itself on that facet."""
    measured = EQUATIONS["35"].value(on_slope(context, angle_deg, slope_deg), form)
    return {"measured_restitution": measured}


@claim("C47")
def c47(context: Context, *, angle_deg: AngleDegrees, slope_deg: FacingDegrees) -> Numbers:
    """By how much a facing slope changes the exact e_m, mu_m and -mu_m from no slope."""
    facing, level = (on_slope(context, angle_deg, slope).rebound for slope in (slope_deg, 0.0))
    change = facing.measured_impulse_ratio - level.measured_impulse_ratio
    return {
        "change_of_restitution": facing.measured_restitution - level.measured_restitution,
        "change_of_signed_impulse_ratio": change,
        "change_of_impulse_ratio_as_plotted": -change,
    }


@claim("C48")
def c48(context: Context, *, restitutions: tuple[Fraction, ...]) -> Numbers:
    """Coefficient of phi^2 in the exact e_m at normal incidence over the printed one, less 1.

    The largest error over all restitutions, and that of the corrected expansion after Eq. (40).
    """
    e = np.array(restitutions)
    case = on_slope(context, 90.0, SMALL_SLOPE_DEG, e=e)
    exact = case.rebound.measured_restitution
    printed, corrected = (EQUATIONS["after 40"].value(case, form) for form in FORMS)
    errors = (e - exact) / (e - printed) - 1.0, (corrected - exact) / np.square(case.slope)
    return {
        "largest_relative_error_of_printed_coefficient": np.max(np.abs(errors[0])),
        "largest_error_of_corrected_coefficient": np.max(np.abs(errors[1])),
    }


def on_slope(
    context: Context, angle_deg: float, slope_deg: float, **changes: Real
) -> SlopedImpacts:
    """Return an impact on a slope, angles in degrees; changed are ``e`` or ``spin_ratio``."""
    steel = context.params.steel
    impact: dict[str, Any] = {"e": steel.restitution, "spin_ratio": steel.spin_ratio} | changes
    return SlopedImpacts(
        angle=np.radians(angle_deg), slope=np.radians(slope_deg), friction=steel.friction, **impact
    )


@claim("C51")
def c51(context: Context, *, dropped: Dropped, trend_deg: AngleRange) -> Numbers:
    """Rise of e_m on Formica, and the change of e on the smooth surface of Fig. 23."""
    steep, shallow = (
        context.number("monte_carlo", "smooth_relative_restitution", angle_deg=angle)
        for angle in trend_deg
    )
    risen = rise(context, "restitution", dropped, trend_deg)
    return {
        "rise_on_rough_surface_over_half_width": risen,
        "change_on_smooth_surface": shallow - steep,
    }


@claim("C52")
def c52(context: Context, *, dropped: Dropped, trend_deg: AngleRange) -> Numbers:
    """Return -mu of the smooth surface of Fig. 23, and the rise of -mu_m on Formica."""
    smooth = context.number("monte_carlo", "smooth_impulse_ratio", angle_deg=trend_deg[1])
    risen = rise(context, "impulse_ratio", dropped, trend_deg)
    return {
        "impulse_ratio_of_smooth_surface": smooth,
        "rise_on_rough_surface_over_half_width": risen,
    }


@claim("C60")
def c60(context: Context, *, dropped: Dropped) -> Numbers:
    """Largest declared angle at which e_m exceeds that without slopes significantly."""
    flat = replace(dropped, surface_slope=0.0)
    # nothing to compare with where the smooth surface keeps the spheres
    biased = (
        angle
        for angle in sorted(context.params.steel.angles_deg, reverse=True)
        if context.over_half_width("restitution", (dropped, angle), (flat, angle)).value > 1.0
    )
    return {"largest_angle_with_bias_of_restitution": next(biased, 0.0)}


@claim("C94")
def c94(
    context: Context, *, dropped: Dropped, alike_angles_deg: Angles, differ_angle_deg: AngleDegrees
) -> Numbers:
    """Differences of relative e_m, Formica with slopes less the same without."""
    alike = [abs(departure(context, dropped, angle)) for angle in alike_angles_deg]
    return {
        "largest_difference_at_steep_angles": max(alike),
        "difference_at_shallow_angle": abs(departure(context, dropped, differ_angle_deg)),
    }


def departure(context: Context, sloped: Dropped, angle: float) -> float:
    """Return e_m with slopes less that without, each less its value at the reference angle."""
    flat = replace(sloped, surface_slope=0.0)
    (e, start), (flat_e, flat_start) = (
        [context.mean("restitution", dropped, at).value for at in (angle, REFERENCE_DEG)]
        for dropped in (sloped, flat)
    )
    return float((e - start) - (flat_e - flat_start))


@claim("C95", by_contact=True)
def c95(context: Context, *, case: CaseName, angles_deg: AngleRange) -> Numbers:
    """Difference of relative e between silicon and Formica, both smooth."""
    low, high = sorted(angles_deg)
    angle = np.append(np.arange(low, high + COARSE / 2, COARSE), REFERENCE_DEG)
    steel, supposed = context.steel, calibrated_contact(context.inputs, case)

    def relative(contact: Contact) -> FloatArray:
        e = context.hit(contact, context.speed, angle[:, None]).coefficient_of_restitution
        return np.asarray(e - e[-1])

    residual = np.max(np.abs(relative(steel) - relative(supposed)), axis=0)
    return {"largest_residual_difference_of_relative_restitution": residual}


@claim("C96")
def c96(
    context: Context,
    *,
    dropped: Dropped,
    pair: tuple[Source, ...],
    angles_deg: AngleRange,
    spin_sd: NonNegative,
) -> Numbers:
    """Share of the departure of e_m that some sources explain, by angle.

    The departure is that of a sample in which slope, diameter, speed and spin vary from one in
    which none does; the others are at their means, or at none.
    """
    larger, smaller = angles_deg
    spun = replace(dropped, spin=InitialSpin(mean=0.0, sd=spin_sd))

    def share(sources: tuple[str, ...], angle: float) -> float:
        bare, partial, whole = (
            varied_restitution(context, spun, kept, angle) for kept in ((), sources, SOURCES)
        )
        return (partial - bare) / (whole - bare)

    return {
        "share_explained_by_pair": share(pair, larger),
        "share_explained_by_pair_at_shallow_angle": share(pair, smaller),
        **{f"share_explained_by_{name}": share((name,), larger) for name in SOURCES},
    }


def varied_restitution(
    context: Context, dropped: Dropped, sources: tuple[str, ...], angle: float
) -> float:
    """Return the mean measured restitution with only some sources of scatter."""
    if "spin" not in sources:
        dropped = replace(dropped, spin=NO_SPIN)
    if "slope" not in sources:
        dropped = replace(dropped, surface_slope=0.0)
    if "diameter" not in sources:
        dropped = replace(dropped, diameter_um=Constant(at=mean(dropped.diameter_um)))
    if "speed" not in sources:
        still = replace(context.params.sampling.dispenser, exit_speed_m_per_s=0.0)
        context = context.drawing(dispenser=still)
    return float(context.mean("restitution", dropped, angle).value)
