"""Restitutions to be fitted: one data set checked, and many in units of their slowest rebounds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import lgamma, log
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.typing import ArrayLike

from microimpact.core.arrays import (
    NON_NEGATIVE,
    POSITIVE,
    FloatArray,
    Numbers,
    Range,
    checked,
)
from microimpact.core.computable import NotComputable
from microimpact.model.empirical.kernel import LEAST_SCATTER, heavy_tails

Places = npt.NDArray[np.intp]
Given = Numbers | ArrayLike

# Beyond these, numbers are not those of an impact, and their ratios not those of a computer.
SPEEDS = Range(lower=1e-9, upper=1e6, lower_closed=True, upper_closed=True)
SPEED_ERRORS = Range(lower=0.0, upper=1e6, lower_closed=True, upper_closed=True)
DIAMETERS = Range(lower=1e-12, upper=1e3, lower_closed=True, upper_closed=True)
# Bounds of relative standard deviations of speed and diameter, and of that which is to be found;
# exponent of v_c in 1/d that few laws exceed, and that few fall short of.
RELATIVE = Range(lower=0.0, upper=0.5, lower_closed=True)
SMALLEST_SIZE_SCATTER, LARGEST_SIZE_SCATTER = 0.002, 0.4
STEEP, FLAT = 1.8, 0.8
# Standard deviations by which no sphere of a set is off.
FAR_OFF = 4.0
FREE = "free"
# Degrees of freedom that are tried; least scale of e where sigma is not given.
FREEDOMS = (2.0, 3.0, 4.0, 6.0, 10.0, 20.0, 100.0)
FREEDOM = Range(lower=1.0, upper=1e6, lower_closed=True, upper_closed=True)
LEAST_SIGMA = 1e-4


def measurements(
    v: Given, e: Given, sigma: Given, e_range: Range, sigma_range: Range
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Check speeds, restitutions and their standard deviations, each (n,).

    Parameters
    ----------
    v
        Normal impact speeds (n,), m/s, within ``SPEEDS``.
    e
        Coefficients of restitution (n,), within ``e_range``.
    sigma
        Standard deviation of e, one number or (n,), within ``sigma_range``.

    Raises
    ------
    TypeError, ValueError
        If an argument does not hold real numbers, or they are out of range, or shapes differ.
    """
    speed = np.atleast_1d(checked("v", v, SPEEDS))
    measured = np.atleast_1d(checked("e", e, e_range))
    spread = np.asarray(checked("sigma", sigma, sigma_range))
    if speed.ndim != 1 or speed.shape != measured.shape:
        raise ValueError(
            f"v and e must be of one shape (n,), got {speed.shape} and {measured.shape}"
        )
    if spread.shape not in {(), speed.shape}:
        raise ValueError(f"sigma must be one number or of shape {speed.shape}, got {spread.shape}")
    return speed, measured, np.broadcast_to(spread, speed.shape)


def scatter_of(
    v: FloatArray, sigma_v: Given | None, d: Given | None, size_scatter: Given | str | None
) -> tuple[FloatArray, bool, float | None] | None:
    """Check errors of speeds and scatter of sizes.

    Parameters
    ----------
    v
        Normal speeds, m/s, (n,).
    sigma_v
        Standard errors of the speeds, m/s; None if not known.
    d
        Diameters, m; None if not known.
    size_scatter
        Relative standard deviation of the diameters, ``"free"``, or None, as of `compare_models`.

    Returns
    -------
    rows, free, diameter
        Rows of `Scatter` (4, n), whether the scatter of size is to be found, and the median
        diameter in m, None if no diameters are given. None instead of all, if nothing is said.

    Raises
    ------
    TypeError, ValueError
        If numbers are out of range, or shapes differ.
    """
    if sigma_v is None and d is None and size_scatter is None:
        return None
    free = isinstance(size_scatter, str)
    if free and size_scatter != FREE:
        raise ValueError(f"size_scatter must be numbers or {FREE!r}, got {size_scatter!r}")
    spread = 0.0 if size_scatter is None else size_scatter
    size = 1.0 if free else checked("size_scatter", spread, RELATIVE)
    speed = checked("sigma_v", 0.0 if sigma_v is None else sigma_v, SPEED_ERRORS)
    diameter = checked("d", 1.0 if d is None else d, DIAMETERS)
    for name, value in {"sigma_v": speed, "d": diameter, "size_scatter": size}.items():
        if np.shape(value) not in {(), v.shape}:
            raise ValueError(
                f"{name} must be one number or of shape {v.shape}, got {np.shape(value)}"
            )
    checked("sigma_v / v", np.divide(speed, v), RELATIVE)
    median = float(np.median(diameter))
    rows = np.log(np.divide(diameter, median)), np.divide(speed, v), size, 1.0
    arrays = np.broadcast_arrays(*rows)
    return np.stack([np.asarray(a, float) for a in arrays]), free, None if d is None else median


def tails_of(tails: float | str | None, *, known: bool) -> Tails | None:
    """Check the degrees of freedom of Student's t.

    Parameters
    ----------
    tails
        Degrees of freedom, ``"free"``, or None, as of `compare_models`.
    known
        Whether sigma of e is given.

    Raises
    ------
    TypeError, ValueError
        If they are out of range.
    """
    if tails is None:
        return None
    if isinstance(tails, str) and tails != FREE:
        raise ValueError(f"tails must be degrees of freedom or {FREE!r}, got {tails!r}")
    freedoms = FREEDOMS if isinstance(tails, str) else (float(checked("tails", tails, FREEDOM)),)
    return Tails(freedoms, known)


def is_contradicted(v: FloatArray, e: FloatArray, rows: FloatArray) -> bool:
    """Tell whether captures lie farther above rebounds than errors and sizes allow, for any v_c.

    Parameters
    ----------
    v, e
        Normal speeds, m/s, and restitutions, (n,).
    rows
        Rows of `Scatter`, (4, n).
    """
    log_d, speed, size, _ = rows
    if np.all(e > 0.0):
        return False
    for exponent in np.linspace(FLAT, STEEP, 6):
        middle = np.log(v) + exponent * log_d
        off = FAR_OFF * np.hypot(speed, exponent * size) + LEAST_SCATTER
        if np.max((middle - off)[e == 0.0]) <= np.min((middle + off)[e > 0.0]):
            return False
    return True


def require_telling(v: FloatArray, e: FloatArray, points: int, different: int) -> None:
    """Refuse data with fewer points, or different speeds, from the slowest rebound upwards.

    Parameters
    ----------
    v, e
        Normal speeds, m/s, and restitutions, (n,).
    points
        Least number of points from the slowest rebound upwards.
    different
        Least number of different speeds among these.

    Raises
    ------
    ValueError
        If there are fewer, or no sphere rebounds.
    """
    if not np.any(e > 0.0):
        raise NotComputable("e must be positive somewhere: no sphere rebounds")
    slowest = float(v[e > 0.0].min())
    telling = v[v >= slowest]
    for least, number, what in (
        (points, telling.size, "points"),
        (different, np.unique(telling).size, "different speeds"),
    ):
        if number < least:
            raise NotComputable(
                f"v must hold at least {least} {what} from the smallest rebounding speed "
                f"{slowest:g} m/s upwards, got {number}"
            )


ARRAYS = ("v", "e", "weight", "unit", "top")


class Scatter(NamedTuple):
    """Errors of speeds and scatter of sizes in r data sets."""

    # ln of the diameter over the median one; relative standard deviations of speed and of
    # diameter, or of a scatter of size to be found, its pattern; number of measurements (r, 4, n).
    rows: FloatArray
    free_size: bool  # Whether the scatter of size is to be found
    free_sigma: bool  # Whether sigma of e is
    contradicted: bool = False  # Whether that of size is, since the one stated cannot be


class Tails(NamedTuple):
    """Student's t in place of the normal distribution of e."""

    freedoms: tuple[float, ...]  # Degrees of freedom to choose from
    known: bool  # Whether sigma is given, below which no scale is taken

    def density(self) -> FloatArray:
        """Freedoms, and -2 ln of their densities' factors less those of a normal one, (k, 2)."""
        rows = [
            (nu, 2.0 * (lgamma(0.5 * nu) - lgamma(0.5 * (nu + 1.0))) + log(0.5 * nu) - 1.0)
            for nu in self.freedoms
        ]
        return np.array(rows)

    def likeliest(self, missed: FloatArray, count: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Deviance, scale and freedom (m, 3), and weights of the squares of residuals (m, n).

        Parameters
        ----------
        missed
            Residuals over sigma, (m, n).
        count
            Number of rebounds among them, of a shape that broadcasts to (m,).
        """
        student, weights = np.empty((len(missed), 3)), np.empty(missed.shape)
        number = np.array(np.broadcast_to(np.asarray(count, float), len(missed)))
        least = 1.0 if self.known else LEAST_SIGMA
        heavy_tails(np.ascontiguousarray(missed), number, self.density(), least, student, weights)
        return student, weights


@dataclass(frozen=True, slots=True, kw_only=True)
class DataSets:
    """Data sets (r, n), checked, in units of the slowest rebounding speed of each."""

    v: FloatArray  # Speeds (r, n)
    e: FloatArray  # Coefficients of restitution (r, n)
    weight: FloatArray  # 1/sigma, 0 for a datum that is not there (r, n)
    # The slowest rebounding speed (r,), m/s, and the largest speed in its units.
    unit: FloatArray
    top: FloatArray
    q: float | None  # Exponent of Eq. (33), or None where it is free.
    scatter: Scatter | None = None  # None: speeds are exact and all spheres of one size
    tails: Tails | None = None  # None: e is normal

    def select(self, rows: slice | Places) -> DataSets:
        """Index the data sets."""
        scatter = self.scatter and self.scatter._replace(rows=self.scatter.rows[rows])
        arrays = {name: getattr(self, name)[rows] for name in ARRAYS}
        return DataSets(**arrays, q=self.q, scatter=scatter, tails=self.tails)

    def split(self) -> list[DataSets]:
        """The data sets one by one."""
        return [self.select(slice(i, i + 1)) for i in range(len(self.unit))]

    @property
    def reach(self) -> FloatArray:
        """Largest v_c (r,): the slowest rebound, or more where that may be of a large sphere."""
        if self.scatter is None:
            return np.ones(self.unit.shape)
        sizes, speeds, spreads, _ = np.abs(np.moveaxis(self.scatter.rows, 1, 0)).max(axis=2)
        spreads = LARGEST_SIZE_SCATTER if self.scatter.free_size else spreads
        wide = 4.0 * np.hypot(speeds, STEEP * spreads)
        return np.asarray(np.exp(np.minimum(wide, 1.0) + STEEP * sizes))

    @property
    def free(self) -> int:
        """Number of free parameters."""
        return 5 if self.q is None else 4


def data_sets(v: ArrayLike, e: ArrayLike, weight: ArrayLike, q: float | None = None) -> DataSets:
    """Check data sets and scale them to their slowest rebounds.

    Parameters
    ----------
    v
        Normal impact speeds, (n,) or (r, n), m/s; positive.
    e
        Coefficients of restitution (r, n), 0 or more; 0 for a captured sphere.
    weight
        1/sigma, of a shape that broadcasts to (r, n); 0 leaves a datum out.
    q
        Exponent of Eq. (33), positive; None: free.

    Raises
    ------
    TypeError
        If an argument does not hold real numbers.
    ValueError
        If a number is out of range, or a data set has no more points than free parameters from its
        smallest rebounding speed upwards.
    """
    measured = np.atleast_2d(checked("e", e, NON_NEGATIVE))
    speed = np.broadcast_to(checked("v", v, POSITIVE), measured.shape)
    weights = np.broadcast_to(checked("weight", weight, NON_NEGATIVE), measured.shape)
    if q is not None:
        checked("q", q, POSITIVE)
    sets = in_own_units(speed, measured, weights, q)
    telling = np.sum((weights > 0.0) & (sets.v >= 1.0), axis=1)
    if np.any(telling <= sets.free):
        few = int(np.argmin(telling))
        raise NotComputable(
            f"e: data set {few} must hold at least {sets.free + 1} points from the smallest "
            f"rebounding speed upwards, one more than free parameters, got {telling[few]}"
        )
    return sets


def in_own_units(v: FloatArray, e: FloatArray, weight: FloatArray, q: float | None) -> DataSets:
    """Scale r checked data sets to their slowest rebounds.

    Parameters
    ----------
    v, e
        Normal speeds, m/s, and restitutions, (r, n).
    weight
        1/sigma of e, 0 where a point is missing, (r, n).
    q
        Exponent of Eq. (33), or None where it is free.
    """
    unit = np.where((weight > 0.0) & (e > 0.0), v, np.inf).min(axis=1)
    ratio = v / unit[:, None]
    top = np.where(weight > 0.0, ratio, 0.0).max(axis=1)
    return DataSets(v=ratio, e=e, weight=weight, unit=unit, top=top, q=q)


def stacked_sets(parts: Sequence[DataSets]) -> DataSets:
    """Join data sets of one number of points and one q into a batch."""
    arrays = {name: np.concatenate([getattr(part, name) for part in parts]) for name in ARRAYS}
    scatter = parts[0].scatter
    if scatter is not None:
        rows = [part.scatter.rows for part in parts if part.scatter is not None]
        scatter = scatter._replace(rows=np.concatenate(rows))
    return DataSets(**arrays, q=parts[0].q, scatter=scatter, tails=parts[0].tails)
