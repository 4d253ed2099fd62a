"""Restitution and impulse ratio measured on a slope: exact, expanded, and as printed (Section 4.1).

The article expands Eqs. (35) and (36) for shallow and for normal incidence. Here each equation,
as printed and as it should be, is compared with the exact rotation of the rigid body's rebound.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import product
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray, Real
from microimpact.core.solve import root
from microimpact.model.rigid_body.roughness import (
    RoughRebound,
    energy_bound,
    greatest_restitution,
    measured_restitution,
    normal_restitution,
    rolling_impulse_ratio_measured,
    rolling_restitution,
    rough_rebound,
    shallow_restitution,
    sloped_impulse_ratio,
)
from study.declared.parameters import AngleDegrees, Finite, Fraction, ObliqueDegrees, OpenShare
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

    `name`, `quantity`: its number, and which coefficient it gives; `shallow`: whether it is for
    shallow incidence; else for normal incidence; `spun`: whether it contains spin; `form`: its
    value for a case, as printed (True) or as it should be.
    """

    name: str
    quantity: str
    shallow: bool
    spun: bool
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
        name=name,
        quantity=IMPULSE if name in {"38", "41"} else RESTITUTION,
        shallow=name in {"35", "37", "38"},
        spun=name in {"39", "41"},
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


SlopeDegrees = Annotated[float, Field(gt=-90, lt=90)]

# Steps in which a range is walked before its end is found by a root search.
STEPS = 2000
# The walk begins off a point at which the error is 0/0, and ends off grazing incidence: a share.
OFF = 1e-6

RANGE_COLUMNS = [
    *("equation", "quantity", "form", "spin_ratio", "criterion", "variable", "fixed_deg"),
    *("low_deg", "high_deg", "low_is_limit", "high_is_limit"),
]
Found = tuple[float, float, bool, bool]
NOWHERE: Found = (np.nan, np.nan, False, False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Impacts on slopes, and the relative error ``tolerance`` that counts as agreement.

    Ranges of the slope are sought at ``shallow_angles_deg`` and at normal incidence, up to
    `LARGEST_SLOPE` to either side; ranges of the angle at ``range_slopes_deg``.
    """

    restitution: Annotated[float, Field(gt=0, le=1, allow_inf_nan=False)]
    friction: Fraction
    spin_ratios: Annotated[tuple[Finite, ...], Field(min_length=1)]
    shallow_angles_deg: Annotated[tuple[AngleDegrees, ...], Field(min_length=1)]
    slopes_deg: Annotated[tuple[SlopeDegrees, ...], Field(min_length=1)]
    range_slopes_deg: Annotated[tuple[SlopeDegrees, ...], Field(min_length=1)]
    tolerance: OpenShare
    drawn_angle_deg: AngleDegrees
    drawn_slope_deg: ObliqueDegrees
    drawn_spin_ratio: Finite

    def case(self, angle_deg: Real, slope_deg: Real, spin_ratio: float) -> SlopedImpacts:
        """Return impacts on slopes, both angles in degrees."""
        return SlopedImpacts(
            angle=np.radians(angle_deg),
            slope=np.radians(slope_deg),
            e=self.restitution,
            friction=self.friction,
            spin_ratio=spin_ratio,
        )

    def angles(self, equation: Equation) -> tuple[float, ...]:
        """Return the angles of incidence in degrees that an equation is for."""
        return self.shallow_angles_deg if equation.shallow else (90.0,)

    def spins(self, equation: Equation) -> tuple[float, ...]:
        """Return the spin ratios for an equation; only 0 where it does not contain spin."""
        return self.spin_ratios if equation.spun else (0.0,)


def run(params: Params, inputs: Tables) -> Tables:
    """Compare the printed and the corrected equations with the exact coefficients.

    ``roughness_expansions``: per equation, angle, slope and spin the exact value, both forms, their
    relative errors, and for e_m the bounds. Slopes that face away from the sphere have no row.
    ``roughness_ranges``: per equation and form the ranges of slope and angle, around no slope or
    from the incidence it is for, within which it is as exact as the tolerance asks (``accuracy``)
    or its e_m within the bound of energy (``energy``). Ends are empty where it is so nowhere; an
    end may be the limit of the search: largest slope, grazing or normal incidence. ``roughness``:
    data of the figure, the impulse ratio as -mu_m.
    """
    return {
        "roughness_expansions": expansions(params),
        "roughness_ranges": ranges(params),
        "roughness": curves(params),
    }


def expansions(params: Params) -> pd.DataFrame:
    """Return the table of exact, printed and corrected values."""
    frames = []
    for equation in EQUATIONS.values():
        grid = np.meshgrid(params.angles(equation), params.slopes_deg, indexing="ij")
        facing = grid[0] + grid[1] > 0.0
        angle, slope = (degrees[facing] for degrees in grid)
        for spin in params.spins(equation):
            case = params.case(angle, slope, spin)
            exact = equation.exact(case)
            values = {form: equation.value(case, form) for form in FORMS}
            columns = {
                "equation": equation.name,
                "quantity": equation.quantity,
                "angle_deg": angle,
                "slope_deg": slope,
                "restitution": params.restitution,
                "friction": params.friction,
                "spin_ratio": spin,
                "local_impulse_ratio": case.mu,
                "exact": exact,
                **values,
                **{f"{form}_error": equation.error(case, form) for form in FORMS},
            }
            if equation.quantity == RESTITUTION:
                bound = energy_bound(case.angle, spin)
                columns |= {
                    "energy_bound": bound,
                    "greatest_without_spin": greatest_restitution(case.angle, case.e),
                    "exact_within_bound": np.abs(exact) <= bound,
                }
                columns |= {f"{f}_within_bound": np.abs(values[f]) <= bound for f in FORMS}
            frames.append(pd.DataFrame(columns))
    return pd.concat(frames, ignore_index=True).assign(evidence="computed")


def ranges(params: Params) -> pd.DataFrame:
    """Return the table of ranges. Eq. (35) as corrected is exact and has no row."""
    rows: list[tuple[object, ...]] = []
    for equation, form in product(EQUATIONS.values(), FORMS):
        if equation.name == "35" and form == CORRECTED:
            continue
        criteria = ["accuracy"] + ["energy"] * (equation.quantity == RESTITUTION)
        for spin in params.spins(equation):
            start, arguments = (
                (equation.name, equation.quantity, form, spin),
                (params, equation, form),
            )
            for angle, criterion in product(params.angles(equation), criteria):
                limits = slope_range(*arguments, angle, spin, energy=criterion == "energy")
                rows.append((*start, criterion, "slope", angle, *limits))
            for slope in params.range_slopes_deg:
                limits = angle_range(*arguments, slope, spin)
                rows.append((*start, "accuracy", "angle", slope, *limits))
    table = pd.DataFrame(rows, columns=RANGE_COLUMNS)
    return table.assign(tolerance=params.tolerance, evidence="computed")


def slope_range(
    params: Params, equation: Equation, form: str, angle: float, spin: float, energy: bool = False
) -> Found:
    """Return the slopes in degrees around zero for which a form holds, and which ends are limits.

    To hold means to be as exact as the tolerance or, if `energy`, not to break energy.
    """
    template = params.case(angle, 0.0, spin)

    def excess(slope: Real) -> FloatArray:
        case = replace(template, slope=np.radians(slope))
        if not energy:
            return equation.error(case, form) - params.tolerance
        return np.abs(equation.value(case, form)) / energy_bound(case.angle, spin) - 1.0

    lowest, highest = max(-LARGEST_SLOPE, -angle * (1 - OFF)), LARGEST_SLOPE
    low, high = (first_excess(excess, OFF * end, end) for end in (lowest, highest))
    return NOWHERE if np.isnan(low + high) else (low, high, low == lowest, high == highest)


def angle_range(params: Params, equation: Equation, form: str, slope: float, spin: float) -> Found:
    """Return the angles in degrees, from the incidence a form is for, in which it is exact."""
    template = params.case(90.0, slope, spin)

    def excess(angle: Real) -> FloatArray:
        case = replace(template, angle=np.radians(angle))
        return equation.error(case, form) - params.tolerance

    least = max(-slope, 0.0) + 90.0 * OFF
    start, end = (least, 90.0) if equation.shallow else (90.0, least)
    limit = first_excess(excess, start, end)
    if np.isnan(limit):
        return NOWHERE
    low, high = min(start, limit), max(start, limit)
    return low, high, low == least, high == 90.0


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
    """Return the data of the figure: e_m and -mu_m over slope, over angle, at normal incidence.

    The series ``range printed`` and ``range corrected`` are the two ends of a range.
    """
    angle, slope, reach = params.drawn_angle_deg, params.drawn_slope_deg, DRAWN_SLOPES
    # up to where a sphere without spin would slide the other way
    angles = np.linspace(1.0, 89.0 - slope, POINTS)
    slopes = np.linspace(-reach, reach, POINTS)
    facing = slopes[slopes > -0.9 * angle]
    frames = []
    for shallow, normal, spin in (("37", "after 40", 0.0), ("38", "41", params.drawn_spin_ratio)):
        for view, name, x, case in (
            ("slope", shallow, facing, params.case(angle, facing, 0.0)),
            ("angle", shallow, angles, params.case(angles, slope, 0.0)),
            ("normal", normal, slopes, params.case(90.0, slopes, spin)),
        ):
            equation = EQUATIONS[name]
            panel = f"{view} {equation.quantity}"
            frames += _panel(params, panel, view, equation, x, case)
            if equation.quantity == RESTITUTION:
                frames += _others(panel, equation, x, case)
    return pd.concat(frames, ignore_index=True)


def _panel(
    params: Params, panel: str, view: str, equation: Equation, x: FloatArray, case: SlopedImpacts
) -> list[pd.DataFrame]:
    sign = 1.0 if equation.quantity == RESTITUTION else -1.0
    frames = [_frame(panel, "exact", x, sign * equation.exact(case))]
    for form in FORMS:
        y = sign * equation.value(case, form)
        frames.append(_frame(panel, form, x, y))
        if view == "angle":
            limits = angle_range(params, equation, form, params.drawn_slope_deg, case.spin_ratio)
        else:
            angle = params.drawn_angle_deg if view == "slope" else 90.0
            limits = slope_range(params, equation, form, angle, case.spin_ratio)
        ends = np.array(limits[:2])
        if np.isfinite(ends).all():
            frames.append(_frame(panel, f"range {form}", ends, np.interp(ends, x, y)))
    return frames


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
