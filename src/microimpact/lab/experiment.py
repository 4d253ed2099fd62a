"""One experiment: particles of one kind dropped on one target at one angle and speed."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Annotated

import numpy as np
import scipy
from annotated_types import Ge

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.bounds import Count, Positive
from microimpact.lab.dispenser import (
    NO_SPIN,
    Dispenser,
    InitialSpin,
    Paths,
    arrivals,
    drop_height,
    paths,
)
from microimpact.lab.events import Falling, Impacts, IntArray, Measured
from microimpact.lab.reduction import Mean
from microimpact.lab.surface import SMOOTH, Rebound, Surface, collide, drawn_shares, simulated
from microimpact.model.contact import Contact, resized
from microimpact.model.law.families import NoTableError
from microimpact.model.law.table import Law, tabulate
from microimpact.statistics.distributions import Distribution, mean, sample

# Share of the sizes beyond either end of a table, and its speeds, m/s: impacts of all others are
# integrated. Tables in memory.
BEYOND = 0.01
SPEEDS = (0.01, 4.0)
KEPT_TABLES = 16
# Angle of incidence from the surface, degrees, that the analyser sees; imaging sees all others.
NORMAL = 90.0
# Particles dropped at first; while events are wanting, as many again as so far.
DROPPED_AT_FIRST = 200

# Velocity and spin (k, 3) before later impacts, and whose they are (k,) -> rebounds.
Later = Callable[[FloatArray, FloatArray, IntArray], Rebound]


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedClass:
    """Nominal speed, and range of measured speeds accepted."""

    speed_m_per_s: Positive
    speed_range_m_per_s: tuple[Positive, Positive]

    def __post_init__(self) -> None:
        """Refuse a class that does not hold its nominal speed."""
        low, high = self.speed_range_m_per_s
        if not low < self.speed_m_per_s < high:
            raise ValueError(
                f"speed_range_m_per_s: [{low:g}, {high:g}] must ascend and hold "
                f"{self.speed_m_per_s:g}"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """A contact and how rough it is.

    Attributes
    ----------
    contact
        Of particles of one size; its work of adhesion and damping hold for every size.
    surface
        Slopes of surface and particle together.
    law
        Where normal impacts come from, see `lab.surface.simulated`.
    """

    contact: Contact
    surface: Surface = SMOOTH
    law: Law | None = None

    def tabulated(self, diameter_um: Distribution) -> Target:
        """Return the same with a table of normal impacts, which pays from some 20,000 on.

        It is made for a distribution of diameters, um, and serves all targets of its contact;
        outcomes differ by no more than its error, verdicts on capture not at all.
        """
        return replace(self, law=_table(self.contact, diameter_um))

    def hit(
        self, diameter: FloatArray, velocity: FloatArray, spin: FloatArray, rng: np.random.Generator
    ) -> Rebound:
        """Let spheres hit the target.

        Parameters
        ----------
        diameter
            m, (n,).
        velocity, spin
            Before impact, m/s and rad/s, (n, 3).
        rng
            Generator from which facets are drawn.
        """
        n = len(velocity)
        shares = drawn_shares(rng, n, self.surface.rules)
        strike = simulated(resized(self.contact, diameter), n, self.law)
        return collide(self.surface, velocity, spin, shares, strike)

    def later(self, diameter: FloatArray, rng: np.random.Generator) -> Later:
        """Return the rebounds of spheres of some diameters (m) that fall back on the target."""
        return lambda velocity, spin, sphere: self.hit(diameter[sphere], velocity, spin, rng)


@lru_cache(maxsize=KEPT_TABLES)
def _table(contact: Contact, diameter_um: Distribution) -> Law | None:
    ends = diameter_um.quantile(np.array([BEYOND, 1.0 - BEYOND])) * 1e-6
    if ends[0] == ends[1]:
        return None
    try:
        return tabulate(resized(contact, ends), *SPEEDS)
    except NoTableError:
        return None


def impacts_of(falling: Falling, rebound: Rebound) -> Impacts:
    """Return the impacts of arriving particles, from their rebounds."""
    return Impacts(
        **{name: getattr(falling, name) for name in Falling.__dataclass_fields__},
        rebound_velocity=rebound.velocity,
        rebound_spin=rebound.spin,
        captured=rebound.captured,
        contacts=rebound.contacts,
    )


def in_range(speed: FloatArray, speed_range: tuple[float, float]) -> BoolArray:
    """Tell which speeds lie in a range, its ends included, all m/s."""
    inside: BoolArray = (speed >= speed_range[0]) & (speed <= speed_range[1])
    return inside


@dataclass(frozen=True, slots=True, kw_only=True)
class Drop:
    """Particles, target, height and speed of a drop.

    Attributes
    ----------
    target
        Contact and roughness.
    diameter_um
        Distribution of the diameter, um.
    speed
        Nominal speed at the target, m/s; it sets the drop height.
    dispenser
        Spreads of release.
    angle
        Nominal angle of incidence from the surface, degrees.
    speed_range
        Range of speeds accepted, m/s.
    spin
        Spreads of initial spin.
    """

    target: Target
    diameter_um: Distribution
    speed: float
    dispenser: Dispenser
    angle: float = NORMAL
    speed_range: tuple[float, float] = (0.0, np.inf)
    spin: InitialSpin = NO_SPIN

    @property
    def height(self) -> float:
        """From the needle to the target, m."""
        return drop_height(self.speed, self.dispenser)

    @property
    def key(self) -> tuple[int, ...]:
        """Key of its random draws, from its conditions, so that it is the same in every study."""
        contact, slope = self.target.contact, self.target.surface.slope
        # The slope that one facet in six exceeds: one standard deviation.
        exceeded = float(slope.quantile(np.asarray(scipy.special.ndtr(1.0))))
        words = (
            contact.particle.name,
            contact.surface.name,
            f"{mean(self.diameter_um):.0f} um",
            f"slope {exceeded:.2f}",
            f"{self.speed:g} m/s",
            f"{self.angle:g} deg",
        )
        hashed = hashlib.sha256(", ".join(words).encode()).digest()
        return tuple(int.from_bytes(hashed[k : k + 4], "big") for k in (0, 4))

    def tabulated(self) -> Drop:
        """Return the same with a table of normal impacts, see `Target.tabulated`."""
        return replace(self, target=self.target.tabulated(self.diameter_um))

    @property
    def paths(self) -> Paths:
        """How particles fall on the target."""
        return partial(paths, angle=self.angle, height=self.height, dispenser=self.dispenser)

    def release(self, n: int, rng: np.random.Generator, path: Paths | None = None) -> Falling:
        """Let particles fall.

        Parameters
        ----------
        n
            Number of particles.
        rng
            Generator of the draws.
        path
            How they fall; by `paths` if not given.
        """
        diameter = sample(self.diameter_um, rng, n) * 1e-6
        position, velocity, fall = (path or self.paths)(n, rng)
        share = self.spin.sd * rng.standard_normal((n, 3))
        share[:, 1] += self.spin.mean
        return Falling(
            time=arrivals(n, self.dispenser, rng),
            diameter=diameter,
            position=position,
            velocity=velocity,
            spin=share * (fall / (0.5 * diameter))[:, None],
        )

    def hit(self, falling: Falling, rng: np.random.Generator) -> Impacts:
        """Let particles that arrive at the target hit it."""
        rebound = self.target.hit(falling.diameter, falling.velocity, falling.spin, rng)
        return impacts_of(falling, rebound)

    def impacts(self, n: int, rng: np.random.Generator, within: float = np.inf) -> Impacts:
        """Drop particles and let them hit the target.

        Parameters
        ----------
        n
            Number of particles.
        rng
            Generator of the draws.
        within
            Distance from the middle beyond which they are out of sight of any instrument and left
            out, m.
        """
        return self.hit(self.release(n, rng).within(within), rng)

    def in_class(self, speed: FloatArray) -> BoolArray:
        """Tell which speeds (m/s) are accepted."""
        return in_range(speed, self.speed_range)


@dataclass(frozen=True, slots=True, kw_only=True)
class StopRule:
    """When an experiment ends: with its events, or given up.

    Attributes
    ----------
    events
        Number of accepted events wanted; as many, the first, are averaged.
    fewest_events
        Below this number there is no mean.
    most_dropped
        Number of particles after which the experiment is given up.
    """

    events: Annotated[int, Ge(2)]
    fewest_events: Annotated[int, Ge(2)]
    most_dropped: Count

    def __post_init__(self) -> None:
        """Refuse a mean of more events than are wanted."""
        if self.fewest_events > self.events:
            raise ValueError(
                f"fewest_events: {self.fewest_events} must be at most events, {self.events}"
            )

    def batch(self, dropped: int) -> int:
        """Return how many are dropped next: as many as before, until it is given up."""
        return min(max(dropped, DROPPED_AT_FIRST), self.most_dropped - dropped)

    def ended(self, accepted: int, dropped: int) -> bool:
        """Tell whether the experiment ends, by the events accepted and the particles dropped."""
        return accepted >= self.events or dropped >= self.most_dropped


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """Result of one experiment with either instrument.

    Attributes
    ----------
    measured
        Accepted events, in order of time; `event` counts in `impacts`.
    impacts
        All within the reach of the instrument: first impacts in order of time, then later ones.
    first
        Number of first impacts.
    dropped
        Particles dropped.
    fates
        What became of them, in the words of the instrument.
    means
        Mean and interval of every quantity measured; `NO_MEAN` of too few events.
    """

    measured: Measured
    impacts: Impacts
    first: int
    dropped: int
    fates: Mapping[str, int]
    means: Mapping[str, Mean]

    @property
    def first_impacts(self) -> Impacts:
        """The first impact of every particle within reach."""
        return self.impacts.select(slice(self.first))

    @property
    def true(self) -> Measured:
        """Accepted events as they were; two records of different particles have no truth."""
        events = self.measured.event
        return self.impacts.in_plane.select(events[events >= 0])
