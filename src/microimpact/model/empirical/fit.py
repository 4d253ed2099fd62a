"""Fit of the empirical restitution curve, Eq. (34), and the uncertainty of its capture velocity.

The curve is clipped: e = 0 at and below v_c. A captured sphere, e = 0, is a datum like any other,
of zero misfit while v_c lies above its speed; no sphere that rebounds can be slower than v_c, so
0 <= v_c <= the smallest rebounding speed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microimpact.core.arrays import POSITIVE, FloatArray, Range, checked
from microimpact.core.readable import Readable
from microimpact.model.empirical.data import DataSets, data_sets, measurements, require_telling
from microimpact.model.empirical.equations import restitution
from microimpact.model.empirical.intervals import Intervals, interval_batch
from microimpact.model.empirical.kernel import V_C
from microimpact.model.empirical.search import CLOSEST, STARTS, BatchFit, fit_batch, model

NAMES = ("k", "p", "kappa", "q", "v_c")
UNITS = ("m/s", "", "m/s", "", "m/s")
# A standard error of this many times the value leaves the parameter open.
OPEN = 10.0
# A chi-square that fewer than this share of data sets would exceed is too large for the curve.
TOO_LARGE = 0.01


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class RestitutionFit(Readable):
    """Eq. (34) fitted to data; ``str(fit)`` is a summary.

    Attributes
    ----------
    k, p, kappa, q, v_c
        Parameters as in `microimpact.model.empirical.equations.restitution`; k, kappa, v_c in m/s.
    v_c_interval
        Profile likelihood interval of v_c, m/s.
    v_c_interval_limited
        For each end of it, whether it is set by the admissible range, 0 to the smallest
        rebounding speed, and not by the values of e. An end within 0.1 % of that speed is.
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
        Names of free parameters that ended on a bound; v_c also where it is fixed by the speed of
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


def covariance(sets: DataSets, fit: BatchFit) -> FloatArray:
    """Covariance of k, p, kappa, q, v_c of one data set, as its weights are, in m/s."""
    logs, unit = fit.logs(sets)[0, :V_C], sets.unit[0]
    gap = max(1.0 - fit.v_c[0] / unit, 0.0)
    slopes = model(sets.v[0], logs, 1.0, gap)[1] * sets.weight[0, :, None]
    held = fit.at_bound[0]
    free = np.array([True, True, True, sets.q is None, True]) & ~held
    natural = np.append(fit.parameters[0, :V_C], -gap * unit)  # d/d ln(gap) = -gap d/d v_c
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
        elif errors[name] > OPEN * value:
            spread = "not determined by the data"
        if name == "v_c":
            spread = f"{_interval(fit)} (profile likelihood, {100 * fit.confidence:g} %)"
            spread += ", on a bound" * (name in fit.on_bound)
        lines.append(f"  {name:5s} = {value:<10.6g} {unit:3s} {spread}")
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
    lines.append(f"  {_trust(fit)}")
    return "\n".join(lines)


def _trust(fit: RestitutionFit) -> str:
    """Supposition behind the errors and the interval, in words."""
    from scipy.special import chdtrc

    if not fit.sigma_estimated and chdtrc(fit.degrees_of_freedom, fit.chi_square) < TOO_LARGE:
        return "chi-square is too large for sigma: the curve does not hold, nor does the interval"
    return "errors and interval suppose that Eq. (34), with this q if fixed, is the true curve"


def _interval(fit: RestitutionFit) -> str:
    low, high = fit.v_c_interval
    left, right = (" (end of range)" if limited else "" for limited in fit.v_c_interval_limited)
    return f"[{low:.6g}{left}, {high:.6g}{right}]"


# Measured with noise, e may come out somewhat above 1; far above it is no normal impact.
MEASURED_E = Range(lower=0.0, upper=1.2, lower_closed=True, upper_closed=True)
SIGMA = Range(lower=1e-12, upper=1e12, lower_closed=True, upper_closed=True)
CONFIDENCE = Range(lower=0.0, upper=1.0)
# Below this share of the data a misfit is rounding.
ROUNDING = 1e-10
# Below this share of chi-square a difference of it is.
PROFILE_ROUNDING = 1e-7
# Tolerance of the search for a single fit.
TOLERANCE = 1e-11
# A profile lower by more than this share of the admissible rise met another minimum.
OVERLOOKED = 1e-4


def fit_restitution(
    v: ArrayLike,
    e: ArrayLike,
    sigma: ArrayLike | None = None,
    q: float | None = None,
    *,
    confidence: float = 0.95,
) -> RestitutionFit:
    """Fit Eq. (34) to coefficients of restitution by weighted least squares.

    The global minimum is sought from several starts. Errors and interval suppose that Eq. (34),
    with q as given if it is, is the true curve; of a curve that it only resembles they say nothing,
    and v_c may lie far outside. The interval of v_c holds every value whose
    least chi-square, over all other parameters, exceeds the minimum by less than the quantile of
    chi-square with one degree of freedom; if sigma is estimated, by less than the quantile of F.

    Parameters
    ----------
    v
        Normal impact speeds (n,), m/s; positive.
    e
        Coefficients of restitution (n,), in [0, 1.2]; 0 for a captured sphere.
    sigma
        Standard deviation of e, one number or (n,); 1e-12 to 1e12. None: one number for all,
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
    spread = 1.0 if sigma is None else sigma
    speed, measured, spread = measurements(v, e, spread, MEASURED_E, SIGMA)
    fixed = None if q is None else scalar("q", q)
    level = scalar("confidence", confidence, CONFIDENCE)
    free = 5 if fixed is None else 4
    require_telling(speed, measured, free + 1, free)
    # Relative weights: the tolerances of the search are absolute in part.
    least = float(spread.min())
    sets = data_sets(speed, measured, least / spread, fixed)
    known = None if sigma is None else least**2
    fit, interval, starts = _search(sets, level, known)
    variance = _variance(sets, fit) if known is None else known
    low, high = interval.ends[0].tolist()
    left, right = interval.limited[0].tolist()
    return _result(
        sets,
        fit,
        variance,
        v=speed,
        sigma=np.sqrt(variance) / sets.weight[0],
        sigma_estimated=sigma is None,
        v_c_interval=(low, high),
        v_c_interval_limited=(left, right),
        confidence=level,
        starts=starts,
    )


def scalar(name: str, value: object, allowed: Range = POSITIVE) -> float:
    """Return one real number in range, or raise as `checked` does.

    Parameters
    ----------
    name
        Argument that is checked.
    value
        What was given.
    allowed
        Range of the number.
    """
    number = checked(name, value, allowed)
    if not isinstance(number, float):
        raise TypeError(f"{name} must be one real number, got {value!r}")
    return number


def _search(
    sets: DataSets, level: float, variance: float | None
) -> tuple[BatchFit, Intervals, int]:
    """Minimum, interval of v_c, and number of searches."""
    fit, starts = fit_batch(sets, len(STARTS), tolerance=TOLERANCE), len(STARTS)
    rounding = ROUNDING**2 * float(np.sum(np.square(sets.weight * sets.e)))
    while True:
        rise = _admissible_rise(sets, fit, level, variance)
        least = float(fit.chi_square[0])
        rise = max(rise, rounding, PROFILE_ROUNDING * least)
        interval = interval_batch(sets, fit, rise)
        if interval.least[0] >= least - OVERLOOKED * rise:
            return fit, interval, starts
        # The profile met a lower point: an overlooked minimum lies there or lower still.
        fit = fit_batch(sets, len(STARTS), interval.at, TOLERANCE)
        starts = len(STARTS) + 1


def _freedom(sets: DataSets, fit: BatchFit) -> int:
    """Degrees of freedom; captured points below v_c cannot miss and do not count."""
    telling = (sets.e[0] > 0.0) | (sets.v[0] > (1.0 + CLOSEST) * fit.v_c[0] / sets.unit[0])
    return int(telling.sum()) - sets.free


def _admissible_rise(sets: DataSets, fit: BatchFit, level: float, variance: float | None) -> float:
    """Rise of chi-square at the ends of the interval: a quantile of chi-square(1) or F(1, n)."""
    from scipy.special import chdtri, fdtri

    if variance is not None:
        return variance * float(chdtri(1.0, 1.0 - level))
    return _variance(sets, fit) * float(fdtri(1.0, _freedom(sets, fit), level))


def _result(sets: DataSets, fit: BatchFit, variance: float, **known: Any) -> RestitutionFit:
    """The fit of one data set; ``variance`` scales the squares of the standard deviations."""
    e, chi_square = sets.e[0], float(fit.chi_square[0])
    parameters = dict(zip(NAMES, fit.parameters[0].tolist(), strict=True))
    mean = np.average(e, weights=sets.weight[0] ** 2)
    total = float(np.sum(np.square(sets.weight[0] * (e - mean))))
    return RestitutionFit(
        **parameters,
        cov=covariance(sets, fit) * variance,
        residuals=e - restitution(known["v"], **parameters),
        e=e,
        chi_square=chi_square / variance,
        degrees_of_freedom=_freedom(sets, fit),
        r_squared=1.0 - chi_square / total if np.ptp(e) > 0.0 else 0.0,
        on_bound=tuple(np.array(NAMES)[fit.at_bound[0]].tolist()),
        q_fixed=sets.q is not None,
        converged=bool(fit.converged[0]),
        starts_agreeing=int(fit.agreeing[0]),
        **known,
    )


def _variance(sets: DataSets, fit: BatchFit) -> float:
    """Mean square of the residuals per degree of freedom, not below rounding."""
    least = ROUNDING**2 * float(np.mean(np.square(sets.e)))
    return max(float(fit.chi_square[0]) / _freedom(sets, fit), least)
