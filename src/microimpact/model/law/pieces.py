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
from functools import cache
from itertools import product

import numpy as np
from numpy.polynomial import chebyshev

from microimpact.core.arrays import FloatArray, Range
from microimpact.model import passes
from microimpact.model.law.families import NoTableError
from microimpact.model.passes import DEGREE, WIDTH

# Impacts that one call of the compiled code computes; threads share them out.
BLOCK = 1 << 15

# Pieces per octave that are tried in turn, until the error is within the tolerance.
SPLITS, TOLERANCES = (1, 2, 4, 8), Range(lower=0.0, upper=1.0)
SAFETY = 2.0  # the error stated over that measured between the nodes
WIDTHS = 6  # nodes in a band
# Nodes of a speed over g.
SPEED_WIDTHS = (8, 11, 15, 20, 30, 45, 60)
# Arguments of the compiled look-up.
Compiled = tuple[FloatArray | tuple[int, ...] | float, ...]
# Of x and g, arrays of one shape (n,), the quantities (WIDTH, n).
Sampled = Callable[[FloatArray, FloatArray], FloatArray]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Table:
    """Polynomials in x and g."""

    # Of powers of the places within band and piece, (bands, pieces, widths, WIDTH, DEGREE + 1);
    # bands are equal parts of g's interval.
    coefficients: FloatArray
    lowest: int  # Binary exponent of the first octave
    split: int  # Pieces per octave
    error: float  # Largest relative difference from the function between the nodes, or its bound

    @property
    def pieces(self) -> int:
        """Number of pieces, of all bands."""
        return int(self.coefficients.shape[0] * self.coefficients.shape[1])

    def __call__(self, x: FloatArray, g: FloatArray) -> FloatArray:
        """Return the quantities (WIDTH, n) at x (n,) and g (n,) or (1,); NaN beyond the table."""
        out = np.empty((WIDTH, x.size))
        passes.look_up(x, g, compiled(np.zeros(0), NOTHING, self, 0.0, 0.0), out, 0)
        return out


# A table without pieces.
NOTHING = Table(coefficients=np.empty((1, 0, 1, WIDTH, DEGREE + 1)), lowest=0, split=1, error=0.0)


def compiled(
    slowness: FloatArray, captures: Table, rebounds: Table, gap: float, error: float
) -> Compiled:
    """Arguments of the compiled look-up: polynomials of both tables row by row.

    Parameters
    ----------
    slowness
        Chebyshev coefficients in g of one over the threshold of x; empty without threshold, where
        ``rebounds`` is a table over x itself.
    captures, rebounds
        Tables over x over the threshold, and over that less one.
    gap
        Distance below the threshold within which the table is not asked.
    error
        Bound of the relative errors.
    """
    tables = captures, rebounds
    rows = [t.coefficients.reshape(-1, *t.coefficients.shape[2:]) for t in tables if t.pieces]
    first = 0, captures.pieces
    whole = [
        (n, *t.coefficients.shape[:2], t.lowest, t.split)
        for n, t in zip(first, tables, strict=True)
    ]
    return slowness, np.concatenate(rows or [NOTHING.coefficients[0]]), *whole, gap, error


def in_blocks(run: Callable[[slice], object], count: int, threads: int) -> None:
    """Call a function for all blocks of impacts.

    Parameters
    ----------
    run
        Takes the slice of a block.
    count
        Number of impacts.
    threads
        Threads that share the blocks.
    """
    blocks = [slice(start, min(start + BLOCK, count)) for start in range(0, count, BLOCK)]
    if min(threads, len(blocks)) <= 1:
        for block in blocks:
            run(block)
    else:
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(run, blocks))


def nodes(count: int) -> FloatArray:
    """Chebyshev points in (-1, 1)."""
    return np.asarray(chebyshev.chebpts1(count)) if count > 1 else np.zeros(1)


def between(count: int) -> FloatArray:
    """Points where the error of interpolation through `nodes` is largest: the ends, and between."""
    return np.asarray(chebyshev.chebpts2(count + 1)) if count > 1 else np.zeros(1)


@cache
def powers_through_nodes(count: int) -> FloatArray:
    """Matrix that turns values at the nodes into coefficients of powers."""
    inverse = np.linalg.inv(chebyshev.chebvander(nodes(count), count - 1))
    columns = [np.resize(chebyshev.cheb2poly(row), count) for row in np.eye(count)]
    for degree, column in enumerate(columns):
        column[degree + 1 :] = 0.0
    return np.asarray(np.stack(columns, axis=1) @ inverse)


def slowness(
    speeds: Callable[[FloatArray], FloatArray], tolerance: float, *, alike: bool
) -> FloatArray:
    """Chebyshev coefficients in g of the reciprocal of a speed, which is nearly linear.

    Parameters
    ----------
    speeds
        The speed at places g; it must be finite and positive.
    tolerance
        Largest relative error.
    alike
        Whether it is the same at all.

    Raises
    ------
    NoTableError
        If it is infinite somewhere, or varies too much.
    """
    for count in (1,) if alike else SPEED_WIDTHS:
        values = speeds(nodes(count))
        if not np.all(np.isfinite(values)):
            raise NoTableError("at no speed does a sphere of these contacts rebound")
        coefficients = chebyshev.chebfit(nodes(count), 1.0 / values, count - 1)
        held_out = between(count)
        product = chebyshev.chebval(held_out, coefficients) * speeds(held_out)
        if np.max(np.abs(product - 1.0)) <= tolerance:
            return np.asarray(coefficients)
    raise NoTableError(
        "the speeds of these contacts differ by too much: take fewer sizes at a time"
    )


def _places(lowest: int, octaves: int, split: int, points: FloatArray) -> FloatArray:
    """Values of x at points of [-1, 1] within each piece, shape (pieces, points)."""
    part = (np.arange(split)[:, None] + 0.5 * (points + 1.0)) / split
    octave = np.ldexp(0.5, lowest + np.arange(octaves))
    return np.asarray((octave[:, None, None] * (1.0 + part)).reshape(octaves * split, -1))


def _piecewise(
    sampled: Sampled, octaves: tuple[int, int], split: int, bands: int, widths: int
) -> Table:
    """Table of a function, see `smallest`; quantities that are not needed are zero."""

    def points(along: FloatArray, across: FloatArray) -> tuple[FloatArray, ...]:
        """Places x and g, shape (bands, pieces, across, along)."""
        x = _places(*octaves, split, along)
        g = (2.0 * np.arange(bands)[:, None] + 1.0 + across) / bands - 1.0
        return np.broadcast_arrays(x[None, :, None, :], g[:, None, :, None])

    x, g = points(nodes(DEGREE + 1), nodes(widths))
    table = Table(
        coefficients=np.einsum(
            "jb,ka,lnpba->npjlk",
            powers_through_nodes(widths),
            powers_through_nodes(DEGREE + 1),
            sampled(np.ravel(x), np.ravel(g)).reshape(WIDTH, *x.shape),
            order="C",
        ),
        lowest=octaves[0],
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


def smallest(
    sampled: Sampled,
    octaves: tuple[int, int],
    tolerance: float,
    splits: tuple[int, ...] = SPLITS,
    bands: tuple[int, ...] = (1,),
    widths: int = 1,
    error: Callable[[Table], float] = lambda table: table.error,
) -> Table:
    """Smallest table of a function that reaches a tolerance.

    Parameters
    ----------
    sampled
        The function.
    octaves
        Binary exponent of the first octave of x, as of `math.frexp`, and their number.
    tolerance
        Largest error, which is stated `SAFETY` times as large as measured.
    splits, bands
        Pieces per octave and bands of g that are tried in turn.
    widths
        Nodes in g in a band.
    error
        Measure of a table's error, which the table states; that between the nodes if not given.

    Raises
    ------
    NoTableError
        If no table does.
    """
    least = math.inf
    for split, band in product(splits, bands):
        table = _piecewise(sampled, octaves, split, band, widths)
        stated = SAFETY * error(table)
        if stated <= tolerance:
            return replace(table, error=stated)
        least = min(least, stated)
    raise NoTableError(
        f"no table reaches the tolerance {tolerance:g}; the closest comes to {least:.1g}: "
        "give a larger one, or sizes and speeds that are closer together"
    )
