"""What a fit of Eq. (34) found, and its summary."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from microimpact.arrays import FloatArray
from microimpact.model.restitution import restitution
from microimpact.model.restitution_search import Optimum, Problem, model

NAMES = ("k", "p", "kappa", "q", "v_c")
UNITS = ("m/s", "", "m/s", "", "m/s")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RestitutionFit:
    """Eq. (34) fitted to data; ``str(fit)`` is a summary.

    Attributes
    ----------
    k, p, kappa, q, v_c
        Parameters as in `microimpact.model.restitution.restitution`; k, kappa, v_c in m/s.
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
