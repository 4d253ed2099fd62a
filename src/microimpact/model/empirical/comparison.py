"""Capture velocity from restitutions by several models, and an interval that rests on no one.

Each model of e(v) has its own profile of chi-square over v_c. Models are weighted by Akaike's
criterion, corrected for few data where sigma is estimated (AICc; Burnham and Anderson 2002). The
interval is that of averaged tail areas (Fletcher and Turek 2012): what the models' signed roots of
chi-square leave beyond an end, averaged with these weights, is half of what the confidence leaves.
The study `fit_coverage` tells how often it holds the true v_c.

The laws of contact need no material here: see `microimpact.model.empirical.shapes`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from typing import NamedTuple

import numpy as np
import scipy

from microimpact.core.arrays import FloatArray, Numbers, Range, checked
from microimpact.core.solve import root
from microimpact.model.empirical import shapes
from microimpact.model.empirical.data import (
    DataSets,
    in_own_units,
    measurements,
    require_telling,
)
from microimpact.model.empirical.equations import restitution
from microimpact.model.empirical.kernel import V_C
from microimpact.model.empirical.search import STARTS, Found, profile

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
# Models lighter than this change no digit.
WEIGHTLESS = 1e-14
# Shares by which tests reject: misfit, residuals in runs.
REJECTED = 0.01


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


# Of one data set, v_c (m,) in its unit, and variables (s, m, 5) to start from, if any.
Profile = Callable[[DataSets, FloatArray, FloatArray], Found]


def _empirical(q: float | None, data: DataSets, v_c: FloatArray, starts: FloatArray) -> Found:
    """Profile of Eq. (34)."""
    fresh, owner = 0 if len(starts) else len(STARTS), np.zeros(v_c.size, np.intp)
    return profile(replace(data, q=q), owner, 1.0 - v_c, *starts, fresh=fresh)


def _of_law(name: str, data: DataSets, v_c: FloatArray, starts: FloatArray) -> Found:
    """Profile of a law of contact."""
    return shapes.profile(name, data.v[0], data.e[0], data.weight[0], v_c, *starts)


def _eq_34(x: FloatArray, v_c: float, v: FloatArray) -> FloatArray:
    """Return Eq. (34) at speeds (n,), of logarithms of k, p, kappa and q."""
    k, p, kappa, q = np.exp(x[:V_C])
    return restitution(v, k, p, kappa, q, v_c)


def _by_law(name: str, x: FloatArray, v_c: float, v: FloatArray) -> FloatArray:
    """Return e of a law of contact at speeds (n,)."""
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
    level = float(checked("confidence", confidence, CONFIDENCE))
    given = sigma is not None
    speed, measured, spread = measurements(v, e, 1.0 if sigma is None else sigma, FRACTION, SPREAD)
    require_telling(speed, measured, FEWEST, FEWEST - 1)
    order = np.argsort(speed, kind="stable")[None]
    data = in_own_units(speed[order], measured[order], 1.0 / spread[order], None)
    count = int(np.sum(data.v >= 1.0))
    for name in models or ():
        if name not in CANDIDATES:
            raise ValueError(f"models: {name!r} must be one of {'; '.join(CANDIDATES)}")
    asked = {name: CANDIDATES[name] for name in models or CANDIDATES}
    spare = 0 if given else 2  # AICc divides by what is left
    tried = {name: of for name, of in asked.items() if count > of.free + spare}
    if not tried:
        fewest = 1 + spare + min(of.free for of in asked.values())
        raise ValueError(
            f"v must hold at least {fewest} points from the smallest rebounding speed upwards for "
            f"these models, got {count}"
        )
    free = np.array([of.free for of in tried.values()])
    drawn = [_drawn(partial(of.profile, data), count - of.free, given) for of in tried.values()]
    least = np.array([found.chi_square.min() for found in drawn])
    leftover = least / (count - free)  # variance of e in units of sigma squared
    criterion = _criterion(least, free, count, given)
    best = int(np.argmin(criterion))
    weights = np.exp(-0.5 * (criterion - criterion[best]))
    weights /= weights.sum()
    widened = max(1.0, float(leftover[best]))
    # With sigma known the signed roots are normal; else, of Student's distribution.
    freedom = np.full(free.size, np.inf) if given and widened == 1.0 else count - free
    variances = np.full(free.size, widened) if given else leftover
    tails = [_Tail(*each) for each in zip(drawn, variances, freedom, strict=True)]
    half, unit = 0.5 * (1.0 - level), float(data.unit[0])

    telling = [(w, of) for w, of in zip(weights, tails, strict=True) if w > WEIGHTLESS]

    def averaged(v_c: float) -> float:
        return float(sum(w * tail(v_c) for w, tail in telling))

    fitted = [
        Model(
            name=name,
            free=of.free,
            v_c=unit * found.v_c,
            interval=(unit * tails[k].quantile(half), unit * tails[k].quantile(1.0 - half)),
            chi_square=float(least[k]) if given else None,
            criterion=float(criterion[k] - criterion[best]),
            weight=float(weights[k]),
            law=partial(_in_metres, of, found, unit),
        )
        for k, ((name, of), found) in enumerate(zip(tried.items(), drawn, strict=True))
    ]
    fitted.sort(key=lambda model: model.criterion)
    _require_a_curve(data, fitted[0])
    low, v_c, high = (unit * _quantile(averaged, level) for level in (half, 0.5, 1.0 - half))
    interval = low, high
    return Comparison(
        models=tuple(fitted),
        v_c=v_c,
        v_c_interval=interval,
        confidence=level,
        sigma=float(np.sqrt(leftover[best])) if not given else None,
        scatter=float(np.sqrt(leftover[best])) if given else 1.0,
        warnings=tuple(_warnings(data, fitted, v_c, interval)),
    )


def _in_metres(of: Candidate, found: _Drawn, unit: float, v: FloatArray) -> FloatArray:
    return of.restitution(found.x, found.v_c, np.asarray(v) / unit)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Drawn:
    """A profile: v_c in the data's unit, chi-square (g,); the variables (5,) at the best v_c."""

    values: FloatArray
    chi_square: FloatArray
    v_c: float
    x: FloatArray


def _drawn(of: Callable[[FloatArray, FloatArray], Found], freedom: int, given: bool) -> _Drawn:
    """Draw a profile, closer and closer about its low part."""
    # v_c, chi-square and the variables in columns.
    first = np.append(FIRST_VALUES[:-1:APART], GREATEST)
    rows = np.column_stack([first, *of(first, np.zeros((0, 0, 0)))[:2]])
    for number in range(ROUNDS + 1):
        values, chi_square = rows.T[:2]
        lowest = float(chi_square.min())
        unit = max(1.0, lowest / freedom) if given else max(lowest / freedom, TINY)
        low = np.flatnonzero(chi_square - lowest < NEGLIGIBLE * unit)
        ends = values[max(low[0] - 1, 0)], values[min(low[-1] + 1, values.size - 1)]
        fresh = np.linspace(*ends, VALUES)[1:-1] if number else FIRST_VALUES
        after = np.searchsorted(values, fresh)
        fresh, after = (of[values[after] != fresh] for of in (fresh, after))
        # Neighbours on both sides are close starts.
        found = of(fresh, rows[[after - 1, after], 2:])
        rows = np.insert(rows, after, np.column_stack([fresh, *found[:2]]), axis=0)
    values, chi_square = np.ascontiguousarray(rows.T[:2])
    at = int(np.argmin(chi_square))
    return _Drawn(values=values, chi_square=chi_square, v_c=float(values[at]), x=rows[at, 2:])


class _Tail:
    """Share of the probability of v_c below a value, by the signed root of chi-square's rise."""

    def __init__(self, drawn: _Drawn, variance: float, freedom: float) -> None:
        at = int(np.searchsorted(drawn.values, drawn.v_c))
        rise = np.sqrt((drawn.chi_square - drawn.chi_square.min()) / max(variance, TINY))
        # Beyond a valley counts what lies lower further out: the profile of a missed minimum.
        below = np.minimum.accumulate(rise[: at + 1])
        above = np.minimum.accumulate(rise[at:][::-1])[::-1]
        self.values, self.freedom = drawn.values, freedom
        self.roots = np.concatenate([-below[:-1], above])

    def __call__(self, v_c: float) -> float:
        return float(scipy.special.stdtr(self.freedom, np.interp(v_c, self.values, self.roots)))

    def quantile(self, level: float) -> float:
        """Return the v_c below which so large a share lies; 0 or 1 where the range sets it."""
        here = float(scipy.special.stdtrit(self.freedom, level))
        if not self.roots[0] < here < self.roots[-1]:
            return float(here >= self.roots[-1])
        return float(np.interp(here, self.roots, self.values))


def _quantile(share: Callable[[float], float], level: float) -> float:
    """Return the v_c below which so large a share lies; 0 or 1 where the range sets it."""
    if share(LEAST) >= level:
        return 0.0
    if share(GREATEST) <= level:
        return 1.0
    return root(lambda v_c: share(v_c) - level, LEAST, GREATEST, absolute=1e-9)


def _criterion(least: FloatArray, free: FloatArray, count: int, given: bool) -> FloatArray:
    """Akaike's criterion; that for few data where sigma is estimated, too.

    With sigma too small for every model, chi-square counts in units of what the best leaves.
    """
    if given:
        return np.asarray(least / max(1.0, float(np.min(least / (count - free)))) + 2.0 * free)
    numbers = free + 1
    loss = count * np.log(np.maximum(least, TINY) / count)
    return np.asarray(loss + 2.0 * numbers * count / (count - numbers - 1.0))


def _missed(data: DataSets, model: Model) -> tuple[FloatArray, FloatArray]:
    """Return e from the slowest rebound upwards, and what the model leaves of it."""
    telling = data.v[0] >= 1.0
    e = data.e[0, telling]
    return e, e - model.law(data.unit * data.v[0, telling])


def _require_a_curve(data: DataSets, model: Model) -> None:
    """Refuse data that no model describes better than chance would."""
    e, missed = _missed(data, model)
    scatter = float(np.sqrt(np.mean(missed**2)))
    if scatter > WILD and np.sum(missed**2) > 0.5 * np.sum((e - e.mean()) ** 2):
        raise ValueError(
            f"e must depend on v as a rebound does: the closest of all models leaves a scatter of "
            f"{scatter:.2g}, and explains less than half of the variance"
        )


def _warnings(
    data: DataSets, models: list[Model], v_c: float, interval: tuple[float, float]
) -> Iterator[str]:
    yield from _about_the_fit(data, models[0])
    heavy = [model for model in models if model.weight >= LIGHT]
    for one, other in combinations(heavy, 2):
        if one.interval[0] > other.interval[1] or other.interval[0] > one.interval[1]:
            yield f"models disagree: {one.name} and {other.name} have intervals that do not meet"
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


def _about_the_fit(data: DataSets, best: Model) -> Iterator[str]:
    _, missed = _missed(data, best)
    if best.chi_square is None:
        yield "sigma is not given, so that no misfit can be told from noise"
    elif scipy.special.chdtrc(freedom := missed.size - best.free, best.chi_square) < REJECTED:
        yield (
            f"the scatter about the best model is {np.sqrt(best.chi_square / freedom):.2g} times "
            "the sigma given: the intervals are widened by that"
        )
    if _runs(missed) < REJECTED:
        yield "residuals of one sign come in runs: no model has the shape of the data"


def _runs(missed: FloatArray) -> float:
    """Return how often chance alone gives so few runs of signs (Wald and Wolfowitz 1940)."""
    above = missed > 0.0
    more, less = int(above.sum()), int((~above).sum())
    total = more + less
    if min(more, less) < 2:
        return 1.0
    runs = 1 + int(np.sum(above[1:] != above[:-1]))
    mean = 1.0 + 2.0 * more * less / total
    variance = (mean - 1.0) * (mean - 2.0) / (total - 1.0)
    return float(scipy.special.ndtr((runs + 0.5 - mean) / np.sqrt(variance)))
