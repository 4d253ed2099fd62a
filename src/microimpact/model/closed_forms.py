"""Closed forms from the literature, to compare with the model: capture velocities, restitution.

Used by the studies and by the tests alike. Arguments are SI numbers or arrays that broadcast.
"""

from __future__ import annotations

import math

import numpy as np

from microimpact.core.arrays import FloatArray, Real
from microimpact.model.contact import Contact
from microimpact.model.dynamics.normal import WELL_DEPTH

# Spacing of atoms in contact, m, and Tabor's numbers from which JKR and up to which DMT hold.
ATOMIC_SPACING, JKR_ABOVE, DMT_BELOW = 0.4e-9, 5.0, 0.1

# Mean pressure over yield strength at which a sphere begins to yield below its surface.
YIELD_PRESSURE_RATIO = 1.6


def contact_modulus(contact: Contact) -> Real:
    """Contact modulus E* of Hertz, Pa: ``1/E* = pi (k_1 + k_2)``, three quarters of K."""
    return 0.75 * contact.hertz_stiffness


def jkr_sticking_velocity(contact: Contact) -> Real:
    """Quasi-static JKR sticking velocity, m/s (Thornton and Ning 1998; Johnson and Pollock 1994).

    ``V_s = (14.18/m)^(1/2) (w^5 r^4 / E*^2)^(1/6)``: the only loss is that of the snap-off.
    """
    work = contact.work_of_adhesion
    assert work is not None
    modulus = np.square(contact_modulus(contact))
    group = np.power(work, 5) * np.power(contact.hertz_radius, 4) / modulus
    velocity: Real = np.sqrt(14.18 / contact.mass) * np.power(group, 1.0 / 6.0)
    return velocity


def jkr_loss(contact: Contact) -> Real:
    """Energy that a JKR contact loses from closing to break, J: 7.0922 (w^5 r^4 / E*^2)^(1/3).

    ``(12/5) (1 + 6 4^(1/3)) (pi/6)^(5/3) (w^5 r^4 / K^2)^(1/3)``; twice the constant is printed as
    14.18 (Thornton and Ning 1998).
    """
    work = contact.work_of_adhesion
    assert work is not None
    group = np.power(work, 5) * np.power(contact.hertz_radius, 4)
    scale = np.power(group / np.square(contact.hertz_stiffness), 1.0 / 3.0)
    loss: Real = 2.4 * (1.0 + 6.0 * 4.0 ** (1.0 / 3.0)) * (np.pi / 6.0) ** (5.0 / 3.0) * scale
    return loss


def tabor_number(contact: Contact) -> Real:
    """Tabor's number ``(r w^2 / (E*^2 z^3))^(1/3)``, with the spacing z = 0.4 nm of atoms.

    It compares the stretch of a JKR contact with the range of the forces: JKR holds far above 1,
    the contact of Derjaguin, Muller and Toporov (DMT) far below (Tabor 1977; Johnson and
    Greenwood 1997).
    """
    work = contact.work_of_adhesion
    assert work is not None
    group = contact.hertz_radius * np.square(work) / np.square(contact_modulus(contact))
    return np.power(group, 1.0 / 3.0) / ATOMIC_SPACING


def contact_regime(number: float) -> str:
    """Elastic adhesive contact that holds at a Tabor number (Johnson and Greenwood 1997)."""
    if number >= JKR_ABOVE:
        return "JKR"
    return "DMT" if number <= DMT_BELOW else "between JKR and DMT"


def hertz_contact_time(contact: Contact, speed: Real) -> Real:
    """Contact time of an elastic impact without adhesion, s, at a normal speed in m/s (Hertz 1881).

    ``2 pi^(1/2) Gamma(7/5)/Gamma(9/10) n/V`` with the greatest compression ``n = (5 m V^2 / (4 K
    r^(1/2)))^(2/5)``.
    """
    stiffness = contact.hertz_stiffness * np.sqrt(contact.hertz_radius)
    compression = np.power(1.25 * contact.mass * np.square(speed) / stiffness, 0.4)
    time: Real = 2.0 * math.sqrt(math.pi) * math.gamma(1.4) / math.gamma(0.9) * compression / speed
    return time


def brach_dunn_velocity(contact: Contact) -> Real:
    """Capture velocity of Brach and Dunn 1992, m/s: the stick criterion of deposition codes.

    ``v_c = (2 Ebar/d)^(10/7)``, ``Ebar = 0.51 (5 pi^2 (k_1 + k_2) / (4 rho^(3/2)))^(2/5)``; in
    this form, spread by El-Batsh, codes for the deposition of particles in flows rely on it. No
    energy of adhesion occurs in it: the constant 0.51 is dimensional (SI) and is valid for one
    adhesion, whatever the surfaces.
    """
    compliance = 4.0 / (3.0 * np.pi * contact.hertz_stiffness)
    density = contact.particle.density
    effective = 0.51 * (1.25 * np.pi**2 * compliance / np.power(density, 1.5)) ** 0.4
    return np.power(2.0 * effective / contact.diameter, 10.0 / 7.0)


def dahneke_velocity(adhesion_energy: Real, mass: Real, restitution: Real) -> Real:
    """Capture velocity of Dahneke 1971, m/s: ``e^2 = (1 - e^2) E / (m v^2 / 2)`` at capture.

    Parameters
    ----------
    adhesion_energy
        Energy E of the adhering sphere, J.
    mass
        Mass of the sphere, kg.
    restitution
        Coefficient of restitution far above capture.
    """
    lost = (1.0 - np.square(restitution)) / np.square(restitution)
    return np.sqrt(2.0 * adhesion_energy / mass * lost)


def sticking_restitution(
    speed: Real, sticking_velocity: Real, restitution: Real = 1.0
) -> FloatArray:
    """Coefficient of restitution where adhesion takes the same energy at every speed.

    ``e = R sqrt(1 - (V_s/V)^2)``, zero up to V_s: with R = 1 that of JKR's quasi-static loss
    (Thornton and Ning 1998), with R that of the bare impact Dahneke's of 1971.

    Parameters
    ----------
    speed
        Normal impact speed V, m/s.
    sticking_velocity
        Capture velocity V_s, m/s.
    restitution
        R, the coefficient of restitution far above V_s.
    """
    share = np.square(np.asarray(sticking_velocity) / np.asarray(speed))
    return np.asarray(restitution * np.sqrt(np.maximum(1.0 - share, 0.0)))


def yield_velocity(contact: Contact, yield_strength: Real) -> Real:
    """Normal speed above which an impact without adhesion is plastic, m/s (Thornton and Ning 1998).

    ``V_y = (pi / 2E*)^2 (8 pi r^3 p_y^5 / (15 m))^(1/2)``, which is ``1.56 (p_y^5 / (E*^4
    rho))^(1/2)`` on a plane, with ``p_y = 1.6`` times the yield strength.

    Parameters
    ----------
    contact
        The contact.
    yield_strength
        Of the softer body, Pa.
    """
    pressure = YIELD_PRESSURE_RATIO * np.asarray(yield_strength)
    size = 8.0 * np.pi * np.power(contact.hertz_radius, 3) / (15.0 * contact.mass)
    slope = np.square(np.pi / (2.0 * contact_modulus(contact)))
    velocity: Real = slope * np.sqrt(size * np.power(pressure, 5))
    return velocity


def plastic_restitution(speed: Real, yield_velocity: Real) -> FloatArray:
    """Coefficient of restitution of an elastic-plastic impact without adhesion.

    Thornton and Ning 1998: with ``x = V_y/V``, ``e = (6 sqrt(3)/5)^(1/2) (1 - x^2/6)^(1/2) (x / (x
    + 2 (6/5 - x^2/5)^(1/2)))^(1/4)``; one up to V_y.

    Parameters
    ----------
    speed
        Normal impact speed V, m/s.
    yield_velocity
        V_y, m/s.
    """
    x = np.minimum(np.asarray(yield_velocity) / np.asarray(speed), 1.0)
    unloading = x / (x + 2.0 * np.sqrt(1.2 - np.square(x) / 5.0))
    bulk = np.sqrt(1.2 * np.sqrt(3.0) * (1.0 - np.square(x) / 6.0))
    return np.asarray(bulk * np.power(unloading, 0.25))


def adhesion_energy(contact: Contact) -> Real:
    """Depth of the contact's adhesive well, J."""
    delta = contact.equilibrium_compression
    return WELL_DEPTH * np.sqrt(contact.hertz_radius) * contact.stiffness * np.power(delta, 2.5)
