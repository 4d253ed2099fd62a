"""Piecewise polynomials over octaves of one variable and the width of another.

A *table* holds several quantities as functions of x > 0 and g in [-1, 1]. The pieces are octaves of
x, or equal parts of octaves, so that a function with a singular point at x = 0 is as smooth on one
piece as on any other, and so that the bits of x name the piece. Within a piece every quantity is a
polynomial through Chebyshev points, stored by powers: at this degree these lose nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import chebyshev

from microimpact.core.arrays import FloatArray
from microimpact.core.compiled import jit

DEGREE = 12
# Quantities side by side in one table: what fills the widest registers.
WIDTH = 8

# Impacts that one call of the compiled code computes; threads share them out.
BLOCK = 1 << 15

_jit_inline = jit(inline="always")
_jit = jit(fastmath={"contract"})

# Of x and g, arrays of one shape (n,), the quantities (WIDTH, n).
Sampled = Callable[[FloatArray, FloatArray], FloatArray]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Table:
    """Polynomials in x and g.

    Attributes
    ----------
    coefficients
        Of powers of the places within band and piece, (bands, pieces, widths, DEGREE + 1, WIDTH);
        bands are equal parts of g's interval.
    lowest
        Binary exponent of the first octave.
    split
        Pieces per octave.
    error
        Largest difference from the function at points between the nodes, relative.
    """

    coefficients: FloatArray
    lowest: int
    split: int
    error: float

    @property
    def pieces(self) -> int:
        """Number of pieces, of all bands."""
        return int(self.coefficients.shape[0] * self.coefficients.shape[1])

    def __call__(self, x: FloatArray, g: FloatArray) -> FloatArray:
        """Return the quantities (WIDTH, n) at x (n,) and g (n,) or (1,); NaN beyond the table."""
        return both_sides(x, g, np.zeros(0), NOTHING, self, 0.0)

    @property
    def compiled(self) -> tuple[FloatArray, int, int]:
        """What compiled code is handed of a table."""
        return self.coefficients, self.lowest, self.split


# A table without pieces.
NOTHING = Table(coefficients=np.empty((1, 0, 1, DEGREE + 1, WIDTH)), lowest=0, split=1, error=0.0)


def both_sides(
    w: FloatArray,
    g: FloatArray,
    reciprocal: FloatArray,
    below: Table,
    above: Table,
    gap: float,
    *,
    threads: int = 1,
) -> FloatArray:
    """Look up quantities that have one table below a threshold and another above it.

    Parameters
    ----------
    w
        Shape (n,).
    g
        Shape (n,) or (1,).
    reciprocal
        Chebyshev coefficients in g of one over the threshold of w; empty without threshold, where
        ``above`` is a table over w itself.
    below, above
        Tables over w over the threshold, and over that less one.
    gap
        So close below one, the table is not asked.
    threads
        That share the work.

    Returns
    -------
    ndarray
        Shape (WIDTH, n); NaN beyond the tables.
    """
    out = np.empty((WIDTH, w.size))

    def run(part: slice) -> None:
        here = w[part], g if g.size == 1 else g[part]
        _both_sides(*here, reciprocal, *below.compiled, *above.compiled, gap, out, part.start)

    blocks = [slice(start, start + BLOCK) for start in range(0, w.size, BLOCK)]
    if min(threads, len(blocks)) <= 1:
        for block in blocks:
            run(block)
    else:
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(run, blocks))
    return out


def first_above(
    w: FloatArray, g: FloatArray, reciprocal: FloatArray, above: Table, gap: float
) -> FloatArray:
    """Look up the first quantity alone, (n,); it is zero below the threshold. See `both_sides`."""
    out = np.empty(w.size)
    table, lowest, split = above.compiled
    _first_above(w, g, reciprocal, np.ascontiguousarray(table[..., 0]), lowest, split, gap, out)
    return out


@_jit_inline
def _ratio(w, g, reciprocal):  # type: ignore[no-untyped-def]
    """Return w over the threshold, by Clenshaw's sum of its reciprocal."""
    one, two = 0.0, 0.0
    for k in range(reciprocal.size - 1, 0, -1):
        one, two = 2.0 * g * one - two + reciprocal[k], one
    return w * (g * one - two + reciprocal[0])


@_jit_inline
def _at(x, g, coefficients, lowest, split):  # type: ignore[no-untyped-def]
    """Return band and piece (-1: none), and the places within them."""
    mantissa, exponent = math.frexp(x)
    place = (2.0 * mantissa - 1.0) * split
    part = int(place)
    piece = (exponent - lowest) * split + part
    if not (0.0 < x < math.inf and 0 <= piece < coefficients.shape[1]):
        piece = -1
    bands = coefficients.shape[0]
    across = 0.5 * (g + 1.0) * bands
    band = min(max(int(across), 0), bands - 1)
    return band, piece, 2.0 * (place - part) - 1.0, 2.0 * (across - band) - 1.0


@_jit_inline
def _quantities(x, g, coefficients, lowest, split, row):  # type: ignore[no-untyped-def]
    """Write the quantities at one point into ``row``."""
    band, piece, t, along = _at(x, g, coefficients, lowest, split)
    if piece < 0:
        row[0] = math.nan
        return
    last = coefficients.shape[2] - 1
    for lane in range(WIDTH):
        value = coefficients[band, piece, last, DEGREE, lane]
        for k in range(DEGREE):
            value = value * t + coefficients[band, piece, last, DEGREE - 1 - k, lane]
        row[lane] = value
    for j in range(last - 1, -1, -1):
        for lane in range(WIDTH):
            value = coefficients[band, piece, j, DEGREE, lane]
            for k in range(DEGREE):
                value = value * t + coefficients[band, piece, j, DEGREE - 1 - k, lane]
            row[lane] = row[lane] * along + value


@_jit
def _both_sides(  # type: ignore[no-untyped-def]
    w,
    g,
    reciprocal,
    below,
    lowest_below,
    split_below,
    above,
    lowest_above,
    split_above,
    gap,
    out,
    start,
):
    """Write the quantities at w and g into the columns of ``out`` from ``start`` on."""
    if below.shape[3] != DEGREE + 1 or below.shape[4] != WIDTH:
        return  # never: gives the compiler the distance of rows
    if above.shape[3] != DEGREE + 1 or above.shape[4] != WIDTH:
        return
    row = np.empty(WIDTH)
    for i in range(w.size):
        along = g[0] if g.size == 1 else g[i]
        ratio = _ratio(w[i], along, reciprocal) if reciprocal.size else math.inf
        if ratio >= 1.0:
            x = ratio - 1.0 if reciprocal.size else w[i]
            _quantities(x, along, above, lowest_above, split_above, row)
        elif ratio <= 1.0 - gap:
            _quantities(ratio, along, below, lowest_below, split_below, row)
        else:
            row[0] = math.nan
        for lane in range(WIDTH):
            out[lane, start + i] = row[lane]


@_jit
def _first_above(w, g, reciprocal, above, lowest, split, gap, out):  # type: ignore[no-untyped-def]
    if above.shape[3] != DEGREE + 1:
        return
    for i in range(w.size):
        along = g[0] if g.size == 1 else g[i]
        ratio = _ratio(w[i], along, reciprocal) if reciprocal.size else math.inf
        if ratio <= 1.0 - gap:
            out[i] = 0.0
            continue
        x = ratio - 1.0 if reciprocal.size else w[i]
        band, piece, t, across = _at(x, along, above, lowest, split)
        out[i] = math.nan if piece < 0 else 0.0
        for j in range(above.shape[2] - 1, -1, -1):
            value = above[band, piece, j, DEGREE] if piece >= 0 else 0.0
            for k in range(DEGREE):
                value = value * t + above[band, max(piece, 0), j, DEGREE - 1 - k]
            out[i] = out[i] * across + value


def nodes(count: int) -> FloatArray:
    """Chebyshev points in (-1, 1)."""
    return np.asarray(chebyshev.chebpts1(count)) if count > 1 else np.zeros(1)


def between(count: int) -> FloatArray:
    """Points where the error of interpolation through `nodes` is largest: the ends, and between."""
    return np.asarray(chebyshev.chebpts2(count + 1)) if count > 1 else np.zeros(1)


def powers_through_nodes(count: int) -> FloatArray:
    """Matrix that turns values at the nodes into coefficients of powers."""
    inverse = np.linalg.inv(chebyshev.chebvander(nodes(count), count - 1))
    columns = [np.resize(chebyshev.cheb2poly(row), count) for row in np.eye(count)]
    for degree, column in enumerate(columns):
        column[degree + 1 :] = 0.0
    return np.asarray(np.stack(columns, axis=1) @ inverse)


def _places(lowest: int, octaves: int, split: int, points: FloatArray) -> FloatArray:
    """Values of x at points of [-1, 1] within each piece, shape (pieces, points)."""
    part = (np.arange(split)[:, None] + 0.5 * (points + 1.0)) / split
    octave = np.ldexp(0.5, lowest + np.arange(octaves))
    return np.asarray((octave[:, None, None] * (1.0 + part)).reshape(octaves * split, -1))


def piecewise(
    sampled: Sampled, *, lowest: int, octaves: int, split: int, widths: int = 1, bands: int = 1
) -> Table:
    """Return the table of a function.

    Parameters
    ----------
    sampled
        The function; quantities that are not wanted are zero.
    lowest, octaves
        Binary exponent of the first octave of x, in the sense of `math.frexp`, and their number.
    split
        Pieces per octave.
    widths, bands
        Nodes in g in a band, and number of bands.
    """

    def points(along: FloatArray, across: FloatArray) -> tuple[FloatArray, ...]:
        """Places x and g, shape (bands, pieces, across, along)."""
        x = _places(lowest, octaves, split, along)
        g = (2.0 * np.arange(bands)[:, None] + 1.0 + across) / bands - 1.0
        return np.broadcast_arrays(x[None, :, None, :], g[:, None, :, None])

    x, g = points(nodes(DEGREE + 1), nodes(widths))
    table = Table(
        coefficients=np.einsum(
            "jb,ka,lnpba->npjkl",
            powers_through_nodes(widths),
            powers_through_nodes(DEGREE + 1),
            sampled(np.ravel(x), np.ravel(g)).reshape(WIDTH, *x.shape),
            order="C",
        ),
        lowest=lowest,
        split=split,
        error=0.0,
    )
    # The upper end of a piece is the lower of the next: a little inside, the piece is its own.
    inside = 1.0 - 1e-12
    x, g = points(between(DEGREE + 1) * inside, between(widths) * inside)
    expected = sampled(np.ravel(x), np.ravel(g))
    difference = np.abs(table(np.ravel(x), np.ravel(g)) - expected)
    relative = np.divide(difference, np.abs(expected), out=difference, where=expected != 0.0)
    error = float(np.max(relative)) if np.all(np.isfinite(relative)) else math.inf
    return replace(table, error=error)
