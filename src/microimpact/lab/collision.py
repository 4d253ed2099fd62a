"""Impacts on a rough surface: facets, weighted by how often they are hit, and second contacts.

A rough surface (or a rough particle) is a plane of the same contact whose local normal differs from
the nominal one. Slopes are normal, with one standard deviation per axis; a facet is hit in
proportion to its area as seen along the motion, ``(-v.n)+ / n_z``, so that facets that face the
particle are hit more often and those turned away never. A particle that still moves towards the
surface after its first contact meets another facet.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.compiled import jit
from microimpact.lab.events import IntArray
from microimpact.model.contact import Contact
from microimpact.model.dynamics.impact import NormalLaw, spatial
from microimpact.statistics.distributions import uniforms

MOST_CONTACTS = 5
NEWTON_STEPS = 60

_jit = jit()


@dataclass(frozen=True, slots=True, kw_only=True)
class Rebound:
    """State after the last contact, in the frame of the nominal surface (normal along z).

    Attributes
    ----------
    velocity, spin
        m/s and rad/s, shape (n, 3).
    captured
        True where the particle stays: a contact did not end, or `MOST_CONTACTS` were not enough
        to leave the surface; shape (n,).
    contacts
        Contacts made, shape (n,).
    """

    velocity: FloatArray
    spin: FloatArray
    captured: BoolArray
    contacts: IntArray


def collide(
    contact: Contact,
    velocity: FloatArray,
    spin: FloatArray,
    slope_sd: float,
    rng: np.random.Generator,
    *,
    planar_slopes: bool = False,
    most_contacts: int = MOST_CONTACTS,
    law: NormalLaw | None = None,
) -> Rebound:
    """Let n particles hit a surface.

    Parameters
    ----------
    contact
        The contact, of one sphere or of n spheres.
    velocity, spin
        Before impact, m/s and rad/s, shape (n, 3); velocity[:, 2] < 0.
    slope_sd
        Standard deviation of the surface's slope along each axis (tangent of the angle); 0 is
        smooth.
    rng
        Source of the facets.
    planar_slopes
        Whether facets slope along the motion only, as in the plane of the article's Fig. 22.
    most_contacts
        Contacts after which a particle that does not leave counts as captured.
    law
        Where normal impacts come from, see `model.dynamics.impact.planar`.
    """
    n = len(velocity)
    velocity, spin = np.array(velocity, dtype=float), np.array(spin, dtype=float)
    captured, contacts = np.zeros(n, dtype=bool), np.zeros(n, dtype=np.int64)
    moving = np.arange(n)
    for _ in range(most_contacts):
        # All n are drawn for, so that the facets of one particle do not depend on another's fate.
        drawn = uniforms(rng, (2, n))[:, moving]
        frames = facet_frames(velocity[moving], slope_sd, drawn, planar_slopes)
        after, turn, stays = _on_facets(
            _of(contact, moving, n), velocity[moving], spin[moving], frames, law
        )
        velocity[moving], spin[moving] = after, turn
        captured[moving] = stays
        contacts[moving] += 1
        moving = moving[~stays & (after[:, 2] <= 0.0)]
        if moving.size == 0:
            break
    captured[moving] = True
    return Rebound(velocity=velocity, spin=spin, captured=captured, contacts=contacts)


def _of(contact: Contact, index: IntArray, n: int) -> Contact:
    """Return the contacts of some of n particles; a single contact serves all."""
    if contact.shape != (n,) or len(index) == n:
        return contact
    names = (contact.adhesion_input, "diameter", "hertz_damping", "adhesion_damping", "friction")
    return contact.replace(
        **{name: np.broadcast_to(getattr(contact, name), (n,))[index] for name in names}
    )


def _on_facets(
    contact: Contact,
    velocity: FloatArray,
    spin: FloatArray,
    frames: FloatArray,
    law: NormalLaw | None,
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Velocity, spin and capture after one contact on facets given by their frames (m, 3, 3)."""
    outcome = spatial(
        contact,
        np.einsum("mij,mj->mi", frames, velocity),
        np.einsum("mij,mj->mi", frames, spin),
        law=law,
    )
    back = np.swapaxes(frames, 1, 2)
    return (
        np.einsum("mij,mj->mi", back, outcome.velocity),
        np.einsum("mij,mj->mi", back, outcome.spin),
        np.asarray(outcome.captured),
    )


def facet_frames(
    velocity: FloatArray, slope_sd: float, drawn: FloatArray, planar_slopes: bool
) -> FloatArray:
    """Return the frames of the facets hit: rows t1, t2 and normal, shape (n, 3, 3).

    Parameters
    ----------
    velocity
        Of approach, m/s, shape (n, 3).
    slope_sd
        Standard deviation of the slope along each axis.
    drawn
        Uniform numbers that choose the facets, along the motion and across it, shape (2, n).
    planar_slopes
        As in `collide`.
    """
    facing, across = drawn
    along = np.hypot(velocity[:, 0], velocity[:, 1])
    rise = slope_sd * weighted_slope(facing, -velocity[:, 2], slope_sd * along)
    side = np.zeros_like(along) if planar_slopes else slope_sd * scipy.special.ndtri(across)
    frames = np.empty((len(along), 3, 3))
    _lay(velocity, along, rise, side, frames)
    return frames


@_jit
def _lay(velocity, along, rise, side, frames):  # type: ignore[no-untyped-def]
    """Frames of facets by their slopes along the motion (x, if it is normal) and to its left.

    The surface z = rise s + side q, with s along the motion, has the normal (-rise, -side, 1).
    """
    for i in range(along.size):
        x, y = 1.0, 0.0
        if along[i] > 0.0:
            x, y = velocity[i, 0] / along[i], velocity[i, 1] / along[i]
        first, second, normal = frames[i]
        normal[0], normal[1], normal[2] = side[i] * y - rise[i] * x, -rise[i] * y - side[i] * x, 1.0
        normal /= math.sqrt(normal[0] ** 2 + normal[1] ** 2 + 1.0)
        first[0], first[1], first[2] = normal[2], 0.0, -normal[0]
        first /= math.sqrt(normal[2] ** 2 + normal[0] ** 2)
        second[0] = normal[1] * first[2] - normal[2] * first[1]
        second[1] = normal[2] * first[0] - normal[0] * first[2]
        second[2] = normal[0] * first[1] - normal[1] * first[0]


def weighted_slope(u: FloatArray, normal_speed: FloatArray, slope_speed: FloatArray) -> FloatArray:
    """Return the slope of the facet hit, along the motion, in standard deviations.

    With x the slope and ``c = normal_speed / slope_speed`` its density is proportional to
    ``(c + x)+ phi(x)``; that is the area of facets of slope x as seen along the motion. The
    distribution function, ``c (Phi(x) - Phi(-c)) + phi(c) - phi(x)`` over its value at infinity, is
    inverted by Newton steps kept inside a bracket.

    Parameters
    ----------
    u
        Uniform numbers in (0, 1), shape (n,).
    normal_speed
        Speed towards the nominal surface, m/s; negative: leaving it, and caught up by a facet.
    slope_speed
        Speed along the surface times the standard deviation of the slope, m/s; 0 gives the plain
        normal distribution.
    """
    slope = np.array(scipy.special.ndtri(u))
    _weigh(np.ascontiguousarray(u), normal_speed, slope_speed, slope)
    return slope


@_jit
def _weigh(u, normal_speed, slope_speed, slope):  # type: ignore[no-untyped-def]
    """Replace quantiles of the plain normal distribution by those of the weighted one."""
    for i in range(slope.size):
        # Beyond this the weight is flat to rounding, and c * Phi would lose what matters.
        if normal_speed[i] < 1e8 * slope_speed[i]:
            slope[i] = _weighted_quantile(u[i], normal_speed[i] / slope_speed[i], slope[i])


@_jit
def _weighted_quantile(u, c, guess):  # type: ignore[no-untyped-def]
    cut, at_cut = _below(-c), _phi(c)
    wanted = u * (c * _below(c) + at_cut)
    low, high = -c, max(-c, 0.0) + 10.0
    x = min(max(guess, low), high)
    for _ in range(NEWTON_STEPS):
        excess = c * (_below(x) - cut) + at_cut - _phi(x) - wanted
        if excess < 0.0:
            low = x
        elif excess > 0.0:
            high = x
        density = (c + x) * _phi(x)
        moved = x - excess / density if density > 0.0 else x
        if not low < moved < high:
            moved = 0.5 * (low + high)
        if abs(moved - x) <= 1e-14 * (1.0 + abs(x)):
            break
        x = moved
    return x


@_jit
def _below(x):  # type: ignore[no-untyped-def]
    """Distribution function of the normal distribution."""
    return 0.5 * math.erfc(-math.sqrt(0.5) * x)


@_jit
def _phi(x):  # type: ignore[no-untyped-def]
    return math.exp(-0.5 * x * x) / math.sqrt(2.0 * math.pi)
