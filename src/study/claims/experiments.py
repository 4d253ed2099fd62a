"""Numbers of the claims of Sections 2.1 to 2.3: free fall, instruments, normal impacts, capture."""

from __future__ import annotations

from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray, Real
from microimpact.core.computable import NotComputable
from microimpact.core.constants import gravity
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.normal import normal_impact
from microimpact.statistics.distributions import Distribution
from microimpact.statistics.intervals import ERROR_BAR, student_half_width
from study.analyses.pile_up.compute import onset
from study.claims.claim import RIDGE, Claim, Number, untestable
from study.claims.context import Context, Estimate, Numbers, of_share
from study.declared.parameters import (
    Count,
    Finite,
    Fraction,
    NonNegative,
    Positive,
    PositiveRange,
)

# An interval that is said to hold the mean so often does, if it does so within the tolerance.
LEVEL, LEVEL_TOLERANCE = 0.95, 0.015
# Points of curves over speeds.
POINTS = 61
# Curves begin so much above the capture velocity, relatively.
ABOVE_CAPTURE = 1e-4
# Quantiles of a sieve class, and speeds, of a mean of its rebounds.
CLASS_SIZES, CLASS_SPEEDS = 50, 9

Share = Annotated[Fraction, Field(gt=0)]
Sizes = Annotated[tuple[Positive, ...], Field(min_length=2)]


@Claim(
    "C01",
    "Falling freely through 0.01 to 1.0 m, a particle reaches 0.44 to 4.4 m/s.",
    says=(
        "After the shortest fall a particle has {speed_after_shortest_fall}, after the longest "
        "{speed_after_longest_fall}."
    ),
    where="2.1",
    quote="providing a velocity range from 0.44 m/s to 4.4 m/s",
    article="0.44 to 4.4",
    unit="m/s",
    numbers={
        "speed_after_shortest_fall": Number(unit="m/s", within=(0.44, 0.005)),
        "speed_after_longest_fall": Number(unit="m/s", within=(4.4, 0.05)),
    },
    reason=(
        "Half a unit of the last digit of each printed speed; the printed heights are settings "
        "and count as exact."
    ),
)
def c01(context: Context, *, heights_m: PositiveRange, exit_speed_m_per_s: NonNegative) -> Numbers:
    """Speeds after the shortest and longest fall, from a speed at the exit of the dispenser."""
    shortest, longest = np.sqrt(exit_speed_m_per_s**2 + 2.0 * gravity * np.array(heights_m))
    return {"speed_after_shortest_fall": shortest, "speed_after_longest_fall": longest}


@Claim(
    "C03",
    "A probe about 1 mm above the surface sees rebounds down to the capture velocity.",
    says=(
        "Of the rebounds at [[speed_m_per_s:g]] m/s, {share_of_rebounds_below_probe:%} do not "
        "rise to the probe; {share_of_rebounds_below_probe:bound %} may be missing."
    ),
    where="2.1",
    quote="The probe volume was positioned about 1 mm above the surface.",
    kind="virtual experiment",
    article="no effect of the distance is mentioned",
    numbers={
        "slowest_rebound_seen": Number(unit="m/s"),
        "share_of_rebounds_below_probe": Number(
            "share of rebounds below the probe at [[speed_m_per_s:g]] m/s", at_most=0.05
        ),
    },
    reason=(
        "If more than one rebound in twenty cannot rise to the probe, more is missing than the 5 "
        "% that the error bars leave out. Tested at [[speed_m_per_s:g]] m/s, the faster end of "
        "the pile-up."
    ),
    cases=RIDGE,
    figures="fig04 fig05",
    by_contact=True,
)
def c03(
    context: Context,
    *,
    probe_height_mm: Positive,
    speed_m_per_s: Positive,
    diameter_um: Distribution,
    sizes: Count,
) -> Numbers:
    """Slowest rebound that climbs to the probe, and share of the rebounds that do not."""
    slowest = np.sqrt(2.0 * gravity * 1e-3 * probe_height_mm)
    spheres = resized(context.steel, of_class(diameter_um, sizes)[:, None])
    rebound = speed_m_per_s * normal_impact(spheres, speed_m_per_s).coefficient_of_restitution
    captured, slow = (np.sum(rebound <= least, axis=0) for least in (0.0, slowest))
    if np.all(captured == sizes):
        raise NotComputable(f"C03.speed_m_per_s: no sphere rebounds at {speed_m_per_s:g}")
    share = (slow - captured) / np.maximum(sizes - captured, 1)
    return {
        "slowest_rebound_seen": slowest,
        "share_of_rebounds_below_probe": np.where(captured < sizes, share, np.nan),
    }


def of_class(diameter_um: Distribution, sizes: int) -> FloatArray:
    """Return the diameters, m, at the middles of equal shares of a size class, ascending."""
    return np.asarray(diameter_um.quantile((np.arange(sizes) + 0.5) / sizes) * 1e-6)


@Claim(
    "C04",
    (
        "The impacts at 0.2 to 0.3 m/s fell through at least 0.01 m, the smallest drop height of "
        "the dispenser."
    ),
    says=(
        "An impact at [[speed_m_per_s:g]] m/s needs a fall of {drop_height:mm}. The smallest "
        "height is printed as 0.01 m, that is {drop_height:bound mm}."
    ),
    where="2.1, 2.3.1",
    quote="varied from 0.01 m to 1.0 m",
    kind="contradiction",
    article="0.01",
    unit="m",
    numbers={
        "drop_height": Number("drop height for [[speed_m_per_s:g]] m/s", "m", at_least=0.005),
    },
    reason=(
        "The printed height minus half a unit of its last digit. [[speed_m_per_s:g]] m/s is the "
        "faster end of the range and therefore the milder test."
    ),
    figures="fig04",
)
def c04(context: Context, *, speed_m_per_s: Positive) -> Numbers:
    """Height of free fall that gives the faster end of the piling up."""
    return {"drop_height": speed_m_per_s**2 / (2.0 * gravity)}


@Claim(
    "C05",
    "Restitution is roughly constant above about 0.75 m/s and falls with the speed below it.",
    says=(
        "Restitution changes by {largest_relative_change_of_restitution:%} above "
        "[[flat_from_m_per_s:g]] m/s, where {largest_relative_change_of_restitution:bound %} "
        "counts as constant, and falls by {relative_fall_of_restitution:%} at "
        "[[slow_speed_m_per_s:g]] m/s."
    ),
    where="2.3.1, Fig. 4",
    quote=(
        "at higher initial velocities (above about 0.75 m/s), the coefficient of restitution is "
        "roughly constant"
    ),
    article="constant above 0.75 m/s, falling below",
    numbers={
        "largest_relative_change_of_restitution": Number(
            "largest relative change of restitution above [[flat_from_m_per_s:g]] m/s", at_most=0.1
        ),
        "relative_fall_of_restitution": Number(
            "relative fall of restitution at [[slow_speed_m_per_s:g]] m/s", at_least=0.1
        ),
    },
    reason=(
        "Roughly means 10 % of the value at [[steel.speed_m_per_s:g]] m/s, from there down to "
        "[[flat_from_m_per_s:g]] m/s; below, restitution must leave that band. Calibrated, since "
        "both contacts were chosen for being flat in that range."
    ),
    if_met="calibrated",
    cases=RIDGE,
    figures="fig04 fig16",
    equations="19 25",
    by_contact=True,
)
def c05(context: Context, *, flat_from_m_per_s: Positive, slow_speed_m_per_s: Positive) -> Numbers:
    """Restitution against that at 1.66 m/s: greatest change down to 0.75 m/s, fall at 0.3 m/s."""
    speeds = np.geomspace(flat_from_m_per_s, context.speed, POINTS)
    e = context.impacts(speeds).coefficient_of_restitution
    slow = context.impacts(slow_speed_m_per_s).coefficient_of_restitution
    return {
        "largest_relative_change_of_restitution": np.max(np.abs(e / e[-1] - 1), axis=0),
        "relative_fall_of_restitution": 1.0 - slow / e[-1],
    }


@Claim(
    "C07",
    (
        "The larger spheres have the lower capture velocity, and their restitution begins to fall "
        "at a lower speed."
    ),
    says=(
        "The capture velocity of [[diameters_um.0:g]] µm is {ratio_of_capture_velocities} of that "
        "of [[diameters_um.1:g]] µm, and the speed at which restitution begins to fall "
        "{ratio_of_speeds_below_plateau} of it."
    ),
    where="2.3.1, 6, Fig. 4",
    quote="This inherently leads to a lower capture velocity for larger diameter microspheres.",
    article="inequality, 75 µm below 49 µm",
    numbers={
        "ratio_of_capture_velocities": Number(
            "capture velocity at [[diameters_um.0:g]] over that at [[diameters_um.1:g]] µm",
            at_most=0.999,
        ),
        "ratio_of_speeds_below_plateau": Number(
            "speed at [[plateau_share:g]] of the plateau, [[diameters_um.0:g]] over [[diameters_um.1:g]] µm",
            at_most=0.999,
        ),
    },
    reason=(
        "Any difference beyond 0.1 % counts. Only one diameter is calibrated, so the ratio is a "
        "prediction."
    ),
    cases=RIDGE,
    figures="fig04 fig05",
    equations="19 25",
    external=(
        "capture velocity falls with size by more than the classical power",
        "capture velocity of silver falls with size by this power",
    ),
    by_contact=True,
)
def c07(
    context: Context,
    *,
    diameters_um: tuple[Positive, Positive],
    work_size_exponent: Finite,
    plateau_share: Share,
) -> Numbers:
    """Capture velocity, and speed at 0.9 of the plateau, of the larger mean size over the smaller.

    The plateau is each size's own restitution at 1.66 m/s. The work of adhesion is that of the
    calibrated size times a power of the ratio of sizes, as a rule the power 0.
    """
    sizes = (np.atleast_1d(np.full(context.steel.shape, d * 1e-6)) for d in diameters_um)
    large, small = (sized(context.steel, size, work_size_exponent) for size in sizes)
    return {
        "ratio_of_capture_velocities": capture_velocity(large) / capture_velocity(small),
        "ratio_of_speeds_below_plateau": speed_of_share(context, large, plateau_share)
        / speed_of_share(context, small, plateau_share),
    }


def speed_of_share(context: Context, contact: Contact, share: float) -> FloatArray:
    """Return the fastest speed in m/s at which restitution is down to the share of its plateau.

    Of each contact; that of capture, if it never is.
    """
    speeds = np.geomspace(capture_velocity(contact), context.speed, POINTS)
    e = normal_impact(contact, speeds).coefficient_of_restitution
    excess = e - share * e[-1]
    last = np.max(np.where(excess < 0.0, np.arange(POINTS)[:, None], 0), axis=0)
    below, above = (np.take_along_axis(excess, last[None] + i, 0)[0] for i in (0, 1))
    slow, fast = (np.take_along_axis(speeds, last[None] + i, 0)[0] for i in (0, 1))
    return np.asarray(slow + (fast - slow) * below / (below - above))


@Claim(
    "C08",
    "The mean sphere of the smaller size class is captured below about 0.2 to 0.3 m/s.",
    says=(
        "The mean sphere of [[diameter_um:g]] µm is captured below {capture_velocity}; accepted "
        "is {capture_velocity:bound}."
    ),
    where="2.3.1",
    quote="(i.e., were captured by the surface) at about 0.2 to 0.3 m/s",
    article="0.2 to 0.3",
    unit="m/s",
    numbers={
        "capture_velocity": Number(
            "capture velocity at [[diameter_um:g]] µm", "m/s", at_least=0.18, at_most=0.33
        ),
    },
    reason=(
        "About widens both ends by 10 %. Calibrated, since the capture velocity of one diameter "
        "fixed the contact."
    ),
    if_met="calibrated",
    cases=RIDGE,
    figures="fig04",
    by_contact=True,
)
def c08(context: Context, *, diameter_um: Positive) -> Numbers:
    """Capture velocity of the mean sphere of the smaller sieve class."""
    return {"capture_velocity": capture_velocity(resized(context.steel, diameter_um * 1e-6))}


def sized(contact: Contact, diameter: Real, work_exponent: float) -> Contact:
    """Return the contact at other diameters, m: damping stays.

    The work of adhesion grows with a power of the diameter.
    """
    growth = np.power(diameter / contact.diameter, work_exponent)
    return contact.replace(
        diameter=diameter, work_of_adhesion=np.asarray(contact.work_of_adhesion) * growth
    )


@Claim(
    "C61",
    (
        "The trajectory imaging system can measure speeds from about 0.1 to 30 m/s, given a frame "
        "rate and a field of view."
    ),
    says=(
        "Some field of view serves {speeds_served_by_some_field_of_view} of the declared speeds, "
        "of which {speeds_served_by_some_field_of_view:bound} are needed, and the slowest would "
        "need a fall of {drop_to_slowest_speed}, where the dispenser gives "
        "{drop_to_slowest_speed:bound}."
    ),
    where="2.1",
    quote="the system could measure particle velocities ranging from about 0.1 to 30 m/s",
    kind="virtual experiment",
    article="0.1 to 30",
    unit="m/s",
    numbers={
        "drop_to_slowest_speed": Number(unit="mm", at_least=5.0, identifies=True),
        "speeds_served_by_some_field_of_view": Number(at_least=6.0),
    },
    reason=(
        "All six declared speeds must give [[camera.least_dashes]] dashes or more per leg, and a "
        "speed bias below the declared bound, in some field of view, with at most "
        "[[most_pulses_per_s:g]] pulses and [[camera.fields_per_s:g]] fields per second. Frame "
        "rate and field of view are not published; the slowest speed is tested only if the "
        "printed smallest drop, less half a unit of its digit, gives it."
    ),
    figures="fig01",
)
def c61(context: Context, *, most_pulses_per_s: Positive) -> Numbers:
    """Speeds that some field of view serves, and how far a sphere falls to the slowest."""
    table = context.table("ptis_range", method="model")
    served = table[table["covered"] & (table["chop_per_s"] <= most_pulses_per_s)]
    return {
        "drop_to_slowest_speed": table["fall_height_mm"].min(),
        "speeds_served_by_some_field_of_view": served["speed_m_per_s"].nunique(),
    }


@Claim(
    "C62",
    "Pairs are found equally well whatever the height of the probe above the surface.",
    says=(
        "Between heights of the probe precision changes by "
        "{largest_change_of_precision_over_half_width} half-widths of the error bar and recall by "
        "{largest_change_of_recall_over_half_width}; no effect is "
        "{largest_change_of_precision_over_half_width:bound}."
    ),
    where="2.1",
    quote="had no effect on pair identification",
    kind="virtual experiment",
    article="no effect",
    numbers={
        "largest_change_of_precision_over_half_width": Number(at_most=1.0),
        "largest_change_of_recall_over_half_width": Number(at_most=1.0),
    },
    reason=(
        "No effect means none that experiments of [[sampling.events]] events would show, between "
        "the declared heights of the probe at each of [[speeds_m_per_s:g]] m/s."
    ),
    figures="fig02 fig04",
)
def c62(context: Context, *, speeds_m_per_s: tuple[Positive, ...]) -> Numbers:
    """Largest change of precision and recall with the height of the probe, at any of the speeds.

    Over the half-width of the 95 % interval that two experiments have for it. Heights at which no
    pair is recorded have neither.
    """
    table, events = context.table("pairing_quality"), context.params.sampling.events
    if missing := sorted({*speeds_m_per_s} - {*table["speed_m_per_s"]}):
        raise NotComputable(f"C62.speeds_m_per_s: no pairs were sought at {missing}")
    chosen = table[table["speed_m_per_s"].isin(speeds_m_per_s)]
    numbers = {}
    for name, counted in (("precision", "pairs"), ("recall", "recorded_pairs")):
        changes = []
        for _, rows in chosen.dropna(subset=[name]).groupby("speed_m_per_s"):
            share, n = rows[name].to_numpy(float), rows[counted].to_numpy(float)
            ends = [int(share.argmin()), int(share.argmax())]
            variance = share[ends] * (1.0 - share[ends])
            width = ERROR_BAR * np.sqrt(max(variance.sum(), np.finfo(float).tiny) / events)
            error = np.sqrt(np.sum(variance / n[ends]))
            changes.append(Estimate(np.ptp(share), error) / width)
        numbers[f"largest_change_of_{name}_over_half_width"] = max(changes)
    return numbers


@Claim(
    "C63",
    "The error bars contain the true mean with a probability of 95 %.",
    says=(
        "The error bars contain the mean of the observable events in "
        "{least_coverage_of_mean_of_observable_events:%} to "
        "{greatest_coverage_of_mean_of_observable_events:%} of the experiments; required is "
        "{least_coverage_of_mean_of_observable_events:bound %}."
    ),
    where="2.1",
    quote="to provide estimates of the true mean values at 95% confidence",
    kind="virtual experiment",
    article="0.95",
    numbers={
        "least_coverage_of_mean_of_observable_events": Number(
            "lowest coverage of the mean of observable events", at_least=0.935
        ),
        "greatest_coverage_of_mean_of_observable_events": Number(
            "highest coverage of the mean of observable events", at_most=0.965
        ),
        "speed_at_least_coverage": Number("speed of the lowest coverage", "m/s"),
        "angle_at_least_coverage": Number("angle of the lowest coverage", "deg"),
        "share_of_experiments_within_tolerance": Number("share of experiments within 0.015"),
        "least_coverage_of_mean_of_all_impacts": Number(
            "lowest coverage of the mean of all impacts"
        ),
    },
    reason=(
        "The coverage of every experiment must be the printed probability within half a unit of "
        "its last digit plus the sampling error of the repetitions, together 0.015. Systematic "
        "errors are drawn once per repetition."
    ),
    assumed="errors of the instrument",
    figures="fig04 fig05 fig06",
)
def c63(context: Context) -> Numbers:
    """Share of intervals of restitution that hold either mean: the extremes over experiments."""
    table = context.table("interval_coverage")
    coverage = table["coverage_observable"]
    least, greatest = (table.iloc[int(k)] for k in (coverage.argmin(), coverage.argmax()))
    lowest, highest = (
        of_share(row["coverage_observable"], row["experiments"]) for row in (least, greatest)
    )
    return {
        "least_coverage_of_mean_of_observable_events": lowest,
        "greatest_coverage_of_mean_of_observable_events": highest,
        "speed_at_least_coverage": least["speed_m_per_s"],
        "angle_at_least_coverage": least["angle_deg"],
        "share_of_experiments_within_tolerance": (
            (coverage - LEVEL).abs() <= LEVEL_TOLERANCE
        ).mean(),
        "least_coverage_of_mean_of_all_impacts": table["coverage_all"].min(),
    }


@Claim(
    "C64",
    "The fall of restitution at low speeds is stronger for the smaller size class.",
    says=(
        "From [[speeds_m_per_s.1:g]] to [[speeds_m_per_s.0:g]] m/s the smaller class falls by more "
        "than the larger one by {difference_of_falls_over_half_width} half-widths of the "
        "difference."
    ),
    where="2.3.1, Fig. 4",
    quote="This effect is more pronounced for smaller diameter particles",
    kind="virtual experiment",
    article="inequality",
    numbers={
        "difference_of_falls_over_half_width": Number(
            "fall to [[speeds_m_per_s.0:g]] m/s, smaller less larger class / half-width",
            at_least=1.0,
        ),
        "fall_of_smaller_class": Number(),
        "fall_of_larger_class": Number(),
    },
    reason=(
        "Mean restitutions of the rebounds over the whole sieve ranges, at [[speeds_m_per_s.1:g]] "
        "m/s less at [[speeds_m_per_s.0:g]] m/s, the faster end of the pile-up; a fall is stronger "
        "if experiments could have seen it. Sharpens C07."
    ),
    cases=RIDGE,
    figures="fig04 fig05",
    by_contact=True,
)
def c64(
    context: Context,
    *,
    smaller_um: Distribution,
    larger_um: Distribution,
    speeds_m_per_s: PositiveRange,
) -> Numbers:
    """Falls of restitution from the fastest to a low speed: means of the rebounds of two classes.

    Beside them their difference over the half-width of its 95 % interval, of four experiments whose
    events differ by the diameter.
    """
    falls, variances = [], []
    for diameter_um in (smaller_um, larger_um):
        spheres = resized(context.steel, of_class(diameter_um, CLASS_SIZES)[:, None, None])
        e = normal_impact(spheres, np.array(speeds_m_per_s)[:, None]).coefficient_of_restitution
        share = np.maximum(np.sum(e > 0.0, axis=0), 1)
        mean = np.sum(e, axis=0) / share
        variance = np.sum(np.square(np.where(e > 0.0, e - mean, 0.0)), axis=0) / share
        falls.append(mean[1] - mean[0])
        variances.append(np.sum(variance, axis=0))
    events = context.params.sampling.events
    sd = np.sqrt(np.sum(variances, axis=0))
    width = student_half_width(sd, events, freedom=4 * (events - 1))
    return {
        "difference_of_falls_over_half_width": (falls[0] - falls[1]) / width,
        "fall_of_smaller_class": falls[0],
        "fall_of_larger_class": falls[1],
    }


@Claim(
    "C65",
    (
        "The spread of diameters prevents an exact measurement of the capture velocity of the "
        "smaller class."
    ),
    says=(
        "The speeds at which some spheres are captured and some rebound span "
        "{width_of_capture_over_capture_velocity:%} of the capture velocity at "
        "[[named_diameter_um:g]] µm."
    ),
    where="2.3.1",
    quote="it was impossible to measure directly an exact capture velocity",
    kind="virtual experiment",
    article="not measurable",
    numbers={
        "width_of_capture_over_capture_velocity": Number(
            "width of capture from [[captured_shares.0:.0%]] to [[captured_shares.1:.0%]] over the capture velocity at [[named_diameter_um:g]] µm",
            at_least=0.2,
        ),
    },
    reason=(
        "The captured share falls from [[captured_shares.1:g]] to [[captured_shares.0:g]] over a "
        'range of speeds. A range wider than 10 % to either side ("about") hides the value.'
    ),
    cases=RIDGE,
    figures="fig04",
    by_contact=True,
)
def c65(
    context: Context,
    *,
    diameter_um: Distribution,
    named_diameter_um: Positive,
    captured_shares: tuple[Fraction, Fraction],
) -> Numbers:
    """Range of speeds over which capture sets in, over the capture velocity of the named sphere.

    Larger spheres have lower capture velocities, so that the share captured is a quantile of
    diameters.
    """
    ends = diameter_um.quantile(np.sort(captured_shares)) * 1e-6
    sizes = np.append(ends, named_diameter_um * 1e-6)[:, None]
    *limits, named = np.asarray(capture_velocity(resized(context.steel, sizes)))
    return {"width_of_capture_over_capture_velocity": np.ptp(limits, axis=0) / named}


@Claim(
    "C66",
    "A pile that grows at 0.2 to 0.3 m/s means capture in one impact.",
    says=(
        "Piles begin at {onset_speed_with_strong_capture} with a capture velocity of "
        "[[strong_capture_m_per_s:g]] m/s and at {onset_speed_with_weak_capture} with one of "
        "[[weak_capture_m_per_s:g]] m/s, {least_difference_of_onset_speeds} apart or more; "
        "accepted is {onset_speed_with_strong_capture:bound} and "
        "{onset_speed_with_weak_capture:bound}."
    ),
    where="2.3.1, 6",
    quote="the microspheres started to pile up on the substrate surface",
    kind="virtual experiment",
    article="0.2 to 0.3",
    unit="m/s",
    numbers={
        "onset_speed_with_strong_capture": Number(
            "onset speed at a capture velocity of [[strong_capture_m_per_s:g]] m/s",
            "m/s",
            at_least=0.18,
            at_most=0.33,
        ),
        "onset_speed_with_weak_capture": Number(
            "onset speed at a capture velocity of [[weak_capture_m_per_s:g]] m/s",
            "m/s",
            at_most=0.18,
        ),
        "largest_difference_of_onset_speeds": Number(unit="m/s"),
        "least_difference_of_onset_speeds": Number(unit="m/s", at_least=0.1, identifies=True),
    },
    reason=(
        "Spheres that go on bouncing may pile up as well. If contacts that capture below "
        "[[weak_capture_m_per_s:g]] and below [[strong_capture_m_per_s:g]] m/s start piles at "
        "speeds that differ by less than the width of the printed range, on any declared target "
        "and slope, the pile does not reveal the capture velocity. Onset speeds are given at "
        "[[radius_mm:g]] mm and [[slope_deg:g]]°, for both meanings of a pile."
    ),
    cases=("[[shares.0:.0%]] stay", "[[shares.1:.0%]] stay"),
    assumed="target, slope and stream",
    figures="fig04",
)
def c66(
    context: Context,
    *,
    radius_mm: Positive,
    slope_deg: NonNegative,
    shares: tuple[Fraction, Fraction],
    strong_capture_m_per_s: Positive,
    weak_capture_m_per_s: Positive,
) -> Numbers:
    """Speeds below which a target piles up, for strong and weak capture, by share that stays.

    Beside both onsets, their largest and least difference over all targets.
    """
    table = context.table("pile_up")
    velocities = strong_capture_m_per_s, weak_capture_m_per_s
    targets = table[["target_radius_mm", "slope_deg"]].drop_duplicates().to_numpy(float).tolist()
    meant = min(targets, key=lambda t: [abs(t[0] - radius_mm), abs(t[1] - slope_deg)])
    numbers = {}
    for share in shares:
        onsets = [
            [first_pile(table, radius, slope, each, share) for each in velocities]
            for radius, slope in targets
        ]
        strong, weak = onsets[targets.index(meant)]
        difference = np.abs(np.diff(onsets))
        numbers[f"{100.0 * share:g} % stay"] = {
            "onset_speed_with_strong_capture": strong,
            "onset_speed_with_weak_capture": weak,
            "largest_difference_of_onset_speeds": np.max(difference),
            "least_difference_of_onset_speeds": np.min(difference),
        }
    return numbers


def first_pile(
    table: pd.DataFrame, radius: float, slope: float, velocity: float, wanted: float
) -> float:
    """Return the highest speed (m/s) at which the share that counts as a pile rests on a target.

    The slowest of the speeds tried, if there is no pile at any of them. Raises NotComputable if
    none was tried with the capture velocity.

    Parameters
    ----------
    table
        ``pile_up``.
    radius, slope, velocity
        Of the target, mm and degrees; capture velocity, m/s.
    wanted
        The share.
    """
    rows = table[(table["target_radius_mm"] == radius) & (table["slope_deg"] == slope)]
    rows = rows[np.isclose(rows["capture_velocity_m_per_s"], velocity)]
    if rows.empty:
        raise NotComputable(f"pile_up: no row with capture_velocity_m_per_s {velocity:g}")
    speed, share = (rows[name].to_numpy(float) for name in ("speed_m_per_s", "share_on_target"))
    return float(speed[0]) if np.all(share < wanted) else onset(speed, share, wanted)


@Claim(
    "C105",
    (
        "The plateau of restitution above 0.75 m/s remains when the whole sieve range of the "
        "smaller class is averaged."
    ),
    says=(
        "Averaged over the sieve range, restitution changes by "
        "{largest_relative_change_of_conditional_mean:%} above [[flat_from_m_per_s:g]] m/s; "
        "{largest_relative_change_of_conditional_mean:bound %} counts as constant."
    ),
    where="2.3.1, Fig. 4",
    quote="both cases display a similar trend",
    kind="virtual experiment",
    article="constant",
    numbers={
        "largest_relative_change_of_conditional_mean": Number(
            "largest relative change of the conditional mean above [[flat_from_m_per_s:g]] m/s",
            at_most=0.1,
        ),
        "captured_share": Number("captured share at [[flat_from_m_per_s:g]] m/s"),
    },
    reason=(
        "Roughly constant means within 10 % of the mean at [[steel.speed_m_per_s:g]] m/s, over "
        "all rebounds of the class. Only one diameter was calibrated."
    ),
    cases=RIDGE,
    figures="fig04",
    by_contact=True,
)
def c105(context: Context, *, diameter_um: Distribution, flat_from_m_per_s: Positive) -> Numbers:
    """How the mean e of a sieve class's rebounds changes from the nominal speed down."""
    speeds = np.geomspace(flat_from_m_per_s, context.speed, CLASS_SPEEDS)
    means, captured = zip(
        *(rebounds_of_class(context, diameter_um, v) for v in speeds), strict=True
    )
    return {
        "largest_relative_change_of_conditional_mean": np.max(
            np.abs(np.array(means) / means[-1] - 1.0), axis=0
        ),
        "captured_share": captured[0],
    }


def rebounds_of_class(
    context: Context, diameter_um: Distribution, speed: float
) -> tuple[FloatArray, FloatArray]:
    """Return the mean restitution of a sieve class's rebounds, 0 for none, and the share captured.

    At a normal speed in m/s; of each contact.
    """
    spheres = resized(context.steel, of_class(diameter_um, CLASS_SIZES)[:, None])
    impact = normal_impact(spheres, speed)
    total = np.sum(impact.coefficient_of_restitution, axis=0)
    mean = total / np.maximum(np.sum(~impact.captured, axis=0), 1)
    return mean, np.mean(impact.captured, axis=0)


untestable(
    Claim(
        "C107",
        "The capture velocity falls with the particle size as a power law.",
        where="2.3, 6",
        quote="capture velocity decreases with a power-law dependence on particle size",
        article="power law",
        figures="capture_laws",
        equations="25",
        external=(
            "capture velocity falls with size by more than the classical power",
            "capture velocity of silver falls with size by this power",
        ),
        reason=(
            "No exponent is printed, and over sizes within a factor of three any smooth decrease is nearly "
            "a power."
        ),
    )
)
