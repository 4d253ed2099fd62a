"""The impacts that every method computes, and how the results are judged."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from microimpact import Contact, Material
from microimpact.model.closed_forms import contact_modulus
from microimpact.model.reference import CASES

# Damping groups (C_H, C_A): none, light, and strong enough that slow impacts are captured.
GROUPS = ((0.0, 0.0), (0.02, 0.2), (0.1, 0.3))
SLOWEST, FASTEST = 0.3, 30.0


@dataclass(frozen=True, slots=True)
class Cases:
    """Normal impacts in an adhesive scale: speed in V, and damping groups (flat arrays).

    Of JKR contacts the first group is the viscous one, and the other is zero.
    """

    speed: np.ndarray
    hertz: np.ndarray
    adhesion: np.ndarray

    def __len__(self) -> int:
        return self.speed.size

    def every(self, stride: int) -> Cases:
        """Every ``stride``-th case: the same mix of speeds and damping, for slow methods."""
        part = slice(stride // 2, None, stride)
        return Cases(self.speed[part], self.hertz[part], self.adhesion[part])


class Method(Protocol):
    """A way of computing one number for each case, at several settings.

    What can be prepared once for any impacts (compiled code, integrators) is made in ``__init__``
    and not timed; everything that depends on the impacts' numbers is.
    """

    name: str
    source: str  # the distribution it comes from
    settings: tuple[float, ...]  # tolerances, or steps per contact where they exceed 1
    share: int  # computes one in so many of the cases

    def __init__(self, cases: Cases, setting: float) -> None: ...

    def __call__(self) -> np.ndarray: ...


def make_cases(per_group: int) -> Cases:
    """Speeds from 0.3 to 30 V, evenly in the logarithm, for each damping group."""
    speeds = np.geomspace(SLOWEST, FASTEST, per_group)
    hertz, adhesion = np.repeat(np.array(GROUPS), per_group, axis=0).T
    return Cases(np.tile(speeds, len(GROUPS)), hertz.copy(), adhesion.copy())


def make_hertz_cases(number: int) -> Cases:
    """Undamped impacts over the same range of speeds."""
    nothing = np.zeros(number)
    return Cases(np.geomspace(SLOWEST, FASTEST, number), nothing, nothing)


def make_jkr_cases(number: int, name: str) -> Cases:
    """Impacts of a JKR contact of the reference that do not stick, by its name."""
    contact = CASES[name].contact
    unit, group = jkr_scales(contact)
    return Cases(np.geomspace(0.1, 10.0, number) / unit, np.full(number, group), np.zeros(number))


def jkr_scales(contact: Contact) -> tuple[float, float]:
    """Unit of speed, m/s, and viscous group of a JKR contact.

    In units of its radius at the break, x^2, and of the time in which ``dx/dt = u``:
    ``du/dt = -(x^3 - 1)(x^6 - 6 x^3 + group x^2 u)``.
    """
    modulus, radius = float(contact_modulus(contact)), float(contact.hertz_radius)
    force = np.pi * contact.work_of_adhesion * radius / 6.0
    a = (6.0 * force * radius / (8.0 * modulus)) ** (1.0 / 3.0)
    unit = 2.0 * float(np.sqrt(a**2 / radius * force / contact.mass))
    return unit, 2.0 * modulus * a * contact.law.viscous_time * unit / force


def as_jkr_contact(cases: Cases) -> tuple[Contact, np.ndarray]:
    """The pair of the reference with these impacts, and the speeds in m/s."""
    contact = CASES["viscous-jkr-pair" if np.any(cases.hertz) else "jkr-pair"].contact
    return contact, cases.speed * jkr_scales(contact)[0]


def as_hertz_pair(cases: Cases) -> tuple[Contact, np.ndarray]:
    """Two spheres of steel without adhesion, and the speeds in m/s."""
    contact, speed = as_contact(cases)
    like = {"surface": contact.particle, "partner_diameter": contact.diameter}
    return contact.replace(work_of_adhesion=0.0, **like), speed


def as_contact(cases: Cases) -> tuple[Contact, np.ndarray]:
    """A contact in SI units with these damping groups, and the speeds in m/s."""
    steel = Material(name="steel", youngs_modulus=193e9, poissons_ratio=0.3, density=8000.0)
    silicon = Material(name="silicon", youngs_modulus=160e9, poissons_ratio=0.27, density=2330.0)
    bare = Contact(particle=steel, surface=silicon, diameter=50e-6, work_of_adhesion=0.5)
    unit = bare.velocity_scale
    contact = bare.replace(hertz_damping=cases.hertz / unit, adhesion_damping=cases.adhesion / unit)
    return contact, cases.speed * unit


@dataclass(frozen=True, slots=True)
class Errors:
    """Differences from the reference over all cases, and the number of wrong verdicts.

    The numbers compared are of order one (e; contact time over Hertz's). A wrong verdict on capture
    counts with its full error: e is 0 where captured.
    """

    median: float
    largest: float
    wrong: int


def judge(values: np.ndarray, reference: np.ndarray) -> Errors:
    """Compare with the reference, in the reference's precision."""
    errors = np.abs(values - reference)
    wrong = int(np.count_nonzero((values > 0.0) != (reference > 0.0)))
    return Errors(float(np.median(errors[reference > 0.0])), float(np.max(errors)), wrong)
