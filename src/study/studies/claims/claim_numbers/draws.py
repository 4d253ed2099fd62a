"""Numbers of claims over contacts drawn by the printed statements, in scenarios and by laws.

All laws count that a scenario does not exclude.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import cast

import numpy as np
import pandas as pd

from microimpact.model.choices import FrictionBasis
from study.studies.claims.claim_numbers.claim import CLAIMS, flat
from study.studies.claims.claim_numbers.context import Context
from study.studies.claims.claim_numbers.params import Common
from study.studies.contacts import posterior_contact, posterior_rows
from study.tables import UNCOMPUTABLE

DRAW = ("contact", "scenario", "law", "draw")
COLUMNS = ("claim", *DRAW, "alternative", "quantity", "value")


# Laws other than the ring force are integrated point by point: of their draws every so many count.
SPARSE = 3


def drawn_contacts(params: Common, inputs: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Return the drawn contacts for which claims are computed."""
    case = params.draws.case
    rows = pd.concat(
        [posterior_rows(inputs, case, scenario) for scenario in params.draws.scenarios],
        ignore_index=True,
    )
    return rows[(rows["contact_law"] == "ring force") | (rows["draw"] % SPARSE == 0)]


def numbers_of_draws(
    params: Common, inputs: Mapping[str, pd.DataFrame], claims: Iterable[str]
) -> pd.DataFrame:
    """Return the numbers of claims for every draw, with `COLUMNS`.

    Friction and its basis are those of the draw, all else as for the calibrated cases. A claim
    that cannot be computed with a draw has no row, as those about the ring force with other laws.
    """
    drawn = drawn_contacts(params, inputs)
    parts = [
        part
        for (_, basis), rows in drawn.groupby(["contact_law", "friction_basis"])
        for part in _of_basis(params, inputs, cast("FrictionBasis", basis), rows, tuple(claims))
    ]
    if not parts:
        return pd.DataFrame(columns=list(COLUMNS))
    table = pd.concat(parts)
    # In the order of the claims and the draws, whatever the basis of friction.
    order = {name: number for number, name in enumerate(claims)}
    table = table.assign(order=table["claim"].map(order)).reset_index(names="row")
    return table.sort_values(["order", "row"], kind="stable")[list(COLUMNS)]


def _of_basis(
    params: Common,
    inputs: Mapping[str, pd.DataFrame],
    basis: FrictionBasis,
    rows: pd.DataFrame,
    claims: tuple[str, ...],
) -> Iterator[pd.DataFrame]:
    """Yield the numbers of each quantity for the draws of one basis of friction."""
    context = Context(
        params=replace(params, steel=replace(params.steel, friction_basis=basis)),
        inputs=inputs,
        case=params.steel.cases[0],
        contacts=posterior_contact(inputs, rows),
    )
    draws = rows.rename(columns={"case": "contact"})[list(DRAW)]
    for name in claims:
        try:
            numbers = list(flat(CLAIMS[name].numbers(context), ""))
        except UNCOMPUTABLE:
            continue
        values = [np.broadcast_to(value, len(rows)) for *_, value in numbers]
        known = np.all(np.isfinite(values), axis=0)
        for (alternative, quantity, _), value in zip(numbers, values, strict=True):
            part = draws.assign(claim=name, alternative=alternative, quantity=quantity, value=value)
            yield part[known]
