"""How well Eq. (34), and an average of models, find the capture velocity (Section 3.3).

Data sets have the restitution of a true curve with noise, over speeds from a lowest one upwards;
spheres that seem captured are not among them. Every design has random numbers of its own, by what
it is, so that designs are independent and none changes with the others.

Designs of the average, and what they gave, are the rows of ``config/fit_coverage.csv``; how often
contacts drawn by several laws hold the capture velocity of other sizes those of
``config/capture_predictions.csv``. A run computes what it names again;
``config/examples/fit-coverage.yaml`` all of it.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain, product
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
import pandas as pd
import scipy
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.core.bounds import AboveOne, Count, Name, Positive
from microimpact.core.materials import declared_file
from microimpact.core.nearest import nearest
from microimpact.model.contact import Contact
from microimpact.model.contact_laws import JKR, ThorntonNing
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.empirical.comparison import Comparison, compare_sets
from microimpact.model.empirical.data import DataSets, data_sets, stacked_sets
from microimpact.model.empirical.equations import restitution
from microimpact.model.empirical.intervals import interval_batch
from microimpact.model.empirical.search import BatchFit, fit_batch
from microimpact.model.posterior import NoConvergenceError, calibrate_laws
from microimpact.statistics.distributions import generator
from microimpact.statistics.intervals import wilson_interval
from study.contacts import calibrated_contact
from study.declared.parameters import CaseName
from study.tables import POINTS, Row, Tables, read_table, series_frame

NEEDS = {
    "calibration": ("calibration",),
    "fig15_16_restitution_fits": ("restitution_fits",),
}

ANALYSIS = 34
EQ_34, SIMULATION, VISCOUS, PLASTIC = "Eq. 34", "simulation", "viscous JKR", "Thornton-Ning"
# The ring force with a rate exponent between those of the cases, v_N the capture velocity.
BETWEEN, RATE = "ring force, n = 0.7", 0.7
# e = 0.85 sqrt(1 - (v_c/v)^2) (v_c/v)^(1/4), which no model has.
FOREIGN = "foreign curve"
LARGEST_E, FALL = 0.85, 0.25
# v_c ~ 1/d^n of the curves without a contact: Dahneke (1971), and the work of a JKR contact.
EXPONENTS = {EQ_34: 1.0, FOREIGN: 5.0 / 6.0}
ENDS = ("coverage_low", "coverage_high")
# Sizes, over that measured, at which contacts are to predict the capture velocity, and how surely.
SIZES, LEVEL = (1.0 / 3.0, 0.5, 1.0, 2.0), 0.9
# Between marks of the same scatter, %, and of the same size, as a factor.
APART, SIZES_APART = 0.3, 1.08
# True laws by w_A in J/m2, near the least squares to the printed restitutions and v_c of steel.
LAWS = {
    VISCOUS: (JKR(viscous_time=10.47622e-9), 4.77547),
    PLASTIC: (ThorntonNing(yield_pressure=1.643005e9), 8.88597),
}
QUANTITIES = {"bias": "bias", "rms_error": "rms", "coverage": "coverage"}

Speeds = Annotated[tuple[AboveOne, ...], Field(min_length=1)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Averaged:
    """Designs in which every data set is fitted by all models."""

    cases: Annotated[tuple[CaseName, ...], Field(min_length=1)]  # Contacts with a ring force
    # Of the file, to be computed
    designs: Annotated[tuple[Name, ...], Field(min_length=1)] | Literal["all"]
    # Data sets of each law whose contacts predict other sizes; 0: as in the file
    predicted: Annotated[int, Field(ge=0)]


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
        largest = max(*self.lowest_speeds_in_v_c, *TRIED["lowest_speed_in_v_c"].astype(float))
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


class Spheres(NamedTuple):
    """Relative standard deviations of diameters and speeds, and whether captured ones are kept."""

    size_scatter: float = 0.0
    speed_error: float = 0.0
    captured: str = "dropped"  # or "kept"


class Analysis(NamedTuple):
    """Knowledge that a fit has of the errors."""

    sigma: str  # "given", or "estimated"
    scatter: str  # "exact": nothing of sizes and speeds; "given"; "free": the sizes are to be found
    models: str  # "all", or the name of one


class Trial(NamedTuple):
    """Data sets of one kind and their analysis."""

    design: Design
    spheres: Spheres
    analysis: Analysis


ALIKE = Spheres()
TRIED = read_table(declared_file("fit_coverage.csv"))
PREDICTED = read_table(declared_file("capture_predictions.csv"))


def fit_designs(params: Params) -> list[Design]:
    """Designs in which Eq. (34) alone is fitted."""
    levels = (EQ_34, SIMULATION), params.noise_of_e, params.lowest_speeds_in_v_c
    return [Design(*level) for level in product(*levels)]


def averaged_designs(params: Params) -> dict[str, Trial]:
    """Designs in which all models are fitted, by name."""
    known = list(TRIED["design"])
    names = known if params.averaged.designs == "all" else params.averaged.designs
    for name in names:
        if name not in known:
            raise ValueError(f"averaged.designs: {name!r} is no design{nearest(name, known)}")
    rows: Any = TRIED.set_index("design").loc[list(names)]
    return {
        name: Trial(*(kind(*row[list(kind._fields)]) for kind in (Design, Spheres, Analysis)))  # type: ignore[arg-type]
        for name, row in rows.iterrows()
    }


def run(params: Params, inputs: Tables) -> Tables:
    """Measure bias, error and coverage of v_c in every design.

    ``fit_coverage``: errors of v_c by Eq. (34) and coverage of its profile interval, with q free
    and fixed. ``averaged_intervals``: coverage, width and warnings of the average of all models in
    the designs that the run names; of the others those of the file are drawn.
    ``capture_predictions``: coverage of v_c at other sizes by contacts drawn by several laws.
    ``capture_recovery``, ``averaged_coverage``: data of the figures. Raises ValueError if noise
    hides so many rebounds that too few are left to fit.
    """
    exponents = None, params.fixed_exponent
    pairs = zip(*(_fit_rows(params, inputs, q) for q in exponents), strict=True)
    fits = pd.DataFrame(list(chain.from_iterable(pairs)))
    averages = pd.DataFrame(list(_averaged_rows(params, inputs)))
    predictions = PREDICTED
    if params.averaged.predicted:
        predictions = pd.DataFrame(list(_predicted_rows(params, inputs)))
    drawn = averaged_figure(_with_tried(averages), params.confidence)
    return {
        "fit_coverage": fits,
        "averaged_intervals": averages,
        "capture_predictions": predictions,
        "averaged_coverage": pd.concat([drawn, predicted_figure(predictions)], ignore_index=True),
        "capture_recovery": fit_figure(fits, params.confidence),
    }


def true_contact(params: Params, inputs: Tables, truth: str) -> Contact:
    """Contact whose simulated restitution is a true curve."""
    if truth == BETWEEN:
        contact = calibrated_contact(inputs, params.case)
        limit = float(capture_velocity(contact))
        return contact.replace(adhesion_rate_exponent=RATE, reference_velocity=limit)
    if truth in LAWS:
        return calibrated_contact(inputs, params.averaged.cases[0]).by_law(*LAWS[truth])
    return calibrated_contact(inputs, params.case if truth == SIMULATION else truth)


def true_curve(
    params: Params, inputs: Tables, truth: str, ratio: FloatArray, size: FloatArray | float = 1.0
) -> FloatArray:
    """True restitution at speeds ratio (..., n) in units of the true capture velocity.

    Parameters
    ----------
    truth
        Name of the curve.
    ratio
        Speeds over the capture velocity of the median sphere.
    size
        Diameters over that of the median sphere, of the same shape or one number.
    """
    if truth not in EXPONENTS:
        contact = true_contact(params, inputs, truth)
        sized = contact.replace(diameter=size * contact.diameter)
        return simulate(sized, ratio * capture_velocity(contact)).coefficient_of_restitution
    limit = size ** -EXPONENTS[truth]
    if truth == FOREIGN:
        share = np.minimum(limit / ratio, 1.0)
        return np.asarray(LARGEST_E * np.sqrt(1.0 - share**2) * share**FALL)
    fits = inputs["restitution_fits"]
    fits = fits[~fits["evidence"].isin(POINTS)]
    fit = fits[(fits["case"] == params.case) & (fits["exponent"] == "fixed")]
    if fit.empty:
        raise ValueError(f"case: {params.case!r} must be one with a fit in restitution_fits")
    names = ("k_m_per_s", "p", "kappa_m_per_s", "q", "v_c_m_per_s")
    k, p, kappa, q, v_c = (float(fit[name].iloc[0]) for name in names)
    # All speeds of a smaller sphere are higher by as much as its v_c.
    return restitution(ratio / limit * v_c, k, p, kappa, q, v_c)


def measured(
    params: Params, inputs: Tables, design: Design, spheres: Spheres = ALIKE
) -> tuple[FloatArray, FloatArray]:
    """Speeds in true v_c and measured restitutions, 0 where none is seen, both (sets, n)."""
    ratio = np.geomspace(design.lowest_speed_in_v_c, params.highest_speed_in_v_c, params.points)
    kind = (design,) if spheres == ALIKE else (design, spheres)
    rng = generator(params.seed, ANALYSIS, *(zlib.crc32(repr(part).encode()) for part in kind))
    noise, sizes, errors = rng.standard_normal((3, params.sets, params.points))
    size = np.exp(spheres.size_scatter * sizes) if spheres.size_scatter else 1.0
    curve = true_curve(params, inputs, design.truth, ratio, size)
    e = np.clip(curve + design.noise_of_e * noise, 0.0, 1.0)
    return ratio * np.exp(spheres.speed_error * errors), np.where(curve > 0.0, e, 0.0)


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
    """Rows of the average of all models, all data sets of a design compared together."""
    for name, trial in averaged_designs(params).items():
        rebounds = measured(params, inputs, trial.design, trial.spheres)
        data = [_arguments(trial, v, e) for v, e in zip(*rebounds, strict=True)]
        models = None if trial.analysis.models == "all" else [trial.analysis.models]
        comparisons = compare_sets(data, confidence=params.confidence, models=models)
        factors = {key: value for part in trial for key, value in part._asdict().items()}
        yield {"design": name} | factors | _averaged(comparisons)


def _arguments(trial: Trial, v: FloatArray, e: FloatArray) -> tuple[Any, ...]:
    """Arguments of `compare_models` for one data set (n,)."""
    design, spheres, analysis = trial
    kept = (e > 0.0) | (spheres.captured == "kept")
    sigma = design.noise_of_e if analysis.sigma == "given" else None
    if analysis.scatter == "exact":
        return v[kept], e[kept], sigma
    size = "free" if analysis.scatter == "free" else spheres.size_scatter
    return v[kept], e[kept], sigma, spheres.speed_error * v[kept], None, size


def _predicted_rows(params: Params, inputs: Tables) -> Iterator[Row]:
    """Rows of capture velocities at other sizes, from contacts that rebounds of one size admit."""
    few = replace(params, sets=params.averaged.predicted)
    for truth in (BETWEEN, VISCOUS):
        contact = true_contact(params, inputs, truth)
        v_c = float(capture_velocity(contact))
        design = Design(truth, params.noise_of_e[0], params.lowest_speeds_in_v_c[0])
        intervals = []
        for ratio, e in zip(*measured(few, inputs, design), strict=True):
            kept = e > 0.0
            try:
                drawn = calibrate_laws(contact, ratio[kept] * v_c, e[kept], design.noise_of_e)
            except NoConvergenceError:
                continue
            limits = drawn.of_all(_at_other_sizes)
            intervals.append(np.quantile(limits, [0.5 - 0.5 * LEVEL, 0.5 + 0.5 * LEVEL], axis=1))
        shares = np.transpose(intervals) / _at_other_sizes(contact)[:, None, None]
        for size, ends in zip(SIZES, np.swapaxes(shares, 1, 2), strict=True):
            yield {
                **design._asdict(),
                "size": size,
                **_coverage(ends),
                "without_convergence": few.sets - len(ends),
                "evidence": "virtual experiment",
            }


def _at_other_sizes(contact: Contact) -> FloatArray:
    """Capture velocities of `SIZES`, over that measured, (sizes, ...)."""
    sizes = np.reshape(SIZES, (-1,) + (1,) * len(contact.shape))
    return capture_velocity(contact.replace(diameter=sizes * contact.diameter))


def _with_tried(averages: pd.DataFrame) -> pd.DataFrame:
    """Rows of all designs: those of this run, and of the file where it has none."""
    others = TRIED[~TRIED["design"].isin(averages["design"]) & TRIED["sets"].notna()]
    return pd.concat([averages, others], ignore_index=True)


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
    """Coverage over the scatter of v_c, by true curve: taken as exact, and allowed for.

    Designs of the same scatter are moved apart.
    """
    squares = table[["size_scatter", "speed_error"]].astype(float) ** 2
    scatter = 100.0 * squares.sum(axis=1) ** 0.5
    frames = []
    for panel, chosen in {
        "taken as exact": table["scatter"] == "exact",
        "allowed for": table["scatter"] != "exact",
    }.items():
        at = scatter[chosen].round(6)
        number, many = at.groupby(at).cumcount(), at.groupby(at).transform("size")
        x = at + APART * (number - 0.5 * (many - 1.0))
        for truth, rows in table[chosen].groupby("truth", sort=False):
            coverage = [rows[name].astype(float) for name in ("coverage", *ENDS)]
            frames.append(
                _frame(
                    panel,
                    str(truth),
                    x[rows.index],
                    coverage[0],
                    "virtual experiment",
                    *coverage[1:],
                )
            )
        ends = np.array([x.min(), x.max()])
        frames.append(_frame(panel, "nominal", ends, confidence))
    return pd.concat(frames, ignore_index=True)


def predicted_figure(table: pd.DataFrame) -> pd.DataFrame:
    """Coverage of predicted capture velocities over the size, by true law; marks moved apart."""
    panel = "at other sizes"
    frames = []
    for number, (truth, rows) in enumerate(table.groupby("truth", sort=False)):
        coverage = [rows[name].astype(float) for name in ("coverage", *ENDS)]
        size = rows["size"].astype(float) * SIZES_APART ** (number - 0.5)
        frames.append(
            _frame(panel, str(truth), size, coverage[0], "virtual experiment", *coverage[1:])
        )
    ends = table["size"].astype(float).agg(["min", "max"])
    return pd.concat([*frames, _frame(panel, "nominal", ends, LEVEL)], ignore_index=True)
