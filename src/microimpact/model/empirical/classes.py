"""Capture velocity by classes of one data set, and its exponent in the diameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import scipy
from numpy.typing import ArrayLike

from microimpact.core.arrays import FloatArray, Numbers, checked
from microimpact.core.computable import NotComputable
from microimpact.core.readable import Readable, table
from microimpact.model.empirical.comparison import Comparison, compare_models, with_interval


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class Classes(Readable):
    """Capture velocities of classes, and v_c ~ d^n through them.

    Attributes
    ----------
    compared
        By the name of the class, the smallest spheres first: the models of its data, or the reason
        why there are none.
    exponent, exponent_interval
        n and its interval; None with fewer than two classes that have a diameter and an interval.
    confidence
        Nominal coverage of the intervals.
    laws
        By the name of the model: its n for given materials, and its weight, both means over the
        classes.
    warnings
        What speaks against trusting the numbers, in sentences.
    """

    compared: Mapping[str, Comparison | NotComputable]
    exponent: float | None
    exponent_interval: tuple[float, float] | None
    confidence: float
    laws: Mapping[str, tuple[float, float]]
    warnings: tuple[str, ...] = field(repr=False)

    def summary(self) -> str:
        """Classes with their intervals, the exponent, and those of the laws, as text."""
        rows: list[tuple[str, ...]] = []
        reasons = []
        for name, fit in self.compared.items():
            if isinstance(fit, NotComputable):
                rows.append((name, "", "not computed", "", "", "", ""))
                reasons.append(f"{name}: {fit}")
                continue
            size = "" if fit.diameter is None else f"{1e6 * fit.diameter:.4g}"
            best = fit.models[0]
            cells = with_interval(fit.v_c, fit.v_c_interval)
            rows.append((name, size, *cells, best.name, f"{best.weight:.2f}"))
        header = ("class", "d (um)", "v_c (m/s)", "from", "to", "best model", "weight")
        lines = [table(rows, header), *reasons]
        if self.exponent is None or self.exponent_interval is None:
            return "\n".join([*lines, "No exponent in d: two classes with v_c and d are needed."])
        low, high = self.exponent_interval
        lines.append(
            f"v_c ~ d^n: n = {self.exponent:.3f}, {100 * self.confidence:g} %: {low:.3f} to "
            f"{high:.3f}, the classes weighted by their intervals."
        )
        laws = [
            (name, f"{n:.3f}", "yes" if low <= n <= high else "no", f"{weight:.2f}")
            for name, (n, weight) in self.laws.items()
        ]
        names = ("model", "n of given materials", "in the interval", "mean weight")
        return "\n".join([*lines, table(laws, names)])


def compare_classes(
    classes: ArrayLike,
    v: Numbers,
    e: Numbers,
    sigma: Numbers | None = None,
    sigma_v: Numbers | None = None,
    d: Numbers | None = None,
    size_scatter: Numbers | Literal["free"] | None = None,
    *,
    confidence: float = 0.95,
    **options: Any,
) -> Classes:
    """Fit each class of rebounds, and the exponent n of v_c ~ d^n through the classes.

    n is that of weighted least squares in logarithms: half an interval is the standard deviation
    times its normal quantile. Where classes scatter by more than their intervals, that of n is
    widened, by Student's distribution.

    Parameters
    ----------
    classes
        Name of the class of each row, (n,).
    v, e, sigma, sigma_v, d, size_scatter, confidence, **options
        As of `compare_models`.

    Raises
    ------
    TypeError, ValueError
        As of `compare_models`; a class with too few data costs its row only.
    """
    names = np.ravel(classes).astype(str)
    values: dict[str, Any] = {"v": v, "e": e, "sigma": sigma, "sigma_v": sigma_v, "d": d}
    values["size_scatter"] = size_scatter
    arrays: dict[str, Any] = {
        name: x if x is None or isinstance(x, str) else checked(name, x)
        for name, x in values.items()
    }
    if names.shape != np.shape(arrays["v"]):
        shape = np.shape(arrays["v"])
        raise ValueError(f"classes must be of the shape of v, {shape}, got {names.shape}")
    compared: dict[str, Comparison | NotComputable] = {}
    for name in dict.fromkeys(names.tolist()):
        rows = names == name
        mine = {key: x[rows] if np.ndim(x) else x for key, x in arrays.items()}
        try:
            compared[name] = compare_models(**mine, confidence=confidence, **options)
        except NotComputable as reason:
            compared[name] = reason
    compared = dict(sorted(compared.items(), key=lambda pair: _size(pair[1])))
    fits = {name: fit for name, fit in compared.items() if isinstance(fit, Comparison)}
    warnings = [f"{name}: {word}" for name, fit in fits.items() for word in fit.warnings]
    # An open interval has no standard deviation.
    used = [fit for fit in fits.values() if fit.diameter is not None and fit.v_c_interval[0] > 0.0]
    warnings += [
        f"{name}: the data do not bound v_c, so that the class does not count for the exponent"
        for name, fit in fits.items()
        if fit.diameter is not None and fit not in used
    ]
    exponent, interval = _exponent(used, confidence)
    return Classes(
        compared=compared,
        exponent=exponent,
        exponent_interval=interval,
        confidence=confidence,
        laws=_laws([*fits.values()]),
        warnings=tuple(warnings),
    )


def _size(fit: Comparison | NotComputable) -> float:
    return fit.diameter or 0.0 if isinstance(fit, Comparison) else np.inf


def _exponent(
    used: Sequence[Comparison], confidence: float
) -> tuple[float | None, tuple[float, float] | None]:
    """Slope of ln v_c over ln d, and its interval."""
    x: FloatArray = np.log([float(fit.diameter or np.nan) for fit in used])
    if x.size < 2 or np.ptp(x) == 0.0:
        return None, None
    y: FloatArray = np.log([fit.v_c for fit in used])
    level = 0.5 + 0.5 * confidence
    normal = float(scipy.special.ndtri(level))
    sigma = np.array([np.log(fit.v_c_interval[1] / fit.v_c_interval[0]) for fit in used])
    weight = (2.0 * normal / sigma) ** 2
    middle_x, middle_y = np.average(x, weights=weight), np.average(y, weights=weight)
    information = np.sum(weight * (x - middle_x) ** 2)
    slope = float(np.sum(weight * (x - middle_x) * (y - middle_y)) / information)
    missed = y - middle_y - slope * (x - middle_x)
    spread, quantile = 1.0, normal
    if (freedom := x.size - 2) and (left := np.sum(weight * missed**2) / freedom) > 1.0:
        spread, quantile = left, float(scipy.special.stdtrit(freedom, level))
    half = quantile * float(np.sqrt(spread / information))
    return slope, (slope - half, slope + half)


def _laws(fits: Sequence[Comparison]) -> dict[str, tuple[float, float]]:
    """Mean exponent and weight of each model, the heaviest first."""
    by_name: dict[str, list[tuple[float, float]]] = {}
    for fit in fits:
        for model in fit.models:
            by_name.setdefault(model.name, []).append((model.size_exponent, model.weight))
    means = {
        name: (float(np.mean([n for n, _ in pairs])), sum(w for _, w in pairs) / len(fits))
        for name, pairs in by_name.items()
    }
    return dict(sorted(means.items(), key=lambda pair: -pair[1][1]))
