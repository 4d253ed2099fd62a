"""Numbers of the claims of Sections 2.4.1 and 2.4.2: oblique impacts on silicon and mirrors."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pandas as pd

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.computable import NotComputable
from microimpact.core.solve import IntArray, root, threshold
from microimpact.lab.dispenser import NO_SPIN, InitialSpin
from microimpact.lab.events import Impacts
from microimpact.lab.experiment import SpeedClass, StopRule
from microimpact.lab.ptis.experiment import collect
from microimpact.lab.reduction import EXACT, Mean
from microimpact.model.dynamics.impact import simulate, velocity_components
from microimpact.model.rigid_body.roughness import measured_restitution
from microimpact.statistics.distributions import generator
from study.declared.parameters import (
    AngleDegrees,
    Count,
    Finite,
    Fraction,
    Name,
    NonNegative,
    ObliqueDegrees,
    Positive,
)
from study.studies.claims.claim_numbers.claim import claim
from study.studies.claims.claim_numbers.context import (
    AngleRange,
    Angles,
    Context,
    Estimate,
    Numbers,
    SteepToShallow,
    of_share,
    over_draws,
)
from study.studies.experiments.mechanisms.impulse_regions import REGION_ANGLES, regions
from study.studies.experiments.mechanisms.loss import departures
from study.studies.experiments.mechanisms.spin import rolling_limit
from study.studies.samples import Dropped, half_width, in_class

# Speeds in m/s between which that of capture is sought: none below, all above.
SLOWEST, FASTEST = 1e-3, 1e2
# Steps in which ranges of angles are walked, degrees.
COARSE, FINE = 1.0, 0.01
COARSE_STEPS = round(COARSE / FINE)
# Curves of rebounds begin so much above the normal speed of capture.
ABOVE_CAPTURE = 1e-6
# Greatest spread of spins, r omega/v, that is tried.
WIDEST_SPREAD = 10.0
# Second number of the key of the stream of repeated experiments; the first is that of the claim.
ANALYSIS, SPREAD = 109, 0
# Points of curves over angles and facets, and spins tried from back spin to rolling.
POINTS, TRIED_SPINS = 61, 41
# How far a constant region of the impulse ratio may stray, and the least width of a transition that
# is seen, degrees.
CONSTANT_WITHIN, LEAST_TRANSITION = 0.1, 5.0
# Pairs of surfaces in the table of the mechanisms.
SLOPES_ALONE, HALF_ADHESION, MIRROR = "silicon", "silicon, half the adhesion", "mirror"


@claim("C09")
def c09(context: Context, *, angles_deg: AngleRange, facet_slope_deg: Finite) -> Numbers:
    """Normal speed of capture at 30 deg over that at 90 deg, the larger ratio of all cases."""
    shallow, steep = angles_deg
    ratios = [
        normal_capture_speed(case, shallow, facet_slope_deg)
        / normal_capture_speed(case, steep, facet_slope_deg)
        for case in context.cases()
    ]
    return {"ratio_of_normal_capture_speeds": max(ratios)}


def normal_capture_speed(context: Context, angle: float, facet_slope: float) -> float:
    """Return the speed normal to the nominal surface at which simulated impacts begin to rebound.

    The sphere meets a facet that faces it by a slope, degrees, as a rule none.
    """
    steel, local = context.steel, angle + facet_slope
    local = min(local, 180.0 - local)

    def rebounds(log_speed: float) -> bool:
        return not context.hit(steel, np.exp(log_speed), local).captured

    speed = np.exp(threshold(rebounds, np.log(SLOWEST), np.log(FASTEST)))
    return float(speed * np.sin(np.radians(angle)))


@claim("C10", by_contact=True)
def c10(context: Context) -> Numbers:
    """Angle at which the sphere that leaves begins to roll."""
    low, steel = context.shallowest_rebounds(), context.steel

    def rolls(angle: FloatArray) -> BoolArray:
        return context.hit(steel, context.speed, angle).rolling

    high = np.full(low.shape, 90.0)
    known = ~rolls(low) & rolls(high)

    def begun(angle: FloatArray) -> BoolArray:
        return np.where(known, rolls(angle), angle >= 90.0)

    limit = np.where(known, threshold(begun, low - ~known, high), np.nan)
    return {"rolling_to_sliding_angle": limit}


@claim("C11")
def c11(context: Context, *, angles_deg: AngleRange) -> Numbers:
    """Greatest true and measured restitution over shallow angles and facets up to the angle.

    The impact with the facet is simulated; Eq. (35) gives what is measured about the nominal
    surface. The largest over all cases.
    """
    angles = np.linspace(*angles_deg, POINTS)[:, None]
    slopes = angles * np.linspace(0.0, 1.0, POINTS)
    true, measured, bounded = [], [], []
    for case in context.cases():
        impact = case.hit(case.steel, context.speed, angles + slopes)
        e, mu = impact.coefficient_of_restitution, -impact.impulse_ratio
        seen = np.asarray(measured_restitution(np.radians(angles), np.radians(slopes), e, mu))
        free = ~impact.captured
        if not free.any():
            raise NotComputable(f"C11.angles_deg: no rebound at {context.speed:g} m/s")
        true.append(e[free].max())
        measured.append(seen[free].max())
        bounded.append((seen * np.sin(np.radians(angles)))[free].max())
    return {
        "largest_true_restitution": max(true),
        "largest_measured_restitution": max(measured),
        "largest_measured_restitution_times_sine": max(bounded),
    }


@claim("C12", by_contact=True)
def c12(context: Context, *, speed_m_per_s: Positive, angles_deg: SteepToShallow) -> Numbers:
    """Change of the translational loss between 85 and 50 deg, over its value at 85 deg."""
    loss = translational_loss(context, speed_m_per_s, *angles_deg)
    change = np.max(np.abs(loss / loss[0] - 1.0), axis=0)
    return {"largest_relative_change_of_energy_loss": change}


@claim("C13", by_contact=True)
def c13(context: Context, *, angles_deg: SteepToShallow) -> Numbers:
    """Translational loss at 10 deg, and its greatest rise above any value at a steeper angle."""
    loss = translational_loss(context, context.speed, *angles_deg)
    return {
        "energy_loss_at_shallow_angle": loss[-1],
        "largest_rise_towards_shallow_angles": np.max(
            loss - np.minimum.accumulate(loss, axis=0), axis=0
        ),
    }


def translational_loss(context: Context, speed: float, *steep_to_shallow: float) -> FloatArray:
    """Return the loss of Eq. (3) in all steps from the steep angle to the shallow one."""
    angles = context.all_angles(*steep_to_shallow)
    return np.asarray(context.impacts(speed, angles).translational_energy_loss)


@claim("C14")
def c14(context: Context) -> Numbers:
    """Eta of Eq. (13) against the inverse tangent, and the latter and its square below 45 deg."""
    angles = context.all_angles()
    v_n, v_t = velocity_components(context.speed, angles)
    eta = inverse_tangent(np.radians(angles))
    # The signed eta of Eq. (13) is negative: the sphere approaches.
    below = eta[angles < 45.0]
    return {
        "largest_difference_from_eq_13": np.max(np.abs(-v_t / v_n - eta)),
        "least_eta": np.min(below),
        "least_ratio_of_square_to_eta": np.min(np.square(below) / below),
    }


def inverse_tangent(angle: FloatArray) -> FloatArray:
    """Return the printed tan^-1 of an angle (rad), read as the reciprocal of the tangent."""
    cotangent: FloatArray = np.sin(0.5 * np.pi - angle) / np.sin(angle)
    return cotangent


@claim("C15", by_case=True)
def c15(
    context: Context, *, speed_m_per_s: Positive, angle_deg: AngleDegrees, spin_ratio: Finite
) -> Numbers:
    """Impulse ratio of a slow oblique impact with the spin of a sphere that has rolled."""
    contact = context.steel
    spin = spin_ratio * speed_m_per_s / contact.radius
    impact = simulate(contact, speed_m_per_s, angle_deg, spin)
    return {"impulse_ratio_with_greatest_spin": impact.impulse_ratio}


@claim("C16", by_case=True)
def c16(
    context: Context,
    *,
    dropped: Dropped,
    speed_m_per_s: Positive,
    normal_speed_below_m_per_s: Positive,
) -> Numbers:
    """Share captured, and mean restitution, of slow impacts below a normal speed.

    At the declared angles at which the nominal speed leads there. A captured sphere counts with the
    restitution 0 that it has: where none rebounds there is no other mean.
    """
    angles, limit = np.array(context.params.steel.angles_deg), normal_speed_below_m_per_s
    slow = replace(dropped, speed_m_per_s=speed_m_per_s)
    below = angles[speed_m_per_s * np.sin(np.radians(angles)) < limit]
    stayed, restitution = [], []
    for angle in below:
        impacts = sampled(context, slow, float(angle))
        chosen = impacts.select(-impacts.velocity[:, 2] < limit)
        stayed += chosen.captured.tolist()
        rebound = np.where(chosen.captured, 0.0, chosen.rebound_velocity[:, 2])
        restitution += (-rebound / chosen.velocity[:, 2]).tolist()
    return {
        "captured_share": of_share(np.mean(stayed), len(stayed)),
        "mean_restitution": np.mean(restitution),
    }


def sampled(context: Context, dropped: Dropped, angle: float) -> Impacts:
    """Return the impacts of the speed class at one angle, of the context's case."""
    impacts = context.sample(dropped).impacts(angle)
    return impacts.select(in_class(dropped, impacts))


@claim("C67", by_case=True)
def c67(context: Context, *, dropped: Dropped, spin_sd: NonNegative) -> Numbers:
    """Kinds of regions of the mean impulse ratio, and the transition, with and without spins."""
    spun = replace(dropped, spin=InitialSpin(mean=0.0, sd=spin_sd))
    return {
        "no spin": found_regions(context, dropped),
        "spins of either sense": found_regions(context, spun),
    }


def found_regions(context: Context, dropped: Dropped) -> Numbers:
    """Return the kinds of regions between change points, and the width of the transition."""
    angle = REGION_ANGLES
    means = [context.series.mean("impulse_ratio", dropped, a) for a in angle.tolist()]
    mean, error = np.array(means, dtype=float).T
    known = np.isfinite(mean)
    if not known.any():
        raise NotComputable("at no angle is there a mean of rebounds")
    parts = regions(angle[known], mean[known], error[known], CONSTANT_WITHIN)
    width = sum(part["width_deg"] for part in parts if part["region"] == "transition")
    kinds = {part["region"] for part in parts}
    if width < LEAST_TRANSITION:
        kinds.discard("transition")
    return {"regions_found": len(kinds), "width_of_transition": width}


@claim("C68", by_contact=True)
def c68(
    context: Context, *, plateau_angles_deg: AngleRange, grazing_angle_deg: AngleDegrees
) -> Numbers:
    """How far e strays from the printed plateau, and e at the grazing angle."""
    low, high = sorted(plateau_angles_deg)
    angle = np.arange(low, high + COARSE / 2, COARSE)
    level, grazing = (
        context.impacts(context.speed, angles).coefficient_of_restitution
        for angles in (angle, grazing_angle_deg)
    )
    stray = np.abs(level - context.params.steel.restitution)
    return {
        "largest_difference_from_plateau": np.max(stray, axis=0),
        "restitution_at_grazing_angle": grazing,
    }


@claim("C69", by_contact=True)
def c69(context: Context, *, level_angles_deg: AngleRange, rise_angles_deg: AngleRange) -> Numbers:
    """Ratios of impulse ratios between angles, friction following the declared force."""
    return {
        "level_of_impulse_ratio": quotient(context, level_angles_deg),
        "rise_of_impulse_ratio": quotient(context, rise_angles_deg),
        "rise_of_impulse_ratio_hertz": quotient(context, rise_angles_deg, "hertz"),
        "rise_of_impulse_ratio_net": quotient(context, rise_angles_deg, "net"),
    }


def quotient(context: Context, angles: tuple[float, float], basis: str = "") -> FloatArray:
    """Return the impulse ratio at one angle over that at another."""
    ratio = context.impacts(context.speed, np.array(angles), basis).impulse_ratio
    return np.asarray(ratio[0] / ratio[1])


@claim("C71")
def c71(context: Context, *, angles_deg: tuple[AngleDegrees, ...]) -> Numbers:
    """Least difference of restitution above 20 deg, with half the adhesion and without."""
    half, alone = (
        least_difference(context, name, "restitution", angles_deg)
        for name in (HALF_ADHESION, SLOPES_ALONE)
    )
    return {
        "least_difference_rough_less_smooth_with_half_adhesion": half,
        "least_difference_rough_less_smooth_with_slopes_alone": alone,
    }


def least_difference(
    context: Context, name: str, quantity: str, angles: tuple[float, ...]
) -> Estimate:
    """Return the least difference of a mean, rough less smooth, with at most its error.

    The smooth surface scatters no more than the rough one.
    """
    difference, sd, n = (
        pair(context, name, column, angles)
        for column in (f"{quantity}_difference", f"{quantity}_sd", "rebounds")
    )
    least = int(difference.argmin())
    error = sd.iloc[least] * np.sqrt(2.0 / n.iloc[least])
    return Estimate(difference.iloc[least], error)


def pair(
    context: Context, name: str, column: str, angles: tuple[float, ...] | None = None
) -> pd.Series:
    """Return a column of a rough less a smooth surface at some angles, or at all."""
    return context.column("surface_pairs", column, angles, pair=name)


@claim("C72")
def c72(context: Context) -> Numbers:
    """Largest excess of the impulse ratio on the rough surface, at any angle."""
    excess = pair(context, SLOPES_ALONE, "impulse_ratio_difference_over_half_width")
    return {"largest_excess_of_rough_surface_over_half_width": excess.max()}


@claim("C73")
def c73(context: Context, *, angles_deg: tuple[AngleDegrees, ...]) -> Numbers:
    """Largest difference of the energy loss above 50 deg, with half the adhesion and without."""
    column = "energy_loss_difference_over_half_width"
    half, alone = (
        pair(context, name, column, angles_deg).max() for name in (HALF_ADHESION, SLOPES_ALONE)
    )
    return {
        "largest_difference_rough_less_smooth_with_half_adhesion_over_half_width": half,
        "largest_difference_rough_less_smooth_with_slopes_alone_over_half_width": alone,
    }


@claim("C74")
def c74(context: Context, *, angles_deg: tuple[AngleDegrees, ...]) -> Numbers:
    """Least difference of the losses on the mirror, and its error by squared restitutions."""
    error = pair(context, MIRROR, "loss_less_squares_over_half_width", angles_deg)
    least = least_difference(context, MIRROR, "energy_loss", angles_deg)
    return {
        "least_difference_of_losses_rough_less_smooth": least,
        "largest_error_of_difference_over_half_width": error.abs().max(),
    }


@claim("C75", by_case=True)
def c75(
    context: Context,
    *,
    dropped: Dropped,
    classes: dict[Name, SpeedClass],
    trend_deg: AngleRange,
    sphere_speeds_m_per_s: tuple[Positive, Positive],
) -> Numbers:
    """Falls of restitution with the speed and the angle: means of the rebounds of a class.

    Beside them the fall of the mean sphere between the two faster speeds.
    """
    e = [[class_mean(context, dropped, c, angle) for angle in trend_deg] for c in classes.values()]
    (fast, fast_shallow), (middle, _), (slowest, slowest_shallow) = e
    speeds = np.array(sphere_speeds_m_per_s)
    sphere = simulate(context.steel, speeds, trend_deg[0]).coefficient_of_restitution
    return {
        "fall_to_slowest_class": fast - slowest,
        "fall_with_angle_of_slowest_less_fastest_class": (slowest - slowest_shallow)
        - (fast - fast_shallow),
        "fall_to_middle_class": fast - middle,
        "fall_of_mean_sphere_to_middle_speed": sphere[0] - sphere[1],
    }


def class_mean(
    context: Context, dropped: Dropped, speed_class: SpeedClass, angle: float
) -> Estimate:
    """Return the mean restitution of the rebounds of a speed class at one angle.

    Raises NotComputable if too few rebound.
    """
    of_class = replace(dropped, **asdict(speed_class))
    if not context.seen(of_class, angle).measured:
        speed = speed_class.speed_m_per_s
        raise NotComputable(f"of the class at {speed:g} m/s no sphere rebounds at {angle:g} deg")
    return context.mean("restitution", of_class, angle)


@claim("C76", by_case=True)
def c76(
    context: Context, *, dropped: Dropped, speed_class: SpeedClass, trend_deg: AngleRange
) -> Numbers:
    """Fall of restitution from steep to shallow: means of the rebounds of the fastest class."""
    steep, shallow = (class_mean(context, dropped, speed_class, angle) for angle in trend_deg)
    return {"fall_of_restitution": steep - shallow}


@claim("C77", by_case=True)
def c77(
    context: Context, *, speeds_m_per_s: tuple[Positive, Positive, Positive], spin_ratio: Finite
) -> Numbers:
    """How far the end of rolling moves towards steep angles as the speed falls, by spin."""
    fast, middle, slowest = speeds_m_per_s
    base = rolling_limit(context.steel, fast, 0.0)
    return {
        name: {
            f"shift_of_rolling_limit_at_{words}": rolling_limit(context.steel, speed, spin) - base
            for words, speed in (("slowest", slowest), ("middle", middle))
        }
        for name, spin in (("no spin", 0.0), ("back spin", spin_ratio))
    }


@claim("C111", by_case=True)
def c111(
    context: Context,
    *,
    speeds_m_per_s: tuple[Positive, Positive],
    angle_deg: AngleDegrees,
    seen_shift_deg: Positive,
) -> Numbers:
    """Share of initial spins that narrow rolling visibly, that end friction, and that do both.

    Of spins of the mean sphere at the slowest speed, from back spin r omega = v to rolling.
    """
    fast, slowest = speeds_m_per_s
    spins = np.linspace(-1.0, 1.0, TRIED_SPINS)
    base = rolling_limit(context.steel, fast, 0.0)
    shift = np.array([rolling_limit(context.steel, slowest, spin) - base for spin in spins])
    turning = spins * slowest / context.steel.radius
    ratio = simulate(context.steel, slowest, angle_deg, turning).impulse_ratio
    narrower, frictionless = shift >= seen_shift_deg, ratio <= 0.0
    return {
        "share_of_spins_that_do_both": np.mean(narrower & frictionless),
        "share_of_spins_that_narrow_rolling": np.mean(narrower),
        "share_of_spins_without_friction": np.mean(frictionless),
    }


@claim("C78", by_case=True)
def c78(
    context: Context,
    *,
    dropped: Dropped,
    angle_deg: AngleDegrees,
    mean_spin: Finite,
    spin_spreads: tuple[Positive, ...],
) -> Numbers:
    """Least mean impulse ratio over spreads of spins about two means, and the spins needed.

    The mean spin needed brings the mean to zero. No spread about zero does; the spread needed is
    the least with which the interval of an experiment reaches zero.
    """
    needed = context.table("spin_needed", angle_deg=angle_deg).iloc[0]
    energy = "rotational_over_translational_energy"

    def ratio(mean: float, sd: float) -> Mean:
        spun = replace(dropped, spin=InitialSpin(mean=mean, sd=sd))
        return context.series.seen(spun, angle_deg).means["impulse_ratio"]

    def lower_end(sd: float) -> float:
        mean = ratio(0.0, sd)
        return mean.value - half_width(mean, EXACT, context.params.sampling)

    common = {
        "mean_spin_over_speed_needed": needed["mean_spin_needed"],
        "spin_deviation_over_speed_needed": root(lower_end, 0.0, WIDEST_SPREAD, absolute=1e-2),
        f"{energy}_needed": needed[energy],
    }
    return {
        name: {"least_mean_impulse_ratio": min(ratio(mean, sd).value for sd in spin_spreads)}
        | common
        for name, mean in (
            ("spins of either sense", 0.0),
            ("spins of the sense of rolling", mean_spin),
        )
    }


@claim("C79", by_case=True)
def c79(
    context: Context,
    *,
    dropped: Dropped,
    classes: dict[Name, SpeedClass],
    departures_deg: dict[Name, AngleDegrees],
    angles_deg: Angles,
    mean_spins: tuple[Finite, ...],
) -> Numbers:
    """First angle at which the loss differs from that at the steepest, in two speed classes.

    Without spin, and with the mean spin, r omega over v, that leads nearest to the printed angle.
    """

    def departure(speed_class: SpeedClass, spin: float) -> float:
        at = replace(dropped, spin=replace(dropped.spin, mean=spin), **asdict(speed_class))
        losses = [context.seen(at, angle).means["energy_loss"] for angle in angles_deg]
        return next(departures(angles_deg, losses, context.params.sampling), angles_deg[-1])

    def nearest(name: str, spins: tuple[float, ...]) -> float:
        angles = [departure(classes[name], spin) for spin in spins]
        return min(angles, key=lambda angle: (abs(angle - departures_deg[name]), angle))

    alternatives = {"without spin": (0.0,), "with some spin": (0.0, *mean_spins)}
    return {
        words: {f"angle_of_departure_of_{name}_class": nearest(name, spins) for name in classes}
        for words, spins in alternatives.items()
    }


@claim("C80")
def c80(context: Context, *, friction_up_to: Fraction) -> Numbers:
    """Share of angles, restitutions and frictions at which the loss falls towards shallow ones."""
    table = context.table("loss_slopes")
    is_small = table["friction"] <= friction_up_to
    halves = {f"friction up to {friction_up_to:g}": is_small}
    halves[f"friction above {friction_up_to:g}"] = ~is_small
    return {
        name: {"share_of_falling_slopes": table.loc[rows, "share_falling"].mean()}
        for name, rows in halves.items()
    }


@claim("C106", by_contact=True)
def c106(
    context: Context,
    *,
    speed_m_per_s: Positive,
    angles_deg: AngleRange,
    friction_speed_exponent: NonNegative,
) -> Numbers:
    """Impulse ratio at the shallow angle less that at the steep one, at the slow speed.

    Parameters
    ----------
    friction_speed_exponent
        Of the normal speed, over the speed, in the coefficient of friction, which is constant: 0.
    """
    angle, steel = np.array(angles_deg)[:, None], context.steel
    share = np.power(np.sin(np.radians(angle)), friction_speed_exponent)
    rubbing = steel.replace(friction=steel.friction * share)
    shallow, steep = context.hit(rubbing, speed_m_per_s, angle).impulse_ratio
    return {"difference_of_impulse_ratios": shallow - steep}


@claim("C109")
def c109(
    context: Context,
    *,
    dropped: Dropped,
    angle_deg: ObliqueDegrees,
    experiments: Count,
    most_dropped: Count,
) -> Numbers:
    """Mean half-width of -mu in experiments with spin over that in those without.

    Events are those that the imaging system reports, by the model of its errors.
    """
    params, contact = context.params, context.sample(dropped).contact
    sampling = params.sampling
    stop = StopRule(events=sampling.events, fewest_events=2, most_dropped=most_dropped)

    def half_widths(spin: InitialSpin) -> Estimate:
        drop = replace(dropped, spin=spin).drop(contact, angle_deg, sampling.dispenser)
        streams = (generator(sampling.seed, ANALYSIS, SPREAD, n) for n in range(experiments))
        means = [collect(drop, params.camera, stop, rng).means["impulse_ratio"] for rng in streams]
        return over_draws([0.5 * (mean.high - mean.low) for mean in means])

    spun, bare = half_widths(dropped.spin), half_widths(NO_SPIN)
    error = np.hypot(spun.error / spun.value, bare.error / bare.value)
    ratio = spun.value / bare.value
    return {"interval_width_with_over_without_spin": Estimate(ratio, ratio * error)}


@claim("C110", by_contact=True)
def c110(context: Context, *, rise_share: Positive, from_angle_deg: AngleDegrees) -> Numbers:
    """Largest angle at which -mu of a rebound exceeds that at 40 deg by a share."""
    steel, start = context.steel, from_angle_deg
    least = np.maximum(context.capture_angle(ABOVE_CAPTURE), FINE)

    def ratio(angle: FloatArray) -> FloatArray:
        return context.hit(steel, context.speed, angle).impulse_ratio

    level = (1.0 + rise_share) * ratio(np.asarray(start))

    def first(steps: IntArray) -> tuple[IntArray, BoolArray]:
        """Return the first of steps (m, n) at which it has risen, and whether there is one."""
        risen = ratio(angle(steps)) >= level
        step = np.take_along_axis(steps, risen.argmax(axis=0)[None], axis=0)[0]
        return step, np.any(risen, axis=0)

    def angle(steps: IntArray) -> FloatArray:
        return np.asarray(np.maximum(start - FINE * steps, least))

    # Over coarse steps, then within the one in which it rises.
    steps = np.arange(0, round(start / FINE) + COARSE_STEPS, COARSE_STEPS)[:, None]
    coarse, rises = first(np.broadcast_to(steps, (len(steps), least.size)))
    fine, _ = first(np.maximum(coarse - np.arange(COARSE_STEPS + 1)[::-1, None], 0))
    return {"angle_of_rise": np.where(rises, angle(fine), 0.0)}
