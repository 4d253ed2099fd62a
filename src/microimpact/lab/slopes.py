"""Slopes of the facets that are hit, for any distribution of the slopes of the surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from microimpact.core.arrays import FloatArray
from microimpact.lab.events import IntArray
from microimpact.statistics.distributions import (
    LARGEST_PROBABILITY,
    SMALLEST_PROBABILITY,
    Distribution,
)

# The distribution is cut into cells of equal width in normal scores, uniform within each: the
# width of 1/64 changes the variance of a normal slope by 2e-5 of itself.
SCORES = np.linspace(-8.25, 8.25, 1057)
# Beyond this the motion is so steep that all facets are hit alike, to rounding.
STEEPEST = 1e8


@dataclass(frozen=True, slots=True, eq=False)
class HitSlopes:
    """Slopes weighted by the area of their facets as seen along the motion.

    With x the slope (tangent) along the motion and c the tangent of the angle of approach, facets
    of slope x are hit in proportion to ``(c + x)+``. Counterpart, for any distribution, of
    `lab.collision.weighted_slope`.

    Attributes
    ----------
    edges
        Slopes between the cells, ascending, shape (n + 1,).
    mass
        Share of all facets in each cell, shape (n,).
    below, moment
        Share of facets below each edge, and integral of the slope over them, shape (n + 1,).
    """

    edges: FloatArray
    mass: FloatArray
    below: FloatArray
    moment: FloatArray

    @classmethod
    def of(cls, distribution: Distribution) -> HitSlopes:
        """Return the table of a distribution of slopes."""
        u = np.clip(scipy.special.ndtr(SCORES), SMALLEST_PROBABILITY, LARGEST_PROBABILITY)
        edges = np.asarray(distribution.quantile(u))
        mass = np.diff(u) / (u[-1] - u[0])
        first = mass * 0.5 * (edges[1:] + edges[:-1])
        sums = (np.concatenate([[0.0], np.cumsum(part)]) for part in (mass, first))
        return cls(edges, mass, *sums)

    def quantile(self, u: FloatArray, tangent: FloatArray) -> FloatArray:
        """Return the slopes below which a share ``u`` of all hits lies.

        Parameters
        ----------
        u
            Shares in (0, 1), shape (n,).
        tangent
            Of the angle of approach, shape (n,); negative for a sphere that recedes.

        Returns
        -------
        ndarray
            Shape (n,); -inf where no facet can be hit.
        """
        c = np.minimum(tangent, STEEPEST)
        cell = np.clip(np.searchsorted(self.edges, -c, side="right") - 1, 0, self.mass.size - 1)
        start = np.clip(-c, self.edges[cell], self.edges[cell + 1])
        reached = self._hits_below_edge(cell, c) + self._hits_within(cell, c, start)
        last = np.full_like(cell, self.mass.size)
        target = reached + u * (self._hits_below_edge(last, c) - reached)
        # From the cell of -c on the integral ascends; halve the cells until one is left.
        for _ in range(self.mass.size.bit_length()):
            middle = (cell + last) // 2
            beyond = self._hits_below_edge(middle, c) > target
            cell, last = np.where(beyond, cell, middle), np.where(beyond, middle, last)
        start = np.maximum(start, self.edges[cell])
        before = self._hits_below_edge(cell, c) + self._hits_within(cell, c, start)
        width = self.edges[cell + 1] - self.edges[cell]
        rest = (
            np.maximum(target - before, 0.0)
            * width
            / np.maximum(self.mass[cell], np.finfo(float).tiny)
        )
        weight = np.maximum(c + start, 0.0)
        # Root of weight x + x^2/2 = rest; without cancellation where the weight is large.
        divisor = weight + np.sqrt(np.square(weight) + 2.0 * rest)
        step = np.divide(2.0 * rest, divisor, out=np.zeros_like(rest), where=divisor > 0.0)
        slope = np.minimum(start + step, self.edges[cell + 1])
        return np.where(c + self.edges[-1] > 0.0, slope, -np.inf)

    def _hits_below_edge(self, edge: IntArray, c: FloatArray) -> FloatArray:
        return c * self.below[edge] + self.moment[edge]

    def _hits_within(self, cell: IntArray, c: FloatArray, slope: FloatArray) -> FloatArray:
        """Integral of c + x over the facets of a cell up to a slope."""
        left, right = self.edges[cell], self.edges[cell + 1]
        share = np.divide(slope - left, right - left, out=np.zeros_like(c), where=right > left)
        return self.mass[cell] * share * (c + 0.5 * (left + slope))
