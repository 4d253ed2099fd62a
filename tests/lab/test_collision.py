"""Rough surfaces: which facets are hit, what the rebound is in their frame, second contacts."""

import numpy as np
import pytest
from scipy import integrate, special, stats

from microimpact.lab.collision import collide, facet_frames, weighted_slope
from microimpact.model.dynamics.impact import planar, spatial
from microimpact.statistics.distributions import generator, uniforms

REST = np.zeros((1, 3))


def incoming(n, angle, speed=1.66):
    v = speed * np.array([np.cos(np.radians(angle)), 0.0, -np.sin(np.radians(angle))])
    return np.tile(v, (n, 1))


def frames_of(velocity, slope_sd, seed, planar_slopes=False):
    """The facets that particles hit first in `collide` with the same seed."""
    drawn = uniforms(generator(seed), (2, len(velocity)))
    return facet_frames(velocity, slope_sd, drawn, planar_slopes)


@pytest.mark.parametrize("c", [0.05, 0.6, 1.0, 3.0, 40.0])
def test_slopes_follow_the_area_seen_along_the_motion(c):
    u = np.linspace(0.001, 0.999, 300)
    low = max(-c, -12.0)  # what lies beyond is below rounding
    x = weighted_slope(u, np.full(u.size, c), np.ones(u.size))
    total = integrate.quad(lambda s: (c + s) * stats.norm.pdf(s), low, 12.0)[0]
    for share, end in zip(u[::60], x[::60], strict=True):
        seen = integrate.quad(lambda s: (c + s) * stats.norm.pdf(s), low, end)[0]
        assert seen / total == pytest.approx(share, abs=1e-8)
    assert np.all(x > -c)


def test_slopes_are_plain_at_normal_incidence():
    u = np.linspace(0.01, 0.99, 50)
    flat = weighted_slope(u, np.ones(50), np.zeros(50))
    np.testing.assert_allclose(flat, special.ndtri(u))
    nearly = weighted_slope(u, np.ones(50), np.full(50, 1e-7))
    np.testing.assert_allclose(nearly, flat, atol=1e-5)


def test_mean_facing_slope_is_the_tilted_moment():
    # E[x] = E[x (c + x)+] / E[(c + x)+] = Phi(c) / (c Phi(c) + phi(c)).
    c, n = 0.7, 400_000
    x = weighted_slope((np.arange(n) + 0.5) / n, np.full(n, c), np.ones(n))
    expected = stats.norm.cdf(c) / (c * stats.norm.cdf(c) + stats.norm.pdf(c))
    assert np.mean(x) == pytest.approx(expected, rel=1e-4)


def test_facets_always_face_the_particle_and_frames_are_orthonormal():
    v = incoming(5000, 5.0)
    frames = frames_of(v, 0.3, seed=1)
    np.testing.assert_allclose(
        np.einsum("mij,mkj->mik", frames, frames), np.tile(np.eye(3), (5000, 1, 1)), atol=1e-14
    )
    np.testing.assert_allclose(np.linalg.det(frames), 1.0)
    assert np.all(np.einsum("mj,mj->m", frames[:, 2], v) < 0.0)
    assert np.all(frames[:, 2, 2] > 0.0)


def test_planar_slopes_stay_in_the_plane():
    frames = frames_of(incoming(100, 30.0), 0.2, seed=1, planar_slopes=True)
    assert np.all(frames[:, 2, 1] == 0.0)
    assert np.std(frames[:, 2, 0]) > 0.1


def test_a_smooth_surface_gives_the_smooth_impact(contact):
    v = incoming(7, 40.0)
    rebound = collide(contact, v, np.zeros((7, 3)), 0.0, generator(1))
    smooth = spatial(contact, v)
    np.testing.assert_allclose(rebound.velocity, smooth.velocity, rtol=1e-13, atol=1e-16)
    np.testing.assert_allclose(rebound.spin, smooth.spin, rtol=1e-13, atol=1e-9)
    assert np.all(rebound.contacts == 1)


def test_a_facet_is_a_rotated_plane(contact):
    """One planar facet of slope phi: the planar impact at alpha + phi, turned back."""
    v = incoming(200, 25.0)
    spin = np.zeros((200, 3))
    spin[:, 1] = 4e3
    frames = frames_of(v, 0.1, seed=5, planar_slopes=True)
    rebound = collide(contact, v, spin, 0.1, generator(5), planar_slopes=True, most_contacts=1)
    phi = np.arctan2(-frames[:, 2, 0], frames[:, 2, 2])
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
    rebound = collide(contact, v, spin, 0.2, generator(2))
    inertia = 0.4 * (contact.diameter / 2) ** 2

    def energy(velocity, turn):
        return np.sum(velocity**2, axis=1) + inertia * np.sum(turn**2, axis=1)

    gained = energy(rebound.velocity, rebound.spin) - energy(v, spin)
    assert np.all(gained <= 1e-12 * energy(v, spin))


def test_who_rebounds_leaves_the_surface_and_second_contacts_happen(contact):
    rebound = collide(contact, incoming(4000, 5.0), np.zeros((4000, 3)), 0.1, generator(3))
    assert np.all(rebound.velocity[~rebound.captured, 2] > 0.0)
    assert rebound.contacts.max() > 1
    once = collide(
        contact, incoming(4000, 5.0), np.zeros((4000, 3)), 0.1, generator(3), most_contacts=1
    )
    assert once.captured.sum() > rebound.captured.sum()


def test_particles_of_many_sizes_meet_their_own_contact(contact):
    sizes = np.array([20e-6, 62e-6, 110e-6])
    many = collide(
        contact.replace(diameter=sizes), incoming(3, 70.0), np.zeros((3, 3)), 0.0, generator(1)
    )
    for i, size in enumerate(sizes):
        one = collide(contact.replace(diameter=size), incoming(1, 70.0), REST, 0.0, generator(1))
        np.testing.assert_allclose(many.velocity[i], one.velocity[0], rtol=1e-12)


def test_first_facets_do_not_depend_on_the_fate_of_others(contact):
    """The same draws, whoever is captured: changing one particle leaves the others as they were."""
    v = incoming(50, 6.0)
    slow = v.copy()
    slow[10] *= 0.01
    a = collide(contact, v, np.zeros((50, 3)), 0.15, generator(4))
    b = collide(contact, slow, np.zeros((50, 3)), 0.15, generator(4))
    others = np.arange(50) != 10
    np.testing.assert_array_equal(a.velocity[others], b.velocity[others])
