"""Draws from a density over a box, by affine-invariant ensembles (Goodman and Weare 2010; emcee).

Points spread over the box are drawn again in proportion to a power of the density that leaves as
many different ones as walkers are wanted: there the walkers start, wherever the density has its
modes. Several ensembles that know nothing of each other tell how well that worked.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from microimpact.core.arrays import FloatArray
from microimpact.core.computable import NotComputable
from microimpact.core.extras import optional
from microimpact.core.solve import NoRootError, root

# Share of the steps that is not kept: the walkers drift to where they belong.
DRIFT = 1.0 / 3.0
ENSEMBLES, WALKERS = 2, 40
# Binary logarithm of the number of points among which the walkers find their starts.
SPREAD = 13
# Shares of the moves: stretches, differences of two walkers, and the same at full length, which
# leaps between modes.
STRETCHES, DIFFERENCES, LEAPS = 0.4, 0.5, 0.1

# While they drift, walkers that lie below the best logarithm by more than the first, where hardly a
# draw would ever be, are fetched; the second says how often, and each time at most half of them.
LEFT_BEHIND, GATHERINGS = 10.0, 5

LogDensity = Callable[[FloatArray], FloatArray]


class NoDensityError(NotComputable):
    """No point that was looked at has any density."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Draws:
    """Draws and how they came about."""

    points: FloatArray  # (n, axes), in random order
    log_density: FloatArray  # Of each (n,), up to a constant
    # Independent draws that all kept steps are worth, for the worst axis: the variance over that of
    # the mean, by the spread of the walkers' own means.
    effective_size: float
    # Per axis: spread of the means of the halves of every ensemble against the spread within
    # (Gelman et al. 2013, 11.4); 1 where they agree.
    split_r_hat: FloatArray


def draw(
    log_density: LogDensity,
    low: FloatArray,
    high: FloatArray,
    *,
    draws: int,
    steps: int,
    seed: int,
) -> Draws:
    """Draw from a density that is zero outside of a box.

    Parameters
    ----------
    log_density
        Takes points (n, axes) inside the box, returns their logarithms (n,), -inf for none.
    low, high
        Ends of the box (axes,).
    draws
        How many points are wanted, without repetition.
    steps
        Of each ensemble; the first third of them is not kept.
    seed
        Of all random numbers.

    Raises
    ------
    NoDensityError
        If fewer of the points spread have a density than there are walkers.
    ValueError
        If more draws are wanted than points are kept.
    """
    emcee = optional("emcee")

    kept = steps - int(DRIFT * steps)
    points = kept * WALKERS * ENSEMBLES
    if draws > points:
        raise ValueError(f"draws must be at most {points}, got {draws}")

    def inside(points: FloatArray) -> FloatArray:
        density = np.full(points.shape[0], -np.inf)
        good = np.all((points > low) & (points < high), axis=1)
        if np.any(good):
            density[good] = log_density(points[good])
        return density

    streams = [np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(2 + ENSEMBLES)]
    starts = _starts(inside, low, high, WALKERS * ENSEMBLES, streams[0])
    moves: list[Any] = [
        (emcee.moves.StretchMove(), STRETCHES),
        (emcee.moves.DEMove(), DIFFERENCES),
        (emcee.moves.DEMove(gamma0=1.0), LEAPS),
    ]
    unchecked: Any = {"skip_initial_state_check": True}
    chains, values = [], []
    for begun, stream in zip(np.split(starts, ENSEMBLES), streams[2:], strict=True):
        places = begun
        sampler = emcee.EnsembleSampler(WALKERS, low.size, inside, moves=moves, vectorize=True)
        sampler.random_state = np.random.RandomState(stream.integers(2**32)).get_state()
        for _ in range(GATHERINGS):
            state = sampler.run_mcmc(places, (steps - kept) // (GATHERINGS + 1), **unchecked)
            places = _gathered(state.coords, state.log_prob, stream)
        sampler.run_mcmc(places, steps - sampler.iteration, **unchecked)
        chains.append(sampler.get_chain()[-kept:])
        values.append(sampler.get_log_prob()[-kept:])
    chain = np.stack(chains)
    taken = streams[1].choice(points, draws, replace=False)
    return Draws(
        points=chain.reshape(-1, low.size)[taken],
        log_density=np.stack(values).ravel()[taken],
        effective_size=_effective_size(chain),
        split_r_hat=_split_r_hat(chain),
    )


def effective_number(weights: FloatArray) -> float:
    """Return how many equal weights vary a mean as much as these (Kish): (sum w)^2 / sum w^2."""
    return float(np.square(np.sum(weights)) / np.sum(np.square(weights)))


def resampled(weights: FloatArray, number: int, rng: np.random.Generator) -> Any:
    """Return indices drawn in proportion to weights, as evenly as possible (systematic).

    Parameters
    ----------
    weights
        Weights of the points, (n,), not negative.
    number
        How many indices are drawn.
    rng
        Generator of the draw.
    """
    share = np.cumsum(weights) / np.sum(weights)
    return np.searchsorted(share, (np.arange(number) + rng.random()) / number)


def _starts(
    log_density: LogDensity,
    low: FloatArray,
    high: FloatArray,
    number: int,
    rng: np.random.Generator,
) -> FloatArray:
    from scipy.stats.qmc import Sobol

    points = low + (high - low) * Sobol(low.size, rng=rng).random_base2(SPREAD)
    values = log_density(points)
    finite = np.isfinite(values)
    if np.sum(finite) < 2 * number:
        raise NoDensityError(
            f"{np.sum(finite)} of {values.size} points spread over the ranges have any density; "
            f"{2 * number} are needed"
        )
    points, values = points[finite], values[finite] - np.max(values[finite])

    def surplus(power: float) -> float:
        return effective_number(np.exp(power * values)) - 2.0 * number

    try:
        power = root(surplus, 0.0, 1.0, relative=1e-3)
    except NoRootError:  # the density itself leaves enough
        power = 1.0
    weights = np.exp(power * values)
    return np.asarray(
        points[rng.choice(values.size, number, replace=False, p=weights / np.sum(weights))]
    )


def _gathered(points: FloatArray, values: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Set walkers that were left behind between two others (Hou et al. 2012)."""
    behind = values < min(np.max(values) - LEFT_BEHIND, np.median(values))
    others = points[~behind]
    gathered = points.copy()
    for walker in np.flatnonzero(behind):
        near, far = rng.choice(others, 2, replace=False)
        gathered[walker] = near + rng.random() * (far - near)
    return gathered


def _split_r_hat(chain: FloatArray) -> FloatArray:
    """Potential scale reduction per axis of chains (ensembles, steps, walkers, axes)."""
    half = chain.shape[1] // 2
    parts = np.concatenate([chain[:, :half], chain[:, half : 2 * half]])
    parts = parts.reshape(parts.shape[0], -1, parts.shape[-1])
    within = parts.var(axis=1, ddof=1).mean(axis=0)
    between = parts.mean(axis=1).var(axis=0, ddof=1)
    return np.asarray(np.sqrt((within + between) / within))


def _effective_size(chain: FloatArray) -> float:
    steps, axes = chain.shape[1], chain.shape[-1]
    means = chain.mean(axis=1).reshape(-1, axes)
    variance = chain.reshape(-1, axes).var(axis=0)
    size = means.shape[0] * variance / means.var(axis=0, ddof=1)
    return float(np.min(np.minimum(size, steps * means.shape[0])))
