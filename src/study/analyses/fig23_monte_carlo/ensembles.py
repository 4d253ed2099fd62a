"""Ensembles of rigid spheres on a rough surface, and the estimates that they give (Section 4.2).

Events come in replicates: quasi-random sets of a fixed size, each with random numbers of its own. A
replicate is a pure function of the ensemble, the angle and its number. The scatter of the
replicates' means gives the error of every estimate. One replicate at a time is in memory.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

import numpy as np
from pydantic import Field

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.computable import NotComputable
from microimpact.lab.events import IntArray
from microimpact.lab.surface import Rules, Strike, Surface, collide
from microimpact.model import passes
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.law.families import NoTableError
from microimpact.model.law.table import TOLERANCE, Law, tabulate
from microimpact.statistics.distributions import (
    LARGEST_PROBABILITY,
    SMALLEST_PROBABILITY,
    Constant,
    Distribution,
    generator,
    mean,
    quasi_random,
)
from study.declared.parameters import Count, Finite, NonNegative

# Probabilities whose quantiles bound all that is drawn.
ENDS = np.array([SMALLEST_PROBABILITY, LARGEST_PROBABILITY])
# How far the table of e reaches beyond the sizes and speeds drawn: spin before impact may make a
# second one faster than the first.
MARGIN, FASTEST = 0.01, 1.5
# Sizes at which all spheres must have a capture velocity.
SIZES = 12
# Very wide distributions of sizes get tables of this relative error.
WIDE_TOLERANCE = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class Process:
    """Process parameters and initial conditions."""

    speed_m_per_s: Distribution  # Speed before impact
    diameter_um: Distribution  # Of the sphere
    # Tangents of the article's angle phi; normal and as wide as `infer_slope` says if not given.
    slope: Distribution | None = None
    spin_ratio: Finite  # r omega / v about the axis of tilt, positive in the sense of rolling
    friction: NonNegative  # Coulomb coefficient

    def __post_init__(self) -> None:
        """Refuse speeds and diameters that are not positive."""
        for name in ("speed_m_per_s", "diameter_um"):
            distribution = getattr(self, name)
            if getattr(distribution, "low", 0.0) > 0.0:  # nothing is drawn below; no need of SciPy
                continue
            low = float(np.min(distribution.quantile(ENDS)))
            if low <= 0.0:
                raise ValueError(
                    f"{name}: {distribution.kind} reaches down to {low:.4g}, must be positive: "
                    "take a truncated or lognormal distribution"
                )


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """How many events are drawn; ``events`` of each replicate are a power of two."""

    replicates: Annotated[int, Field(ge=2)]
    events: Count

    def __post_init__(self) -> None:
        """Refuse a number that a Sobol sequence cannot have."""
        if self.events < 2 or self.events & (self.events - 1):
            raise ValueError(f"events must be a power of two (2, 4, 8, ...), got {self.events}")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RigidBody:
    """Rigid body model with the restitution of simulated normal impacts.

    At given damping and adhesion all diameters are one family of `model.law.families`, whose
    velocity scale goes with their power -5/6.
    """

    law: Law  # e of all speeds and sizes that a process may draw
    size: float  # Diameter in the middle of the family, um

    @classmethod
    def of(cls, contact: Contact, process: Process) -> RigidBody:
        """Return the model of a contact for all speeds and sizes that a process may draw.

        Raises ValueError if some of these spheres rebound at no speed, or at every one, or the
        surface is curved.
        """
        if np.any(np.isfinite(contact.surface_radius)):
            raise ValueError(
                f"surface_radius: must be infinite in the rigid body model of an ensemble, got "
                f"{contact.surface_radius}"
            )
        smallest, largest = process.diameter_um.quantile(ENDS)
        size = np.geomspace(smallest * (1.0 - MARGIN), largest * (1.0 + MARGIN), SIZES)
        spheres = resized(contact, size * 1e-6)
        limit = np.asarray(capture_velocity(spheres))
        odd = size[~(np.isfinite(limit) & (limit > 0.0))]
        if odd.size:
            raise NotComputable(
                f"process.diameter_um: spheres of {odd.max():.3g} um have no capture velocity; "
                "narrow the distribution"
            )
        fastest = process.speed_m_per_s.quantile(ENDS)[1]
        speeds = limit.max(), FASTEST * max(fastest, limit.max())
        try:
            law = tabulate(spheres, *speeds, tolerance=TOLERANCE)
        except NoTableError:
            law = tabulate(spheres, *speeds, tolerance=WIDE_TOLERANCE)
        return cls(law=law, size=float(np.sqrt(size[0] * size[-1])))

    def coordinates(self, diameter_um: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the velocity scales of spheres, m/s, and their positions in the family."""
        steps, family = (5.0 / 6.0) * np.log(diameter_um / self.size), self.law.family
        position = np.zeros_like(steps) if family.alike else -steps / family.half_width
        return np.asarray(family.velocity_scale * np.exp(-steps)), np.asarray(position)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Ensemble:
    """Spheres that hit a rough surface, how many are drawn, and by which random numbers."""

    process: Process
    slope: Distribution  # Along the motion
    two_axes: bool  # Whether it is that across the motion too; else the surface is planar
    rules: Rules
    body: RigidBody
    plan: Plan
    seed: tuple[int, ...]
    restitution_shift: float = 0.0  # Added to e of the smooth surface, within [0, 1]


def smooth_at_means(ensemble: Ensemble) -> Ensemble:
    """Return the ensemble on a smooth surface, all else at its mean: all events are one."""
    process = replace(
        ensemble.process,
        speed_m_per_s=Constant(at=mean(ensemble.process.speed_m_per_s)),
        diameter_um=Constant(at=mean(ensemble.process.diameter_um)),
    )
    plan = Plan(replicates=2, events=2)
    return replace(ensemble, process=process, slope=Constant(at=0.0), plan=plan)


class Estimate(NamedTuple):
    """Means over accepted events, standard errors of these, standard deviations of events.

    The impulse ratio is -mu, as drawn in the article. Shares are of all events.
    """

    restitution: float
    restitution_error: float
    restitution_sd: float
    impulse_ratio: float
    impulse_ratio_error: float
    impulse_ratio_sd: float
    accepted: float
    facing_away: float
    captured: float
    not_leaving: float


class Sums(NamedTuple):
    """Sums over the events of replicates: counts, measured e and -mu, and their squares."""

    accepted: FloatArray
    facing_away: FloatArray
    captured: FloatArray
    not_leaving: FloatArray
    e: FloatArray
    e_squared: FloatArray
    mu: FloatArray
    mu_squared: FloatArray


def estimate(
    ensemble: Ensemble,
    angle_deg: float,
    key: int = 0,
    *,
    shares: Iterable[FloatArray] | None = None,
) -> Estimate:
    """Return measured coefficients at one nominal angle.

    Parameters
    ----------
    ensemble
        The ensemble.
    angle_deg
        Nominal angle of incidence from the surface.
    key
        Number of the random streams: other keys, independent estimates.
    shares
        Result of `replicate_shares` for every replicate, if there already; estimates of
        ensembles that differ in their parameters alone may share them.
    """
    plan = ensemble.plan
    if shares is None:
        shares = (replicate_shares(ensemble, key, number) for number in range(plan.replicates))
    sums = Sums(*np.transpose([replicate_sums(ensemble, angle_deg, each) for each in shares]))
    events = plan.replicates * plan.events
    counts = (float(count.sum()) / events for count in sums[:4])
    if not sums.accepted.any():
        return Estimate(*[np.nan] * 6, *counts)
    e, mu = _moments(sums.e, sums.e_squared, sums), _moments(sums.mu, sums.mu_squared, sums)
    return Estimate(*e, *mu, *counts)


def _moments(values: FloatArray, squares: FloatArray, sums: Sums) -> tuple[float, float, float]:
    """Return mean of the accepted events, its standard error, and their standard deviation."""
    n, accepted = values.size, sums.accepted.sum()
    average = values.sum() / accepted
    # Scatter of a ratio of sums, as the number accepted varies between replicates.
    scatter = values - average * sums.accepted
    error = np.sqrt(np.sum(scatter**2) * n / (n - 1)) / accepted
    variance = squares.sum() / accepted - average**2
    return float(average), float(error), float(np.sqrt(max(variance, 0.0)))


def replicate_shares(ensemble: Ensemble, key: int, number: int) -> FloatArray:
    """Return the shares of one replicate's events of which the quantiles are their parameters.

    Rows are speed, diameter, and for each facet met in turn its slope along the motion and, if the
    surface has two axes, across it.
    """
    axes = 2 if ensemble.two_axes else 1
    rng = generator(*ensemble.seed, key, number)
    points = quasi_random(ensemble.plan.events, 2 + axes * ensemble.rules.most_contacts, rng)
    return np.ascontiguousarray(points.T)


def replicate_sums(ensemble: Ensemble, angle_deg: float, shares: FloatArray) -> list[float]:
    """Let the spheres of one replicate hit the surface; return `Sums` of its events.

    Parameters
    ----------
    ensemble
        The ensemble.
    angle_deg
        Nominal angle of incidence from the surface.
    shares
        As of `replicate_shares`.
    """
    process, rules, planar = ensemble.process, ensemble.rules, Constant(at=0.0)
    surface = Surface(
        slope=ensemble.slope,
        cross_slope=ensemble.slope if ensemble.two_axes else planar,
        rules=rules,
    )
    speed = process.speed_m_per_s.quantile(shares[0])
    diameter = process.diameter_um.quantile(shares[1])
    before, turn = np.zeros((2, speed.size, 3))
    before[:, 0] = speed * np.cos(np.radians(angle_deg))
    before[:, 2] = -speed * np.sin(np.radians(angle_deg))
    turn[:, 1] = process.spin_ratio * speed
    facets = shares[2:].reshape(rules.most_contacts, -1, speed.size)
    # A planar surface takes any share for its slope across.
    pairs = ((facet[0], facet[-1]) for facet in facets)
    rebound = collide(surface, before, turn, pairs, _rigid(ensemble, diameter))
    accepted, facing_away = rebound.observed(rules), rebound.contacts == 0
    change = (rebound.velocity - before)[accepted]
    e = -rebound.velocity[accepted, 2] / before[accepted, 2]
    mu = -change[:, 0] / change[:, 2]
    rejected = ~(accepted | facing_away | rebound.kept)
    counts = accepted, facing_away, rebound.kept, rejected
    return [float(np.sum(values)) for values in (*counts, e, e**2, mu, mu**2)]


def _rigid(ensemble: Ensemble, diameter_um: FloatArray) -> Strike:
    """Return the contacts of rigid spheres; their spin is r omega, m/s."""
    unit, position = ensemble.body.coordinates(diameter_um)
    friction = np.full(diameter_um.size, ensemble.process.friction)

    def strike(
        which: IntArray, velocity: FloatArray, turn: FloatArray, normal: FloatArray
    ) -> tuple[FloatArray, FloatArray, BoolArray]:
        speed = -np.vecdot(velocity, normal)
        bare = ensemble.body.law.restitution(speed / unit[which], position[which])
        e = np.clip(bare + ensemble.restitution_shift, 0.0, 1.0)
        after, turned = np.empty((2, *velocity.shape))
        passes.rebounds(velocity, turn, normal, e, friction[which], after, turned)
        return after, turned, bare <= 0.0

    return strike
