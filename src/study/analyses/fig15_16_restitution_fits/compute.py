"""Simulated restitution curves and their fits by Eq. (34) (Figs. 15 and 16)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np
import pandas as pd

from microimpact.core.arrays import FloatArray
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.empirical.fit import RestitutionFit, fit_restitution
from study.contacts import (
    CAPTURE_VELOCITIES,
    calibrated_contact,
    fitted_to,
    printed_capture_velocity,
)
from study.declared.parameters import AboveOne, CaseName, Fraction
from study.tables import (
    NotComputedError,
    Row,
    Tables,
    series_frame,
)

NEEDS = {"calibration": ("calibration",)}
PRINTED_VALUES = CAPTURE_VELOCITIES

_frame = partial(series_frame, "restitution", x_unit="m_per_s", y_unit="1")

# Curves begin at this share of the capture velocity, and are dense so far above it, where they rise
# like a root.
DRAWN_FROM = 0.7
JUST_ABOVE = np.geomspace(1e-5, 0.03, 12)

# End of the axis of Fig. 16, m/s.
LARGEST_SPEED = 3.0
# Smooth curves.
CURVE_POINTS = 300
# As many as events in an experiment.
FITTED_POINTS = 40


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedCase:
    """One calibrated contact, where its curve is drawn and up to which speed it is fitted.

    ``fitted_to`` is a speed in capture velocities of the simulation. Cases that are not ``fitted``
    are drawn only: the ends of an interval.
    """

    figure: Literal["fig15", "fig16"]
    fitted: bool = True
    fitted_to: AboveOne


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """The cases, and how their curves are sampled and fitted.

    ``fitted_from`` is a speed in capture velocities of the simulation.
    """

    cases: dict[CaseName, FittedCase]
    fitted_from: AboveOne
    fixed_exponent: Fraction

    def __post_init__(self) -> None:
        """Refuse a figure without a case."""
        missing = {"fig15", "fig16"} - {case.figure for case in self.cases.values()}
        if missing:
            raise ValueError(f"cases: none is drawn in {', '.join(sorted(missing))}")


def run(params: Params, inputs: Tables) -> Tables:
    """Simulate and fit every case.

    ``fig15``, ``fig16``: e against speed in m/s, the simulation, its fit with q free, and the
    printed capture velocity. ``restitution_fits``: per case the fits with q free and fixed.
    """
    frames: dict[str, list[pd.DataFrame]] = {"fig15": [], "fig16": []}
    rows: list[Row] = []
    for name, case in params.cases.items():
        try:
            contact = calibrated_contact(inputs, name)
        except NotComputedError as why:
            rows.append({"case": name, "problem": str(why)})
            continue
        limit = float(capture_velocity(contact))
        printed = printed_capture_velocity(inputs, contact)
        known: Row = {"simulated_v_c_m_per_s": limit, "printed_v_c_m_per_s": printed}
        is_fitted = fitted_to(inputs, name, "capture_velocity")
        evidence = "calibrated" if is_fitted else "computed"
        largest = max(LARGEST_SPEED, case.fitted_to * limit)
        speed = _speeds(DRAWN_FROM * limit, limit, largest, CURVE_POINTS)
        e = simulate(contact, speed).coefficient_of_restitution
        figure_frames = frames[case.figure]
        figure_frames.append(_frame(f"{name}, simulation", speed, e, evidence))
        if not case.fitted:
            continue
        sampled = np.geomspace(params.fitted_from, case.fitted_to, FITTED_POINTS) * limit
        measured = simulate(contact, sampled).coefficient_of_restitution
        fits = [fit_restitution(sampled, measured, q=q) for q in (None, params.fixed_exponent)]
        rows += [_row(name, known, evidence, fit) for fit in fits]
        free = fits[0]
        speed = _speeds(DRAWN_FROM * limit, free.v_c, largest, CURVE_POINTS)
        figure_frames.append(_frame(f"{name}, fit", speed, free.curve(speed), evidence))
        mark = _frame(f"printed, {printed:g} m/s", printed, 0.0, "printed")
        if np.isfinite(printed) and not any(mark.equals(frame) for frame in figure_frames):
            figure_frames.append(mark)
    tables = {figure: pd.concat(parts, ignore_index=True) for figure, parts in frames.items()}
    return tables | {"restitution_fits": pd.DataFrame(rows)}


def _speeds(start: float, v_c: float, end: float, points: int) -> FloatArray:
    """Return speeds in m/s at which a curve is drawn, its capture velocity among them."""
    near = max(start, v_c) * np.array([1.0, *(1.0 + JUST_ABOVE)])
    return np.union1d(np.geomspace(start, end, points), near)


def _row(case: str, known: Row, evidence: str, fit: RestitutionFit) -> Row:
    low, high = fit.v_c_interval
    return {
        "case": case,
        "exponent": "fixed" if fit.q_fixed else "free",
        "k_m_per_s": fit.k,
        "p": fit.p,
        "kappa_m_per_s": fit.kappa,
        "q": fit.q,
        "v_c_m_per_s": fit.v_c,
        "v_c_low_m_per_s": low,
        "v_c_high_m_per_s": high,
        **known,
        "rms_residual": float(np.sqrt(np.mean(np.square(fit.residuals)))),
        "r_squared": fit.r_squared,
        "on_bound": " ".join(fit.on_bound),
        "evidence": evidence,
    }
