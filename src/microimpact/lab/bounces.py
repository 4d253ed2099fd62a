"""Spheres that fall back on a horizontal target: every bounce is an impact again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.constants import gravity
from microimpact.lab.events import Impacts, IntArray

# velocity, spin (k, 3) before a later impact, whose sphere (k,) -> velocity, spin, captured after
Rebound = Callable[[FloatArray, FloatArray, IntArray], tuple[FloatArray, FloatArray, BoolArray]]


def with_later_impacts(impacts: Impacts, later: Rebound, limit: int) -> Impacts:
    """Follow spheres that fall back on a horizontal target.

    Parameters
    ----------
    impacts
        First impacts, n.
    later
        Gives the outcome of later impacts: ``later(velocity, spin, sphere)`` with velocity and
        spin before impact, shape (k, 3), and whose they are, indices into `impacts`; returns
        velocity and spin after it and who is captured.
    limit
        Most later impacts of one sphere.

    Returns
    -------
    Impacts
        The n first impacts, and after them the later ones.
    """
    generations, sphere = [impacts], np.arange(len(impacts))
    for _ in range(limit):
        last = generations[-1]
        again = ~last.captured
        if not np.any(again):
            break
        sphere, start = sphere[again], last.rebound_velocity[again]
        flight = 2.0 * start[:, 2] / gravity
        velocity, spin = start * [1.0, 1.0, -1.0], last.rebound_spin[again]
        after, spin_after, captured = later(velocity, spin, sphere)
        generations.append(
            replace(
                last,
                time=last.time[again] + flight,
                diameter=last.diameter[again],
                position=last.position[again] + flight[:, None] * start[:, :2],
                velocity=velocity,
                spin=spin,
                rebound_velocity=after,
                rebound_spin=spin_after,
                captured=captured,
                contacts=np.ones(len(sphere), dtype=np.int64),
            )
        )
    names = Impacts.__dataclass_fields__
    return Impacts(**{k: np.concatenate([getattr(g, k) for g in generations]) for k in names})
