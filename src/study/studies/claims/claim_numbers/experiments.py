"""Numbers of the claims of Sections 2.1 to 2.3: free fall, instruments, normal impacts, capture."""

from __future__ import annotations

from functools import partial
from itertools import pairwise

import numpy as np

from microimpact.core.arrays import FloatArray, Real
from microimpact.core.constants import gravity
from microimpact.core.solve import IntArray, root
from microimpact.lab.pdpa.pairing import correct
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.rigid_body.algebra import energy_loss
from microimpact.statistics.distributions import Distribution, generator
from study.studies.claims.claim_numbers.claim import claim
from study.studies.claims.claim_numbers.context import (
    Context,
    Estimate,
    Numbers,
    between,
    of_share,
)
from study.studies.contacts import calibrated_contact
from study.studies.experiments.pile_up import onset

# Ends of an interval of 95 %, of which the lower decides.
LOWER_END = 0.025
# An interval that is said to hold the mean so often does, if it does so within the tolerance.
LEVEL, LEVEL_TOLERANCE = 0.95, 0.015
# Half-width of a 95 % interval over its standard error.
ERROR_BAR = 1.96


@claim("C01")
def c01(context: Context) -> Numbers:
    """Speeds after the shortest and longest fall, from a speed at the exit of the dispenser."""
    fall = context.params.fall
    shortest, longest = np.sqrt(
        fall.exit_speed_m_per_s**2 + 2.0 * gravity * np.array(fall.heights_m)
    )
    return {"speed_after_shortest_fall": shortest, "speed_after_longest_fall": longest}


@claim("C02")
def c02(context: Context) -> Numbers:
    """Largest error of restitution from speeds at the probe that are carried to the surface."""
    fall = context.params.fall
    height = 1e-3 * fall.probe_height_mm
    v = np.linspace(*fall.speeds_m_per_s, fall.points)[:, None]
    e = np.linspace(*fall.restitutions, fall.points)
    at_probe = [np.sqrt(np.square(speed) - 2.0 * gravity * height) for speed in (v, e * v)]
    incident, rebound = (
        correct(sign * speed, height, fall.correction)
        for sign, speed in zip((-1.0, 1.0), at_probe, strict=True)
    )
    return {"largest_error_of_restitution": np.max(np.abs(-rebound / incident - e))}


@claim("C03", by_case=True)
def c03(context: Context) -> Numbers:
    """Slowest rebound that climbs to the probe, and share of the rebounds that do not."""
    fall = context.params.fall
    slowest = np.sqrt(2.0 * gravity * 1e-3 * fall.probe_height_mm)
    speed = fall.pile_up_speed_m_per_s
    count = context.params.sieves.sizes

    def first_faster(steel: Contact, rebound: float) -> IntArray:
        sizes = of_class(context, context.params.sieves.smaller_um)
        below, above = np.full(steel.shape, -1), np.full(steel.shape, count)
        while np.any(above - below > 1):
            middle = np.maximum((below + above) // 2, 0)
            e = normal_impact(resized(steel, sizes[middle]), speed).coefficient_of_restitution
            faster = e * speed > rebound
            below, above = np.where(faster, below, middle), np.where(faster, middle, above)
        return above

    # The larger a sphere, the faster its rebound, so that two places among the sizes tell all.
    captured, slow = (
        context.of_steel(("C03", least), partial(first_faster, rebound=least))
        for least in (0.0, slowest)
    )
    if captured == count:
        raise ValueError(f"fall.pile_up_speed_m_per_s: no sphere rebounds at {speed:g}")
    return {
        "slowest_rebound_seen": slowest,
        "share_of_rebounds_below_probe": (slow - captured) / (count - captured),
    }


def of_class(context: Context, diameter_um: Distribution) -> FloatArray:
    """Return the diameters that stand for a size class, ascending, m."""
    sizes = context.params.sieves.sizes
    return np.asarray(diameter_um.quantile((np.arange(sizes) + 0.5) / sizes) * 1e-6)


def restitutions(
    context: Context, diameter_um: Distribution, speed: FloatArray | float
) -> FloatArray:
    """Return the restitution of all sizes of a class, 0 if captured; sizes along the last axis."""
    impact = normal_impact(resized(context.steel, of_class(context, diameter_um)), speed)
    return np.where(impact.captured, 0.0, impact.coefficient_of_restitution)


@claim("C04")
def c04(context: Context) -> Numbers:
    """Height of free fall that gives the faster end of the piling up."""
    speed = context.params.fall.pile_up_speed_m_per_s
    return {"drop_height": speed**2 / (2.0 * gravity)}


@claim("C05", by_case=True)
def c05(context: Context) -> Numbers:
    """Restitution against that at 1.66 m/s: greatest change down to 0.75 m/s, fall at 0.3 m/s."""
    normal = context.params.normal
    speeds = between((normal.flat_from_m_per_s, context.speed), normal.points)
    e = context.steel_impacts(speeds).coefficient_of_restitution
    slow = context.steel_impacts(normal.slow_speed_m_per_s).coefficient_of_restitution
    return {
        "largest_relative_change_of_restitution": np.max(np.abs(e / e[-1] - 1)),
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
    normal = case.params.normal
    least = float(capture_velocity(case.steel)) * (1.0 + normal.above_capture)
    return between((least, case.speed), normal.points)


@claim("C07", by_case=True)
def c07(context: Context) -> Numbers:
    """Capture velocity, and speed at 0.9 of the plateau, of the larger mean size over the smaller.

    The plateau is each size's own restitution at 1.66 m/s. The work of adhesion is that of the
    calibrated size times a power of the ratio of sizes, as a rule the power 0.
    """
    large, small = (
        sized(context, context.steel, diameter * 1e-6)
        for diameter in context.params.normal.compared_diameters_um
    )
    return {
        "ratio_of_capture_velocities": capture_velocity(large) / capture_velocity(small),
        "ratio_of_speeds_below_plateau": speed_of_share(context, large)
        / speed_of_share(context, small),
    }


def speed_of_share(context: Context, contact: Contact) -> float:
    """Return the fastest speed in m/s at which restitution is down to the share of its plateau."""
    normal = context.params.normal
    limit = float(capture_velocity(contact))
    plateau = float(simulate(contact, context.speed).coefficient_of_restitution)

    def excess(speed: float) -> float:
        e = float(simulate(contact, speed).coefficient_of_restitution)
        return e - normal.plateau_share * plateau

    for fast, slow in pairwise(between((context.speed, limit), normal.points)):
        if excess(slow) < 0.0:
            return root(excess, slow, fast, absolute=1e-14, relative=1e-14)
    raise ValueError(f"restitution never falls to {normal.plateau_share:g} of its plateau")


@claim("C08", by_case=True)
def c08(context: Context) -> Numbers:
    """Capture velocity of the mean sphere of the smaller sieve class."""
    diameter = context.params.sieves.named_diameter_um * 1e-6
    limit = context.limits("C08", lambda steel: sized(context, steel, diameter))
    return {"capture_velocity": limit}


def sized(context: Context, contact: Contact, diameter: Real) -> Contact:
    """Return the contact at other diameters, m: damping stays, and the work of adhesion."""
    growth = np.power(diameter / contact.diameter, context.params.normal.work_size_exponent)
    return contact.replace(
        diameter=diameter, work_of_adhesion=np.asarray(contact.work_of_adhesion) * growth
    )


@claim("C61")
def c61(context: Context) -> Numbers:
    """Speeds that some field of view serves, and those that the best one does at its best angle.

    The disk speed is the greatest over the speeds that the best one serves.
    """
    table = context.table("ptis_range", method="model")
    pulses = context.params.instruments.most_pulses_per_s
    served = table[table["covered"] & (table["chop_per_s"] <= pulses)]
    views = [
        (rows["speed_m_per_s"].nunique(), width, rows["disk_rev_per_min"].max())
        for (width, _), rows in served.groupby(["view_width_mm", "angle_deg"])
    ]
    count, width, disk = max(views, default=(0, 0.0, 0.0))
    return {
        "speeds_served_by_some_field_of_view": served["speed_m_per_s"].nunique(),
        "speeds_served_by_best_field_of_view": count,
        "disk_speed_needed": disk,
        "best_field_of_view": width,
    }


@claim("C62")
def c62(context: Context) -> Numbers:
    """Largest change of precision and recall with the height of the probe, at any of the speeds.

    Over the half-width of the 95 % interval that two experiments have for it. Heights at which no
    pair is recorded have neither.
    """
    table, events = context.table("pairing_quality"), context.params.sampling.events
    speeds = context.params.instruments.pair_speeds_m_per_s
    if missing := sorted({*speeds} - {*table["speed_m_per_s"]}):
        raise ValueError(f"instruments.pair_speeds_m_per_s: no pairs were sought at {missing}")
    chosen = table[table["speed_m_per_s"].isin(speeds)]
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
    table = context.table("interval_coverage", quantity="restitution")
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
def c64(context: Context) -> Numbers:
    """Ratio of the speeds at which restitution has fallen to a share of its plateau.

    Of both classes over their whole ranges, rebounds alone; its interval from experiments with
    rebounding spheres drawn anew at every speed.
    """
    sieves, sampling = context.params.sieves, context.params.sampling
    speed = np.geomspace(*sieves.speeds_m_per_s, sieves.points)
    rng = generator(sampling.seed, 3)
    ratio, drawn = np.ones(1), np.ones(sieves.experiments)
    for diameter_um, power in ((sieves.smaller_um, 1.0), (sieves.larger_um, -1.0)):
        spheres = [e[e > 0.0] for e in restitutions(context, diameter_um, speed[:, None])]
        rebounding = np.array([len(e) >= sampling.events for e in spheres])
        if not rebounding.any():
            raise ValueError(f"sieves: at no speed do {sampling.events} spheres of a class rebound")
        known = [e for e, enough in zip(spheres, rebounding, strict=True) if enough]
        curve = np.array([[e.mean()] for e in known])
        sample = np.array(
            [rng.choice(e, (sieves.experiments, sampling.events)).mean(axis=1) for e in known]
        )
        ratio = ratio * fallen_speed(speed[rebounding], curve, sieves.plateau_share) ** power
        drawn = drawn * fallen_speed(speed[rebounding], sample, sieves.plateau_share) ** power
    return {
        "ratio_of_speeds_below_plateau": ratio[0],
        "lower_end_of_its_interval": np.quantile(drawn, LOWER_END),
    }


def fallen_speed(speed: FloatArray, restitution: FloatArray, share: float) -> FloatArray:
    """Return the highest speed at which restitution is a share of its value at the last speed.

    `speed`: ascending, m/s, shape (n,); `restitution`: of m experiments, shape (n, m); `share`: of
    the plateau. Raises ValueError if it is above that share at all speeds.
    """
    aim = share * restitution[-1]
    below = restitution < aim
    if not below.any(axis=0).all():
        raise ValueError(f"sieves.speeds_m_per_s: restitution does not fall to {share:g} at them")
    last = len(speed) - 1 - np.argmax(below[::-1], axis=0)
    column = np.arange(restitution.shape[1])
    low, high = restitution[last, column], restitution[last + 1, column]
    part = (aim - low) / (high - low)
    fallen: FloatArray = speed[last] * (speed[last + 1] / speed[last]) ** part
    return fallen


@claim("C65", by_case=True)
def c65(context: Context) -> Numbers:
    """Range of speeds over which capture sets in, over the capture velocity of the named sphere.

    Larger spheres have lower capture velocities, so that the share captured is a quantile of
    diameters.
    """
    sieves = context.params.sieves
    ends = sieves.smaller_um.quantile(np.sort(sieves.captured_shares)) * 1e-6
    sizes = np.append(ends, sieves.named_diameter_um * 1e-6)[:, None]
    *limits, named = context.limits("C65", lambda steel: resized(steel, sizes))
    width = np.ptp(limits) / named
    return {"width_of_capture_over_capture_velocity": width}


@claim("C66")
def c66(context: Context) -> Numbers:
    """Speeds below which a target piles up, for strong and weak capture, by share that stays."""
    shares = context.params.instruments.pile_shares
    return {f"{100.0 * share:g} % stay": piles(context, share) for share in shares}


def piles(context: Context, share: float) -> Numbers:
    """Return both onsets, and their largest and least difference over all targets and scatters."""
    params = context.params.instruments
    table = context.table("pile_up")
    targets = table[["target_radius_mm", "slope_deg"]].drop_duplicates().to_numpy(float)
    onsets = {
        (radius, slope): [
            first_pile(context, radius, slope, velocity, share)
            for velocity in (params.strong_capture_m_per_s, params.weak_capture_m_per_s)
        ]
        for radius, slope in targets.tolist()
    }
    meant = params.pile_radius_mm, params.pile_slope_deg
    near = min(onsets, key=lambda target: np.abs(np.subtract(target, meant)).tolist())
    strong, weak = onsets[near]
    difference = [abs(strong - weak) for strong, weak in onsets.values()]
    return {
        "onset_speed_with_strong_capture": strong,
        "onset_speed_with_weak_capture": weak,
        "largest_difference_of_onset_speeds": max(difference),
        "least_difference_of_onset_speeds": min(difference),
    }


def first_pile(
    context: Context, radius: float, slope: float, velocity: float, wanted: float
) -> float:
    """Return the highest speed (m/s) at which the share that counts as a pile rests on a target.

    The slowest of the speeds tried, if there is no pile at any of them.
    """
    rows = context.table("pile_up", target_radius_mm=radius, slope_deg=slope)
    rows = rows[np.isclose(rows["capture_velocity_m_per_s"], velocity)]
    if rows.empty:
        raise ValueError(f"pile_up: no row with capture_velocity_m_per_s {velocity:g}")
    speed, share = (rows[name].to_numpy(float) for name in ("speed_m_per_s", "share_on_target"))
    return float(speed[0]) if np.all(share < wanted) else onset(speed, share, wanted)


@claim("C105", by_case=True)
def c105(context: Context) -> Numbers:
    """How the mean e of a sieve class's rebounds changes from the nominal speed down."""
    sieves = context.params.sieves
    shares = (np.arange(sieves.plateau_sizes) + 0.5) / sieves.plateau_sizes
    spheres = resized(context.steel, sieves.smaller_um.quantile(shares) * 1e-6)
    speed = between((context.params.normal.flat_from_m_per_s, context.speed), 25)
    impact = normal_impact(spheres, speed[:, None])
    rebounds = np.sum(~impact.captured, axis=1)
    average = np.sum(impact.coefficient_of_restitution, axis=1) / np.maximum(rebounds, 1)
    change = np.max(np.abs(average / average[-1] - 1.0))
    return {
        "largest_relative_change_of_conditional_mean": change,
        "captured_share": np.mean(impact.captured[0]),
    }


@claim("C107")
def c107(context: Context) -> Numbers:
    """Local exponents of the capture velocity over the printed sizes on molybdenum."""
    fluorescein = context.params.fluorescein
    contact = calibrated_contact(context.inputs, fluorescein.case)
    sizes = np.array(fluorescein.sizes_um) * 1e-6
    exponents = local_exponents(context, contact, sizes)
    return {
        "greatest_local_exponent": np.max(exponents),
        "relative_spread_of_local_exponent": np.ptp(exponents) / abs(np.mean(exponents)),
    }


def local_exponents(context: Context, contact: Contact, diameter: Real) -> FloatArray:
    """Return d ln v_c / d ln d, by central differences."""
    step = context.params.normal.exponent_step
    up, down = (
        capture_velocity(sized(context, contact, diameter * np.exp(s))) for s in (step, -step)
    )
    return np.asarray(np.log(up / down) / (2.0 * step))
