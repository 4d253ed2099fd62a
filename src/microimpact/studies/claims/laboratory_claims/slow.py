"""Numbers behind the claims on spin, regions of the impulse ratio, and slower impacts."""

from __future__ import annotations

import numpy as np
import scipy

from microimpact.core.arrays import FloatArray
from microimpact.lab.samples import Statistic, half_width, with_spin
from microimpact.model.dynamics.impact import simulate
from microimpact.studies.claims.laboratory_claims.context import Context, Numbers
from microimpact.studies.experiments.mechanisms.impulse_regions import regions
from microimpact.studies.experiments.mechanisms.spin import rolling_limit

# Greatest spread of spins, r omega/v, that is tried.
WIDEST_SPREAD = 10.0


def c15(context: Context) -> dict[str, float]:
    """Impulse ratio of a slow oblique impact with the spin of a sphere that has rolled."""
    slow, contact = context.params.slow, context.steel
    speed = min(slow.speeds_m_per_s)
    spin = slow.spin_ratio * speed / contact.radius
    impact = simulate(contact, speed, slow.spin_deg, spin)
    return {"impulse_ratio_at_45_deg_with_greatest_spin": float(impact.impulse_ratio)}


def c67(context: Context) -> dict[str, float]:
    """Kinds of regions between change points of the mean impulse ratio, and the transition."""
    wanted = context.params.regions
    samples = [context.seen(wanted.dropped, angle) for angle in wanted.angles_deg]
    ratio = [sample.statistics["impulse_ratio"] for sample in samples]
    mean, sd = (np.array([getattr(one, name) for one in ratio]) for name in ("mean", "sd"))
    known = np.isfinite(mean)
    error = sd[known] / np.sqrt([len(s.measured) for s, k in zip(samples, known, strict=True) if k])
    angle = np.array(wanted.angles_deg)[known]
    found = regions(angle, mean[known], error, wanted.constant_within)
    width = sum(one["width_deg"] for one in found if one["region"] == "transition")
    kinds = {one["region"] for one in found}
    if width < wanted.least_transition_deg:
        kinds.discard("transition")
    return {"regions_found": len(kinds), "width_of_transition": width}


def mean_sphere(context: Context) -> FloatArray:
    """Return restitution of the mean sphere by speed and angle (steep, shallow)."""
    slow = context.params.slow
    speed = np.array(slow.speeds_m_per_s)[:, None]
    impact = simulate(context.steel, speed, np.array(slow.trend_deg))
    return np.asarray(impact.coefficient_of_restitution)


def c75(context: Context) -> dict[str, float]:
    """Falls of restitution with the speed and the angle; of the sieve class, with the speed."""
    e = mean_sphere(context)
    fast, middle, slow = e[:, 0]
    falls = e[:, 0] - e[:, 1]
    table = context.table("speed_and_angle").sort_values("speed_m_per_s")
    conditional = table["conditional_mean_steep"].to_numpy(float)
    return {
        "fall_at_85_deg_1p60_to_1p05_m_per_s": fast - middle,
        "fall_at_85_deg_1p05_to_0p45_m_per_s": middle - slow,
        "fall_85_to_25_deg_at_0p45_less_at_1p60_m_per_s": falls[-1] - falls[0],
        "conditional_mean_fall_at_85_deg_1p60_to_0p45_m_per_s": conditional[-1] - conditional[0],
    }


def c76(context: Context) -> dict[str, float]:
    """Fall of restitution of the mean sphere at the greatest speed, from steep to shallow."""
    steep, shallow = mean_sphere(context)[0]
    return {"fall_of_restitution_85_to_25_deg": steep - shallow}


def c77(context: Context) -> dict[str, float]:
    """How far the end of rolling moves towards steep angles as the speed falls."""
    slow = context.params.slow
    fast, middle, slowest = slow.speeds_m_per_s
    base = rolling_limit(context.steel, fast, 0.0)
    return {
        "shift_of_rolling_limit_at_0p45_m_per_s": (
            rolling_limit(context.steel, slowest, slow.limit_spin_ratio) - base
        ),
        "shift_of_rolling_limit_at_1p05_m_per_s": rolling_limit(context.steel, middle, 0.0) - base,
    }


def c78(context: Context) -> dict[str, float]:
    """Least mean impulse ratio over spreads of spins, and the spins that would make it zero.

    The mean spin needed brings the mean to zero. No spread about zero does; the spread needed is
    the least with which the interval of an experiment reaches zero.
    """
    slow = context.params.slow
    needed = context.table("spin_needed", angle_deg=slow.spin_deg).iloc[0]
    return {
        "least_mean_impulse_ratio_zero_mean_spin": min(
            _with_spread(context, slow.mean_spin, sd).mean for sd in slow.spin_spreads
        ),
        "mean_spin_over_speed_needed": float(needed["mean_spin_needed"]),
        "spin_deviation_over_speed_needed": spread_needed(context),
        "rotational_over_translational_energy_needed": float(
            needed["rotational_over_translational_energy"]
        ),
    }


def _with_spread(context: Context, mean: float, sd: float) -> Statistic:
    slow = context.params.slow
    spun = with_spin(slow.dropped, mean=mean, sd=sd)
    return context.seen(spun, slow.spin_deg).statistics["impulse_ratio"]


def spread_needed(context: Context) -> float:
    """Return the spread of spins without a mean whose interval, of one mean, reaches zero."""
    exact = Statistic(mean=0.0, sd=0.0, systematic=0.0)

    def lower_end(sd: float) -> float:
        of = _with_spread(context, 0.0, sd)
        return of.mean - half_width(of, exact, context.params.sampling)

    return float(scipy.optimize.brentq(lower_end, 0.0, WIDEST_SPREAD, xtol=1e-2))


def c79(context: Context) -> dict[str, float]:
    """First angle at which the loss differs from that at the steepest; 0 if it never does."""
    table = context.table("speed_and_angle").sort_values("speed_m_per_s")
    slow, middle, fast = np.nan_to_num(table["first_departure_of_loss_deg"].to_numpy(float))
    return {
        "angle_of_departure_at_1p05_m_per_s": middle,
        "angle_of_departure_at_0p45_m_per_s": slow,
        "angle_of_departure_at_1p60_m_per_s": fast,
    }


def c80(context: Context) -> dict[str, float]:
    """Share of angles, restitutions and frictions at which the loss falls towards shallow ones."""
    share = context.inputs["loss_slopes"]["share_falling"].mean()
    return {"share_of_falling_slopes_below_45_deg": float(share)}


def c91(context: Context) -> dict[str, float]:
    """Spin, or tilt, that gives a mean impulse ratio of 0.01 at normal incidence.

    Of the calibrated contacts the greatest spin, and the least tilt, over the uncertainty that
    this study supposes.
    """
    table = context.inputs["spin_or_tilt"]
    tilt = float(table["tilt_deg"].min())
    return {
        "spin_over_speed_for_impulse_ratio_of_0p01": float(table["spin_over_speed"].max()),
        "tilt_for_impulse_ratio_of_0p01": tilt,
        "tilt_over_its_uncertainty": tilt / context.params.sampling.angle_error_deg,
    }


def c92(context: Context) -> dict[str, float]:
    """Rise by adhesion, and spread at equal normal speed of two speeds, by adhesion or slopes."""
    adhesion, slopes = (
        context.table("adhesion_or_roughness", cause=cause).iloc[0]
        for cause in ("adhesion", "slopes")
    )
    spread = "spread_at_equal_normal_speed"
    return {
        "spread_over_speeds_at_equal_normal_speed_by_adhesion": float(adhesion[spread]),
        "spread_over_speeds_at_equal_normal_speed_by_slopes": float(slopes[spread]),
        "rise_at_shallowest_rebound_at_1p66_m_per_s_by_adhesion": float(
            adhesion["rise_at_shallowest_rebound"]
        ),
    }


_SHIFTS = tuple(f"shift_of_rolling_limit_at_{speed}_m_per_s" for speed in ("0p45", "1p05"))
_DEPARTURES = tuple(f"angle_of_departure_at_{v}_m_per_s" for v in ("1p05", "0p45", "1p60"))

CLAIMS = {
    "C15": Numbers(of=c15, by_case=True, evidence="computed"),
    "C67": Numbers(of=c67, by_case=True, units={"width_of_transition": "deg"}),
    "C75": Numbers(of=c75, by_case=True, evidence="computed"),
    "C76": Numbers(of=c76, by_case=True, evidence="computed"),
    "C77": Numbers(of=c77, by_case=True, evidence="computed", units=dict.fromkeys(_SHIFTS, "deg")),
    "C78": Numbers(of=c78, by_case=True),
    "C79": Numbers(of=c79, by_case=True, units=dict.fromkeys(_DEPARTURES, "deg")),
    "C80": Numbers(of=c80, evidence="computed"),
    "C91": Numbers(of=c91, evidence="computed", units={"tilt_for_impulse_ratio_of_0p01": "deg"}),
    "C92": Numbers(of=c92, by_case=True),
}
