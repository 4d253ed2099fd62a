"""From events to a plotted point: mean and 95 % interval of an experiment (Section 2.1)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from microimpact.core.arrays import FloatArray, checked
from microimpact.lab.events import Measured
from microimpact.statistics.intervals import student_half_width

FEWEST_EVENTS = 2
QUANTITIES = ("restitution", "impulse_ratio", "energy_loss")


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
        With fewer than two events, or a value that is masked or not finite.
    """
    values = np.asarray(checked("values", values))
    n = values.size
    if n < FEWEST_EVENTS:
        raise ValueError(f"an interval needs at least {FEWEST_EVENTS} events, got {n}")
    sd = float(np.std(values, ddof=1))
    shared = np.sqrt(np.sum(np.square(np.asarray(systematic, dtype=float))))
    half = float(student_half_width(sd, n, shared, level))
    centre = float(np.mean(values))
    return Mean(value=centre, low=centre - half, high=centre + half, events=n, sd=sd)


def quantities(measured: Measured) -> dict[str, FloatArray]:
    """Return restitution, impulse ratio and energy loss (Eqs. 1-3) of every event."""
    return {
        "restitution": measured.coefficient_of_restitution,
        "impulse_ratio": measured.impulse_ratio,
        "energy_loss": measured.translational_energy_loss,
    }


def reduced(
    measured: Measured,
    shifted: Callable[[Measured, float], Measured],
    error: float,
    names: tuple[str, ...] = QUANTITIES,
) -> dict[str, Mean]:
    """Return mean and interval of quantities, with one error that all events share.

    Parameters
    ----------
    measured
        At least two events.
    shifted
        Gives the events as they would be if the instrument's setting were off by so much.
    error
        Standard uncertainty of that setting.
    names
        Quantities that the instrument measures.

    Raises
    ------
    ValueError
        With fewer than two events.
    """
    high, low = (quantities(shifted(measured, sign * error)) for sign in (1.0, -1.0))
    values = quantities(measured)
    return {
        name: mean_interval(values[name], systematic=0.5 * abs(np.mean(high[name] - low[name])))
        for name in names
    }
