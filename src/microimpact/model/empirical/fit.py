"""Fit of the empirical restitution curve, Eq. (34), and the uncertainty of its capture velocity.

The curve is clipped: e = 0 at and below v_c. A captured sphere, e = 0, is a datum like any other,
of zero misfit while v_c lies above its speed; no sphere that rebounds can be slower than v_c, so
0 <= v_c <= the smallest rebounding speed.
"""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microimpact.core.arrays import POSITIVE, FloatArray, Range, checked
from microimpact.model.empirical.equations import restitution
from microimpact.model.empirical.search import (
    CLOSEST,
    ON_BOUND,
    V_C,
    Optimum,
    Problem,
    minimum,
    model,
    profile_interval,
)

NAMES = ("k", "p", "kappa", "q", "v_c")
UNITS = ("m/s", "", "m/s", "", "m/s")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RestitutionFit:
    """Eq. (34) fitted to data; ``str(fit)`` is a summary.

    Attributes
    ----------
    k, p, kappa, q, v_c
        Parameters as in `microimpact.model.empirical.equations.restitution`; k, kappa, v_c in m/s.
    v_c_interval
        Profile likelihood interval of v_c, m/s.
    v_c_interval_limited
        For each end of it, whether it is set by the admissible range, 0 to the smallest
        rebounding speed (or 0.1 % below), and not by the values of e.
    confidence
        Nominal coverage of that interval.
    cov
        Covariance (5, 5) in the order k, p, kappa, q, v_c, linearised at the minimum. Zero for a
        fixed q; NaN for the parameters in ``on_bound``, to which linearisation does not apply.
    residuals
        e minus the curve (n,), in the order of the data.
    v, e, sigma
        The data (n,): speeds in m/s, coefficients of restitution, standard deviations of e.
    sigma_estimated
        Whether sigma was estimated from the residuals.
    chi_square
        Sum of squares of residuals over sigma.
    degrees_of_freedom
        Data less free parameters. Captured points below v_c do not count: they cannot miss.
    r_squared
        Share of the (weighted) variance of e that the curve explains.
    on_bound
        Names of free parameters that ended on a bound; v_c also where it rests on the speed of
        a captured sphere, at which the clip bends the sum of squares.
    q_fixed
        Whether q was given.
    converged
        Whether the search ended by its tolerances.
    starts, starts_agreeing
        Number of searches, and of those that ended at the minimum.
    """

    k: float
    p: float
    kappa: float
    q: float
    v_c: float
    v_c_interval: tuple[float, float]
    v_c_interval_limited: tuple[bool, bool]
    confidence: float
    cov: FloatArray
    residuals: FloatArray
    v: FloatArray
    e: FloatArray
    sigma: FloatArray
    sigma_estimated: bool
    chi_square: float
    degrees_of_freedom: int
    r_squared: float
    on_bound: tuple[str, ...]
    q_fixed: bool
    converged: bool
    starts: int
    starts_agreeing: int

    @property
    def parameters(self) -> FloatArray:
        """The five numbers k, p, kappa, q, v_c."""
        return np.array([self.k, self.p, self.kappa, self.q, self.v_c])

    @property
    def standard_errors(self) -> dict[str, float]:
        """Square roots of the diagonal of ``cov``, by name."""
        return dict(zip(NAMES, np.sqrt(np.diag(self.cov)).tolist(), strict=True))

    @property
    def reduced_chi_square(self) -> float:
        """Chi-square per degree of freedom; 1 where sigma was estimated, rounding apart."""
        return self.chi_square / self.degrees_of_freedom

    def curve(self, v: ArrayLike) -> FloatArray:
        """Fitted coefficient of restitution at normal speeds v, m/s, any shape."""
        return restitution(v, self.k, self.p, self.kappa, self.q, self.v_c)

    def summary(self) -> str:
        """Parameters with standard errors, interval of v_c and goodness, as text."""
        return _summary(self)

    def __str__(self) -> str:
        return _summary(self)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CaptureBootstrap:
    """Parametric bootstrap of v_c.

    Attributes
    ----------
    interval
        Percentile interval, m/s.
    sample
        v_c of each replicate, m/s.
    on_bound
        Number of replicates in which v_c ended on a bound.
    confidence
        Nominal coverage of the interval.
    """

    interval: tuple[float, float]
    sample: FloatArray
    on_bound: int
    confidence: float


def covariance(problem: Problem, best: Optimum, on_bound: tuple[str, ...]) -> FloatArray:
    """Covariance of k, p, kappa, q, v_c at the minimum, for the weights of the problem."""
    gap = 1.0 - best.v_c
    slopes = model(problem.v, best.logs, 1.0, gap)[1] * problem.weight[:, None]
    held = np.array([name in on_bound for name in NAMES])
    free = np.append(problem.free, True) & ~held
    natural = np.append(np.exp(best.logs), -gap)  # d/d ln(gap) = -gap d/d v_c
    size = np.linalg.norm(slopes[:, free], axis=0)
    size = np.where(size > 0.0, size, 1.0)
    _, singular, rows = np.linalg.svd(slopes[:, free] / size, full_matrices=False)
    # A direction that the data do not determine gets a huge variance, not a division by zero.
    factor = rows.T / np.maximum(singular, np.finfo(float).eps) / size[:, None]
    factor *= natural[free, None]
    cov = np.zeros((5, 5))
    cov[np.ix_(free, free)] = factor @ factor.T
    cov[held, :] = cov[:, held] = np.nan
    return cov


def _summary(fit: RestitutionFit) -> str:
    lines = ["Eq. (34): e = k^p/(k^p + v^p) (1 - kappa^q/(kappa^q + (v - v_c)^q)), 0 for v <= v_c"]
    errors = fit.standard_errors
    for name, unit, value in zip(NAMES, UNITS, fit.parameters, strict=True):
        spread = f"+- {errors[name]:.2g}"
        if name in fit.on_bound:
            spread = "on a bound"
        elif name == "q" and fit.q_fixed:
            spread = "fixed"
        lines.append(f"  {name:5s} = {value:<10.6g} {unit:3s} {spread}")
    lines.append(f"  v_c in {_interval(fit)} m/s (profile likelihood, {100 * fit.confidence:g} %)")
    how = "estimated from the residuals" if fit.sigma_estimated else "given"
    low, high = fit.sigma.min(), fit.sigma.max()
    sigma = f"{low:.3g}" if low == high else f"{low:.3g} to {high:.3g}"
    lines.append(f"  sigma of e {sigma} ({how})")
    lines.append(
        f"  chi-square {fit.chi_square:.4g} on {fit.degrees_of_freedom} degrees of freedom, "
        f"reduced {fit.reduced_chi_square:.3g}, R^2 {fit.r_squared:.6g}"
    )
    ended = "converged" if fit.converged else "NOT converged"
    lines.append(
        f"  {fit.v.size} points; {ended}; {fit.starts_agreeing} of {fit.starts} starts agree"
    )
    return "\n".join(lines)


def _interval(fit: RestitutionFit) -> str:
    low, high = fit.v_c_interval
    left, right = (" (end of range)" if limited else "" for limited in fit.v_c_interval_limited)
    return f"[{low:.6g}{left}, {high:.6g}{right}]"


# Measured with noise, e may come out somewhat above 1; far above it is no normal impact.
MEASURED_E = Range(lower=0.0, upper=1.2, lower_closed=True, upper_closed=True)
SIGMA = Range(lower=1e-12, lower_closed=True)
CONFIDENCE = Range(lower=0.0, upper=1.0)
# Below this share of the data a misfit is rounding.
ROUNDING = 1e-10
# Below this share of chi-square a difference of it is.
PROFILE_ROUNDING = 1e-7


def fit_restitution(
    v: ArrayLike,
    e: ArrayLike,
    sigma: ArrayLike | None = None,
    q: float | None = None,
    *,
    confidence: float = 0.95,
) -> RestitutionFit:
    """Fit Eq. (34) to coefficients of restitution by weighted least squares.

    The global minimum is sought from several starts. The interval of v_c holds every value whose
    least chi-square, over all other parameters, exceeds the minimum by less than the quantile of
    chi-square with one degree of freedom; if sigma is estimated, by less than the quantile of F.

    Parameters
    ----------
    v
        Normal impact speeds (n,), m/s; positive.
    e
        Coefficients of restitution (n,), in [0, 1.2]; 0 for a captured sphere.
    sigma
        Standard deviation of e, one number or (n,); 1e-12 or more. None: one number for all,
        estimated from the residuals.
    q
        Exponent of Eq. (33), positive; None: free.
    confidence
        Coverage of the interval of v_c, in (0, 1).

    Returns
    -------
    RestitutionFit

    Raises
    ------
    TypeError
        If an argument does not hold real numbers.
    ValueError
        If a number is not finite or out of range, shapes differ, or no sphere rebounds; or if,
        from the smallest rebounding speed upwards, there are fewer points than free parameters
        and one more or fewer different speeds than free parameters.
    """
    speed, measured = _checked_data(v, e)
    fixed = None if q is None else _scalar("q", q)
    level = _scalar("confidence", confidence, CONFIDENCE)
    slowest = _slowest_rebound(speed, measured, 5 if fixed is None else 4)
    spread = _spread(sigma, speed.shape)
    # Relative weights: the tolerances of the search are absolute in part.
    least = float(spread.min())
    problem = Problem(speed / slowest, measured, least / spread, fixed)
    known = None if sigma is None else least**2
    best, interval, limited = _search(problem, level, known)
    variance = _variance(problem, best) if known is None else known
    return _result(
        problem,
        best,
        slowest,
        variance,
        v=speed,
        sigma=np.sqrt(variance) / problem.weight,
        sigma_estimated=sigma is None,
        v_c_interval=(interval[0] * slowest, interval[1] * slowest),
        v_c_interval_limited=limited,
        confidence=level,
    )


def bootstrap_v_c(
    fit: RestitutionFit,
    replicates: int,
    seed: int,
    *,
    spawn_key: tuple[int, ...] = (),
    confidence: float = 0.95,
) -> CaptureBootstrap:
    """Parametric bootstrap of v_c: refit the fitted curve with fresh normal noise.

    Noise that would carry e below zero makes the point a captured one. Replicate i draws from
    ``SeedSequence(seed, spawn_key=(*spawn_key, i))``, so the sample does not depend on chunks.

    Parameters
    ----------
    fit
        A fit; its speeds and sigma are used.
    replicates
        Number of refits, 1 or more.
    seed
        Root of the random draws, 0 or more.
    spawn_key
        Place of this sample among those of the same root.
    confidence
        Coverage of the interval, in (0, 1).

    Raises
    ------
    TypeError, ValueError
        If an argument is of another kind or out of range.
    RuntimeError
        If no sphere rebounds in a replicate.
    """
    if not isinstance(fit, RestitutionFit):
        raise TypeError(f"fit must be a RestitutionFit, got {fit!r}")
    for name, value, least in (("replicates", replicates, 1), ("seed", seed, 0)):
        if isinstance(value, bool) or not isinstance(value, Integral):
            raise TypeError(f"{name} must be a whole number, got {value!r}")
        if value < least:
            raise ValueError(f"{name} must be at least {least}, got {value}")
    level = _scalar("confidence", confidence, CONFIDENCE)
    curve, fixed = fit.curve(fit.v), fit.q if fit.q_fixed else None
    weight = fit.sigma.min() / fit.sigma
    sample, on_bound = np.empty(replicates), 0
    for i in range(replicates):
        draw = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(*spawn_key, i)))
        noise = fit.sigma * draw.standard_normal(curve.shape)
        e = np.where(curve > 0.0, np.maximum(curve + noise, 0.0), 0.0)
        if not np.any(e > 0.0):
            raise RuntimeError(f"no sphere rebounds in replicate {i}: sigma is too large")
        slowest = float(fit.v[e > 0.0].min())
        start = np.log(
            [fit.k / slowest, fit.p, fit.kappa / slowest, fit.q, max(fit.v_c / slowest, CLOSEST)]
        )
        found = minimum(Problem(fit.v / slowest, e, weight, fixed), start)
        sample[i] = found.v_c * slowest
        on_bound += found.on_edge
    tail = 0.5 * (1.0 - level)
    low, high = np.quantile(sample, [tail, 1.0 - tail]).tolist()
    return CaptureBootstrap(
        interval=(low, high), sample=sample, on_bound=on_bound, confidence=level
    )


def _scalar(name: str, value: object, allowed: Range = POSITIVE) -> float:
    number = checked(name, value, allowed)
    if not isinstance(number, float):
        raise TypeError(f"{name} must be one real number, got {value!r}")
    return number


def _checked_data(v: ArrayLike, e: ArrayLike) -> tuple[FloatArray, FloatArray]:
    speed = np.atleast_1d(checked("v", v, POSITIVE))
    measured = np.atleast_1d(checked("e", e, MEASURED_E))
    if speed.ndim != 1 or speed.shape != measured.shape:
        raise ValueError(f"v and e must be of one shape (n,), got {np.shape(v)} and {np.shape(e)}")
    return speed, measured


def _slowest_rebound(v: FloatArray, e: FloatArray, free: int) -> float:
    """Smallest rebounding speed, if the data suffice for so many free parameters."""
    if not np.any(e > 0.0):
        raise ValueError("e must be positive somewhere: no sphere rebounds")
    slowest = float(v[e > 0.0].min())
    telling = v[v >= slowest]
    if telling.size <= free:
        raise ValueError(
            f"v must hold at least {free + 1} points from the smallest rebounding speed upwards, "
            f"for {free} free parameters and one more, got {telling.size}"
        )
    different = np.unique(telling).size
    if different < free:
        raise ValueError(
            f"v must hold at least {free} different speeds from the smallest rebounding one "
            f"upwards, one for each free parameter, got {different}"
        )
    return slowest


def _spread(sigma: ArrayLike | None, shape: tuple[int, ...]) -> FloatArray:
    """Standard deviations of all points; ones where they are to be estimated."""
    spread = np.asarray(checked("sigma", 1.0 if sigma is None else sigma, SIGMA))
    if spread.shape not in {(), shape}:
        raise ValueError(f"sigma must be one number or of shape {shape}, got {spread.shape}")
    return np.broadcast_to(spread, shape)


def _search(
    problem: Problem, level: float, variance: float | None
) -> tuple[Optimum, tuple[float, float], tuple[bool, bool]]:
    """Minimum, interval of v_c, and which of its ends the admissible range sets."""
    best = minimum(problem)
    rounding = ROUNDING**2 * float(np.sum(np.square(problem.weight * problem.e)))
    while True:
        rise = _admissible_rise(problem, best, level, variance)
        rise = max(rise, rounding, PROFILE_ROUNDING * best.chi_square)
        interval, limited, lowest = profile_interval(problem, best, rise)
        if lowest.chi_square >= best.chi_square - 1e-4 * rise:
            return best, interval, limited
        # The profile met a lower point: an overlooked minimum lies there or lower still.
        start = np.append(lowest.logs, np.log(max(lowest.v_c, CLOSEST)))
        best = min(lowest, minimum(problem, start), key=lambda each: each.chi_square)


def _freedom(problem: Problem, best: Optimum) -> int:
    """Degrees of freedom; captured points below v_c cannot miss and do not count."""
    telling = (problem.e > 0.0) | (problem.v > best.v_c)
    return int(telling.sum() - problem.free.sum() - 1)


def _admissible_rise(
    problem: Problem, best: Optimum, level: float, variance: float | None
) -> float:
    """Rise of chi-square at the ends of the interval: a quantile of chi-square(1) or F(1, n)."""
    from scipy.special import chdtri, fdtri

    if variance is not None:
        return variance * float(chdtri(1.0, 1.0 - level))
    return _variance(problem, best) * float(fdtri(1.0, _freedom(problem, best), level))


def _on_bound(problem: Problem, best: Optimum) -> tuple[str, ...]:
    low, high = problem.bounds
    near = (best.logs - low < ON_BOUND) | (high - best.logs < ON_BOUND)
    bound = np.append(near & problem.free, best.on_edge)
    return tuple(name for name, hit in zip(NAMES, bound, strict=True) if hit)


def _result(
    problem: Problem, best: Optimum, unit: float, variance: float, **known: Any
) -> RestitutionFit:
    """The fit in m/s; ``variance`` scales the squares of the standard deviations."""
    on_bound = _on_bound(problem, best)
    units = np.array([unit, 1.0, unit, 1.0, unit])
    k, p, kappa, q = np.exp(best.logs) * units[:V_C]
    v_c = best.v_c * unit
    residuals = problem.e - restitution(known["v"], k, p, kappa, q, v_c)
    mean = np.average(problem.e, weights=problem.weight**2)
    total = float(np.sum(np.square(problem.weight * (problem.e - mean))))
    return RestitutionFit(
        k=float(k),
        p=float(p),
        kappa=float(kappa),
        q=float(q) if problem.q is None else problem.q,
        v_c=v_c,
        cov=covariance(problem, best, on_bound) * variance * np.outer(units, units),
        residuals=residuals,
        e=problem.e,
        chi_square=best.chi_square / variance,
        degrees_of_freedom=_freedom(problem, best),
        r_squared=1.0 - best.chi_square / total if np.ptp(problem.e) > 0.0 else 0.0,
        on_bound=on_bound,
        q_fixed=problem.q is not None,
        converged=best.converged,
        starts=best.starts,
        starts_agreeing=best.agreeing,
        **known,
    )


def _variance(problem: Problem, best: Optimum) -> float:
    """Mean square of the residuals per degree of freedom, not below rounding."""
    least = ROUNDING**2 * float(np.mean(np.square(problem.e)))
    return max(best.chi_square / _freedom(problem, best), least)
