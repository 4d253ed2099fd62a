"""Numbers behind the claims on what was measured, and what the means are said to show."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import pandas as pd

from microimpact.nearest import nearest
from microimpact.studies import (
    _laboratory_claims_instruments,
    _laboratory_claims_normal,
    _laboratory_claims_slopes,
    _laboratory_claims_slow,
    _laboratory_claims_spores,
)
from microimpact.studies._laboratory_claims_context import Context, Numbers, Params

__all__ = ["CLAIMS", "Params", "run"]

CLAIMS: Mapping[str, Numbers] = dict(
    sorted(
        (
            _laboratory_claims_instruments.CLAIMS
            | _laboratory_claims_normal.CLAIMS
            | _laboratory_claims_slopes.CLAIMS
            | _laboratory_claims_slow.CLAIMS
            | _laboratory_claims_spores.CLAIMS
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
    for name in params.claims:
        if name not in CLAIMS:
            raise ValueError(
                f"laboratory_claims.claims: no claim {name!r} here{nearest(name, CLAIMS)}"
            )
    context = Context(params=params, inputs=inputs)
    rows = [row for name in params.claims for row in _rows(name, context)]
    return {"laboratory_claims": pd.DataFrame(rows)}


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
