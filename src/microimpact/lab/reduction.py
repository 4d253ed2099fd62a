"""From events to a plotted point: mean and 95 % interval of an experiment (Section 2.1)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microimpact.core.arrays import FloatArray, Real, checked
from microimpact.core.computable import NotComputable
from microimpact.lab.events import Measured
from microimpact.model.dynamics.impact import Impact
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
    sd
        Standard deviation of the events.
    systematic
        Standard uncertainty of the mean from errors that the events share.
    """

    value: float
    low: float
    high: float
    sd: float
    systematic: float


# Of too few events, and an exactly known number to compare with.
NO_MEAN, EXACT = (Mean(**dict.fromkeys(Mean.__dataclass_fields__, x)) for x in (np.nan, 0.0))


def mean_interval(values: ArrayLike, systematic: float = 0.0) -> Mean:
    """Return the mean of the events and its 95 % interval.

    The half width is ``t sqrt(s^2/n + B^2)``: finite sampling and measurement noise show in the
    scatter s of the events; errors that an experiment shares do not, and enter by their standard
    uncertainty B.

    Parameters
    ----------
    values
        Of the events, shape (n,).
    systematic
        Standard uncertainty of the mean from errors shared by all events.

    Raises
    ------
    ValueError
        With fewer than two events, or a value that is masked or not finite.
    """
    values = np.asarray(checked("values", values))
    n = values.size
    if n < FEWEST_EVENTS:
        raise NotComputable(f"an interval needs at least {FEWEST_EVENTS} events, got {n}")
    sd = float(np.std(values, ddof=1))
    half = float(student_half_width(sd, n, systematic))
    centre = float(np.mean(values))
    low, high = centre - half, centre + half
    return Mean(value=centre, low=low, high=high, sd=sd, systematic=systematic)


def quantities(measured: Measured | Impact) -> dict[str, FloatArray]:
    """Return restitution, impulse ratio and energy loss (Eqs. 1-3) of every event or impact."""
    return {
        "restitution": measured.coefficient_of_restitution,
        "impulse_ratio": measured.impulse_ratio,
        "energy_loss": measured.translational_energy_loss,
    }


def shared_error(
    measured: Measured, shifted: Callable[[Measured, Any], Measured], error: Real
) -> dict[str, FloatArray]:
    """Return the standard uncertainty of every mean from an error that all events share.

    Parameters
    ----------
    measured
        Events, of several experiments along the first axes.
    shifted
        Gives the events as they would be if the instrument's setting were off by so much.
    error
        Standard uncertainty of that setting, one for all or one per experiment.
    """
    high, low = (quantities(shifted(measured, sign * error)) for sign in (1.0, -1.0))
    return {name: 0.5 * np.abs((high[name] - low[name]).mean(axis=-1)) for name in high}


def reduced(
    measured: Measured,
    shifted: Callable[[Measured, Any], Measured],
    error: float,
    fewest: int,
    names: tuple[str, ...] = QUANTITIES,
) -> dict[str, Mean]:
    """Return mean and interval of the quantities that an instrument measures.

    Parameters
    ----------
    measured, shifted, error
        As of `shared_error`, of one experiment.
    fewest
        Number of events below which there is no mean.
    names
        Names of the quantities.
    """
    if len(measured) < fewest:
        return dict.fromkeys(names, NO_MEAN)
    values, systematic = quantities(measured), shared_error(measured, shifted, error)
    return {name: mean_interval(values[name], float(systematic[name])) for name in names}


def interval_columns(
    means: Mapping[str, Mean], *names: str, ends: tuple[str, ...] = ("low", "high")
) -> dict[str, float]:
    """Return means with their intervals as columns of a table, nan where there is none.

    Parameters
    ----------
    means
        Means by name.
    *names
        Those that become columns.
    ends
        Suffixes of the columns of the ends.
    """
    columns: dict[str, float] = {}
    for name in names:
        mean = means.get(name, NO_MEAN)
        columns |= {name: mean.value} | {f"{name}_{end}": getattr(mean, end) for end in ends}
    return columns
