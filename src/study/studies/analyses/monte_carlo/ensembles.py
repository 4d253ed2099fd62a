"""Ensembles of impacts whose parameters are drawn from distributions, and estimates (Section 4.2).

Events come in replicates: batches of a fixed size, each with random numbers of its own. A replicate
is a pure function of the ensemble, the angle and its number, so that neither the order in which
replicates are computed nor the place matters. Each thread holds the draws of `BLOCK` events in
memory, of one replicate or several small ones, and what rigid bodies do is added up in one compiled
pass over them. The scatter of the replicates' means gives the error of every estimate, whatever the
method of sampling. Sums over replicates are exact, so an estimate does not depend on the number of
threads in its last digit either.
"""

from __future__ import annotations

import math
import sys
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from itertools import islice
from typing import Annotated, Any, Literal, NamedTuple, Protocol

import numpy as np
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.lab.surface import Rules, Strike, Surface, collide
from microimpact.model import passes
from microimpact.statistics.distributions import (
    LARGEST_PROBABILITY,
    SMALLEST_PROBABILITY,
    AnyDistribution,
    Constant,
    Distribution,
    generator,
    mean,
)
from microimpact.statistics.sampling import (
    Correlation,
    Generator,
    Method,
    joint_shares,
    require_varying,
)
from study.declared.parameters import Count

# Draws of a replicate, by the names of the parameters.
Draws = Mapping[str, FloatArray]

# Slopes of the facets, of which every contact has its own.
SLOPES = ("slope", "cross_slope")
POSITIVE = ("speed_m_per_s", "diameter_um", "work_of_adhesion_factor")
NON_NEGATIVE = ("friction", "restitution_factor", "hertz_damping_factor", "adhesion_damping_factor")


@dataclass(frozen=True, slots=True, kw_only=True)
class Inferred:
    """Slopes that are normal about the mean surface, as wide as a printed restitution asks for.

    The study infers the width of each variant and puts a `Normal` in its place.
    """

    kind: Literal["inferred"] = "inferred"


NONE, UNIT = Constant(at=0.0), Constant(at=1.0)

Slope = Annotated[AnyDistribution | Inferred, Field(discriminator="kind")]


@dataclass(frozen=True, kw_only=True)
class Process:
    """Process parameters and initial conditions, each any distribution."""

    speed_m_per_s: Distribution  # Speed before impact
    diameter_um: Distribution  # Of the sphere
    # Of the surface, along the motion and across it: tangents of the article's angle phi.
    slope: Slope
    cross_slope: Distribution
    spin_ratio: Distribution  # r omega / v about the axis of tilt, positive in the sense of rolling
    friction: Distribution  # Coulomb coefficient
    # What follows does not vary in Section 4.2.
    angle_offset_deg: Distribution = NONE  # Deviation from the nominal angle of incidence
    # The rigid body model takes ``factor e + offset``, within [0, 1], for e; not with the dynamic
    # simulation.
    restitution_factor: Distribution = UNIT
    restitution_offset: Distribution = NONE
    work_of_adhesion_factor: Distribution = UNIT  # Multiple of the contact's work of adhesion
    # Multiples of the coefficients of damping; with the dynamic simulation only.
    hertz_damping_factor: Distribution = UNIT
    adhesion_damping_factor: Distribution = UNIT

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

    @cached_property
    def distributions(self) -> dict[str, Any]:
        """The distributions by name."""
        return {item.name: getattr(self, item.name) for item in fields(self)}

    def at_means(self, *, but: Sequence[str] = ()) -> Process:
        """Return the process with all parameters but some held at their means."""
        held = {k: Constant(at=mean(d)) for k, d in self.distributions.items() if k not in but}
        return replace(self, **held)


class Impact(Protocol):
    """Model of an impact in an ensemble."""

    def sums(self, ensemble: Ensemble, groups: Iterable[Events]) -> FloatArray:
        """Return the sums over events, (replicates, columns), see `model.passes.SUMS`."""
        ...


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


@dataclass(frozen=True, kw_only=True, eq=False)
class Ensemble:
    """Distributions, rules of the surface, and model of an impact."""

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
        slope, across = self.process.slope, self.process.cross_slope
        if isinstance(slope, Inferred):
            raise ValueError("slope: must be inferred before events are drawn; declare one")
        return Surface(slope=slope, cross_slope=across, rules=self.rules)

    @cached_property
    def drawn(self) -> dict[str, Distribution]:
        """Distributions of all that is drawn: parameters, and slopes of the facets met later.

        These are independent of all else.
        """
        further = {
            _name(axis, contact): getattr(self.process, axis)
            for contact in range(1, self.rules.most_contacts)
            for axis in SLOPES
        }
        return self.process.distributions | further

    @cached_property
    def constants(self) -> dict[str, FloatArray]:
        """Values of the parameters that do not vary, (1,)."""
        return {
            name: np.full(1, law.at)
            for name, law in self.process.distributions.items()
            if isinstance(law, Constant)
        }


def deterministic(ensemble: Ensemble) -> Ensemble:
    """Return the ensemble with every parameter at its mean: all events are one."""
    process = ensemble.process.at_means()
    return replace(
        ensemble, process=process, correlation=Correlation(), plan=Plan(replicates=2, events=2)
    )


# Events of a replicate of a long run, and as many as are drawn at a time: larger arrays go back to
# the system with every task of a thread, and their pages come anew.
BLOCK = 2**14
# Events of a task: the few so close to capture that they are integrated go side by side.
TOGETHER = 4 * BLOCK
# Tasks of each thread that wait: threads are never idle, and an error is told soon.
AHEAD = 4

# Columns of the shares that are told.
REPORTED = passes.ACCEPTED, passes.FACING_AWAY, passes.CAPTURED, passes.NOT_LEAVING


class Estimate(NamedTuple):
    """Means over accepted events, standard errors of these, standard deviations of events.

    The impulse ratio is -mu, as drawn in the article. Shares are of all events.
    """

    restitution: float
    restitution_error: float
    restitution_sd: float
    impulse_ratio: float
    impulse_ratio_error: float
    impulse_ratio_sd: float
    accepted: float
    facing_away: float
    captured: float
    not_leaving: float


def estimate(
    ensemble: Ensemble,
    angle_deg: float,
    key: int = 0,
    *,
    threads: int = 1,
    done: Callable[[int], None] | None = None,
    shares: Sequence[Draws] | None = None,
) -> Estimate:
    """Return measured coefficients at one nominal angle.

    Parameters
    ----------
    ensemble
        The ensemble.
    angle_deg
        Nominal angle of incidence from the surface.
    key
        Number of the random streams: other keys, independent estimates.
    threads
        Number of threads; results do not depend on it.
    done
        Called with the number of events after each task.
    shares
        Result of `replicate_shares` for every replicate, if there already; estimates of
        ensembles that differ in their parameters alone may share them.
    """
    plan = ensemble.plan

    def some(numbers: range) -> FloatArray:
        drawn = (
            (replicate_shares(ensemble, key, number) for number in numbers)
            if shares is None
            else shares[numbers.start : numbers.stop]
        )
        return replicate_sums(ensemble, angle_deg, drawn)

    together = max(1, TOGETHER // plan.events)
    tasks = (
        range(first, min(first + together, plan.replicates))
        for first in range(0, plan.replicates, together)
    )
    sums = []
    for part in _shared(some, tasks, threads):
        sums.append(part)
        if done is not None:
            done(plan.events * len(part))
    return summary(np.concatenate(sums), plan.events)


def long_run(ensemble: Ensemble, events: int) -> Ensemble:
    """Return the ensemble with so many plain draws, rounded up to whole replicates of `BLOCK`."""
    plan = Plan(replicates=max(2, -(-events // BLOCK)), events=BLOCK)
    return replace(ensemble, plan=plan)


def _shared(
    task: Callable[[range], FloatArray], numbers: Iterable[range], threads: int
) -> Iterator[FloatArray]:
    """Yield the results of a task, in the order of its numbers."""
    if threads == 1:
        yield from map(task, numbers)
        return
    left = iter(numbers)
    with ThreadPoolExecutor(threads) as pool:
        waiting = deque(pool.submit(task, one) for one in islice(left, AHEAD * threads))
        while waiting:
            yield waiting.popleft().result()
            waiting.extend(pool.submit(task, one) for one in islice(left, 1))


def summary(sums: FloatArray, events: int) -> Estimate:
    """Return the estimate of replicates, in their order; means are NaN if no event is accepted."""
    total = np.array([math.fsum(column) for column in sums.T])
    shares = total / (len(sums) * events)
    if not (accepted := total[passes.ACCEPTED]):
        return Estimate(*[np.nan] * 6, *(float(shares[i]) for i in REPORTED))
    numbers: list[float] = []
    for first, squares in ((passes.E, passes.E_SQUARED), (passes.MU, passes.MU_SQUARED)):
        average = total[first] / accepted
        # Scatter of a ratio of sums, as the number accepted varies between replicates.
        scatter = sums[:, first] - average * sums[:, passes.ACCEPTED]
        error = np.sqrt(math.fsum(scatter**2) * len(sums) / (len(sums) - 1)) / accepted
        variance = total[squares] / accepted - average**2
        numbers += [float(average), float(error), float(np.sqrt(max(variance, 0.0)))]
    return Estimate(*numbers, *(float(shares[i]) for i in REPORTED))


def replicate_shares(ensemble: Ensemble, key: int, number: int) -> Draws:
    """Return the shares of one replicate's events of which the quantiles are their parameters."""
    plan = ensemble.plan
    return joint_shares(
        ensemble.drawn,
        plan.events,
        generator(ensemble.seed[0], *ensemble.seed[1:], key, number),
        correlation=ensemble.correlation,
        method=plan.method,
        generator=plan.generator,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Events:
    """Events of some replicates of an ensemble at one nominal angle, degrees."""

    ensemble: Ensemble
    angle_deg: float
    shares: Draws  # Of which the quantiles are parameters; of constants one for all
    # Number of events, and of the replicates that these are in turn.
    count: int
    replicates: int

    @property
    def draws(self) -> dict[str, FloatArray]:
        """Values of all parameters but the slopes; of constants of shape (1,)."""
        constants = self.ensemble.constants
        varying = {
            name: law.quantile(self.shares[name])
            for name, law in self.ensemble.process.distributions.items()
            if name not in SLOPES and name not in constants
        }
        return constants | varying

    @property
    def facets(self) -> list[tuple[FloatArray, FloatArray]]:
        """Shares of the facets met in turn, along and across."""
        contacts = range(self.ensemble.rules.most_contacts)
        return [
            (self.shares[_name("slope", k)], self.shares[_name("cross_slope", k)]) for k in contacts
        ]


class Struck(ABC):
    """Impacts that are found contact by contact."""

    @abstractmethod
    def __call__(self, draws: Draws) -> Strike:
        """Return the rebounds of spheres with these draws, as a function of their contacts."""

    def sums(self, ensemble: Ensemble, groups: Iterable[Events]) -> FloatArray:
        """Return the sums over events, see `Impact`."""
        return np.concatenate([self._sums(ensemble.surface, events) for events in groups])

    def _sums(self, surface: Surface, events: Events) -> FloatArray:
        n, rules = events.count, surface.rules
        draws = {name: np.broadcast_to(values, n) for name, values in events.draws.items()}
        facets = [(np.broadcast_to(a, n), np.broadcast_to(b, n)) for a, b in events.facets]
        before, spin = _approach(draws, events.angle_deg)
        rebound = collide(surface, before, spin, facets, self(draws))
        faced, accepted, after = rebound.contacts > 0, rebound.observed(rules), rebound.velocity
        change = after[accepted] - before[accepted]
        e, mu = np.zeros((2, n))
        e[accepted] = -after[accepted, 2] / before[accepted, 2]
        mu[accepted] = -change[:, 0] / change[:, 2]
        counts = (~faced, rebound.kept, faced & ~rebound.kept & ~accepted, accepted)
        sums = [
            values.reshape(events.replicates, -1).sum(axis=1, dtype=float)
            for values in (*counts, e, e**2, mu, mu**2)
        ]
        return np.stack(sums, axis=1)


def replicate_sums(ensemble: Ensemble, angle_deg: float, shares: Iterable[Draws]) -> FloatArray:
    """Return counts of rejections, and sums of e and -mu and of their squares.

    Shape (replicates, 8), of the shares of each replicate.
    """
    left, together = iter(shares), max(1, BLOCK // ensemble.plan.events)
    parts = iter(lambda: list(islice(left, together)), [])
    groups = (_events(ensemble, angle_deg, part) for part in parts)
    return ensemble.impact.sums(ensemble, groups)


def _events(ensemble: Ensemble, angle_deg: float, shares: Sequence[Draws]) -> Events:
    """Return the events of the shares of some replicates."""
    joined = shares[0]
    if len(shares) > 1:
        joined = {
            name: one if one.size == 1 else np.concatenate([s[name] for s in shares])
            for name, one in joined.items()
        }
    return Events(
        ensemble=ensemble,
        angle_deg=angle_deg,
        shares=joined,
        count=len(shares) * ensemble.plan.events,
        replicates=len(shares),
    )


def _approach(draws: Draws, angle_deg: float) -> tuple[FloatArray, FloatArray]:
    """Velocity and spin before impact, in the frame of the nominal surface, shape (n, 3)."""
    angle, speed = np.radians(angle_deg + draws["angle_offset_deg"]), draws["speed_m_per_s"]
    none = np.zeros_like(speed)
    velocity = np.stack([speed * np.cos(angle), none, -speed * np.sin(angle)], axis=1)
    turn = draws["spin_ratio"] * speed / (0.5e-6 * draws["diameter_um"])
    return velocity, np.stack([none, turn, none], axis=1)


def _name(axis: str, contact: int) -> str:
    return f"{axis}, contact {contact + 1}" if contact else axis


@contextmanager
def progress(title: str, total: int) -> Iterator[Callable[[int], None]]:
    """Yield a function that advances a bar towards ``total`` by each further part."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich import progress as bars
    from rich.console import Console

    columns = (
        bars.TextColumn("{task.description}"),
        bars.BarColumn(),
        bars.TaskProgressColumn(),
        bars.TimeElapsedColumn(),
        bars.TimeRemainingColumn(),
    )
    with bars.Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=total)
        yield lambda part: bar.advance(task, part)
