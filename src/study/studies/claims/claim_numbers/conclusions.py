"""Numbers of the claims of Sections 6 and 7: the conclusions of the article."""

from __future__ import annotations

import numpy as np

from microimpact.model.closed_forms import YIELD_PRESSURE_RATIO, plastic_restitution, yield_velocity
from microimpact.model.dynamics.impact import simulate, velocity_components
from microimpact.model.dynamics.rolling import gravity_ratio, rolling_distance
from study.declared.parameters import (
    Fraction,
    Name,
    Positive,
    PositiveRange,
)
from study.studies.claims.claim_numbers.claim import claim
from study.studies.claims.claim_numbers.context import Context, Numbers, greatest, without_adhesion


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
