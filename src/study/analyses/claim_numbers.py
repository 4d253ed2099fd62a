"""Numbers behind the claims of the article; `study.judge` judges them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from microimpact.core.computable import NotComputable
from microimpact.core.nearest import nearest
from study.claims.claim import CLAIMS, NUMBER_COLUMNS, ascending, flat, params, rows
from study.claims.context import Common, Context
from study.claims.sections import SECTIONS
from study.contacts import posterior_contact, posterior_rows
from study.tables import Tables

__all__ = ["CLAIMS", "SECTIONS", "Params", "drawn", "numbers", "numbers_of", "run"]

NEEDS = {
    "inference": ("posterior_contacts",),
    "calibration": ("calibration", "calibration_family", "molybdenum_capture"),
    "fig20_force_history": ("force_ratios",),
    "rolling_dissipation": ("rolling_dissipation",),
    "fig15_16_restitution_fits": ("restitution_fits",),
    "track_imaging": ("ptis_range",),
    "pair_search": ("pairing_quality",),
    "interval_coverage": ("interval_coverage",),
    "pile_up": ("pile_up",),
    "mechanisms": (
        "adhesion_or_roughness",
        "formica_mechanism",
        "loss_resolution",
        "loss_slopes",
        "smooth_spore",
        "spin_needed",
        "spin_or_tilt",
        "spore_comparison",
        "spore_trends",
        "surface_pairs",
    ),
    "fig24_25_doe": (
        "doe_bd_aliasing",
        "doe_design",
        "doe_effects",
        "doe_elasticities",
        "doe_levels",
    ),
    "fig23_monte_carlo": ("monte_carlo",),
}
# Makers of the tables that claims decided by drawn contacts read.
DRAWS_NEED = ("calibration", "inference", "fig24_25_doe")
PRINTED_VALUES = (
    "restitution_sst76_silicon",
    "capture_velocity_sst_silicon",
    "normal_speed_lycopodium_48deg",
    "normal_speed_lycopodium_38deg",
)

# Of a drawn contact, and of its numbers.
DRAW = ("contact", "scenario", "law", "draw")
DRAW_COLUMNS = ("claim", *DRAW, "alternative", "quantity", "value")
# Of laws other than the ring force, which cost more, every third draw counts.
SPARSE = 3

# Settings of all claims: what they share, and a field for each claim with settings.
Params: Any = params()


def run(params: Common, inputs: Tables) -> Tables:
    """Compute the numbers of every claim, and of some for drawn contacts: `numbers`, `drawn`."""
    return {**numbers(params, inputs), **drawn(params, inputs)}


def numbers(params: Common, inputs: Tables) -> Tables:
    """Compute the numbers of every claim.

    A claim that cannot be computed with the settings has a row that says why, and leaves the others
    alone.

    Parameters
    ----------
    params
        Settings of all claims.
    inputs
        ``materials``, ``contacts``, ``printed``: declared rows; tables of earlier studies by name.

    Returns
    -------
    dict of pandas.DataFrame
        ``claim_numbers``: per claim, case and quantity its value, error and code; in the column
        ``problem``, why there is none.
    """
    context = Context(params=params, inputs=inputs)
    every = [row for name in ascending() for row in rows(name, context)]
    return {"claim_numbers": pd.DataFrame(every, columns=list(NUMBER_COLUMNS))}


def drawn(params: Common, inputs: Tables) -> Tables:
    """Compute the numbers of the claims that drawn contacts decide, for every draw.

    A rule of its own makes them: it waits for the analyses of `DRAWS_NEED` alone.

    Parameters
    ----------
    params, inputs
        As in `draws_of`.

    Returns
    -------
    dict of pandas.DataFrame
        ``claim_draws``: what `draws_of` returns for all these claims.
    """
    return {"claim_draws": draws_of(params, inputs)}


def draws_of(params: Common, inputs: Tables, *claims: str) -> pd.DataFrame:
    """Return the numbers of the claims that drawn contacts decide, for every draw.

    Contacts are drawn by the printed statements, in scenarios and by all laws that a scenario does
    not exclude. Friction and its basis are those of the draw, all else as for the calibrated cases.
    A claim that cannot be computed with a draw has no row, as those about the ring force with other
    laws.

    Parameters
    ----------
    params, inputs
        As in `numbers`; of the tables those of `DRAWS_NEED` are read.
    *claims
        Such as ``C58``; all, if none are named.

    Returns
    -------
    pandas.DataFrame
        Rows with `DRAW_COLUMNS`, in the order of claims and draws.
    """
    wanted = claims or tuple(name for name in ascending() if CLAIMS[name].by_contact)
    contacts = pd.concat(
        [posterior_rows(inputs, params.draws.case, each) for each in params.draws.scenarios],
        ignore_index=True,
    )
    is_ring_force = contacts["contact_law"] == "ring force"
    contacts = contacts[is_ring_force | (contacts["draw"] % SPARSE == 0)]
    groups = [rows for _, rows in contacts.groupby(["contact_law", "friction_basis"])]
    parts = [part for rows in groups for part in _of(wanted, params, inputs, rows)]
    if not parts:
        return pd.DataFrame(columns=list(DRAW_COLUMNS))
    table = pd.concat(parts)
    # In the order of the draws within a claim, whatever the law and the basis of friction.
    order = {name: number for number, name in enumerate(wanted)}
    table = table.assign(order=table["claim"].map(order)).reset_index(names="row")
    return table.sort_values(["order", "row"], kind="stable")[list(DRAW_COLUMNS)]


def _of(
    claims: Sequence[str], params: Common, inputs: Tables, rows: pd.DataFrame
) -> Iterator[pd.DataFrame]:
    """Yield the numbers of each quantity of claims, for draws of one law and basis of friction."""
    basis = rows["friction_basis"].iloc[0]
    context = Context(
        params=replace(params, steel=replace(params.steel, friction_basis=basis)),
        inputs=inputs,
        case=params.steel.cases[0],
        contacts=posterior_contact(inputs, rows),
    )
    draws = rows.rename(columns={"case": "contact"})[list(DRAW)]
    for name in claims:
        try:
            entries = list(flat(CLAIMS[name].computed(context), ""))
        except NotComputable:
            continue
        values = [np.broadcast_to(value, len(rows)) for *_, value in entries]
        known = np.all(np.isfinite(values), axis=0)
        of_claim = draws.assign(claim=name)
        for (alternative, quantity, _), value in zip(entries, values, strict=True):
            yield of_claim.assign(alternative=alternative, quantity=quantity, value=value)[known]


def numbers_of(claim: str, params: Common, inputs: Tables) -> pd.DataFrame:
    """Return the numbers of one claim, as rows of the table of all.

    Parameters
    ----------
    claim
        Such as ``C58``.
    params, inputs
        As in `numbers`; of the tables those that the claim reads.

    Raises
    ------
    ValueError
        If no function computes such a claim.
    """
    if claim not in CLAIMS:
        raise ValueError(f"no function computes a claim {claim!r}{nearest(claim, CLAIMS)}")
    context = Context(params=params, inputs=inputs)
    return pd.DataFrame(list(rows(claim, context)), columns=list(NUMBER_COLUMNS))
