"""Numbers behind the claims on what was measured, and what the means are said to show."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from microimpact.studies.claim_numbers import numbers_table
from microimpact.studies.claims.laboratory_claims import (
    instruments as _laboratory_claims_instruments,
)
from microimpact.studies.claims.laboratory_claims import normal, slopes, slow, spores
from microimpact.studies.claims.laboratory_claims.context import Context, Numbers, Params

__all__ = ["CLAIMS", "Params", "run"]

CLAIMS: Mapping[str, Numbers] = dict(
    sorted(
        (
            _laboratory_claims_instruments.CLAIMS
            | normal.CLAIMS
            | slopes.CLAIMS
            | slow.CLAIMS
            | spores.CLAIMS
        ).items()
    )
)


def run(params: Params, inputs: Mapping[str, pd.DataFrame]) -> Mapping[str, pd.DataFrame]:
    """Compute the numbers of every claim wanted.

    Parameters
    ----------
    params
        Parameters of the study.
    inputs
        ``materials``, ``anchors``: declared rows; ``calibration``: calibrated contacts;
        ``ptis_range``, ``pairing_quality``, ``interval_coverage``, ``pile_up`` and the tables of
        mechanisms, as the studies make them.

    Returns
    -------
    mapping
        ``laboratory_claims``: per claim, case and quantity its value and unit.

    Raises
    ------
    ValueError
        If a claim is not among those of this study.
    """
    context = Context(params=params, inputs=inputs)
    return {"laboratory_claims": numbers_table("laboratory_claims", CLAIMS, params.claims, context)}
