"""How often the interval that `microimpact fit` recommends holds the true capture velocity."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import islice, product, starmap
from typing import Annotated, NamedTuple

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.core.tables import Row, Tables, series_frame
from microimpact.declared.parameters import AboveOne, CaseName, Count, Name, NonNegative, Positive
from microimpact.model.contact import Contact
from microimpact.model.contact_laws import JKR
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.empirical.comparison import Comparison, compare_sets
from microimpact.model.empirical.equations import restitution
from microimpact.statistics.intervals import wilson_interval
from microimpact.studies.contacts import calibrated_contact
from microimpact.studies.models.contact_laws import WORK, law_fit
from microimpact.studies.models.fit_coverage.truths import MEASUREMENTS, observed, standard_noise

ANOTHER = "ring force, another n"


@dataclass(frozen=True, slots=True, kw_only=True)
class Averaged:
    """Data sets of several true curves, each fitted by all models."""

    # Contacts with a ring force; a last one has the damping of the last at v_c, but falling with
    # another rate exponent.
    cases: Annotated[tuple[CaseName, ...], Field(min_length=1)]
    another_rate_exponent: NonNegative
    # The JKR contact with a viscous bulk, of the laws that contact_laws fits with the printed v_c.
    viscous_law: Name
    lowest_speeds_in_v_c: Annotated[tuple[AboveOne, ...], Field(min_length=1)]
    noise_of_e: Annotated[tuple[Positive, ...], Field(min_length=1)]
    points: Annotated[tuple[Annotated[int, Field(ge=8)], ...], Field(min_length=1)]
    sets: Count  # Data sets per truth and design


class Design(NamedTuple):
    """A true curve and the design of its data."""

    truth: str
    noise: float
    points: int
    lowest: float


def designs(params: Averaged) -> Iterator[Design]:
    """All designs."""
    names = ("Eq. 34", *params.cases, "viscous JKR", ANOTHER)
    levels = (names, params.noise_of_e, params.points, params.lowest_speeds_in_v_c)
    return starmap(Design, product(*levels))


def true_contact(params: Averaged, inputs: Tables, truth: str) -> Contact:
    """Return the contact behind a true curve that is simulated."""
    if truth in params.cases:
        return calibrated_contact(inputs, truth)
    if truth == "viscous JKR":
        fit = law_fit(inputs["contact_law_fits"], params.viscous_law)
        law = JKR(viscous_time=1e-9 * fit["viscous_time_ns"])
        return calibrated_contact(inputs, params.cases[0]).by_law(law, fit[WORK])
    contact = calibrated_contact(inputs, params.cases[-1])
    limit = float(capture_velocity(contact))
    return contact.replace(
        adhesion_damping=contact.adhesion_damping_at(limit),
        adhesion_rate_exponent=params.another_rate_exponent,
        reference_velocity=limit,
    )


def rows(
    params: Averaged,
    inputs: Tables,
    constants: tuple[float, ...],
    highest: float,
    seed: int,
    confidence: float,
    chosen: Sequence[Design],
) -> list[Row]:
    """Fit the data sets of some designs, a row each; v_c in units of the true one.

    `constants`: k, p, kappa, q, v_c of Eq. (34), m/s; `highest`: speed in v_c.
    """
    measured: list[tuple[FloatArray, FloatArray, float]] = []
    for design in chosen:
        ratio = np.geomspace(design.lowest, highest, design.points)
        if design.truth == "Eq. 34":
            curve = restitution(ratio * constants[-1], *constants)
        else:
            contact = true_contact(params, inputs, design.truth)
            curve = simulate(contact, ratio * capture_velocity(contact)).coefficient_of_restitution
        noise = design.noise * standard_noise(seed, MEASUREMENTS, design.points, params.sets)
        e, seen = observed(curve, noise, "rebounds")
        # Nobody reports more than all.
        e = np.minimum(e, 1.0)
        measured += [(ratio[of], own[of], design.noise) for own, of in zip(e, seen, strict=True)]
    found = iter(compare_sets(measured, confidence=confidence))
    return [_row(design, list(islice(found, params.sets))) for design in chosen]


def _row(design: Design, found: list[Comparison]) -> Row:
    ends = np.array([of.v_c_interval for of in found])
    holds = (ends[:, 0] <= 1.0) & (ends[:, 1] >= 1.0)
    warned = np.array([bool(of.warnings) for of in found])
    low, high = wilson_interval(int(holds.sum()), len(found))
    return {
        "truth": design.truth,
        "noise_of_e": design.noise,
        "points": design.points,
        "lowest_speed_in_v_c": design.lowest,
        "sets": len(found),
        "held": int(holds.sum()),
        "coverage": float(holds.mean()),
        "coverage_low": low,
        "coverage_high": high,
        "median_width": float(np.median(np.diff(ends))),
        "warned": float(warned.mean()),
        "missed_without_warning": int(np.sum(~holds & ~warned)),
        "evidence": "virtual experiment",
    }


def figure_data(table: pd.DataFrame, confidence: float) -> pd.DataFrame:
    """Coverage and median width over the lowest speed, by truth, of all noises and points."""
    frame, frames = partial(series_frame, x_unit="1", y_unit="1"), []
    for truth, own in table.groupby("truth", sort=False):
        parts = own.groupby("lowest_speed_in_v_c")
        x = np.array(list(parts.groups), dtype=float)
        held, sets = parts["held"].sum(), parts["sets"].sum()
        ends = np.array([wilson_interval(*pair) for pair in zip(held, sets, strict=True)]).T
        name, kind = str(truth), "virtual experiment"
        frames.append(frame("coverage", name, x, held / sets, kind, *ends))
        frames.append(frame("width", name, x, parts["median_width"].median(), kind))
    x = table["lowest_speed_in_v_c"].agg(["min", "max"]).to_numpy(float)
    return pd.concat([*frames, frame("coverage", "nominal", x, confidence)], ignore_index=True)
