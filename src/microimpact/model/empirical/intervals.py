"""Profile of chi-square in v_c, Eq. (34), and the intervals of v_c that follow from it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microimpact.core.arrays import POSITIVE, BoolArray, FloatArray, checked
from microimpact.core.solve import TINY, roots
from microimpact.model.empirical.data import DataSets, Places
from microimpact.model.empirical.kernel import V_C
from microimpact.model.empirical.search import CLOSEST, BatchFit, profile

# An end of v_c nearer than this to the smallest rebounding speed is set by that speed.
AT_REBOUND = 1e-3
# The distance of v_c from the smallest rebounding speed grows by this factor, or falls, until
# chi-square has risen enough.
STRIDE = 2.0
# An end is known to this share of its distance from the smallest rebounding speed.
TOLERANCE = 1e-6


class Intervals(NamedTuple):
    """Intervals of v_c of r data sets."""

    ends: FloatArray  # Lower and upper ends (r, 2), m/s
    # Whether an end is set by the admissible range, 0 to the slowest rebound (r, 2).
    limited: BoolArray
    # The least chi-square met on the way (r,), and ln(k, p, kappa, q, v_c) (r, 5) there, in units
    # of the slowest rebounds: below that of the fit, if this overlooked a minimum.
    least: FloatArray
    at: FloatArray


def interval_batch(sets: DataSets, fit: BatchFit, rise: ArrayLike) -> Intervals:
    """Profile intervals of v_c.

    From the fit outwards, the first v_c at which the least chi-square over all other parameters
    exceeds that of the fit by more than the rise.

    Parameters
    ----------
    sets, fit
        The data and their fit.
    rise
        Rise of chi-square above the minimum, positive, of a shape that broadcasts to (r,).
    """
    count = len(sets.unit)
    limit = np.broadcast_to(np.sqrt(checked("rise", rise, POSITIVE)), count)
    # Both ends at once: the lower ones of all data sets, then the upper ones.
    way = _Way(sets, np.tile(fit.logs(sets), (2, 1)), fit, limit)
    best = np.maximum(1.0 - fit.v_c / sets.unit, CLOSEST)
    outermost = np.concatenate([np.ones(count), np.minimum(best, AT_REBOUND)])
    gap, inside, rows = outermost.copy(), np.tile(best, 2), np.arange(2 * count)
    # A search from its neighbour's end may stay in a higher valley than one from a fresh start.
    for fresh in (False, True):
        gap[rows] = way.crossing(*_bracket(way, inside, outermost[rows], rows), rows, fresh=fresh)
        rows = rows[gap[rows] != outermost[rows]]
        rows = rows[way.excess(gap[rows], rows, fresh=True) < -TOLERANCE * way.limit[rows]]
        inside = gap[rows]
    held = gap == outermost
    ends = np.where(held, np.repeat([0.0, 1.0], count), 1.0 - gap)
    lowest = np.argmin(way.least.reshape(2, -1), axis=0) * count + np.arange(count)
    return Intervals(
        ends=ends.reshape(2, -1).T * sets.unit[:, None],
        limited=held.reshape(2, -1).T,
        least=way.least[lowest],
        at=way.at[lowest],
    )


class _Way:
    """Searches with v_c held, each from where one within the limit ended: its neighbour's start."""

    def __init__(self, sets: DataSets, at: FloatArray, fit: BatchFit, limit: FloatArray) -> None:
        self.sets, self.at, self.logs = sets, at, at[:, :V_C].copy()
        self.minimum, self.limit = np.tile(fit.chi_square, 2), np.tile(limit, 2)
        self.least = self.minimum.copy()

    def excess(self, gap: FloatArray, rows: Places, *, fresh: bool) -> FloatArray:
        """Root of the rise of chi-square, nearly linear in v_c, less the root at the limit."""
        owner = rows % len(self.sets.unit)
        minimum = profile(self.sets, owner, gap, self.logs[rows], fresh=int(fresh))
        chi_square, logs = minimum.value, minimum.x[:, :V_C]
        value = np.sqrt(np.maximum(chi_square - self.minimum[rows], 0.0)) - self.limit[rows]
        within, lower = value <= 0.0, chi_square < self.least[rows]
        self.logs[rows[within]] = logs[within]
        self.least[rows[lower]] = chi_square[lower]
        v_c = np.log(np.maximum(1.0 - gap, CLOSEST))
        self.at[rows[lower]] = np.column_stack([logs, v_c])[lower]
        return value

    def crossing(
        self, within: FloatArray, beyond: FloatArray, rows: Places, *, fresh: bool
    ) -> FloatArray:
        """Distance of v_c from the slowest rebound at which the rise of chi-square is the limit.

        The ends keep the signs that they had when they were bracketed: a later search may come to a
        minimum that the fit overlooked, which `least` reports, and from there both are within.
        """

        def signed(
            gap: FloatArray, rows: FloatArray, within: FloatArray, beyond: FloatArray
        ) -> FloatArray:
            value = self.excess(gap, rows.astype(np.intp), fresh=fresh)
            value = np.where(gap == within, np.minimum(value, -TINY), value)
            return np.where(gap == beyond, np.maximum(value, TINY), value)

        gap, apart = beyond.copy(), within != beyond
        ends = within[apart], beyond[apart]
        gap[apart] = roots(signed, *ends, rows[apart], *ends, relative=TOLERANCE)
        return gap


def _bracket(
    way: _Way, best: FloatArray, outermost: FloatArray, rows: Places
) -> tuple[FloatArray, FloatArray]:
    """Distances of v_c from the slowest rebound within the limit and beyond it.

    Both are the outermost one where the limit is never met.
    """
    inside, outside = best.copy(), outermost.copy()
    growing = np.arange(len(best))
    while growing.size:
        last, end = inside[growing], outermost[growing]
        gap = np.where(end >= last, np.minimum(last * STRIDE, end), np.maximum(last / STRIDE, end))
        within = way.excess(gap, rows[growing], fresh=True) <= 0.0
        outside[growing] = gap
        inside[growing[within]] = gap[within]
        growing = growing[within & (gap != end)]
    return inside, outside
