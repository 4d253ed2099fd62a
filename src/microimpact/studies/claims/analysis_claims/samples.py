"""Claims decided by large samples of virtual impacts on smooth and rough surfaces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from microimpact.lab.dispenser import InitialSpin
from microimpact.lab.experiment import Target
from microimpact.lab.ptis.experiment import Recipe, collect, reduced
from microimpact.lab.samples import Dropped, Sampling, rough, with_spin
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.normal import normal_impact
from microimpact.statistics.distributions import Constant, generator, mean
from microimpact.studies.claims.analysis_claims.context import Context

SOURCES = ("slope", "diameter", "speed", "spin")

# Second number of the key of every stream; the first is that of this analysis.
ANALYSIS, SPREAD = 109, 0


def c51(context: Context) -> dict[str, float]:
    """Return the rise of e_m on Formica, and the change of e on the smooth surface of Fig. 23."""
    steep, shallow = context.params.samples.fall_angles_deg
    return {
        "rise_on_rough_surface_45_to_15_deg_over_half_width": rise(context, "restitution"),
        "change_on_smooth_surface_45_to_15_deg": smooth(
            context, "smooth_relative_restitution", shallow
        )
        - smooth(context, "smooth_relative_restitution", steep),
    }


def c52(context: Context) -> dict[str, float]:
    """Return -mu of the smooth surface of Fig. 23, and the rise of -mu_m on Formica."""
    _, shallow = context.params.samples.fall_angles_deg
    return {
        "impulse_ratio_of_smooth_surface_at_15_deg": smooth(
            context, "smooth_impulse_ratio", shallow
        ),
        "rise_on_rough_surface_45_to_15_deg_over_half_width": rise(context, "impulse_ratio"),
    }


def rise(context: Context, quantity: str) -> float:
    """Return the rise of a mean on Formica towards the shallow angle, over its half-width."""
    samples = context.params.samples
    steep, shallow = samples.fall_angles_deg
    return context.over_half_width(quantity, (samples.formica, shallow), (samples.formica, steep))


def smooth(context: Context, quantity: str, angle: float) -> float:
    """Return a number of the smooth surface from the table of the Monte Carlo analysis.

    Raises
    ------
    ValueError
        If the analysis has no such angle.
    """
    table = context.inputs["monte_carlo"]
    own = table.loc[table["angle_deg"] == angle, quantity]
    if own.empty:
        raise ValueError(f"monte_carlo: angles_deg must have {angle:g}")
    return float(own.iloc[0])


def c60(context: Context) -> dict[str, float]:
    """Return the largest declared angle at which e_m exceeds that without slopes significantly."""
    samples = context.params.samples
    flat = rough(samples.silicon_back, samples.smooth_slope)
    for angle in sorted(samples.declared_angles_deg, reverse=True):
        # nothing to compare with where the smooth surface keeps the spheres
        bias = context.over_half_width("restitution", (samples.silicon_back, angle), (flat, angle))
        if bias > 1.0:
            return {"largest_angle_with_bias_of_restitution": angle}
    return {"largest_angle_with_bias_of_restitution": 0.0}


def c94(context: Context) -> dict[str, float]:
    """Return differences of relative e_m, Formica with slopes less the same without."""
    samples = context.params.samples
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
    samples = context.params.samples
    flat = rough(samples.formica, samples.smooth_slope)
    sloped_change, flat_change = (
        restitution(context, one, angle) - restitution(context, one, samples.reference_angle_deg)
        for one in (samples.formica, flat)
    )
    return sloped_change - flat_change


def restitution(
    context: Context, dropped: Dropped, angle: float, sampling: Sampling | None = None
) -> float:
    """Return the mean measured restitution of a sample."""
    return context.seen(dropped, angle, sampling).statistics["restitution"].mean


def c96(context: Context) -> dict[str, float]:
    """Return the share of the departure of e_m that some sources explain, by angle.

    The departure is that of a sample in which slope, diameter, speed and spin vary from one in
    which none does; the others are at their means, or at none.
    """
    samples = context.params.samples
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
    samples, sampling = context.params.samples, context.sampling
    dropped = with_spin(samples.formica, mean=0.0, sd=samples.spin_sd if "spin" in sources else 0.0)
    if "slope" not in sources:
        dropped = rough(dropped, samples.smooth_slope)
    if "diameter" not in sources:
        dropped = replace(dropped, diameter_um=Constant(at=mean(dropped.diameter_um)))
    if "speed" not in sources:
        still = replace(sampling.dispenser, exit_speed_m_per_s=0.0)
        sampling = replace(sampling, dispenser=still)
    return restitution(context, dropped, angle, sampling)


def c105(context: Context, contact: Contact) -> dict[str, float]:
    """Return how the mean e of a sieve class's rebounds changes from the nominal speed down."""
    sieve = context.params.sieve
    shares = (np.arange(sieve.sizes) + 0.5) / sieve.sizes
    spheres = resized(contact, sieve.diameter_um.quantile(shares) * 1e-6)
    speed = np.geomspace(sieve.lowest_speed_m_per_s, sieve.highest_speed_m_per_s, 25)
    impact = normal_impact(spheres, speed[:, None])
    rebounds = np.sum(~impact.captured, axis=1)
    average = np.sum(impact.coefficient_of_restitution, axis=1) / np.maximum(rebounds, 1)
    change = average / average[-1] - 1.0
    return {
        "largest_relative_change_of_conditional_mean_above_0p75_m_per_s": float(
            np.max(np.abs(change))
        ),
        "captured_share_at_0p75_m_per_s": float(np.mean(impact.captured[0])),
    }


def c109(context: Context) -> dict[str, float]:
    """Return the mean half-width of -mu in experiments with spin over that in those without.

    Events are those that the imaging system reports, by the model of its errors.
    """
    spread = context.params.spread
    spun = half_widths(context, spread.dropped.spin)
    bare = half_widths(context, InitialSpin(sd=0.0, mean=0.0))
    return {"interval_width_with_over_without_spin_at_70_deg": float(spun / bare)}


def half_widths(context: Context, spin: InitialSpin) -> float:
    """Return the mean half-width of the impulse ratio over repeated experiments."""
    spread, samples = context.params.spread, context.params.samples
    dropped = spread.dropped
    contact = context.contact(dropped.case).replace(friction=dropped.friction)
    recipe = Recipe(
        target=Target(
            contact=resized(contact, mean(dropped.diameter_um) * 1e-6), slope_sd=dropped.slope_sd
        ),
        diameter_um=dropped.diameter_um,
        speed=dropped.speed_m_per_s,
        speed_range=dropped.speed_range_m_per_s,
        dispenser=samples.dispenser,
        spin=spin,
        instrument=spread.instrument,
        method="model",
    )
    widths = []
    for number in range(spread.experiments):
        rng = generator(context.params.seed, ANALYSIS, SPREAD, number)
        found = collect(recipe, spread.angle_deg, samples.events, spread.most_dropped, rng)
        of = reduced(found.measured, spread.instrument.angle_error_deg)["impulse_ratio"]
        widths.append(0.5 * (of.high - of.low))
    return float(np.mean(widths))
