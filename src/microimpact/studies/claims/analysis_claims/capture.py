"""Claims on capture: its sizes, what becomes of captured spheres, and capture on slopes."""

from __future__ import annotations

from itertools import product

import numpy as np
import scipy

from microimpact.core.arrays import FloatArray, Real
from microimpact.lab.collision import Rebound, collide
from microimpact.model.contact import Contact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import planar, velocity_components
from microimpact.model.dynamics.rolling import gravity_ratio, rolling_distance
from microimpact.statistics.distributions import generator
from microimpact.studies.claims.analysis_claims.context import Context, Numbers

ANALYSIS = 98
# Where normal speeds of capture are looked for, relative to the one known; halved to rounding.
AROUND, HALVINGS = 1e-3, 50
# To how much of the nominal normal speed apparent capture is found.
APPARENT = 1e-3


def c08(context: Context, contact: Contact) -> dict[str, float]:
    """Return the capture velocity of the mean sphere of the smaller sieve class."""
    diameter = context.params.capture.mean_diameter_um * 1e-6
    return {"capture_velocity_49_um": float(capture_velocity(sized(context, contact, diameter)))}


def c57(context: Context, contact: Contact) -> dict[str, float]:
    """Return elasticities of the capture velocity at the nominal contact, damping held."""
    step = context.params.capture.exponent_step
    work = np.asarray(contact.work_of_adhesion) * np.exp([step, -step])
    limit = capture_velocity(contact.replace(work_of_adhesion=work))
    return {
        "elasticity_to_work_of_adhesion": float(np.log(limit[0] / limit[1]) / (2.0 * step)),
        "elasticity_to_diameter": float(local_exponents(context, contact, contact.diameter)),
    }


def c107(context: Context) -> dict[str, float]:
    """Return local exponents of the capture velocity over the printed sizes on molybdenum."""
    contact = context.contact(context.params.molybdenum.case)
    sizes = np.array(context.params.capture.sizes_um) * 1e-6
    exponents = local_exponents(context, contact, sizes)
    return {
        "greatest_local_exponent": float(np.max(exponents)),
        "relative_spread_of_local_exponent": float(np.ptp(exponents) / abs(np.mean(exponents))),
    }


def local_exponents(context: Context, contact: Contact, diameter: Real) -> FloatArray:
    """Return d ln v_c / d ln d, by central differences."""
    step = context.params.capture.exponent_step
    up, down = (
        capture_velocity(sized(context, contact, diameter * np.exp(s))) for s in (step, -step)
    )
    return np.asarray(np.log(up / down) / (2.0 * step))


def sized(context: Context, contact: Contact, diameter: Real) -> Contact:
    """Return the contact at other diameters, m: damping stays, and the work of adhesion."""
    growth = np.power(diameter / contact.diameter, context.params.capture.work_size_exponent)
    return contact.replace(
        diameter=diameter, work_of_adhesion=np.asarray(contact.work_of_adhesion) * growth
    )


def c97(context: Context) -> Numbers:
    """Return how far a captured sphere rolls, and the couple of its weight over that of adhesion.

    It comes at the steepest angle at which it is captured, and adhesion alone stops it: the weight,
    which would carry it further, stands beside.
    """
    capture = context.params.capture
    found = {}
    for case, shift in product(context.ridge, capture.shifts_nm):
        contact, lag = case.contact, shift * 1e-9
        sine = min(float(capture_velocity(contact)) / capture.speed_m_per_s, 1.0)
        angle = float(np.degrees(np.arcsin(sine)))
        along = capture.kept_share * velocity_components(capture.speed_m_per_s, angle)[1]
        distance = rolling_distance(contact, along, lag) * 1e3
        found[f"{case.name}, shift {shift:g} nm"] = {
            "distance_rolled_over_half_width_of_spot": float(distance / capture.spot_mm),
            "gravity_couple_over_rolling_couple": float(gravity_ratio(contact, lag, 90.0 - angle)),
        }
    return found


def c98(context: Context, contact: Contact) -> dict[str, float]:
    """Return normal speeds of capture without slopes, and where half are captured with them."""
    capture = context.params.capture
    *speeds, upright = decoupled_speeds(contact, np.array([*capture.decoupled_angles_deg, 90.0]))
    apparent, steep = (
        apparent_speed(context, contact, angle) for angle in (capture.oblique_angle_deg, 90.0)
    )
    return {
        "largest_difference_of_normal_capture_speeds_over_angles": float(
            np.max(np.abs(np.array(speeds) / upright - 1.0))
        ),
        "apparent_capture_speed_10_over_90_deg_with_slopes": apparent / steep,
        "share_that_rolls_away_or_bounces_again": share_lost(context, contact, apparent),
    }


def decoupled_speeds(contact: Contact, angle: FloatArray) -> FloatArray:
    """Return the normal speed at which capture ends at angles of incidence in degrees."""
    limit = float(capture_velocity(contact))
    low, high = (np.full(angle.shape, limit * (1.0 + side * AROUND)) for side in (-1.0, 1.0))
    into, along = velocity_components(1.0, angle)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        stays = planar(contact, -middle, middle * along / -into).captured
        low, high = np.where(stays, middle, low), np.where(stays, high, middle)
    return np.asarray(0.5 * (low + high))


def apparent_speed(context: Context, contact: Contact, angle: float) -> float:
    """Return the nominal normal speed below which more than half the spheres stay on slopes."""

    def excess(speed: float) -> float:
        return 0.5 - float(np.mean(on_slopes(context, contact, angle, speed).captured))

    limit = float(capture_velocity(contact))
    return float(scipy.optimize.bisect(excess, 0.02 * limit, 3.0 * limit, xtol=APPARENT * limit))


def on_slopes(context: Context, contact: Contact, angle: float, normal_speed: float) -> Rebound:
    """Return what identical spheres do on slopes; the same facets whatever the speed."""
    capture = context.params.capture
    into, along = velocity_components(normal_speed / np.sin(np.radians(angle)), angle)
    velocity = np.tile([along, 0.0, into], (capture.spheres, 1))
    return collide(
        contact,
        velocity,
        np.zeros_like(velocity),
        capture.slope_sd,
        generator(context.params.seed, ANALYSIS),
    )


def share_lost(context: Context, contact: Contact, normal_speed: float) -> float:
    """Return the share that strikes again at once, or stays and rolls off the spot."""
    capture = context.params.capture
    angle = capture.oblique_angle_deg
    rebound = on_slopes(context, contact, angle, normal_speed)
    along = np.hypot(rebound.velocity[:, 0], rebound.velocity[:, 1])
    lag = max(capture.shifts_nm) * 1e-9
    distance = rolling_distance(contact, along, lag, 90.0 - angle) * 1e3
    rolls = rebound.captured & (distance > capture.spot_mm)
    return float(np.mean(rolls | (rebound.contacts > 1)))
