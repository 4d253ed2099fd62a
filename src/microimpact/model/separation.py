"""Forces that hold a charged particle on a plane: contact adhesion, spacers on it, image charges.

Not of the article: the separation of a particle that carries nanometre spherules and charge, as
Rimai, Quesnel and Reifenberger 2000 (J. Adhesion 74) describe it. Arguments are SI numbers or
arrays that broadcast; charges are magnitudes, and the plane is a conductor.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
import scipy

from microimpact.core.arrays import NON_NEGATIVE, POSITIVE, FloatArray, Range, Real, checked, choice
from microimpact.core.computable import NotComputable
from microimpact.core.constants import epsilon_0

PLACEMENTS = ("lifted", "even", "random")
WEIGHT_FRACTION = Range(lower=0.0, upper=1.0, lower_closed=True)

# A particle stands on no fewer spherules than a stool on legs.
LEGS = 3


def jkr_pull_off(work_of_adhesion: Real, radius: Real) -> Real:
    """Pull-off force of a sphere from a plane, N (Johnson, Kendall and Roberts): ``3 pi w R / 2``.

    The stiffness does not enter.
    """
    return 1.5 * np.pi * work_of_adhesion * radius


def jkr_contact_radius(work_of_adhesion: Real, radius: Real, stiffness: Real) -> Real:
    """Contact radius at zero load, m: ``a_0^3 = 6 pi w R^2 / K``, K as in Eqs. (20), (21).

    Parameters
    ----------
    work_of_adhesion
        Work of adhesion w, J/m2.
    radius
        Effective radius R, m.
    stiffness
        K, Pa.
    """
    return np.cbrt(6.0 * np.pi * work_of_adhesion * np.square(radius) / stiffness)


def image_force(charge: Real, radius: Real, gap: Real = 0.0, enhancement: Real = 1.0) -> Real:
    """Attraction of a uniformly charged sphere to its image, N.

    ``F = alpha q^2 / (16 pi eps_0 (R + gap)^2)``

    Parameters
    ----------
    charge
        q, C.
    radius
        R, m.
    gap
        Between sphere and plane, m.
    enhancement
        alpha: 1 for a charge at the centre; above 1 by the polarisation of a dielectric sphere.
    """
    return enhancement * np.square(charge) / (16.0 * np.pi * epsilon_0 * np.square(radius + gap))


def patch_area(charge: Real, breakdown_field: Real) -> Real:
    """Least area on which a charge fits, m2: patches as dense as breakdown lets them be.

    The field between a patch and the plane it faces is ``E = s/eps_0``, so that the charge per
    area s is at most ``eps_0 E_b``.
    """
    return charge / (epsilon_0 * breakdown_field)


def patch_force(charge: Real, share: Real, breakdown_field: Real, gap: Real = 0.0) -> FloatArray:
    """Attraction of charged patches to their images, N: ``s^2 A / (2 eps_0)`` without a gap.

    Parameters
    ----------
    charge
        Of the whole particle, C.
    share
        Of the patches that face the plane in the contact; taken as one disc of area A.
    breakdown_field
        E_b, V/m: the patches are as dense as it allows, ``s = eps_0 E_b``.
    gap
        Between disc and plane, m.
    """
    area = share * patch_area(charge, breakdown_field)
    pressure = 0.5 * epsilon_0 * np.square(breakdown_field)
    return np.asarray(pressure * area * disc_image_factor(2.0 * gap / np.sqrt(area / np.pi)))


def disc_image_factor(separation: Real) -> FloatArray:
    """Force between a charged disc and its image over that without a gap.

    ``1 - p (p^2 + 4)^(1/2) (K(m) - E(m))/pi``, ``m = 4/(p^2 + 4)``, p their distance over the
    radius: the integral of ``2 J_1(t)^2 exp(-p t)/t`` in complete elliptic integrals. Two point
    charges for large p.
    """
    p = np.maximum(checked("separation", separation, NON_NEGATIVE), 1e-150)  # K is infinite at 0
    size = np.square(p) + 4.0
    elliptic = scipy.special.ellipkm1(np.square(p) / size) - scipy.special.ellipe(4.0 / size)
    return np.asarray(1.0 - p * np.sqrt(size) * elliptic / np.pi)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CoatedParticle:
    """A particle on a plane, with equal, rigid spherules on its surface; fields may be arrays.

    Parameters
    ----------
    radius
        Of the sphere of equal volume, which also is that of the bare contact, m.
    density
        Of the particle without spherules, kg/m3.
    surface_factor
        Surface of the irregular particle over that of the sphere.
    stiffness
        K of a contact with the plane, Pa.
    work_of_adhesion
        Particle on plane and spherule on plane, J/m2.
    spherule_radius, spherule_density
        m and kg/m3.

    Raises
    ------
    ValueError
        If a number is not positive, or the contact of a spherule as wide as the spherule.
    """

    radius: Real
    density: Real
    surface_factor: Real
    stiffness: Real
    work_of_adhesion: Real
    spherule_radius: Real
    spherule_density: Real

    def __post_init__(self) -> None:
        """Check the numbers."""
        for field in fields(self):
            value = checked(field.name, getattr(self, field.name), POSITIVE)
            object.__setattr__(self, field.name, value)
        if np.any(spherule_indentation(self) >= self.spherule_radius / 3.0):
            raise NotComputable(
                "work_of_adhesion must be below K r / (6 pi) of the spherules, or they sink in"
            )


def spherule_count(particle: CoatedParticle, weight_fraction: Real) -> Real:
    """Return the spherules per particle, where they are so much of the weight of both together."""
    x = checked("weight_fraction", weight_fraction, WEIGHT_FRACTION)
    volumes = np.power(particle.radius / particle.spherule_radius, 3)
    return x / (1.0 - x) * volumes * (particle.density / particle.spherule_density)


def coverage(particle: CoatedParticle, weight_fraction: Real) -> Real:
    """Return cross-sections of all spherules over the particle's surface: 1 is a full layer."""
    surface = 4.0 * particle.surface_factor * np.square(particle.radius)
    shadow = np.square(particle.spherule_radius)
    return spherule_count(particle, weight_fraction) * shadow / surface


def carried_share(particle: CoatedParticle, weight_fraction: Real, placement: str) -> FloatArray:
    """Share of the bare contact area that spherules carry; the rest still touches.

    Parameters
    ----------
    weight_fraction
        Of silica, in [0, 1).
    placement
        ``even``: spherules side by side, the share is the area they cover, at most all.
        ``random``: they fall anywhere and may lie on one another; the upper limit of what touches.
        ``lifted``: three under the bare contact carry it all, by Poisson's law of their number;
        the lower limit.
    """
    covered = coverage(particle, weight_fraction)
    if choice("placement", placement, PLACEMENTS) == "random":
        return np.asarray(-np.expm1(-covered))
    covered = np.minimum(covered, 1.0)
    if placement == "even":
        return np.asarray(covered)
    bare = jkr_contact_radius(particle.work_of_adhesion, particle.radius, particle.stiffness)
    return np.asarray(
        scipy.special.pdtrc(LEGS - 1, covered * np.square(bare / particle.spherule_radius))
    )


def spherule_indentation(particle: CoatedParticle) -> Real:
    """Return the approach of a spherule and the plane at zero load, m (JKR): ``a_0^2 / (3 r)``."""
    r = particle.spherule_radius
    contact = jkr_contact_radius(particle.work_of_adhesion, r, particle.stiffness)
    return np.square(contact) / (3.0 * r)


def touching_spherules(particle: CoatedParticle) -> Real:
    """Return how many spherules of a full layer touch the plane, at least three.

    Those on the cap of the particle as high as their indentation d: area ``2 pi R d``, each
    ``pi r^2``.
    """
    cap = 2.0 * particle.radius * spherule_indentation(particle)
    return np.maximum(cap / np.square(particle.spherule_radius), LEGS)


def adhesion_force(particle: CoatedParticle, weight_fraction: Real, placement: str) -> FloatArray:
    """Pull-off force of the coated particle, N: bare contact and spherules by their shares.

    Shares are those of `carried_share`. Without silica the force is that of JKR for the bare
    particle; carried in full it is that of JKR for the spherules that touch.

    Parameters
    ----------
    particle
        Particle with its silica.
    weight_fraction
        Mass of silica over that of the particle.
    placement
        How the spherules lie on it, one of ``PLACEMENTS``.
    """
    share = carried_share(particle, weight_fraction, placement)
    bare = jkr_pull_off(particle.work_of_adhesion, particle.radius)
    each = jkr_pull_off(particle.work_of_adhesion, particle.spherule_radius)
    return np.asarray((1.0 - share) * bare + share * touching_spherules(particle) * each)
