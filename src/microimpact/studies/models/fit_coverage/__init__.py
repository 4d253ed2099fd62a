"""How well Eq. (34) finds the capture velocity from data that never reach capture (Section 3.3)."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from operator import itemgetter

import numpy as np
import pandas as pd
import scipy

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.tables import POINTS
from microimpact.lab.contacts import calibrated_contact
from microimpact.model.empirical.intervals import interval_batch, profile_batch
from microimpact.model.empirical.search import (
    BatchFit,
    DataSets,
    data_sets,
    fit_batch,
    stacked_fits,
    stacked_sets,
)
from microimpact.statistics.intervals import share_error
from microimpact.studies.models.fit_coverage.design import Cell, Params, cells, method_cells
from microimpact.studies.models.fit_coverage.intervals import Sample, intervals
from microimpact.studies.models.fit_coverage.tables import figure_data
from microimpact.studies.models.fit_coverage.truths import (
    MEASUREMENTS,
    Truths,
    observed,
    standard_deviations,
    standard_noise,
)

NEEDS = {"calibration": ("calibration",), "restitution_fits": ("restitution_fits",)}

__all__ = ["Params", "gather", "part", "run"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """Speeds (n,) in v_c, measured e (r, n), which are there, and the deviations (n,) assumed."""

    ratio: FloatArray
    e: FloatArray
    present: BoolArray
    deviation: FloatArray


Numbered = tuple[int, dict[str, object]]


def run(params: Params, inputs: Mapping[str, pd.DataFrame]) -> Mapping[str, pd.DataFrame]:
    """Measure bias, error and coverage of v_c in every cell of the design.

    Parameters
    ----------
    params
        Parameters of the study.
    inputs
        ``calibration``, ``restitution_fits``: tables of those studies; ``materials``: declared
        rows. The true Eq. (34) is the fit of the case with q fixed.

    Returns
    -------
    mapping
        ``fit_coverage``: errors of v_c and coverage of its profile interval, per cell.
        ``fit_intervals``: coverage by method of interval.
        ``capture_recovery``: data of the figure.

    Raises
    ------
    ValueError
        If noise hides so many rebounds that too few are left to fit.
    """
    return gather(params, inputs, [part(params, inputs, 0, 1)])


def part(
    params: Params, inputs: Mapping[str, pd.DataFrame], index: int, count: int
) -> tuple[list[Numbered], list[Numbered]]:
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
    return coverage, methods


def gather(
    params: Params,
    inputs: Mapping[str, pd.DataFrame],
    parts: Sequence[tuple[list[Numbered], list[Numbered]]],
) -> Mapping[str, pd.DataFrame]:
    """Return the tables, from the rows of all parts."""
    table, methods = (
        pd.DataFrame([row for _, row in sorted(chain(*rows), key=itemgetter(0))])
        for rows in zip(*parts, strict=True)
    )
    reference = (params.variants[0].variant, params.reference_noise_of_e, params.reference_points)
    return {
        "fit_coverage": table,
        "fit_intervals": methods,
        "capture_recovery": figure_data(table, reference, params.confidence),
    }


def _truths(params: Params, inputs: Mapping[str, pd.DataFrame]) -> Truths:
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
        rise = profile_batch(sets, fit, 1.0) - fit.chi_square
        own = [slice(k * each, (k + 1) * each) for k in range(len(group))]
        some = [slice(of.start, of.start + params.interval_replicates) for of in own]
        ends = interval_batch(
            stacked_sets([sets.take(of) for of in some]),
            stacked_fits([fit.take(of) for of in some]),
            limit,
        ).ends
        widths = np.diff(ends).reshape(len(group), -1)
        for (number, cell), of, width in zip(group, own, widths, strict=True):
            row = _row(params, cell, sets.take(of), fit.take(of), rise[of])
            rows.append((number, row | {"median_width": float(np.median(width))}))
    return rows


def _measured(params: Params, truths: Truths, cell: Cell, replicates: int) -> Measured:
    ratio = np.geomspace(cell.lowest, params.highest_speed_in_v_c, cell.points)
    curve = truths.mean_restitution(cell.truth, ratio, cell.variant)
    deviation = standard_deviations(cell.noise, ratio, curve, cell.variant)
    noise = standard_noise(params.seed, MEASUREMENTS, cell.points, replicates)
    e, present = observed(curve, deviation * noise, cell.variant.selection)
    assumed = deviation if cell.variant.weights == "true" else np.full(ratio.shape, cell.noise)
    return Measured(ratio=ratio, e=e, present=present, deviation=assumed)


def _sets(params: Params, truths: Truths, cell: Cell, replicates: int) -> DataSets:
    data = _measured(params, truths, cell, replicates)
    try:
        return data_sets(data.ratio, data.e, data.present / data.deviation, cell.q)
    except ValueError as error:
        raise ValueError(f"noise_of_e: {cell.noise:g} hides too many rebounds: {error}") from None


def _row(
    params: Params, cell: Cell, sets: DataSets, fit: BatchFit, rise: FloatArray
) -> dict[str, object]:
    """Row of a cell but for the width; the rise is that of chi-square at the true v_c."""
    error = fit.v_c - 1.0
    limit = float(scipy.special.chdtri(1.0, 1.0 - params.confidence))
    covered = np.mean(rise <= limit)
    freedom = np.sum(sets.weight > 0.0, axis=1) - sets.free
    variance = fit.chi_square / freedom
    estimated = np.mean(rise <= variance * scipy.special.fdtri(1.0, freedom, params.confidence))
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
        "reduced_chi_square": float(np.mean(variance)),
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
