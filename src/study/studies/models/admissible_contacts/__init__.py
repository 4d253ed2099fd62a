"""All contacts that the printed statements admit, in one step, instead of two hand-picked ones.

The printed facts on a pair leave open its work of adhesion, both coefficients of damping, the rate
exponent, the size class behind some statements, and friction with its basis. Here they all vary at
once; every statement is an interval of a likelihood. The contacts drawn are the pair, for figures
and verdicts; with the printed capture velocity and without it, since its own status is in doubt.

Impacts are cheap and capture velocities are not: the ensemble draws by the statements on impacts,
and capture velocities weight a pool of its draws. Class and basis are drawn last, each in
proportion to its likelihood.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core import ensemble
from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.separation import jkr_pull_off
from study.declared.parameters import Count, Name, Seed
from study.studies.contacts import BAND, admissible_contact, calibrated_contact
from study.studies.models.admissible_contacts.case import (
    FIELDS,
    Case,
    Chosen,
    Posterior,
    Sampler,
    Variant,
    bare_contact,
    contacts,
    posterior,
    values,
)
from study.studies.models.admissible_contacts.statements import Within
from study.tables import Row, Tables, series_frame

NEEDS = {"calibration": ("calibration",)}

COLUMNS = ("low", "median", "high")
# Columns that are told.
TOLD = (*FIELDS, "restitution", "adhesion_share", "contact_time_ns", "pull_off_uN")
# Densities are shown this factor beyond the outermost draws.
BESIDE = 1.2
# Series of other things than a variant.
PRINTED, TWO_STAGE = "printed", "two-stage"


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Cases that are calibrated, the sampler, and points of the curves shown.

    Marginals and pairs are shown of the first case.
    """

    seed: Seed
    sampler: Sampler
    draws: Count
    cases: dict[Name, Case]
    variants: dict[Name, Variant]
    points: Annotated[int, Field(ge=10)]


def run(params: Params, inputs: Tables) -> Tables:
    """Draw the admissible contacts of every case.

    ``admissible_contacts``: the draws, their parameters and derived numbers, by case and variant.
    ``admissible_diagnostics``: how well they were drawn. ``admissible_summary``: medians and
    intervals, and the two-stage estimates. ``admissible_statements``: what each statement says,
    what the draws have, and what it decides. ``admissible_limits``, ``admissible_shares``,
    ``admissible_works``: marginals and pairs of the first case. ``admissible_bands``: e against the
    speed. `inputs`: ``materials``, ``contacts``: the declared rows of the pairs; ``calibration``:
    the two-stage estimates.
    """
    pairs = [
        (pool, pool.chosen(variant, left.without, params.draws))
        for name, case in params.cases.items()
        for pool in [posterior(name, case, inputs, params.sampler, params.seed)]
        for variant, left in params.variants.items()
    ]
    draws = [table(*pair, inputs) for pair in pairs]
    rows = [row for pair, drawn in zip(pairs, draws, strict=True) for row in summary(*pair, drawn)]
    rows += [row for name, case in params.cases.items() for row in two_stage(name, case, inputs)]
    summaries = pd.DataFrame(rows)[["case", "estimate", "quantity", *COLUMNS]]
    contacts_drawn = pd.concat(draws, ignore_index=True)
    known = {**inputs, "admissible_contacts": contacts_drawn}
    curves = [bands(*case, params.variants, known, params.points) for case in params.cases.items()]
    first = next(iter(params.cases.items()))
    return {
        "admissible_contacts": contacts_drawn,
        "admissible_diagnostics": pd.DataFrame([diagnostics(*pair) for pair in pairs]),
        "admissible_summary": summaries,
        "admissible_statements": pd.DataFrame([row for pair in pairs for row in told(*pair)]),
        "admissible_bands": pd.concat(curves, ignore_index=True),
        **marginals(*first, params.variants, contacts_drawn, summaries, params.points),
    }


def derived(case: Case, contact: Contact) -> dict[str, FloatArray]:
    """Return properties of contacts of any shape at the case's diameter and speed."""
    outcome = normal_impact(contact, case.speed_m_per_s, ledger=True)
    ledger, work = outcome.ledger, contact.work_of_adhesion
    assert ledger is not None
    assert work is not None
    return {
        "restitution": outcome.coefficient_of_restitution,
        "adhesion_share": ledger.adhesion_work / (ledger.adhesion_work + ledger.hertz_work),
        "contact_time_ns": outcome.contact_time * 1e9,
        "pull_off_uN": np.broadcast_to(jkr_pull_off(work, contact.radius) * 1e6, contact.shape),
    }


def table(posterior_of_case: Posterior, chosen: Chosen, inputs: Tables) -> pd.DataFrame:
    """Return the draws of one case and variant, a row each."""
    case, bare = posterior_of_case.case, bare_contact(posterior_of_case.case, inputs)
    contact = contacts(case, bare, chosen.points, np.array([case.diameter_um]))
    predictions = values(case, chosen.points)
    limits = posterior_of_case.limits[chosen.taken]
    return pd.DataFrame(
        {
            "case": posterior_of_case.name,
            "variant": chosen.variant,
            "draw": np.arange(len(limits)),
            "particle": case.particle,
            "surface": case.surface,
            **{name: predictions.get(name, getattr(bare, field)) for name, field in FIELDS.items()},
            "reference_velocity_m_per_s": case.speed_m_per_s,
            "diameter_um": np.array(case.classes_um)[chosen.classes],
            "friction_basis": np.array(case.friction_bases)[chosen.bases],
            "v_c_m_per_s": limits[np.arange(len(limits)), chosen.classes],
            "derived_at_um": case.diameter_um,
            "derived_at_m_per_s": case.speed_m_per_s,
            "v_c_derived_m_per_s": limits[:, case.classes_um.index(case.diameter_um)],
            **{name: value[:, 0] for name, value in derived(case, contact).items()},
            "log_likelihood": chosen.log_likelihood,
            "most_central": most_central(chosen.points),
        }
    )


def most_central(points: FloatArray) -> BoolArray:
    """Mark the draw with the least mean distance to all others (n,), axes in their own spread.

    The likelihood is flat where all statements hold, so its maximum may lie in any corner.
    """
    scaled = points / points.std(axis=0)
    distance = np.linalg.norm(scaled[:, None] - scaled, axis=-1).mean(axis=1)
    return np.asarray(np.arange(len(points)) == np.argmin(distance))


def diagnostics(posterior_of_case: Posterior, chosen: Chosen) -> Row:
    """Return how well the draws of one case and variant came about."""
    weights = posterior_of_case.weights(chosen.without)
    return {
        "case": posterior_of_case.name,
        "variant": chosen.variant,
        "open_parameters": len(posterior_of_case.case.ranges.open()),
        "acceptance": posterior_of_case.pool.acceptance,
        "split_r_hat": float(np.max(posterior_of_case.pool.split_r_hat)),
        "kept": posterior_of_case.pool.kept,
        "effective_size": posterior_of_case.pool.effective_size,
        "pool": len(weights),
        "effective_size_weighted": ensemble.effective_number(weights),
        "largest_weight": float(np.max(weights) / np.sum(weights)),
        "draws": len(chosen.taken),
        "different_draws": len(np.unique(chosen.taken)),
    }


def summary(posterior_of_case: Posterior, chosen: Chosen, draws: pd.DataFrame) -> list[Row]:
    """Return medians and intervals of the numbers of one case and variant."""
    case = posterior_of_case.case
    sizes = limits_by_size(case, posterior_of_case.limits[chosen.taken])
    numbers = {name: draws[name].to_numpy(float) for name in TOLD} | sizes
    names = {"case": posterior_of_case.name, "estimate": chosen.variant}
    rows: list[Row] = [
        names | {"quantity": name} | dict(zip(COLUMNS, np.quantile(value, BAND), strict=True))
        for name, value in numbers.items()
    ]
    kinds: list[tuple[str, object]] = [("diameter_um", size) for size in case.classes_um]
    kinds += [("friction_basis", basis) for basis in case.friction_bases]
    return rows + [
        names | {"quantity": f"share of {axis} {kind}", "median": np.mean(draws[axis] == kind)}
        for axis, kind in kinds
    ]


def two_stage(name: str, case: Case, inputs: Tables) -> list[Row]:
    """Return the same numbers of the two-stage estimates, which have no interval."""
    rows = []
    for compared in case.compared:
        contact = calibrated_contact(inputs, compared)
        limits = capture_velocity(resized(contact, np.array(case.classes_um) * 1e-6))
        numbers = {n: getattr(contact, field) for n, field in FIELDS.items()}
        numbers |= derived(case, contact) | limits_by_size(case, limits)
        names = {"case": name, "estimate": f"{TWO_STAGE}, {compared}"}
        rows += [names | {"quantity": n, "median": float(v)} for n, v in numbers.items()]
    return rows


def limits_by_size(case: Case, limits: FloatArray) -> dict[str, FloatArray]:
    """Capture velocities of every size class, from all of them (..., classes)."""
    names = [f"v_c_at_{d:g}_um_m_per_s" for d in case.classes_um]
    return dict(zip(names, np.moveaxis(limits, -1, 0), strict=True))


def told(posterior_of_case: Posterior, chosen: Chosen) -> list[Row]:
    """Return each statement beside the quantities of the draws of a case and variant.

    A statement that the variant leaves out is told, too: what the draws predict for it.
    """
    rows: list[Row] = []
    for name, statement in posterior_of_case.case.all_statements.items():
        value = posterior_of_case.quantities[name][chosen.taken]
        if value.ndim == 2:
            kinds = (
                chosen.bases
                if isinstance(statement, Within) and statement.frictional
                else chosen.classes
            )
            value = value[np.arange(len(value)), kinds]
        row: Row = {
            "case": posterior_of_case.name,
            "variant": chosen.variant,
            "statement": name,
            "stated": name not in chosen.without,
            "quantity": "share captured",
        }
        if isinstance(statement, Within):
            low, high = statement.interval
            row |= {"quantity": statement.quantity, "interval_low": low, "interval_high": high}
            row |= {
                "tail": statement.tail,
                "share_inside": np.mean((low <= value) & (value <= high)),
            }
        row |= dict(zip(COLUMNS, np.quantile(value, BAND), strict=True))
        row["log_likelihood"] = np.median(statement.log_likelihood(value))
        rows.append(row | left_out(posterior_of_case, (*chosen.without, name)))
    return rows


def left_out(posterior_of_case: Posterior, without: Collection[str]) -> dict[str, float]:
    """Return the capture velocity by all statements but some.

    The pool was drawn with all statements on impacts: where the draws that then count are few, the
    effective size says so.
    """
    weights = posterior_of_case.weights(without)
    limits = posterior_of_case.limits[
        :, posterior_of_case.case.classes_um.index(posterior_of_case.case.diameter_um)
    ]
    order = np.argsort(limits)
    share = np.cumsum(weights[order]) / np.sum(weights)
    ends = np.interp(BAND, share, limits[order])
    told_of = {f"v_c_left_out_{n}_m_per_s": v for n, v in zip(COLUMNS, ends, strict=True)}
    return told_of | {"effective_size_left_out": ensemble.effective_number(weights)}


def density(values: FloatArray, at: FloatArray) -> FloatArray:
    """Return the density of draws at some places, its highest value 1 (Gaussian kernels)."""
    from scipy.stats import gaussian_kde

    estimate = gaussian_kde(values)(at)
    return np.asarray(estimate / np.max(estimate))


def marginals(
    case_name: str,
    case: Case,
    variants: Iterable[str],
    draws: pd.DataFrame,
    summary: pd.DataFrame,
    points: int,
) -> dict[str, pd.DataFrame]:
    """Return densities and pairs of the draws of one case, beside the two-stage estimates."""
    shares = np.linspace(0.0, 1.0, points)
    limits, others, works = [], [], []
    limit = partial(series_frame, "limit", x_unit="m_per_s", y_unit="1")
    share = partial(series_frame, "share", x_unit="1", y_unit="1")
    rate = partial(series_frame, "rate", x_unit="1", y_unit="1")
    work = partial(series_frame, "work", x_unit="J_per_m2", y_unit="m_per_s")
    by_variant = draws[draws["case"] == case_name].groupby("variant")
    for variant in variants:
        rows = by_variant.get_group(variant)
        v_c, part = rows["v_c_derived_m_per_s"].to_numpy(), rows["adhesion_share"].to_numpy()
        n, w = rows["rate_exponent"], rows["work_of_adhesion_J_per_m2"]
        name, kind = variant, "calibrated"
        speeds = np.geomspace(v_c.min() / BESIDE, v_c.max() * BESIDE, points)
        limits.append(limit(name, speeds, density(np.log(v_c), np.log(speeds)), kind))
        others += [share(name, shares, density(part, shares), kind), rate(name, n, part, kind)]
        works.append(work(name, w, v_c, kind))
    table = summary[summary["case"] == case_name].pivot(
        index="estimate", columns="quantity", values="median"
    )
    v_c_name = f"v_c_at_{case.diameter_um:g}_um_m_per_s"
    for name, kind in ((f"{TWO_STAGE}, {other}", "calibrated") for other in case.compared):
        row = table.loc[name]
        others.append(share(name, row["adhesion_share"], 0.0, kind))
        others.append(rate(name, row["rate_exponent"], row["adhesion_share"], kind))
        works.append(work(name, row["work_of_adhesion_J_per_m2"], row[v_c_name], kind))
    limits += [limit(PRINTED, value, 0.0, PRINTED) for value in case.printed_limits()]
    return {
        "admissible_limits": pd.concat(limits, ignore_index=True),
        "admissible_shares": pd.concat(others, ignore_index=True),
        "admissible_works": pd.concat(works, ignore_index=True),
    }


def bands(
    case_name: str, case: Case, variants: Iterable[str], inputs: Tables, points: int
) -> pd.DataFrame:
    """Return e against the normal speed: bands of the draws, single contacts, printed facts.

    Parameters
    ----------
    case_name, case
        The pair; bands are of its diameter.
    inputs
        ``admissible_contacts``, ``calibration``, ``materials``.
    """
    frame = partial(series_frame, case_name, x_unit="m_per_s", y_unit="1")
    speeds = np.geomspace(*case.shown_m_per_s, points)
    table, frames = inputs["admissible_contacts"], []
    by_variant = table[table["case"] == case_name].groupby("variant")
    for variant in variants:
        contact = resized(admissible_contact(inputs, case_name, variant), case.diameter_um * 1e-6)
        e = normal_impact(contact, speeds[:, None]).coefficient_of_restitution
        low, high = np.quantile(e, BAND[::2], axis=1)
        single = e[:, int(np.argmax(by_variant.get_group(variant)["most_central"]))]
        frames.append(frame(variant, speeds, single, "calibrated", low, high))
    for compared in case.compared:
        contact = resized(calibrated_contact(inputs, compared), case.diameter_um * 1e-6)
        e = normal_impact(contact, speeds).coefficient_of_restitution
        frames.append(frame(f"{TWO_STAGE}, {compared}", speeds, e, "calibrated"))
    for size, speed, (low, high) in case.printed_restitutions():
        name = f"{PRINTED}, {size:g} um"
        frames.append(frame(name, speed, 0.5 * (low + high), PRINTED, low, high))
    frames += [frame(PRINTED, value, 0.0, PRINTED) for value in case.printed_limits()]
    return pd.concat(frames, ignore_index=True)
