"""Numbers behind the claims that the models of impact decide."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import pandas as pd

from microimpact.nearest import nearest
from microimpact.studies import (
    _model_claims_algebra,
    _model_claims_normal,
    _model_claims_oblique,
    _model_claims_sampled,
    _model_claims_tables,
)
from microimpact.studies._model_claims_context import Context, Numbers, Params

__all__ = ["CLAIMS", "Params", "run"]

CLAIMS: Mapping[str, Numbers] = dict(
    sorted(
        (
            _model_claims_algebra.CLAIMS
            | _model_claims_normal.CLAIMS
            | _model_claims_oblique.CLAIMS
            | _model_claims_sampled.CLAIMS
            | _model_claims_tables.CLAIMS
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
    for name in params.claims:
        if name not in CLAIMS:
            raise ValueError(f"model_claims.claims: no claim {name!r} here{nearest(name, CLAIMS)}")
    context = Context(params=params, inputs=inputs)
    rows = [row for name in params.claims for row in _rows(name, context)]
    return {"model_claims": pd.DataFrame(rows)}


def _rows(name: str, context: Context) -> Iterator[dict[str, object]]:
    claim = CLAIMS[name]
    for each in context.cases() if claim.by_case else (context,):
        for quantity, value in claim.of(each).items():
            yield {
                "claim": name,
                "case": each.case,
                "quantity": quantity,
                "value": float(value),
                "unit": claim.units.get(quantity, "-"),
                "evidence": claim.evidence,
            }
