"""Closed forms from the literature, to stand beside the model: capture velocities and Hertz impact.

Used by the studies and by the tests alike. Arguments are SI numbers or arrays that broadcast.
"""

from __future__ import annotations

import numpy as np

from microimpact.arrays import Real
from microimpact.model.contact import Contact
from microimpact.model.normal import WELL_DEPTH


def jkr_sticking_velocity(contact: Contact) -> Real:
    """Quasi-static JKR sticking velocity, m/s (Thornton and Ning 1998; Johnson and Pollock 1994).

    ``V_s = (14.18/m)^(1/2) (w^5 r^4 / E*^2)^(1/6)``: the only loss is that of the snap-off.
    """
    modulus = 0.75 * contact.hertz_stiffness
    work = contact.work_of_adhesion
    assert work is not None
    group = np.power(work, 5) * np.power(contact.hertz_radius, 4) / np.square(modulus)
    velocity: Real = np.sqrt(14.18 / contact.mass) * np.power(group, 1.0 / 6.0)
    return velocity


def brach_dunn_velocity(contact: Contact) -> Real:
    """Capture velocity of Brach and Dunn 1992, m/s, common in codes for deposition (El-Batsh).

    ``v_c = (2 Ebar/d)^(10/7)``, ``Ebar = 0.51 (5 pi^2 (k_1 + k_2) / (4 rho^(3/2)))^(2/5)``; the
    constant 0.51 is dimensional (SI), so adhesion does not enter.
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
        kg.
    restitution
        Coefficient of restitution far above capture.
    """
    lost = (1.0 - np.square(restitution)) / np.square(restitution)
    return np.sqrt(2.0 * adhesion_energy / mass * lost)


def adhesion_energy(contact: Contact) -> Real:
    """Depth of the contact's adhesive well, J."""
    delta = contact.equilibrium_compression
    return WELL_DEPTH * np.sqrt(contact.hertz_radius) * contact.stiffness * np.power(delta, 2.5)


def hertz_contact_time(contact: Contact, speed: Real) -> Real:
    """Contact time of an elastic impact without adhesion, s: ``2.9433 delta_m / v``."""
    return 2.9432751843247043 * hertz_compression(contact, speed) / np.asarray(speed)


def hertz_compression(contact: Contact, speed: Real) -> Real:
    """Greatest compression of an elastic impact without adhesion, m."""
    hertz = np.sqrt(contact.hertz_radius) * contact.stiffness
    return np.power(1.25 * contact.mass * np.square(speed) / hertz, 0.4)
