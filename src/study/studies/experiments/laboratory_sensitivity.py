"""Effect of the laboratory's assumed spreads on its means: each halved and doubled."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.lab.dispenser import Dispenser
from microimpact.lab.ptis.experiment import turned
from microimpact.lab.reduction import QUANTITIES, quantities
from microimpact.statistics.distributions import TruncatedNormal, generator
from study.declared.parameters import Count, Name, NonNegative, ObliqueDegrees, Positive
from study.studies.samples import FEWEST_REBOUNDS, Dropped, Sample, Sampling, in_class
from study.tables import Tables

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
# Where each stands in a `Setting`.
SPREADS: Mapping[Spread, tuple[str, ...]] = {
    "exit_speed": ("sample", "sampling", "dispenser", "exit_speed_m_per_s"),
    "lateral_speed": ("sample", "sampling", "dispenser", "lateral_speed_m_per_s"),
    "lateral_position": ("sample", "sampling", "dispenser", "lateral_position_mm"),
    "diameter_sd": ("sample", "dropped", "diameter_um", "sd"),
    "spin_sd": ("sample", "dropped", "spin", "sd"),
    "surface_slope": ("sample", "dropped", "surface_slope"),
    "particle_slope": ("sample", "dropped", "particle_slope"),
    "velocity_noise": ("velocity_noise",),
    "angle_error": ("angle_error",),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class BaseSeries:
    """Particles dropped, and the spreads that are varied."""

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
    series: dict[Name, BaseSeries]
    angles_deg: tuple[ObliqueDegrees, ...]
    factors: tuple[Positive, ...]
    dispenser: Dispenser
    # Standard deviation of a measured velocity component over the speed.
    velocity_noise_relative: NonNegative
    # Unknown tilt of the target; the means are compared with it and with a multiple.
    angle_error_deg: NonNegative


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """Spreads of a sample, and errors of measurement, which leave its impacts alone."""

    sample: Sample
    velocity_noise: float
    angle_error: float


def scaled(record: Any, path: Sequence[str], factor: float) -> Any:
    """Return a dataclass with one number, in a field or in fields of fields, multiplied."""
    name, *rest = path
    value = getattr(record, name)
    return replace(record, **{name: scaled(value, rest, factor) if rest else factor * value})


def run(params: Params, inputs: Tables) -> Tables:
    """Vary every spread alone, on common random numbers.

    ``laboratory_sensitivity``: base mean, change and its standard error, per series, angle, spread,
    factor and quantity.
    """
    return {"laboratory_sensitivity": pd.DataFrame(_rows(params, inputs))}


def _rows(params: Params, inputs: Tables) -> Iterator[dict[str, Any]]:
    sampling = Sampling(
        seed=params.seed,
        impacts=params.impacts,
        events=params.impacts,
        angle_error_deg=params.angle_error_deg,
        dispenser=params.dispenser,
    )
    for name, series in params.series.items():
        base = Setting(
            sample=Sample.of(series.dropped, sampling, inputs),
            velocity_noise=params.velocity_noise_relative,
            angle_error=params.angle_error_deg,
        )
        for angle in params.angles_deg:
            reference = measured(base, angle)
            for spread in series.spreads:
                for factor in params.factors:
                    varied = measured(scaled(base, SPREADS[spread], factor), angle)
                    for quantity in QUANTITIES:
                        yield {
                            "series": name,
                            "angle_deg": angle,
                            "spread": spread,
                            "factor": factor,
                            "quantity": quantity,
                            **change(reference[quantity], varied[quantity]),
                            "evidence": "virtual experiment",
                        }


def measured(setting: Setting, angle: float) -> dict[str, FloatArray]:
    """Return the measured quantities of n impacts, nan where captured or outside the class.

    Settings share their random numbers. The target's tilt and the noise of the velocities are laid
    over the true impacts.
    """
    sample = setting.sample
    impacts = sample.impacts(angle)
    free = ~impacts.captured & in_class(sample.dropped, impacts)
    true = turned(impacts.in_plane.select(np.flatnonzero(free)), setting.angle_error)
    noise = generator(sample.sampling.seed, 3).standard_normal((4, len(impacts)))[:, true.event]
    noise *= setting.velocity_noise * true.speed
    # In turn of incident and rebound velocity the normal and the tangential component.
    legs = np.moveaxis(noise.reshape(2, 2, -1)[:, ::-1], -1, 0)
    noisy = replace(true, velocities=true.velocities + legs)
    values = {name: np.full(len(impacts), np.nan) for name in QUANTITIES}
    for name, column in quantities(noisy).items():
        values[name][noisy.event] = column
    return values


def change(reference: FloatArray, varied: FloatArray) -> dict[str, float]:
    """Return the mean of a reference, the change to another mean, and its standard error.

    Empty where hardly any particle rebounds. Either mean is a ratio of sums over the particles
    present; the error of their difference follows from what each particle contributes to it, so
    that common random numbers count.

    Parameters
    ----------
    reference, varied
        Of the same n particles, nan where one is absent, shape (n,).
    """
    means, parts = [], []
    for values in (reference, varied):
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
        "other_rebounds": int(np.sum(np.isfinite(varied))),
        "base_mean": means[0],
        "change": means[1] - means[0],
        "standard_error": float(spread),
    }
