"""The laboratory: values declared once, to which the analyses refer.

Fields bear the names of the parameters they are given to.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from microimpact.lab.dispenser import Dispenser, InitialSpin
from microimpact.lab.experiment import StopRule
from microimpact.lab.pdpa.analyser import Analyser
from microimpact.lab.ptis.system import ImagingSystem
from microimpact.model.choices import FittedLaw
from microimpact.statistics.distributions import Distribution, mean
from study.declared.parameters import (
    AngleDegrees,
    CaseName,
    Fraction,
    MaterialName,
    Name,
    NonNegative,
    Positive,
    PositiveRange,
)
from study.samples import Dropped

# A mean is printed with two digits.
MEAN_WITHIN = 0.02


@dataclass(frozen=True, slots=True, kw_only=True)
class DeclaredParticles:
    """One size class of one material, and the mean of its diameters as it is printed."""

    particle: MaterialName
    diameter_um: Distribution | None = None
    particle_slope: NonNegative | None = None
    mean_diameter_um: Positive | None = None

    def __post_init__(self) -> None:
        """Refuse a mean that the diameters have not."""
        if self.diameter_um and self.mean_diameter_um:
            drawn = mean(self.diameter_um)
            if abs(drawn / self.mean_diameter_um - 1.0) > MEAN_WITHIN:
                raise ValueError(
                    f"mean_diameter_um {self.mean_diameter_um:g} must be the mean of diameter_um, "
                    f"{drawn:.3g}: change both"
                )


@dataclass(frozen=True, slots=True, kw_only=True)
class DeclaredSurface:
    """A target: its material and its slope."""

    surface: MaterialName
    surface_slope: NonNegative


@dataclass(frozen=True, slots=True, kw_only=True)
class DeclaredSpeed:
    """Speed of an impact, the number the text has for it, and the measured speeds accepted."""

    speed_m_per_s: Positive
    printed_speed_m_per_s: Positive | None = None
    speed_range_m_per_s: PositiveRange | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Protocol(StopRule):
    """End of an experiment, and the angles of the target."""

    angles_deg: tuple[AngleDegrees, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Pile:
    """A target on which spheres pile up, and a capture velocity far below the printed one."""

    target_radius_mm: Positive
    slope_deg: NonNegative
    weak_capture_m_per_s: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A contact: its materials, targets of its calibration, and numbers left open."""

    particle: MaterialName
    surface: MaterialName
    diameter_um: Positive | None = None
    damped_as: Name | None = None
    speed_m_per_s: Positive | None = None
    restitution: Fraction | None = None
    capture_velocity_m_per_s: Positive | None = None
    rate_exponent: NonNegative | None = None
    work_of_adhesion_J_per_m2: Positive | None = None  # noqa: N815
    damping_fitted_at_J_per_m2: Positive | None = None  # noqa: N815
    law: FittedLaw | None = None
    adhesion_over_hertz: Positive | None = None
    dissipation_over_adhesion: Positive | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class DeclaredDrop(Dropped):
    """Drop as declared, with the materials of particle and surface."""

    particle: MaterialName
    surface: MaterialName


@dataclass(frozen=True, slots=True, kw_only=True)
class Sieve:
    """Particles of one size class."""

    particle: MaterialName
    diameter_um: Distribution


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceHistory:
    """The impact whose force is drawn over time."""

    case: CaseName
    mean_diameter_um: Positive
    speed_m_per_s: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class DeclaredImpact(DeclaredDrop):
    """The impact that analyses of one contact are of, and further contacts of its pair."""

    mean_diameter_um: Positive
    back: DeclaredSurface
    populations: Mapping[str, Sieve]
    normal_speeds_m_per_s: Annotated[tuple[Positive, ...], Field(min_length=1)]
    sieve: Sieve
    force_history: ForceHistory
    other_case: CaseName
    cases: Annotated[tuple[CaseName, ...], Field(min_length=1)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Laboratory:
    """All that can be named, by section."""

    particles: Mapping[str, DeclaredParticles]
    surfaces: Mapping[str, DeclaredSurface]
    speeds: Mapping[str, DeclaredSpeed]
    spins: Mapping[str, InitialSpin]
    frictions: Mapping[str, Fraction]
    dispenser: Dispenser
    pdpa: Analyser
    ptis: ImagingSystem
    experiment: Protocol
    pile: Pile
    cases: Mapping[str, Case]
    impact: DeclaredImpact
    drops: Mapping[str, DeclaredDrop]

    def disagreements(self) -> Iterator[str]:
        """Yield a line for each drop whose contact is of other materials, and each false name."""
        for name, case in self.cases.items():
            said, exponent = re.search(r"\bn = (\S+)$", name), case.rate_exponent
            if said and case.law:
                yield f"cases.{name}.law: {case.law!r} has no n: declare a case of another name"
            elif said and exponent is not None and said[1] != f"{exponent:g}":
                wanted = name.replace(said[0], f"n = {exponent:g}")
                yield f"cases.{name}.rate_exponent: {exponent:g}: declare a case {wanted!r} for it"
        impact = self.impact
        cases = {"case": impact.case, "other_case": impact.other_case}
        cases |= {f"cases[{i}]": case for i, case in enumerate(impact.cases)}
        if impact.back.surface != impact.surface:
            back = repr(impact.back.surface)
            yield f"impact.back.surface: {back} must be {impact.surface}, as in front"
        named = [(f"drops.{name}.case", drop.case, drop) for name, drop in self.drops.items()]
        named += [(f"impact.{key}", name, impact) for key, name in cases.items()]
        for key, name, drop in named:
            if (bodies := self.pair(name)) != (wanted := f"{drop.particle} on {drop.surface}"):
                yield f"{key}: {name!r} is of {bodies}, must be of {wanted}"

    def pair(self, case: str) -> str:
        """Return the materials of a case, or of a declared pair, as ``particle on surface``."""
        declared = self.cases.get(case)
        return f"{declared.particle} on {declared.surface}" if declared else case

    def other_particle(self, key: str, particle: str, case: str) -> Iterator[str]:
        """Yield a line if a particle is none of a case."""
        if particle != (wanted := self.pair(case).partition(" on ")[0]):
            yield f"{key}: {particle!r} must be {wanted}, as of the case {case!r}"
