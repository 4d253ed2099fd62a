"""Impulse ratio against angle of incidence for Coulomb friction (Fig. 17, rigid body model)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from microimpact.model.rigid_body.algebra import rigid_body_rebound
from study.contacts import all_printed
from study.declared.parameters import Finite, Fraction, NonNegative, Points, Positive
from study.tables import Tables, series_frame

_frame = partial(series_frame, x_unit="deg", y_unit="1")


PRINTED_VALUES = ("impulse_ratio_normal_incidence_no_spin",)


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Friction coefficients without spin, and initial spins at one friction coefficient.

    A spin ratio is r omega / v: the peripheral speed over the speed of the sphere, positive
    in the sense of rolling.
    """

    restitution: Fraction
    friction: tuple[NonNegative, ...]
    spin_ratio: tuple[Finite, ...]
    spin_friction: Positive
    points: Points


def run(params: Params, inputs: Tables) -> Tables:
    """Return the data of Fig. 17.

    ``fig17``: impulse ratio (-mu of Eq. 2) against the angle in degrees. Panel ``friction``: one
    series per friction coefficient, no spin. Panel ``spin``: one series per spin ratio.
    """
    angle = np.linspace(0.0, 90.0, params.points + 1)[1:]
    frames = []
    for friction in params.friction:
        ratio = impulse_ratio(angle, params.restitution, friction, 0.0)
        frames.append(_frame("friction", f"{friction:g}", angle, ratio))
    for name, value in all_printed(inputs).items():
        frames.append(_frame("friction", str(name), 90.0, value, "printed"))
    for spin_ratio in params.spin_ratio:
        ratio = impulse_ratio(angle, params.restitution, params.spin_friction, spin_ratio)
        frames.append(_frame("spin", f"{spin_ratio:g}", angle, ratio))
    return {"fig17": pd.concat(frames, ignore_index=True)}


def impulse_ratio(
    angle: NDArray[np.float64], restitution: float, friction: float, spin_ratio: float
) -> NDArray[np.float64]:
    """Return the impulse ratio -mu of the rigid body model, which depends on no scale.

    Shape of `angle`; positive when friction opposes the tangential velocity.

    Parameters
    ----------
    angle
        Angle of incidence from the surface in degrees, in (0, 90].
    restitution
        Coefficient of restitution e.
    friction
        Friction coefficient f.
    spin_ratio
        Initial r omega / v.
    """
    alpha = np.radians(angle)
    # cos(90 deg) is not exactly 0 in floating point, but the tangential velocity there is.
    v_t = np.where(angle == 90.0, 0.0, np.cos(alpha))
    rebound = rigid_body_rebound(-np.sin(alpha), v_t, spin_ratio, 1.0, restitution, friction)
    return 0.0 - np.asarray(rebound.mu)
