"""Numbers of the claims of Sections 2.1 to 2.3: free fall, instruments, normal impacts, capture."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray, Real
from microimpact.core.computable import NotComputable
from microimpact.core.constants import gravity
from microimpact.core.solve import root
from microimpact.lab.pdpa.pairing import Form, correct
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.rigid_body.algebra import energy_loss
from microimpact.statistics.distributions import Distribution, generator
from microimpact.statistics.intervals import ERROR_BAR
from study.declared.parameters import (
    CaseName,
    Count,
    Finite,
    Fraction,
    NonNegative,
    Positive,
    PositiveRange,
)
from study.studies.claims.claim_numbers.claim import claim
from study.studies.claims.claim_numbers.context import Context, Estimate, Numbers, of_share
from study.studies.contacts import calibrated_contact
from study.studies.experiments.pile_up import onset

# Ends of an interval of 95 %, of which the lower decides.
LOWER_END = 0.025
# An interval that is said to hold the mean so often does, if it does so within the tolerance.
LEVEL, LEVEL_TOLERANCE = 0.95, 0.015
# Points of curves: over speeds, over both numbers of an impact, and over the falls of two classes.
POINTS, GRID, FALL = 61, 41, 40
# Curves begin so much above the capture velocity, relatively.
ABOVE_CAPTURE = 1e-4
# Relative step of logarithmic derivatives of the capture velocity.
EXPONENT_STEP = 0.01
# Quantiles of a sieve class, and speeds, of a mean of its rebounds.
CLASS_SIZES, CLASS_SPEEDS = 50, 9

Share = Annotated[Fraction, Field(gt=0)]
Sizes = Annotated[tuple[Positive, ...], Field(min_length=2)]


@claim("C01")
def c01(context: Context, *, heights_m: PositiveRange, exit_speed_m_per_s: NonNegative) -> Numbers:
    """Speeds after the shortest and longest fall, from a speed at the exit of the dispenser."""
    shortest, longest = np.sqrt(exit_speed_m_per_s**2 + 2.0 * gravity * np.array(heights_m))
    return {"speed_after_shortest_fall": shortest, "speed_after_longest_fall": longest}


@claim("C02")
def c02(
    context: Context,
    *,
    probe_height_mm: Positive,
    correction: Form,
    speeds_m_per_s: PositiveRange,
    restitutions: tuple[Fraction, Fraction],
) -> Numbers:
    """Largest error of restitution from speeds at the probe that are carried to the surface."""
    height = 1e-3 * probe_height_mm
    v = np.linspace(*speeds_m_per_s, GRID)[:, None]
    e = np.linspace(*restitutions, GRID)
    at_probe = [np.sqrt(np.square(speed) - 2.0 * gravity * height) for speed in (v, e * v)]
    incident, rebound = (
        correct(sign * speed, height, correction)
        for sign, speed in zip((-1.0, 1.0), at_probe, strict=True)
    )
    return {"largest_error_of_restitution": np.max(np.abs(-rebound / incident - e))}


@claim("C03", by_contact=True)
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
    """Return so many diameters that stand for a size class, ascending, m."""
    return np.asarray(diameter_um.quantile((np.arange(sizes) + 0.5) / sizes) * 1e-6)


@claim("C04")
def c04(context: Context, *, speed_m_per_s: Positive) -> Numbers:
    """Height of free fall that gives the faster end of the piling up."""
    return {"drop_height": speed_m_per_s**2 / (2.0 * gravity)}


@claim("C05", by_contact=True)
def c05(context: Context, *, flat_from_m_per_s: Positive, slow_speed_m_per_s: Positive) -> Numbers:
    """Restitution against that at 1.66 m/s: greatest change down to 0.75 m/s, fall at 0.3 m/s."""
    speeds = np.geomspace(flat_from_m_per_s, context.speed, POINTS)
    e = context.impacts(speeds).coefficient_of_restitution
    slow = context.impacts(slow_speed_m_per_s).coefficient_of_restitution
    return {
        "largest_relative_change_of_restitution": np.max(np.abs(e / e[-1] - 1), axis=0),
        "relative_fall_of_restitution": 1.0 - slow / e[-1],
    }


@claim("C06")
def c06(context: Context) -> Numbers:
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
    least = float(capture_velocity(case.steel)) * (1.0 + ABOVE_CAPTURE)
    return np.geomspace(least, case.speed, POINTS)


@claim("C07", by_case=True)
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
    large, small = (sized(context.steel, d * 1e-6, work_size_exponent) for d in diameters_um)
    return {
        "ratio_of_capture_velocities": capture_velocity(large) / capture_velocity(small),
        "ratio_of_speeds_below_plateau": speed_of_share(context, large, plateau_share)
        / speed_of_share(context, small, plateau_share),
    }


def speed_of_share(context: Context, contact: Contact, share: float) -> float:
    """Return the fastest speed in m/s at which restitution is down to the share of its plateau."""
    limit = float(capture_velocity(contact))
    plateau = float(simulate(contact, context.speed).coefficient_of_restitution)

    def excess(speed: float) -> float:
        e = float(simulate(contact, speed).coefficient_of_restitution)
        return e - share * plateau

    for fast, slow in pairwise(np.geomspace(context.speed, limit, POINTS)):
        if excess(slow) < 0.0:
            return root(excess, slow, fast, absolute=1e-14, relative=1e-14)
    raise NotComputable(f"restitution never falls to {share:g} of its plateau")


@claim("C08", by_contact=True)
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


@claim("C61")
def c61(context: Context, *, most_pulses_per_s: Positive) -> Numbers:
    """Speeds that some field of view serves, and how far a sphere falls to the slowest."""
    table = context.table("ptis_range", method="model")
    served = table[table["covered"] & (table["chop_per_s"] <= most_pulses_per_s)]
    return {
        "drop_to_slowest_speed": table["fall_height_mm"].min(),
        "speeds_served_by_some_field_of_view": served["speed_m_per_s"].nunique(),
    }


@claim("C62")
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


@claim("C63")
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


@claim("C64", by_case=True)
def c64(
    context: Context,
    *,
    smaller_um: Distribution,
    larger_um: Distribution,
    sizes: Count,
    speeds_m_per_s: PositiveRange,
    plateau_share: Fraction,
    experiments: Count,
) -> Numbers:
    """Ratio of the speeds at which restitution has fallen to a share of its plateau.

    Of both classes over their whole ranges, rebounds alone; its interval from experiments with
    rebounding spheres drawn anew at every speed. The plateau is at the fastest.
    """
    sampling = context.params.sampling
    speed = np.geomspace(*speeds_m_per_s, FALL)
    rng = generator(sampling.seed, 3)
    ratio, drawn = np.ones(1), np.ones(experiments)
    for diameter_um, power in ((smaller_um, 1.0), (larger_um, -1.0)):
        spheres = resized(context.steel, of_class(diameter_um, sizes))
        e = normal_impact(spheres, speed[:, None]).coefficient_of_restitution
        rebounds = [row[row > 0.0] for row in e]
        rebounding = np.array([len(row) >= sampling.events for row in rebounds])
        if not rebounding.any():
            raise NotComputable(f"C64: at no speed do {sampling.events} spheres of a class rebound")
        known = [row for row, enough in zip(rebounds, rebounding, strict=True) if enough]
        curve = np.array([[row.mean()] for row in known])
        sample = np.array(
            [rng.choice(row, (experiments, sampling.events)).mean(axis=1) for row in known]
        )
        ratio = ratio * fallen_speed(speed[rebounding], curve, plateau_share) ** power
        drawn = drawn * fallen_speed(speed[rebounding], sample, plateau_share) ** power
    return {
        "ratio_of_speeds_below_plateau": ratio[0],
        "lower_end_of_its_interval": np.quantile(drawn, LOWER_END),
    }


def fallen_speed(speed: FloatArray, restitution: FloatArray, share: float) -> FloatArray:
    """Return the highest speed at which restitution is a share of its value at the last speed.

    Parameters
    ----------
    speed
        Ascending, m/s, shape (n,).
    restitution
        Of m experiments, shape (n, m).
    share
        Of the plateau.

    Raises
    ------
    ValueError
        If it is above that share at all speeds.
    """
    aim = share * restitution[-1]
    below = restitution < aim
    if not below.any(axis=0).all():
        raise NotComputable(f"C64.speeds_m_per_s: restitution does not fall to {share:g} at them")
    last = len(speed) - 1 - np.argmax(below[::-1], axis=0)
    column = np.arange(restitution.shape[1])
    low, high = restitution[last, column], restitution[last + 1, column]
    part = (aim - low) / (high - low)
    fallen: FloatArray = speed[last] * (speed[last + 1] / speed[last]) ** part
    return fallen


@claim("C65", by_contact=True)
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


@claim("C66")
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


@claim("C105", by_contact=True)
def c105(context: Context, *, diameter_um: Distribution, flat_from_m_per_s: Positive) -> Numbers:
    """How the mean e of a sieve class's rebounds changes from the nominal speed down."""
    spheres = resized(context.steel, of_class(diameter_um, CLASS_SIZES)[:, None])
    means = []
    for speed in np.geomspace(flat_from_m_per_s, context.speed, CLASS_SPEEDS):
        impact = normal_impact(spheres, speed)
        rebounds = np.sum(~impact.captured, axis=0)
        total = np.sum(impact.coefficient_of_restitution, axis=0)
        means.append(total / np.maximum(rebounds, 1))
    slowest = normal_impact(spheres, flat_from_m_per_s)
    return {
        "largest_relative_change_of_conditional_mean": np.max(
            np.abs(np.array(means) / means[-1] - 1.0), axis=0
        ),
        "captured_share": np.mean(slowest.captured, axis=0),
    }


@claim("C107")
def c107(
    context: Context, *, case: CaseName, sizes_um: Sizes, work_size_exponent: Finite
) -> Numbers:
    """Local exponents of the capture velocity over the printed sizes on molybdenum."""
    contact = calibrated_contact(context.inputs, case)
    exponents = local_exponents(contact, np.array(sizes_um) * 1e-6, work_size_exponent)
    return {
        "greatest_local_exponent": np.max(exponents),
        "relative_spread_of_local_exponent": np.ptp(exponents) / abs(np.mean(exponents)),
    }


def local_exponents(contact: Contact, diameter: Real, work_exponent: float) -> FloatArray:
    """Return d ln v_c / d ln d, by central differences; `work_exponent` as in `sized`."""
    up, down = (
        capture_velocity(sized(contact, diameter * np.exp(step), work_exponent))
        for step in (EXPONENT_STEP, -EXPONENT_STEP)
    )
    return np.asarray(np.log(up / down) / (2.0 * EXPONENT_STEP))
