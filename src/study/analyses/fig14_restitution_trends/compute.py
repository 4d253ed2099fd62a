"""Trends of R, rho and e with the normal impact speed (Fig. 14, a schematic)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Annotated

import numpy as np
import pandas as pd

from microimpact.model.empirical.equations import (
    adhesion_coefficient,
    body_restitution,
    restitution,
)
from study.declared.parameters import Must, Points, Positive
from study.tables import Tables, series_frame


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Constants of Eqs. 32 and 33 and the range of speeds to show."""

    body_speed_m_per_s: Positive
    body_exponent: Positive
    adhesion_speed_m_per_s: Positive
    adhesion_exponent: Positive
    capture_speed_m_per_s: Positive
    largest_speed_m_per_s: Annotated[Positive, Must("above", "capture_speed_m_per_s")]
    points: Points


def run(params: Params, inputs: Tables) -> Tables:
    """Return the data of Fig. 14.

    ``fig14``: the three coefficients against speed in m/s, on a grid that contains the capture
    velocity, and an upright line at that velocity.
    """
    v_c = params.capture_speed_m_per_s
    speed = np.linspace(0.0, params.largest_speed_m_per_s, params.points)
    speed = np.union1d(speed, [v_c])
    k, p = params.body_speed_m_per_s, params.body_exponent
    kappa, q = params.adhesion_speed_m_per_s, params.adhesion_exponent
    frame = partial(series_frame, "trends", x_unit="m_per_s", y_unit="1")
    frames = [
        frame("body restitution", speed, body_restitution(speed, k, p)),
        frame("adhesion", speed, adhesion_coefficient(speed, kappa, q, v_c)),
        frame("overall restitution", speed, restitution(speed, k, p, kappa, q, v_c)),
        frame("capture velocity", v_c, [0.0, 1.0]),
    ]
    return {"fig14": pd.concat(frames, ignore_index=True)}
