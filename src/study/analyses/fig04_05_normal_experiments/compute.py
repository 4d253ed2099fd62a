"""Normal impacts as the article's laboratory measures them: two sieve classes (Figs. 4 and 5)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from microimpact.core.arrays import FloatArray, Real
from microimpact.lab.dispenser import Dispenser
from microimpact.lab.experiment import Drop, Outcome, StopRule, Target
from microimpact.lab.pdpa.analyser import Analyser
from microimpact.lab.pdpa.experiment import QUANTITIES, collect
from microimpact.lab.reduction import interval_columns
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.normal import normal_impact
from microimpact.statistics.distributions import generator, mean
from microimpact.statistics.intervals import mean_and_error
from study.contacts import calibrated_contact, pair_of, printed_values_for
from study.declared.parameters import (
    CaseName,
    ExperimentSeed,
    Fraction,
    Name,
    Points,
    Positive,
)
from study.laboratory import Laboratory, Sieve
from study.tables import Tables, series_frame

NEEDS = {"calibration": ("calibration",)}
PRINTED_VALUES = ("pile_up_speed_sst_silicon",)

_frame = partial(series_frame, "all", x_unit="m_per_s", y_unit="1")
# Speed, m/s, and restitution of a curve.
Drawn = tuple[FloatArray, FloatArray]

# Where more are captured, the mean of the few that rebound is not drawn.
HIDDEN_SHARE = 0.9
# Of the plateau, where restitution has visibly fallen.
PLATEAU_SHARE = 0.9
# Quantiles of each sieve class.
SIZES = 200


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Two sieve classes on one surface over a range of speeds."""

    seed: ExperimentSeed
    case: CaseName
    other_case: CaseName
    populations: dict[Name, Sieve]
    speeds_m_per_s: tuple[Positive, ...]
    speed_window: Fraction
    stop: StopRule
    dispenser: Dispenser
    instrument: Analyser
    points: Points


def disagreements(params: Params, _: Mapping[str, Any], laboratory: Laboratory) -> Iterator[str]:
    """Yield a line for each class of particles that are not those of the contact."""
    for name, population in params.populations.items():
        key = f"populations.{name}.particle"
        yield from laboratory.other_particle(key, population.particle, params.case)


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """Mean restitution and captured share of a sieve class over speed, without instrument."""

    speed: FloatArray  # m/s, shape (n,)
    # Mean restitution of the particles that rebound, shape (n,); nan where none does.
    rebounding: FloatArray
    captured: FloatArray  # Share captured, shape (n,)


def run(params: Params, inputs: Tables) -> Tables:
    """Drop both classes at every speed, observe, reduce.

    ``fig04``: restitution against the normal speed. ``fig05``: energy loss. ``normal_experiments``:
    one row per experiment, measured and true. ``size_effects``: what the spread of sizes does to
    restitution and capture.
    """
    contacts = {case: calibrated_contact(inputs, case) for case in (params.case, params.other_case)}
    table = pd.DataFrame(
        experiment_row(name, speed, experiment(params, population, speed, contacts[params.case]))
        for (name, population), speed in product(params.populations.items(), params.speeds_m_per_s)
    )
    curves = {
        (case, name): sieve_curve(params, population, contact)
        for case, contact in contacts.items()
        for name, population in params.populations.items()
    }
    pair, populations = pair_of(inputs, params.case), params.populations.values()
    sizes = [mean(population.diameter_um) for population in populations]
    printed = pd.concat([printed_values_for(inputs, *pair, diameter_um=size) for size in sizes])
    series = sieves_drawn(params, params.case, curves)
    second = sieves_drawn(params, params.other_case, curves, ", other end")
    drawn = {**series, **(second if params.other_case != params.case else {})}
    return {
        "fig04": figure_data(params, "restitution", table, drawn, printed),
        "fig05": figure_data(params, "energy_loss", table, series, printed, lambda e: 1.0 - e**2),
        "normal_experiments": table,
        "size_effects": pd.DataFrame(size_effects(curves)),
    }


def experiment(params: Params, population: Sieve, speed: float, contact: Contact) -> Outcome:
    """Return one experiment: its first accepted events near the nominal speed are averaged."""
    window = params.speed_window
    drop = Drop(
        target=Target(contact=contact),
        diameter_um=population.diameter_um,
        speed=speed,
        speed_range=(speed * (1.0 - window), speed * (1.0 + window)),
        dispenser=params.dispenser,
    ).tabulated()
    return collect(drop, params.instrument, params.stop, generator(params.seed, *drop.key))


def experiment_row(population: str, speed: float, outcome: Outcome) -> dict[str, Any]:
    """Return one experiment as a row of the table: losses, measured means, and truth."""
    measured, fates = outcome.measured, outcome.fates
    truth = outcome.first_impacts.in_plane.coefficient_of_restitution
    return {
        "population": population,
        "nominal_speed_m_per_s": speed,
        "speed_m_per_s": mean_and_error(-measured.normal[0])[0],
        "dropped": outcome.dropped,
        "events": len(measured),
        "captured": fates["captured"],
        "too_slow_for_the_probe": fates["rebound below probe"],
        "missed_the_probe": fates["incident missed probe"] + fates["rebound missed probe"],
        **interval_columns(outcome.means, *QUANTITIES),
        "true_restitution_of_rebounds": mean_and_error(truth[truth > 0.0])[0],
        "evidence": "virtual experiment",
    }


def sieve_curve(params: Params, population: Sieve, contact: Contact) -> Curve:
    """Return the mean of a sieve class over its sizes, at speeds up to the largest."""
    share = (np.arange(SIZES) + 0.5) / SIZES
    sized = resized(contact, population.diameter_um.quantile(share) * 1e-6)
    speed = np.geomspace(0.05, max(params.speeds_m_per_s), params.points)
    impact = normal_impact(sized, speed[:, None])
    e, captured = impact.coefficient_of_restitution, np.asarray(impact.captured)
    rebounds = np.sum(~captured, axis=1)
    with np.errstate(invalid="ignore"):
        rebounding = np.sum(np.where(captured, 0.0, e), axis=1) / rebounds
    return Curve(speed=speed, rebounding=rebounding, captured=np.mean(captured, axis=1))


def size_effects(curves: Mapping[tuple[str, str], Curve]) -> Iterator[dict[str, Any]]:
    """Yield where restitution has fallen to a share of its plateau, and the width of capture."""
    for (case, name), curve in curves.items():
        plateau = float(curve.rebounding[-1])
        low = np.flatnonzero(curve.rebounding < PLATEAU_SHARE * plateau)
        fallen = float(curve.speed[low[-1]]) if low.size else np.nan
        captured = {
            f"captured_{share}_percent_m_per_s": np.interp(
                -share / 100.0, -curve.captured, curve.speed
            )
            for share in (50, 10)
        }
        yield (
            {"case": case, "population": name, "fallen_speed_m_per_s": fallen, **captured}
            | {"restitution_at_highest_speed": plateau, "evidence": "computed"}
        )


def sieves_drawn(
    params: Params, case: str, curves: Mapping[tuple[str, str], Curve], end: str = ""
) -> dict[str, Drawn]:
    """Return the restitution of both classes on one contact, where not all is captured."""
    drawn = {}
    for name in params.populations:
        curve = curves[case, name]
        shown = curve.captured < HIDDEN_SHARE
        drawn[f"{name} sieve{end}"] = curve.speed[shown], curve.rebounding[shown]
    return drawn


def figure_data(
    params: Params,
    quantity: str,
    table: pd.DataFrame,
    drawn: Mapping[str, Drawn],
    printed: pd.DataFrame,
    transform: Callable[[Real], Real] = lambda e: e,
) -> pd.DataFrame:
    """Measured means of a quantity, and the transform to it of restitutions drawn."""
    frames = [
        _frame(str(population), own["speed_m_per_s"], own[quantity], "virtual experiment", *ends)
        for population, own in table.dropna(subset=quantity).groupby("population", sort=False)
        for ends in [(own[f"{quantity}_low"], own[f"{quantity}_high"])]
    ]
    frames += [_frame(name, speed, transform(e)) for name, (speed, e) in drawn.items()]
    piles = printed.loc[printed.index.isin(PRINTED_VALUES), ["low", "high"]]
    if len(piles):
        frames.append(_frame("printed pile-up", piles.iloc[0], 0.0, "printed"))
    return pd.concat(frames, ignore_index=True)
