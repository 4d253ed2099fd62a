"""Uncertainty of the capture velocity of Eq. (34) by parametric bootstrap."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from microimpact.core.arrays import FloatArray, whole
from microimpact.core.readable import Readable
from microimpact.model.empirical.data import in_own_units
from microimpact.model.empirical.fit import CONFIDENCE, RestitutionFit, scalar
from microimpact.model.empirical.kernel import V_C
from microimpact.model.empirical.search import CLOSEST, fit_batch


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class CaptureBootstrap(Readable):
    """Parametric bootstrap of v_c; ``str(sample)`` is a summary.

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
    sample: FloatArray = field(repr=False)
    on_bound: int
    confidence: float

    @property
    def median(self) -> float:
        """Median of the sample, m/s."""
        return float(np.median(self.sample))

    def summary(self) -> str:
        """Median, interval and size of the sample, as text."""
        low, high = self.interval
        return (
            f"v_c = {self.median:.6g} m/s [{low:.6g}, {high:.6g}] (median and percentile interval, "
            f"{100 * self.confidence:g} %, of {self.sample.size} replicates; "
            f"{self.on_bound} with v_c on a bound)"
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
    whole("replicates", replicates, 1)
    whole("seed", seed, 0)
    level = scalar("confidence", confidence, CONFIDENCE)
    curve = fit.curve(fit.v)
    streams = (np.random.SeedSequence(seed, spawn_key=(*spawn_key, i)) for i in range(replicates))
    noise = np.stack([np.random.default_rng(each).standard_normal(curve.size) for each in streams])
    e = np.where(curve > 0.0, np.maximum(curve + fit.sigma * noise, 0.0), 0.0)
    if np.any(none := ~np.any(e > 0.0, axis=1)):
        raise RuntimeError(f"no sphere rebounds in replicate {none.argmax()}: sigma is too large")
    v, weight = (np.tile(row, (replicates, 1)) for row in (fit.v, fit.sigma.min() / fit.sigma))
    sets = in_own_units(v, e, weight, fit.q if fit.q_fixed else None)
    truth = np.tile(fit.parameters, (replicates, 1))
    truth[:, [0, 2, V_C]] /= sets.unit[:, None]
    truth[:, V_C] = np.clip(truth[:, V_C], CLOSEST, 1.0)
    fits = fit_batch(sets, guess=np.log(truth))
    tail = 0.5 * (1.0 - level)
    low, high = np.quantile(fits.v_c, [tail, 1.0 - tail]).tolist()
    return CaptureBootstrap(
        interval=(low, high),
        sample=fits.v_c,
        on_bound=int(np.count_nonzero(fits.capture_on_bound)),
        confidence=level,
    )
