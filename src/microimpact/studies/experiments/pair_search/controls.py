"""Streams in which a search for pairs must fail, or is made hard."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import BoolArray
from microimpact.declared.parameters import Positive
from microimpact.lab.pdpa.analyser import GroundTruth, Stream
from microimpact.lab.pdpa.observation import Observation, Quality, judge, ratio
from microimpact.lab.pdpa.pairing import search
from microimpact.statistics.distributions import generator
from microimpact.studies.experiments.pair_search.doppler import Setup, dropped, observed


@dataclass(frozen=True, slots=True, kw_only=True)
class Control:
    """Nominal speed of the impacts, and how many times as many arrive in the crowded stream."""

    speed_m_per_s: Positive
    crowding: Annotated[float, Field(gt=1)]


Change = Callable[[Observation, np.random.Generator], tuple[Stream, GroundTruth]]


def pairing_controls(
    setup: Setup, params: Control, experiments: int, particles: int, key: int
) -> pd.DataFrame:
    """Return how the search fares with changed streams of the same experiments.

    ``pairs_per_incident`` is the rate at which a falling record is given a partner; where there
    are none to be found, it is the rate of false pairs.
    """
    often = setup.dispenser.particles_per_tap * params.crowding
    crowded = replace(setup, dispenser=replace(setup.dispenser, particles_per_tap=often))
    plain, dense = (
        _observed(case, params.speed_m_per_s, experiments, particles, key)
        for case in (setup, crowded)
    )
    cases: tuple[tuple[str, list[Observation], Change], ...] = (
        ("as recorded", plain, _as_recorded),
        ("times of rebounds permuted", plain, _times_permuted),
        ("rebounds left out", plain, _without_rebounds),
        (f"{params.crowding:g} times the arrivals", dense, _as_recorded),
    )
    rows = []
    for name, observations, change in cases:
        found = list(_judged(setup, observations, change, particles, key))
        total = {
            count: sum(getattr(quality, count) for quality in found)
            for count in ("pairs", "true_pairs", "recorded_pairs", "unpaired_incidents")
        }
        rows.append(
            {
                "stream": name,
                "speed_m_per_s": params.speed_m_per_s,
                "probe_height_mm": setup.instrument.probe_height_mm,
                "experiments": experiments,
                **total,
                "precision": ratio(total["true_pairs"], total["pairs"]),
                "recall": ratio(total["true_pairs"], total["recorded_pairs"]),
                "pairs_per_incident": ratio(
                    total["pairs"], total["pairs"] + total["unpaired_incidents"]
                ),
                "converged": sum(quality.converged for quality in found) / experiments,
            }
        )
    return pd.DataFrame(rows)


def _observed(
    setup: Setup, speed: float, experiments: int, particles: int, key: int
) -> list[Observation]:
    every = [dropped(setup, speed, particles, (key, i, 0)) for i in range(experiments)]
    return [observed(setup, one, speed, (key, i, 1)) for i, one in enumerate(every)]


def _judged(
    setup: Setup, observations: list[Observation], change: Change, particles: int, key: int
) -> Iterator[Quality]:
    instrument = setup.instrument
    estimate = 1e-3 * instrument.probe_height_mm * (1.0 + instrument.initial_estimate_error)
    for i, found in enumerate(observations):
        stream, truth = change(found, generator(setup.seed, key, i, 2))
        pairing = search(stream, estimate, instrument)
        captured = found.impacts.captured[:particles]
        yield judge(pairing, stream, truth, found.crossing, captured, found.quality.height)


def _as_recorded(found: Observation, _: np.random.Generator) -> tuple[Stream, GroundTruth]:
    return found.stream, found.truth


def _times_permuted(found: Observation, rng: np.random.Generator) -> tuple[Stream, GroundTruth]:
    rising = np.flatnonzero(found.stream.velocity > 0.0)
    time = found.stream.time.copy()
    time[rising] = time[rng.permutation(rising)]
    return replace(found.stream, time=time), found.truth


def _without_rebounds(found: Observation, _: np.random.Generator) -> tuple[Stream, GroundTruth]:
    """Leave out what rose; false records stay, and rise as often as they fall."""
    stays: BoolArray = (found.truth.impact < 0) | (found.stream.velocity < 0.0)
    truth = replace(found.truth, leg=found.truth.leg[stays], impact=found.truth.impact[stays])
    return found.stream.take(stays), truth
