"""How well Eq. (34), and an average of models, find the capture velocity (Section 3.3).

Data sets have the restitution of a true curve with noise, over speeds from a lowest one upwards;
spheres that seem captured are not among them. Every design has random numbers of its own, by what
it is, so that designs are independent and none changes with the others.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from itertools import chain, islice, product
from typing import Annotated, NamedTuple

import numpy as np
import pandas as pd
import scipy
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.core.bounds import AboveOne, Count, Positive
from microimpact.model.contact import Contact
from microimpact.model.contact_laws import JKR
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.empirical.comparison import Comparison, compare_sets
from microimpact.model.empirical.data import DataSets, data_sets, stacked_sets
from microimpact.model.empirical.equations import restitution
from microimpact.model.empirical.intervals import interval_batch
from microimpact.model.empirical.search import BatchFit, fit_batch
from microimpact.statistics.distributions import generator
from microimpact.statistics.intervals import wilson_interval
from study.declared.parameters import CaseName
from study.studies.contacts import Posterior, calibrated_contact
from study.tables import POINTS, Row, Tables, series_frame

NEEDS = {
    "calibration": ("calibration",),
    "restitution_fits": ("restitution_fits",),
    "inference": ("evidence_summary",),
}

ANALYSIS = 34
EQ_34, SIMULATION, VISCOUS = "Eq. 34", "simulation", "viscous JKR"
QUANTITIES = {"bias": "bias", "rms_error": "rms", "coverage": "coverage"}

Speeds = Annotated[tuple[AboveOne, ...], Field(min_length=1)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Averaged:
    """Designs in which every data set is fitted by all models."""

    cases: Annotated[tuple[CaseName, ...], Field(min_length=1)]  # Contacts with a ring force
    # The JKR contact with a viscous bulk: medians of this posterior.
    viscous: Posterior
    lowest_speeds_in_v_c: Speeds
    noise_of_e: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Designs of the fit of Eq. (34) and of the average of models; speeds in true v_c."""

    seed: Annotated[int, Field(ge=0)]
    case: CaseName  # Its fit with q fixed is the true Eq. (34), its contact is the simulation
    fixed_exponent: Positive
    lowest_speeds_in_v_c: Speeds
    highest_speed_in_v_c: AboveOne
    noise_of_e: Annotated[tuple[Positive, ...], Field(min_length=1)]
    points: Annotated[int, Field(ge=8)]
    sets: Count  # Data sets of each design
    starts: Annotated[int, Field(ge=1, le=5)]
    confidence: Annotated[float, Field(ge=0.5, lt=1)]
    averaged: Averaged

    def __post_init__(self) -> None:
        """Refuse a lowest speed that is not below the highest."""
        largest = max(*self.lowest_speeds_in_v_c, *self.averaged.lowest_speeds_in_v_c)
        if largest >= self.highest_speed_in_v_c:
            raise ValueError(
                f"highest_speed_in_v_c: {self.highest_speed_in_v_c:g} must be above every lowest "
                f"speed, of which the largest is {largest:g}"
            )


class Design(NamedTuple):
    """A true curve, the standard deviation of e, and the lowest speed in v_c."""

    truth: str
    noise_of_e: float
    lowest_speed_in_v_c: float


def fit_designs(params: Params) -> list[Design]:
    """Designs in which Eq. (34) alone is fitted."""
    levels = (EQ_34, SIMULATION), params.noise_of_e, params.lowest_speeds_in_v_c
    return [Design(*level) for level in product(*levels)]


def averaged_designs(params: Params) -> list[Design]:
    """Designs in which all models are fitted."""
    settings = params.averaged
    truths, noise = (EQ_34, *settings.cases, VISCOUS), settings.noise_of_e
    return [Design(*level) for level in product(truths, (noise,), settings.lowest_speeds_in_v_c)]


def run(params: Params, inputs: Tables) -> Tables:
    """Measure bias, error and coverage of v_c in every design.

    ``fit_coverage``: errors of v_c by Eq. (34) and coverage of its profile interval, with q free
    and fixed. ``averaged_intervals``: coverage, width and warnings of the average of all models.
    ``capture_recovery``, ``averaged_coverage``: data of the figures. Raises ValueError if noise
    hides so many rebounds that too few are left to fit.
    """
    exponents = None, params.fixed_exponent
    pairs = zip(*(_fit_rows(params, inputs, q) for q in exponents), strict=True)
    fits = pd.DataFrame(list(chain.from_iterable(pairs)))
    averages = pd.DataFrame(list(_averaged_rows(params, inputs)))
    return {
        "fit_coverage": fits,
        "averaged_intervals": averages,
        "averaged_coverage": averaged_figure(averages, params.confidence),
        "capture_recovery": fit_figure(fits, params.confidence),
    }


def true_contact(params: Params, inputs: Tables, truth: str) -> Contact:
    """Contact whose simulated restitution is a true curve."""
    if truth != VISCOUS:
        return calibrated_contact(inputs, params.case if truth == SIMULATION else truth)
    table, viscous = inputs["evidence_summary"], params.averaged.viscous
    for column in ("case", "scenario", "law"):
        table = table[table[column] == getattr(viscous, column)]
    fit = table.set_index("quantity")["median"]
    law = JKR(viscous_time=1e-9 * float(fit["viscous_time_ns"]))
    work = float(fit["work_of_adhesion_J_per_m2"])
    return calibrated_contact(inputs, params.averaged.cases[0]).by_law(law, work)


def true_curve(params: Params, inputs: Tables, truth: str, ratio: FloatArray) -> FloatArray:
    """True restitution at speeds ratio (n,) in units of the true capture velocity."""
    if truth != EQ_34:
        contact = true_contact(params, inputs, truth)
        return simulate(contact, ratio * capture_velocity(contact)).coefficient_of_restitution
    fits = inputs["restitution_fits"]
    fits = fits[~fits["evidence"].isin(POINTS)]
    fit = fits[(fits["case"] == params.case) & (fits["exponent"] == "fixed")]
    if fit.empty:
        raise ValueError(f"case: {params.case!r} must be one with a fit in restitution_fits")
    names = ("k_m_per_s", "p", "kappa_m_per_s", "q", "v_c_m_per_s")
    constants = [float(fit[name].iloc[0]) for name in names]
    return restitution(ratio * constants[-1], *constants)


def measured(params: Params, inputs: Tables, design: Design) -> tuple[FloatArray, FloatArray]:
    """Speeds (n,) in true v_c and measured restitutions (sets, n), 0 where none is seen."""
    ratio = np.geomspace(design.lowest_speed_in_v_c, params.highest_speed_in_v_c, params.points)
    curve = true_curve(params, inputs, design.truth, ratio)
    rng = generator(params.seed, ANALYSIS, zlib.crc32(repr(design).encode()))
    noise = design.noise_of_e * rng.standard_normal((params.sets, params.points))
    return ratio, np.clip(curve + noise, 0.0, 1.0)


def _fit_rows(params: Params, inputs: Tables, q: float | None) -> Iterator[Row]:
    """Rows of Eq. (34) with q free (None) or fixed, all designs fitted together."""
    designs = fit_designs(params)
    data = [_weighted(design, *measured(params, inputs, design), q) for design in designs]
    sets = stacked_sets(data)
    fit = fit_batch(sets, params.starts)
    limit = float(scipy.special.chdtri(1.0, 1.0 - params.confidence))
    ends = interval_batch(sets, fit, limit).ends
    for i, design in enumerate(designs):
        rows = slice(i * params.sets, (i + 1) * params.sets)
        factors = design._asdict() | {"exponent": "free" if q is None else "fixed"}
        yield factors | _errors(sets.select(rows), fit.select(rows), ends[rows])


def _weighted(design: Design, ratio: FloatArray, e: FloatArray, q: float | None) -> DataSets:
    noise = design.noise_of_e
    try:
        return data_sets(ratio, e, (e > 0.0) / noise, q)
    except ValueError as error:
        raise ValueError(f"noise_of_e: {noise:g} hides too many rebounds: {error}") from None


def _errors(sets: DataSets, fit: BatchFit, ends: FloatArray) -> Row:
    error = fit.v_c - 1.0
    freedom = np.sum(sets.weight > 0.0, axis=1) - sets.free
    return {
        **_coverage(ends),
        "bias": float(np.mean(error)),
        "median_error": float(np.median(error)),
        "rms_error": float(np.sqrt(np.mean(error**2))),
        "v_c_on_bound": float(np.mean(fit.capture_on_bound)),
        "converged": float(np.mean(fit.converged)),
        "reduced_chi_square": float(np.mean(fit.chi_square / freedom)),
        "evidence": "virtual experiment",
    }


def _coverage(ends: FloatArray) -> Row:
    """Share of intervals (sets, 2) that hold the true v_c, which is 1, and their median width."""
    held = int(np.sum((ends[:, 0] <= 1.0) & (ends[:, 1] >= 1.0)))
    low, high = wilson_interval(held, len(ends))
    return {
        "sets": len(ends),
        "held": held,
        "coverage": held / len(ends),
        "coverage_low": low,
        "coverage_high": high,
        "median_width": float(np.median(np.diff(ends))),
    }


def _averaged_rows(params: Params, inputs: Tables) -> Iterator[Row]:
    """Rows of the average of all models, all data sets compared together."""
    designs = averaged_designs(params)
    rebounds: list[tuple[FloatArray, FloatArray, float]] = []
    for design in designs:
        ratio, measurements = measured(params, inputs, design)
        rebounds += [(ratio[e > 0.0], e[e > 0.0], design.noise_of_e) for e in measurements]
    comparisons = iter(compare_sets(rebounds, confidence=params.confidence))
    for design in designs:
        yield design._asdict() | _averaged(list(islice(comparisons, params.sets)))


def _averaged(comparisons: list[Comparison]) -> Row:
    ends = np.array([comparison.v_c_interval for comparison in comparisons])
    warned = np.array([bool(comparison.warnings) for comparison in comparisons])
    missed = (ends[:, 0] > 1.0) | (ends[:, 1] < 1.0)
    return {
        **_coverage(ends),
        "warned": float(warned.mean()),
        "missed_without_warning": int(np.sum(missed & ~warned)),
        "evidence": "virtual experiment",
    }


_frame = partial(series_frame, x_unit="1", y_unit="1")


def _marks(panel: str, series: str, rows: pd.DataFrame, quantity: str) -> pd.DataFrame:
    """One quantity over the lowest speed; a coverage has the ends of its interval."""
    ends = [rows[f"coverage_{end}"] for end in ("low", "high")] if quantity == "coverage" else []
    x = rows["lowest_speed_in_v_c"]
    return _frame(panel, series, x, rows[quantity], "virtual experiment", *ends)


def fit_figure(table: pd.DataFrame, confidence: float) -> pd.DataFrame:
    """Bias, rms error and coverage of Eq. (34) over the lowest speed, by true curve."""
    frames = []
    for (column, quantity), truth in product(QUANTITIES.items(), (EQ_34, SIMULATION)):
        panel, rows = f"{quantity}, {truth}", table[table["truth"] == truth]
        for (noise, exponent), part_rows in rows.groupby(["noise_of_e", "exponent"]):
            frames.append(_marks(panel, f"noise {noise:g}, q {exponent}", part_rows, column))
        if column == "coverage":
            x = rows["lowest_speed_in_v_c"].agg(["min", "max"])
            frames.append(_frame(panel, "nominal", x, confidence))
    return pd.concat(frames, ignore_index=True)


def averaged_figure(table: pd.DataFrame, confidence: float) -> pd.DataFrame:
    """Coverage and median width of the average over the lowest speed, by true curve."""
    frames = [
        _marks(panel, str(truth), rows, column)
        for truth, rows in table.groupby("truth", sort=False)
        for panel, column in {"coverage": "coverage", "width": "median_width"}.items()
    ]
    x = table["lowest_speed_in_v_c"].agg(["min", "max"]).to_numpy(float)
    return pd.concat([*frames, _frame("coverage", "nominal", x, confidence)], ignore_index=True)
