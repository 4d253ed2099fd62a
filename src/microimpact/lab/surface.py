"""The rough surface: the facets that a sphere meets, and its contacts until it leaves.

A rough surface (or a rough particle) is a plane of facets whose normals differ from the nominal
one, the z axis. A facet is given by its slopes, tangents of angles: along the motion of the sphere,
positive where the facet faces it, and across. Seen along the motion a facet shows the area
``(-v.n)+ / n_z``, so that with x the slope along the motion and c the tangent of the angle of
approach it is hit in proportion to ``(c + x)+``; the slope across it leaves as it is. A sphere that
still moves towards the surface after a contact meets another facet.

What one contact does is a `Strike`, given from outside: dynamic simulation in the laboratory,
the rigid body model in Monte Carlo analyses.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice
from typing import Annotated, Literal

import numpy as np
import scipy
from annotated_types import Ge, Le

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.lab.events import IntArray
from microimpact.model import passes
from microimpact.model.contact import Contact
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.law.table import Law
from microimpact.statistics.distributions import (
    LARGEST_PROBABILITY,
    SMALLEST_PROBABILITY,
    Distribution,
    Normal,
    uniforms,
)

# Which spheres (m,), their velocity and spin, m/s and rad/s, and the unit normals of their facets,
# (m, 3) each -> velocity and spin after the contact, and who stays on the facet.
Strike = Callable[
    [IntArray, FloatArray, FloatArray, FloatArray], tuple[FloatArray, FloatArray, BoolArray]
]

# Distributions of slopes are cut into cells of equal width in normal scores, uniform within each:
# the width of 1/128 changes the variance of a normal slope by 5e-6 of itself.
SCORES = np.linspace(-8.25, 8.25, 2113)
KEPT_TABLES = 64


@dataclass(frozen=True, slots=True, kw_only=True)
class Rules:
    """Which facets are hit and which events are observed.

    Attributes
    ----------
    facets
        ``seen``: facets are hit in proportion to their area as seen along the motion. ``facing``:
        in proportion to their area on the map, as in adding a random slope to the angle; one turned
        away from the sphere is not hit, and the event does not count. ``every``: the same, but the
        equations are applied to such a facet, too, as a program does that does not ask.
    must_leave
        An event counts only if the sphere leaves the nominal surface.
    most_contacts
        Facets that a sphere may hit in turn without leaving the surface.
    """

    facets: Literal["seen", "facing", "every"]
    must_leave: bool
    most_contacts: Annotated[int, Ge(1), Le(20)]


LABORATORY = Rules(facets="seen", must_leave=True, most_contacts=5)


@dataclass(frozen=True, slots=True, kw_only=True)
class Surface:
    """How rough a surface is, and by which rules it is struck.

    Attributes
    ----------
    slope, cross_slope
        Distributions of the slope along the motion and across it, tangents.
    rules
        Those of the laboratory if not given.
    """

    slope: Distribution
    cross_slope: Distribution
    rules: Rules = LABORATORY


def rough(slope_sd: float) -> Surface:
    """Return a surface of normal slopes, of one standard deviation along and across the motion."""
    return Surface(slope=Normal(sd=slope_sd), cross_slope=Normal(sd=slope_sd))


SMOOTH = rough(0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rebound:
    """State of n spheres after their last contact, in the frame of the nominal surface.

    Attributes
    ----------
    velocity, spin
        m/s and rad/s, shape (n, 3).
    kept
        True where a contact did not end, shape (n,).
    contacts
        Contacts made; none where no facet faced the sphere, shape (n,).
    """

    velocity: FloatArray
    spin: FloatArray
    kept: BoolArray
    contacts: IntArray

    @property
    def captured(self) -> BoolArray:
        """True where the sphere stays: it was kept, or does not leave the nominal surface."""
        captured: BoolArray = self.kept | ~(self.velocity[:, 2] > 0.0)
        return captured

    def observed(self, rules: Rules) -> BoolArray:
        """Tell which events count by the rules, shape (n,)."""
        stays = self.captured if rules.must_leave else self.kept
        counted: BoolArray = ~stays & (self.contacts > 0)
        return counted


def drawn_shares(
    rng: np.random.Generator, n: int, rules: Rules = LABORATORY
) -> Iterator[FloatArray]:
    """Yield plain shares for `collide`, drawn for each contact as it comes.

    Parameters
    ----------
    rng
        Generator of the draws.
    n
        Number of spheres.
    rules
        By which the facets are struck.
    """
    # All n are drawn for, so that the facets of one sphere do not depend on another's fate.
    return (uniforms(rng, (2, n)) for _ in range(rules.most_contacts))


def collide(
    surface: Surface,
    velocity: FloatArray,
    spin: FloatArray,
    shares: Iterable[FloatArray | tuple[FloatArray, FloatArray]],
    strike: Strike,
) -> Rebound:
    """Let n spheres hit a surface.

    Parameters
    ----------
    surface
        Its slopes and rules.
    velocity, spin
        Before impact, m/s and rad/s, shape (n, 3); spheres with velocity[:, 2] >= 0 meet nothing.
    shares
        For every contact the shares, in (0, 1), of which the quantiles are the slopes of the facets
        along the motion and across it, shape (2, n).
    strike
        What one contact does.
    """
    velocity, spin = np.array(velocity, dtype=float), np.array(spin, dtype=float)
    kept, contacts = np.zeros(len(velocity), dtype=bool), np.zeros(len(velocity), dtype=np.int64)
    moving = np.flatnonzero(velocity[:, 2] < 0.0)
    for along, across in islice(shares, surface.rules.most_contacts):
        toward = velocity[moving]
        normal = facets(surface, toward, along[moving], across[moving])
        met = np.vecdot(toward, normal) < 0.0
        moving = moving[met]
        velocity[moving], spin[moving], stays = strike(
            moving, toward[met], spin[moving], normal[met]
        )
        kept[moving] = stays
        contacts[moving] += 1
        moving = moving[~stays & (velocity[moving, 2] <= 0.0)]
        if not moving.size:
            break
    return Rebound(velocity=velocity, spin=spin, kept=kept, contacts=contacts)


def facets(
    surface: Surface, velocity: FloatArray, along: FloatArray, across: FloatArray
) -> FloatArray:
    """Return the unit normals of the facets met, shape (n, 3).

    Parameters
    ----------
    surface
        Slopes, and whether they are weighted.
    velocity
        Of approach, m/s, shape (n, 3); only its direction along the nominal surface counts (x, if
        it is normal).
    along, across
        Shares of which the quantiles are the slopes of the facet along the motion and to its left,
        shape (n,). A facet whose slope along the motion is positive faces the sphere.
    """
    normal = np.empty(velocity.shape)
    hits, kind = hit_slopes(surface.slope), passes.FACETS.index(surface.rules.facets)
    passes.normals(velocity, *_slopes(surface, along, across), hits, kind, normal)
    return normal


def _slopes(
    surface: Surface, along: FloatArray, across: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return slopes of shares; of facets that are seen, the share along the motion stays."""
    seen = surface.rules.facets == "seen"
    return along if seen else surface.slope.quantile(along), surface.cross_slope.quantile(across)


def simulated(contact: Contact, n: int, law: Law | None = None) -> Strike:
    """Return contacts of n spheres by dynamic simulation (Eqs. 19-29).

    Parameters
    ----------
    contact
        Of one sphere, for all, or of n.
    law
        A table of them; otherwise every contact is integrated.
    """
    columns = law.family.columns(contact, (n,)) if law else np.empty((0, 0))

    def strike(
        which: IntArray, velocity: FloatArray, spin: FloatArray, normal: FloatArray
    ) -> tuple[FloatArray, FloatArray, BoolArray]:
        speed = -np.vecdot(velocity, normal)
        if law:
            radius, friction, unit, shape_index, scale, *_ = columns[which % len(columns)].T
            restitution, captured = law.quantities(speed / unit, shape_index)
            e = restitution[passes.RESTITUTION]
            support = restitution[passes.COMPRESSIVE] * (scale if law.family.adhesive else speed)
        else:
            spheres = contact.at(which) if contact.shape == (n,) and len(which) < n else contact
            impact = normal_impact(spheres, speed)
            e, captured = impact.coefficient_of_restitution, impact.captured
            support = np.asarray(impact.compressive_impulse / spheres.mass)
            radius, friction = np.asarray(spheres.radius), np.asarray(spheres.friction)
        # Of a rigid body that friction has the same impulse; who stays rolls in the end.
        same = friction * support / ((1.0 + e) * speed)
        same = np.where(captured & (friction > 0.0), np.inf, same)
        radius = np.reshape(radius, (-1, 1))
        after, turned = np.empty((2, *velocity.shape))
        passes.rebounds(velocity, radius * spin, normal, e, same, after, turned)
        return after, turned / radius, captured

    return strike


@lru_cache(maxsize=KEPT_TABLES)
def hit_slopes(distribution: Distribution) -> tuple[FloatArray, ...]:
    """Return the table by which slopes are weighted by the area of their facets as seen.

    Slopes between the cells, ascending, shape (n + 1,); share of all facets in each cell, (n,);
    share of facets below each edge, and integral of the slope over them, (n + 1,).
    """
    u = np.clip(scipy.special.ndtr(SCORES), SMALLEST_PROBABILITY, LARGEST_PROBABILITY)
    edges = np.asarray(distribution.quantile(u))
    mass = np.diff(u) / (u[-1] - u[0])
    first = mass * 0.5 * (edges[1:] + edges[:-1])
    sums = (np.concatenate([[0.0], np.cumsum(part)]) for part in (mass, first))
    return edges, mass, *sums
