"""The roughness that a printed restitution asks for (Sections 2.4.4 and 4.2)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from microimpact.core.arrays import FloatArray
from microimpact.core.solve import root
from microimpact.statistics.distributions import Normal
from microimpact.statistics.intervals import ERROR_BAR
from study.analyses.fig23_monte_carlo.ensembles import Ensemble, Plan, estimate, replicate_shares
from study.declared.parameters import AngleDegrees, NonNegative
from study.tables import Row

# Standard deviation of a quantity that may lie anywhere within one half-width.
RECTANGULAR = np.sqrt(3.0)
# Standard deviations between which a solution is sought, and points of the grid that brackets it.
SLOPE_SDS = (0.05, 0.6)
GRID = 10
# Relative step of a derivative.
STEP = 0.02


@dataclass(frozen=True, slots=True, kw_only=True)
class SlopeInference:
    """Measured restitution at an angle, and how well it is known."""

    # What is printed.
    angle_deg: AngleDegrees
    restitution: NonNegative
    # Half-widths of the angle as printed, and of the smooth surface's restitution.
    angle_half_width_deg: NonNegative
    restitution_half_width: NonNegative
    plan: Plan  # Events drawn


def infer_slope(ensemble: Ensemble, settings: SlopeInference, events_measured: int) -> Row:
    """Return the standard deviation of the slope that meets the restitution, and its uncertainty.

    All slopes share their random numbers, so that the restitution is a smooth function of the
    slope. The uncertainty has four parts: the interval of the measured mean, angle and
    smooth restitution within their half-widths, and the number of events drawn.

    Parameters
    ----------
    ensemble
        Rules, model and all parameters but the slope, which is taken as normal.
    settings
        Restitution to be met.
    events_measured
        Events behind one measured mean.
    """
    ensemble = replace(ensemble, plan=settings.plan)
    shares = [replicate_shares(ensemble, 0, number) for number in range(settings.plan.replicates)]
    grid = np.geomspace(*SLOPE_SDS, GRID)

    def measured(sd: float, angle: float = 0.0, shift: float = 0.0) -> float:
        rough = replace(ensemble, slope=Normal(sd=sd), restitution_shift=shift)
        return estimate(rough, settings.angle_deg + angle, shares=shares).restitution

    def solved(angle: float, shift: float) -> float:
        return _first_crossing(lambda sd: measured(sd, angle, shift) - settings.restitution, grid)

    sd = solved(0.0, 0.0)
    row: Row = {
        "largest_restitution": max(measured(float(sd)) for sd in grid),
        "reached": bool(np.isfinite(sd)),
    }
    if not row["reached"]:
        return row

    def half_range(angle: float, shift: float) -> float:
        return 0.5 * abs(solved(angle, shift) - solved(-angle, -shift))

    at = estimate(replace(ensemble, slope=Normal(sd=sd)), settings.angle_deg, shares=shares)
    step = STEP * sd
    rate = (measured(sd + step) - measured(sd - step)) / (2.0 * step)
    parts = {
        "u_events_measured": at.restitution_sd / np.sqrt(events_measured) / rate,
        "u_angle": half_range(settings.angle_half_width_deg, 0.0) / RECTANGULAR,
        "u_smooth_restitution": half_range(0.0, settings.restitution_half_width) / RECTANGULAR,
        "u_events_drawn": at.restitution_error / rate,
    }
    total = float(np.sqrt(sum(np.square(list(parts.values())))))
    return row | {
        "slope_sd": sd,
        **{name: float(value) for name, value in parts.items()},
        "u_slope_sd": total,
        "slope_sd_low": sd - ERROR_BAR * total,
        "slope_sd_high": sd + ERROR_BAR * total,
    }


def _first_crossing(function: Callable[[float], float], grid: FloatArray) -> float:
    """Return where a function first ascends through zero, infinity if it does not on the grid."""
    for low, high in pairwise(map(float, grid)):
        if function(high) >= 0.0:
            # The function has small steps where an event comes to be accepted.
            return root(function, low, high, absolute=1e-5)
    return np.inf
