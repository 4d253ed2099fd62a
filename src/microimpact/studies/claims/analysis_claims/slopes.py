"""Claims of Section 4.1: what is measured on one slope, against the exact rotation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from microimpact.core.arrays import FloatArray
from microimpact.studies.analyses.roughness_expansions import EQUATIONS, Case
from microimpact.studies.claims.analysis_claims.context import Context
from microimpact.studies.claims.analysis_claims.params import Slopes


def c45(context: Context) -> dict[str, float]:
    """Return e_m over e on a facet as steep as the angle of incidence, by Eq. (35)."""
    slopes = context.params.slopes
    return {"measured_over_true_restitution": steep_restitution(slopes) / slopes.restitution}


def c46(context: Context) -> dict[str, float]:
    """Return e_m itself on that facet."""
    return {"measured_restitution": steep_restitution(context.params.slopes)}


def c47(context: Context) -> dict[str, float]:
    """Return by how much a facing slope changes the exact e_m, mu_m and -mu_m from no slope."""
    slopes = context.params.slopes
    facing, level = (shallow(slopes, degrees).rebound for degrees in (slopes.facing_slope_deg, 0.0))
    change = float(facing.measured_impulse_ratio - level.measured_impulse_ratio)
    return {
        "change_of_restitution": float(facing.measured_restitution - level.measured_restitution),
        "change_of_signed_impulse_ratio": change,
        "change_of_impulse_ratio_as_plotted": -change,
    }


def c48(context: Context) -> dict[str, float]:
    """Return the error of the coefficient of phi^2 in e_m at normal incidence without spin.

    Of the expansion after Eq. (40) and of the exact rotation, at all restitutions.
    """
    slopes = context.params.slopes
    squared = np.square(np.radians(slopes.small_slope_deg))
    errors = []
    for e in slopes.restitutions:
        case = upright(slopes, slopes.small_slope_deg, slopes.spin_ratio, e)
        errors.append((EQUATIONS["after 40"].value(case, slopes.form) - exact(case)[0]) / squared)
    return {"largest_error_of_coefficient_of_squared_slope": float(np.max(np.abs(errors)))}


def c49(context: Context) -> dict[str, float]:
    """Return the error of the coefficient of phi in mu_m (Eq. 41), and mu_m without a slope."""
    slopes = context.params.slopes
    phi = float(np.radians(slopes.small_slope_deg))
    errors, level = [], []
    for e in slopes.restitutions:
        sloped, flat = (
            upright(slopes, degrees, slopes.spin_ratio, e)
            for degrees in (slopes.small_slope_deg, 0.0)
        )
        coefficient = EQUATIONS["41"].value(replace(sloped, spin_ratio=0.0), slopes.form) / phi
        errors.append((exact(sloped)[1] - exact(flat)[1]) / phi - coefficient)
        level.append(exact(flat)[1])
    return {
        "largest_error_of_coefficient_of_slope": float(np.max(np.abs(errors))),
        "impulse_ratio_without_slope": float(np.max(np.abs(level))),
    }


def c50(context: Context) -> dict[str, float]:
    """Return the exact bias by spin over that of Eq. (41), and over (2/7) (r omega / v) phi."""
    slopes = context.params.slopes
    spun, bare = (
        upright(slopes, slopes.small_slope_deg, spin, slopes.restitution)
        for spin in (slopes.biasing_spin_ratio, 0.0)
    )
    of_e, of_mu = (
        float(with_ - without) for with_, without in zip(exact(spun), exact(bare), strict=True)
    )
    by_41 = float(
        EQUATIONS["41"].value(spun, slopes.form) - EQUATIONS["41"].value(bare, slopes.form)
    )
    first = 2.0 / 7.0 * slopes.biasing_spin_ratio * float(spun.slope)
    return {
        "bias_of_impulse_ratio_over_that_of_eq_41": of_mu / by_41,
        "bias_of_restitution_over_first_order": of_e / first,
    }


def steep_restitution(slopes: Slopes) -> float:
    """Return e_m by Eq. (35) on the facet as steep as the angle of incidence."""
    case = shallow(slopes, slopes.steep_slope_deg)
    return float(EQUATIONS["35"].value(case, slopes.form))


def shallow(slopes: Slopes, slope_deg: float) -> Case:
    """Return a shallow impact on a slope."""
    return Case(
        angle=np.radians(slopes.angle_deg),
        slope=np.radians(slope_deg),
        e=slopes.restitution,
        friction=slopes.friction,
        spin_ratio=slopes.spin_ratio,
    )


def upright(slopes: Slopes, slope_deg: float, spin_ratio: float, e: float) -> Case:
    """Return an impact at normal incidence on a slope."""
    return Case(
        angle=np.pi / 2,
        slope=np.radians(slope_deg),
        e=e,
        friction=slopes.friction,
        spin_ratio=spin_ratio,
    )


def exact(case: Case) -> tuple[FloatArray, FloatArray]:
    """Return e_m and the signed mu_m of the exact rotation."""
    return case.rebound.measured_restitution, case.rebound.measured_impulse_ratio
