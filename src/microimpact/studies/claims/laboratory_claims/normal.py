"""Numbers behind the claims on free fall, the probe, and normal impacts of two sieve classes."""

from __future__ import annotations

import numpy as np

from microimpact.core.arrays import FloatArray
from microimpact.core.constants import gravity
from microimpact.lab.pdpa.pairing import correct
from microimpact.model.contact import resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.normal import normal_impact
from microimpact.statistics.distributions import Distribution, generator
from microimpact.studies.claims.laboratory_claims.context import Context, Numbers

# Ends of an interval of 95 %, of which the lower decides.
LOWER_END = 0.025


def c01(context: Context) -> dict[str, float]:
    """Speeds after the shortest and longest fall, from a speed at the exit of the dispenser."""
    fall = context.params.fall
    shortest, longest = np.sqrt(
        fall.exit_speed_m_per_s**2 + 2.0 * gravity * np.array(fall.heights_m)
    )
    return {"speed_after_shortest_fall": shortest, "speed_after_longest_fall": longest}


def c02(context: Context) -> dict[str, float]:
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
    return {"largest_error_of_restitution": float(np.max(np.abs(-rebound / incident - e)))}


def c03(context: Context) -> dict[str, float]:
    """Slowest rebound that climbs to the probe, and share of the rebounds that do not."""
    fall = context.params.fall
    slowest = np.sqrt(2.0 * gravity * 1e-3 * fall.probe_height_mm)
    e = restitutions(context, context.params.sieves.smaller_um, fall.rebound_speed_m_per_s)
    rebounds = e[e > 0.0] * fall.rebound_speed_m_per_s
    return {
        "slowest_rebound_seen": slowest,
        "share_of_rebounds_below_probe_at_0p3_m_per_s": np.mean(rebounds < slowest),
    }


def c04(context: Context) -> dict[str, float]:
    """Height of free fall that gives the faster end of the piling up."""
    speed = context.params.fall.pile_up_speed_m_per_s
    return {"drop_height_for_0p3_m_per_s": speed**2 / (2.0 * gravity)}


def c64(context: Context) -> dict[str, float]:
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
        known = [e for e, enough in zip(spheres, rebounding, strict=True) if enough]
        curve = np.array([[e.mean()] for e in known])
        sample = np.array(
            [rng.choice(e, (sieves.experiments, sampling.events)).mean(axis=1) for e in known]
        )
        ratio = ratio * fallen_speed(speed[rebounding], curve, sieves.plateau_share) ** power
        drawn = drawn * fallen_speed(speed[rebounding], sample, sieves.plateau_share) ** power
    return {
        "speed_ratio_at_0p9_of_plateau_smaller_to_larger_class": float(ratio[0]),
        "lower_end_of_its_interval": float(np.quantile(drawn, LOWER_END)),
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
        raise ValueError(f"sieves.speeds_m_per_s: restitution does not fall to {share:g} at them")
    last = len(speed) - 1 - np.argmax(below[::-1], axis=0)
    column = np.arange(restitution.shape[1])
    low, high = restitution[last, column], restitution[last + 1, column]
    part = (aim - low) / (high - low)
    found: FloatArray = speed[last] * (speed[last + 1] / speed[last]) ** part
    return found


def c65(context: Context) -> dict[str, float]:
    """Range of speeds over which capture sets in, over the capture velocity of the named sphere.

    Larger spheres have lower capture velocities, so that the share captured is a quantile of
    diameters.
    """
    sieves, contact = context.params.sieves, context.steel
    ends = sieves.smaller_um.quantile(np.sort(sieves.captured_shares)) * 1e-6
    slow, fast = np.sort(capture_velocity(resized(contact, ends)))
    named = capture_velocity(resized(contact, sieves.named_diameter_um * 1e-6))
    return {
        "width_of_capture_10_to_90_percent_over_capture_velocity_49_um": float(
            (fast - slow) / named
        )
    }


def restitutions(
    context: Context, diameter_um: Distribution, speed: FloatArray | float
) -> FloatArray:
    """Return the restitution of all sizes of a class, 0 if captured; sizes along the last axis."""
    sizes = context.params.sieves.sizes
    diameter = diameter_um.quantile((np.arange(sizes) + 0.5) / sizes) * 1e-6
    impact = normal_impact(resized(context.steel, diameter), speed)
    return np.where(impact.captured, 0.0, impact.coefficient_of_restitution)


CLAIMS = {
    "C01": Numbers(
        of=c01,
        evidence="computed",
        units=dict.fromkeys(("speed_after_shortest_fall", "speed_after_longest_fall"), "m/s"),
    ),
    "C02": Numbers(of=c02, evidence="computed"),
    "C03": Numbers(of=c03, by_case=True, units={"slowest_rebound_seen": "m/s"}),
    "C04": Numbers(of=c04, evidence="computed", units={"drop_height_for_0p3_m_per_s": "m"}),
    "C64": Numbers(of=c64, by_case=True),
    "C65": Numbers(of=c65, by_case=True),
}
