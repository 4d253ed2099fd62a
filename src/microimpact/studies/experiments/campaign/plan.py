"""The experiments of a campaign: blocks of particles, surfaces, speeds and angles, written out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import product
from typing import TypeVar

import pandas as pd

from microimpact.core.nearest import nearest
from microimpact.declared.parameters import (
    AngleDegrees,
    CaseName,
    MaterialName,
    Name,
    NonNegative,
    Positive,
)
from microimpact.lab.dispenser import Dispenser, InitialSpin
from microimpact.lab.experiment import Drop, SpeedClass, Target
from microimpact.lab.surface import combined_slope, rough
from microimpact.model.contact import Contact
from microimpact.statistics.distributions import Distribution

# What the article counts (Section 2), and the printed values that say how many.
COUNTED = {
    "experiments": "campaign_experiments",
    "diameter ranges": "campaign_diameter_ranges",
    "surfaces": "campaign_surfaces",
    "angles": "campaign_angles",
    "speed ranges": "campaign_speed_ranges",
}
T = TypeVar("T")

ABOUT = "speed ranges"


@dataclass(frozen=True, slots=True, kw_only=True)
class Particles:
    """One range of sizes of one material; slope and spin as in the laboratory."""

    name: Name
    particle: MaterialName
    diameter_um: Distribution
    particle_slope: NonNegative
    spin_sd: NonNegative


@dataclass(frozen=True, slots=True, kw_only=True)
class Surface:
    """A target: its material and how rough it is."""

    name: Name
    surface: MaterialName
    surface_slope: NonNegative


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """All combinations of some particles, surfaces, speeds and angles, with one contact.

    The contact has the work of adhesion and the damping of a calibrated `case`, whatever its
    materials are.
    """

    particles: tuple[Name, ...]
    surfaces: tuple[Name, ...]
    case: CaseName
    speeds_m_per_s: tuple[Positive, ...]
    angles_deg: tuple[AngleDegrees, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Experiment:
    """One experiment of a campaign."""

    particles: Particles
    surface: Surface
    case: str
    speed_class: SpeedClass
    angle: float

    @property
    def title(self) -> str:
        """What it is, in words; no two experiments share it."""
        speed = self.speed_class.speed_m_per_s
        return f"{self.particles.name} on {self.surface.name}, {speed:g} m/s, {self.angle:g} deg"

    @property
    def pair(self) -> tuple[str, str, str]:
        """What decides its contact."""
        return self.particles.name, self.surface.name, self.case

    def drop(self, contact: Contact, dispenser: Dispenser) -> Drop:
        """Return what is dropped, on a contact of its materials."""
        slope_sd = combined_slope(self.surface.surface_slope, self.particles.particle_slope)
        return Drop(
            target=Target(contact=contact, surface=rough(slope_sd)),
            diameter_um=self.particles.diameter_um,
            angle=self.angle,
            speed=self.speed_class.speed_m_per_s,
            speed_range=self.speed_class.speed_range_m_per_s,
            dispenser=dispenser,
            spin=InitialSpin(sd=self.particles.spin_sd, mean=0.0),
        )


def expand(
    blocks: Iterable[Block],
    particles: Iterable[Particles],
    surfaces: Iterable[Surface],
    speed_classes: Iterable[SpeedClass],
) -> list[Experiment]:
    """Return the experiments that blocks declare.

    Raises
    ------
    ValueError
        If a block names what is not declared, or an experiment is declared twice.
    """
    by_name = {one.name: one for one in particles}
    targets = {one.name: one for one in surfaces}
    classes = {f"{one.speed_m_per_s:g}": one for one in speed_classes}
    found: dict[str, Experiment] = {}
    for number, block in enumerate(blocks):
        where = f"blocks[{number}]"
        chosen = (
            [_named(name, by_name, f"{where}.particles") for name in block.particles],
            [_named(name, targets, f"{where}.surfaces") for name in block.surfaces],
            [_named(f"{v:g}", classes, f"{where}.speeds_m_per_s") for v in block.speeds_m_per_s],
        )
        for dropped, target, speed_class, angle in product(*chosen, block.angles_deg):
            one = Experiment(
                particles=dropped,
                surface=target,
                case=block.case,
                speed_class=speed_class,
                angle=angle,
            )
            if one.title in found:
                raise ValueError(f"{where}: {one.title}: declared twice")
            found[one.title] = one
    return list(found.values())


def _named(name: str, known: Mapping[str, T], where: str) -> T:
    if name not in known:
        raise ValueError(f"{where}: {name!r} must be one of those declared{nearest(name, known)}")
    return known[name]


def counts(experiments: Iterable[Experiment]) -> dict[str, int]:
    """Return how many experiments and different levels there are, as the article counts them."""
    all_of = list(experiments)
    return {
        "experiments": len(all_of),
        "diameter ranges": len({one.particles.diameter_um for one in all_of}),
        "surfaces": len({one.surface for one in all_of}),
        "angles": len({one.angle for one in all_of}),
        "speed ranges": len({one.speed_class for one in all_of}),
    }


def check_counts(experiments: Iterable[Experiment], printed: pd.Series, about: int) -> None:
    """Check the declared experiments against the printed counts.

    Parameters
    ----------
    experiments
        As declared.
    printed
        Printed values by key.
    about
        How far the number of speed ranges, which is printed as approximate, may be off.

    Raises
    ------
    ValueError
        Naming every count that does not agree.
    """
    wrong = []
    for name, number in counts(experiments).items():
        wanted = int(printed[COUNTED[name]])
        if abs(number - wanted) > (about if name == ABOUT else 0):
            wrong.append(f"{number} {name}, not {wanted}")
    if wrong:
        raise ValueError(f"blocks: give {'; '.join(wrong)} (Section 2)")
