"""Numbers behind the claims that the models of impact decide."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from microimpact.studies.claim_numbers import Numbers, numbers_table
from microimpact.studies.claims.model_claims import algebra, normal, oblique, sampled, tables
from microimpact.studies.claims.model_claims.context import Context, Params

__all__ = ["CLAIMS", "Params", "run"]

CLAIMS: Mapping[str, Numbers] = dict(
    sorted(
        (algebra.CLAIMS | normal.CLAIMS | oblique.CLAIMS | sampled.CLAIMS | tables.CLAIMS).items()
    )
)


def run(params: Params, inputs: Mapping[str, pd.DataFrame]) -> Mapping[str, pd.DataFrame]:
    """Compute the numbers of every claim wanted.

    Parameters
    ----------
    params
        Parameters of the study.
    inputs
        ``materials``, ``contacts``, ``anchors``: declared rows; ``calibration``,
        ``molybdenum_capture``, ``force_ratios``, ``rolling_dissipation``, ``restitution_fits``:
        tables of the studies that make them.

    Returns
    -------
    mapping
        ``model_claims``: per claim, case and quantity its value and unit.

    Raises
    ------
    ValueError
        If a claim is not among those of this study.
    """
    context = Context(params=params, inputs=inputs)
    return {"model_claims": numbers_table("model_claims", CLAIMS, params.claims, context)}
