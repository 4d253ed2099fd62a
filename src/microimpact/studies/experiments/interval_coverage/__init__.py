"""How often the 95 % intervals of some 40 events hold the true mean, and which (Section 2.1)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from operator import itemgetter
from typing import Annotated, Any

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.core.tables import series_frame
from microimpact.declared.parameters import (
    CaseName,
    Count,
    Fraction,
    Keyed,
    Name,
    NonNegative,
    Positive,
)
from microimpact.lab.contacts import calibrated_contact
from microimpact.lab.dispenser import Dispenser, InitialSpin
from microimpact.lab.events import Measured
from microimpact.lab.experiment import Drop, Target
from microimpact.lab.pdpa import analyser as doppler
from microimpact.lab.pdpa import experiment as normal_incidence
from microimpact.lab.ptis import experiment as oblique_incidence
from microimpact.lab.ptis import system as imaging
from microimpact.lab.reduction import QUANTITIES, quantities
from microimpact.lab.surface import rough
from microimpact.statistics.distributions import Distribution, generator
from microimpact.statistics.intervals import student_half_width, wilson_interval
from microimpact.studies.experiments.interval_coverage.repeated import (
    Repeated,
    by_doppler,
    by_imaging,
)

NEEDS = {"calibration": ("calibration",)}

NORMAL = 90.0
SHIFTED = {"PDPA": normal_incidence.moved, "PTIS": oblique_incidence.turned}
MEASURED_BY = {"PDPA": ("restitution",), "PTIS": QUANTITIES}
# The means that are drawn, by the end of their columns.
DRAWN = {"observable": "events that can be measured", "rebounds": "all rebounds"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """Experiments of one surface, over speeds at one angle or over angles at one speed."""

    name: Name
    speeds_m_per_s: tuple[Positive, ...]
    angles_deg: tuple[Annotated[float, Field(gt=0, le=90)], ...]
    diameter_um: Distribution
    slope: NonNegative
    speed_window: Annotated[float, Field(gt=0, lt=1)]
    simulated: Count


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Cases, and how often each is repeated; at 90 deg by the analyser, else by imaging."""

    seed: Annotated[int, Field(ge=0)]
    case: CaseName
    friction: Fraction
    cases: Annotated[tuple[Case, ...], Keyed("name")]
    experiments: Annotated[int, Field(ge=2)]
    events: Annotated[int, Field(ge=2)]
    level: Annotated[float, Field(gt=0, lt=1)]
    dispenser: Dispenser
    pdpa: doppler.Instrument
    ptis: imaging.Instrument

    def __post_init__(self) -> None:
        """Refuse to draw a panel of nothing."""
        normal = [angle == NORMAL for case in self.cases for angle in case.angles_deg]
        if not (any(normal) and not all(normal)):
            raise ValueError("cases: must hold an experiment at 90 deg and one at another angle")


def run(params: Params, inputs: Mapping[str, pd.DataFrame]) -> Mapping[str, pd.DataFrame]:
    """Repeat every experiment and count the intervals that hold each mean.

    Parameters
    ----------
    params
        Parameters of the study.
    inputs
        ``calibration``: calibrated contacts; ``materials``: declared rows.

    Returns
    -------
    mapping
        ``interval_coverage``: one row per experiment and quantity. ``coverage_by_speed``,
        ``coverage_by_angle``: coverage of restitution.
    """
    return gather(params, inputs, [part(params, inputs, 0, 1)])


def part(
    params: Params, inputs: Mapping[str, pd.DataFrame], index: int, count: int
) -> list[tuple[int, list[dict[str, Any]]]]:
    """Return the rows of every ``count``-th experiment, from ``index`` on, with their numbers."""
    contact = calibrated_contact(inputs, params.case).replace(friction=params.friction)
    every = [
        (number, i, k)
        for number, case in enumerate(params.cases)
        for i, k in np.ndindex(len(case.angles_deg), len(case.speeds_m_per_s))
    ]
    rows = []
    for place in range(index, len(every), count):
        number, i, k = every[place]
        case = params.cases[number]
        target = Target(contact=contact, surface=rough(case.slope)).tabulated(case.diameter_um)
        angle, speed = case.angles_deg[i], case.speeds_m_per_s[k]
        rng = generator(params.seed, number, i, k)
        try:
            repeated = _repeated(params, case, target, angle, speed, rng)
        except ValueError as error:
            where = f"cases.{case.name}, {speed:g} m/s, {angle:g} deg"
            raise ValueError(f"{where}: {error}") from None
        rows.append((place, list(coverage_rows(params, case, angle, speed, repeated))))
    return rows


def gather(
    params: Params,
    inputs: Mapping[str, pd.DataFrame],
    parts: Sequence[list[tuple[int, list[dict[str, Any]]]]],
) -> Mapping[str, pd.DataFrame]:
    """Return the tables, from the rows of all parts."""
    every = sorted(chain(*parts), key=itemgetter(0))
    table = pd.DataFrame([row for _, rows in every for row in rows])
    return {"interval_coverage": table, **drawn(table)}


def _repeated(
    params: Params,
    case: Case,
    target: Target,
    angle: float,
    speed: float,
    rng: np.random.Generator,
) -> Repeated:
    window = case.speed_window
    drop = Drop(
        target=target,
        diameter_um=case.diameter_um,
        angle=angle,
        speed=speed,
        speed_range=(speed * (1.0 - window), speed * (1.0 + window)),
        dispenser=params.dispenser,
        spin=InitialSpin(sd=0.0, mean=0.0),
    )
    size = params.experiments, params.events, case.simulated
    if angle == NORMAL:
        return by_doppler(*size, drop, params.pdpa, rng)
    return by_imaging(*size, drop, params.ptis, rng)


def coverage_rows(
    params: Params, case: Case, angle: float, speed: float, repeated: Repeated
) -> Iterator[dict[str, Any]]:
    """Yield how often the intervals of each quantity hold each mean, and how wide they are."""
    instrument = "PDPA" if angle == NORMAL else "PTIS"
    means = quantities(repeated.measured)
    accepted, unselected = quantities(repeated.true), _unselected(case, speed, repeated)
    systematic = _systematic(instrument, repeated)
    for name in MEASURED_BY[instrument]:
        values = means[name]
        centre = values.mean(axis=1)
        sd = values.std(axis=1, ddof=1)
        half = student_half_width(sd, params.events, systematic[name], params.level)
        row: dict[str, Any] = {
            "case": case.name,
            "instrument": instrument,
            "angle_deg": angle,
            "speed_m_per_s": speed,
            "quantity": name,
            "experiments": params.experiments,
            "events": params.events,
            "captured_share": float(np.mean(repeated.impacts.captured)),
            "observable_share": repeated.observable,
        }
        truths = {"observable": float(accepted[name].mean())} | unselected[name]
        for which, truth in truths.items():
            held = np.abs(centre - truth) <= half
            low, high = wilson_interval(int(held.sum()), held.size)
            row |= {
                f"mean_{which}": truth,
                f"coverage_{which}": float(held.mean()),
                f"coverage_{which}_low": low,
                f"coverage_{which}_high": high,
            }
        yield row | {
            "bias_of_the_mean": float(centre.mean() - truths["observable"]),
            "half_width": float(half.mean()),
            "systematic_share": float(np.mean(np.square(systematic[name] / (half / 2.0)))),
            "skewness_of_events": _skewness(values),
            "evidence": "virtual experiment",
        }


def _systematic(instrument: str, repeated: Repeated) -> dict[str, FloatArray]:
    """Return the standard uncertainty of every mean that its events share, (experiments,)."""
    shift = SHIFTED[instrument]
    high, low = (
        quantities(shift(repeated.measured, sign * repeated.uncertainty)) for sign in (1.0, -1.0)
    )
    return {name: 0.5 * np.abs((high[name] - low[name]).mean(axis=1)) for name in high}


def _skewness(values: FloatArray) -> float:
    about = values - values.mean()
    squares = about * about  # a product is far quicker than a power
    return float(np.mean(squares * about) / np.mean(squares) ** 1.5)


def _unselected(case: Case, speed: float, repeated: Repeated) -> dict[str, dict[str, float]]:
    """Return the means over all rebounds and over all impacts of the class, seen or not.

    Captured impacts count with no restitution and all their energy lost; friction is of rebounds.
    """
    exact: Measured = repeated.impacts.in_plane
    inside = np.abs(exact.speed / speed - 1.0) <= case.speed_window
    rebounds = inside & ~repeated.impacts.captured
    return {
        name: {
            "rebounds": float(np.mean(of[rebounds])),
            "all": float(np.mean(of[rebounds if name == "impulse_ratio" else inside])),
        }
        for name, of in quantities(exact).items()
    }


def drawn(table: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return the coverage of restitution, by speed at normal and by angle at oblique incidence."""
    rows = table[table["quantity"] == "restitution"]
    axes = {"speed": ("PDPA", "speed_m_per_s"), "angle": ("PTIS", "angle_deg")}
    found = {}
    for axis, (instrument, column) in axes.items():
        frames = [
            series_frame(
                panel=axis,
                series=f"{name}: {words}",
                evidence="virtual experiment",
                x=own[column],
                y=100.0 * own[f"coverage_{which}"],
                y_low=100.0 * own[f"coverage_{which}_low"].to_numpy(),
                y_high=100.0 * own[f"coverage_{which}_high"].to_numpy(),
                x_unit=column.removeprefix("speed_").removeprefix("angle_"),
                y_unit="percent",
            )
            for name, own in rows[rows["instrument"] == instrument].groupby("case", sort=False)
            for which, words in DRAWN.items()
        ]
        found[f"coverage_by_{axis}"] = pd.concat(frames, ignore_index=True)
    return found
