"""The rough surface: the facets that a sphere meets, and its contacts until it leaves.

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

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
import scipy
from annotated_types import Ge, Le

from microimpact.core.arrays import BoolArray, FloatArray, Real
from microimpact.lab.events import IntArray
from microimpact.model import passes
from microimpact.model.contact import Contact
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.law.table import Law
from microimpact.model.passes import STEEPEST
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
# Parts of the hits of which the first cell is kept where one angle is that of many spheres.
GUIDES = 1024
# Hits at one angle, see `_steady`; empty where there are many.
Steady = tuple[IntArray, FloatArray]
NOT_STEADY: Steady = np.empty(0, dtype=np.int64), np.empty((0, 3))


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


class Spheres(NamedTuple):
    """Spheres that hit a surface.

    Attributes
    ----------
    drawn
        Speed, angle of incidence (degrees), r omega over the speed, friction, factor and offset of
        e, unit of the speed in the law (m/s), place in the law's family, each (number,) or (1,).
    shares
        As of `collide`, (number,) or (1,).
    number, parts
        Number of spheres, and of the equal parts that are added up apart.
    """

    drawn: Sequence[Real]
    shares: Iterable[tuple[FloatArray, FloatArray]]
    number: int
    parts: int


def rigid_sums(surface: Surface, law: Law, groups: Iterable[Spheres]) -> FloatArray:
    """Let rigid spheres hit a surface, and return sums over the observed rebounds.

    As `collide` with contacts of rigid bodies, but in one compiled pass without arrays between, and
    with one group in memory at a time. Contacts so close to capture that they must be integrated
    wait for those of all groups.

    Parameters
    ----------
    surface
        Its slopes and rules.
    law
        Of which e is taken.
    groups
        One or more.

    Returns
    -------
    ndarray
        Shape (parts of all groups, columns), see `model.passes.SUMS`.
    """
    rules, most = surface.rules, surface.rules.most_contacts
    codes = passes.FACETS.index(rules.facets), rules.must_leave, most
    look_ups = hit_slopes(surface.slope), codes, law.compiled
    parts: list[FloatArray] = []
    waiting: list[FloatArray] = []
    nothing_known = np.empty((most, 0))
    for spheres in groups:
        sums = np.zeros((spheres.parts, 2 * passes.LOST))
        _, late = _added(_events(surface, spheres), nothing_known, look_ups, sums)
        late[0] += sum(map(len, parts))
        waiting.append(late)
        parts.append(sums)
    sums, late = np.concatenate(parts), np.concatenate(waiting, axis=1)
    known = np.full((most, late.shape[1]), np.nan)
    while late.size:
        (rows, contact), (w, *columns) = late[:2].astype(np.int64), late[2:]
        drawn, along, across = columns[: -2 * most], columns[-2 * most : -most], columns[-most:]
        known[contact, np.arange(rows.size)] = law.restitution(w, drawn[-1])
        events = rows, drawn, np.stack(along), np.stack(across), NOT_STEADY
        who, late = _added(events, known, look_ups, sums)
        known = known[:, who]
    return sums[:, : passes.LOST] + sums[:, passes.LOST :]


# Events as the compiled pass takes them, see `model.passes.events`: rows, what is drawn, slopes
# along and across, and what is steady.
_Events = tuple[IntArray, Sequence[Real], FloatArray, FloatArray, Steady]


def _events(surface: Surface, spheres: Spheres) -> _Events:
    """Return the events of some spheres, their parts numbered from 0."""
    shares = (np.stack(one) for one in zip(*spheres.shares, strict=True))
    along, across = _slopes(surface, *shares)
    steady, angle = NOT_STEADY, spheres.drawn[1]
    if surface.rules.facets == "seen" and np.size(angle) == 1:
        steady = _steady(surface.slope, float(np.ravel(angle)[0]))
    rows = np.repeat(np.arange(spheres.parts), spheres.number // spheres.parts)
    return rows, spheres.drawn, along, across, steady


def _added(
    events: _Events, known: FloatArray, look_ups: tuple[Any, ...], sums: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Add events to sums, and return those that ask for e: numbers, and columns to come again.

    The columns: row of the sums, contact, w, all that is drawn, slopes along and across.
    """
    rows, drawn, along, across, steady = events
    flat = tuple(passes.flat(values, rows.shape) for values in drawn)
    asked = np.empty((rows.size, len(passes.ASKED)))
    number = passes.events(rows, known, flat, (along, across, steady), look_ups, sums, asked)
    who, (contact, w) = asked[:number, 0].astype(np.int64), asked[:number, 1:].T
    columns = [values[who % values.size] for values in (*flat, *along, *across)]
    return who, np.stack([rows[who], contact, w, *columns])


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
def _steady(distribution: Distribution, angle: float) -> Steady:
    """Inverse of the cumulative hit probability at one angle, degrees, of many spheres.

    Cell of each of ``GUIDES`` equal steps of probability, (GUIDES,); and per edge of the cells
    that can be hit, (cells + 1, 3): hits below, slope, width of the cell over its share of facets.
    """
    edges, mass, below, moment = hit_slopes(distribution)
    tangent = min(float(np.tan(np.radians(angle))), STEEPEST)
    if not 0.0 < angle <= 90.0 or tangent + edges[-1] <= 0.0:
        return NOT_STEADY
    first = int(np.searchsorted(edges, -tangent, side="right")) - 1
    first = min(max(first, 0), mass.size - 1)
    slope = np.maximum(edges[first:], -tangent)
    rate = np.append(np.diff(edges) / np.maximum(mass, passes.TINY), 0.0)[first:]
    hits = (tangent * below + moment)[first:]
    if rate[0] > 0.0:  # those of a part of the first cell
        hits[0] = hits[1] - 0.5 * ((tangent + slope[1]) ** 2 - (tangent + slope[0]) ** 2) / rate[0]
    steps = hits[0] + np.arange(GUIDES) / GUIDES * (hits[-1] - hits[0])
    cell = np.searchsorted(hits, steps, side="right") - 1
    return np.clip(cell, 0, hits.size - 2), np.stack([hits, slope, rate], axis=1)


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
