"""Fit of the empirical restitution curve, Eq. (34), and the uncertainty of its capture velocity.

The curve is clipped: e = 0 at and below v_c. A captured sphere, e = 0, is a datum like any other,
of zero misfit while v_c lies above its speed; no sphere that rebounds can be slower than v_c, so
0 <= v_c <= the smallest rebounding speed.
"""

from __future__ import annotations

from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microimpact.arrays import POSITIVE, FloatArray, Range, checked
from microimpact.model.restitution import restitution
from microimpact.model.restitution_result import (
    NAMES,
    CaptureBootstrap,
    RestitutionFit,
    covariance,
)
from microimpact.model.restitution_search import (
    CLOSEST,
    ON_BOUND,
    V_C,
    Optimum,
    Problem,
    minimum,
    profile_interval,
)

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
