"""Spheres that fall back on a horizontal target: every bounce is an impact again."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.constants import gravity
from microimpact.lab.events import Falling, Impacts, IntArray
from microimpact.lab.experiment import Later, impacts_of

# Later bounces are slower than the height of the probe volume allows.
LATER_IMPACTS = 5


def generations(
    impacts: Impacts, later: Later, limit: int, farthest: float = np.inf
) -> Iterator[tuple[IntArray, Impacts]]:
    """Yield first, second, ... impacts of spheres on a horizontal target, and whose they are.

    Parameters
    ----------
    impacts
        First impacts.
    later
        Gives the impacts of spheres that fall again.
    limit
        Impacts after the first for which a sphere is followed at most.
    farthest
        Distance from the middle beyond which it is not followed, m.
    """
    sphere = np.arange(len(impacts))
    yield sphere, impacts
    last = impacts
    for _ in range(limit):
        start = last.rebound_velocity
        flight = 2.0 * start[:, 2] / gravity
        position = last.position + flight[:, None] * start[:, :2]
        again = ~last.captured & (np.hypot(position[:, 0], position[:, 1]) <= farthest)
        if not np.any(again):
            break
        sphere = sphere[again]
        falling = Falling(
            time=last.time[again] + flight[again],
            diameter=last.diameter[again],
            position=position[again],
            velocity=start[again] * [1.0, 1.0, -1.0],
            spin=last.rebound_spin[again],
        )
        last = impacts_of(falling, later(falling.velocity, falling.spin, sphere))
        yield sphere, last


def with_later_impacts(impacts: Impacts, later: Later, limit: int = LATER_IMPACTS) -> Impacts:
    """Return first impacts, and after them the later ones.

    Parameters
    ----------
    impacts, later, limit
        As of `generations`.
    """
    return Impacts.joined([those for _, those in generations(impacts, later, limit)])


@dataclass(frozen=True, slots=True, kw_only=True)
class Resting:
    """Fates of n spheres on a target without edge."""

    # True where the sphere came to rest within the bounces followed, shape (n,).
    captured: BoolArray
    impacts: IntArray  # Impacts made, shape (n,)
    # Greatest distance from the middle at which it touched the surface, m, shape (n,): on a target
    # of a larger radius it rests, past the edge of a smaller one it falls.
    reach: FloatArray

    def on_target(self, radius: float) -> BoolArray:
        """Tell which spheres rest on a target of a radius (m)."""
        return self.captured & (self.reach <= radius)


def resting(impacts: Impacts, later: Later, most_impacts: int, farthest: float) -> Resting:
    """Follow spheres from their first impact until they rest, or are given up as not captured.

    Parameters
    ----------
    impacts, later
        As of `generations`.
    most_impacts
        Impacts after which a sphere is given up.
    farthest
        As of `generations`.
    """
    n = len(impacts)
    captured, made, reach = np.zeros(n, dtype=bool), np.zeros(n, dtype=np.int64), np.zeros(n)
    for sphere, those in generations(impacts, later, most_impacts - 1, farthest):
        captured[sphere] = those.captured
        made[sphere] += 1
        x, y = those.position.T
        reach[sphere] = np.maximum(reach[sphere], np.hypot(x, y))
    return Resting(captured=captured, impacts=made, reach=reach)
