"""Numbers behind the claims of the article, by section; the claims ledger judges them.

One function per claim, named after it; its docstring says what is computed. What the article
states, and the criteria, are in ``config/claims.yaml``.
"""

from __future__ import annotations

from collections.abc import Iterable

import pandas as pd

from microimpact.core.nearest import nearest
from microimpact.core.tables import Tables
from microimpact.studies.claims import NUMBER_COLUMNS
from microimpact.studies.claims.claim_numbers import (
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
from microimpact.studies.claims.claim_numbers.claim import CLAIMS, NOT_COMPUTED, rows
from microimpact.studies.claims.claim_numbers.context import Context
from microimpact.studies.claims.claim_numbers.params import Params

__all__ = ["CLAIMS", "NOT_COMPUTED", "SECTIONS", "Params", "numbers_of", "run"]

NEEDS = {
    "admissible_contacts": ("admissible_contacts",),
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
        "speed_and_angle",
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


Part = list[tuple[int, list[draws.Row]]]


def part(params: Params, inputs: Tables, index: int, count: int) -> Part:
    """Return the numbers of every ``count``-th draw, from ``index`` on, with its place.

    Of the tables, only ``calibration`` and ``admissible_contacts`` are read.
    """
    rows = draws.chosen(params, inputs)
    own = draws.rows_of(params, inputs, rows.iloc[index::count])
    return list(zip(range(index, len(rows), count), own, strict=True))


def gather(params: Params, inputs: Tables, parts: Iterable[Part]) -> Tables:
    """Compute the numbers of every claim, and put those of the draws together; see `run`."""
    context = Context(params=params, inputs=inputs)
    found = [row for name in _ascending() for row in rows(name, context)]
    drawn = {place: rows for part in parts for place, rows in part}
    table = [row for place in sorted(drawn) for row in drawn[place]]
    return {
        "claim_numbers": pd.DataFrame(found, columns=list(NUMBER_COLUMNS)),
        "claim_draws": pd.DataFrame(table, columns=list(draws.COLUMNS)),
    }


def run(params: Params, inputs: Tables) -> Tables:
    """Compute the numbers of every claim.

    A claim that cannot be computed with the settings has a row that says why, and leaves the others
    alone.

    ``claim_numbers``: per claim, case and quantity its value, unit, evidence and code; in the
    column ``problem``, why there is none. ``claim_draws``: numbers of some claims for admissible
    contacts. `inputs`: ``materials``, ``contacts``, ``printed``: declared rows; tables of earlier
    studies by name.
    """
    return gather(params, inputs, [part(params, inputs, 0, 1)])


def numbers_of(claim: str, params: Params, inputs: Tables) -> pd.DataFrame:
    """Return the numbers of one claim, as rows of the table of all.

    `claim`: such as ``C58``; `params`, `inputs`: as in `run`; of the tables those that the claim
    reads. Raises ValueError if no function computes such a claim.
    """
    if claim not in CLAIMS:
        raise ValueError(f"no function computes a claim {claim!r}{nearest(claim, CLAIMS)}")
    context = Context(params=params, inputs=inputs)
    return pd.DataFrame(list(rows(claim, context)), columns=list(NUMBER_COLUMNS))


def _ascending() -> list[str]:
    return sorted(CLAIMS, key=lambda name: int(name[1:]))
