"""Numbers behind the claims on roughness, Monte Carlo, designed experiments and estimation.

One function per claim, named after it, in the modules ``_analysis_claims_*``; its docstring says
what is computed. What the article states, and the criteria, stand in ``config/claims.yaml``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import pandas as pd

from microimpact.studies.claim_numbers import code_of
from microimpact.studies.claims.analysis_claims import (
    capture,
    designs,
    impacts,
    losses,
    samples,
    slopes,
)
from microimpact.studies.claims.analysis_claims.context import (
    Context,
    Numbers,
    by_name,
    on_ridge,
    once,
)
from microimpact.studies.claims.analysis_claims.params import Params

__all__ = ["CLAIMS", "COLUMNS", "Params", "numbers_of", "run"]

COLUMNS = ["claim", "case", "quantity", "value", "unit", "evidence", "code"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """How the numbers of a claim are computed, on what they rest, and their unit."""

    numbers: Callable[[Context], Numbers]
    evidence: str = "computed"
    unit: str = "-"


VIRTUAL = "virtual experiment"

CLAIMS = {
    "C08": Entry(numbers=on_ridge(capture.c08), evidence="calibrated", unit="m/s"),
    "C45": Entry(numbers=once(slopes.c45)),
    "C46": Entry(numbers=once(slopes.c46)),
    "C47": Entry(numbers=once(slopes.c47)),
    "C48": Entry(numbers=once(slopes.c48)),
    "C49": Entry(numbers=once(slopes.c49)),
    "C50": Entry(numbers=once(slopes.c50)),
    "C51": Entry(numbers=once(samples.c51), evidence=VIRTUAL),
    "C52": Entry(numbers=once(samples.c52), evidence=VIRTUAL),
    "C53": Entry(numbers=by_name(designs.c53)),
    "C54": Entry(numbers=by_name(designs.c54)),
    "C55": Entry(numbers=by_name(designs.c55)),
    "C56": Entry(numbers=by_name(designs.c56)),
    "C57": Entry(numbers=on_ridge(capture.c57)),
    "C60": Entry(numbers=once(samples.c60), evidence=VIRTUAL, unit="deg"),
    "C68": Entry(numbers=on_ridge(impacts.c68)),
    "C69": Entry(numbers=on_ridge(impacts.c69)),
    "C70": Entry(numbers=on_ridge(losses.c70)),
    "C93": Entry(numbers=on_ridge(impacts.c93)),
    "C94": Entry(numbers=once(samples.c94), evidence=VIRTUAL),
    "C95": Entry(numbers=on_ridge(impacts.c95)),
    "C96": Entry(numbers=once(samples.c96), evidence=VIRTUAL),
    "C97": Entry(numbers=capture.c97),
    "C98": Entry(numbers=on_ridge(capture.c98), evidence=VIRTUAL),
    "C99": Entry(numbers=on_ridge(losses.c99)),
    "C100": Entry(numbers=on_ridge(losses.c100)),
    "C101": Entry(numbers=on_ridge(losses.c101)),
    "C102": Entry(numbers=on_ridge(losses.c102)),
    "C103": Entry(numbers=once(losses.c103)),
    "C104": Entry(numbers=on_ridge(losses.c104)),
    "C105": Entry(numbers=on_ridge(samples.c105), evidence=VIRTUAL),
    "C106": Entry(numbers=on_ridge(impacts.c106)),
    "C107": Entry(numbers=once(capture.c107)),
    "C108": Entry(numbers=on_ridge(losses.c108)),
    "C109": Entry(numbers=once(samples.c109), evidence=VIRTUAL),
    "C110": Entry(numbers=on_ridge(impacts.c110), unit="deg"),
}


def run(params: Params, inputs: Mapping[str, pd.DataFrame]) -> Mapping[str, pd.DataFrame]:
    """Compute the numbers of every claim of this group.

    Parameters
    ----------
    params
        Parameters of the study.
    inputs
        ``calibration``, ``calibration_family``, ``doe_effects``, ``monte_carlo``: tables of these
        studies; ``materials``: declared rows.

    Returns
    -------
    mapping
        ``analysis_claims``: one row per claim, case and quantity.
    """
    context = Context.of(params, inputs)
    frames = [numbers_of(claim, context) for claim in CLAIMS]
    return {"analysis_claims": pd.concat(frames, ignore_index=True)}


def numbers_of(claim: str, context: Context) -> pd.DataFrame:
    """Return the numbers of one claim as rows."""
    entry = CLAIMS[claim]
    code = code_of(entry.numbers)
    rows = [
        (claim, case, quantity, float(value), entry.unit, entry.evidence, code)
        for case, found in entry.numbers(context).items()
        for quantity, value in found.items()
    ]
    return pd.DataFrame(rows, columns=COLUMNS)
