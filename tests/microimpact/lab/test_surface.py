"""Rough surfaces: which facets are hit, what the rebound is in their frame, second contacts."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import integrate, optimize, special, stats

from microimpact.lab.surface import (
    LABORATORY,
    SMOOTH,
    Surface,
    collide,
    drawn_shares,
    facets,
    rough,
    simulated,
)
from microimpact.model.dynamics.impact import planar, spatial
from microimpact.model.passes import STEEPEST
from microimpact.statistics.distributions import (
    Constant,
    Histogram,
    Normal,
    Uniform,
    generator,
    uniforms,
)

SEED = 20011


def incoming(n, angle, speed=1.66):
    v = speed * np.array([np.cos(np.radians(angle)), 0.0, -np.sin(np.radians(angle))])
    return np.tile(v, (n, 1))


def planar_slopes(sd):
    return Surface(slope=Normal(sd=sd), cross_slope=Constant(at=0.0))


def hit_slopes(slope, u, tangent):
    """Slopes below which shares of all hits lie, at tangents of the angle of approach."""
    velocity = np.stack([np.ones(u.size), np.zeros(u.size), -tangent], axis=1)
    surface = Surface(slope=slope, cross_slope=Constant(at=0.0))
    x, _, z = facets(surface, velocity, u, np.full(u.size, 0.5)).T
    return -x / z


def facets_of(velocity, surface, seed):
    """The facets that particles hit first in `hit` with the same seed."""
    return facets(surface, velocity, *uniforms(generator(seed), (2, len(velocity))))


def hit(contact, velocity, spin, surface, seed, law=None):
    """Rebounds of spheres of one contact."""
    n, rng = len(velocity), generator(seed)
    return collide(
        surface, velocity, spin, drawn_shares(rng, n, surface.rules), simulated(contact, n, law)
    )


@pytest.mark.parametrize("c", [-0.4, 0.05, 0.6, 1.0, 3.0, 40.0])
def test_slopes_follow_the_area_seen_along_the_motion(c):
    """The closed form for normal slopes, inverted, and its limits."""

    def seen(x):
        """Integral of (c + s) phi(s) from -c to x."""
        return c * (special.ndtr(x) - special.ndtr(-c)) + phi(-c) - phi(x)

    def phi(s):
        return np.exp(-0.5 * s * s) / np.sqrt(2.0 * np.pi)

    low, sd = max(-c, -12.0), 0.2
    assert seen(1.0) == pytest.approx(
        integrate.quad(lambda s: (c + s) * phi(s), low, 1.0)[0], rel=1e-9
    )
    u = np.linspace(0.001, 0.999, 200)
    found = hit_slopes(Normal(sd=sd), u, np.full(u.size, sd * c)) / sd
    exact = [optimize.brentq(lambda x, s=s: seen(x) - s * seen(40.0), low, 12.0) for s in u]
    # a cell of 1/128 is taken as uniform
    assert found == pytest.approx(exact, abs=3e-5)
    assert np.all(found > -c)


def test_mean_facing_slope_is_the_tilted_moment():
    # E[x] = E[x (c + x)+] / E[(c + x)+] = Phi(c) / (c Phi(c) + phi(c)).
    c, n = 0.7, 400_000
    x = hit_slopes(Normal(), (np.arange(n) + 0.5) / n, np.full(n, c))
    expected = stats.norm.cdf(c) / (c * stats.norm.cdf(c) + stats.norm.pdf(c))
    assert np.mean(x) == pytest.approx(expected, rel=1e-4)


def test_hit_slopes_of_other_distributions():
    u = np.array([0.1, 0.5, 0.9])
    # density (c + x) on (-c, c): the share below x is ((c + x) / 2c)^2
    found = hit_slopes(Uniform(low=-0.1, high=0.1), u, np.full(3, 0.1))
    assert found == pytest.approx(0.2 * np.sqrt(u) - 0.1, rel=1e-6)
    one = hit_slopes(Constant(at=0.1), u, np.array([0.3, -0.05, -0.2]))
    assert one == pytest.approx([0.1, 0.1, -STEEPEST])  # where no facet can be hit
    # two kinds of facets are hit in the ratio of c + x
    many = generator(SEED, 7).random(2**16)
    narrow = Histogram(edges=(-0.1001, -0.1, 0.2, 0.2001), counts=(1.0, 0.0, 1.0))
    kinds = hit_slopes(narrow, many, np.full(2**16, 0.4))
    assert np.mean(kinds > 0.05) == pytest.approx(0.6 / 0.9, abs=0.01)


def test_facets_always_face_the_particle():
    v = incoming(5000, 5.0)
    normal = facets_of(v, rough(0.3), seed=1)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0)
    assert np.all(np.vecdot(normal, v) < 0.0)
    assert np.all(normal[:, 2] > 0.0)


def test_equal_weights_take_facets_as_they_lie():
    equal = replace(rough(0.3), rules=replace(LABORATORY, facets="facing"))
    v = incoming(100_000, 5.0)
    normal = facets_of(v, equal, seed=1)
    assert np.mean(normal[:, 0] / normal[:, 2]) == pytest.approx(0.0, abs=0.005)
    assert np.mean(np.vecdot(v, normal) > 0.0) == pytest.approx(
        stats.norm.cdf(-np.tan(np.radians(5.0)) / 0.3), abs=0.005
    )


def test_slopes_along_and_across_go_with_the_motion():
    """The frame of a facet turns with the direction of the motion, whatever it is."""
    shares = uniforms(generator(1), (2, 50))
    turn = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    v = incoming(50, 30.0)
    one, other = (facets(rough(0.2), w, *shares) for w in (v, v @ turn.T))
    np.testing.assert_allclose(other, one @ turn.T, atol=1e-14)
    assert np.std(one[:, 1]) > 0.1


def test_a_smooth_surface_gives_the_smooth_impact(contact):
    v = incoming(7, 40.0)
    rebound = hit(contact, v, np.zeros((7, 3)), SMOOTH, 1)
    smooth = spatial(contact, v)
    np.testing.assert_allclose(rebound.velocity, smooth.velocity, rtol=1e-13, atol=1e-16)
    np.testing.assert_allclose(rebound.spin, smooth.spin, rtol=1e-13, atol=1e-9)
    assert np.all(rebound.contacts == 1)


def test_a_facet_is_a_rotated_plane(contact):
    """One planar facet of slope phi: the planar impact at alpha + phi, turned back."""
    v = incoming(200, 25.0)
    spin = np.zeros((200, 3))
    spin[:, 1] = 4e3
    normal = facets_of(v, planar_slopes(0.1), seed=5)
    once = replace(planar_slopes(0.1), rules=replace(LABORATORY, most_contacts=1))
    rebound = hit(contact, v, spin, once, 5)
    phi = np.arctan2(-normal[:, 0], normal[:, 2])
    local = np.radians(25.0) + phi
    outcome = planar(contact, -1.66 * np.sin(local), 1.66 * np.cos(local), 4e3)
    v_n = outcome.normal_velocity * np.cos(phi) + outcome.tangential_velocity * np.sin(phi)
    v_t = outcome.tangential_velocity * np.cos(phi) - outcome.normal_velocity * np.sin(phi)
    np.testing.assert_allclose(rebound.velocity[:, 2], v_n, rtol=1e-10, atol=1e-13)
    np.testing.assert_allclose(rebound.velocity[:, 0], v_t, rtol=1e-10, atol=1e-13)
    np.testing.assert_allclose(rebound.spin[:, 1], outcome.spin, rtol=1e-10)


def test_no_rebound_gains_energy(contact):
    v = incoming(3000, 8.0)
    spin = generator(2).normal(0.0, 5e3, (3000, 3))
    rebound = hit(contact, v, spin, rough(0.2), 2)
    inertia = 0.4 * (contact.diameter / 2) ** 2

    def energy(velocity, turn):
        return np.sum(velocity**2, axis=1) + inertia * np.sum(turn**2, axis=1)

    gained = energy(rebound.velocity, rebound.spin) - energy(v, spin)
    assert np.all(gained <= 1e-12 * energy(v, spin))


def test_who_rebounds_leaves_the_surface_and_second_contacts_happen(contact):
    rebound = hit(contact, incoming(4000, 5.0), np.zeros((4000, 3)), rough(0.1), 3)
    assert np.all(rebound.velocity[~rebound.captured, 2] > 0.0)
    assert rebound.contacts.max() > 1
    single = replace(rough(0.1), rules=replace(LABORATORY, most_contacts=1))
    once = hit(contact, incoming(4000, 5.0), np.zeros((4000, 3)), single, 3)
    assert once.captured.sum() > rebound.captured.sum()


def test_first_facets_do_not_depend_on_the_fate_of_others(contact):
    """The same draws, whoever is captured: changing one particle leaves the others as they were."""
    v = incoming(50, 6.0)
    slow = v.copy()
    slow[10] *= 0.01
    a = hit(contact, v, np.zeros((50, 3)), rough(0.15), 4)
    b = hit(contact, slow, np.zeros((50, 3)), rough(0.15), 4)
    others = np.arange(50) != 10
    np.testing.assert_array_equal(a.velocity[others], b.velocity[others])
