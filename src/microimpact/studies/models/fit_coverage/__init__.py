"""How well Eq. (34), and an average of models, find the capture velocity (Section 3.3)."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain, product, starmap
from operator import itemgetter
from typing import Annotated, NamedTuple

import numpy as np
import pandas as pd
import scipy
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.core.tables import POINTS, Tables, series_frame
from microimpact.declared.parameters import AboveOne, CaseName, Count, Keyed, Must, Positive
from microimpact.model.empirical.data import DataSets, Places, data_sets, stacked_sets
from microimpact.model.empirical.intervals import interval_batch, profile_batch
from microimpact.model.empirical.search import BatchFit, fit_batch
from microimpact.statistics.intervals import share_error, wilson_interval
from microimpact.studies.contacts import calibrated_contact
from microimpact.studies.models.fit_coverage import averaged
from microimpact.studies.models.fit_coverage.averaged import Averaged
from microimpact.studies.models.fit_coverage.intervals import Methods, Sample, intervals
from microimpact.studies.models.fit_coverage.truths import (
    MEASUREMENTS,
    TRUTHS,
    TruthName,
    Truths,
    Variant,
    mean_restitution,
    observed,
    standard_deviations,
    standard_noise,
)

NEEDS = {
    "calibration": ("calibration",),
    "restitution_fits": ("restitution_fits",),
    "contact_laws": ("contact_law_fits",),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """The design: the first variant at all levels, the others at the reference levels.

    Speeds are in capture velocities of the nominal sphere, so none may be 1 or less.
    """

    seed: Annotated[int, Field(ge=0)]
    case: CaseName
    fixed_exponent: Positive
    lowest_speeds_in_v_c: Annotated[tuple[AboveOne, ...], Field(min_length=1)]
    highest_speed_in_v_c: AboveOne
    noise_of_e: tuple[Positive, ...]
    points: tuple[Annotated[int, Field(ge=8)], ...]
    reference_noise_of_e: Annotated[Positive, Must("one of", "noise_of_e")]
    reference_points: Annotated[int, Must("one of", "points")]
    variants: Annotated[tuple[Variant, ...], Field(min_length=1), Keyed("variant")]
    sizes: Annotated[int, Field(ge=3)]
    replicates: Count
    interval_replicates: Annotated[Count, Must("at most", "replicates")]
    starts: Annotated[int, Field(ge=1, le=5)]
    confidence: Annotated[float, Field(ge=0.5, lt=1)]
    methods: Methods
    averaged: Averaged

    def __post_init__(self) -> None:
        """Refuse speeds out of order, and more replicates for a part than for the whole."""
        parts = (self, self.methods, self.averaged)
        lowest = max(1.0, *(v for part in parts for v in part.lowest_speeds_in_v_c))
        if lowest >= self.highest_speed_in_v_c:
            raise ValueError(
                f"highest_speed_in_v_c: {self.highest_speed_in_v_c:g} must be above every lowest "
                f"speed, of which the largest is {lowest:g}"
            )
        if self.methods.replicates > self.replicates:
            told = f"{self.methods.replicates} must be at most replicates, {self.replicates}"
            raise ValueError(f"methods.replicates: {told}")


class Cell(NamedTuple):
    """One combination of the factors; the exponent q is None where it is free."""

    truth: TruthName
    variant: Variant
    noise: float
    points: int
    lowest: float
    q: float | None

    @property
    def factors(self) -> dict[str, object]:
        """Its columns in a table."""
        return {
            "truth": self.truth,
            "variant": self.variant.variant,
            "noise_of_e": self.noise,
            "points": self.points,
            "lowest_speed_in_v_c": self.lowest,
            "exponent": "free" if self.q is None else "fixed",
        }


def cells(params: Params) -> Iterator[Cell]:
    """All cells, in pairs with q free and fixed."""
    first, *others = params.variants
    inner = params.lowest_speeds_in_v_c, (None, params.fixed_exponent)
    yield from starmap(Cell, product(TRUTHS, (first,), params.noise_of_e, params.points, *inner))
    for variant in others:
        yield from starmap(Cell, product(TRUTHS, (variant,), *_reference(params), *inner))


def _reference(params: Params) -> tuple[tuple[float], tuple[int]]:
    return (params.reference_noise_of_e,), (params.reference_points,)


def method_cells(params: Params) -> Iterator[Cell]:
    """Cells in which methods of intervals are compared."""
    inner = params.methods.lowest_speeds_in_v_c, (None, params.fixed_exponent)
    yield from starmap(Cell, product(TRUTHS, params.variants[:1], *_reference(params), *inner))


QUANTITIES = {"bias": "bias", "rms_error": "rms", "coverage": "coverage"}


def figure_data(table: pd.DataFrame, params: Params) -> pd.DataFrame:
    """Bias, rms error and coverage over the lowest speed, by truth, for the first variant."""
    variant, points = params.variants[0].variant, params.reference_points
    rows = table[(table["variant"] == variant) & (table["points"] == points)]
    frame = partial(series_frame, x_unit="1", y_unit="1")
    frames = []
    for quantity, short in QUANTITIES.items():
        for truth in TRUTHS:
            panel = f"{short}, {truth}"
            own = rows[rows["truth"] == truth]
            for (noise, exponent), part in own.groupby(["noise_of_e", "exponent"], sort=True):
                y, sets = part[quantity].to_numpy(float), part["replicates"]
                held = np.rint(part["coverage"] * sets).astype(int)
                ends = np.array([wilson_interval(*pair) for pair in zip(held, sets, strict=True)]).T
                series, x = f"noise {noise:g}, q {exponent}", part["lowest_speed_in_v_c"]
                bounds = ends if quantity == "coverage" else ()
                frames.append(frame(panel, series, x, y, "virtual experiment", *bounds))
            if quantity == "coverage":
                x = own["lowest_speed_in_v_c"].agg(["min", "max"])
                frames.append(frame(panel, "nominal", x, params.confidence))
    return pd.concat(frames, ignore_index=True)


Numbered = tuple[int, dict[str, object]]
Part = tuple[list[Numbered], list[Numbered], list[Numbered]]


def run(params: Params, inputs: Tables) -> Tables:
    """Measure bias, error and coverage of v_c in every cell of the design.

    The true Eq. (34) is the fit of the case with q fixed.

    ``fit_coverage``: errors of v_c and coverage of its profile interval, per cell.
    ``fit_intervals``: coverage by method of interval. ``capture_recovery``: data of the figure.
    Raises ValueError if noise hides so many rebounds that too few are left to fit.
    """
    return gather(params, inputs, [part(params, inputs, 0, 1)])


def part(params: Params, inputs: Tables, index: int, count: int) -> Part:
    """Return rows of every ``count``-th pair of cells, from ``index`` on, with their numbers."""
    truths = _truths(params, inputs)

    def mine(all_cells: Iterator[Cell]) -> list[tuple[int, Cell]]:
        # Cells are in pairs, with q free and fixed; fits with q free take longer.
        return [pair for pair in enumerate(all_cells) if pair[0] // 2 % count == index]

    coverage = _coverage(params, truths, mine(cells(params)))
    methods = [
        (number, row)
        for number, cell in mine(method_cells(params))
        for row in _method_rows(params, truths, cell)
    ]
    shared = (truths.constants, params.highest_speed_in_v_c, params.seed, params.confidence)
    designs = list(enumerate(averaged.designs(params.averaged)))[index::count]
    average = averaged.rows(params.averaged, inputs, *shared, [design for _, design in designs])
    numbers = (number for number, _ in designs)
    return coverage, methods, list(zip(numbers, average, strict=True))


def gather(params: Params, inputs: Tables, parts: Sequence[Part]) -> Tables:
    """Return the tables, from the rows of all parts."""
    table, methods, average = (
        pd.DataFrame([row for _, row in sorted(chain(*rows), key=itemgetter(0))])
        for rows in zip(*parts, strict=True)
    )
    return {
        "fit_coverage": table,
        "fit_intervals": methods,
        "averaged_intervals": average,
        "averaged_coverage": averaged.figure_data(average, params.confidence),
        "capture_recovery": figure_data(table, params),
    }


def _truths(params: Params, inputs: Tables) -> Truths:
    fits = inputs["restitution_fits"]
    fits = fits[~fits["evidence"].isin(POINTS)]
    fit = fits[(fits["case"] == params.case) & (fits["exponent"] == "fixed")]
    if fit.empty:
        raise ValueError(f"case: {params.case!r} must be one with a fit in restitution_fits")
    names = ("k_m_per_s", "p", "kappa_m_per_s", "q", "v_c_m_per_s")
    k, p, kappa, q, v_c = (float(fit[name].iloc[0]) for name in names)
    contact = calibrated_contact(inputs, params.case)
    return Truths(contact=contact, constants=(k, p, kappa, q, v_c), sizes=params.sizes)


def _coverage(params: Params, truths: Truths, mine: list[tuple[int, Cell]]) -> list[Numbered]:
    """Rows of cells. Those alike in points and q are fitted together; intervals, of some fits."""
    groups: dict[tuple[int, float | None], list[tuple[int, Cell]]] = defaultdict(list)
    for number, cell in mine:
        groups[cell.points, cell.q].append((number, cell))
    limit, each = float(scipy.special.chdtri(1.0, 1.0 - params.confidence)), params.replicates
    rows = []
    for group in groups.values():
        sets = stacked_sets([_sets(params, truths, cell, each) for _, cell in group])
        fit = fit_batch(sets, params.starts)
        # A lower chi-square at the true v_c would change nothing where that is covered anyway.
        enough = fit.chi_square + np.minimum(limit, _rise_estimated(params, sets, fit))
        rise = profile_batch(sets, fit, 1.0, enough) - fit.chi_square
        own = [slice(k * each, (k + 1) * each) for k in range(len(group))]
        some = [slice(of.start, of.start + params.interval_replicates) for of in own]
        ends = interval_batch(
            stacked_sets([sets.select(of) for of in some]),
            BatchFit.joined([fit.select(of) for of in some]),
            limit,
        ).ends
        widths = np.diff(ends).reshape(len(group), -1)
        for (number, cell), of, width in zip(group, own, widths, strict=True):
            row = _row(params, cell, sets.select(of), fit.select(of), rise[of])
            rows.append((number, row | {"median_width": float(np.median(width))}))
    return rows


def _sets(params: Params, truths: Truths, cell: Cell, replicates: int) -> DataSets:
    """Measured data of a cell, as they are fitted."""
    ratio = np.geomspace(cell.lowest, params.highest_speed_in_v_c, cell.points)
    spheres = cell.variant.largest_size_ratio, cell.variant.selection
    curve = mean_restitution(truths, cell.truth, tuple(ratio), *spheres)
    deviation = standard_deviations(cell.noise, ratio, curve, cell.variant)
    noise = standard_noise(params.seed, MEASUREMENTS, cell.points, replicates)
    e, present = observed(curve, deviation * noise, cell.variant.selection)
    assumed = deviation if cell.variant.weights == "true" else np.full(ratio.shape, cell.noise)
    try:
        return data_sets(ratio, e, present / assumed, cell.q)
    except ValueError as error:
        raise ValueError(f"noise_of_e: {cell.noise:g} hides too many rebounds: {error}") from None


def _freedom(sets: DataSets) -> Places:
    return np.asarray(np.sum(sets.weight > 0.0, axis=1) - sets.free)


def _rise_estimated(params: Params, sets: DataSets, fit: BatchFit) -> FloatArray:
    """Admissible rise of chi-square (r,) where sigma is estimated."""
    freedom, place = np.unique(_freedom(sets), return_inverse=True)  # few, of many data sets
    quantile = scipy.special.fdtri(1.0, freedom, params.confidence)
    return np.asarray(fit.chi_square / freedom[place] * quantile[place])


def _row(
    params: Params, cell: Cell, sets: DataSets, fit: BatchFit, rise: FloatArray
) -> dict[str, object]:
    """Row of a cell but for the width; the rise is that of chi-square at the true v_c."""
    error = fit.v_c - 1.0
    limit = float(scipy.special.chdtri(1.0, 1.0 - params.confidence))
    covered = np.mean(rise <= limit)
    estimated = np.mean(rise <= _rise_estimated(params, sets, fit))
    at_zero = fit.capture_on_bound & (fit.v_c < 0.5)
    return {
        **cell.factors,
        "replicates": params.replicates,
        "bias": float(np.mean(error)),
        "median_error": float(np.median(error)),
        "rms_error": float(np.sqrt(np.mean(error**2))),
        "coverage": float(covered),
        "coverage_standard_error": share_error(float(covered), params.replicates),
        "coverage_sigma_estimated": float(estimated),
        "median_width": np.nan,
        "width_replicates": params.interval_replicates,
        "v_c_on_bound": float(np.mean(fit.capture_on_bound)),
        "v_c_at_zero": float(np.mean(at_zero)),
        "any_on_bound": float(np.mean(fit.on_bound)),
        "converged": float(np.mean(fit.converged)),
        "reduced_chi_square": float(np.mean(fit.chi_square / _freedom(sets))),
        "evidence": "virtual experiment",
    }


def _method_rows(params: Params, truths: Truths, cell: Cell) -> Iterator[dict[str, object]]:
    sets = _sets(params, truths, cell, params.methods.replicates)
    fit = fit_batch(sets, params.starts)
    ratio = sets.v[0] * sets.unit[0]
    sample = Sample(ratio=ratio, noise=cell.noise, sets=sets, fit=fit)
    found = intervals(sample, params.methods, params.seed, params.confidence)
    for method, ends in found.items():
        covered = float(np.mean((ends[:, 0] <= 1.0) & (ends[:, 1] >= 1.0)))
        yield {
            **cell.factors,
            "method": method,
            "replicates": params.methods.replicates,
            "resamples": params.methods.resamples if "bootstrap" in method else 0,
            "coverage": covered,
            "coverage_standard_error": share_error(covered, params.methods.replicates),
            "median_width": float(np.median(np.diff(ends))),
            "evidence": "virtual experiment",
        }
