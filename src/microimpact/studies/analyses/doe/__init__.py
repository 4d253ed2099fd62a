"""Designed experiments on the capture velocity (Section 4.3, Figs. 24 and 25)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.core.tables import Row, Tables
from microimpact.declared.parameters import CaseName, Keyed, Name, Positive, PrintedName
from microimpact.lab.contacts import all_printed, calibrated_contact
from microimpact.model.contact import Contact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.empirical.search import data_sets, fit_batch
from microimpact.statistics.effects import (
    defining_relation,
    fractional_factorial,
    full_factorial,
)
from microimpact.studies.analyses.doe.factors import (
    FACTORS,
    LETTERS,
    Levels,
    at_levels,
    coded,
    elasticities,
    factor_values,
    realistic_levels,
)
from microimpact.studies.analyses.doe.tables import (
    DesignedExperiment,
    alias_rows,
    bd_aliasing,
    effect_rows,
    figure_frame,
)

NEEDS = {"calibration": ("calibration", "calibration_family")}

# Place of this study among the random draws of one seed.
ANALYSIS = 24
FIGURES = {"realistic": "fig24", "uniform": "fig25"}

OpenFraction = Annotated[float, Field(gt=0, lt=1)]


@dataclass(frozen=True, slots=True, kw_only=True)
class DesignedCase:
    """A calibrated contact: designs are run with it, or its elasticities are taken alone."""

    case: CaseName
    designed: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class FitSampling:
    """How restitution is sampled to find the capture velocity by a fit of Eq. (34).

    Speeds are multiples of the run's capture velocity, one drawn at random in each of so many equal
    steps of the logarithm.
    """

    fitted_from: Annotated[float, Field(gt=1)]
    fitted_to: Annotated[float, Field(gt=1)]
    points: Annotated[int, Field(ge=8)]
    replicates: Annotated[int, Field(ge=2)]

    def __post_init__(self) -> None:
        """Refuse an empty range."""
        if self.fitted_from >= self.fitted_to:
            raise ValueError(
                f"fitted_from {self.fitted_from:g} must be below fitted_to {self.fitted_to:g}"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """The cases, the design, and the levels.

    ``diameters_um`` are the ends of a sieve class; ``anchors`` names the printed small variation.
    """

    seed: Annotated[int, Field(ge=0)]
    cases: Annotated[tuple[DesignedCase, ...], Keyed("case")]
    drawn_case: CaseName
    generator: Name
    confidence: OpenFraction
    diameters_um: tuple[Positive, Positive]
    anchors: tuple[PrintedName]
    sampling: FitSampling

    def __post_init__(self) -> None:
        """Refuse a generator that confounds factors, and a drawn case without a design."""
        defining_relation(self.generator, LETTERS)
        designed = [case.case for case in self.cases if case.designed]
        if self.drawn_case not in designed:
            raise ValueError(
                f"drawn_case: {self.drawn_case!r} must be a designed case:"
                f" {', '.join(designed) or 'there is none'}"
            )


def run(params: Params, inputs: Tables) -> Tables:
    """Run every design and analyse it.

    ``doe_levels``, ``doe_design``: levels and runs of the full design with their capture velocities
    in m/s, run 0 at the nominal values. ``doe_aliases``: what the fraction cannot tell apart.
    ``doe_effects``: effects in % of the mean, or of 0.01 in ln v_c. ``doe_bd_aliasing``: BD in
    every quarter fraction. ``doe_elasticities``: exact slopes. ``fig24``, ``fig25``: effects drawn.
    Raises ValueError, naming the first run without a finite capture velocity.
    """
    experiments = list(_experiments(params, inputs))
    effects = pd.DataFrame([row for each in experiments for row in effect_rows(each)])
    slopes = pd.DataFrame(_elasticity_rows(params, inputs))
    drawn = {
        FIGURES[each.variation]: figure_frame(each, effects)
        for each in experiments
        if each.case == params.drawn_case
    }
    return {
        "doe_levels": pd.DataFrame([row for each in experiments for row in _level_rows(each)]),
        "doe_design": pd.concat([_design_table(each) for each in experiments], ignore_index=True),
        "doe_aliases": pd.DataFrame(alias_rows(experiments[0].relation)),
        "doe_effects": effects,
        "doe_bd_aliasing": pd.DataFrame([r for each in experiments for r in bd_aliasing(each)]),
        "doe_elasticities": slopes,
    } | drawn


def _experiments(params: Params, inputs: Tables) -> Iterator[DesignedExperiment]:
    """Yield each case with each set of levels, its runs made."""
    share = float(all_printed(inputs)[params.anchors[0]]) / 100.0
    small = Levels(**{name: (1.0 - share, 1.0 + share) for name, _ in FACTORS.values()})
    number = 0
    for case in params.cases:
        if not case.designed:
            continue
        contact = calibrated_contact(inputs, case.case)
        wide = realistic_levels(contact, params.diameters_um, inputs)
        for variation, levels in {"realistic": wide, "uniform": small}.items():
            yield _experiment(params, case.case, variation, contact, levels, number)
            number += 1


def _experiment(
    params: Params, case: str, variation: str, contact: Contact, levels: Levels, number: int
) -> DesignedExperiment:
    full, fraction = full_factorial(len(LETTERS)), fractional_factorial(params.generator)
    centre = np.zeros((1, len(LETTERS)))
    contacts = at_levels(contact, coded(levels.array, np.concatenate([centre, full])))
    response = capture_velocity(contacts)
    _require_finite(case, variation, response)
    runs = (fraction > 0.0) @ 2 ** np.arange(len(LETTERS))
    seeds = [
        np.random.SeedSequence(params.seed, spawn_key=(ANALYSIS, number, int(run))) for run in runs
    ]
    sampled = at_levels(contact, coded(levels.array, full[runs, None, None]))
    fitted = _fitted(sampled, response[1 + runs], params.sampling, seeds)
    return DesignedExperiment(
        case=case,
        variation=variation,
        contact=contact,
        contacts=contacts,
        levels=levels.array,
        relation=defining_relation(params.generator, LETTERS),
        full=full,
        runs=runs,
        centre=float(response[0]),
        response=response[1:],
        fitted=fitted,
        confidence=params.confidence,
    )


def _require_finite(case: str, variation: str, response: FloatArray) -> None:
    bad = np.flatnonzero(~(np.isfinite(response) & (response > 0.0)))
    if bad.size:
        raise ValueError(
            f"doe: {case!r}, {variation} levels: run {bad[0]} has no finite, positive capture"
            f" velocity ({response[bad[0]]} m/s); nominal values are run 0, the others are in"
            f" standard order of {', '.join(LETTERS)}"
        )


def _fitted(
    contact: Contact,
    limits: FloatArray,
    sampling: FitSampling,
    seeds: Sequence[np.random.SeedSequence],
) -> FloatArray:
    """Return capture velocities by fits of Eq. (34), shape (replicates, runs), m/s.

    `contact`: the runs' contacts, shape (runs, 1, 1); `limits`, `seeds`: capture velocity of each
    run, m/s, and seed of its speeds; `sampling`: how many speeds, and where.
    """
    shape = sampling.replicates, sampling.points
    draws = [np.random.Generator(np.random.PCG64(seed)).random(shape) for seed in seeds]
    steps = np.arange(sampling.points) + np.stack(draws)
    span = np.log(sampling.fitted_to / sampling.fitted_from)
    speed = limits[:, None, None] * sampling.fitted_from * np.exp(span * steps / sampling.points)
    e = normal_impact(contact, speed).coefficient_of_restitution
    sets = data_sets(speed.reshape(-1, sampling.points), e.reshape(-1, sampling.points), 1.0)
    return fit_batch(sets).v_c.reshape(len(seeds), -1).T


def _level_rows(each: DesignedExperiment) -> Iterator[Row]:
    nominal = factor_values(each.contact)
    for column, (letter, (name, unit)) in enumerate(FACTORS.items()):
        low, high = each.levels[:, column]
        value = float(nominal[letter])
        yield {
            "case": each.case,
            "variation": each.variation,
            "factor": letter,
            "name": name,
            "low_multiple": low,
            "high_multiple": high,
            "nominal": value,
            "low": low * value,
            "high": high * value,
            "unit": unit,
        }


def _design_table(each: DesignedExperiment) -> pd.DataFrame:
    design = np.concatenate([np.zeros((1, len(LETTERS))), each.full]).astype(int)
    fits = np.full((2, len(design)), np.nan)
    fits[:, 1 + each.runs] = each.fitted.mean(axis=0), each.fitted.std(axis=0, ddof=1)
    contacts = each.contacts
    values = {
        f"{name}_{unit.replace('/', '_per_').replace('-', '1')}": np.asarray(value)
        for (name, unit), value in zip(
            FACTORS.values(), factor_values(contacts).values(), strict=True
        )
    }
    response = np.concatenate([[each.centre], each.response])
    return pd.DataFrame(
        {"case": each.case, "variation": each.variation, "run": range(len(design))}
        | {"in_fraction": np.isin(np.arange(len(design)) - 1, each.runs)}
        | {letter: design[:, i] for i, letter in enumerate(LETTERS)}
        | values
        | {
            "adhesion_damping_s_per_m": contacts.adhesion_damping,
            "hertz_damping_s_per_m": contacts.hertz_damping,
            "capture_velocity_m_per_s": response,
            "ln_capture_velocity": np.log(response),
            "fitted_capture_velocity_m_per_s": fits[0],
            "fitted_standard_deviation_m_per_s": fits[1],
            "evidence": "computed",
        }
    )


def _elasticity_rows(params: Params, inputs: Tables) -> Iterator[Row]:
    for case in params.cases:
        contact = calibrated_contact(inputs, case.case)
        found = elasticities(contact)
        columns = zip(found.at_fixed_zeta, found.at_fixed_damping, strict=True)
        for letter, (zeta, damping) in zip(LETTERS, columns, strict=True):
            yield {
                "case": case.case,
                "factor": letter,
                "name": FACTORS[letter][0],
                "at_fixed_zeta": zeta,
                "at_fixed_damping": damping,
                "unit": "-",
                "evidence": "computed",
            }
