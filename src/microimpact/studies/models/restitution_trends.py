"""Trends of R, rho and e with the normal impact speed (Fig. 14, a schematic)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from microimpact.core.tables import series_frame
from microimpact.declared.parameters import Count, Positive
from microimpact.model.empirical.equations import (
    adhesion_coefficient,
    body_restitution,
    restitution,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Constants of Eqs. 32 and 33 and the range of speeds to show."""

    body_speed_m_per_s: Positive
    body_exponent: Positive
    adhesion_speed_m_per_s: Positive
    adhesion_exponent: Positive
    capture_speed_m_per_s: Positive
    largest_speed_m_per_s: Positive
    points: Count

    def __post_init__(self) -> None:
        """Refuse a range of speeds without rebound."""
        if self.largest_speed_m_per_s <= self.capture_speed_m_per_s:
            raise ValueError(
                f"largest_speed_m_per_s {self.largest_speed_m_per_s} must be above"
                f" capture_speed_m_per_s {self.capture_speed_m_per_s}"
            )


def run(params: Params, inputs: Mapping[str, pd.DataFrame]) -> Mapping[str, pd.DataFrame]:
    """Return the data of Fig. 14.

    Parameters
    ----------
    params
        Parameters of the study.
    inputs
        Not used.

    Returns
    -------
    mapping
        ``fig14``: the three coefficients against speed in m/s, on a grid that contains the
        capture velocity, and an upright line at that velocity.
    """
    v_c = params.capture_speed_m_per_s
    speed = np.linspace(0.0, params.largest_speed_m_per_s, params.points)
    speed = np.union1d(speed, [v_c])
    k, p = params.body_speed_m_per_s, params.body_exponent
    kappa, q = params.adhesion_speed_m_per_s, params.adhesion_exponent
    curves: list[tuple[str, ArrayLike, ArrayLike]] = [
        ("body restitution", speed, body_restitution(speed, k, p)),
        ("adhesion", speed, adhesion_coefficient(speed, kappa, q, v_c)),
        ("overall restitution", speed, restitution(speed, k, p, kappa, q, v_c)),
        ("capture velocity", [v_c, v_c], [0.0, 1.0]),
    ]
    frames = [
        series_frame(
            panel="trends",
            series=name,
            evidence="computed",
            x=x,
            y=y,
            x_unit="m_per_s",
            y_unit="1",
        )
        for name, x, y in curves
    ]
    return {"fig14": pd.concat(frames, ignore_index=True)}
