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

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import pandas as pd

from microimpact.core import ensemble
from microimpact.core.arrays import FloatArray
from microimpact.declared.parameters import Count, Keyed, Seed
from microimpact.lab.contacts import admissible_contact, calibrated_contact
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
from microimpact.studies.models.admissible_contacts.statements import Within

NEEDS = {"calibration": ("calibration",)}

# Lower end, middle and upper end of what is told of a distribution.
QUANTILES = (0.05, 0.5, 0.95)
COLUMNS = ("low", "median", "high")


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """What is calibrated, and how it is drawn."""

    seed: Seed
    sampler: Sampler
    draws: Count
    cases: Annotated[tuple[Case, ...], Keyed("case")]
    variants: Annotated[tuple[Variant, ...], Keyed("variant")]


def run(params: Params, inputs: Mapping[str, pd.DataFrame]) -> Mapping[str, pd.DataFrame]:
    """Draw the admissible contacts of every case.

    Parameters
    ----------
    params
        Parameters of the study.
    inputs
        ``materials``, ``contacts``: the declared rows of the pairs; ``calibration``: the two-stage
        estimates.

    Returns
    -------
    mapping
        ``admissible_contacts``: the draws, their parameters and derived numbers, by case and
        variant. ``admissible_diagnostics``: how well they were drawn. ``admissible_summary``:
        medians and intervals, and the two-stage estimates. ``admissible_statements``: what each
        statement says, and what the draws have.
    """
    found = [posterior(case, inputs, params.sampler, params.seed) for case in params.cases]
    pairs = [(p, v, p.chosen(v, params.draws)) for p in found for v in params.variants]
    draws = [table(p, v, chosen, inputs) for p, v, chosen in pairs]
    return {
        "admissible_contacts": pd.concat(draws, ignore_index=True),
        "admissible_diagnostics": pd.DataFrame([diagnostics(*one) for one in pairs]),
        "admissible_summary": summary(params.cases, draws, inputs),
        "admissible_statements": pd.DataFrame([row for one in pairs for row in told(*one)]),
    }


def derived(case: Case, contact: Contact) -> dict[str, FloatArray]:
    """Return what follows from contacts of any shape at the case's diameter and speed."""
    contact = resized(contact, case.diameter_um * 1e-6)
    outcome = normal_impact(contact, case.speed_m_per_s, ledger=True)
    ledger, work = outcome.ledger, contact.work_of_adhesion
    assert ledger is not None
    assert work is not None
    return {
        "restitution": outcome.coefficient_of_restitution,
        "adhesion_share": ledger.adhesion_work / (ledger.adhesion_work + ledger.hertz_work),
        "contact_time_ns": outcome.contact_time * 1e9,
        "pull_off_uN": np.broadcast_to(jkr_pull_off(work, contact.radius) * 1e6, contact.shape),
        **{
            f"v_c_at_{d:g}_um_m_per_s": capture_velocity(resized(contact, d * 1e-6))
            for d in case.classes_um
        },
    }


def table(
    found: Posterior, variant: Variant, chosen: Chosen, inputs: Mapping[str, pd.DataFrame]
) -> pd.DataFrame:
    """Return the draws of one case and variant, a row each."""
    case, bare = found.case, bare_contact(found.case, inputs)
    contact = contacts(case, bare, chosen.points, np.array([case.diameter_um]))
    open_values = values(case, chosen.points)
    parameters = {
        name: open_values.get(name, np.full(len(chosen.points), getattr(bare, field)))
        for name, field in FIELDS.items()
    }
    follows = {name: value[:, 0] for name, value in derived(case, contact).items()}
    limits = np.stack([follows.pop(f"v_c_at_{d:g}_um_m_per_s") for d in case.classes_um], axis=1)
    return pd.DataFrame(
        {
            "case": case.case,
            "variant": variant.variant,
            "draw": np.arange(len(chosen.points)),
            "particle": case.particle,
            "surface": case.surface,
            **parameters,
            "reference_velocity_m_per_s": case.speed_m_per_s,
            "diameter_um": np.array(case.classes_um)[chosen.classes],
            "friction_basis": np.array(case.friction_bases)[chosen.bases],
            "v_c_m_per_s": limits[np.arange(len(limits)), chosen.classes],
            "derived_at_um": case.diameter_um,
            "derived_at_m_per_s": case.speed_m_per_s,
            "v_c_derived_m_per_s": capture_velocity(contact)[:, 0],
            **follows,
            "log_likelihood": chosen.log_likelihood,
            "most_central": most_central(chosen.points),
        }
    )


def most_central(points: FloatArray) -> FloatArray:
    """Mark the draw with the least mean distance to all others (n,), axes in their own spread.

    The likelihood is flat where all statements hold, so its maximum may lie in any corner.
    """
    scaled = points / points.std(axis=0)
    distance = np.linalg.norm(scaled[:, None] - scaled, axis=-1).mean(axis=1)
    return np.arange(len(points)) == np.argmin(distance)


def diagnostics(found: Posterior, variant: Variant, chosen: Chosen) -> dict[str, object]:
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


def summary(
    cases: tuple[Case, ...], draws: list[pd.DataFrame], inputs: Mapping[str, pd.DataFrame]
) -> pd.DataFrame:
    """Return medians and intervals of every number, and those of the two-stage estimates."""
    named = {case.case: case for case in cases}
    rows: list[dict[str, object]] = []
    for rows_of in draws:
        case = named[rows_of["case"].iloc[0]]
        names = {"case": case.case, "estimate": rows_of["variant"].iloc[0]}
        contact = admissible_contact(inputs | {"admissible_contacts": rows_of}, *names.values())
        numbers = {name: rows_of[name].to_numpy(float) for name in FIELDS}
        for name, value in (numbers | derived(case, contact)).items():
            ends = dict(zip(COLUMNS, np.quantile(value, QUANTILES), strict=True))
            rows.append(names | {"quantity": name} | ends)
        for axis in ("diameter_um", "friction_basis"):
            for value, share in rows_of[axis].value_counts(normalize=True, sort=False).items():
                rows.append(names | {"quantity": f"share of {axis} {value}", "median": share})
    for case in cases:
        for other in case.compared:
            contact = calibrated_contact(inputs, other)
            numbers = {name: getattr(contact, field) for name, field in FIELDS.items()}
            rows += [
                {"case": case.case, "estimate": f"two-stage, {other}"}
                | {"quantity": name, "median": float(value)}
                for name, value in (numbers | derived(case, contact)).items()
            ]
    return pd.DataFrame(rows)[["case", "estimate", "quantity", *COLUMNS]]


def told(found: Posterior, variant: Variant, chosen: Chosen) -> list[dict[str, object]]:
    """Return what each statement says and what the draws of one case and variant have.

    A statement that the variant leaves out is told, too: what the draws predict for it.
    """
    rows = []
    places = {"classes": chosen.classes, "bases": chosen.bases}
    stated = [s.statement for s in found.stated(variant)]
    for one in found.case.statements:
        value = found.quantities[one.statement][chosen.taken]
        if value.ndim == 2:
            kind = "bases" if isinstance(one, Within) and one.frictional else "classes"
            value = value[np.arange(len(value)), places[kind]]
        ends = dict(zip(COLUMNS, np.quantile(value, QUANTILES), strict=True))
        within = isinstance(one, Within)
        rows.append(
            {
                "case": found.case.case,
                "variant": variant.variant,
                "statement": one.statement,
                "stated": one.statement in stated,
                "quantity": one.quantity if within else "share captured",
                "interval_low": one.interval[0] if within else np.nan,
                "interval_high": one.interval[1] if within else np.nan,
                "tail": one.tail if within else np.nan,
                **ends,
                "log_likelihood": float(np.median(one.log_likelihood(value))),
                "share_inside": float(
                    np.mean((value >= one.interval[0]) & (value <= one.interval[1]))
                )
                if within
                else np.nan,
            }
        )
    return rows
