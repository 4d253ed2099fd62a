"""How well means of events and shares of counted cases are known."""

from __future__ import annotations

import numpy as np

from microimpact.core.arrays import BoolArray, FloatArray, Real

CONFIDENCE = 0.95
# Half-width of such an interval over the standard error of a mean of many events.
ERROR_BAR = 1.96


def student_half_width(
    sd: Real,
    events: int,
    systematic: Real = 0.0,
    level: float = CONFIDENCE,
    freedom: int | None = None,
) -> FloatArray:
    """Return half the width of the interval of a mean of events, by Student's t.

    Parameters
    ----------
    sd
        Standard deviation of the events; of a difference of two means of as many events, the
        root of the sum of both squares.
    events
        Number of events, at least 2.
    systematic
        Standard uncertainty of the mean from all errors shared by the events; broadcasts with
        ``sd``.
    level
        Probability that the interval holds the true mean.
    freedom
        Degrees of freedom, if not one less than events.
    """
    from scipy.special import stdtrit

    t = stdtrit(events - 1 if freedom is None else freedom, 0.5 * (1.0 + level))
    return np.asarray(t * np.sqrt(np.square(sd) / events + np.square(systematic)))


def mean_and_error(values: FloatArray | BoolArray) -> tuple[float, float]:
    """Return a mean and its standard error; nan of too few values."""
    n = len(values)
    mean = float(np.mean(values)) if n else float("nan")
    return mean, float(np.std(values, ddof=1) / np.sqrt(n)) if n > 1 else float("nan")


def wilson_interval(part: float, whole: float) -> tuple[float, float]:
    """Ends of the 95 % interval of a share by Wilson's score.

    SciPy's `scipy.stats.binomtest` gives the same, and takes half a second to import.

    Parameters
    ----------
    part, whole
        Number of cases counted, and of all cases; of weighted ones their effective numbers.
    """
    from scipy.special import ndtri

    z = float(ndtri(0.5 * (1.0 + CONFIDENCE)))
    share, scale = part / whole, 2.0 * (whole + z**2)
    centre = (2.0 * part + z**2) / scale
    half = z / scale * float(np.sqrt(4.0 * part * (1.0 - share) + z**2))
    return (centre - half if part else 0.0), (centre + half if part < whole else 1.0)
