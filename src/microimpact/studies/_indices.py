"""Sobol' indices of variance: the one place that knows the library.

First-order and total indices by Saltelli's scheme, with bootstrap intervals.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from microimpact.arrays import FloatArray


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

    Returns
    -------
    ndarray
        Shape (samples, inputs + 2, inputs): per base sample the points A, A with one input each
        from B, and B.

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
    from SALib.analyze import sobol as analysis

    if not np.all(np.isfinite(response)):
        raise ValueError("Sobol' indices need finite responses")
    if np.ptp(response) == 0.0:
        raise ValueError("Sobol' indices need a response that varies")
    found: Any = analysis.analyze(
        _problem(response.shape[1] - 2),
        response.ravel(),
        calc_second_order=False,
        num_resamples=resamples,
        keep_resamples=True,
        seed=draw,
    )
    tail = 0.5 * (1.0 - confidence)
    ends = {
        f"{name}_{end}": np.quantile(found[f"{key}_conf_all"], probability, axis=0)
        for name, key in (("first", "S1"), ("total", "ST"))
        for end, probability in (("low", tail), ("high", 1.0 - tail))
    }
    return Indices(first=np.asarray(found["S1"]), total=np.asarray(found["ST"]), **ends)


def _problem(inputs: int) -> dict[str, object]:
    names = [f"x{i}" for i in range(inputs)]
    return {"num_vars": inputs, "names": names, "bounds": [[0.0, 1.0]] * inputs}
