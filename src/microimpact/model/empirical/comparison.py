"""Capture velocity from restitutions by several models, and a model-averaged interval.

Each model of e(v) has its own profile of chi-square over v_c. Models are weighted by Akaike's
criterion, corrected for few data where sigma is estimated (AICc; Burnham and Anderson 2002). The
interval is that of averaged tail areas (Fletcher and Turek 2012): what the models' signed roots of
chi-square leave beyond an end, averaged with these weights, is half of what the confidence leaves.
The study `fit_coverage` tells how often it holds the true v_c.

The laws of contact need no material here: see `microimpact.model.empirical.shapes`.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from typing import NamedTuple

import numpy as np
import scipy

from microimpact.core.arrays import FloatArray, Numbers, Range, checked
from microimpact.core.solve import roots
from microimpact.model.empirical import shapes
from microimpact.model.empirical.data import (
    DataSets,
    Places,
    in_own_units,
    measurements,
    require_telling,
    stacked_sets,
)
from microimpact.model.empirical.equations import restitution
from microimpact.model.empirical.kernel import V_C
from microimpact.model.empirical.search import STARTS, Minima, profile

CONFIDENCE = Range(lower=0.0, upper=1.0)
FRACTION = Range(lower=0.0, upper=1.0, lower_closed=True, upper_closed=True)
SPREAD = Range(lower=0.0, upper=1.0, upper_closed=True)
# Data from the slowest rebound upwards: fewer leave no model a degree of freedom.
FEWEST = 5
# A scatter of e above this, where no model explains half of the variance, is no curve.
WILD = 0.15
# Within this factor of v_c a speed is near capture.
NEAR = 1.3
TINY = 1e-300
# v_c is sought between these shares of the smallest rebounding speed.
LEAST, GREATEST = 1e-3, 1.0 - 1e-6
# Values of v_c in a profile, at first every third of them, for then there are neighbours to start
# from; it is drawn anew so many times, each about where chi-square is low.
VALUES, APART, ROUNDS = 24, 3, 2
_CLOSE = 1.0 - np.geomspace(1.0 - GREATEST, 0.05, VALUES // 3)
FIRST_VALUES = np.append(
    np.linspace(LEAST, 0.95, VALUES - _CLOSE.size, endpoint=False), _CLOSE[::-1]
)
# Rise of chi-square, in units of what one parameter adds, at which nothing of v_c is left.
NEGLIGIBLE = 30.0
# Models lighter than this are left out of words.
LIGHT = 0.05
# Shares by which tests reject: misfit, residuals in runs, a stray row.
REJECTED = 0.01
# Rows that a message names at most.
NAMED = 3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Model:
    """One model fitted to the data.

    Attributes
    ----------
    name
        What it is.
    free
        Number of free parameters.
    v_c, interval
        Capture velocity and its profile interval by this model alone, m/s. An end may be that of
        the range, 0 or the smallest rebounding speed.
    chi_square
        Least sum of squares over sigma, or None where sigma is not given.
    criterion
        AIC, or AICc where sigma is not given, less that of the best model.
    weight
        Akaike's weight; all sum to 1.
    law
        e at normal speeds (n,), m/s.
    """

    name: str
    free: int
    v_c: float
    interval: tuple[float, float]
    chi_square: float | None
    criterion: float
    weight: float
    law: Callable[[FloatArray], FloatArray]


# Data sets, the one of each search (m,), v_c (m,) in its unit, and variables (s, m, 5) to start
# from, if any.
Profile = Callable[[DataSets, Places, FloatArray, FloatArray], Minima]


def _empirical(
    q: float | None, data: DataSets, owner: Places, v_c: FloatArray, starts: FloatArray
) -> Minima:
    """Profile of Eq. (34)."""
    fresh = 0 if len(starts) else len(STARTS)
    return profile(replace(data, q=q), owner, 1.0 - v_c, *starts, fresh=fresh)


def _of_law(
    name: str, data: DataSets, owner: Places, v_c: FloatArray, starts: FloatArray
) -> Minima:
    """Profile of a law of contact."""
    return shapes.profile(name, data, owner, v_c, *starts)


def _eq_34(x: FloatArray, v_c: float, v: FloatArray) -> FloatArray:
    """Eq. (34) at speeds (n,), by logarithms of k, p, kappa and q."""
    k, p, kappa, q = np.exp(x[:V_C])
    return restitution(v, k, p, kappa, q, v_c)


def _by_law(name: str, x: FloatArray, v_c: float, v: FloatArray) -> FloatArray:
    """Coefficients of restitution of a law of contact at speeds (n,)."""
    return shapes.restitution(name, x, v / v_c)


class Candidate(NamedTuple):
    """A model to be tried: free parameters with v_c, profile, e of its variables, v_c and v."""

    free: int
    profile: Profile
    restitution: Callable[[FloatArray, float, FloatArray], FloatArray]


CANDIDATES = {
    "Eq. 34, q free": Candidate(5, partial(_empirical, None), _eq_34),
    "Eq. 34, q = 1/2": Candidate(4, partial(_empirical, 0.5), _eq_34),
} | {
    name: Candidate(law.free + 1, partial(_of_law, name), partial(_by_law, name))
    for name, law in shapes.LAWS.items()
}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Comparison:
    """Models of one data set side by side, and v_c from all of them.

    Attributes
    ----------
    models
        The best first.
    v_c, v_c_interval
        Median and interval of the averaged tail areas, m/s.
    confidence
        Nominal coverage of all intervals.
    sigma
        Standard deviation of e that the best model leaves, where none is given; else None.
    scatter
        The same over the sigma given, or 1.
    warnings
        What speaks against trusting the interval, in sentences.
    """

    models: tuple[Model, ...]
    v_c: float
    v_c_interval: tuple[float, float]
    confidence: float
    sigma: float | None
    scatter: float
    warnings: tuple[str, ...]


def compare_models(
    v: Numbers,
    e: Numbers,
    sigma: Numbers | None = None,
    *,
    confidence: float = 0.95,
    models: Sequence[str] | None = None,
) -> Comparison:
    """Find the capture velocity from restitutions by all models, and an interval of their average.

    Where the best model leaves more scatter than sigma admits, sigma is taken larger by that much.

    Parameters
    ----------
    v
        Normal impact speeds (n,), m/s; repeats are welcome.
    e
        Coefficients of restitution (n,), in [0, 1]; 0 for a captured sphere.
    sigma
        Standard deviation of e, one number or (n,); None: one for all, estimated.
    confidence
        Coverage of the intervals, in (0, 1).
    models
        Names of the models to be tried, of `CANDIDATES`; None: all.

    Raises
    ------
    TypeError, ValueError
        If a model is unknown, numbers are out of range or too few, no sphere rebounds, or e hardly
        depends on v in the way that a rebound does.
    """
    return compare_sets([(v, e, sigma)], confidence=confidence, models=models)[0]


def compare_sets(
    sets: Sequence[tuple[Numbers, Numbers, Numbers | None]],
    *,
    confidence: float = 0.95,
    models: Sequence[str] | None = None,
) -> list[Comparison]:
    """Compare models of many data sets, each speeds, restitutions and sigma, by `compare_models`.

    Sets with as many points, and as many of them from the slowest rebound upwards, are searched
    side by side. Arguments and errors are the same.
    """
    level = float(checked("confidence", confidence, CONFIDENCE))
    alike: dict[tuple[int, int, bool], list[tuple[int, DataSets, Places]]] = defaultdict(list)
    for number, (v, e, sigma) in enumerate(sets):
        known = sigma is not None
        spread = 1.0 if sigma is None else sigma
        speed, measured, spread = measurements(v, e, spread, FRACTION, SPREAD)
        require_telling(speed, measured, FEWEST, FEWEST - 1)
        order = np.argsort(speed, kind="stable")
        row = order[None]
        data = in_own_units(speed[row], measured[row], 1.0 / spread[row], None)
        alike[speed.size, int(np.sum(data.v >= 1.0)), known].append((number, data, order + 1))
    for name in models or ():
        if name not in CANDIDATES:
            raise ValueError(f"models: {name!r} must be one of {'; '.join(CANDIDATES)}")
    candidates = {name: CANDIDATES[name] for name in models or CANDIDATES}
    comparisons: dict[int, Comparison] = {}
    for (_, count, known), members in alike.items():
        numbers, parts, rows = zip(*members, strict=True)
        compared = _compared(stacked_sets(parts), rows, count, known, level, candidates)
        comparisons |= zip(numbers, compared, strict=True)
    return [comparisons[number] for number in range(len(sets))]


def _compared(
    sets: DataSets,
    rows: Sequence[Places],
    count: int,
    known: bool,
    level: float,
    candidates: dict[str, Candidate],
) -> list[Comparison]:
    """Compare models of data sets that each hold ``count`` points from the slowest rebound up.

    ``rows`` are the numbers (n,), from 1, that the points of each set had before they were sorted.
    """
    spare = 0 if known else 2  # AICc divides by what is left
    tried = {name: model for name, model in candidates.items() if count > model.free + spare}
    if not tried:
        fewest = 1 + spare + min(model.free for model in candidates.values())
        raise ValueError(
            f"v must hold at least {fewest} points from the smallest rebounding speed upwards for "
            f"these models, got {count}"
        )
    free = np.array([model.free for model in tried.values()])[:, None]
    drawn = [_drawn(model.profile, sets, count - model.free, known) for model in tried.values()]
    profiles, v_c = (np.stack([getattr(best, name) for best in drawn]) for name in ("rows", "v_c"))
    least = profiles[..., 1].min(axis=2)
    leftover = least / (count - free)  # variance of e in units of sigma squared
    criterion = _criterion(least, free, count, known)
    best, every = np.argmin(criterion, axis=0), np.arange(len(sets.unit))
    criterion = criterion - criterion[best, every]
    weights = np.exp(-0.5 * criterion)
    weights /= weights.sum(axis=0)
    scatter = leftover[best, every]
    widened = np.maximum(1.0, scatter)
    # With sigma known the signed roots are normal; else, of Student's distribution.
    freedom = np.where(known & (widened == 1.0), np.inf, count - free)
    tails = _Tails(profiles, v_c, widened if known else leftover, freedom)
    half = 0.5 * (1.0 - level)
    alone = sets.unit * np.stack([tails.quantiles(half), tails.quantiles(1.0 - half)])
    low, middle, high = (
        sets.unit * _averaged(weights, tails, share) for share in (half, 0.5, 1.0 - half)
    )
    compared = []
    for i, unit in enumerate(sets.unit):
        fitted = [
            Model(
                name=name,
                free=candidate.free,
                v_c=float(unit * v_c[k, i]),
                interval=(float(alone[0, k, i]), float(alone[1, k, i])),
                chi_square=float(least[k, i]) if known else None,
                criterion=float(criterion[k, i]),
                weight=float(weights[k, i]),
                law=partial(_in_metres, candidate, drawn[k].x[i], float(v_c[k, i]), float(unit)),
            )
            for k, (name, candidate) in enumerate(tried.items())
        ]
        fitted.sort(key=lambda model: model.criterion)
        data, interval = sets.select(slice(i, i + 1)), (float(low[i]), float(high[i]))
        residuals = _residuals(data, rows[i], fitted[0])
        _require_a_curve(residuals)
        compared.append(
            Comparison(
                models=tuple(fitted),
                v_c=float(middle[i]),
                v_c_interval=interval,
                confidence=level,
                sigma=float(np.sqrt(scatter[i])) if not known else None,
                scatter=float(np.sqrt(scatter[i])) if known else 1.0,
                warnings=tuple(_warnings(data, fitted, residuals, float(middle[i]), interval)),
            )
        )
    return compared


def _in_metres(
    candidate: Candidate, x: FloatArray, v_c: float, unit: float, v: FloatArray
) -> FloatArray:
    return candidate.restitution(x, v_c, np.asarray(v) / unit)


class _Drawn(NamedTuple):
    """Profiles of r data sets: v_c in their units and chi-square, and where that is least."""

    rows: FloatArray  # v_c and chi-square (r, g, 2)
    v_c: FloatArray  # The best (r,)
    x: FloatArray  # The variables there (r, 5)


def _drawn(search: Profile, sets: DataSets, freedom: int, known: bool) -> _Drawn:
    """Draw profiles, closer and closer about their low parts."""
    every = np.arange(len(sets.unit))

    def searched(owner: Places, v_c: FloatArray, starts: FloatArray) -> FloatArray:
        """v_c, chi-square and the variables of each search (m, 7)."""
        return np.column_stack([v_c, *search(sets, owner, v_c, starts)[:2]])

    first = np.append(FIRST_VALUES[:-1:APART], GREATEST)
    owner, v_c = np.repeat(every, first.size), np.tile(first, every.size)
    rows = searched(owner, v_c, np.zeros((0, 0, 0))).reshape(every.size, first.size, -1)
    between = np.tile(np.setdiff1d(FIRST_VALUES, first), (every.size, 1))
    for _ in range(ROUNDS + 1):
        # Neighbours on both sides are close starts; a value that is there already stays as it is.
        after = np.sum(rows[:, None, :, 0] < between[..., None], axis=2)
        before, more = (rows[every[:, None], at] for at in (after - 1, after))
        new = more[..., 0] != between
        starts = np.stack([before[new, 2:], more[new, 2:]])
        more[new] = searched(np.nonzero(new)[0], between[new], starts)
        rows = np.concatenate([rows, more], axis=1)
        rows = np.take_along_axis(rows, np.argsort(rows[..., :1], axis=1, kind="stable"), axis=1)
        rise = rows[..., 1] - (lowest := rows[..., 1].min(axis=1, keepdims=True))
        unit = np.maximum(lowest / freedom, 1.0 if known else TINY)
        low, last = rise < NEGLIGIBLE * unit, rows.shape[1] - 1
        ends = low.argmax(axis=1) - 1, last - low[:, ::-1].argmax(axis=1) + 1
        start, stop = (rows[every, np.clip(end, 0, last), 0] for end in ends)
        between = np.linspace(start, stop, VALUES, axis=1)[:, 1:-1]
    at = rows[every, np.argmin(rows[..., 1], axis=1)]
    return _Drawn(rows=rows[..., :2], v_c=at[:, 0], x=at[:, 2:])


class _Tails:
    """Shares of the probability of v_c below a value, by the signed root of chi-square's rise.

    Of k models and r data sets: profiles (k, r, g, 2), the best v_c (k, r), and variance and
    degrees of freedom, of shapes that broadcast to (k, r).
    """

    def __init__(
        self, profiles: FloatArray, v_c: FloatArray, variance: FloatArray, freedom: FloatArray
    ) -> None:
        self.values, chi_square = np.moveaxis(profiles, -1, 0)
        self.freedom = np.broadcast_to(freedom, v_c.shape)
        rise = chi_square - chi_square.min(axis=-1, keepdims=True)
        rise = np.sqrt(rise / np.maximum(variance, TINY)[..., None])
        # Beyond a valley counts what lies lower further out: the profile of a missed minimum.
        below = self.values < v_c[..., None]
        outer = np.minimum.accumulate(np.where(below, rise, np.inf), axis=-1)
        inner = np.minimum.accumulate(np.where(below, np.inf, rise)[..., ::-1], axis=-1)
        self.roots = np.where(below, -outer, inner[..., ::-1])

    def below(self, v_c: FloatArray, rows: Places) -> FloatArray:
        """Shares (k, m) of the probability below v_c (m,) in data sets (m,)."""
        root = _interpolated(v_c, self.values[:, rows], self.roots[:, rows])
        return np.asarray(scipy.special.stdtr(self.freedom[:, rows], root))

    def quantiles(self, level: float) -> FloatArray:
        """Quantiles (k, r) of v_c; 0 or 1 where the range sets them."""
        here = np.asarray(scipy.special.stdtrit(self.freedom, level), float)
        v_c = _interpolated(here, self.roots, self.values)
        v_c = np.where(here > self.roots[..., 0], v_c, 0.0)
        return np.where(here < self.roots[..., -1], v_c, 1.0 * (here >= self.roots[..., -1]))


def _interpolated(x: FloatArray, points: FloatArray, values: FloatArray) -> FloatArray:
    """Interpolate values at x (...) linearly between points that grow along the last axis."""
    after = np.sum(points < x[..., None], axis=-1, keepdims=True).clip(1, points.shape[-1] - 1)
    (x_0, x_1), (y_0, y_1) = (
        [np.take_along_axis(array, at, axis=-1)[..., 0] for at in (after - 1, after)]
        for array in (points, values)
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(y_0 + (x - x_0) * ((y_1 - y_0) / (x_1 - x_0)))


def _averaged(weights: FloatArray, tails: _Tails, level: float) -> FloatArray:
    """Quantiles (r,) of v_c by averaged tail areas; 0 or 1 where the range ends."""

    def excess(v_c: FloatArray, rows: Places) -> FloatArray:
        return np.asarray(np.sum(weights[:, rows] * tails.below(v_c, rows), axis=0) - level)

    every = np.arange(weights.shape[1])
    bottom, top = (excess(np.full(every.size, end), every) for end in (LEAST, GREATEST))
    v_c = np.where(bottom >= 0.0, 0.0, 1.0)
    within = np.flatnonzero((bottom < 0.0) & (top > 0.0))
    v_c[within] = roots(excess, LEAST, GREATEST, within, absolute=1e-9)
    return v_c


def _criterion(least: FloatArray, free: FloatArray, count: int, known: bool) -> FloatArray:
    """Akaike's criterion; that for few data where sigma is estimated, too.

    With sigma too small for every model, chi-square counts in units of what the best leaves.
    """
    if known:
        unit = np.maximum(1.0, np.min(least / (count - free), axis=0))
        return np.asarray(least / unit + 2.0 * free)
    numbers = free + 1
    loss = count * np.log(np.maximum(least, TINY) / count)
    return np.asarray(loss + 2.0 * numbers * count / (count - numbers - 1.0))


class _Residuals(NamedTuple):
    """Data (m,) from the slowest rebound upwards, and their residuals from a model."""

    rows: Places  # Numbers of the rows as they were passed, from 1
    v: FloatArray  # m/s
    e: FloatArray
    missed: FloatArray  # e less the model
    in_sigma: FloatArray  # The same over sigma; if sigma is not given, over that of all other rows

    def largest(self, least: float = 0.0) -> str:
        """Rows of the largest residuals, in words, if these are at least so many sigma."""
        size = np.abs(self.in_sigma)
        words = ", ".join(
            f"row {self.rows[i]} (v = {self.v[i]:.4g} m/s, e = {self.e[i]:.3g}, "
            f"{self.in_sigma[i]:+.1f} sigma)"
            for i in np.argsort(-size, kind="stable")[:NAMED]
            if size[i] >= least
        )
        return f"; largest residuals: {words}" if words else ""


def _residuals(data: DataSets, rows: Places, model: Model) -> _Residuals:
    telling = data.v[0] >= 1.0
    v, e = data.unit * data.v[0, telling], data.e[0, telling]
    missed = e - model.law(v)
    in_sigma = missed * data.weight[0, telling]
    if model.chi_square is None:
        squares = np.maximum(np.sum(missed**2) - missed**2, TINY)
        in_sigma = missed / np.sqrt(squares / (e.size - model.free - 1))
    return _Residuals(rows[telling], v, e, missed, in_sigma)


def _require_a_curve(residuals: _Residuals) -> None:
    """Refuse data that no model describes better than chance would."""
    e, missed = residuals.e, residuals.missed
    scatter = float(np.sqrt(np.mean(missed**2)))
    if scatter > WILD and np.sum(missed**2) > 0.5 * np.sum((e - e.mean()) ** 2):
        raise ValueError(
            f"e must depend on v as a rebound does: the closest of all models leaves a scatter of "
            f"{scatter:.2g}, and explains less than half of the variance{residuals.largest()}"
        )


def _warnings(
    data: DataSets,
    models: list[Model],
    residuals: _Residuals,
    v_c: float,
    interval: tuple[float, float],
) -> Iterator[str]:
    yield from _about_the_fit(models[0], residuals)
    heavy = [model for model in models if model.weight >= LIGHT]
    for first, second in combinations(heavy, 2):
        if first.interval[0] > second.interval[1] or second.interval[0] > first.interval[1]:
            yield f"models disagree: {first.name} and {second.name} have intervals that do not meet"
    if len(heavy) == 1 < len(models):
        yield (
            f"one model alone, {models[0].name}, carries the interval, which supposes it true: of "
            "another curve such an interval is too narrow"
        )
    slowest = float(data.unit[0])
    captured = slowest * data.v[data.e == 0.0]
    if slowest > NEAR * v_c and not (captured > v_c / NEAR).any():
        yield (
            f"no speed is near capture: the slowest rebound has {slowest:.3g} m/s"
            f"{f', {slowest / v_c:.2g} times v_c' if v_c > 0.0 else ', v_c is 0'}"
        )
    if (nearest := max(captured, default=0.0)) > slowest:
        yield (
            f"captures up to {nearest:.3g} m/s and rebounds from {slowest:.3g} m/s on overlap: "
            "the spheres or the places do not share one v_c"
        )
    if interval[0] == 0.0:
        yield "the data do not bound v_c from below"
    if interval[1] == slowest:
        yield "the upper end is the slowest rebound itself"


def _about_the_fit(best: Model, residuals: _Residuals) -> Iterator[str]:
    missed, freedom = residuals.missed, residuals.missed.size - best.free
    if best.chi_square is None:
        # So far out lies one row in that share of all data sets (Bonferroni).
        stray = float(scipy.special.stdtrit(freedom - 1, 1.0 - 0.5 * REJECTED / missed.size))
        yield (
            "sigma is not given, so that no misfit can be told from noise"
            f"{residuals.largest(stray)}"
        )
    elif scipy.special.chdtrc(freedom, best.chi_square) < REJECTED:
        yield (
            f"the scatter about the best model is {np.sqrt(best.chi_square / freedom):.3g} times "
            f"the sigma given: the intervals are widened by that{residuals.largest()}"
        )
    if _runs(missed) < REJECTED:
        yield "residuals of one sign come in runs: no model has the shape of the data"


def _runs(missed: FloatArray) -> float:
    """Probability of so few runs of signs by chance (Wald and Wolfowitz 1940)."""
    above = missed > 0.0
    more, less = int(above.sum()), int((~above).sum())
    total = more + less
    if min(more, less) < 2:
        return 1.0
    runs = 1 + int(np.sum(above[1:] != above[:-1]))
    mean = 1.0 + 2.0 * more * less / total
    variance = (mean - 1.0) * (mean - 2.0) / (total - 1.0)
    return float(scipy.special.ndtr((runs + 0.5 - mean) / np.sqrt(variance)))
