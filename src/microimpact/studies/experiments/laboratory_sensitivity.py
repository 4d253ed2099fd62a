"""What the assumed spreads of the laboratory do to its means: each halved and doubled."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.core.tables import Tables
from microimpact.declared.parameters import Count, Keyed, Name, NonNegative, Positive
from microimpact.lab.dispenser import Dispenser
from microimpact.lab.events import Impacts
from microimpact.lab.ptis.experiment import turned
from microimpact.lab.reduction import QUANTITIES, quantities
from microimpact.lab.samples import (
    FEWEST_REBOUNDS,
    Dropped,
    Sampling,
    contact_of,
    impacts_of,
    in_class,
)
from microimpact.model.contact import Contact
from microimpact.statistics.distributions import TruncatedNormal, generator

NEEDS = {"calibration": ("calibration",)}

Spread = Literal[
    "exit_speed",
    "lateral_speed",
    "lateral_position",
    "diameter_sd",
    "spin_sd",
    "surface_slope",
    "particle_slope",
    "velocity_noise",
    "angle_error",
]
# Errors of measurement, which leave the true impacts alone.
LAID_OVER = ("velocity_noise", "angle_error")


@dataclass(frozen=True, slots=True, kw_only=True)
class BaseSeries:
    """What is dropped, and which of its spreads are varied."""

    name: Name
    dropped: Dropped
    spreads: tuple[Spread, ...]

    def __post_init__(self) -> None:
        """Refuse sizes whose spread has no name."""
        if not isinstance(self.dropped.diameter_um, TruncatedNormal):
            raise ValueError("dropped.diameter_um: must be a truncated normal distribution")


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Series, factors and the errors of measurement."""

    seed: Annotated[int, Field(ge=0)]
    impacts: Count
    series: Annotated[tuple[BaseSeries, ...], Keyed("name")]
    angles_deg: tuple[Annotated[float, Field(gt=0, lt=90)], ...]
    factors: tuple[Positive, ...]
    dispenser: Dispenser
    # Standard deviation of a measured velocity component over the speed.
    velocity_noise_relative: NonNegative
    # Unknown tilt of the target; the means are compared with it and with a multiple.
    angle_error_deg: NonNegative


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """All spreads of one sample."""

    dropped: Dropped
    dispenser: Dispenser
    velocity_noise: float
    angle_error: float

    def scaled(self, spread: Spread, factor: float) -> Setting:
        """Return the setting with one spread multiplied."""
        dropped, dispenser = self.dropped, self.dispenser
        sizes = dropped.diameter_um
        assert isinstance(sizes, TruncatedNormal)
        changes: dict[str, Any] = {
            "exit_speed": {"exit_speed_m_per_s": factor * dispenser.exit_speed_m_per_s},
            "lateral_speed": {"lateral_speed_m_per_s": factor * dispenser.lateral_speed_m_per_s},
            "lateral_position": {"lateral_position_mm": factor * dispenser.lateral_position_mm},
            "diameter_sd": {"diameter_um": replace(sizes, sd=factor * sizes.sd)},
            "spin_sd": {"spin": replace(dropped.spin, sd=factor * dropped.spin.sd)},
            "surface_slope": {"surface_slope": factor * dropped.surface_slope},
            "particle_slope": {"particle_slope": factor * dropped.particle_slope},
            "velocity_noise": {"velocity_noise": factor * self.velocity_noise},
            "angle_error": {"angle_error": factor * self.angle_error},
        }
        if spread in LAID_OVER:
            return replace(self, **changes[spread])
        if spread in {"exit_speed", "lateral_speed", "lateral_position"}:
            return replace(self, dispenser=replace(dispenser, **changes[spread]))
        return replace(self, dropped=replace(dropped, **changes[spread]))


def run(params: Params, inputs: Tables) -> Tables:
    """Vary every spread alone, on common random numbers.

    ``laboratory_sensitivity``: base mean, change and its standard error, per series, angle, spread,
    factor and quantity.
    """
    return {"laboratory_sensitivity": pd.DataFrame(_rows(params, inputs))}


def _rows(params: Params, inputs: Tables) -> Iterator[dict[str, Any]]:
    for series in params.series:
        base = Setting(
            dropped=series.dropped,
            dispenser=params.dispenser,
            velocity_noise=params.velocity_noise_relative,
            angle_error=params.angle_error_deg,
        )
        contact = contact_of(series.dropped, inputs)
        for angle in params.angles_deg:
            true = true_sample(base, contact, angle, params)
            reference = sample(base, true, params)
            for spread in series.spreads:
                for factor in params.factors:
                    setting = base.scaled(spread, factor)
                    same = spread in LAID_OVER
                    own = true if same else true_sample(setting, contact, angle, params)
                    other = sample(setting, own, params)
                    for name in QUANTITIES:
                        yield {
                            "series": series.name,
                            "angle_deg": angle,
                            "spread": spread,
                            "factor": factor,
                            "quantity": name,
                            **change(reference[name], other[name]),
                            "evidence": "virtual experiment",
                        }


def true_sample(setting: Setting, contact: Contact, angle: float, params: Params) -> Impacts:
    """Return the true impacts of a sample; settings share their random numbers.

    Works of adhesion and damping are those of `contact`, whatever the sizes.
    """
    sampling = Sampling(
        seed=params.seed,
        impacts=params.impacts,
        events=params.impacts,
        angle_error_deg=setting.angle_error,
        dispenser=setting.dispenser,
    )
    return impacts_of(setting.dropped, contact, angle, sampling)


def sample(setting: Setting, impacts: Impacts, params: Params) -> dict[str, FloatArray]:
    """Return the measured quantities of n impacts, nan where captured or outside the class.

    The target's tilt and the noise of the velocities are laid over them.
    """
    dropped = setting.dropped
    free = ~impacts.captured & in_class(dropped, impacts)
    true = turned(impacts.in_plane.select(np.flatnonzero(free)), setting.angle_error)
    noise = generator(params.seed, 3).standard_normal((4, len(impacts)))[:, true.event]
    noise *= setting.velocity_noise * true.speed
    # In turn of incident and rebound velocity the normal and the tangential component.
    legs = np.moveaxis(noise.reshape(2, 2, -1)[:, ::-1], -1, 0)
    measured = replace(true, velocities=true.velocities + legs)
    values = {name: np.full(len(impacts), np.nan) for name in QUANTITIES}
    for name, of in quantities(measured).items():
        values[name][measured.event] = of
    return values


def change(reference: FloatArray, other: FloatArray) -> dict[str, float]:
    """Return the mean of a reference, the change to another mean, and its standard error.

    Empty where hardly any particle rebounds. Either mean is a ratio of sums over the particles
    present; the error of their difference follows from what each particle contributes to it, so
    that common random numbers count.

    `reference`, `other`: of the same n particles, nan where one is absent, shape (n,).
    """
    means, parts = [], []
    for values in (reference, other):
        present = np.isfinite(values)
        if np.sum(present) < FEWEST_REBOUNDS:
            means.append(np.nan)
            parts.append(np.full(values.shape, np.nan))
            continue
        centre = float(np.mean(values[present]))
        means.append(centre)
        parts.append(np.where(present, np.nan_to_num(values) - centre, 0.0) / np.mean(present))
    spread = np.std(parts[1] - parts[0], ddof=1) / np.sqrt(reference.size)
    return {
        "rebounds": int(np.sum(np.isfinite(reference))),
        "other_rebounds": int(np.sum(np.isfinite(other))),
        "base_mean": means[0],
        "change": means[1] - means[0],
        "standard_error": float(spread),
    }
