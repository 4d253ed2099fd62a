"""Energy loss over the angle: where it falls, and whether it tells two restitutions apart."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from microimpact.lab.reduction import Mean
from microimpact.model.dynamics.impact import velocity_components
from microimpact.model.rigid_body.algebra import energy_loss, rigid_body_rebound
from study.declared.parameters import AngleDegrees, Fraction, NonNegative
from study.samples import Dropped, Sample, Sampling, half_width
from study.tables import Tables

# Angles at which the slope of the rigid body's energy loss is looked at.
LOSS_ANGLES = 23


@dataclass(frozen=True, slots=True, kw_only=True)
class Loss:
    """Energy loss of the rigid body, and of steel and spores at one angle."""

    # Grid on which the slope of the energy loss is looked at, and ends of its angles.
    restitutions: tuple[Fraction, ...]
    frictions: tuple[NonNegative, ...]
    angles_deg: tuple[AngleDegrees, AngleDegrees]
    # Angle and restitutions of steel and spores there.
    resolved_deg: AngleDegrees
    resolved_restitutions: tuple[Fraction, Fraction]
    # Samples that give the scatter.
    resolved_steel: Dropped
    resolved_spore: Dropped


def loss_tables(params: Loss, sampling: Sampling, inputs: Tables) -> dict[str, pd.DataFrame]:
    """Return the tables, by name."""
    return {
        "loss_slopes": pd.DataFrame(loss_slopes(params)),
        "loss_resolution": pd.DataFrame([resolution(params, sampling, inputs)]),
    }


def departures(
    angles: Sequence[float], losses: Sequence[Mean], sampling: Sampling
) -> Iterator[float]:
    """Yield the angles at which a loss differs from the first by more than its half-width."""
    for angle, loss in zip(angles[1:], losses[1:], strict=True):
        if abs(loss.value - losses[0].value) > half_width(loss, losses[0], sampling):
            yield angle


def loss_slopes(params: Loss) -> Iterator[dict[str, Any]]:
    """Share of angles at which the rigid body's energy loss falls as the angle becomes shallow."""
    angle = np.linspace(*params.angles_deg, LOSS_ANGLES)
    for e, friction in product(params.restitutions, params.frictions):
        falling = np.diff(rigid_loss(e, friction, angle)) / np.diff(angle) > 0.0
        yield {
            "restitution": e,
            "friction": friction,
            "share_falling": float(np.mean(falling)),
            "evidence": "computed",
        }


def rigid_loss(e: float, friction: float, angle: np.ndarray) -> np.ndarray:
    """Return T_L of a rigid sphere without spin at angles in degrees, Eqs. (12)-(14)."""
    v_n, v_t = velocity_components(1.0, angle)
    rebound = rigid_body_rebound(v_n, v_t, 0.0, 1.0, e, friction)
    return np.asarray(energy_loss(v_n, v_t, 0.0, 1.0, e, rebound.mu).translational)


def resolution(params: Loss, sampling: Sampling, inputs: Tables) -> dict[str, Any]:
    """Differences of printed restitutions and losses against the resolution of 40 events."""
    angle, both = params.resolved_deg, (params.resolved_steel, params.resolved_spore)
    smooth, rough = (Sample.of(dropped, sampling, inputs).seen(angle).means for dropped in both)
    e = params.resolved_restitutions
    losses = [
        float(rigid_loss(value, dropped.friction, np.array(angle)))
        for value, dropped in zip(e, both, strict=True)
    ]
    width, width_of_loss = (
        half_width(smooth[name], rough[name], sampling) for name in ("restitution", "energy_loss")
    )
    return {
        "difference_of_restitutions": e[0] - e[1],
        "difference_of_restitutions_over_half_width": (e[0] - e[1]) / width,
        "difference_of_losses": losses[1] - losses[0],
        "difference_of_losses_over_half_width": (losses[1] - losses[0]) / width_of_loss,
        "evidence": "virtual experiment",
    }
