"""Where dropped spheres end: bounce after bounce on a flat, horizontal target."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.constants import gravity
from microimpact.lab.collision import collide
from microimpact.lab.events import IntArray
from microimpact.lab.experiment import Target
from microimpact.model.contact import resized


@dataclass(frozen=True, slots=True, kw_only=True)
class Resting:
    """What becomes of n spheres on a target without edge.

    Attributes
    ----------
    captured
        True where the sphere came to rest within the bounces followed, shape (n,).
    impacts
        Impacts made, shape (n,).
    reach
        Greatest distance from the middle at which it touched the surface, m, shape (n,): on a
        target of a larger radius it rests, past the edge of a smaller one it falls.
    """

    captured: BoolArray
    impacts: IntArray
    reach: FloatArray

    def on_target(self, radius: float) -> BoolArray:
        """Tell which spheres rest on a target of a radius (m)."""
        return self.captured & (self.reach <= radius)


def follow(
    target: Target,
    diameter: FloatArray,
    position: FloatArray,
    velocity: FloatArray,
    spin: FloatArray,
    rng: np.random.Generator,
    *,
    most_impacts: int,
    farthest: float,
) -> Resting:
    """Follow spheres from their first impact until they rest.

    Parameters
    ----------
    target
        Contact and roughness; every impact meets a slope of its own.
    diameter
        m, shape (n,).
    position
        Of the first impact, m, shape (n, 2).
    velocity, spin
        Before it, m/s and rad/s, shape (n, 3); velocity[:, 2] < 0.
    rng
        Source of the slopes.
    most_impacts
        Impacts after which a sphere is given up as not captured.
    farthest
        Distance (m) beyond which a sphere is no longer followed.
    """
    n = len(diameter)
    position, velocity, spin = (np.array(a, dtype=float) for a in (position, velocity, spin))
    captured, impacts = np.zeros(n, dtype=bool), np.zeros(n, dtype=np.int64)
    reach = np.hypot(position[:, 0], position[:, 1])
    moving = np.flatnonzero(reach <= farthest)
    for _ in range(most_impacts):
        if moving.size == 0:
            break
        rebound = collide(
            resized(target.contact, diameter[moving]),
            velocity[moving],
            spin[moving],
            target.slope_sd,
            rng,
            planar_slopes=target.planar_slopes,
            law=target.law,
        )
        impacts[moving] += 1
        captured[moving] = rebound.captured
        free, moving = ~rebound.captured, moving[~rebound.captured]
        start = rebound.velocity[free]
        position[moving] += 2.0 * start[:, 2:] / gravity * start[:, :2]
        velocity[moving], spin[moving] = start * [1.0, 1.0, -1.0], rebound.spin[free]
        distance = np.hypot(position[moving, 0], position[moving, 1])
        reach[moving] = np.maximum(reach[moving], distance)
        moving = moving[distance <= farthest]
    return Resting(captured=captured, impacts=impacts, reach=reach)
