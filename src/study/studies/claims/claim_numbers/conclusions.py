"""Numbers of the claims of Sections 6 and 7: the conclusions of the article."""

from __future__ import annotations

import numpy as np

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.solve import threshold
from microimpact.lab.experiment import Target
from microimpact.lab.surface import rough
from microimpact.model.closed_forms import YIELD_PRESSURE_RATIO, plastic_restitution, yield_velocity
from microimpact.model.contact import Contact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import planar, simulate, velocity_components
from microimpact.model.dynamics.rolling import gravity_ratio, rolling_distance
from microimpact.statistics.distributions import generator
from study.declared.parameters import (
    AngleDegrees,
    Count,
    Fraction,
    Name,
    NonNegative,
    Positive,
    PositiveRange,
)
from study.studies.claims.claim_numbers.claim import claim
from study.studies.claims.claim_numbers.context import Context, Numbers, greatest, without_adhesion

ANALYSIS = 98
# Where normal speeds of capture are looked for, relative to the one known.
AROUND = 1e-3
# To how much of the nominal normal speed apparent capture is found.
APPARENT = 1e-3
# Angles at which the normal speed of capture is sought.
DECOUPLED_DEG = (10.0, 20.0, 30.0, 45.0, 60.0, 75.0, 85.0)


@claim("C40", by_contact=True)
def c40(context: Context) -> Numbers:
    """Spin after impact, the largest over all rebounds."""
    impact = context.rebounds()
    return {"largest_final_spin": greatest(np.abs(impact.spin), ~impact.captured)}


@claim("C58")
def c58(context: Context, *, yield_strengths_MPa: dict[Name, Positive]) -> Numbers:
    """Loss by plastic deformation (Thornton and Ning 1998) over the loss measured, by hardness.

    Beside it the greatest pressure by Hertz without adhesion and damping, ``p_0 = 3 F/(2 pi a^2)``
    with ``F = K a^3/r``, and the yield strength at which nothing yields.
    """
    elastic = without_adhesion(context.steel).replace(hertz_damping=0.0)
    depth = simulate(elastic, context.speed).maximum_compression
    pressure = 1.5 / np.pi * elastic.stiffness * np.sqrt(depth / elastic.hertz_radius)
    measured = 1.0 - context.params.steel.restitution**2
    common = {
        "yield_strength_for_no_yield": pressure / YIELD_PRESSURE_RATIO * 1e-6,
        "peak_hertz_pressure": pressure * 1e-9,
    }

    def lost(strength: float) -> float:
        limit = yield_velocity(elastic, strength * 1e6)
        return 1.0 - float(plastic_restitution(context.speed, limit)) ** 2

    return {
        name: {"plastic_loss_over_measured_loss": lost(strength) / measured, **common}
        for name, strength in yield_strengths_MPa.items()
    }


@claim("C59", by_contact=True)
def c59(context: Context) -> Numbers:
    """Loss of energy, rotation included, with friction less that without; least of all rebounds."""
    angles = np.array(context.params.steel.angles_deg)[:, None]
    rough = context.impacts(context.speed, angles[:, 0])
    smooth = context.hit(context.steel.replace(friction=0.0), context.speed, angles)
    oblique = ~rough.captured & (angles < 90.0)
    return {
        "least_added_loss_of_total_energy": -greatest(
            smooth.energy_loss - rough.energy_loss, oblique
        )
    }


@claim("C97", by_contact=True)
def c97(
    context: Context, *, shifts_nm: PositiveRange, kept_share: Fraction, spot_mm: Positive
) -> Numbers:
    """Distance that a captured sphere rolls, and moment of its weight over adhesion's.

    It comes at the steepest angle at which it is captured, and adhesion alone stops it: the weight,
    which would carry it further, is given, too.
    """
    contact, angle = context.steel, context.capture_angle()
    along = kept_share * velocity_components(context.speed, angle)[1]
    numbers = {}
    for shift in shifts_nm:
        lag = shift * 1e-9
        distance = rolling_distance(contact, along, lag) * 1e3
        numbers[f"shift {shift:g} nm"] = {
            "distance_rolled_over_half_width_of_spot": distance / spot_mm,
            "gravity_moment_over_rolling_moment": gravity_ratio(contact, lag, 90.0 - angle),
        }
    return numbers


@claim("C98", by_case=True)
def c98(
    context: Context,
    *,
    angle_deg: AngleDegrees,
    slope_sd: NonNegative,
    spheres: Count,
) -> Numbers:
    """Normal speeds of capture without slopes, and where half are captured with them.

    Identical spheres meet slopes; the same ones at every speed.
    """
    contact = context.steel
    *speeds, upright = decoupled_speeds(contact, np.array([*DECOUPLED_DEG, 90.0]))
    target = Target(contact=contact, surface=rough(slope_sd))
    limit = float(capture_velocity(contact))
    diameter = np.full(spheres, contact.diameter)

    def apparent_speed(angle: float) -> float:
        """Return the nominal normal speed below which more than half the spheres stay."""

        def half_leave(speed: float) -> bool:
            into, along = velocity_components(speed / np.sin(np.radians(angle)), angle)
            velocity = np.tile([along, 0.0, into], (spheres, 1))
            rng = generator(context.params.sampling.seed, ANALYSIS)
            rebound = target.hit(diameter, velocity, np.zeros_like(velocity), rng)
            return float(np.mean(rebound.captured)) <= 0.5

        return threshold(half_leave, 0.02 * limit, 3.0 * limit, absolute=APPARENT * limit)

    return {
        "largest_difference_of_normal_capture_speeds_over_angles": np.max(
            np.abs(np.array(speeds) / upright - 1.0)
        ),
        "ratio_of_apparent_capture_speeds": apparent_speed(angle_deg) / apparent_speed(90.0),
    }


def decoupled_speeds(contact: Contact, angle: FloatArray) -> FloatArray:
    """Return the normal speed at which capture ends at angles of incidence in degrees."""
    limit = float(capture_velocity(contact))
    low, high = (np.full(angle.shape, limit * (1.0 + side * AROUND)) for side in (-1.0, 1.0))
    into, along = velocity_components(1.0, angle)

    def leaves(speed: FloatArray) -> BoolArray:
        return ~planar(contact, -speed, speed * along / -into).captured

    return threshold(leaves, low, high)
