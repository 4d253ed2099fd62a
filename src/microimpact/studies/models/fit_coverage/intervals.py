"""Intervals of v_c by several methods, for the study of Eq. (34)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy
from numpy.typing import NDArray
from pydantic import Field

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.declared.parameters import AboveOne, Count
from microimpact.model.empirical.data import DataSets, data_sets
from microimpact.model.empirical.equations import restitution
from microimpact.model.empirical.intervals import interval_batch, profile_batch
from microimpact.model.empirical.search import BatchFit, fit_batch
from microimpact.studies.models.fit_coverage.truths import (
    CURVE_RESAMPLES,
    DATA_RESAMPLES,
    observed,
    stream,
)

# Most resamples drawn for each one wanted; those with too few different speeds do not serve.
TRIES = 4
# A rise of chi-square that the quantile of nearly every sample of rises exceeds.
SMALL_RISE = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Methods:
    """Comparison of interval methods on a few cells of the first variant, at reference values."""

    lowest_speeds_in_v_c: tuple[AboveOne, ...]
    replicates: Count
    resamples: Annotated[int, Field(ge=20)]
    share_of_points: Annotated[float, Field(gt=0, le=1)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """Data sets of one cell, equal known noise, and their fits."""

    ratio: FloatArray
    noise: float
    sets: DataSets
    fit: BatchFit


def intervals(
    sample: Sample, methods: Methods, seed: int, confidence: float
) -> dict[str, FloatArray]:
    """Ends (r, 2) of the intervals of v_c by method, in units of the true v_c."""
    sets, fit = sample.sets, sample.fit
    # On a boundary: the mixture of chi-square with 0 and with 1 degree of freedom, in equal parts.
    simple, mixture = (
        float(scipy.special.chdtri(1.0, share * (1.0 - confidence))) for share in (1.0, 2.0)
    )
    tails = np.array([0.5 * (1.0 - confidence), 0.5 * (1.0 + confidence)])
    shape = (len(fit.v_c), methods.resamples)

    again = _from_curves(sample, methods, seed)
    refit, true = fit_batch(again, starts=1), np.repeat(fit.v_c, methods.resamples)
    rises = np.zeros(len(fit.v_c))
    for small in (SMALL_RISE, 0.0):
        # Where the quantile lies above them, it does not matter how small the small rises are.
        if np.any(rises <= SMALL_RISE):
            rise = profile_batch(again, refit, true, refit.chi_square + small) - refit.chi_square
            # Above all rebounds of a resample no v_c is admissible, and the rise is infinite.
            rise = np.clip(rise, np.finfo(float).tiny, np.finfo(float).max).reshape(shape)
            rises = np.quantile(rise, confidence, axis=1, method="higher")

    fewer = fit_batch(_from_data(sample, methods, seed), starts=1).v_c.reshape(shape)
    spread = np.sqrt(methods.share_of_points) * (fewer - fit.v_c[:, None])
    scaled = fit.v_c[:, None] - np.quantile(spread, tails[::-1], axis=1).T
    return {
        "profile, chi-square": interval_batch(sets, fit, simple).ends,
        "profile, boundary mixture": interval_batch(sets, fit, mixture).ends,
        "profile, parametric bootstrap": interval_batch(sets, fit, rises).ends,
        "percentiles of parametric bootstrap": np.quantile(
            refit.v_c.reshape(shape), tails, axis=1
        ).T,
        "m out of n bootstrap": np.clip(scaled, 0.0, sets.unit[:, None]),
    }


def _from_curves(sample: Sample, methods: Methods, seed: int) -> DataSets:
    """Every fitted curve with fresh noise, of which only rebounds are seen."""
    points = len(sample.ratio)
    shape = (methods.resamples, points)
    curves = restitution(sample.ratio, *(column[:, None] for column in sample.fit.parameters.T))
    noise = [
        stream(seed, CURVE_RESAMPLES, points, i).standard_normal(shape) for i in range(len(curves))
    ]
    curve = np.repeat(curves, methods.resamples, axis=0)
    e, present = observed(curve, sample.noise * np.concatenate(noise), "rebounds")
    return data_sets(sample.ratio, e, present / sample.noise, sample.sets.q)


def _from_data(sample: Sample, methods: Methods, seed: int) -> DataSets:
    """Of every data set m of the n points, drawn with replacement."""
    points, free = len(sample.ratio), sample.sets.free
    chosen = [
        _usable(stream(seed, DATA_RESAMPLES, points, i), present, free, methods)
        for i, present in enumerate(sample.sets.e > 0.0)
    ]
    weight = np.sqrt(np.concatenate(chosen)) / sample.noise
    e = np.repeat(sample.sets.e, methods.resamples, axis=0)
    return data_sets(sample.ratio, e, weight, sample.sets.q)


def _usable(
    random: np.random.Generator, present: BoolArray, free: int, methods: Methods
) -> NDArray[np.int64]:
    """Return the first resamples that determine the free parameters with a point to spare."""
    drawn = round(methods.share_of_points * present.size)
    alike = np.full(present.size, 1.0 / present.size)
    usable = np.empty((0, present.size), np.int64)
    for _ in range(TRIES):
        counts = random.multinomial(drawn, alike, size=methods.resamples) * present
        usable = np.concatenate([usable, counts[np.sum(counts > 0, axis=1) > free]])
        if len(usable) >= methods.resamples:
            return usable[: methods.resamples]
    raise ValueError(
        f"methods.share_of_points: {methods.share_of_points:g} leaves too few different "
        f"speeds for {free} free parameters"
    )
