"""Distributions of particles and surfaces, each by its quantile function.

A draw is the quantile of a uniform number, whatever the distribution; plain or quasi-random.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import scipy
from annotated_types import Ge

from microimpact.core.arrays import FloatArray
from microimpact.core.bounds import ByKind, Name, NonNegative, Positive

# Uniform numbers stay this far inside (0, 1): the quantiles of 0 and 1 may be infinite.
SMALLEST_PROBABILITY = 2.0**-54
LARGEST_PROBABILITY = 1.0 - 2.0**-53


@dataclass(frozen=True, slots=True, kw_only=True)
class Constant:
    """The same number always."""

    at: float
    kind: Literal["constant"] = "constant"

    def quantile(self, u: FloatArray) -> FloatArray:
        """Return the values below which a share ``u`` of all draws lies."""
        return np.full(np.shape(u), float(self.at))


@dataclass(frozen=True, slots=True, kw_only=True)
class Uniform:
    """All numbers of an interval alike."""

    low: float
    high: float
    kind: Literal["uniform"] = "uniform"

    def __post_init__(self) -> None:
        """Refuse an empty interval."""
        _ordered(self.low, self.high)

    def quantile(self, u: FloatArray) -> FloatArray:
        """Return the values below which a share ``u`` of all draws lies."""
        return self.low + (self.high - self.low) * np.asarray(u)


@dataclass(frozen=True, slots=True, kw_only=True)
class Normal:
    """Normal distribution; mean 0 and standard deviation 1 (standardised) if not given."""

    mean: float = 0.0
    sd: NonNegative = 1.0
    kind: Literal["normal"] = "normal"

    def quantile(self, u: FloatArray) -> FloatArray:
        """Return the values below which a share ``u`` of all draws lies."""
        return np.asarray(self.mean + self.sd * scipy.special.ndtri(u))


@dataclass(frozen=True, slots=True, kw_only=True)
class TruncatedNormal:
    """Normal distribution cut to an interval; mean and sd are those before the cut."""

    mean: float
    sd: Positive
    low: float
    high: float
    kind: Literal["truncated_normal"] = "truncated_normal"

    def __post_init__(self) -> None:
        """Refuse an empty interval, or one without probability."""
        _ordered(self.low, self.high)
        if not self.share > 0.0:
            raise ValueError(
                f"low {self.low:g} to high {self.high:g} lies so far from the mean {self.mean:g} "
                f"(sd {self.sd:g}) that nothing is drawn there"
            )

    @property
    def share(self) -> float:
        """Share of the normal distribution that the cut leaves."""
        # Below each end; by a function that needs no import of SciPy's.
        below, above = (0.5 * math.erfc(-end / math.sqrt(2.0)) for end in self._ends())
        return above - below

    def _ends(self) -> tuple[float, float]:
        """Ends in standard deviations, on the side where probabilities are exact."""
        ends = (self.low - self.mean) / self.sd, (self.high - self.mean) / self.sd
        return (-ends[1], -ends[0]) if ends[0] > 0.0 else ends

    def quantile(self, u: FloatArray) -> FloatArray:
        """Return the values below which a share ``u`` of all draws lies."""
        low, high = self._ends()
        mirrored = self.low > self.mean
        share = 1.0 - np.asarray(u) if mirrored else np.asarray(u)
        below, above = scipy.special.ndtr(low), scipy.special.ndtr(high)
        z = np.clip(scipy.special.ndtri(below + share * (above - below)), low, high)
        return np.asarray(self.mean + self.sd * (-z if mirrored else z))


@dataclass(frozen=True, slots=True, kw_only=True)
class HalfNormal:
    """Absolute value of a normal variable of mean zero."""

    sd: NonNegative
    kind: Literal["half_normal"] = "half_normal"

    def quantile(self, u: FloatArray) -> FloatArray:
        """Return the values below which a share ``u`` of all draws lies."""
        return np.asarray(self.sd * math.sqrt(2.0) * scipy.special.erfinv(u))


@dataclass(frozen=True, slots=True, kw_only=True)
class LogNormal:
    """Lognormal distribution by its median and its geometric standard deviation (1 or more)."""

    median: Positive
    geometric_sd: Annotated[float, Ge(1)]
    kind: Literal["lognormal"] = "lognormal"

    def quantile(self, u: FloatArray) -> FloatArray:
        """Return the values below which a share ``u`` of all draws lies."""
        return np.asarray(
            self.median * np.exp(math.log(self.geometric_sd) * scipy.special.ndtri(u))
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Histogram:
    """Bins of given weights, uniform within each."""

    edges: tuple[float, ...]
    counts: tuple[NonNegative, ...]
    kind: Literal["histogram"] = "histogram"

    def __post_init__(self) -> None:
        """Refuse a histogram that is empty or whose bins are not in order."""
        if len(self.edges) != len(self.counts) + 1:
            raise ValueError(
                f"edges must be one more than counts, got {len(self.edges)} and {len(self.counts)}"
            )
        if any(b <= a for a, b in zip(self.edges, self.edges[1:], strict=False)):
            raise ValueError(f"edges must increase, got {list(self.edges)}")
        if not sum(self.counts) > 0.0:
            raise ValueError(f"counts must not all be zero, got {list(self.counts)}")

    def quantile(self, u: FloatArray) -> FloatArray:
        """Return the values below which a share ``u`` of all draws lies."""
        counts = np.asarray(self.counts, dtype=float)
        share = np.concatenate([[0.0], np.cumsum(counts)]) / counts.sum()
        u = np.asarray(u)
        # The first bin that reaches u: an empty bin reaches nothing.
        bins = np.clip(np.searchsorted(share, u, side="left") - 1, 0, counts.size - 1)
        inside = (u - share[bins]) / np.maximum(share[bins + 1] - share[bins], np.finfo(float).tiny)
        edges = np.asarray(self.edges)
        return np.asarray(edges[bins] + inside * (edges[bins + 1] - edges[bins]))


@dataclass(frozen=True, slots=True, kw_only=True)
class SampleFile:
    """Values measured elsewhere, in a file, drawn with replacement.

    The file holds one number per line; what follows a ``#`` is a comment.
    """

    path: Name
    kind: Literal["sample_file"] = "sample_file"

    def __post_init__(self) -> None:
        """Refuse a file that is missing, empty or not of that form."""
        _values_in(self.path)

    def quantile(self, u: FloatArray) -> FloatArray:
        """Return the values below which a share ``u`` of all draws lies."""
        ordered = _values_in(self.path)
        index = np.minimum((np.asarray(u) * ordered.size).astype(int), ordered.size - 1)
        return np.asarray(ordered[index])


@cache
def _values_in(path: str) -> FloatArray:
    """Values of a sample file in ascending order."""
    try:
        lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f"path: {path}: cannot be read as text: {error}") from None
    values = []
    for number, line in enumerate(lines, start=1):
        text = line.partition("#")[0].strip()
        if not text:
            continue
        try:
            values.append(float(text))
        except ValueError:
            values.append(math.nan)
        if not math.isfinite(values[-1]):
            raise ValueError(f"path: {path}, line {number}: {text!r} must be one finite number")
    if not values:
        raise ValueError(f"path: {path}: must hold at least one number, got none")
    ordered = np.sort(np.asarray(values))
    ordered.setflags(write=False)
    return ordered


Distribution = Annotated[
    Constant | Uniform | Normal | TruncatedNormal | HalfNormal | LogNormal | Histogram | SampleFile,
    ByKind(),
]


def uniforms(rng: np.random.Generator, shape: int | tuple[int, ...]) -> FloatArray:
    """Return uniform numbers strictly inside (0, 1), whose quantiles are finite."""
    drawn = rng.random(shape)
    return np.clip(drawn, SMALLEST_PROBABILITY, LARGEST_PROBABILITY, out=drawn)


def quasi_random(n: int, dimensions: int, rng: np.random.Generator) -> FloatArray:
    """Return a scrambled Sobol sequence in the open unit cube, (n, dimensions).

    Parameters
    ----------
    n
        Number of points, a power of two.
    dimensions
        Number of dimensions.
    rng
        Generator of the scrambling.
    """
    points = scipy.stats.qmc.Sobol(dimensions, rng=rng).random_base2(n.bit_length() - 1)
    return np.clip(points, SMALLEST_PROBABILITY, LARGEST_PROBABILITY)


def sample(
    distribution: Distribution, rng: np.random.Generator, shape: int | tuple[int, ...]
) -> FloatArray:
    """Return independent draws in the unit of the distribution.

    Parameters
    ----------
    distribution
        Distribution of the quantity.
    rng
        Generator of the draws.
    shape
        Shape of the draws.
    """
    return distribution.quantile(uniforms(rng, shape))


@cache
def mean(distribution: Distribution, nodes: int = 4001) -> float:
    """Return the mean of a distribution, by the midpoint rule over its quantiles."""
    return float(np.mean(distribution.quantile((np.arange(nodes) + 0.5) / nodes)))


def generator(seed: int, *key: int) -> np.random.Generator:
    """Return the random generator of one part of an analysis.

    Parameters
    ----------
    key
        Numbers of the part (experiment, chunk, ...): other keys, independent streams.
    """
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))


def child(rng: np.random.Generator, *key: int) -> np.random.Generator:
    """Return an independent generator for one part of another generator's use.

    Nothing is drawn from `rng`; its seed alone matters, so that results do not depend on the order
    or the grouping of the parts. Raises TypeError if `rng` was not made from a
    `numpy.random.SeedSequence` (as `default_rng` does).
    """
    root = rng.bit_generator.seed_seq
    if not isinstance(root, np.random.SeedSequence):
        raise TypeError(f"rng must come from a SeedSequence, not {type(root).__name__}")
    return np.random.default_rng(
        np.random.SeedSequence(root.entropy, spawn_key=(*root.spawn_key, *key))
    )


def _ordered(low: float, high: float) -> None:
    if not low < high:
        raise ValueError(f"low must be below high, got {low:g} and {high:g}")
