"""Numbers of the claims of Sections 4.1 and 4.2: what is measured on slopes, one or many."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from microimpact.core.arrays import FloatArray
from microimpact.lab.contacts import calibrated_contact
from microimpact.lab.samples import Dropped, Sampling, rough, with_spin
from microimpact.model.calibration import damping_factor_for
from microimpact.model.contact import Contact
from microimpact.model.rigid_body.algebra import rigid_body_rebound
from microimpact.model.rigid_body.roughness import measured_impulse_ratio, measured_restitution
from microimpact.statistics.distributions import Constant, mean
from microimpact.studies.analyses.roughness_expansions import EQUATIONS, SlopedImpacts
from microimpact.studies.claims.claim_numbers.claim import CALIBRATED, VIRTUAL, claim
from microimpact.studies.claims.claim_numbers.context import Context, Estimate
from microimpact.studies.claims.claim_numbers.oblique import at_angles

SOURCES = ("slope", "diameter", "speed", "spin")
# Steps in which a range of angles is walked, degrees.
COARSE = 1.0


@claim("C44")
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


@claim("C45")
def c45(context: Context) -> dict[str, float]:
    """Measured over true restitution on a facet as steep as the angle of incidence, by Eq. (35)."""
    true = context.params.steel.restitution
    return {"measured_over_true_restitution": steep_restitution(context) / true}


@claim("C46")
def c46(context: Context) -> dict[str, float]:
    """Measured restitution itself on that facet."""
    return {"measured_restitution": steep_restitution(context)}


def steep_restitution(context: Context) -> float:
    """Return e_m by Eq. (35) on the facet as steep as the angle of incidence."""
    slopes = context.params.slopes
    case = shallow(context, slopes.steep_slope_deg)
    return float(EQUATIONS["35"].value(case, slopes.form))


@claim("C47")
def c47(context: Context) -> dict[str, float]:
    """By how much a facing slope changes the exact e_m, mu_m and -mu_m from no slope."""
    slopes = context.params.slopes
    facing, level = (
        shallow(context, degrees).rebound for degrees in (slopes.facing_slope_deg, 0.0)
    )
    change = float(facing.measured_impulse_ratio - level.measured_impulse_ratio)
    return {
        "change_of_restitution": float(facing.measured_restitution - level.measured_restitution),
        "change_of_signed_impulse_ratio": change,
        "change_of_impulse_ratio_as_plotted": -change,
    }


@claim("C48")
def c48(context: Context) -> dict[str, float]:
    """Coefficient of phi^2 in the exact e_m at normal incidence over the printed one, less 1.

    The largest error over all restitutions, and that of the corrected expansion after Eq. (40).
    """
    slopes = context.params.slopes
    squared = np.square(np.radians(slopes.small_slope_deg))
    printed, corrected = [], []
    for e in slopes.restitutions:
        case = upright(context, slopes.small_slope_deg, context.params.steel.spin_ratio, e)
        fall = e - exact(case)[0]
        printed.append(fall / (e - EQUATIONS["after 40"].value(case, "printed")) - 1.0)
        corrected.append((EQUATIONS["after 40"].value(case, "corrected") - e + fall) / squared)
    return {
        "largest_relative_error_of_printed_coefficient": float(np.max(np.abs(printed))),
        "largest_error_of_corrected_coefficient": float(np.max(np.abs(corrected))),
    }


@claim("C49")
def c49(context: Context) -> dict[str, float]:
    """Error of the coefficient of phi in mu_m (Eq. 41), and mu_m without a slope."""
    slopes = context.params.slopes
    phi = float(np.radians(slopes.small_slope_deg))
    errors, level = [], []
    for e in slopes.restitutions:
        sloped, flat = (
            upright(context, degrees, context.params.steel.spin_ratio, e)
            for degrees in (slopes.small_slope_deg, 0.0)
        )
        coefficient = EQUATIONS["41"].value(replace(sloped, spin_ratio=0.0), slopes.form) / phi
        errors.append((exact(sloped)[1] - exact(flat)[1]) / phi - coefficient)
        level.append(exact(flat)[1])
    return {
        "largest_error_of_coefficient_of_slope": float(np.max(np.abs(errors))),
        "impulse_ratio_without_slope": float(np.max(np.abs(level))),
    }


@claim("C50")
def c50(context: Context) -> dict[str, float]:
    """Exact bias by spin over that of Eq. (41), and over (2/7) (r omega / v) phi."""
    slopes = context.params.slopes
    spun, bare = (
        upright(context, slopes.small_slope_deg, spin, context.params.steel.restitution)
        for spin in (slopes.biasing_spin_ratio, 0.0)
    )
    of_e, of_mu = (
        float(with_ - without) for with_, without in zip(exact(spun), exact(bare), strict=True)
    )
    by_41 = float(
        EQUATIONS["41"].value(spun, slopes.form) - EQUATIONS["41"].value(bare, slopes.form)
    )
    first = 2.0 / 7.0 * slopes.biasing_spin_ratio * float(spun.slope)
    return {
        "bias_of_impulse_ratio_over_that_of_eq_41": of_mu / by_41,
        "bias_of_restitution_over_first_order": of_e / first,
    }


def shallow(context: Context, slope_deg: float) -> SlopedImpacts:
    """Return a shallow impact on a slope."""
    steel = context.params.steel
    return SlopedImpacts(
        angle=np.radians(context.params.slopes.angle_deg),
        slope=np.radians(slope_deg),
        e=steel.restitution,
        friction=steel.friction,
        spin_ratio=steel.spin_ratio,
    )


def upright(context: Context, slope_deg: float, spin_ratio: float, e: float) -> SlopedImpacts:
    """Return an impact at normal incidence on a slope."""
    return SlopedImpacts(
        angle=np.pi / 2,
        slope=np.radians(slope_deg),
        e=e,
        friction=context.params.steel.friction,
        spin_ratio=spin_ratio,
    )


def exact(case: SlopedImpacts) -> tuple[FloatArray, FloatArray]:
    """Return e_m and the signed mu_m of the exact rotation."""
    return case.rebound.measured_restitution, case.rebound.measured_impulse_ratio


@claim("C51", evidence=VIRTUAL)
def c51(context: Context) -> dict[str, float | Estimate]:
    """Rise of e_m on Formica, and the change of e on the smooth surface of Fig. 23."""
    steep, shallow = context.params.formica.trend_deg
    return {
        "rise_on_rough_surface_45_to_15_deg_over_half_width": rise(context, "restitution"),
        "change_on_smooth_surface_45_to_15_deg": smooth(
            context, "smooth_relative_restitution", shallow
        )
        - smooth(context, "smooth_relative_restitution", steep),
    }


@claim("C52", evidence=VIRTUAL)
def c52(context: Context) -> dict[str, float | Estimate]:
    """Return -mu of the smooth surface of Fig. 23, and the rise of -mu_m on Formica."""
    _, shallow = context.params.formica.trend_deg
    return {
        "impulse_ratio_of_smooth_surface_at_15_deg": smooth(
            context, "smooth_impulse_ratio", shallow
        ),
        "rise_on_rough_surface_45_to_15_deg_over_half_width": rise(context, "impulse_ratio"),
    }


def rise(context: Context, quantity: str) -> Estimate:
    """Return the rise of a mean on Formica towards the shallow angle, over its half-width."""
    formica = context.params.formica
    steep, shallow = formica.trend_deg
    return context.over_half_width(quantity, (formica.steel, shallow), (formica.steel, steep))


def smooth(context: Context, quantity: str, angle: float) -> float:
    """Return a number of the smooth surface from the table of the Monte Carlo analysis.

    Raises ValueError if the analysis has no such angle.
    """
    return float(context.column("monte_carlo", quantity, angle).iloc[0])


@claim("C60", evidence=VIRTUAL, units="deg")
def c60(context: Context) -> dict[str, float]:
    """Largest declared angle at which e_m exceeds that without slopes significantly."""
    samples = context.params.roughness
    flat = rough(samples.silicon_back, samples.smooth_slope)
    for angle in sorted(context.params.steel.angles_deg, reverse=True):
        # nothing to compare with where the smooth surface keeps the spheres
        bias = context.over_half_width("restitution", (samples.silicon_back, angle), (flat, angle))
        if bias.value > 1.0:
            return {"largest_angle_with_bias_of_restitution": angle}
    return {"largest_angle_with_bias_of_restitution": 0.0}


@claim("C94", evidence=CALIBRATED)
def c94(context: Context) -> dict[str, float]:
    """Differences of relative e_m, Formica with slopes less the same without."""
    samples = context.params.roughness
    apart = {
        angle: abs(departure(context, angle))
        for angle in (*samples.alike_angles_deg, samples.differ_angle_deg)
    }
    return {
        "largest_difference_from_85_to_45_deg": max(apart[a] for a in samples.alike_angles_deg),
        "difference_at_20_deg": apart[samples.differ_angle_deg],
    }


def departure(context: Context, angle: float) -> float:
    """Return e_m with slopes less that without, each less its value at the reference angle."""
    samples, sloped = context.params.roughness, context.params.formica.steel
    flat = rough(sloped, samples.smooth_slope)
    sloped_change, flat_change = (
        restitution(context, one, angle) - restitution(context, one, samples.reference_angle_deg)
        for one in (sloped, flat)
    )
    return sloped_change - flat_change


def restitution(
    context: Context, dropped: Dropped, angle: float, sampling: Sampling | None = None
) -> float:
    """Return the mean measured restitution of a sample."""
    return context.seen(dropped, angle, sampling).statistics["restitution"].mean


@claim("C95", by_case=True)
def c95(context: Context) -> dict[str, dict[str, float]]:
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

    found = context.of_steel(("C95",), residuals)
    return {
        name: {"largest_residual_difference_of_relative_restitution": residual}
        for name, residual in zip(
            ("Formica as supposed", "Formica like silicon"), found, strict=True
        )
    }


@claim("C96", evidence=CALIBRATED)
def c96(context: Context) -> dict[str, float]:
    """Share of the departure of e_m that some sources explain, by angle.

    The departure is that of a sample in which slope, diameter, speed and spin vary from one in
    which none does; the others are at their means, or at none.
    """
    samples = context.params.roughness
    first, second = samples.explained_angles_deg
    shares = {
        f"share_explained_by_slope_and_diameter_at_{angle:g}_deg": share(
            context, samples.pair, angle
        )
        for angle in (first, second)
    }
    singles = {
        f"share_explained_by_{source}_at_{first:g}_deg": share(context, (source,), first)
        for source in SOURCES
    }
    return shares | singles


def share(context: Context, sources: tuple[str, ...], angle: float) -> float:
    """Return the departure that sources alone give over that which all give."""
    none, some, all_ = (varied_restitution(context, kept, angle) for kept in ((), sources, SOURCES))
    return (some - none) / (all_ - none)


def varied_restitution(context: Context, sources: tuple[str, ...], angle: float) -> float:
    """Return the mean measured restitution with only some sources of scatter."""
    samples, sampling = context.params.roughness, context.params.sampling
    dropped = with_spin(
        context.params.formica.steel, mean=0.0, sd=samples.spin_sd if "spin" in sources else 0.0
    )
    if "slope" not in sources:
        dropped = rough(dropped, samples.smooth_slope)
    if "diameter" not in sources:
        dropped = replace(dropped, diameter_um=Constant(at=mean(dropped.diameter_um)))
    if "speed" not in sources:
        still = replace(sampling.dispenser, exit_speed_m_per_s=0.0)
        sampling = replace(sampling, dispenser=still)
    return restitution(context, dropped, angle, sampling)
