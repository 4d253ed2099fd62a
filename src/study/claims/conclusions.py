"""Numbers of the claims of Sections 6 and 7: the conclusions of the article."""

from __future__ import annotations

import numpy as np

from microimpact.model.closed_forms import YIELD_PRESSURE_RATIO, plastic_restitution, yield_velocity
from microimpact.model.dynamics.impact import simulate, velocity_components
from microimpact.model.dynamics.rolling import gravity_ratio, rolling_distance
from study.claims.claim import RIDGE, Claim, Number
from study.claims.context import Context, Numbers, greatest, without_adhesion
from study.declared.parameters import (
    Fraction,
    Name,
    Positive,
    PositiveRange,
)


@Claim(
    "C40",
    "Final spins reach the order of 1e3 rad/s.",
    says=(
        "The largest final spin is {largest_final_spin}; the printed order means "
        "{largest_final_spin:bound}."
    ),
    where="6",
    quote="the final rotational velocities were determined to reach the order of 10³ rad/s",
    kind="contradiction",
    article="1e3",
    unit="rad/s",
    numbers={
        "largest_final_spin": Number(unit="rad/s", at_least=316.23, at_most=3162.3),
    },
    reason=(
        "An order of magnitude holds within half a decade; tested on the largest spin over all "
        "angles of rebound. Section 3.2.2 prints another order (C39)."
    ),
    cases=RIDGE,
    figures="fig21",
    equations="8 29",
    by_contact=True,
)
def c40(context: Context) -> Numbers:
    """Spin after impact, the largest over all rebounds."""
    impact = context.rebounds()
    return {"largest_final_spin": greatest(np.abs(impact.spin), ~impact.captured)}


@Claim(
    "C58",
    "The impacts hardly deform the materials plastically.",
    says=(
        "Plastic flow would take {plastic_loss_over_measured_loss} of the measured loss, from "
        "spring hard to annealed steel; little is {plastic_loss_over_measured_loss:bound}."
    ),
    where="7, 3",
    quote="plastic deformation during impact is minimal",
    article="minimal",
    numbers={
        "plastic_loss_over_measured_loss": Number("plastic loss / measured loss", at_most=0.1),
        "yield_strength_for_no_yield": Number(unit="MPa"),
        "peak_hertz_pressure": Number(unit="GPa"),
    },
    reason=(
        "Minimal means at most 10 % of the loss 1 - e^2 at the printed restitution. The loss at "
        "[[steel.speed_m_per_s:g]] m/s without adhesion is that of Thornton and Ning 1998, where "
        "the pressure of Hertz exceeds that at which a sphere begins to yield. A loss above the "
        "measured one excludes its yield strength."
    ),
    cases=("annealed", "spring hard"),
)
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


@Claim(
    "C97",
    "Captured spheres can roll away from the spot they hit on a tilted target.",
    says=(
        "A captured sphere rolls {distance_rolled_over_half_width_of_spot} times the half-width "
        "of the spot, depending on the assumed shift of the rolling moment."
    ),
    where="6",
    quote="captured particles can roll away from the (tilted) target zone",
    article="roll away",
    numbers={
        "distance_rolled_over_half_width_of_spot": Number(
            "distance rolled / half-width of the spot", at_least=1.0
        ),
        "gravity_moment_over_rolling_moment": Number("moment of gravity / rolling moment"),
    },
    reason=(
        "The rolling resistance of adhesion opposes the motion, from the steepest angle at which "
        "a sphere of [[steel.diameter_um:g]] µm at [[steel.speed_m_per_s:g]] m/s is captured. The "
        "lag of the contact, which sets that resistance, is not published, so both ends of its "
        "range must agree."
    ),
    cases=(
        "steel-silicon, n = 0, shift [[shifts_nm.0:g]] nm",
        "steel-silicon, n = 0, shift [[shifts_nm.1:g]] nm",
        "steel-silicon, n = 1, shift [[shifts_nm.0:g]] nm",
        "steel-silicon, n = 1, shift [[shifts_nm.1:g]] nm",
    ),
    by_contact=True,
)
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
