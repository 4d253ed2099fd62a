"""Restitution of another code against the reference, and which mistake the difference looks like.

Each known mistake is computed, not fitted: its curve of e follows from the case. In terms of the
s of `microimpact.model.dynamics.force_laws`, JKR's contact closes at ``s^3 = 4 b`` and breaks at
``s^3 = b``; at ``3 b`` the pull is the greatest, at ``6 b`` there is none.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from microimpact.core.arrays import (
    POSITIVE,
    FloatArray,
    Numbers,
    Range,
    Real,
    checked,
    common_shape,
)
from microimpact.core.nearest import nearest
from microimpact.model.contact import Contact
from microimpact.model.contact_laws import JKR
from microimpact.model.dynamics import force_laws
from microimpact.model.dynamics.impact import SPEED
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.reference import CASES

TOLERANCE = 0.005
# What is above 1 is a mistake to be named, what is above 2 no restitution.
RESTITUTION = Range(lower=0.0, upper=2.0, lower_closed=True)

# Where a JKR contact may close and break, in s^3/b, and works of adhesion, each with its mistake.
STARTS = {4.0: "", 6.0: "the contact begins at zero force, not at zero overlap"}
ENDS = {
    1.0: "",
    3.0: "the contact is broken at the pull-off force, not at the greatest stretch",
    4.0: "the contact ends at zero overlap, or adhesion pulls before touch: no loss",
}
WORKS = {
    1.0: "",
    2.0: "the work of adhesion w is taken for the surface energy gamma = w/2",
    0.5: "the surface energy gamma = w/2 is taken for the work of adhesion w",
}
RIGID_WALL = "the wall is taken as rigid"
NOT_REDUCED = "mass and radius of one sphere are taken, not the reduced ones of two"
REDUCED = "the wall is taken as an equal sphere: mass and radius are halved"
HALF_MASS = "half the mass is taken"
DIAMETER = "the diameter is taken for the radius"
DIAMETER_IN_FORCE = "the diameter is taken for the radius in the force, not in the mass"
HALF_MODULUS = "half of Young's modulus is taken"
POISSON = "1 - nu is taken for 1 - nu^2"
SQUARED = "e^2 is given for e"
TIME_STEP = "the difference is irregular in the speed: the time step is too long"
UNKNOWN = "no known mistake"


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """Agreement of one case.

    Attributes
    ----------
    case, impacts
        Its name, and the number of impacts compared.
    difference, speed
        Largest difference of e from the reference, and the normal speed where it is, m/s.
    agrees
        Whether that is within the tolerance.
    causes
        Mistakes with this e(v), the simplest first, each with its largest difference of e.
    """

    case: str
    impacts: int
    difference: float
    speed: float
    agrees: bool
    causes: tuple[tuple[str, float], ...] = ()


def verify(
    case: str, speed: Numbers, restitution: Numbers, tolerance: float = TOLERANCE
) -> Verdict:
    """Compare restitutions of another code with the reference.

    Parameters
    ----------
    case
        A name in `microimpact.model.reference.CASES`.
    speed, restitution
        Normal speeds before impact, m/s, and e, 0 where the sphere stays; numbers or (n,).
    tolerance
        Largest difference of e that counts as agreement.

    Raises
    ------
    TypeError, ValueError
        If the case is unknown, or a number is no speed or no restitution.
    """
    if case not in CASES:
        raise ValueError(f"case {case!r} unknown{nearest(case, CASES)}")
    speeds = checked(f"case {case!r}: speed", speed, SPEED)
    ratios = checked(f"case {case!r}: e", restitution, RESTITUTION)
    common_shape({"speed": speeds, "restitution": ratios})
    speed, restitution = map(np.ravel, np.broadcast_arrays(speeds, ratios))
    if not speed.size:
        raise ValueError(f"case {case!r}: an impact at least, got none")
    tolerance = float(checked("tolerance", tolerance, POSITIVE))
    contact = CASES[case].contact
    expected = normal_impact(contact, speed).coefficient_of_restitution
    off = restitution - expected
    largest = int(np.argmax(np.abs(off)))
    verdict = Verdict(
        case=case,
        impacts=speed.size,
        difference=float(off[largest]),
        speed=float(speed[largest]),
        agrees=bool(np.abs(off[largest]) <= tolerance),
    )
    if verdict.agrees:
        return verdict
    causes = []
    for words, curve in mistakes(contact, speed):
        misfit = float(np.max(np.abs(restitution - curve)))
        # A mistake that moves nothing here explains nothing.
        if misfit <= tolerance and np.max(np.abs(curve - expected)) > tolerance:
            causes.append((words, misfit))
    if not causes:
        turns = np.count_nonzero(np.diff(np.sign(off[np.argsort(speed)])))
        irregular = turns >= 2 or np.any(restitution > 1.0 + tolerance)
        causes.append((TIME_STEP if irregular else UNKNOWN, math.nan))
    return replace(verdict, causes=tuple(sorted(causes, key=lambda c: (c[0].count(";"), c[1]))))


def mistakes(contact: Contact, speed: FloatArray) -> Iterator[tuple[str, FloatArray]]:
    """Restitutions (n,) at normal speeds (n,), m/s, by all known mistakes, each with its words."""
    for words, changed in _other_contacts(contact):
        yield words, normal_impact(changed, speed).coefficient_of_restitution
    yield SQUARED, np.square(normal_impact(contact, speed).coefficient_of_restitution)
    if isinstance(contact.law, JKR):
        for (start, begun), (end, broken), (factor, taken) in product(
            STARTS.items(), ENDS.items(), WORKS.items()
        ):
            words = "; ".join(filter(None, (begun, broken, taken)))
            if words and (begun or broken):
                work = contact.replace(work_of_adhesion=factor * (contact.work_of_adhesion or 0.0))
                yield words, force_laws.jkr_restitution(work, speed, start, end)


def _other_contacts(contact: Contact) -> Iterator[tuple[str, Contact]]:
    """Contacts that are another one by mistake, with its words."""
    work = contact.work_of_adhesion or 0.0
    for factor, taken in WORKS.items():
        if taken and np.any(work):
            yield taken, contact.replace(work_of_adhesion=factor * work)
    if contact.is_pair:
        yield NOT_REDUCED, contact.replace(partner_diameter=math.inf)
    else:
        rigid = replace(contact.surface, name="rigid", youngs_modulus=1e30)
        yield RIGID_WALL, contact.replace(surface=rigid)
        yield REDUCED, contact.replace(partner_diameter=contact.diameter)
    yield HALF_MASS, _with_bodies(contact, density=0.5)
    yield DIAMETER, _enlarged(contact)
    yield DIAMETER_IN_FORCE, _with_bodies(_enlarged(contact), density=0.125)
    yield HALF_MODULUS, _with_bodies(contact, youngs_modulus=0.5)
    poisson = contact.particle.poissons_ratio  # all bodies are of one material
    yield POISSON, _with_bodies(contact, youngs_modulus=1.0 + poisson)
    if contact.law is None and np.any(work):
        # m v dv = -F (1 + c v) dn: adhesion drops out between two touches.
        bare = contact.replace(work_of_adhesion=0.0, adhesion_damping=0.0)
        yield "Hertz damping multiplies the total force, not the Hertz force alone", bare
        yield "adhesion is damped during approach too", contact.replace(damped_attachment=True)
        yield "adhesion is not damped", contact.replace(adhesion_damping=0.0)


def _with_bodies(contact: Contact, **factors: Real) -> Contact:
    """Contact whose bodies have properties multiplied by factors."""
    bodies = {
        role: replace(body, **{name: getattr(body, name) * f for name, f in factors.items()})
        for role, body in (("particle", contact.particle), ("surface", contact.surface))
    }
    return contact.replace(**bodies)


def _enlarged(contact: Contact) -> Contact:
    """Contact of spheres twice as large."""
    sizes = {"diameter": 2.0 * contact.diameter}
    if contact.is_pair:
        sizes["partner_diameter"] = 2.0 * contact.partner_diameter
    return contact.replace(**sizes)
