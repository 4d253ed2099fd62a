"""A pair whose contact is open: laws with their free parameters, statements, scenarios."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace
from itertools import chain
from typing import Annotated, Any, Literal

import numpy as np
import scipy
from pydantic import Field

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.model.choices import FrictionBasis
from microimpact.model.contact import Contact
from study.analyses.inference.statements import (
    FRICTIONAL,
    OWN,
    SHARED,
    TURNING,
    Statement,
    Values,
    log_mean,
)
from study.contacts import Kind, declared_contact
from study.declared.parameters import (
    Ascending,
    CaseName,
    Count,
    CounterpartName,
    Finite,
    MaterialName,
    Name,
    NonNegative,
    Positive,
    PositiveRange,
)
from study.tables import Tables

Parameter = Literal[
    "work_of_adhesion_J_per_m2",
    "hertz_damping_s_per_m",
    "adhesion_damping_s_per_m",
    "rate_exponent",
    "viscous_time_ns",
    "yield_pressure_GPa",
    "unloading_over_loading_work",
    "edge_speed_m_per_s",
    "edge_exponent",
    "friction",
]
WORK: Parameter = "work_of_adhesion_J_per_m2"
# Uniform before the statements; of the others the logarithm is, for not even their order is known.
# What is lost in the material adds to the loss, so that no share of it is preferred.
LINEAR = ("hertz_damping_s_per_m", "rate_exponent", "edge_exponent", "friction")
# Turns of a shared normal, in standard deviations, over which likelihoods are averaged.
TURNS = np.linspace(-4.0, 4.0, 17)
Span = Annotated[tuple[NonNegative, Positive], Ascending]
Basis = FrictionBasis | Literal["pull-off"]


@dataclass(frozen=True, slots=True, kw_only=True)
class LawPrior:
    """A law of contact, ranges of its free parameters, and normal forces that friction may take."""

    law: Kind
    ranges: dict[Parameter, Span]
    fixed: dict[Parameter, NonNegative] = field(default_factory=dict)
    friction_bases: Annotated[tuple[Basis, ...], Field(min_length=1)]

    def parameters(self, points: FloatArray) -> dict[str, FloatArray]:
        """Free parameters by name (n,) from points of the unit cube (n, axes)."""
        named = {str(name): np.full(len(points), value) for name, value in self.fixed.items()}
        for (name, (low, high)), share in zip(self.ranges.items(), points.T, strict=True):
            linear = name in LINEAR
            named[str(name)] = low + (high - low) * share if linear else low * (high / low) ** share
        return named

    def share(self, name: Parameter, value: float) -> float:
        """Share of a parameter's range that lies below a value."""
        low, high = self.ranges[name]
        value = min(max(value, low), high)
        if name in LINEAR:
            return (value - low) / (high - low)
        return float(np.log(value / low) / np.log(high / low))

    def log_prior(self, scenario: Scenario, values: Values) -> FloatArray:
        """Logarithm of the prior density in a scenario, relative to the whole ranges (n,).

        -inf beyond the ranges of the scenario; a parameter that the law lacks does not count.
        """
        log = np.zeros(len(values["capture"]))
        for name, (lowest, highest) in self.ranges.items():
            low, high = scenario.within.get(name, (lowest, highest))
            value = values[name]
            if name in scenario.uniform and name not in LINEAR:
                log += np.log(value * np.log(highest / lowest) / (high - low))
            else:
                log -= np.log(self.share(name, high) - self.share(name, low))
            log[(value < low) | (value > high)] = -np.inf
        return log


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """Statements that do not count, and departures from the laws.

    Given as a choice, what it does not name is as in the first scenario.
    """

    without: tuple[Name, ...] | None = None
    within: dict[Parameter, Span] = field(default_factory=dict)  # Narrower ranges
    uniform: tuple[Parameter, ...] = ()  # Before the statements, in place of their logarithm
    friction_bases: tuple[Basis, ...] = ()  # In place of those of the laws
    intervals: dict[Name, Annotated[tuple[Finite, Finite], Ascending]] = field(default_factory=dict)
    tails: Positive = 1.0  # Factor of all tails
    angle_error_deg: Positive | None = None  # In place of that of the pair


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A pair, laws of its contact, and the statements printed about it."""

    particle: MaterialName
    surface: CounterpartName
    # Where quantities are computed; the speed is the reference velocity of the rate exponent.
    diameter_um: Positive
    speed_m_per_s: Positive
    classes_um: Annotated[tuple[Positive, ...], Field(min_length=2)]
    # Standard deviations: of the angle between the normals of target and camera, by experiment; of
    # the surface's random slope (its tangent), which the mean over the spheres reduces.
    angle_error_deg: NonNegative
    surface_slope: NonNegative
    spheres: Count
    laws: Annotated[dict[Name, LawPrior], Field(min_length=1)]
    statements: Annotated[dict[Name, Statement], Field(min_length=2)]
    shown_m_per_s: PositiveRange  # Normal speeds of the figures
    compared: tuple[CaseName, ...]  # Cases of the two-stage calibration to be compared with
    scenarios: Annotated[dict[Name, Scenario], Field(min_length=1)]
    choices: dict[Name, Scenario] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse names of statements that there are none of, and a size without capture velocity.

        Raises ValueError.
        """
        if self.diameter_um not in self.classes_um:
            raise ValueError(
                f"diameter_um: {self.diameter_um} must be one of classes_um {self.classes_um}"
            )
        for name, scenario in {**self.scenarios, **self.choices}.items():
            named = {*(scenario.without or ()), *scenario.intervals}
            if unknown := sorted(named - set(self.statements)):
                raise ValueError(
                    f"{name}: {unknown[0]!r} must be one of the statements {list(self.statements)}"
                )

    def rows(self) -> Iterator[tuple[str, str, Scenario]]:
        """Kind, name and scenario of all that is computed: with one statement less, and choices."""
        yield from (("scenario", name, each) for name, each in self.scenarios.items())
        first = next(iter(self.scenarios.values()))
        for name in counted(self, first):
            yield "without", name, replace(first, without=(*(first.without or ()), name))
        for name, choice in self.choices.items():
            changes = {f.name: getattr(choice, f.name) for f in fields(choice)}
            yield "choice", name, replace(first, **{k: v for k, v in changes.items() if v})

    def friction_bases(self, law: LawPrior) -> tuple[Basis, ...]:
        """Return the normal forces in Coulomb's law that some scenario has with a law."""
        named = (each.friction_bases for _, _, each in self.rows())
        return tuple(dict.fromkeys(chain(law.friction_bases, *named)))

    def normal_error(self, scenario: Scenario) -> float:
        """Return the standard deviation of the mean normal of an experiment, rad."""
        angle = scenario.angle_error_deg or self.angle_error_deg
        return float(np.hypot(np.radians(angle), self.surface_slope / np.sqrt(self.spheres)))

    def bare(self, inputs: Tables) -> Contact:
        """Return the declared contact of the pair at the diameter, with its declared w_A."""
        contact = declared_contact(inputs, self.particle, self.surface)
        return contact.replace(
            diameter=self.diameter_um * 1e-6,
            work_of_adhesion=contact.work_of_adhesion,
            reference_velocity=self.speed_m_per_s,
        )


def counted(case: Case, scenario: Scenario) -> list[str]:
    """Names of the statements that count in a scenario."""
    return [name for name in case.statements if name not in (scenario.without or ())]


@dataclass(frozen=True, slots=True)
class Likelihood:
    """Log likelihood of contacts (n,), and of each basis of friction (n, bases)."""

    total: FloatArray
    by_basis: FloatArray


@dataclass(frozen=True, slots=True)
class Judged:
    """Values of a law's contacts for the statements of a case; each likelihood is made once."""

    case: Case
    law: LawPrior
    values: Values
    _logs: dict[tuple[Any, ...], FloatArray] = field(default_factory=dict)

    def arguments(self, scenario: Scenario, name: str) -> tuple[Any, ...]:
        """Value, interval, tails and error with which a statement counts."""
        interval = scenario.intervals.get(name, self.case.statements[name].interval)
        error = self.case.normal_error(scenario) * self.values.get(TURNING + name, 0.0)
        return self.values[name], interval, scenario.tails, error

    def log(self, scenario: Scenario, name: str) -> FloatArray:
        """Log likelihood of a statement."""
        key = (name, scenario.intervals.get(name), scenario.tails, scenario.angle_error_deg)
        if key not in self._logs:
            statement = self.case.statements[name]
            self._logs[key] = statement.log_likelihood(*self.arguments(scenario, name))
        return self._logs[key]

    def bases(self, scenario: Scenario) -> BoolArray:
        """Which normal forces in Coulomb's law (bases,) a scenario has."""
        named = scenario.friction_bases or self.law.friction_bases
        return np.isin(self.case.friction_bases(self.law), named)

    def log_together(self, scenario: Scenario, name: str) -> FloatArray:
        """Log likelihood of a statement and of the one that has the same normal (n, bases).

        The mean over the error of the normal; one that is open is averaged over its angles first.
        """
        first = self.case.statements[name].same_normal_as or ""
        both = first, name
        key = (both, *map(scenario.intervals.get, both), scenario.tails, scenario.angle_error_deg)
        if key not in self._logs:
            error = self.case.normal_error(scenario)
            parts = []
            for turn in TURNS * error:
                logs = []
                for each in both:
                    value, interval, tails, _ = self.arguments(scenario, each)
                    value = value + turn * self.values[SHARED + each]
                    spread = error * self.values[OWN + each]
                    statement = self.case.statements[each]
                    logs.append(statement.log_likelihood(value, interval, tails, spread))
                parts.append(log_mean(logs[0])[:, None] + logs[1])
            weights = np.exp(-0.5 * TURNS**2)[:, None, None]
            mean = scipy.special.logsumexp(np.array(parts), axis=0, b=weights / weights.sum())
            self._logs[key] = np.asarray(mean)
        return self._logs[key]

    def misses(self, scenario: Scenario, name: str) -> BoolArray:
        """Whether contacts (n,) miss a statement; of open angles, sizes and bases, one must do."""
        statement = self.case.statements[name]
        missed = statement.misses(*self.arguments(scenario, name))
        if statement.quantity in FRICTIONAL:
            missed = missed[:, self.bases(scenario)]
        return missed if missed.ndim == 1 else np.all(missed, axis=1)

    def likelihood(self, scenario: Scenario) -> Likelihood:
        """Return the likelihood of a scenario; open angles, sizes and bases are alike before it."""
        total: FloatArray = np.zeros(len(self.values["capture"]))
        by_basis = np.where(self.bases(scenario), total[:, None], -np.inf)
        names = counted(self.case, scenario)
        shared = {n: self.case.statements[n].same_normal_as for n in names}
        together = {n: other for n, other in shared.items() if other in names}
        for name in together:
            by_basis = by_basis + self.log_together(scenario, name)
        for name in (n for n in names if n not in {*together, *together.values()}):
            log = self.log(scenario, name)
            if self.case.statements[name].quantity in FRICTIONAL:
                by_basis = by_basis + log
            else:
                total = total + log_mean(log)
        # As many as there are, not as are computed.
        mean = scipy.special.logsumexp(by_basis, axis=1) - np.log(self.bases(scenario).sum())
        return Likelihood(total + mean, by_basis)
