"""Least squares search of very many curves of Eq. (34)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from microimpact.arrays import BoolArray, FloatArray
from microimpact.model.restitution_kernel import descend_all

Places = npt.NDArray[np.intp]


class Search(NamedTuple):
    """Data (r, n); of m searches the data set (m,), upper end of v_c (m,), and the box (m, 5)."""

    v: FloatArray
    e: FloatArray
    weight: FloatArray
    owner: Places
    end: FloatArray
    low: FloatArray
    high: FloatArray


class Found(NamedTuple):
    """Variables ln(k, p, kappa, q, gap) (m, 5), chi-square (m,), whether the searches converged."""

    x: FloatArray
    chi_square: FloatArray
    converged: BoolArray


def descend(search: Search, x: FloatArray) -> Found:
    """Lower the sums of squares from x as far as possible within the box.

    Parameters
    ----------
    search
        The data, and the box of ln(k, p, kappa, q, gap); a variable whose bounds are equal is
        fixed.
    x
        Starts ln(k, p, kappa, q, gap), (s, 5), s a multiple of m: those of all searches once, then
        again.
    """
    start = np.resize(np.arange(len(search.end)), len(x))
    x = np.clip(x, search.low[start], search.high[start])
    found = Found(x, np.empty(len(x)), np.zeros(len(x), bool))
    descend_all(*search, start, *found)
    return found
