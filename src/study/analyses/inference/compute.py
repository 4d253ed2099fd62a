"""Inference of a contact from the article's statements, by several laws at once.

Every law has broad ranges of its free parameters; one pool of draws per law, weighed by the
statements that a scenario trusts, gives its evidence, the capture velocity, adhesion's share of the
loss and the parameters. Leaving a statement out, or another choice, weighs the same pool again.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from statistics import NormalDist
from typing import Annotated, get_args

import numpy as np
import pandas as pd
import scipy
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.core.ensemble import resampled
from microimpact.core.solve import IntArray
from microimpact.model.choices import INTERVAL
from microimpact.model.contact import Contact
from microimpact.model.dynamics.normal import losses, normal_impact
from microimpact.statistics import importance
from microimpact.statistics.distributions import generator
from study.analyses.inference.case import (
    Case,
    Judged,
    LawPrior,
    Likelihood,
    Parameter,
    Scenario,
    counted,
)
from study.analyses.inference.drawn import bands, intervals
from study.analyses.inference.statements import (
    FRICTIONAL,
    TURNING,
    UNLIKELY,
    Values,
    values_of,
)
from study.contacts import ALL_LAWS, DRAWN, of_kind
from study.declared.documents import entries
from study.declared.parameters import Count, Name, Points, Seed
from study.tables import Row, Tables, series_frame

NEEDS = {"calibration": ("calibration",)}

# Scenarios whose contacts are shown against the speed.
SHOWN = ("without the printed v_c", "with the printed v_c")
COLUMNS = ("low", "median", "high")
# Free parameters for which ``first`` is; with each one less, half as many contacts are drawn, but
# not less than a quarter.
AXES, FEWEST = 5, 2
# What is summarised besides the free parameters.
OUTCOMES = ("v_c_m_per_s", "size_exponent", "restitution", "adhesion_share")
# Parameters of the ring force; what is not free is as declared.
RING = (
    "work_of_adhesion_J_per_m2",
    "hertz_damping_s_per_m",
    "adhesion_damping_s_per_m",
    "rate_exponent",
    "friction",
)
# Ends of what is likely by the likelihood alone: 95 % of chi square with one degree of freedom.
LIKELY = 0.5 * NormalDist().inv_cdf(0.975) ** 2
LIKELY_ENDS = ("likely_low", "likely_high")
# Classes of the capture velocity per decade, and how far down the likelihood is shown.
PROFILE, DEPTH = 20, 6.0
# Laws are preferred whose evidence is within this factor of the greatest (Kass and Raftery 1995).
STRONG = np.log(20.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Pairs, and the effort.

    ``first`` is the binary logarithm of the number of contacts spread over the ranges.
    """

    seed: Seed
    first: Annotated[int, Field(ge=6, le=18)]
    rounds: Count
    draws: Count
    points: Points  # Of a curve
    pairs: dict[Name, Case]


def declared_names(branch: Mapping[str, object]) -> dict[str, tuple[str, set[str]]]:
    """Return the names of pairs, scenarios and laws, by sort: where it is declared, and the names.

    The branch is as it stands in the files, right or wrong.
    """
    pairs = entries(branch.get("pairs"))
    names = {
        sort: {
            *beyond,
            *(name for each in pairs.values() for name in entries(entries(each).get(sort))),
        }
        for sort, beyond in (("scenarios", ()), ("laws", (ALL_LAWS,)))
    }
    places = {sort: (f"inference.pairs.{sort}", found) for sort, found in names.items()}
    return {**places, "inference.pairs": ("inference.pairs", set(pairs))}


@dataclass(frozen=True, slots=True, kw_only=True)
class Weighed:
    """A pool of contacts of one law, weighed by a scenario."""

    law: str
    judged: Judged
    scenario: Scenario
    likelihood: Likelihood
    weights: FloatArray  # Their sum is one (n,)
    result: importance.Integral  # Evidence

    @property
    def values(self) -> Values:
        """Values of the contacts."""
        return self.judged.values


def run(params: Params, inputs: Tables) -> Tables:
    """Infer the contact of every case by every law, in every scenario.

    ``evidence_summary``: by case, scenario, law: quantities, evidence, probability of the law.
    ``evidence_statements``: what each statement says, and what the contacts have.
    ``posterior_contacts``: draws of the contacts by scenario and law that it does not exclude.
    ``evidence_limits``, ``evidence_works``, ``capture_velocity_summary``: intervals of the first
    case; ``capture_velocity_profile``: likelihood alone. ``posterior_bands``: e against the speed.
    `inputs`: ``materials``, ``contacts``: the declared rows of the pairs; ``calibration``: contacts
    shown beside the bands.
    """
    summaries, statements, contacts, likelihoods = [], [], [], []
    for name, case in params.pairs.items():
        pools = {law: pool_of(case, law, inputs, params) for law in case.laws}
        known = {k: Judged(case, case.laws[k], dict(pool.record)) for k, pool in pools.items()}
        for kind, row, scenario in case.rows():
            weighed = [weigh(law, known[law], scenario, pools[law]) for law in pools]
            head: Row = {"case": name, "kind": kind, "scenario": row}
            summaries += (summarised := summary(head, case, weighed))
            if kind == "scenario":
                statements += [row for each in weighed for row in statement_rows(head, case, each)]
                excluded = {row["law"] for row in summarised if row.get("standing") == "excluded"}
                kept = [each for each in weighed if each.law not in excluded]
                contacts += [drawn(head, case, each, params) for each in kept]
                if row in SHOWN and name == next(iter(params.pairs)):
                    likelihoods.append(profiles(row, kept))
    table, contacts_drawn = pd.DataFrame(summaries), pd.concat(contacts, ignore_index=True)
    shown = table["scenario"].isin(SHOWN) & table["standing"].isin(["preferred", "consistent"])
    curves = []
    for name, case in params.pairs.items():
        rows = table[shown & (table["case"] == name)]
        laws = set(rows["scenario"] + "; " + rows["law"])
        curves.append(bands(name, case, contacts_drawn, inputs, laws, params.points))
    first, case = next(iter(params.pairs.items()))
    return {
        "evidence_summary": table,
        "evidence_statements": pd.DataFrame(statements),
        "posterior_contacts": contacts_drawn,
        "capture_velocity_profile": pd.concat(likelihoods, ignore_index=True),
        "posterior_bands": pd.concat(curves, ignore_index=True),
        **intervals(case, table[table["case"] == first]),
    }


def values_at(case: Case, law: LawPrior, inputs: Tables, points: FloatArray) -> Values:
    """Return the values of contacts of a law at points of the unit cube (n, axes)."""
    bare, classes = case.bare(inputs), np.array(case.classes_um)
    parameters = law.parameters(points)
    if law.law == "ring force":
        known = {name: np.asarray(getattr(bare, DRAWN[name])) for name in RING}
        spread = {name: np.broadcast_to(value, len(points)) for name, value in known.items()}
        parameters = spread | parameters

    def contacts(diameters: FloatArray, rows: IntArray | slice = slice(None)) -> Contact:
        columns = {key: value[rows, None] for key, value in parameters.items()}
        return of_kind(bare.replace(diameter=diameters * 1e-6), law.law, columns)

    error = case.normal_error(next(iter(case.scenarios.values())))
    values = values_of(case.statements, contacts, case.friction_bases(law), classes, error)
    at_size = contacts(np.array([case.diameter_um]))
    impact = normal_impact(at_size, case.speed_m_per_s)
    limits = values["capture"]
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.log(limits[:, -1] / limits[:, 0]) / np.log(classes[-1] / classes[0])
    outcomes = {
        "v_c_m_per_s": limits[:, case.classes_um.index(case.diameter_um)],
        "size_exponent": slope,
        "restitution": impact.coefficient_of_restitution[:, 0],
        "adhesion_share": losses(at_size, case.speed_m_per_s).adhesion_share[:, 0],
    }
    return values | parameters | outcomes


def pool_of(case: Case, name: str, inputs: Tables, params: Params) -> importance.Pool:
    """Draw contacts of a law where any scenario, omission or choice finds them likely."""
    law, rows = case.laws[name], list(case.rows())

    def logs_of(values: importance.Record) -> FloatArray:
        judged = Judged(case, law, dict(values))
        return np.stack(
            [
                judged.likelihood(scenario).total + law.log_prior(scenario, judged.values)
                for *_, scenario in rows
            ],
            axis=1,
        )

    def log_densities(known: FloatArray) -> FloatArray:
        columns: dict[str, FloatArray] = {}
        heights: dict[str, float] = {}
        for (kind, row, _), logs in zip(rows, known.T, strict=True):
            # What is left without one statement or another is one density, broader than the rest,
            # and so is what other choices leave.
            name, height = row if kind == "scenario" else kind, float(np.max(logs))
            columns[name] = np.maximum(columns.get(name, -np.inf), logs - height)
            heights[name] = max(heights.get(name, -np.inf), height)
        # A scenario without hope gets no draws from the others.
        least = max(heights.values()) - UNLIKELY
        return np.stack([logs for name, logs in columns.items() if heights[name] > least], axis=1)

    return importance.pool(
        partial(values_at, case, law, inputs),
        logs_of,
        log_densities,
        len(law.ranges),
        first=params.first - min(max(AXES - len(law.ranges), 0), FEWEST),
        rounds=params.rounds,
        rng=generator(params.seed, list(case.laws).index(name)),
    )


def weigh(law: str, judged: Judged, scenario: Scenario, pool: importance.Pool) -> Weighed:
    """Weigh the pool of a law by a scenario."""
    likelihood = judged.likelihood(scenario)
    prior = judged.law.log_prior(scenario, judged.values)
    total = np.where(np.isfinite(prior), likelihood.total, -np.inf)
    logs = pool.log_weights(total + prior)
    return Weighed(
        law=law,
        judged=judged,
        scenario=scenario,
        likelihood=replace(likelihood, total=total),
        weights=scipy.special.softmax(logs),
        result=importance.integral(logs, pool.tried),
    )


def summary(head: Row, case: Case, weighed: list[Weighed]) -> list[Row]:
    """Return the quantities of a scenario by each law, and by all of them."""
    evidence = np.array([each.result.log for each in weighed])
    probability = scipy.special.softmax(evidence)
    rows: list[Row] = []
    for each, share in zip(weighed, probability, strict=True):
        names = counted(case, each.scenario)
        missed = {name: each.judged.misses(each.scenario, name) for name in names}
        is_preferred = each.result.log > np.max(evidence) - STRONG
        known = np.isfinite(each.likelihood.total)
        can_be = is_preferred or np.any(known & ~np.any(list(missed.values()), axis=0))
        best = int(np.argmax(each.likelihood.total))
        of_law: Row = {
            **head,
            "law": each.law,
            "standing": "preferred" if is_preferred else "consistent" if can_be else "excluded",
            "missed": "; ".join(name for name, is_missed in missed.items() if is_missed[best]),
            "probability": share,
            "ln_evidence": each.result.log,
            "ln_evidence_error": each.result.error,
            "effective_size": each.result.effective_size,
        }
        # An excluded law has a row that says so.
        named = OUTCOMES[:1] if of_law["standing"] == "excluded" else quantities(case, each)
        values = {name: each.values[name] for name in named}
        rows += quantiles(of_law, values, each.weights, each.likelihood.total)
    # Over the laws only what all of them have.
    names_of_all = set.intersection(*(set(quantities(case, each)) for each in weighed))
    pooled = {
        name: np.concatenate([each.values[name] for each in weighed])
        for name in quantities(case, weighed[0])
        if name in names_of_all
    }
    shares = zip(weighed, probability, strict=True)
    weights = np.concatenate([each.weights * share for each, share in shares])
    likelihoods = np.concatenate([each.likelihood.total for each in weighed])
    over_all: Row = {"law": ALL_LAWS, "probability": 1.0, "effective_size": 1 / np.sum(weights**2)}
    return rows + quantiles({**head, **over_all}, pooled, weights, likelihoods)


def quantities(case: Case, weighed: Weighed) -> tuple[str, ...]:
    """Names of the quantities of a law's contacts that are summarised."""
    return (*OUTCOMES, *map(str, case.laws[weighed.law].ranges))


def quantiles(
    head: Row, values: Mapping[str, FloatArray], weights: FloatArray, likelihoods: FloatArray
) -> list[Row]:
    """Return quantiles of a weighted sample by quantity, and ends of the likelihood.

    The latter are the ends of the values whose log likelihood, the greatest of all contacts with
    them (profile), is within `LIKELY` of the greatest of all.
    """
    likely = likelihoods > np.max(likelihoods) - LIKELY
    rows = []
    for name, value in values.items():
        among = value[likely & np.isfinite(value)]
        ends = (np.min(among), np.max(among)) if among.size else (np.nan, np.nan)
        each = zip(COLUMNS + LIKELY_ENDS, (*weighted(value, weights), *ends), strict=True)
        rows.append({**head, "quantity": name, **dict(each)})
    return rows


def profiles(scenario: str, weighed: list[Weighed]) -> pd.DataFrame:
    """Return the profile likelihood of the capture velocity by each law: no prior is in it.

    The greatest log likelihood of all contacts with a capture velocity, less the greatest by any
    law, in `PROFILE` classes a decade. Open angles, sizes and bases of friction are averaged over.
    """
    greatest = max(float(np.max(each.likelihood.total)) for each in weighed)
    frames = []
    for each in weighed:
        limit, log = each.values["v_c_m_per_s"], each.likelihood.total - greatest
        known = (limit > 0.0) & (log > -DEPTH)
        classes = np.floor(PROFILE * np.log10(limit[known]))
        best = pd.Series(log[known]).groupby(classes).max()
        middle = 10.0 ** ((best.index.to_numpy(float) + 0.5) / PROFILE)
        frame = partial(series_frame, scenario, each.law, x_unit="m_per_s", y_unit="1")
        frames.append(frame(middle, best.to_numpy(float)))
    return pd.concat(frames, ignore_index=True)


def weighted(value: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the quantiles `INTERVAL` of a weighted sample; rows without a value do not count."""
    known = np.isfinite(value) & (weights > 0.0)
    if not np.any(known):
        return np.full(len(INTERVAL), np.nan)
    return np.quantile(value[known], INTERVAL, weights=weights[known], method="inverted_cdf")


def statement_rows(head: Row, case: Case, weighed: Weighed) -> list[Row]:
    """Return each statement beside the values of the contacts of a scenario and law.

    A statement that the scenario leaves out has a row, too: what the contacts predict for it.
    """
    share = scipy.special.softmax(weighed.likelihood.by_basis, axis=1)
    error, known = case.normal_error(weighed.scenario), counted(case, weighed.scenario)
    rows: list[Row] = []
    for name, statement in case.statements.items():
        value, weights = weighed.values[name], weighed.weights
        turning = np.broadcast_to(weighed.values.get(TURNING + name, np.zeros(1)), value.shape)
        if value.ndim == 2:
            each = np.full(value.shape, 1.0 / value.shape[1])
            if statement.quantity in FRICTIONAL:
                each = share
            elif name in known:  # the open angle or size, by what it says
                each = scipy.special.softmax(weighed.judged.log(weighed.scenario, name), axis=1)
            value, turning = value.ravel(), turning.ravel()
            weights = (weights[:, None] * each).ravel()
        low, high = statement.interval
        rows.append(
            {
                **head,
                "law": weighed.law,
                "statement": name,
                "words": statement.words,
                "standing": statement.standing,
                "counts": "yes" if name in known else "no",
                "quantity_stated": statement.quantity,
                "interval_low": low,
                "interval_high": high,
                "tail": statement.tail,
                "angle_error": error * weighted(turning, weights)[1],
                **dict(zip(COLUMNS, weighted(value, weights), strict=True)),
                "share_inside": np.sum(weights * ((low <= value) & (value <= high))),
            }
        )
    return rows


def drawn(head: Row, case: Case, weighed: Weighed, params: Params) -> pd.DataFrame:
    """Return draws of a law's contacts in a scenario, with a basis of friction each."""
    law, rng = case.laws[weighed.law], generator(params.seed, 1)
    taken = resampled(weighed.weights, params.draws, rng)
    logs = weighed.likelihood.by_basis[taken]
    chance = np.exp(logs - logs.max(axis=1, keepdims=True))
    below = np.cumsum(chance, axis=1)
    basis = np.argmax(below > rng.random((len(taken), 1)) * below[:, -1:], axis=1)
    return pd.DataFrame(
        {
            "case": head["case"],
            "scenario": head["scenario"],
            "law": weighed.law,
            "contact_law": law.law,
            "draw": np.arange(params.draws),
            "effective_size": weighed.result.effective_size,
            "particle": case.particle,
            "surface": case.surface,
            "diameter_um": case.diameter_um,
            "reference_velocity_m_per_s": case.speed_m_per_s,
            "friction_basis": np.array(case.friction_bases(law))[basis],
            **{
                name: value[taken]
                for name, value in weighed.values.items()
                if name in (*get_args(Parameter), *OUTCOMES)
            },
        }
    )
