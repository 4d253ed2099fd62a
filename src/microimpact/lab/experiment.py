"""One experiment: particles of one kind dropped on one target at one angle and speed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from microimpact.lab.collision import collide
from microimpact.lab.dispenser import Dispenser, Falling, InitialSpin, drop_height, release
from microimpact.lab.events import Impacts
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.impact import NormalLaw
from microimpact.model.law.families import NoTableError
from microimpact.model.law.table import tabulate
from microimpact.statistics.distributions import Distribution

# Share of the sizes beyond either end of a table, and its speeds, m/s: impacts of all others are
# integrated. Tables in memory.
BEYOND = 0.01
SPEEDS = (0.01, 4.0)
KEPT_TABLES = 16


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """A contact and how rough it is.

    Attributes
    ----------
    contact
        Of particles of one size; its work of adhesion and damping hold for every size.
    slope_sd
        Standard deviation of the local slope per axis, of surface and particle together.
    planar_slopes
        Whether facets slope along the motion only.
    law
        Where normal impacts come from, see `collide`.
    """

    contact: Contact
    slope_sd: float
    planar_slopes: bool = False
    law: NormalLaw | None = None

    def tabulated(self, diameter_um: Distribution) -> Target:
        """Return the same with a table of normal impacts, which pays from some 100,000 on.

        It is made for a distribution of diameters, um, and serves all targets of its contact;
        outcomes differ by no more than its error, verdicts on capture not at all.
        """
        return replace(self, law=_table(self.contact, diameter_um))


@lru_cache(maxsize=KEPT_TABLES)
def _table(contact: Contact, diameter_um: Distribution) -> NormalLaw | None:
    ends = diameter_um.quantile(np.array([BEYOND, 1.0 - BEYOND])) * 1e-6
    if ends[0] == ends[1]:
        return None
    try:
        return tabulate(resized(contact, ends), *SPEEDS).normal_impact
    except NoTableError:
        return None


def combined_slope(surface: float, particle: float) -> float:
    """Return the slope between two rough bodies, each with its own independent slopes."""
    return float(np.hypot(surface, particle))


def true_impacts(
    n: int,
    *,
    target: Target,
    angle: float,
    speed: float,
    diameter_um: Distribution,
    dispenser: Dispenser,
    spin: InitialSpin,
    rng: np.random.Generator,
    within: float = np.inf,
) -> Impacts:
    """Drop n particles and let them hit the target.

    Parameters
    ----------
    n
        Number of particles.
    target
        Contact and roughness.
    angle
        Nominal angle of incidence from the surface, degrees.
    speed
        Nominal speed at the target, m/s; it sets the drop height.
    diameter_um
        Distribution of the diameter, um.
    dispenser, spin
        Spreads of release and of initial spin.
    rng
        Source of the draws.
    within
        Particles that arrive further than this (m) from the middle are out of sight of any
        instrument and left out.
    """
    falling = release(
        n,
        angle=angle,
        height=drop_height(speed, dispenser),
        diameter_um=diameter_um,
        dispenser=dispenser,
        spin=spin,
        rng=rng,
    )
    return hit(falling.within(within), target, rng)


def hit(falling: Falling, target: Target, rng: np.random.Generator) -> Impacts:
    """Let particles that arrive at the target hit it."""
    rebound = collide(
        resized(target.contact, falling.diameter),
        falling.velocity,
        falling.spin,
        target.slope_sd,
        rng,
        planar_slopes=target.planar_slopes,
        law=target.law,
    )
    return Impacts(
        time=falling.time,
        diameter=falling.diameter,
        position=falling.position,
        velocity=falling.velocity,
        spin=falling.spin,
        rebound_velocity=rebound.velocity,
        rebound_spin=rebound.spin,
        captured=rebound.captured,
        contacts=rebound.contacts,
    )
