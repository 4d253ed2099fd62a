"""Designed experiments on the capture velocity (Section 4.3, Figs. 24 and 25)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import product as combinations
from typing import Annotated, Any, Literal

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from pydantic import Field

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.computable import NotComputable
from microimpact.model.contact import Contact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.empirical.data import data_sets
from microimpact.model.empirical.search import fit_batch
from microimpact.statistics.effects import (
    aliases,
    defining_relation,
    effects,
    fractional_factorial,
    full_factorial,
    half_normal_positions,
    lenth,
    normal_positions,
    product,
    quarter_fractions,
)
from study.analyses.fig24_25_doe.factors import (
    FACTORS,
    LETTERS,
    NAMES,
    Levels,
    about_one,
    at_levels,
    coded,
    elasticities,
    factor_values,
    realistic_levels,
)
from study.contacts import all_printed, calibrated_contact
from study.declared.parameters import CaseName, Fraction, Must, Name, Positive
from study.tables import Row, Tables, series_frame

NEEDS = {"calibration": ("calibration", "calibration_family")}
PRINTED_VALUES = ("doe_small_variation",)

# Place of this study among the random draws of one seed.
ANALYSIS = 24
# Measurements begin above capture; they end as for Fig. 16, in capture velocities of the run.
FITTED = (1.1, 15.0)
# Letters of an interaction of two factors: effects of more are taken to be small.
PAIR = 2
FIGURES = {"realistic": "fig24", "uniform": "fig25"}

_frame = partial(series_frame, x_unit="percent", y_unit="1")


@dataclass(frozen=True, slots=True, kw_only=True)
class FitSampling:
    """How restitution is sampled to find the capture velocity by a fit of Eq. (34).

    Speeds lie within `FITTED`: `points` equal steps of the logarithm, a random speed in each.
    """

    points: Annotated[int, Field(ge=8, le=10_000)]
    replicates: Annotated[int, Field(ge=2, le=10_000)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """The cases, the design, and the levels.

    ``diameters_um`` are the ends of a sieve class. ``levels`` are half-ranges of factors by name,
    as 0.1 for levels of 0.9 and 1.1 of the nominal value, in place of the realistic ones.
    """

    seed: Annotated[int, Field(ge=0)]
    cases: Annotated[tuple[CaseName, ...], Field(min_length=1)]
    drawn_case: Annotated[CaseName, Must("one of", "cases")]
    generator: Name
    diameters_um: tuple[Positive, Positive]
    sampling: FitSampling
    levels: dict[Literal[NAMES], Fraction] = field(default_factory=dict)  # type: ignore[valid-type]

    def __post_init__(self) -> None:
        """Refuse a generator that confounds factors."""
        defining_relation(self.generator, LETTERS)


def run(params: Params, inputs: Tables) -> Tables:
    """Run every design and analyse it.

    ``doe_levels``, ``doe_design``: levels and runs of the full design with their capture velocities
    in m/s, run 0 at the nominal values. ``doe_effects``: effects in % of the mean, or of 0.01 in
    ln v_c, with what the fraction cannot tell apart. ``doe_bd_aliasing``: BD in every quarter
    fraction. ``doe_elasticities``: exact slopes. ``fig24``, ``fig25``: effects drawn.
    Raises ValueError, naming the first run without a finite capture velocity.
    """
    experiments = list(_experiments(params, inputs))
    effect_rows = pd.concat([effect_table(each) for each in experiments], ignore_index=True)
    tables = {
        "doe_levels": [_level_table(each) for each in experiments],
        "doe_design": [_design_table(each) for each in experiments],
        "doe_bd_aliasing": [pd.DataFrame(bd_aliasing(each)) for each in experiments],
        "doe_elasticities": [_elasticity_table(case, inputs) for case in params.cases],
    }
    drawn = {
        FIGURES[each.variation]: figure_frame(each, effect_rows)
        for each in experiments
        if each.case == params.drawn_case
    }
    return {name: pd.concat(parts, ignore_index=True) for name, parts in tables.items()} | {
        "doe_effects": effect_rows,
        **drawn,
    }


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DesignedExperiment:
    """One case with one set of levels."""

    # Which contact, and which set of levels.
    case: str
    variation: str
    # The nominal contact, and those of all runs: the nominal one first, then the full design.
    contact: Contact
    contacts: Contact
    levels: FloatArray  # Multiples of the nominal values, shape (2, 5)
    relation: dict[str, int]  # Defining relation of the fraction
    full: FloatArray  # Coded levels of the full design, shape (32, 5)
    runs: NDArray[np.integer[Any]]  # Which of its runs are in the fraction
    # Capture velocity of the nominal contact, and of all runs of the full design, m/s.
    centre: float
    response: FloatArray
    # That of the runs in the fraction by fits of Eq. (34), shape (replicates, runs), m/s.
    fitted: FloatArray


def _experiments(params: Params, inputs: Tables) -> Iterator[DesignedExperiment]:
    """Yield each case with each set of levels, its runs made."""
    share = float(all_printed(inputs)[PRINTED_VALUES[0]]) / 100.0
    small = Levels(**about_one(dict.fromkeys(NAMES, share)))
    for turn, case in enumerate(params.cases):
        contact = calibrated_contact(inputs, case)
        wide = realistic_levels(contact, params.diameters_um, inputs, params.levels)
        yield _experiment(params, case, "realistic", contact, wide, 2 * turn)
        yield _experiment(params, case, "uniform", contact, small, 2 * turn + 1)


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
    )


def _require_finite(case: str, variation: str, response: FloatArray) -> None:
    bad = np.flatnonzero(~(np.isfinite(response) & (response > 0.0)))
    if bad.size:
        raise NotComputable(
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

    Parameters
    ----------
    contact
        The runs' contacts, shape (runs, 1, 1).
    limits, seeds
        Capture velocity of each run, m/s, and seed of its speeds.
    sampling
        How many speeds, and where.
    """
    shape = sampling.replicates, sampling.points
    draws = [np.random.Generator(np.random.PCG64(seed)).random(shape) for seed in seeds]
    steps = np.arange(sampling.points) + np.stack(draws)
    span = np.log(FITTED[1] / FITTED[0])
    speed = limits[:, None, None] * FITTED[0] * np.exp(span * steps / sampling.points)
    e = normal_impact(contact, speed).coefficient_of_restitution
    sets = data_sets(speed.reshape(-1, sampling.points), e.reshape(-1, sampling.points), 1.0)
    return fit_batch(sets).v_c.reshape(len(seeds), -1).T


def _level_table(each: DesignedExperiment) -> pd.DataFrame:
    nominal = np.array([float(value) for value in factor_values(each.contact).values()])
    low, high = each.levels
    return pd.DataFrame(
        {
            "case": each.case,
            "variation": each.variation,
            "factor": list(LETTERS),
            "name": NAMES,
            "low_multiple": low,
            "high_multiple": high,
            "nominal": nominal,
            "low": low * nominal,
            "high": high * nominal,
            "unit": [unit for _, unit in FACTORS.values()],
        }
    )


def _design_table(each: DesignedExperiment) -> pd.DataFrame:
    design = np.concatenate([np.zeros((1, len(LETTERS))), each.full]).astype(int)
    fits = np.full((2, len(design)), np.nan)
    fits[:, 1 + each.runs] = each.fitted.mean(axis=0), each.fitted.std(axis=0, ddof=1)
    contacts, values = each.contacts, factor_values(each.contacts)
    columns = {
        f"{name}_{unit.replace('/', '_per_').replace('-', '1')}": values[letter]
        for letter, (name, unit) in FACTORS.items()
    }
    response = np.concatenate([[each.centre], each.response])
    return pd.DataFrame(
        {"case": each.case, "variation": each.variation, "run": range(len(design))}
        | {"in_fraction": np.isin(np.arange(len(design)) - 1, each.runs)}
        | dict(zip(LETTERS, design.T, strict=True))
        | columns
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


def _elasticity_table(case: str, inputs: Tables) -> pd.DataFrame:
    elasticity = elasticities(calibrated_contact(inputs, case))
    return pd.DataFrame(
        {
            "case": case,
            "factor": list(LETTERS),
            "name": NAMES,
            "at_fixed_zeta": elasticity.at_fixed_zeta,
            "at_fixed_damping": elasticity.at_fixed_damping,
            "unit": "-",
            "evidence": "computed",
        }
    )


def _signed(words: Mapping[str, int], between: str = " ") -> str:
    return between.join(("-" if sign < 0 else "") + word for word, sign in words.items())


def _inseparable(effect: str, aliases: str) -> str:
    """Return an effect and the factors and pairs of factors whose effects are in it, too."""
    short = (word for word in aliases.split() if len(word.lstrip("-")) <= PAIR)
    return effect + "".join(word if word.startswith("-") else f"+{word}" for word in short)


def effect_table(each: DesignedExperiment) -> pd.DataFrame:
    """Return the effects of each response over the fraction, and of exact ones over all runs.

    They are in % of the mean response, or in hundredths of 1 in ln v_c. Beside them the standard
    deviation over replicates.
    """
    exact, everything = each.response, np.arange(len(each.full))
    none: dict[str, int] = {}
    fraction, full = ("fraction", each.runs, each.relation), ("full", everything, none)
    cells = [
        (fraction, "v_c", exact[None, each.runs]),
        (fraction, "ln v_c", np.log(exact[None, each.runs])),
        (fraction, "v_c by Eq. 34", each.fitted),
        (full, "v_c", exact[None]),
        (full, "ln v_c", np.log(exact[None])),
    ]
    tables = []
    for (name, runs, relation), response, values in cells:
        classes = aliases(relation, LETTERS)
        percent = _percent(each.full[runs], list(classes), values, logarithmic=response == "ln v_c")
        mean = percent.mean(axis=0)
        margins = lenth(mean)
        columns = {
            "case": each.case,
            "variation": each.variation,
            "design": name,
            "response": response,
            "effect": list(classes),
            "aliases": [_signed(others) for others in classes.values()],
            "effect_percent": mean,
            "pseudo_error_percent": percent.std(axis=0, ddof=1) if len(percent) > 1 else np.nan,
            "lenth_pseudo_error_percent": margins.pseudo_error,
            "margin_percent": margins.margin,
            "simultaneous_margin_percent": margins.simultaneous,
            "normal_quantile": normal_positions(mean),
            "half_normal_quantile": half_normal_positions(mean),
            "evidence": "computed",
        }
        tables.append(pd.DataFrame(columns))
    return pd.concat(tables, ignore_index=True)


def _percent(
    design: FloatArray, words: list[str], values: FloatArray, *, logarithmic: bool
) -> FloatArray:
    """Effects in % of the mean response; of a logarithm, in hundredths."""
    contrasts = effects(design, LETTERS, words, values)
    return 100.0 * (contrasts if logarithmic else contrasts / values.mean(axis=-1, keepdims=True))


def bd_aliasing(each: DesignedExperiment) -> Iterator[Row]:
    """Yield the apparent effect BD in every quarter fraction, all choices of signs."""

    def percent(runs: BoolArray) -> float:
        response = each.response[runs]
        (effect,) = effects(each.full[runs], LETTERS, ["BD"], response) / response.mean()
        return float(100.0 * effect)

    whole = percent(np.ones(len(each.full), bool))
    for (first, second), (sign_of_first, sign_of_second) in combinations(
        quarter_fractions(LETTERS), combinations((1, -1), repeat=2)
    ):
        relation = {
            first: sign_of_first,
            second: sign_of_second,
            product(first, second): sign_of_first * sign_of_second,
        }
        columns = {w: each.full[:, [LETTERS.index(c) for c in w]].prod(axis=1) for w in relation}
        kept = np.all([columns[word] == sign for word, sign in relation.items()], axis=0)
        others = {product("BD", word): sign for word, sign in relation.items()}
        yield {
            "case": each.case,
            "variation": each.variation,
            "defining_relation": _signed({"I": 1, **relation}, " = "),
            "aliases_of_BD": _signed(others),
            "main_effect": next((word for word in others if len(word) == 1), "none"),
            "apparent_percent": percent(kept),
            "BD_percent": whole,
            "evidence": "computed",
        }


def figure_frame(each: DesignedExperiment, table: pd.DataFrame) -> pd.DataFrame:
    """Return the effects of an experiment as drawn: panels by plot, series by response and word."""
    effect_rows = table[
        (table["case"] == each.case)
        & (table["variation"] == each.variation)
        & (table["design"] == "fraction")
    ]
    frames = []
    for response, rows in effect_rows.groupby("response", sort=False):
        for panel, column, x in (
            ("normal", "normal_quantile", rows["effect_percent"]),
            ("half_normal", "half_normal_quantile", rows["effect_percent"].abs()),
        ):
            words = map(_inseparable, rows["effect"], rows["aliases"])
            for word, size, quantile in zip(words, x, rows[column], strict=True):
                frames.append(_frame(panel, f"{response}: {word}", [size], [quantile]))
            for name in ("margin", "simultaneous margin"):
                margin = rows[f"{name.replace(' ', '_')}_percent"].iloc[0]
                ends = [-margin, margin] if panel == "normal" else [margin]
                frames.append(_frame(panel, f"{response}: {name}", ends, 0.0))
    return pd.concat(frames, ignore_index=True)
