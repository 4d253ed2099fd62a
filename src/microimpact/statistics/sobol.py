"""Sobol' indices of variance: first-order and total ones, with bootstrap intervals.

Saltelli's scheme. SALib draws the points; the indices are those of its analysis, which gathers
every resample anew where one product of matrices serves all.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from microimpact.core.arrays import FloatArray

# A variance, of responses of variance one, below which nothing varies.
NO_VARIANCE: Final = float(np.finfo(float).eps)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Indices:
    """First-order and total indices with the ends of their intervals, shape (inputs,) each."""

    first: FloatArray
    first_low: FloatArray
    first_high: FloatArray
    total: FloatArray
    total_low: FloatArray
    total_high: FloatArray


def require_power_of_two(name: str, samples: int) -> None:
    """Raise a ValueError unless a number of samples is a power of two."""
    if samples < 2 or samples & (samples - 1):
        raise ValueError(f"{name} must be a power of two, 2 or more, got {samples}")


def saltelli_sample(inputs: int, samples: int, draw: np.random.Generator) -> FloatArray:
    """Points of the unit cube in which to evaluate a function for its indices.

    Parameters
    ----------
    inputs
        Number of inputs.
    samples
        Number of base samples, a power of two.
    draw
        Generator of the draws.

    Returns
    -------
    points
        Per base sample the points A, A with one input each from B, and B, (samples, inputs + 2,
        inputs).

    Raises
    ------
    ValueError
        If the number of samples is not a power of two.
    """
    # Imported where it is used: whoever only checks a configuration need not wait for it.
    from SALib.sample import sobol as sampling

    require_power_of_two("samples", samples)
    points: Any = sampling.sample(_problem(inputs), samples, calc_second_order=False, seed=draw)
    cube: FloatArray = np.asarray(points, float).reshape(samples, inputs + 2, inputs)
    return cube


def sobol_indices(
    response: FloatArray, draw: np.random.Generator, *, resamples: int, confidence: float
) -> Indices:
    """Indices from the responses at the points of a Saltelli sample.

    Estimators of Saltelli et al., Computer Physics Communications 181 (2010) 259.

    Parameters
    ----------
    response
        Shape (samples, inputs + 2), finite.
    draw
        Source of the bootstrap's random numbers.
    resamples
        Number of bootstrap samples.
    confidence
        Of the percentile intervals.

    Raises
    ------
    ValueError
        If a response is not finite, or all are the same.
    """
    if not np.all(np.isfinite(response)):
        raise ValueError("Sobol' indices need finite responses")
    if np.ptp(response) == 0.0:
        raise ValueError("Sobol' indices need a response that varies")
    samples, columns = response.shape
    once = np.full((1, samples), 1.0 / samples)
    weights = np.concatenate([once, _resampled(samples, resamples, draw)])
    first, total = np.split(_weighted_indices(response, weights), [columns - 2], axis=1)
    tail = 0.5 * (1.0 - confidence)
    ends = {
        f"{name}_{end}": np.quantile(found[1:], probability, axis=0)
        for name, found in (("first", first), ("total", total))
        for end, probability in (("low", tail), ("high", 1.0 - tail))
    }
    return Indices(first=first[0], total=total[0], **ends)


def _resampled(samples: int, resamples: int, draw: np.random.Generator) -> FloatArray:
    """Share of each base sample in each bootstrap sample, shape (resamples, samples)."""
    drawn = draw.integers(samples, size=(samples, resamples)) + samples * np.arange(resamples)
    counts = np.bincount(drawn.ravel(), minlength=samples * resamples)
    shares: FloatArray = counts.reshape(resamples, samples) / samples
    return shares


def _weighted_indices(response: FloatArray, weights: FloatArray) -> FloatArray:
    """First-order, then total indices for each row of weights, shape (rows, 2 * inputs).

    All are ratios of means of base samples, so that one product of matrices gives them.
    """
    # Estimates are biased for responses that are not centred.
    standard = (response - response.mean()) / response.std()
    a, mixed, b = standard[:, :1], standard[:, 1:-1], standard[:, -1:]
    first, total = b * (mixed - a), 0.5 * (a - mixed) ** 2
    terms = np.hstack([first, total, 0.5 * (a + b), 0.5 * (a**2 + b**2)])
    means = weights @ terms
    variance = means[:, -1:] - means[:, -2:-1] ** 2
    products: FloatArray = np.zeros_like(means[:, :-2])
    np.divide(means[:, :-2], variance, out=products, where=variance > NO_VARIANCE)
    return products


def _problem(inputs: int) -> dict[str, object]:
    names = [f"x{i}" for i in range(inputs)]
    return {"num_vars": inputs, "names": names, "bounds": [[0.0, 1.0]] * inputs}
