"""Restitution and impulse ratio measured on a slope: exact, expanded, and as printed (Section 4.1).

The article expands Eqs. (35) and (36) for shallow and for normal incidence. Here each equation,
as printed and as it should be, is compared with the exact rotation of the rigid body's rebound.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray, Real
from microimpact.core.solve import root
from microimpact.model.rigid_body.roughness import (
    RoughRebound,
    energy_bound,
    measured_restitution,
    normal_restitution,
    rolling_impulse_ratio_measured,
    rolling_restitution,
    rough_rebound,
    shallow_restitution,
    sloped_impulse_ratio,
)
from study.declared.parameters import AngleDegrees, Finite, Fraction, OpenShare
from study.tables import Tables, series_frame

_frame = partial(series_frame, x_unit="deg", y_unit="1")

RESTITUTION, IMPULSE = "restitution", "impulse ratio"
PRINTED, CORRECTED = FORMS = ("printed", "corrected")

# Limit of the search, degrees.
LARGEST_SLOPE = 45.0
# End of the axis, degrees.
DRAWN_SLOPES = 20.0
# Smooth curves.
POINTS = 401


@dataclass(frozen=True, kw_only=True)
class SlopedImpacts:
    """Impacts: angle and slope in radians, and e, which broadcast; all else numbers."""

    angle: Real
    slope: Real
    e: Real
    friction: float
    spin_ratio: float

    @cached_property
    def rebound(self) -> RoughRebound:
        """The exact rebound, computed once for all that is asked of it."""
        return rough_rebound(self.angle, self.slope, self.e, self.friction, self.spin_ratio)

    @property
    def mu(self) -> FloatArray:
        """Signed impulse ratio about the local normal."""
        return self.rebound.impulse_ratio

    @property
    def sliding(self) -> FloatArray:
        """The impulse ratio if the sphere slid throughout, +-f."""
        return np.copysign(self.friction, self.mu)


@dataclass(frozen=True, slots=True, kw_only=True)
class Equation:
    """One equation of the article for a measured coefficient.

    `quantity`: which coefficient it gives; `shallow`: whether it is for shallow incidence, else for
    normal incidence; `form`: its value for a case, as printed (True) or as it should be.
    """

    quantity: str
    shallow: bool
    form: Callable[[SlopedImpacts, bool], Real]

    def exact(self, case: SlopedImpacts) -> FloatArray:
        """Return the measured coefficient without expansion."""
        rebound = case.rebound
        if self.quantity == RESTITUTION:
            return rebound.measured_restitution
        return rebound.measured_impulse_ratio

    def value(self, case: SlopedImpacts, form: str) -> FloatArray:
        """Return the value by the equation, in the shape of the exact value."""
        exact = self.exact(case)
        return np.broadcast_to(self.form(case, form == PRINTED), np.shape(exact))

    def error(self, case: SlopedImpacts, form: str) -> FloatArray:
        """Return the error relative to the exact value."""
        exact = self.exact(case)
        return np.abs(self.value(case, form) - exact) / np.abs(exact)


EQUATIONS = {
    name: Equation(
        quantity=IMPULSE if name in {"38", "41"} else RESTITUTION,
        shallow=name in {"35", "37", "38"},
        form=form,
    )
    for name, form in {
        "35": lambda c, p: measured_restitution(c.angle, c.slope, c.e, c.mu, printed=p),
        "37": lambda c, p: shallow_restitution(c.angle, c.slope, c.e, c.sliding, printed=p),
        "38": lambda c, p: sloped_impulse_ratio(c.slope, c.sliding, printed=p),
        "39": lambda c, p: normal_restitution(c.slope, c.e, c.mu, printed=p),
        "after 40": lambda c, p: rolling_restitution(c.slope, c.e, c.spin_ratio, printed=p),
        "41": lambda c, p: rolling_impulse_ratio_measured(c.slope, c.e, c.spin_ratio, printed=p),
    }.items()
}


# Steps in which a range is walked before its end is found by a root search.
STEPS = 2000
# The walk begins off a point at which the error is 0/0, and ends off grazing incidence: a share.
OFF = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Impacts on slopes, and the relative error ``tolerance`` that counts as agreement."""

    restitution: Annotated[float, Field(gt=0, le=1, allow_inf_nan=False)]
    friction: Fraction
    tolerance: OpenShare
    drawn_angle_deg: AngleDegrees
    drawn_spin_ratio: Finite


def run(params: Params, inputs: Tables) -> Tables:
    """Compare the printed and the corrected equations with the exact coefficients.

    ``roughness``: e_m over slope, e_m and -mu_m at normal incidence, exact and by both forms of
    each equation. The series ``range printed`` and ``range corrected`` are the two ends of the
    range around no slope within which it is as exact as the tolerance asks.
    """
    return {"roughness": curves(params)}


def slope_range(
    equation: Equation, form: str, template: SlopedImpacts, tolerance: float
) -> tuple[float, float]:
    """Return the slopes in degrees around zero for which a form is exact; NaN if there are none.

    Parameters
    ----------
    equation, form
        What is compared with the exact value, printed or corrected.
    template
        An impact, of which the slope varies: up to `LARGEST_SLOPE` to either side.
    tolerance
        Relative error.
    """

    def excess(slope: Real) -> FloatArray:
        case = replace(template, slope=np.radians(slope))
        return equation.error(case, form) - tolerance

    lowest = max(-LARGEST_SLOPE, -float(np.degrees(template.angle)) * (1 - OFF))
    low, high = (first_excess(excess, OFF * end, end) for end in (lowest, LARGEST_SLOPE))
    return low, high


def first_excess(excess: Callable[[Real], FloatArray], start: float, end: float) -> float:
    """Return where the way from start to end first meets a positive excess.

    The end, if it never does; NaN, if it does from the start.
    """
    steps = np.linspace(start, end, STEPS + 1)
    over = excess(steps) > 0.0
    if not over.any():
        return end
    first = int(np.argmax(over))
    if first == 0:
        return np.nan
    return root(excess, steps[first - 1], steps[first], absolute=1e-12)


def curves(params: Params) -> pd.DataFrame:
    """Return the data of the figure."""
    angle, spin = params.drawn_angle_deg, params.drawn_spin_ratio

    def case(angle_deg: Real, slope_deg: Real, spin_ratio: float) -> SlopedImpacts:
        return SlopedImpacts(
            angle=np.radians(angle_deg),
            slope=np.radians(slope_deg),
            e=params.restitution,
            friction=params.friction,
            spin_ratio=spin_ratio,
        )

    slopes = np.linspace(-DRAWN_SLOPES, DRAWN_SLOPES, POINTS)
    facing = slopes[slopes > -0.9 * angle]
    frames = []
    for view, name, x, at, ratio in (
        ("slope", "37", facing, angle, 0.0),
        ("normal", "after 40", slopes, 90.0, 0.0),
        ("normal", "41", slopes, 90.0, spin),
    ):
        equation, impacts = EQUATIONS[name], case(at, x, ratio)
        panel = f"{view} {equation.quantity}"
        sign = 1.0 if equation.quantity == RESTITUTION else -1.0
        frames.append(_frame(panel, "exact", x, sign * equation.exact(impacts)))
        for form in FORMS:
            y = sign * equation.value(impacts, form)
            frames.append(_frame(panel, form, x, y))
            ends = np.array(slope_range(equation, form, case(at, 0.0, ratio), params.tolerance))
            if np.isfinite(ends).all():
                frames.append(_frame(panel, f"range {form}", ends, np.interp(ends, x, y)))
        if equation.quantity == RESTITUTION:
            frames += _others(panel, equation, x, impacts)
    return pd.concat(frames, ignore_index=True)


def _others(
    panel: str, equation: Equation, x: FloatArray, case: SlopedImpacts
) -> list[pd.DataFrame]:
    """Return the bound of energy, and the equation before the expansion as printed."""
    if not equation.shallow:
        return [_frame(panel, "39 printed", x, EQUATIONS["39"].value(case, PRINTED))]
    bound = energy_bound(case.angle, case.spin_ratio)
    before = EQUATIONS["35"].value(case, PRINTED)
    beyond = np.broadcast_to(case.angle + 2.0 * case.slope < 0.0, x.shape)
    frames = [_frame(panel, "energy bound", x, bound)]
    # two branches, on either side of its pole
    for series, side in (("35 printed", ~beyond), ("35 printed beyond", beyond)):
        if side.any():
            frames.append(_frame(panel, series, x[side], before[side]))
    return frames
