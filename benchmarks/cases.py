"""The impacts that every method computes, and how the results are judged."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microimpact import Contact, Material

# Damping groups (C_H, C_A): none, light, and strong enough that slow impacts are captured.
GROUPS = ((0.0, 0.0), (0.02, 0.2), (0.1, 0.3))
SLOWEST, FASTEST = 0.3, 30.0


@dataclass(frozen=True, slots=True)
class Cases:
    """Normal impacts in the adhesive scale: speed in V, and the damping groups (flat arrays)."""

    speed: np.ndarray
    hertz: np.ndarray
    adhesion: np.ndarray

    def __len__(self) -> int:
        return self.speed.size

    def every(self, stride: int) -> Cases:
        """Every ``stride``-th case: the same mix of speeds and damping, for slow methods."""
        part = slice(stride // 2, None, stride)
        return Cases(self.speed[part], self.hertz[part], self.adhesion[part])


def make_cases(per_group: int) -> Cases:
    """Speeds from 0.3 to 30 V, evenly in the logarithm, for each damping group."""
    speeds = np.geomspace(SLOWEST, FASTEST, per_group)
    hertz, adhesion = np.repeat(np.array(GROUPS), per_group, axis=0).T
    return Cases(np.tile(speeds, len(GROUPS)), hertz.copy(), adhesion.copy())


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
    """Relative errors of e over the rebounds, and the number of wrong verdicts on capture."""

    median: float
    largest: float
    wrong: int


def judge(restitution: np.ndarray, reference: np.ndarray) -> Errors:
    """Compare e (0 where captured) with the reference, in the reference's precision."""
    rebounds = reference > 0.0
    wrong = int(np.count_nonzero((restitution > 0.0) != rebounds))
    both = rebounds & (restitution > 0.0)
    errors = np.abs(restitution[both] / reference[both] - 1.0)
    return Errors(float(np.median(errors)), float(np.max(errors)), wrong)
