"""Errors of interpolation in the explorer's tables, against direct integration at random points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.random import PCG64, Generator, SeedSequence

from microimpact.core.arrays import FloatArray
from microimpact.studies.models.explorer_tables.coordinates import (
    IMPULSE_EXPONENT,
    THRESHOLD_EXPONENT,
    adhesion_strength,
    closeness,
    impulse_closeness,
    impulse_unit,
    interpolate,
    node_weights,
    slow_passage,
    time_unit,
)
from microimpact.studies.models.explorer_tables.impacts import (
    ScaledImpacts,
    impacts,
    scaled_thresholds,
)

ANALYSIS = 121

# Random points: dampings down to this share of the largest, speeds up to this many thresholds,
# distances from the threshold down to this one.
SMALLEST_DAMPING = 1e-8
LARGEST_SPEED = 1e3
SMALLEST_DISTANCE = 1e-6

THRESHOLD_SHARE_OF_POINTS = 0.1
CLEAR, NEAR = "clear of the threshold", "just above the threshold"


@dataclass(frozen=True, slots=True)
class Tables:
    """The three tables as arrays: nodes of each axis, and values at them."""

    largest_damping: float
    frames: Mapping[str, pd.DataFrame]

    def values(self, table: str, column: str, *at: FloatArray) -> FloatArray:
        """Return one column at points given by their coordinates on each axis."""
        frame = self.frames[table]
        axes = [np.unique(frame.iloc[:, i].to_numpy()) for i in range(len(at))]
        values = frame[column].to_numpy().reshape([axis.size for axis in axes])
        return interpolate(values, *map(node_weights, axes, at))

    def thresholds(self, damping: FloatArray, share: FloatArray) -> FloatArray:
        """Return the speed at the threshold, in velocity scales."""
        at = (damping / self.largest_damping) ** THRESHOLD_EXPONENT, np.sqrt(share)
        root = np.cbrt(damping)
        return root * self.values("explorer_threshold", "scaled_threshold", *at)

    def impacts(self, damping: FloatArray, share: FloatArray, speed: FloatArray) -> ScaledImpacts:
        """Return outcomes at speeds in velocity scales; those of captured ones mean nothing."""
        limit = self.thresholds(damping, share)
        captured = speed <= limit
        strength = adhesion_strength(speed)
        critical = adhesion_strength(np.where(captured, speed, limit))
        relative, root = damping / self.largest_damping, np.sqrt(share)
        slow = closeness(strength, critical)
        at = relative**THRESHOLD_EXPONENT, root, slow
        scaled = self.values("explorer_restitution", "scaled_restitution", *at)
        restitution = np.minimum(slow * scaled, 1.0)
        work = share * self.values("explorer_restitution", "scaled_hertz_work", *at)
        at = relative**IMPULSE_EXPONENT, root, impulse_closeness(strength, critical)
        compressive, hertz, net, time = (
            self.values("explorer_impulses", f"scaled_{name}", *at)
            for name in ("compressive_impulse", "hertz_impulse", "net_impulse", "contact_time")
        )
        unit = impulse_unit(strength)
        return ScaledImpacts(
            captured=captured,
            restitution=restitution,
            contact_time=time_unit(strength) * (time - slow_passage(strength, restitution)),
            compressive_impulse=unit * compressive,
            peak_net_impulse=1.0 + unit * net,
            hertz_impulse=unit * hertz,
            hertz_work=work,
        )


def accuracy(
    frames: Mapping[str, pd.DataFrame],
    *,
    largest_damping: float,
    near: float,
    points: int,
    seed: int,
) -> pd.DataFrame:
    """Return the largest and root mean square errors, one row per quantity and region.

    Parameters
    ----------
    frames
        The three tables of values.
    largest_damping
        End of the axis of damping.
    near
        Up to this relative distance a speed counts as just above the threshold.
    points
        Random points in each region.
    seed
        Root of the random draws.
    """
    tables = Tables(largest_damping, frames)
    rng = Generator(PCG64(SeedSequence(seed, spawn_key=(ANALYSIS, 0))))
    few = int(points * THRESHOLD_SHARE_OF_POINTS)
    rows = [_threshold_errors(tables, *_dampings(rng, few, largest_damping))]
    wrong = 0
    for region, low, high in ((CLEAR, near, LARGEST_SPEED), (NEAR, SMALLEST_DISTANCE, near)):
        damping, share = _dampings(rng, points, largest_damping)
        distance = np.exp(rng.uniform(np.log(low), np.log(high), points))
        limit = tables.thresholds(damping, share)
        below = limit * (1.0 - np.minimum(distance, 0.9))
        wrong += int(np.sum(~impacts(damping, share, adhesion_strength(below)).captured))
        above = limit * (1.0 + distance)
        exact = impacts(damping, share, adhesion_strength(above))
        wrong += int(np.sum(exact.captured))
        rows += _errors(region, tables.impacts(damping, share, above), exact)
    rows.append(
        {"quantity": "captured", "region": "both sides of the threshold", "error": "wrong verdicts"}
        | {"largest": wrong, "root_mean_square": np.nan, "points": 4 * points}
    )
    return pd.DataFrame(rows).assign(evidence="computed")


def _dampings(rng: Generator, points: int, largest: float) -> tuple[FloatArray, FloatArray]:
    """Draw D and share: over the whole axes, towards their small ends, and both ends of share."""
    even = largest * rng.uniform(size=points) ** (1.0 / THRESHOLD_EXPONENT)
    small = largest * np.exp(rng.uniform(np.log(SMALLEST_DAMPING), 0.0, points))
    damping = np.where(rng.uniform(size=points) < 0.5, even, small)
    share = np.where(rng.uniform(size=points) < 0.5, 1.0, rng.uniform(size=points) ** 3)
    share = share * rng.uniform(size=points)
    kind = rng.uniform(size=points)
    return damping, np.where(kind < 0.1, 0.0, np.where(kind < 0.2, 1.0, share))


def _threshold_errors(tables: Tables, damping: FloatArray, share: FloatArray) -> dict[str, object]:
    exact = scaled_thresholds(damping, share)
    error = tables.thresholds(damping, share) / exact - 1.0
    return _row("threshold_speed", "everywhere", "relative", error)


def _errors(region: str, found: ScaledImpacts, exact: ScaledImpacts) -> list[dict[str, object]]:
    rows = [
        _row(name, region, "absolute", getattr(found, key) - getattr(exact, key))
        for name, key in (
            ("coefficient_of_restitution", "restitution"),
            ("hertz_work", "hertz_work"),
        )
    ]
    names = ("compressive_impulse", "hertz_impulse", "peak_net_impulse", "contact_time")
    return rows + [
        _row(name, region, "relative", getattr(found, name) / getattr(exact, name) - 1.0)
        for name in names
    ]


def _row(quantity: str, region: str, kind: str, error: FloatArray) -> dict[str, object]:
    return {
        "quantity": quantity,
        "region": region,
        "error": kind,
        "largest": float(np.max(np.abs(error))),
        "root_mean_square": float(np.sqrt(np.mean(np.square(error)))),
        "points": error.size,
    }
