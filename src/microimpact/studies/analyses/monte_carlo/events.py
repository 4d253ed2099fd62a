"""Estimates over ensembles of impacts.

Events come in replicates: batches of a fixed size, each with random numbers of its own. A replicate
is a pure function of the ensemble, the angle and its number, so that neither the order in which
replicates are computed nor the place matters; small ones are computed several at a time, and each
thread holds no more events than `BLOCK`, or one replicate, in memory. The scatter of
their means gives the error of every estimate, whatever the method of sampling. Sums over replicates
are exact, so an estimate does not depend on the number of threads in its last digit either.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import islice
from typing import NamedTuple

import numpy as np

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.lab.events import IntArray
from microimpact.lab.slopes import STEEPEST, HitSlopes
from microimpact.model.rigid_body.facets import facet_normals
from microimpact.statistics.distributions import Distribution, generator
from microimpact.statistics.sampling import joint_shares
from microimpact.studies.analyses.monte_carlo.ensembles import Draws, Ensemble, Plan

# Events of a replicate of a long run: its arrays fit the processor's second cache.
BLOCK = 2**14
# Tasks handed to threads at a time: enough to keep them busy, few enough to wait for.
BATCH = 64

# Columns of the sums of a replicate.
FACING_AWAY, CAPTURED, NOT_LEAVING, ACCEPTED, E, E_SQUARED, MU, MU_SQUARED = range(8)


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
        That share the replicates; results do not depend on it.
    done
        Called with the number of events after each task.
    shares
        What `replicate_shares` gives for every replicate, if there already; estimates of ensembles
        that differ in their parameters alone may share them.
    """
    plan = ensemble.plan

    def some(numbers: range) -> FloatArray:
        drawn = (
            [replicate_shares(ensemble, key, number) for number in numbers]
            if shares is None
            else shares[numbers.start : numbers.stop]
        )
        return replicate_sums(ensemble, angle_deg, drawn)

    together = max(1, BLOCK // plan.events)
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
    waiting = iter(numbers)
    with ThreadPoolExecutor(threads) as pool:
        while batch := list(islice(waiting, BATCH)):
            yield from pool.map(task, batch)


def summary(sums: FloatArray, events: int) -> Estimate:
    """Return the estimate of replicates, in their order; means are NaN if no event is accepted."""
    total = np.array([math.fsum(column) for column in sums.T])
    shares = total / (len(sums) * events)
    if not total[ACCEPTED]:
        return Estimate(*[np.nan] * 6, *(float(shares[i]) for i in (3, 0, 1, 2)))
    numbers: list[float] = []
    for first, squares in ((E, E_SQUARED), (MU, MU_SQUARED)):
        average = total[first] / total[ACCEPTED]
        # Scatter of a ratio of sums, as the number accepted varies between replicates.
        scatter = sums[:, first] - average * sums[:, ACCEPTED]
        error = np.sqrt(math.fsum(scatter**2) * len(sums) / (len(sums) - 1)) / total[ACCEPTED]
        variance = total[squares] / total[ACCEPTED] - average**2
        numbers += [float(average), float(error), float(np.sqrt(max(variance, 0.0)))]
    return Estimate(*numbers, *(float(shares[i]) for i in (3, 0, 1, 2)))


def replicate_shares(ensemble: Ensemble, key: int, number: int) -> Draws:
    """Return the shares of one replicate's events of which the quantiles are their parameters."""
    plan = ensemble.plan
    return joint_shares(
        ensemble.process.distributions | _further_slopes(ensemble),
        plan.events,
        generator(ensemble.seed[0], *ensemble.seed[1:], key, number),
        correlation=ensemble.correlation,
        method=plan.method,
        generator=plan.generator,
    )


def replicate_sums(ensemble: Ensemble, angle_deg: float, shares: Sequence[Draws]) -> FloatArray:
    """Return counts of rejections, and sums of e and -mu and of their squares.

    Shape (replicates, 8), of the shares of each replicate.
    """
    distributions = ensemble.process.distributions
    all_shares = {name: np.concatenate([one[name] for one in shares]) for name in shares[0]}
    draws = {name: d.quantile(all_shares[name]) for name, d in distributions.items()}
    before, spin_speed = _approach(draws, angle_deg)
    after, faced, captured = _contacts(ensemble, all_shares, draws, before, spin_speed)
    left = after[:, 2] > 0.0 if ensemble.rules.must_leave else np.ones_like(faced)
    accepted = faced & ~captured & left
    change = after[accepted] - before[accepted]
    e, mu = np.zeros((2, len(accepted)))
    e[accepted] = -after[accepted, 2] / before[accepted, 2]
    mu[accepted] = -change[:, 0] / change[:, 2]
    counts = (~faced, faced & captured, faced & ~captured & ~left, accepted)
    sums = [
        values.reshape(len(shares), -1).sum(axis=1, dtype=float)
        for values in (*counts, e, e**2, mu, mu**2)
    ]
    return np.stack(sums, axis=1)


@dataclass(frozen=True, slots=True)
class _Chosen(Mapping[str, FloatArray]):
    """Draws of some events, copied when asked for: few impacts ask for all parameters."""

    draws: Draws
    chosen: IntArray

    def __getitem__(self, name: str) -> FloatArray:
        return np.take(self.draws[name], self.chosen)

    def __iter__(self) -> Iterator[str]:
        return iter(self.draws)

    def __len__(self) -> int:
        return len(self.draws)


def _approach(draws: Draws, angle_deg: float) -> tuple[FloatArray, FloatArray]:
    """Velocity and r omega before impact, in the frame of the nominal surface, shape (n, 3)."""
    angle, speed = np.radians(angle_deg + draws["angle_offset_deg"]), draws["speed_m_per_s"]
    none = np.zeros_like(speed)
    velocity = np.stack([speed * np.cos(angle), none, -speed * np.sin(angle)], axis=1)
    return velocity, np.stack([none, draws["spin_ratio"] * speed, none], axis=1)


def _further_slopes(ensemble: Ensemble) -> dict[str, Distribution]:
    """Slopes of the facets after the first, independent of all else."""
    return {
        _name(axis, contact): getattr(ensemble.process, axis)
        for contact in range(1, ensemble.rules.most_contacts)
        for axis in ("slope", "cross_slope")
    }


def _name(axis: str, contact: int) -> str:
    return f"{axis}, contact {contact + 1}" if contact else axis


def _contacts(
    ensemble: Ensemble,
    shares: Draws,
    draws: Draws,
    velocity: FloatArray,
    spin_speed: FloatArray,
) -> tuple[FloatArray, BoolArray, BoolArray]:
    """Velocity after the last contact, who met a facet at all, and who stays."""
    velocity, spin_speed = velocity.copy(), spin_speed.copy()
    faced, captured = np.zeros((2, len(velocity)), dtype=bool)
    moving = np.flatnonzero(velocity[:, 2] < 0.0)
    for contact in range(ensemble.rules.most_contacts):
        normal = _facets(
            ensemble,
            velocity[moving],
            shares[_name("slope", contact)][moving],
            shares[_name("cross_slope", contact)][moving],
        )
        into = np.vecdot(velocity[moving], normal)
        if not ensemble.rules.must_face:
            normal, into = -np.sign(into)[:, None] * normal, -np.abs(into)
        moving, normal = moving[into < 0.0], normal[into < 0.0]
        faced[moving] = True
        rebound = ensemble.impact(
            _Chosen(draws, moving), velocity[moving], spin_speed[moving], normal
        )
        velocity[moving], spin_speed[moving], captured[moving] = rebound
        moving = moving[~rebound.captured & (rebound.velocity[:, 2] <= 0.0)]
        if not moving.size:
            break
    return velocity, faced, captured


def _facets(
    ensemble: Ensemble, velocity: FloatArray, along: FloatArray, across: FloatArray
) -> FloatArray:
    """Normals of the facets met, from the shares of their slopes; shape (n, 3)."""
    process = ensemble.process
    if ensemble.rules.flux_weighted:
        speed = np.hypot(velocity[:, 0], velocity[:, 1])
        # Upright motion meets all facets alike; no slope can be hit where none faces the sphere.
        tangent = -velocity[:, 2] / np.maximum(speed, np.finfo(float).tiny)
        slope = np.maximum(HitSlopes.of(process.slope).quantile(along, tangent), -STEEPEST)
    else:
        slope = process.slope.quantile(along)
    return facet_normals(velocity, slope, process.cross_slope.quantile(across))
