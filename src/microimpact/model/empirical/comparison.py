"""Capture velocity from restitutions by several models, and a model-averaged interval.

Each model of e(v) has its own profile of chi-square over v_c. Models are weighted by Akaike's
criterion, corrected for few data where sigma is estimated (AICc; Burnham and Anderson 2002). The
interval is that of averaged tail areas (Fletcher and Turek 2012): what the models' signed roots of
chi-square leave beyond an end, averaged with these weights, is half of what the confidence leaves.
`python -m benchmarks.coverage` tells how often it holds the true v_c.

The laws of contact need no material here: see `microimpact.model.empirical.shapes`.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import combinations
from typing import Any, Literal, NamedTuple

import numpy as np
import scipy

from microimpact.core.arrays import BoolArray, FloatArray, Numbers, Range, checked
from microimpact.core.computable import NotComputable
from microimpact.core.readable import Readable, precise, table
from microimpact.core.solve import roots
from microimpact.model.choices import NOISE
from microimpact.model.empirical import scatter, shapes
from microimpact.model.empirical.data import (
    DataSets,
    Places,
    Scatter,
    in_own_units,
    is_contradicted,
    measurements,
    require_telling,
    scatter_of,
    stacked_sets,
    tails_of,
)
from microimpact.model.empirical.equations import restitution
from microimpact.model.empirical.kernel import FREEDOM, LN_SIGMA, LN_SIZE, SCATTERED, V_C
from microimpact.model.empirical.scatter import FIRST_SIZE
from microimpact.model.empirical.search import STARTS, Minima, profile

CONFIDENCE = Range(lower=0.0, upper=1.0)
FRACTION = Range(lower=0.0, upper=1.0, lower_closed=True, upper_closed=True)
SPREAD = Range(lower=1e-12, upper=1.0, lower_closed=True, upper_closed=True)
# Data from the slowest rebound upwards: fewer leave no model a degree of freedom.
FEWEST = 5
# A scatter of e above this, where no model explains half of the variance, is no curve.
WILD = 0.15
# Within this factor of v_c a speed is near capture.
NEAR = 1.3
# Numbers below the first count as it; logarithms above the second as that.
TINY, LARGEST_LOG = 1e-300, 600.0
# v_c is sought between these shares of the smallest rebounding speed.
LEAST, GREATEST = 1e-3, 1.0 - 1e-6
# Values of v_c in a profile, at first every third of them, for then there are neighbours to start
# from; then the rounds in which it is drawn anew where chi-square is low.
VALUES, APART, ROUNDS = 24, 3, 2
# Largest distance of neighbours where chi-square is low, over the mean distance.
SPARSE = 2.0
_CLOSE = 1.0 - np.geomspace(1.0 - GREATEST, 0.05, VALUES // 3)
FIRST_VALUES = np.append(
    np.linspace(LEAST, 0.95, VALUES - _CLOSE.size, endpoint=False), _CLOSE[::-1]
)
# Rise of chi-square, in units of what one parameter adds, at which nothing of v_c is left.
NEGLIGIBLE = 30.0
# Shares of v_c, found with speeds exact and one size, at which data are searched for a scatter.
NEARBY = np.array([0.85, 1.0, 1.1, 1.25, 1.45])
# A scatter of v/v_c that few measurements fall short of: a narrow class of spheres has 2 % or more.
LIKELY_SCATTER = 0.02
# Models lighter than this are left out of words.
LIGHT = 0.05
# Shares by which tests reject: misfit, residuals in runs, a stray row.
REJECTED = 0.01
# Rows this many sigma off count little under Student's t.
STRAY = 4.0
# Rows that a message names at most.
NAMED = 3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class Model(Readable):
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
    size_exponent
        n of v_c ~ d^n by this model, of given materials, near the median diameter.
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
    size_exponent: float
    law: Callable[[FloatArray], FloatArray] = field(repr=False)


class Candidate(NamedTuple):
    """A model to be tried."""

    free: int  # Free parameters with v_c
    law: str | None  # One of `shapes.LAWS`; None: Eq. (34)
    q: float | None = None  # Its exponent, or None where it is free

    def profile(self, data: DataSets, owner: Places, v_c: FloatArray, starts: FloatArray) -> Minima:
        """Search with v_c (m,) held in data sets (m,), from variables (s, m, ...), if any.

        Parameters
        ----------
        data
            Data sets.
        owner
            Number of the data set of each search, (m,).
        v_c
            Capture velocities held, in units of the slowest rebounds, (m,).
        starts
            Variables to begin from, (s, m, ...); none for the search's own.
        """
        if data.scatter is not None:
            return scatter.profile(self.law, self.q, data, owner, v_c, starts)
        if self.law is not None:
            return shapes.profile(self.law, data, owner, v_c, starts)
        fresh = 0 if len(starts) else len(STARTS)
        return profile(replace(data, q=self.q), owner, 1.0 - v_c, *starts, fresh=fresh)

    def restitution(self, x: FloatArray, v_c: float, v: FloatArray) -> FloatArray:
        """Restitution at speeds (n,) by the variables of a search.

        Parameters
        ----------
        x
            Variables of a search.
        v_c
            Capture velocity, m/s.
        v
            Normal speeds, m/s, (n,).
        """
        if self.law is not None:
            return shapes.restitution(self.law, x, v / v_c)
        k, p, kappa, q = np.exp(x[:V_C])
        return restitution(v, k, p, kappa, q, v_c)


CANDIDATES = {
    "Eq. 34, q free": Candidate(5, None),
    "Eq. 34, q = 1/2": Candidate(4, None, 0.5),
} | {name: Candidate(law.free + 1, name) for name, law in shapes.LAWS.items()}
# Models of the average whose coverage benchmarks/coverage has.
AVERAGED = tuple(name for name in CANDIDATES if name != shapes.EDGE)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class Comparison(Readable):
    """Models of one data set side by side, and v_c from all of them; prints as a table.

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
    tails
        Degrees of freedom of Student's t by the best model, of which sigma is the scale; None: e is
        taken as normal.
    exact
        Whether speeds were taken as exact and all spheres as of one size.
    diameter
        Median diameter, whose v_c this is, m; None where no diameters are given.
    size_scatter
        Relative standard deviation of the diameter by the best model, if that was to be found.
    left_out
        Names of the models that need more rows than there are.
    warnings
        What speaks against trusting the interval, in sentences.
    """

    models: tuple[Model, ...] = field(repr=False)
    v_c: float
    v_c_interval: tuple[float, float]
    confidence: float
    sigma: float | None
    scatter: float
    exact: bool
    diameter: float | None
    size_scatter: float | None
    tails: float | None = None
    left_out: tuple[str, ...] = ()
    warnings: tuple[str, ...] = field(repr=False)

    def summary(self) -> str:
        """Models with their intervals and weights, v_c of all, and assumptions, as text."""
        criterion = "AIC" if self.sigma is None and self.tails is None else "AICc"
        header = ("model", "v_c (m/s)", "from", "to", "free", "chi2", criterion, "weight")
        rows = (
            (
                model.name,
                *with_interval(model.v_c, model.interval),
                str(model.free),
                "" if model.chi_square is None else f"{model.chi_square:.1f}",
                f"{model.criterion:.1f}",
                f"{model.weight:.2f}",
            )
            for model in self.models
        )
        v_c, low, high = with_interval(self.v_c, self.v_c_interval)
        return (
            f"{table(rows, header)}\n"
            f"v_c = {v_c} m/s, {100 * self.confidence:g} %: {low} to {high} m/s, averaged over the "
            "models by weight.\n"
            f"On condition that one of them has the shape of the true curve{self._assumptions()}."
        )

    def _assumptions(self) -> str:
        """Assumptions on speeds and sizes, as the end of a sentence."""
        heavy = ""
        if self.tails is not None:
            scale = f"{self.scatter:.3g} sigma" if self.sigma is None else f"{self.sigma:.2g}"
            heavy = f";\ne scatters by {scale}, as of Student's t with {self.tails:g} degrees"
        if self.exact:
            return f"{heavy}; speeds and sizes are taken as exact"
        words = f"{heavy},\naveraged over the errors of speed and the sizes"
        if self.size_scatter is not None:
            words += f"; these scatter by {100.0 * self.size_scatter:.2g} %"
        if self.diameter is not None:
            words += f"; v_c is that of the median sphere of {1e6 * self.diameter:.4g} um"
        return words


def require_names(key: str, names: Iterable[str], known: Iterable[str]) -> None:
    """Refuse a name that is not known.

    Parameters
    ----------
    key
        What the names are of, for the message.
    names, known
        The names, and those among which they must be.

    Raises
    ------
    ValueError
        Naming the first that is not known, and all that are.
    """
    for name in names:
        if name not in known:
            raise ValueError(f"{key}: {name!r} must be one of {'; '.join(known)}")


def with_interval(value: float, interval: tuple[float, float]) -> list[str]:
    """Format a number and the ends of its interval.

    Parameters
    ----------
    value, interval
        The number, and the ends.
    """
    low, high = interval
    return [precise(number, high - low) for number in (value, low, high)]


def compare_models(
    v: Numbers,
    e: Numbers,
    sigma: Numbers | None = None,
    sigma_v: Numbers | None = None,
    d: Numbers | None = None,
    size_scatter: Numbers | Literal["free"] | None = None,
    *,
    confidence: float = 0.95,
    models: Sequence[str] | None = None,
    tails: float | Literal["free"] | None = None,
) -> Comparison:
    """Find the capture velocity from restitutions by all models, and an interval of their average.

    Where the best model leaves more scatter than sigma admits, sigma is taken larger by that much.
    Without `sigma_v`, `d` and `size_scatter` speeds are taken as exact, and spheres as of one size;
    with one of them models are averaged as `microimpact.model.empirical.scatter` says. If captures
    then lie above rebounds that should be captured too, the scatter of size is found instead.

    Parameters
    ----------
    v
        Normal impact speeds (n,), m/s; repeats are welcome.
    e
        Coefficients of restitution (n,), in [0, 1], or above by three sigma; 0 for a captured
        sphere.
    sigma
        Standard deviation of e, one number or (n,), 1e-12 to 1; None: one for all, estimated.
    sigma_v
        Standard deviation of v, m/s, one number or (n,); None: 0.
    d
        Diameters of the spheres, m, one number or (n,): v_c is that of the median one.
    size_scatter
        Relative standard deviation of the diameters, or of their errors where `d` is of each
        sphere, one number or (n,); ``"free"``: to be found; None: 0.
    confidence
        Coverage of the intervals, in (0, 1).
    models
        Names of the models to be tried, of `CANDIDATES`; None: those of `AVERAGED`.
    tails
        Degrees of freedom of Student's t, 1 or more, by which e scatters, so that stray rows count
        little; ``"free"``: to be found; None: e is normal. Sigma is then its scale, which is found
        if sigma is not given, and not taken as smaller if it is.

    Raises
    ------
    TypeError, ValueError
        If a model is unknown, numbers are out of range or too few, no sphere rebounds, or e hardly
        depends on v in the way that a rebound does.
    RuntimeError
        If the calculation goes wrong.
    """
    return compare_sets(
        [(v, e, sigma, sigma_v, d, size_scatter)],
        confidence=confidence,
        models=models,
        tails=tails,
    )[0]


def compare_sets(
    sets: Sequence[tuple[Any, ...]],
    *,
    confidence: float = 0.95,
    models: Sequence[str] | None = None,
    tails: float | Literal["free"] | None = None,
) -> list[Comparison]:
    """Compare models of many data sets.

    Sets with as many points, and as many of them from the slowest rebound upwards, are searched
    side by side. Errors are those of `compare_models`.

    Parameters
    ----------
    sets
        Positional arguments of `compare_models`, a tuple for each data set.
    confidence, models, tails
        As of `compare_models`.
    """
    level = float(checked("confidence", confidence, CONFIDENCE))
    alike: dict[Any, list[tuple[int, DataSets, Places, float | None]]] = defaultdict(list)
    for number, each in enumerate(sets):
        data, order, known, diameter = _checked(*each)
        heavy = tails_of(tails, known=known)
        data, known = replace(data, tails=heavy), known and heavy is None
        said = data.scatter and data.scatter[1:]
        kind = order.size, int(np.sum(data.v >= 1.0)), known, said
        alike[kind].append((number, data, order + 1, diameter))
    require_names("models", models or (), CANDIDATES)
    candidates = {name: CANDIDATES[name] for name in models or AVERAGED}
    comparisons: dict[int, Comparison] = {}
    for (_, count, known, _), members in alike.items():
        numbers, parts, rows, diameters = zip(*members, strict=True)
        data = stacked_sets(parts)
        compared = _compared(data, rows, diameters, count, known, level, candidates)
        comparisons |= zip(numbers, compared, strict=True)
    return [comparisons[number] for number in range(len(sets))]


def _checked(
    v: Numbers,
    e: Numbers,
    sigma: Numbers | None = None,
    sigma_v: Numbers | None = None,
    d: Numbers | None = None,
    size_scatter: Numbers | str | None = None,
) -> tuple[DataSets, Places, bool, float | None]:
    """Check a data set and sort it by speed: data, order, whether sigma is known, diameter."""
    spread = 1.0 if sigma is None else sigma
    noise = 0.0 if sigma is None else NOISE * np.max(checked("sigma", sigma, SPREAD))
    allowed = replace(FRACTION, upper=1.0 + noise)
    speed, measured, spread = measurements(v, e, spread, allowed, SPREAD)
    open_sizes = scatter_of(speed, sigma_v, d, size_scatter)
    require_telling(speed, measured, FEWEST, FEWEST - 1)
    order = np.argsort(speed, kind="stable")
    row = order[None]
    data = in_own_units(speed[row], measured[row], 1.0 / spread[row], None)
    if open_sizes is None:
        return data, order, sigma is not None, None
    rows, free, diameter = open_sizes
    contradicted = not free and is_contradicted(speed, measured, rows)
    if contradicted:
        rows[2] = 1.0
    said = Scatter(rows[None, :, order], free or contradicted, sigma is None, contradicted)
    return replace(data, scatter=said), order, sigma is not None, diameter


def sorted_data(*arguments: Any) -> DataSets:
    """One data set, the first arguments of `compare_models`, by speed in its own units."""
    return _checked(*arguments)[0]


def _compared(
    sets: DataSets,
    rows: Sequence[Places],
    diameters: Sequence[float | None],
    count: int,
    known: bool,
    level: float,
    candidates: dict[str, Candidate],
) -> list[Comparison]:
    """Compare models of data sets that each hold ``count`` points from the slowest rebound up.

    ``rows`` are the numbers (n,), from 1, that the points of each set had before they were sorted.
    """
    free_size = sets.scatter is not None and sets.scatter.free_size
    free_tails = sets.tails is not None and len(sets.tails.freedoms) > 1
    tried = _affordable(candidates, free_size + free_tails, count, known)
    left_out = tuple(name for name in candidates if name not in tried)
    free = np.array([model.free for model in tried.values()])[:, None]
    drawn = [_drawn(model, sets, count, known) for model in tried.values()]
    profiles, v_c = (np.stack([getattr(best, name) for best in drawn]) for name in ("rows", "v_c"))
    least = profiles[..., 1].min(axis=2)
    chi_square = least if known else count * np.exp(np.minimum(least / count, LARGEST_LOG))
    if sets.scatter is not None and known:
        chi_square = _misfits(sets, rows, tried, drawn)
    leftover = chi_square / (count - free)  # variance of e in units of sigma squared
    criterion = _criterion(least, leftover, free, count, known)
    best, every = np.argmin(criterion, axis=0), np.arange(len(sets.unit))
    criterion = criterion - criterion[best, every]
    weights = np.exp(-0.5 * criterion)
    weights /= weights.sum(axis=0)
    widened = np.maximum(1.0, left := leftover[best, every])
    rise = (profiles[..., 1] - least[..., None]) / (widened[:, None] if known else count)
    if not known:
        # That of the sum of squares, over sigma squared; its logarithm may exceed all numbers.
        rise = (count - free)[..., None] * np.expm1(np.minimum(rise, LARGEST_LOG))
    # With sigma known the signed roots are normal; else, of Student's distribution.
    freedom = np.where(known & (widened == 1.0), np.inf, count - free)
    tails = _Tails(profiles[..., 0], np.sqrt(rise), v_c, freedom)
    scattered = _likelier_scatters([*tried.values()], sets, drawn, best, known)
    half, unit = 0.5 * (1.0 - level), sets.unit * sets.reach
    alone = unit * np.stack([tails.quantiles(half), tails.quantiles(1.0 - half)])
    low, middle, high = (
        unit * _averaged(weights, tails, share) for share in (half, 0.5, 1.0 - half)
    )
    compared = []
    for i, data in enumerate(sets.split()):
        fitted = [
            Model(
                name=name,
                free=candidate.free,
                v_c=float(unit[i] * v_c[k, i]),
                interval=(float(alone[0, k, i]), float(alone[1, k, i])),
                chi_square=float(chi_square[k, i]) if known else None,
                criterion=float(criterion[k, i]),
                weight=float(weights[k, i]),
                size_exponent=-scatter.size_exponent(candidate.law, drawn[k].x[i]),
                law=partial(_in_metres, candidate, data, drawn[k].x[i], float(v_c[k, i])),
            )
            for k, (name, candidate) in enumerate(tried.items())
        ]
        fitted.sort(key=lambda model: model.criterion)
        k, interval = best[i], (float(low[i]), float(high[i]))
        winner, x = list(tried.values())[k], drawn[k].x[i]
        residuals = _residuals(data, rows[i], winner, x, float(v_c[k, i]), known)
        _require_a_curve(residuals)
        sigma, excess = _scales(residuals, float(left[i]), data, known)
        words = (
            *_warnings(data, fitted, residuals, float(middle[i]), interval, scattered[i]),
            *_about_rows(left_out, count),
        )
        compared.append(
            Comparison(
                models=tuple(fitted),
                v_c=float(middle[i]),
                v_c_interval=interval,
                confidence=level,
                sigma=sigma,
                scatter=excess,
                tails=residuals.tails,
                exact=data.scatter is None,
                diameter=diameters[i],
                size_scatter=float(np.exp(x[LN_SIZE])) if free_size else None,
                left_out=left_out,
                warnings=words,
            )
        )
        _require_sound(compared[-1])
    return compared


def _require_sound(comparison: Comparison) -> None:
    """Refuse an average that no right calculation can give."""
    low, high = comparison.v_c_interval
    weights = np.array([model.weight for model in comparison.models])
    ends = np.array([model.interval for model in comparison.models if model.weight >= LIGHT])
    if not (
        low <= comparison.v_c <= high
        and 0.0 <= low < high < np.inf
        and ends[:, 0].min() <= comparison.v_c <= ends[:, 1].max()
        and abs(weights.sum() - 1.0) < 1e-9
    ):
        raise RuntimeError(
            f"the average of models went wrong in these data: v_c = {comparison.v_c:g} m/s, from "
            f"{low:g} to {high:g} m/s, where the models say {ends[:, 0].min():g} to "
            f"{ends[:, 1].max():g} m/s"
        )


def _misfits(
    sets: DataSets, rows: Sequence[Places], tried: dict[str, Candidate], drawn: list[_Drawn]
) -> FloatArray:
    """Sums of squares over sigma (k, r) under scatter, where the deviance has other terms, too."""
    return np.array(
        [
            [
                np.sum(_residuals(data, order, model, x, at, known=True).in_sigma ** 2)
                for data, order, x, at in zip(sets.split(), rows, best.x, best.v_c, strict=True)
            ]
            for model, best in zip(tried.values(), drawn, strict=True)
        ]
    )


def _affordable(
    candidates: dict[str, Candidate], more: int, count: int, known: bool
) -> dict[str, Candidate]:
    """Models for which `count` points are enough, with `more` free parameters."""
    tried = {
        name: model._replace(free=model.free + more)
        for name, model in candidates.items()
        if count > model.free + more + _spare(known)
    }
    if not tried:
        fewest = 1 + _spare(known) + more + min(model.free for model in candidates.values())
        raise NotComputable(
            f"v must hold at least {fewest} points from the smallest rebounding speed upwards for "
            f"these models, got {count}"
        )
    return tried


def _spare(known: bool) -> int:
    """Number of data beyond one more than the free parameters: AICc divides by the rest."""
    return 0 if known else 2


def _in_metres(
    candidate: Candidate, data: DataSets, x: FloatArray, v_c: float, v: FloatArray
) -> FloatArray:
    """Restitution at speeds (n,) in m/s by the variables of a search in one data set."""
    return candidate.restitution(x, v_c * data.reach[0], np.asarray(v) / data.unit[0])


def _likelier_scatters(
    tried: list[Candidate], sets: DataSets, drawn: list[_Drawn], best: Places, known: bool
) -> FloatArray:
    """Scatter of size (r,) by which the best model of each data set gains, else 0."""
    scattered = np.zeros(best.size)
    for k in np.unique(best) if sets.scatter is None and sets.tails is None else ():
        chosen = np.flatnonzero(best == k)
        part = sets.select(chosen)
        scattered[chosen] = _likelier_scatter(tried[k], part, drawn[k], chosen, known)
    return scattered


def _likelier_scatter(
    model: Candidate, sets: DataSets, drawn: _Drawn, chosen: Places, known: bool
) -> FloatArray:
    """Scatter of size (r,) with which a model's criterion is lower than with one size, else 0.

    ``drawn`` are its profiles in all data sets, of which ``sets`` are the chosen ones (r,).
    """
    many, count = chosen.size, int(np.sum(sets.v[0] >= 1.0))
    if count <= model.free + 1 + _spare(known):
        return np.zeros(many)
    rows = np.zeros((many, 4, sets.v.shape[1]))
    rows[:, 2:] = 1.0
    scattered = replace(sets, scatter=Scatter(rows, free_size=True, free_sigma=not known))
    least = drawn.rows[chosen, :, 1].min(axis=1)
    start = np.zeros((many, SCATTERED))
    curve = drawn.x[chosen, :V_C]
    start[:, : curve.shape[1]] = curve
    start[:, LN_SIZE] = np.log(FIRST_SIZE)
    if not known:
        start[:, LN_SIGMA] = 0.5 * (least / count + np.log(0.5))
    owner = np.repeat(np.arange(many), len(NEARBY))
    v_c = (drawn.v_c[chosen, None] * NEARBY).ravel()
    searched = model.profile(scattered, owner, v_c, start[None, owner])
    each = searched.value.reshape(many, len(NEARBY))
    at = np.arange(many), each.argmin(axis=1)
    free, even = np.array([[model.free], [model.free + 1]]), np.ones((2, 1))
    criterion = _criterion(np.stack([least, each[at]]), even, free, count, known)
    size = np.exp(searched.x[:, LN_SIZE]).reshape(each.shape)[at]
    return np.where(criterion[1] < criterion[0], size, 0.0)


class _Drawn(NamedTuple):
    """Profiles of r data sets: v_c in their units and the deviance, and where that is least.

    The deviance is chi-square where sigma is known and n ln(sum of squares/n) where it is not,
    or what scatter makes of these.
    """

    rows: FloatArray  # v_c and deviance (r, g, 2)
    v_c: FloatArray  # The best (r,)
    x: FloatArray  # The variables there (r, ...)


def _drawn(model: Candidate, sets: DataSets, count: int, known: bool) -> _Drawn:  # noqa: PLR0915
    """Draw profiles, closer and closer about their low parts."""
    every, freedom, reach = np.arange(len(sets.unit)), count - model.free, sets.reach
    # Where data are many, their classes tell where to search.
    data = sets if sets.scatter is None else scatter.condensed(sets)

    def searched(data: DataSets, owner: Places, v_c: FloatArray, starts: FloatArray) -> FloatArray:
        """v_c, the deviance and the variables of each search (m, ...)."""
        deviance, x = model.profile(data, owner, v_c * reach[owner], starts)[:2]
        if sets.scatter is None and sets.tails is None and not known:
            deviance = count * np.log(np.maximum(deviance, TINY) / count)
        return np.column_stack([v_c, deviance, x])

    def low(rows: FloatArray) -> BoolArray:
        """Where something of v_c is left (r, g)."""
        rise = rows[..., 1] - (lowest := rows[..., 1].min(axis=1, keepdims=True))
        negligible = (
            NEGLIGIBLE * np.maximum(lowest / freedom, 1.0)
            if known
            else count * np.log1p(NEGLIGIBLE / freedom)
        )
        return np.asarray(rise < negligible)

    def refined(data: DataSets, rows: FloatArray, between: FloatArray) -> FloatArray:
        """Rows with those of more v_c between them, (r, ...)."""
        # Neighbours on both sides are close starts; a value that is there already stays as it is.
        after = np.sum(rows[:, None, :, 0] < between[..., None], axis=2)
        before, more = (rows[every[:, None], at] for at in (after - 1, after))
        new = more[..., 0] != between
        starts = np.stack([before[new, 2:], more[new, 2:]])
        if new.any():
            more[new] = searched(data, np.nonzero(new)[0], between[new], starts)
        rows = np.concatenate([rows, more], axis=1)
        return np.take_along_axis(rows, np.argsort(rows[..., :1], axis=1, kind="stable"), axis=1)

    def closer(rows: FloatArray) -> FloatArray:
        """Values of v_c in the low part (r, ...)."""
        part, last = low(rows), rows.shape[1] - 1
        ends = part.argmax(axis=1) - 1, last - part[:, ::-1].argmax(axis=1) + 1
        start, stop = (rows[every, np.clip(end, 0, last), 0] for end in ends)
        return np.linspace(start, stop, VALUES, axis=1)[:, 1:-1]

    first = np.append(FIRST_VALUES[:-1:APART], GREATEST)
    owner, v_c = np.repeat(every, first.size), np.tile(first, every.size)
    rows = searched(data, owner, v_c, np.zeros((0, 0, 0))).reshape(every.size, first.size, -1)
    between = np.tile(np.setdiff1d(FIRST_VALUES, first), (every.size, 1))
    for _ in range(ROUNDS + (sets.scatter is None)):
        rows = refined(data, rows, between)
        between = closer(rows)
    if data is not sets:
        owner = np.repeat(every, rows.shape[1])
        at = (rows[..., 0] * reach[:, None]).ravel(), rows[..., 2:].reshape(owner.size, -1)
        rows[..., 1] = scatter.deviance_at(model.law, sets, owner, *at).reshape(rows.shape[:2])
        part = low(rows)
        rows[part] = searched(sets, np.nonzero(part)[0], rows[part, 0], rows[None, part, 2:])
        part = low(rows)
        gaps = np.diff(rows[..., 0]) * (part[:, 1:] | part[:, :-1])
        sparse = gaps.max(axis=1, keepdims=True) > SPARSE / VALUES * gaps.sum(axis=1, keepdims=True)
        rows = refined(sets, rows, np.where(sparse, closer(rows), rows[:, -1:, 0]))
    at = rows[every, np.argmin(rows[..., 1], axis=1)]
    return _Drawn(rows=rows[..., :2], v_c=at[:, 0], x=at[:, 2:])


class _Tails:
    """Shares of the probability of v_c below a value, by the signed root of chi-square's rise.

    Of k models and r data sets: v_c of the profiles and the roots without sign (k, r, g), the best
    v_c (k, r), and degrees of freedom, of a shape that broadcasts to (k, r).
    """

    def __init__(
        self, values: FloatArray, roots: FloatArray, v_c: FloatArray, freedom: FloatArray
    ) -> None:
        self.values, self.freedom = values, np.broadcast_to(freedom, v_c.shape)
        # Beyond a valley counts what lies lower further out: the profile of a missed minimum.
        below = values < v_c[..., None]
        outer = np.minimum.accumulate(np.where(below, roots, np.inf), axis=-1)
        inner = np.minimum.accumulate(np.where(below, np.inf, roots)[..., ::-1], axis=-1)
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


def _criterion(
    least: FloatArray, leftover: FloatArray, free: FloatArray, count: int, known: bool
) -> FloatArray:
    """Akaike's criterion of the least deviance; that for few data where sigma is estimated, too.

    With sigma too small for every model, chi-square counts in units of what the best leaves.
    """
    if not np.isfinite(least).all():
        raise RuntimeError("the search for v_c met numbers that are not finite in these data")
    if known:
        unit = np.maximum(1.0, np.min(leftover, axis=0))
        return np.asarray(least / unit + 2.0 * free)
    numbers = free + 1
    return np.asarray(least + 2.0 * numbers * count / (count - numbers - 1.0))


class _Residuals(NamedTuple):
    """Data (m,) from the slowest rebound upwards, and their residuals from a model."""

    rows: Places  # Numbers of the rows as they were passed, from 1
    v: FloatArray  # m/s
    e: FloatArray
    missed: FloatArray  # e less the model
    in_sigma: FloatArray  # The same over sigma; if sigma is not given, over that of all other rows
    share: FloatArray | float = 1.0  # Weights of their squares, 1 where e is normal
    sigma: float | None = None  # Scale of e, where the search has found it
    tails: float | None = None  # Degrees of freedom of Student's t

    def largest(self, least: float = 0.0) -> str:
        """Rows of the largest residuals, in words, if these are at least `least` sigma."""
        size = np.abs(self.in_sigma)
        words = ", ".join(
            f"row {self.rows[i]} (v = {self.v[i]:.4g} m/s, e = {self.e[i]:.3g}, "
            f"{self.in_sigma[i]:+.1f} sigma)"
            for i in np.argsort(-size, kind="stable")[:NAMED]
            if size[i] >= least
        )
        return f"; largest residuals: {words}" if words else ""


def _residuals(
    data: DataSets, rows: Places, model: Candidate, x: FloatArray, v_c: float, known: bool
) -> _Residuals:
    """Residuals of one data set from a model, by the variables of its search."""
    telling = data.v[0] >= 1.0
    if data.scatter is not None:
        telling &= data.e[0] > 0.0
        moments = scatter.expected(model.law, data, v_c * data.reach[0], x)[telling]
        v, e = data.unit * data.v[0, telling], data.e[0, telling]
        missed = e - moments[:, 0]
        scale = None if known else float(np.exp(x[LN_SIGMA]))
        in_sigma, tails, share = missed / np.sqrt(moments[:, 1]), None, np.ones_like(e)
        if data.tails is not None:
            tails = float(x[FREEDOM])
            share = (tails + 1.0) / (tails + in_sigma**2)
        return _Residuals(rows[telling], v, e, missed, in_sigma, share, scale, tails)
    v, e = data.unit * data.v[0, telling], data.e[0, telling]
    missed = e - model.restitution(x, v_c, data.v[0, telling])
    in_sigma = missed * data.weight[0, telling]
    if data.tails is not None:
        curve = model.restitution(x, v_c, data.v[0])
        student, weights = data.tails.likeliest((data.e - curve) * data.weight, e.size)
        _, scale, tails = student[0].tolist()
        share = weights[0, telling] * scale**2
        return _Residuals(rows[telling], v, e, missed, in_sigma / scale, share, scale, tails)
    if not known:
        squares = np.maximum(np.sum(missed**2) - missed**2, TINY)
        in_sigma = missed / np.sqrt(squares / (e.size - model.free - 1))
    return _Residuals(rows[telling], v, e, missed, in_sigma)


def _scales(
    residuals: _Residuals, left: float, data: DataSets, known: bool
) -> tuple[float | None, float]:
    """Sigma of e where it is estimated, else None; its ratio to sigma as stated, or 1."""
    scale = residuals.sigma or float(np.sqrt(left))
    if known or (data.tails is not None and data.tails.known):
        return None, scale
    return scale, 1.0


def _require_a_curve(residuals: _Residuals) -> None:
    """Refuse data that no model describes better than chance would."""
    e, root = residuals.e, np.sqrt(residuals.share)
    missed = residuals.missed * root
    scatter = float(np.sqrt(np.mean(missed**2)))
    if scatter > WILD and np.sum(missed**2) > 0.5 * np.sum((root * (e - e.mean())) ** 2):
        raise NotComputable(
            f"e must depend on v as a rebound does: the closest of all models leaves a scatter of "
            f"{scatter:.2g}, and explains less than half of the variance{residuals.largest()}; "
            "tails admit a few rows that stray"
        )


def _warnings(
    data: DataSets,
    models: list[Model],
    residuals: _Residuals,
    v_c: float,
    interval: tuple[float, float],
    size_scatter: float,
) -> Iterator[str]:
    yield from _about_the_fit(models[0], residuals)
    if data.scatter is None and models[0].chi_square is not None:
        yield from _about_speeds(data, models[0])
    if size_scatter > 0.0:
        yield (
            "the data look as if v_c scattered among the spheres, as with "
            f"{100.0 * size_scatter:.2g} % in diameter, or as if speeds had errors: then the "
            "interval is too narrow"
        )
    heavy = [model for model in models if model.weight >= LIGHT]
    for first, second in combinations(heavy, 2):
        if first.interval[0] > second.interval[1] or second.interval[0] > first.interval[1]:
            yield f"models disagree: {first.name} and {second.name} have intervals that do not meet"
    if len(heavy) == 1 < len(models):
        yield (
            f"one model alone, {models[0].name}, carries the interval, which supposes it true: of "
            "another curve such an interval is too narrow"
        )
    yield from _about_captures(data, v_c)
    if interval[0] == 0.0:
        yield "the data do not bound v_c from below"
    if interval[1] == data.unit[0] * data.reach[0]:
        yield (
            "the upper end is the slowest rebound itself"
            if data.scatter is None
            else "the data do not bound v_c from above"
        )


def _about_rows(left_out: tuple[str, ...], count: int) -> Iterator[str]:
    if left_out:
        yield f"models left out, for {count} rows are too few for them: {', '.join(left_out)}"


def _about_captures(data: DataSets, v_c: float) -> Iterator[str]:
    if data.scatter is not None and data.scatter.contradicted:
        yield (
            "captures lie farther above rebounds than the errors of speed and size stated allow: "
            "these sizes are taken to scatter as much as the data say"
        )
    slowest, exact = float(data.unit[0]), data.scatter is None
    captured = slowest * data.v[data.e == 0.0]
    if slowest > NEAR * v_c and not (captured > v_c / NEAR).any():
        yield (
            f"no speed is near capture: the slowest rebound has {slowest:.3g} m/s"
            f"{f', {slowest / v_c:.2g} times v_c' if v_c > 0.0 else ', v_c is 0'}"
        )
    if exact and (nearest := max(captured, default=0.0)) > slowest:
        yield (
            f"captures up to {nearest:.3g} m/s and rebounds from {slowest:.3g} m/s on overlap: "
            "the spheres or the places do not share one v_c"
        )


def _about_speeds(data: DataSets, best: Model) -> Iterator[str]:
    """Say how exact speeds must be, where that is more than they are likely to be."""
    telling = (data.v[0] >= 1.0) & (data.e[0] > 0.0)
    v, step = data.unit[0] * data.v[0, telling], 1e-3
    rise = (best.law(v * (1.0 + step)) - best.law(v * (1.0 - step))) / (2.0 * step)
    steepest = float(np.max(rise * data.weight[0, telling]))
    if steepest * LIKELY_SCATTER > 1.0:
        yield (
            f"an error of {100.0 / steepest:.2g} % in speed, or about as much in diameter, moves e "
            "near capture by its sigma: if speeds or sizes are not that exact, the interval is too "
            "narrow; state their errors"
        )


def _about_the_fit(best: Model, residuals: _Residuals) -> Iterator[str]:
    missed, freedom = residuals.missed, residuals.missed.size - best.free
    if residuals.tails is not None:
        if words := residuals.largest(STRAY):
            yield f"rows more than {STRAY:g} sigma off count little{words}"
    elif best.chi_square is None:
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
