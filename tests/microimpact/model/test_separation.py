"""Forces that hold a charged, coated particle on a plane."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import j1

from microimpact import Contact, Material
from microimpact.model.separation import (
    PLACEMENTS,
    CoatedParticle,
    adhesion_force,
    carried_share,
    coverage,
    disc_image_factor,
    image_force,
    jkr_contact_radius,
    jkr_pull_off,
    patch_area,
    patch_force,
    spherule_count,
    touching_spherules,
)

EPSILON_0 = 8.8541878e-12
SILICA = np.linspace(0.0, 0.2, 81)


def particle(**changes):
    """Return 8 um of polymer with 16 nm of silica."""
    fields = {
        "radius": 4e-6,
        "density": 1200.0,
        "surface_factor": 1.0,
        "stiffness": 4.56e9,
        "work_of_adhesion": 0.05,
        "spherule_radius": 8e-9,
        "spherule_density": 2200.0,
    }
    return CoatedParticle(**(fields | changes))


def test_jkr_of_a_known_case():
    # 1.5 pi 0.05 4e-6, worked out by hand
    assert jkr_pull_off(0.05, 4e-6) == pytest.approx(942.5e-9, rel=1e-4)
    # pull-off is where JKR's contact radius stops being real: F = -3 pi w R / 2
    work, radius, stiffness = 0.05, 4e-6, 4.56e9
    pull = jkr_pull_off(work, radius)
    inner = 6 * math.pi * work * radius * -pull + (3 * math.pi * work * radius) ** 2
    assert inner == pytest.approx(0.0, abs=1e-12 * pull**2)
    cube = radius / stiffness * (0 + 3 * math.pi * work * radius + 3 * math.pi * work * radius)
    assert jkr_contact_radius(work, radius, stiffness) ** 3 == pytest.approx(cube, rel=1e-12)


def test_contact_radius_is_that_of_the_impact_model():
    bodies = [
        Material(name=name, youngs_modulus=modulus, poissons_ratio=0.3, density=1200.0)
        for name, modulus in (("polymer", 3e9), ("plate", 70e9))
    ]
    contact = Contact(particle=bodies[0], surface=bodies[1], diameter=8e-6, work_of_adhesion=0.05)
    compression = contact.equilibrium_compression
    radius = jkr_contact_radius(0.05, 4e-6, contact.hertz_stiffness)
    assert math.sqrt(compression * 4e-6) == pytest.approx(radius, rel=1e-6)


def test_image_force_of_a_known_case():
    # Rimai's lecture on toner: 15 uC/g on 6 um of radius, 1.4e-14 C, give 12 nN
    assert image_force(1.4e-14, 6e-6) == pytest.approx(12e-9, rel=0.03)
    # one elementary charge 1 nm from a conductor: Coulomb's law at 2 nm
    coulomb = 8.98755e9 * 1.602177e-19**2 / (2e-9) ** 2
    assert image_force(1.602177e-19, 1e-9) == pytest.approx(coulomb, rel=1e-5)
    assert image_force(1e-15, 3e-6, 1e-6) == pytest.approx(image_force(1e-15, 4e-6))
    assert image_force(2e-15, 4e-6, 0.0, 1.9) == pytest.approx(7.6 * image_force(1e-15, 4e-6))


def test_energy_of_lifting_a_uniform_charge():
    # the work done against the image force from R to infinity is q^2 / (16 pi eps_0 R)
    work, _ = quad(lambda gap: image_force(5e-15, 4e-6, gap), 0, np.inf, epsabs=0)
    energy = 5e-15**2 / (16 * math.pi * EPSILON_0 * 4e-6)
    assert work == pytest.approx(energy, rel=1e-6)


def test_patch_force_without_a_gap_is_pressure_times_area():
    density = EPSILON_0 * 1e8
    area = 0.2 * patch_area(4.8e-15, 1e8)
    assert density * area == pytest.approx(0.2 * 4.8e-15, rel=1e-6)
    expected = density**2 * area / (2 * EPSILON_0)
    assert patch_force(4.8e-15, 0.2, 1e8) == pytest.approx(expected, rel=1e-6)
    assert expected == pytest.approx(48e-9, rel=1e-6)  # share times q E_b / 2


@pytest.mark.parametrize("p", [1e-3, 0.07, 0.5, 2.0, 10.0])
def test_disc_and_its_image_against_the_integral(p):
    value, _ = quad(
        lambda t: 2 * j1(t) ** 2 * math.exp(-p * t) / t if t else 0.0,
        0,
        min(40 / p, 4e3),
        limit=4000,
    )
    assert disc_image_factor(p) == pytest.approx(value, rel=2e-4)


def test_disc_and_its_image_in_the_limits():
    assert disc_image_factor(0.0) == 1.0
    # far away two point charges: pi a^2 s^2 / (8 eps_0 p^2) against pi a^2 s^2 / (2 eps_0) ...
    assert disc_image_factor(500.0) == pytest.approx(1 / (2 * 500.0**2), rel=1e-4)
    # ... which is the image force of the same charge
    gap, field = 1e-4, 1e8
    charge = 1e-15
    assert patch_force(charge, 1.0, field, gap) == pytest.approx(image_force(charge, gap), rel=1e-3)
    assert (np.diff(disc_image_factor(np.linspace(0.0, 20.0, 200))) < 0).all()


def test_count_and_coverage_by_hand():
    bare = particle()
    # equal weights: as many spherules as weigh what the particle does
    weight = 4 / 3 * math.pi * (4e-6) ** 3 * 1200
    each = 4 / 3 * math.pi * (8e-9) ** 3 * 2200
    assert spherule_count(bare, 0.5) == pytest.approx(weight / each, rel=1e-12)
    assert coverage(bare, 0.02) == pytest.approx(
        spherule_count(bare, 0.02) * math.pi * (8e-9) ** 2 / (4 * math.pi * (4e-6) ** 2)
    )
    assert coverage(bare, 0.02) == pytest.approx(1.391, rel=1e-3)
    assert coverage(particle(surface_factor=2.0), 0.02) == pytest.approx(1.391 / 2, rel=1e-3)
    assert coverage(particle(spherule_radius=16e-9), 0.02) == pytest.approx(1.391 / 2, rel=1e-3)


@pytest.mark.parametrize("placement", PLACEMENTS)
def test_without_silica_the_particle_is_bare(placement):
    assert adhesion_force(particle(), 0.0, placement) == pytest.approx(jkr_pull_off(0.05, 4e-6))


@pytest.mark.parametrize("placement", PLACEMENTS)
def test_more_silica_never_holds_better_and_saturates(placement):
    coated = particle()
    force = adhesion_force(coated, SILICA, placement)
    assert (np.diff(force) <= 1e-12 * force[0]).all()
    assert force[1] < force[0]
    share = carried_share(coated, SILICA, placement)
    assert ((share >= 0) & (share <= 1)).all()
    full = touching_spherules(coated) * jkr_pull_off(0.05, 8e-9)
    assert force[-1] == pytest.approx(full, rel=1e-3)


def test_side_by_side_the_layer_is_full_at_a_coverage_of_one():
    coated = particle()
    full = 1 / (1 + coverage(coated, 0.5))  # x / (1 - x) times the coverage of equal weights
    below, above = (carried_share(coated, full * f, "even") for f in (0.99, 1.01))
    assert below < 1.0
    assert above == 1.0


def test_order_of_the_limits():
    lifted, even, random = (adhesion_force(particle(), SILICA[1:], p) for p in PLACEMENTS)
    assert (lifted <= even * (1 + 1e-12)).all()
    assert (even <= random * (1 + 1e-12)).all()


def test_lifted_by_three():
    coated = particle(spherule_radius=2e-7, work_of_adhesion=0.01)
    spots = (jkr_contact_radius(0.01, 4e-6, 4.56e9) / 2e-7) ** 2
    mean = spots * coverage(coated, 0.2)
    few = math.exp(-mean) * (1 + mean + mean**2 / 2)  # none, one or two
    assert carried_share(coated, 0.2, "lifted") == pytest.approx(1 - few, rel=1e-9)


def test_share_left_by_a_full_layer():
    # touching 2 R d / r^2 with d = a_0^2 / (3 r): force ratio (2/3) (6 pi w / (K r))^(2/3)
    coated = particle()
    ratio = 2 / 3 * (6 * math.pi * 0.05 / (4.56e9 * 8e-9)) ** (2 / 3)
    found = adhesion_force(coated, 0.2, "even") / adhesion_force(coated, 0.0, "even")
    assert found == pytest.approx(ratio, rel=1e-9)
    # no fewer than three, however stiff
    assert touching_spherules(particle(stiffness=1e13)) == 3


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"radius": 0.0}, "radius must be finite and > 0"),
        ({"work_of_adhesion": 10.0}, "work_of_adhesion must be below K r"),
    ],
)
def test_impossible_particles_are_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        particle(**changes)


def test_impossible_arguments_are_refused():
    with pytest.raises(ValueError, match=r"weight_fraction must be finite and in \[0, 1\)"):
        coverage(particle(), 1.0)
    with pytest.raises(ValueError, match="placement must be one of 'lifted', 'even', 'random'"):
        carried_share(particle(), 0.1, "odd")
