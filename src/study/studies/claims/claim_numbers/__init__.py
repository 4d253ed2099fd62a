"""Numbers behind the claims of the article, by section; the claims ledger judges them.

One function per claim, named after it; its docstring says what is computed. What the article
states, and the criteria, are in ``config/claims.yaml``.
"""

from __future__ import annotations

from typing import Any

import pandas as pd

from microimpact.core.nearest import nearest
from study.studies.claims import NUMBER_COLUMNS
from study.studies.claims.claim_numbers import (
    conclusions,
    designs,
    draws,
    dynamics,
    empirical,
    experiments,
    oblique,
    rigid_body,
    roughness,
    spores,
)
from study.studies.claims.claim_numbers.claim import CLAIMS, ascending, params, rows
from study.studies.claims.claim_numbers.context import Context
from study.studies.claims.claim_numbers.params import Common
from study.tables import NOT_COMPUTED, UNCOMPUTABLE, Tables, reason

__all__ = ["CLAIMS", "SECTIONS", "Params", "numbers_of", "run"]

NEEDS = {
    "inference": ("posterior_contacts",),
    "calibration": ("calibration", "calibration_family", "molybdenum_capture"),
    "force_history": ("force_ratios",),
    "rolling_dissipation": ("rolling_dissipation",),
    "restitution_fits": ("restitution_fits",),
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
    "doe": ("doe_bd_aliasing", "doe_design", "doe_effects", "doe_elasticities", "doe_levels"),
    "monte_carlo": ("monte_carlo",),
}
PRINTED_VALUES = (
    "restitution_sst76_silicon",
    "capture_velocity_sst_silicon",
    "normal_speed_lycopodium_48deg",
    "normal_speed_lycopodium_38deg",
)

# Modules in the order of the article; each registers the claims of its sections.
SECTIONS = (
    experiments,
    oblique,
    spores,
    rigid_body,
    dynamics,
    empirical,
    roughness,
    designs,
    conclusions,
)

# Settings of all claims: what they share, and a field for each claim with settings.
Params: Any = params()


def run(params: Common, inputs: Tables) -> Tables:
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
        ``problem``, why there is none. ``claim_draws``: numbers of some claims for drawn
        contacts.
    """
    context = Context(params=params, inputs=inputs)
    numbers = [row for name in ascending() for row in rows(name, context)]
    try:
        drawn = draws_of(params, inputs)
    except UNCOMPUTABLE as error:  # these claims are not judged by their calibrated cases instead
        drawn = pd.DataFrame(columns=list(draws.COLUMNS))
        row = {"quantity": NOT_COMPUTED, "problem": reason("claim_draws", error)}
        numbers += [{"claim": name, **row} for name in ascending() if CLAIMS[name].by_contact]
    return {
        "claim_numbers": pd.DataFrame(numbers, columns=list(NUMBER_COLUMNS)),
        "claim_draws": drawn,
    }


def draws_of(params: Common, inputs: Tables, *claims: str) -> pd.DataFrame:
    """Return the numbers of the claims that drawn contacts decide, for every draw.

    Of `claims` alone, if some are named. Of the tables, only ``calibration`` and
    ``posterior_contacts`` are read.
    """
    wanted = claims or [name for name in ascending() if CLAIMS[name].by_contact]
    return draws.numbers_of_draws(params, inputs, wanted)


def numbers_of(claim: str, params: Common, inputs: Tables) -> pd.DataFrame:
    """Return the numbers of one claim, as rows of the table of all.

    Parameters
    ----------
    claim
        Such as ``C58``.
    params, inputs
        As in `run`; of the tables those that the claim reads.

    Raises
    ------
    ValueError
        If no function computes such a claim.
    """
    if claim not in CLAIMS:
        raise ValueError(f"no function computes a claim {claim!r}{nearest(claim, CLAIMS)}")
    context = Context(params=params, inputs=inputs)
    return pd.DataFrame(list(rows(claim, context)), columns=list(NUMBER_COLUMNS))
