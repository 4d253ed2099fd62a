"""Numbers behind the claims on normal impacts of steel on silicon."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import scipy

from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.empirical.fit import fit_restitution
from microimpact.studies.claim_numbers import Numbers
from microimpact.studies.claims.model_claims.context import Context, between, without_adhesion

# Hertz (1882): duration of an elastic impact in greatest compressions over the speed.
HERTZ_DURATION = 2.9432751
# Yielding starts below the surface where the greatest pressure exceeds 1.6 yield strengths.
PRESSURE_AT_YIELD = 1.6
# Tabor (1951): representative strain of an indentation over its radius in sphere radii.
TABOR_STRAIN = 0.2


def c05(context: Context) -> dict[str, float]:
    """Restitution against that at 1.66 m/s: greatest change down to 0.75 m/s, fall at 0.3 m/s."""
    normal = context.params.normal
    speeds = between((normal.flat_from_m_per_s, context.speed), normal.points)
    e = context.hit(context.steel, speeds).coefficient_of_restitution
    slow = context.hit(context.steel, normal.slow_speed_m_per_s).coefficient_of_restitution
    return {
        "largest_relative_change_of_restitution_above_0p75_m_per_s": np.max(np.abs(e / e[-1] - 1)),
        "relative_fall_of_restitution_at_0p3_m_per_s": 1.0 - slow / e[-1],
    }


def c07(context: Context) -> dict[str, float]:
    """Capture velocity, and speed at 0.9 of the plateau, of the larger mean size over the smaller.

    The plateau is each size's own restitution at 1.66 m/s. The work of adhesion is that of the
    calibrated size times a power of the ratio of sizes, as a rule the power 0.
    """
    normal, steel = context.params.normal, context.steel
    captured, falling = [], []
    for diameter in normal.compared_diameters_um:
        growth = (diameter / context.params.steel.diameter_um) ** normal.adhesion_size_exponent
        contact = resized(
            steel.replace(work_of_adhesion=steel.work_of_adhesion * growth), diameter * 1e-6
        )
        captured.append(float(capture_velocity(contact)))
        falling.append(speed_of_share(context, contact))
    return {
        "capture_velocity_ratio_75_to_49_um": captured[0] / captured[1],
        "speed_ratio_at_0p9_of_plateau_75_to_49_um": falling[0] / falling[1],
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
            return float(scipy.optimize.brentq(excess, slow, fast, xtol=1e-14, rtol=1e-14))
    raise ValueError(f"restitution never falls to {normal.plateau_share:g} of its plateau")


def c21(context: Context) -> dict[str, float]:
    """Restitution and adhesion coefficient at a speed 1e-4 above that of capture, as calibrated.

    The adhesion coefficient by Eq. (16), 1 - e/R, R from the same impact without ring force.
    """
    normal, steel = context.params.normal, context.steel
    speed = context.calibrated_capture_velocity * (1.0 + normal.above_capture)
    bare = without_adhesion(steel)
    e, body = (float(simulate(c, speed).coefficient_of_restitution) for c in (steel, bare))
    at_rest = simulate(bare, normal.rest_speed_m_per_s).coefficient_of_restitution
    return {
        "restitution_just_above_capture": e,
        "adhesion_coefficient_just_above_capture": 1.0 - e / body,
        "restitution_without_adhesion_at_1_mm_per_s": float(at_rest),
    }


def c27(context: Context) -> dict[str, float]:
    """Share of the adhesion's damping in all that is lost, at multiples of the capture velocity.

    The capture velocity is that which the calibration met.
    """
    multiples = np.array(context.params.normal.capture_velocities)
    speeds = multiples * context.calibrated_capture_velocity
    ledger = normal_impact(context.steel, speeds, ledger=True).ledger
    assert ledger is not None
    shares = ledger.adhesion_work / (ledger.adhesion_work + ledger.hertz_work)
    return {
        f"adhesion_share_at_{multiple:g}_capture_velocities": share
        for multiple, share in zip(multiples, shares, strict=True)
    }


def c28(context: Context) -> dict[str, float]:
    """Restitution at the high speed and capture velocity, less the printed ones."""
    e = float(simulate(context.steel, context.speed).coefficient_of_restitution)
    return {
        "residual_of_restitution": e - context.printed("restitution_sst_silicon_normal"),
        "residual_of_capture_velocity": float(capture_velocity(context.steel))
        - context.printed("capture_velocity_sst_silicon"),
    }


def c29(context: Context) -> dict[str, float]:
    """Greatest compression with the ring force over that without: the least over speeds."""
    normal, steel = context.params.normal, context.steel
    speeds = between((normal.slow_speed_m_per_s, context.speed), normal.points)
    deep, bare = (simulate(c, speeds).maximum_compression for c in (steel, without_adhesion(steel)))
    return {"least_ratio_of_compression_with_to_without_adhesion": np.min(deep / bare)}


def c36(context: Context) -> dict[str, float]:
    """Capture velocity of the calibrated contact."""
    return {"capture_velocity": float(capture_velocity(context.steel))}


def c37(context: Context) -> dict[str, float]:
    """Shortest and longest contact of all rebounds in a range of sizes and speeds.

    Just above the capture velocity of each size contact lasts longest: those speeds are added.
    """
    normal, steel = context.params.normal, context.steel
    diameters = between(normal.lasting_diameters_um, normal.points) * 1e-6
    low, high = normal.lasting_speeds_m_per_s
    sizes = resized(steel, diameters[:, None])
    limit = np.clip(capture_velocity(sizes) * (1.0 + normal.above_capture), low, high)
    speeds = np.hstack(
        [
            np.broadcast_to(between((low, high), normal.points), (diameters.size, normal.points)),
            limit,
        ]
    )
    impact = simulate(sizes, speeds)
    free = ~impact.captured
    lasting = impact.contact_time[free] * 1e9
    bare = without_adhesion(sizes).replace(hertz_damping=0.0)
    deepest = simulate(bare, speeds).maximum_compression
    hertz = (HERTZ_DURATION * deepest / speeds)[free] * 1e9
    return {
        "shortest_contact": lasting.min(),
        "longest_contact": lasting.max(),
        "shortest_contact_by_hertz": hertz.min(),
        "longest_contact_by_hertz": hertz.max(),
    }


def c38(context: Context) -> dict[str, float]:
    """Strain of a normal impact over half its duration, by three measures of strain."""
    steel = context.steel
    impact = simulate(steel, context.speed)
    half, compression = float(impact.contact_time) / 2.0, float(impact.maximum_compression)
    radius = float(steel.radius)
    contact_radius = np.sqrt(float(steel.hertz_radius) * compression)
    return {
        "rate_of_radius_strain": contact_radius / radius / half,
        "rate_of_tabor_strain": TABOR_STRAIN * contact_radius / radius / half,
        "rate_of_compression_strain": compression / radius / half,
    }


def c43(context: Context) -> dict[str, float]:
    """Capture velocity by Eq. (34) over the simulated one, less 1, exponents free.

    From data close above capture by the table of the fits; from two capture velocities here.
    """
    table, normal = context.inputs["restitution_fits"], context.params.normal
    own = (table["case"] == context.case) & (table["exponent"] == "free")
    rows = table[own & (table["evidence"] != "digitised")]
    if len(rows) != 1:
        raise ValueError(f"restitution_fits: {len(rows)} fits of case {context.case!r}, need one")
    fitted, limit = rows["v_c_m_per_s"].iloc[0], rows["simulated_v_c_m_per_s"].iloc[0]
    steel_limit = float(capture_velocity(context.steel))
    ratios = between((normal.fitted_from, normal.fitted_to), normal.fitted_points)
    e = simulate(context.steel, ratios * steel_limit).coefficient_of_restitution
    later = fit_restitution(ratios * steel_limit, e).v_c
    return {
        "relative_error_of_fitted_capture_velocity": fitted / limit - 1.0,
        "relative_error_from_data_above_2_capture_velocities": later / steel_limit - 1.0,
    }


def c58(context: Context) -> dict[str, float]:
    """Greatest pressure by Hertz without adhesion and damping, and the yield strength it needs.

    ``p_0 = 3 F/(2 pi a^2)`` with ``F = K a^3/r``.
    """
    steel = next(context.cases()).steel
    elastic = without_adhesion(steel).replace(hertz_damping=0.0)
    depth = float(simulate(elastic, context.speed).maximum_compression)
    slope = np.sqrt(depth / float(elastic.hertz_radius))
    pressure = 1.5 / np.pi * float(elastic.stiffness) * slope
    return {
        "yield_strength_needed": pressure / PRESSURE_AT_YIELD * 1e-6,
        "peak_hertz_pressure": pressure * 1e-9,
    }


_DURATIONS = (
    "shortest_contact",
    "longest_contact",
    "shortest_contact_by_hertz",
    "longest_contact_by_hertz",
)
_RATES = ("rate_of_radius_strain", "rate_of_tabor_strain", "rate_of_compression_strain")

CLAIMS = {
    "C05": Numbers(of=c05, by_case=True, evidence="calibrated"),
    "C07": Numbers(of=c07, by_case=True),
    "C21": Numbers(of=c21, by_case=True),
    "C27": Numbers(of=c27, by_case=True),
    "C28": Numbers(
        of=c28,
        by_case=True,
        evidence="calibrated",
        units={"residual_of_capture_velocity": "m/s"},
    ),
    "C29": Numbers(of=c29, by_case=True),
    "C36": Numbers(of=c36, by_case=True, evidence="calibrated", units={"capture_velocity": "m/s"}),
    "C37": Numbers(of=c37, by_case=True, units=dict.fromkeys(_DURATIONS, "ns")),
    "C38": Numbers(of=c38, by_case=True, units=dict.fromkeys(_RATES, "1/s")),
    "C43": Numbers(of=c43, by_case=True),
    "C58": Numbers(of=c58, units={"yield_strength_needed": "MPa", "peak_hertz_pressure": "GPa"}),
}
