"""The rough surface: which facets a sphere meets, and what they do to it until it leaves.

A rough surface (or a rough particle) is a plane of facets whose normals differ from the nominal
one, the z axis. A facet is given by its slopes, tangents of angles: along the motion of the sphere,
positive where the facet faces it, and across. Seen along the motion a facet shows the area
``(-v.n)+ / n_z``, so that with x the slope along the motion and c the tangent of the angle of
approach it is hit in proportion to ``(c + x)+``; the slope across it leaves as it is. A sphere that
still moves towards the surface after a contact meets another facet.

What one contact does is a `Strike`, given from outside: dynamic simulation in the laboratory,
that or the rigid body model in Monte Carlo analyses.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice
from typing import Annotated, Literal

import numpy as np
import scipy
from pydantic import Field

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.compiled import jit
from microimpact.lab.events import IntArray
from microimpact.model.contact import Contact
from microimpact.model.dynamics.impact import NormalLaw, spatial
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
# Beyond this the motion is so steep that all facets are hit alike, to rounding.
STEEPEST = 1e8
TINY = float(np.finfo(float).tiny)
KEPT_TABLES = 64

_jit = jit()


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
        So many facets may be hit in turn by a sphere that does not leave the surface.
    """

    facets: Literal["seen", "facing", "every"]
    must_leave: bool
    most_contacts: Annotated[int, Field(ge=1, le=20)]


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


def combined_slope(surface: float, particle: float) -> float:
    """Return the slope between two rough bodies, each with its own independent slopes."""
    return float(np.hypot(surface, particle))


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
    """Yield plain shares for `collide`, those of each contact when it is asked for."""
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
        normal = facets(surface, velocity[moving], along[moving], across[moving])
        into = np.vecdot(velocity[moving], normal)
        if surface.rules.facets == "every":
            normal, into = -np.sign(into)[:, None] * normal, -np.abs(into)
        moving, normal = moving[into < 0.0], normal[into < 0.0]
        velocity[moving], spin[moving], stays = strike(
            moving, velocity[moving], spin[moving], normal
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
        Of approach, m/s, shape (n, 3).
    along, across
        Shares of which the quantiles are the slopes, shape (n,).
    """
    if surface.rules.facets == "seen":
        speed = np.hypot(velocity[:, 0], velocity[:, 1])
        # Upright motion meets all facets alike; no slope can be hit where none faces the sphere.
        tangent = -velocity[:, 2] / np.maximum(speed, TINY)
        slope = np.maximum(hit_slopes(surface.slope).quantile(along, tangent), -STEEPEST)
    else:
        slope = surface.slope.quantile(along)
    return facet_normals(velocity, slope, surface.cross_slope.quantile(across))


def facet_normals(velocity: FloatArray, along: FloatArray, across: FloatArray) -> FloatArray:
    """Return unit normals of facets, shape (n, 3).

    Parameters
    ----------
    velocity
        Before impact, shape (n, 3); only its direction along the nominal surface counts (x, if it
        is normal).
    along, across
        Slopes of the facet along the motion and to its left, tangents, shape (n,). A facet whose
        slope along the motion is positive faces the sphere.
    """
    normal = np.empty(velocity.shape)
    _normals(velocity, along, across, normal)
    return normal


@_jit
def _normals(velocity, along, across, normal):  # type: ignore[no-untyped-def]
    """Write normals of planes z = along s + across q, s along the motion and q to its left."""
    for i in range(velocity.shape[0]):
        x, y = 1.0, 0.0
        speed = math.sqrt(velocity[i, 0] ** 2 + velocity[i, 1] ** 2)
        if speed > 0.0:
            x, y = velocity[i, 0] / speed, velocity[i, 1] / speed
        size = 1.0 / math.sqrt(1.0 + along[i] ** 2 + across[i] ** 2)
        normal[i, 0] = size * (y * across[i] - x * along[i])
        normal[i, 1] = size * (-x * across[i] - y * along[i])
        normal[i, 2] = size


def facet_frames(normal: FloatArray) -> FloatArray:
    """Return right-handed frames of facets: rows t1, t2 and normal, shape (n, 3, 3)."""
    frames = np.empty((len(normal), 3, 3))
    _lay(normal, frames)
    return frames


@_jit
def _lay(normal, frames):  # type: ignore[no-untyped-def]
    for i in range(normal.shape[0]):
        n0, n1, n2 = normal[i, 0], normal[i, 1], normal[i, 2]
        size = 1.0 / math.sqrt(n0 * n0 + n2 * n2)
        t0, t2 = n2 * size, -n0 * size
        frames[i, 0, 0], frames[i, 0, 1], frames[i, 0, 2] = t0, 0.0, t2
        frames[i, 1, 0], frames[i, 1, 1], frames[i, 1, 2] = n1 * t2, n2 * t0 - n0 * t2, -n1 * t0
        frames[i, 2, 0], frames[i, 2, 1], frames[i, 2, 2] = n0, n1, n2


def simulated(contact: Contact, n: int, law: NormalLaw | None = None) -> Strike:
    """Return contacts of n spheres by dynamic simulation (Eqs. 19-29).

    Parameters
    ----------
    contact
        Of one sphere, for all, or of n.
    n
        Number of spheres.
    law
        Where normal impacts come from, see `model.dynamics.impact.planar`.
    """

    def strike(
        which: IntArray, velocity: FloatArray, spin: FloatArray, normal: FloatArray
    ) -> tuple[FloatArray, FloatArray, BoolArray]:
        frames = facet_frames(normal)
        outcome = spatial(
            _of(contact, which, n),
            np.einsum("mij,mj->mi", frames, velocity),
            np.einsum("mij,mj->mi", frames, spin),
            law=law,
        )
        return (
            np.einsum("mij,mi->mj", frames, outcome.velocity),
            np.einsum("mij,mi->mj", frames, outcome.spin),
            np.asarray(outcome.captured),
        )

    return strike


def _of(contact: Contact, index: IntArray, n: int) -> Contact:
    """Return the contacts of some of n spheres; a single contact serves all."""
    if contact.shape != (n,) or len(index) == n:
        return contact
    names = (contact.adhesion_input, "diameter", "hertz_damping", "adhesion_damping", "friction")
    return contact.replace(
        **{name: np.broadcast_to(getattr(contact, name), (n,))[index] for name in names}
    )


@dataclass(frozen=True, slots=True, eq=False)
class HitSlopes:
    """Slopes weighted by the area of their facets as seen along the motion.

    Attributes
    ----------
    edges
        Slopes between the cells, ascending, shape (n + 1,).
    mass
        Share of all facets in each cell, shape (n,).
    below, moment
        Share of facets below each edge, and integral of the slope over them, shape (n + 1,).
    """

    edges: FloatArray
    mass: FloatArray
    below: FloatArray
    moment: FloatArray

    def quantile(self, u: FloatArray, tangent: FloatArray) -> FloatArray:
        """Return the slopes below which a share ``u`` of all hits lies.

        Parameters
        ----------
        u
            Shares in (0, 1), shape (n,).
        tangent
            Of the angle of approach, shape (n,); negative for a sphere that recedes.

        Returns
        -------
        ndarray
            Shape (n,); -inf where no facet can be hit.
        """
        slope = np.empty(np.shape(u))
        c = np.minimum(tangent, STEEPEST)
        _quantiles(
            np.ascontiguousarray(u), c, self.edges, self.mass, self.below, self.moment, slope
        )
        return slope


@lru_cache(maxsize=KEPT_TABLES)
def hit_slopes(distribution: Distribution) -> HitSlopes:
    """Return the table of a distribution of slopes."""
    u = np.clip(scipy.special.ndtr(SCORES), SMALLEST_PROBABILITY, LARGEST_PROBABILITY)
    edges = np.asarray(distribution.quantile(u))
    mass = np.diff(u) / (u[-1] - u[0])
    first = mass * 0.5 * (edges[1:] + edges[:-1])
    sums = (np.concatenate([[0.0], np.cumsum(part)]) for part in (mass, first))
    return HitSlopes(edges, mass, *sums)


@_jit
def _quantiles(u, c, edges, mass, below, moment, slope):  # type: ignore[no-untyped-def]
    """Invert the integral of (c + x)+ over the facets up to a slope x."""
    end = mass.size
    for i in range(u.size):
        if c[i] + edges[end] <= 0.0:
            slope[i] = -np.inf
            continue
        cell = min(max(np.searchsorted(edges, -c[i], side="right") - 1, 0), end - 1)
        start = min(max(-c[i], edges[cell]), edges[cell + 1])
        reached = _hits(cell, start, c[i], edges, mass, below, moment)
        target = reached + u[i] * (c[i] * below[end] + moment[end] - reached)
        # From the cell of -c on the integral ascends; halve the cells until one is left.
        last = end
        while last - cell > 1:
            middle = (cell + last) // 2
            if c[i] * below[middle] + moment[middle] > target:
                last = middle
            else:
                cell = middle
        start = max(start, edges[cell])
        rest = max(target - _hits(cell, start, c[i], edges, mass, below, moment), 0.0)
        # Far out a cell may hold less than rounding.
        rest *= (edges[cell + 1] - edges[cell]) / max(mass[cell], TINY)
        weight = max(c[i] + start, 0.0)
        # Root of weight x + x^2/2 = rest; without cancellation where the weight is large.
        divisor = weight + math.sqrt(weight * weight + 2.0 * rest)
        step = 2.0 * rest / divisor if divisor > 0.0 else 0.0
        slope[i] = min(start + step, edges[cell + 1])


@_jit
def _hits(cell, slope, c, edges, mass, below, moment):  # type: ignore[no-untyped-def]
    """Integral of c + x over the facets up to a slope within a cell."""
    left, right = edges[cell], edges[cell + 1]
    share = (slope - left) / (right - left) if right > left else 0.0
    within = mass[cell] * share * (c + 0.5 * (left + slope))
    return c * below[cell] + moment[cell] + within
