"""From events to a plotted point: mean and 95 % interval of an experiment (Section 2.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from microimpact.statistics.intervals import student_half_width

FEWEST_EVENTS = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Mean:
    """Mean of an experiment with its interval.

    Attributes
    ----------
    value, low, high
        Mean and ends of the interval.
    events
        Number of events averaged.
    sd
        Standard deviation of the events.
    """

    value: float
    low: float
    high: float
    events: int
    sd: float


def mean_interval(values: ArrayLike, systematic: ArrayLike = 0.0, level: float = 0.95) -> Mean:
    """Return the mean of the events and its interval.

    The half width is ``t sqrt(s^2/n + sum B_i^2)``: finite sampling and measurement noise show in
    the scatter s of the events; errors that an experiment shares do not, and enter by their
    standard uncertainty B_i.

    Parameters
    ----------
    values
        Of the events, shape (n,).
    systematic
        Standard uncertainties of the mean from errors shared by all events, any shape.
    level
        Probability that the interval holds the true mean.

    Raises
    ------
    ValueError
        With fewer than two events.
    """
    values = np.asarray(values, dtype=float)
    n = values.size
    if n < FEWEST_EVENTS:
        raise ValueError(f"an interval needs at least {FEWEST_EVENTS} events, got {n}")
    sd = float(np.std(values, ddof=1))
    shared = np.sqrt(np.sum(np.square(np.asarray(systematic, dtype=float))))
    half = float(student_half_width(sd, n, shared, level))
    centre = float(np.mean(values))
    return Mean(value=centre, low=centre - half, high=centre + half, events=n, sd=sd)
