"""Restitution averaged over spheres of several sizes and speeds with errors, and its search.

v/v_c of a sphere is not that of the median one at the measured speed: v_c falls with the diameter,
by each law's own exponent, and speeds have errors. Both together are normal in ln(v/v_c). The
damping of a law, in units of the contact, changes with the diameter, too. The likelihood of a
measured e is its average over that, on condition that the sphere rebounds where the data hold no
captured ones: small spheres are missing there. Where they hold some, all are supposed to be
recorded, and their probability counts.

With heavy tails e scatters about that of its sphere as of Student's t, while sizes and speeds stay
normal. Its scale is searched, not below a sigma that is stated; so are degrees of freedom that are
free. The little that sizes add at a fixed v/v_c widens the scale, which is exact of normal
densities alone.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy

from microimpact.core.arrays import FloatArray
from microimpact.model.empirical import shapes
from microimpact.model.empirical.data import (
    LARGEST_SIZE_SCATTER,
    SMALLEST_SIZE_SCATTER,
    DataSets,
    Places,
    Scatter,
)
from microimpact.model.empirical.kernel import (
    BY_SIZE,
    FREEDOM,
    LN_SIGMA,
    LN_SIZE,
    PARAMETERS,
    SCATTERED,
    Q,
    deviance,
    deviances,
)
from microimpact.model.empirical.search import (
    EXPONENT_BOUNDS,
    K_BOUNDS,
    KAPPA_BOUNDS,
    STARTS,
    Box,
    Minima,
    Objective,
    lowest,
)

# Dahneke (1971): a sphere is held by a force that grows with d, and its mass with d^3.
EXPONENT_OF_EQ_34 = 1.0
SIGMA_BOUNDS, LARGEST_LN_SCALE = (1e-4, 0.5), np.log(1e12)
# Where searches begin: sigma of e, scatter of size.
FIRST_SIGMA, FIRST_SIZE = 0.03, 0.05
# Degrees of freedom where searches begin, if these are free.
FIRST_FREEDOM = 4.0
# Starts from which a search is made, with neighbours in v_c and without.
NEAR, FRESH = 1, 2
# From this number of measurements on, a search begins with classes of them.
MANY = 500
# Classes of speed, and the shares at which e is cut in each, so that strays remain.
SPEED_CLASSES, SHARES_OF_E = 48, (0.03, 0.3, 0.7, 0.97)
# A search ends where a step lowers the deviance by less.
SMALL = 1e-2
_SCALE = (shapes.RATIOS - 1) / np.sqrt(np.log(shapes.LARGEST_RATIO))


# The exponents in d of Eq. (34) alone, in place of a table.
_NO_TABLE = np.array([EXPONENT_OF_EQ_34, 0.0, 0.0]).reshape(1, 1, 1, BY_SIZE)


def _table(law: str | None) -> FloatArray:
    return _NO_TABLE if law is None else shapes.table(law)


def size_exponent(law: str | None, x: FloatArray) -> float:
    """Exponent of v_c in 1/d, of given materials.

    Parameters
    ----------
    law
        One of `shapes.LAWS`, or None for Eq. (34).
    x
        Variables of a search, (3 or more,).
    """
    exponents = _table(law)[..., -BY_SIZE]
    at = np.minimum(x[:PARAMETERS], np.array(exponents.shape) - 1.0)[:, None]
    return float(scipy.ndimage.map_coordinates(exponents, at, order=1, mode="nearest")[0])


def _data(sets: DataSets, scatter: Scatter) -> FloatArray:
    """Data as the search takes them (r, 7, n)."""
    rows = [np.log(sets.v), *np.moveaxis(scatter.rows, 1, 0), sets.e, 1.0 / sets.weight]
    return np.ascontiguousarray(np.stack(rows, axis=1))


def condensed(sets: DataSets) -> DataSets:
    """Means of neighbours in speed and e, where there are many: searches among them are quick.

    Parameters
    ----------
    sets
        Data sets with their scatter.
    """
    scatter, most = sets.scatter, SPEED_CLASSES * (2 + len(SHARES_OF_E))
    assert scatter is not None
    if sets.v.shape[1] < MANY:
        return sets
    # Columns are ln v and e, the rows of the scatter, and 1/sigma; captured spheres are apart.
    every = np.concatenate(
        [np.log(sets.v)[:, None], sets.e[:, None], scatter.rows, sets.weight[:, None]], axis=1
    )
    parts = []
    for columns in every:
        speed, e = columns[0] + columns[2], columns[1]
        classes: list[Places] = []
        for rows, shares in ((e == 0.0, ()), (e > 0.0, SHARES_OF_E)):
            order = np.flatnonzero(rows)[np.argsort(speed[rows], kind="stable")]
            for group in np.array_split(order, SPEED_CLASSES):
                cuts = np.ceil(np.multiply(shares, group.size)).astype(int)
                classes += np.array_split(group[np.argsort(e[group], kind="stable")], cuts)
        means = [columns[:, group].mean(axis=1) for group in classes if group.size]
        part = np.stack(means, axis=1)
        part[5] = [group.size for group in classes if group.size]
        # All data sets of a batch are of one length.
        empty = np.repeat(part[:, :1], most - part.shape[1], axis=1)
        empty[5] = 0.0
        parts.append(np.concatenate([part, empty], axis=1))
    log_v, e, *rows, weight = np.moveaxis(np.array(parts), 1, 0)
    fewer = scatter._replace(rows=np.stack(rows, axis=1))
    return replace(sets, v=np.exp(log_v), e=e, weight=weight, scatter=fewer)


def _box(law: str | None, q: float | None, sets: DataSets) -> FloatArray:
    """Bounds of the variables and the largest steps (3, 7)."""
    scatter, tails = sets.scatter, sets.tails
    assert scatter is not None
    box = np.zeros((3, SCATTERED))
    if law is None:
        exponents = (q, q) if q else EXPONENT_BOUNDS
        bounds = K_BOUNDS, EXPONENT_BOUNDS, KAPPA_BOUNDS, exponents
        box[:2, : Q + 1] = np.log(bounds).T
        box[2, : Q + 1] = 2.0
    else:
        box[1, :PARAMETERS] = np.array(_table(law).shape[:PARAMETERS]) - 1.0
        box[2, :PARAMETERS] = shapes.LONGEST * box[1, :PARAMETERS]
    if tails is not None:
        box[:2, FREEDOM] = min(tails.freedoms), max(tails.freedoms)
        box[:, LN_SIGMA] = 0.0, LARGEST_LN_SCALE, 1.0
    if scatter.free_sigma:
        box[:, LN_SIGMA] = *np.log(SIGMA_BOUNDS), 1.0
    if scatter.free_size:
        box[:, LN_SIZE] = *np.log([SMALLEST_SIZE_SCATTER, LARGEST_SIZE_SCATTER]), 1.0
    return box


def _starts(
    law: str | None, q: float | None, top: FloatArray, v_c: FloatArray, box: FloatArray
) -> FloatArray:
    """Starts (s, m, 7) that depend on no other search."""
    if law is None:
        rows = [
            [k * top, np.full_like(top, p), 0.3 * v_c, np.full_like(top, q or exponent)]
            for k, p, exponent, _ in STARTS
        ]
        first = np.log(np.moveaxis(np.array(rows), 1, -1))
    else:
        shares = np.array(shapes.LAWS[law].starts) * box[1, :PARAMETERS]
        first = np.repeat(shares[:, None], top.size, axis=1)
    starts = np.zeros((*first.shape[:2], SCATTERED))
    starts[..., : first.shape[2]] = first
    starts[..., FREEDOM] = np.clip(FIRST_FREEDOM, *box[:2, FREEDOM])
    if box[0, LN_SIGMA] < 0.0:
        starts[..., LN_SIGMA] = np.log(FIRST_SIGMA)
    if box[2, LN_SIZE]:
        starts[..., LN_SIZE] = np.log(FIRST_SIZE)
    return starts


def profile(
    law: str | None,
    q: float | None,
    sets: DataSets,
    owner: Places,
    v_c: FloatArray,
    starts: FloatArray,
) -> Minima:
    """Search with v_c held; v_c may exceed the slowest rebound, of a sphere larger than most.

    Parameters
    ----------
    law
        One of `shapes.LAWS`; None: Eq. (34), with ``q`` held if that is given.
    sets, owner
        The data, with their scatter, and the data set of each search (m,).
    v_c
        Capture velocities of the median sphere (m,), in units of the slowest rebounds.
    starts
        Variables (s, m, 7) to start from; empty: from those of the law.

    Returns
    -------
    Minima
        Of the deviance; where sigma is searched, less the number of data, and where it is not
        given with the factor of `_likelihood`.
    """
    scatter, tails = sets.scatter, sets.tails
    assert scatter is not None
    low, high, stride = box = _box(law, q, sets)
    fresh = not len(starts)
    begun = _starts(law, q, sets.top[owner], v_c, box) if fresh else starts
    many = v_c.size, 1
    bounds = Box(np.tile(low, many), np.tile(high, many), stride)
    objective = _likelihood(law, sets, owner, v_c)
    if tails is None or len(tails.freedoms) == 1:
        return lowest(objective, begun, bounds, 0.0, SMALL, FRESH if fresh else NEAR)
    # A search keeps its degrees of freedom: all are tried, the likeliest followed.
    if fresh:
        begun = lowest(objective, begun, bounds, 0.0, SMALL, FRESH).x[None]
    begun = np.repeat(begun, len(tails.freedoms), axis=0)
    begun[..., FREEDOM] = np.resize(tails.freedoms, len(begun))[:, None]
    return lowest(objective, begun, bounds, 0.0, SMALL, None if fresh else NEAR + 1)


def _likelihood(law: str | None, sets: DataSets, owner: Places, v_c: FloatArray) -> Objective:
    """Deviance of searches, each with its data set and v_c held, (m,), as of `profile`.

    Few data can be explained by sizes and speeds alone, and with a sigma to be found the likelihood
    has no bound where that is none. So each scatter has a factor then that is proportional to it
    (Chung et al. 2013).
    """
    scatter = sets.scatter
    assert scatter is not None
    table, data = _table(law), _data(sets, scatter)
    free_size, free_sigma = scatter.free_size, scatter.free_sigma
    # Of n data without scatter the deviance is n (ln(sum of squares/n) + 1).
    searched = free_sigma or sets.tails is not None
    number = searched * np.sum(scatter.rows[:, -1] * (sets.v >= 1.0), axis=1)
    unknown = [LN_SIGMA, LN_SIZE][: 1 + free_size]
    usual = np.log([FIRST_SIGMA, FIRST_SIZE][: 1 + free_size])

    def objective(x: FloatArray, rows: Places) -> tuple[FloatArray, FloatArray, FloatArray]:
        total, slope, information = (
            np.empty(len(x)),
            np.empty(x.shape),
            np.empty((*x.shape, SCATTERED)),
        )
        searches = owner[rows], v_c[rows], np.ascontiguousarray(x)
        deviances(table, _SCALE, data, *searches, total, slope, information)
        total -= number[searches[0]]
        if free_sigma:
            total -= 2.0 * (x[:, unknown] - usual).sum(axis=1)
            slope[:, unknown] -= 1.0
        return total, slope, information

    return objective


def deviance_at(
    law: str | None, sets: DataSets, owner: Places, v_c: FloatArray, x: FloatArray
) -> FloatArray:
    """Deviance (m,), as of `profile`, at capture velocities (m,) and variables (m, 7).

    Parameters
    ----------
    law
        One of `shapes.LAWS`, or None for Eq. (34).
    sets, owner
        Data sets with their scatter, and the number of that of each deviance, (m,).
    v_c
        Capture velocities of the median sphere, in the unit of the speeds, (m,).
    x
        Variables of the search, (m, 7).
    """
    return _likelihood(law, sets, owner, v_c)(x, np.arange(len(x)))[0]


def expected(law: str | None, sets: DataSets, v_c: float, x: FloatArray) -> FloatArray:
    """Mean and variance (n, 2) of e of the rebounds of one data set; zeros of captured spheres.

    Parameters
    ----------
    law
        One of `shapes.LAWS`, or None for Eq. (34).
    sets
        A single data set with its scatter.
    v_c
        Capture velocity of the median sphere, in the unit of the speeds.
    x
        Variables of the search, (7,).
    """
    assert sets.scatter is not None
    moments = np.empty((sets.v.shape[1], 2))
    gradient, information = np.empty(SCATTERED), np.empty((SCATTERED, SCATTERED))
    data = _data(sets, sets.scatter)[0]
    deviance(_table(law), _SCALE, data, v_c, x, gradient, information, moments)
    return moments
