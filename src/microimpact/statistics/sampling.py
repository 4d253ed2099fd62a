"""Joint draws of several distributions: plain, antithetic or quasi-random, correlated or not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import accumulate
from typing import Literal

import numpy as np
import scipy

from microimpact.core.arrays import FloatArray
from microimpact.core.bounds import Name
from microimpact.statistics.distributions import (
    LARGEST_PROBABILITY,
    SMALLEST_PROBABILITY,
    Constant,
    Distribution,
    HalfNormal,
    LogNormal,
    Normal,
    TruncatedNormal,
    uniforms,
)

Method = Literal["plain", "antithetic", "quasi_random"]
Generator = Literal["exact", "central_limit"]

# Sum of so many uniform numbers less half as many: mean 0, variance 1, nearly normal. Its fourth
# cumulant is -12/120, so the excess kurtosis is -0.1, and it never leaves (-6, 6).
SUMMANDS = 12


@dataclass(frozen=True, slots=True, kw_only=True)
class Correlation:
    """Correlations of the normal scores of some parameters (a Gaussian copula).

    For normal parameters these are the ordinary correlations. Parameters that are not named are
    independent of all others.
    """

    names: tuple[Name, ...] = ()
    matrix: tuple[tuple[float, ...], ...] = ()

    def __post_init__(self) -> None:
        """Refuse a matrix that is not a correlation matrix of those parameters."""
        n = len(self.names)
        repeated = sorted({name for name in self.names if self.names.count(name) > 1})
        if repeated:
            raise ValueError(f"names: {repeated[0]!r} is given more than once")
        lengths = [len(row) for row in self.matrix]
        if lengths != [n] * n:
            raise ValueError(
                f"matrix must have {n} rows of {n} numbers, one for each name, "
                f"got rows of {lengths}"
            )
        matrix = np.asarray(self.matrix, dtype=float).reshape(n, n)
        if not (np.array_equal(matrix, matrix.T) and np.all(np.diag(matrix) == 1.0)):
            raise ValueError("matrix must be symmetric with ones on its diagonal")
        smallest = np.min(np.linalg.eigvalsh(matrix), initial=1.0)
        if smallest < n * np.finfo(float).eps:
            raise ValueError(
                f"matrix must be positive definite, its smallest eigenvalue is {smallest:.3g}"
            )

    def factor(self) -> FloatArray:
        """Return the Cholesky factor of the matrix."""
        return np.asarray(np.linalg.cholesky(np.asarray(self.matrix, dtype=float)))


def require_varying(correlation: Correlation, distributions: Mapping[str, Distribution]) -> None:
    """Raise a ValueError unless every correlated parameter is there and varies."""
    for name in correlation.names:
        if name not in distributions:
            raise ValueError(
                f"correlation.names: {name!r} must be one of {', '.join(distributions)}"
            )
        if isinstance(distributions[name], Constant):
            raise ValueError(f"correlation.names: {name!r} is constant, so nothing can follow it")


def joint_shares(
    distributions: Mapping[str, Distribution],
    n: int,
    rng: np.random.Generator,
    *,
    correlation: Correlation | None = None,
    method: Method = "plain",
    generator: Generator = "exact",
) -> dict[str, FloatArray]:
    """Draw the shares (uniform numbers) of which the quantiles are the values of parameters.

    Parameters
    ----------
    distributions
        By name; constants take no random numbers.
    n
        Number of draws, a power of two.
    rng
        Source of the uniform numbers.
    correlation
        None is none.
    method
        ``"plain"``: independent draws. ``"antithetic"``: every draw u has its opposite 1 - u.
        ``"quasi_random"``: a scrambled Sobol sequence.
    generator
        ``"exact"``: uniform shares. ``"central_limit"``: those of normal, truncated, half and
        lognormal values come from the sum of twelve uniform numbers, as in the article's program.

    Returns
    -------
    dict
        Arrays of shape (n,) in (0, 1), by name; (1,) those of constants.
    """
    varying = {k: d for k, d in distributions.items() if not isinstance(d, Constant)}
    columns = {k: SUMMANDS if _summed(d, generator) else 1 for k, d in varying.items()}
    ends = dict(zip(columns, accumulate(columns.values()), strict=True))
    cube = unit_points(n, sum(columns.values()), rng, method)
    shares = dict.fromkeys(distributions, np.full(1, 0.5))
    shares |= {name: _share(cube[:, end - columns[name] : end]) for name, end in ends.items()}
    if correlation is not None and correlation.names:
        scores = np.stack([scipy.special.ndtri(shares[name]) for name in correlation.names], axis=1)
        for name, score in zip(correlation.names, (scores @ correlation.factor().T).T, strict=True):
            shares[name] = _inside(scipy.special.ndtr(score))
    return shares


def unit_points(
    n: int, dimensions: int, rng: np.random.Generator, method: Method = "plain"
) -> FloatArray:
    """Return points of the open unit cube, (n, dimensions).

    Parameters
    ----------
    n
        Number of points, a power of two.
    dimensions
        Number of dimensions.
    rng
        Generator of the draws.
    method
        How the points are spread.
    """
    if dimensions == 0:
        return np.empty((n, 0))
    if method == "quasi_random":
        points = scipy.stats.qmc.Sobol(dimensions, rng=rng).random_base2(n.bit_length() - 1)
        return _inside(np.asarray(points))
    if method == "antithetic":
        half = uniforms(rng, (n // 2, dimensions))
        return _inside(np.concatenate([half, 1.0 - half]))
    return uniforms(rng, (n, dimensions))


def _summed(distribution: Distribution, generator: Generator) -> bool:
    normal = isinstance(distribution, Normal | TruncatedNormal | HalfNormal | LogNormal)
    return generator == "central_limit" and normal


def _share(part: FloatArray) -> FloatArray:
    """Return the uniform numbers of one parameter, from its one column or its twelve."""
    if part.shape[1] == 1:
        return part[:, 0]
    return _inside(scipy.special.ndtr(part.sum(axis=1) - SUMMANDS / 2))


def _inside(u: FloatArray) -> FloatArray:
    return np.clip(u, SMALLEST_PROBABILITY, LARGEST_PROBABILITY)
