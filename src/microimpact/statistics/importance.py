"""Importance sampling of several densities over the unit cube by one pool of points.

A Sobol sequence comes first; then, round by round, Student's t kernels at points drawn by the
weights of each density (population Monte Carlo). These points only say where the densities are
high: each counts with a mixture whose kernels stand at the very points, so that integrals by them
come out too small (Marin, Pudlo and Sedki 2019). The pool is drawn afresh from the last kernels and
counts with the density of the whole mixture that drew it (Owen and Zhou 2000), so that any density
can be weighed afterwards, without bias and with the error of independent points.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import chain

import numpy as np
import scipy

from microimpact.core.arrays import FloatArray
from microimpact.core.ensemble import effective_number, resampled
from microimpact.core.solve import root

# Degrees of freedom of the kernels, and draws from each.
FREEDOM, EACH = 5.0, 4
# Binary logarithm of the first sequence's points to each that the pool has all over the cube.
EVEN = 3
# Power to which the weights are raised where hardly any of them count.
FLATTEST = 1e-9

Record = Mapping[str, FloatArray]


@dataclass(frozen=True, slots=True, kw_only=True)
class Pool:
    """Points, the values computed at them, and how densely they were drawn."""

    points: FloatArray  # (n, axes)
    record: Record  # Arrays (n, ...)
    log_proposal: FloatArray  # Density of the mixture (n,)
    tried: int  # Points drawn, those beyond the cube included

    def log_weights(self, log_density: FloatArray) -> FloatArray:
        """Logarithms of weights (n,) whose mean over all tried points is the integral."""
        return np.asarray(log_density - self.log_proposal)


@dataclass(frozen=True, slots=True)
class Integral:
    """Integral of a density: logarithm, its standard error, and points that it is worth."""

    log: float
    error: float
    effective_size: float


def integral(log_weights: FloatArray, tried: int) -> Integral:
    """Return the integral that `Pool.log_weights` estimates."""
    top = float(np.max(log_weights))
    if not np.isfinite(top):
        return Integral(-np.inf, np.nan, 0.0)
    weights = np.exp(log_weights - top)
    size = effective_number(weights)
    error = np.sqrt(max(1.0 / size - 1.0 / tried, 0.0))
    return Integral(top + float(np.log(np.sum(weights) / tried)), float(error), size)


def drawn_size(effective_size: float, draws: int) -> float:
    """Return how many independent draws a share over resampled points is worth.

    The variance of a share p is ``p (1 - p)/n_eff``, of the weighted points, and that of drawing
    again from them, no more than ``p (1 - p)/m`` for m draws of equal weight.

    Parameters
    ----------
    effective_size
        Of the weights (Kish), n_eff.
    draws
        Drawn in proportion to them, m.
    """
    return 1.0 / (1.0 / effective_size + 1.0 / draws)


def pool(
    compute: Callable[[FloatArray], Record],
    logs_of: Callable[[Record], FloatArray],
    log_densities: Callable[[FloatArray], FloatArray],
    axes: int,
    *,
    first: int,
    rounds: int,
    rng: np.random.Generator,
) -> Pool:
    """Draw points where any of several densities is high.

    Parameters
    ----------
    compute
        What is wanted at points (n, axes) of the unit cube, as arrays (n, ...).
    logs_of
        From that, logarithms of densities (n, k), -inf for none; asked for once at each point.
    log_densities
        From those of all points so far, logarithms of the densities (n, densities) to be drawn by.
    axes
        Of the cube.
    first
        Binary logarithm of the number of points of the Sobol sequence; a round has half as many.
    rounds
        How often kernels are set. The pool has the kernels of the latter half of the rounds, as
        many more set by all of them, and points all over the cube.
    rng
        Where all random numbers come from.
    """
    from scipy.stats.qmc import Sobol

    points = Sobol(axes, rng=rng).random_base2(first)
    known = logs_of(compute(points))
    drawn = np.full(len(points), float(len(points)))
    sets: list[list[Kernels]] = []

    def kernels_of_all(draws: int) -> list[Kernels]:
        logs = log_densities(known) - np.log(drawn)[:, None]
        columns = [column for column in logs.T if np.any(column > -np.inf)]
        number = -(-draws // (EACH * len(columns)))
        return [kernels(points, column, number, rng) for column in columns]

    for _ in range(rounds):
        latest = kernels_of_all(2 ** (first - 1))
        new = inside(np.concatenate([each.draw(rng) for each in latest]))
        known = np.concatenate([known, logs_of(compute(new))])
        earlier = sum((each.density(new) for each in chain(*sets)), np.full(len(new), 2.0**first))
        drawn, points = np.concatenate([drawn, earlier]), np.concatenate([points, new])
        drawn = drawn + sum(each.density(points) for each in latest)
        sets.append(latest)
    half = -(-rounds // 2)
    last = [*chain(*sets[-half:]), *kernels_of_all(half * 2 ** (first - 1))]
    even = Sobol(axes, rng=rng).random_base2(first - EVEN)
    points = np.concatenate([even, *(each.draw(rng) for each in last)])
    tried, points = len(points), inside(points)
    drawn = sum((each.density(points) for each in last), np.full(len(points), float(len(even))))
    return Pool(
        points=points,
        record=compute(points),
        log_proposal=np.log(drawn / tried),
        tried=tried,
    )


def inside(points: FloatArray) -> FloatArray:
    """Return the points that are within the unit cube."""
    return points[np.all((points > 0.0) & (points < 1.0), axis=1)]


@dataclass(frozen=True, slots=True)
class Kernels:
    """Student's t kernels of one shape at several centres, `EACH` draws from each."""

    centres: FloatArray  # (kernels, axes)
    factor: FloatArray  # Lower triangle of their covariance (axes, axes)

    def draw(self, rng: np.random.Generator) -> FloatArray:
        """Return the draws."""
        centres = np.repeat(self.centres, EACH, axis=0)
        stretch = np.sqrt(FREEDOM / rng.chisquare(FREEDOM, len(centres)))
        return np.asarray(
            centres + stretch[:, None] * (rng.standard_normal(centres.shape) @ self.factor.T)
        )

    def density(self, points: FloatArray) -> FloatArray:
        """Return how many draws there are per volume (n,)."""
        axes = points.shape[1]
        whitener = np.linalg.inv(self.factor).T
        square = scipy.spatial.distance.cdist(
            points @ whitener, self.centres @ whitener, "sqeuclidean"
        )
        gamma = scipy.special.gammaln
        log_unit = gamma(0.5 * (FREEDOM + axes)) - gamma(0.5 * FREEDOM)
        log_unit -= 0.5 * axes * np.log(np.pi * FREEDOM) + np.sum(np.log(np.diag(self.factor)))
        tails = np.power(1.0 + square / FREEDOM, -0.5 * (FREEDOM + axes))
        return np.asarray(EACH * np.exp(log_unit) * np.sum(tails, axis=1))


def kernels(
    points: FloatArray, log_weights: FloatArray, number: int, rng: np.random.Generator
) -> Kernels:
    """Return kernels for a weighted sample; weights of too few points are flattened by a power.

    Parameters
    ----------
    points
        Sample, (n, dimensions).
    log_weights
        Logarithms of the weights, (n,).
    number
        Number of kernels.
    rng
        Generator of the draws.
    """
    logs = log_weights - np.max(log_weights)

    def surplus(power: float) -> float:
        return float(effective_number(np.exp(power * logs)) - 10.0 * points.shape[1])

    power = 1.0
    if surplus(power) < 0.0:
        power = FLATTEST if surplus(FLATTEST) < 0.0 else root(surplus, FLATTEST, 1.0, relative=1e-2)
    weights = np.exp(power * logs)
    axes = points.shape[1]
    spread = np.cov(points, rowvar=False, aweights=weights, ddof=0).reshape(axes, axes)
    width = number ** (-1.0 / (axes + 4.0))
    factor = np.linalg.cholesky(width**2 * spread + 1e-8 * np.eye(axes))
    return Kernels(points[resampled(weights, number, rng)], factor)
