"""Ensembles of impacts whose parameters are drawn from distributions (Section 4.2)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.declared.parameters import Count
from microimpact.lab.surface import Rules, Strike, Surface
from microimpact.statistics.distributions import (
    LARGEST_PROBABILITY,
    SMALLEST_PROBABILITY,
    AnyDistribution,
    Constant,
    Distribution,
    Normal,
    mean,
)
from microimpact.statistics.sampling import (
    Correlation,
    Generator,
    Method,
    require_varying,
)

# Draws of a replicate, by the names of the parameters.
Draws = Mapping[str, FloatArray]

POSITIVE = ("speed_m_per_s", "diameter_um", "work_of_adhesion_factor")
NON_NEGATIVE = ("friction", "restitution_factor", "hertz_damping_factor", "adhesion_damping_factor")


@dataclass(frozen=True, slots=True, kw_only=True)
class Inferred(Normal):
    """Normal about the mean surface, as wide as a printed restitution asks for.

    How wide that is the study infers, variant by variant; until then the width is 1.
    """

    kind: Literal["inferred"] = "inferred"  # type: ignore[assignment]


Slope = Annotated[AnyDistribution | Inferred, Field(discriminator="kind")]


@dataclass(frozen=True, slots=True, kw_only=True)
class Process:
    """Process parameters and initial conditions, each any distribution.

    Attributes
    ----------
    speed_m_per_s
        Speed before impact.
    angle_offset_deg
        Deviation from the nominal angle of incidence.
    diameter_um
        Of the sphere.
    slope, cross_slope
        Of the surface, along the motion and across it: tangents of the article's angle phi.
    spin_ratio
        r omega / v about the axis of tilt, positive in the sense of rolling.
    friction
        Coulomb coefficient.
    restitution_factor, restitution_offset
        The rigid body model takes ``factor e + offset``, within [0, 1], for e; not with the
        dynamic simulation.
    work_of_adhesion_factor
        Multiple of the work of adhesion of the contact.
    hertz_damping_factor, adhesion_damping_factor
        Multiples of the coefficients of damping; with the dynamic simulation only.
    """

    speed_m_per_s: Distribution
    angle_offset_deg: Distribution
    diameter_um: Distribution
    slope: Slope
    cross_slope: Distribution
    spin_ratio: Distribution
    friction: Distribution
    restitution_factor: Distribution
    restitution_offset: Distribution
    work_of_adhesion_factor: Distribution
    hertz_damping_factor: Distribution
    adhesion_damping_factor: Distribution

    def __post_init__(self) -> None:
        """Refuse distributions that reach values without meaning."""
        ends = np.array([SMALLEST_PROBABILITY, LARGEST_PROBABILITY])
        for name in POSITIVE + NON_NEGATIVE:
            distribution = getattr(self, name)
            if getattr(distribution, "low", 0.0) > 0.0:  # nothing is drawn below; no need of SciPy
                continue
            low = float(np.min(distribution.quantile(ends)))
            if low < 0.0 or (name in POSITIVE and low == 0.0):
                allowed = "positive" if name in POSITIVE else "zero or more"
                raise ValueError(
                    f"{name}: {distribution.kind} reaches down to {low:.4g}, must be {allowed}: "
                    "take a truncated or lognormal distribution"
                )

    @property
    def distributions(self) -> dict[str, Any]:
        """The distributions by name."""
        return {item.name: getattr(self, item.name) for item in fields(self)}

    def at_means(self, *, but: Sequence[str] = ()) -> Process:
        """Return the process with all parameters but some held at their means."""
        held = {k: Constant(at=mean(d)) for k, d in self.distributions.items() if k not in but}
        return replace(self, **held)


# What an impact does to the spheres of which these are the draws.
Impact = Callable[[Draws], Strike]


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """How many events are drawn, and how; ``events`` of each replicate are a power of two."""

    replicates: Annotated[int, Field(ge=2)]
    events: Count
    method: Method = "plain"
    generator: Generator = "exact"

    def __post_init__(self) -> None:
        """Refuse a number that a Sobol sequence or antithetic pairs cannot have."""
        if self.events < 2 or self.events & (self.events - 1):
            raise ValueError(f"events must be a power of two (2, 4, 8, ...), got {self.events}")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Ensemble:
    """What is drawn, by which rules, and what an impact does."""

    process: Process
    rules: Rules
    impact: Impact
    plan: Plan
    seed: tuple[int, ...]
    correlation: Correlation = field(default_factory=Correlation)

    def __post_init__(self) -> None:
        """Refuse a correlation with unknown or constant parameters."""
        require_varying(self.correlation, self.process.distributions)

    @property
    def surface(self) -> Surface:
        """The surface that is struck."""
        process = self.process
        return Surface(slope=process.slope, cross_slope=process.cross_slope, rules=self.rules)


def deterministic(ensemble: Ensemble) -> Ensemble:
    """Return the ensemble with every parameter at its mean: all events are one."""
    process = ensemble.process.at_means()
    return replace(
        ensemble,
        process=process,
        correlation=Correlation(),
        plan=Plan(replicates=2, events=2),
    )
