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

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core import ensemble
from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.tables import Row, Tables
from microimpact.declared.parameters import Count, Keyed, Seed
from microimpact.lab.contacts import BAND, calibrated_contact
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.separation import jkr_pull_off
from microimpact.studies.models.admissible_contacts.case import (
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
from microimpact.studies.models.admissible_contacts.shown import bands, marginals
from microimpact.studies.models.admissible_contacts.statements import Within

NEEDS = {"calibration": ("calibration",)}

COLUMNS = ("low", "median", "high")
# Columns that are told.
TOLD = (*FIELDS, "restitution", "adhesion_share", "contact_time_ns", "pull_off_uN")


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """What is calibrated, how it is drawn, and points of the curves shown.

    Marginals and pairs are shown of the first case.
    """

    seed: Seed
    sampler: Sampler
    draws: Count
    cases: Annotated[tuple[Case, ...], Keyed("case")]
    variants: Annotated[tuple[Variant, ...], Keyed("variant")]
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
    found = [posterior(case, inputs, params.sampler, params.seed) for case in params.cases]
    pairs = [(p, v, p.chosen(v, params.draws)) for p in found for v in params.variants]
    draws = [table(p, v, chosen, inputs) for p, v, chosen in pairs]
    rows = [row for one, drawn in zip(pairs, draws, strict=True) for row in summary(*one, drawn)]
    rows += [row for case in params.cases for row in two_stage(case, inputs)]
    summaries = pd.DataFrame(rows)[["case", "estimate", "quantity", *COLUMNS]]
    contacts_drawn = pd.concat(draws, ignore_index=True)
    known = {**inputs, "admissible_contacts": contacts_drawn}
    curves = [bands(case, params.variants, known, params.points) for case in params.cases]
    return {
        "admissible_contacts": contacts_drawn,
        "admissible_diagnostics": pd.DataFrame([diagnostics(*one) for one in pairs]),
        "admissible_summary": summaries,
        "admissible_statements": pd.DataFrame([row for one in pairs for row in told(*one)]),
        "admissible_bands": pd.concat(curves, ignore_index=True),
        **marginals(params.cases[0], params.variants, contacts_drawn, summaries, params.points),
    }


def derived(case: Case, contact: Contact) -> dict[str, FloatArray]:
    """Return what follows from contacts of any shape at the case's diameter and speed."""
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


def table(found: Posterior, variant: Variant, chosen: Chosen, inputs: Tables) -> pd.DataFrame:
    """Return the draws of one case and variant, a row each."""
    case, bare = found.case, bare_contact(found.case, inputs)
    contact = contacts(case, bare, chosen.points, np.array([case.diameter_um]))
    own = values(case, chosen.points)
    limits = found.limits[chosen.taken]
    return pd.DataFrame(
        {
            "case": case.case,
            "variant": variant.variant,
            "draw": np.arange(len(limits)),
            "particle": case.particle,
            "surface": case.surface,
            **{name: own.get(name, getattr(bare, field)) for name, field in FIELDS.items()},
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


def diagnostics(found: Posterior, variant: Variant, chosen: Chosen) -> Row:
    """Return how well the draws of one case and variant came about."""
    weights = found.weights(variant)
    return {
        "case": found.case.case,
        "variant": variant.variant,
        "open_parameters": len(found.case.ranges.open()),
        "acceptance": found.pool.acceptance,
        "split_r_hat": float(np.max(found.pool.split_r_hat)),
        "kept": found.pool.kept,
        "effective_size": found.pool.effective_size,
        "pool": len(weights),
        "effective_size_weighted": ensemble.effective_number(weights),
        "largest_weight": float(np.max(weights) / np.sum(weights)),
        "draws": len(chosen.taken),
        "different_draws": len(np.unique(chosen.taken)),
    }


def summary(found: Posterior, variant: Variant, chosen: Chosen, draws: pd.DataFrame) -> list[Row]:
    """Return medians and intervals of the numbers of one case and variant."""
    case = found.case
    sizes = limits_by_size(case, found.limits[chosen.taken])
    numbers = {name: draws[name].to_numpy(float) for name in TOLD} | sizes
    names = {"case": case.case, "estimate": variant.variant}
    rows: list[Row] = [
        names | {"quantity": name} | dict(zip(COLUMNS, np.quantile(value, BAND), strict=True))
        for name, value in numbers.items()
    ]
    for axis, kinds in (("diameter_um", case.classes_um), ("friction_basis", case.friction_bases)):
        for kind in kinds:
            share = float(np.mean(draws[axis] == kind))
            rows.append(names | {"quantity": f"share of {axis} {kind}", "median": share})
    return rows


def two_stage(case: Case, inputs: Tables) -> list[Row]:
    """Return the same numbers of the two-stage estimates, which have no interval."""
    rows = []
    for other in case.compared:
        contact = calibrated_contact(inputs, other)
        limits = capture_velocity(resized(contact, np.array(case.classes_um) * 1e-6))
        numbers = {name: getattr(contact, field) for name, field in FIELDS.items()}
        numbers |= derived(case, contact) | limits_by_size(case, limits)
        names = {"case": case.case, "estimate": f"two-stage, {other}"}
        rows += [names | {"quantity": n, "median": float(v)} for n, v in numbers.items()]
    return rows


def limits_by_size(case: Case, limits: FloatArray) -> dict[str, FloatArray]:
    """Capture velocities of every size class, from those of all (..., classes)."""
    names = [f"v_c_at_{d:g}_um_m_per_s" for d in case.classes_um]
    return dict(zip(names, np.moveaxis(limits, -1, 0), strict=True))


def told(found: Posterior, variant: Variant, chosen: Chosen) -> list[Row]:
    """Return what each statement says and what the draws of one case and variant have.

    A statement that the variant leaves out is told, too: what the draws predict for it.
    """
    rows: list[Row] = []
    for one in found.case.all_statements:
        value = found.quantities[one.statement][chosen.taken]
        if value.ndim == 2:
            kinds = chosen.bases if isinstance(one, Within) and one.frictional else chosen.classes
            value = value[np.arange(len(value)), kinds]
        row: Row = {
            "case": found.case.case,
            "variant": variant.variant,
            "statement": one.statement,
            "stated": one.statement not in variant.without,
            "quantity": "share captured",
        }
        if isinstance(one, Within):
            low, high = one.interval
            row |= {"quantity": one.quantity, "interval_low": low, "interval_high": high}
            row |= {"tail": one.tail, "share_inside": np.mean((low <= value) & (value <= high))}
        row |= dict(zip(COLUMNS, np.quantile(value, BAND), strict=True))
        row["log_likelihood"] = np.median(one.log_likelihood(value))
        rows.append(row | left_out(found, variant, one.statement))
    return rows


def left_out(found: Posterior, variant: Variant, statement: str) -> dict[str, float]:
    """Return the capture velocity that is left if one more statement is left out.

    The pool was drawn with all statements on impacts: where the draws that then count are few, the
    effective size says so.
    """
    weights = found.weights(replace(variant, without=(*variant.without, statement)))
    limits = found.limits[:, found.case.classes_um.index(found.case.diameter_um)]
    order = np.argsort(limits)
    share = np.cumsum(weights[order]) / np.sum(weights)
    ends = np.interp(BAND, share, limits[order])
    told_of = {f"v_c_left_out_{n}_m_per_s": v for n, v in zip(COLUMNS, ends, strict=True)}
    return told_of | {"effective_size_left_out": ensemble.effective_number(weights)}
