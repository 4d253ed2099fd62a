"""Numbers of claims over the contacts of steel on silicon that the printed statements admit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from microimpact.lab.contacts import DRAWN, admissible_contact
from microimpact.model.contact import Contact
from microimpact.studies.claims.claim_numbers.claim import CLAIMS, UNCOMPUTABLE, flat
from microimpact.studies.claims.claim_numbers.context import Context
from microimpact.studies.claims.claim_numbers.params import Params

COLUMNS = ("claim", "contact", "variant", "draw", "alternative", "quantity", "value")
Row = tuple[str, str, str, int, str, str, float]


def chosen(params: Params, inputs: Mapping[str, pd.DataFrame]) -> list[pd.Series[Any]]:
    """Return the draws that are taken of every variant, evenly over all of its draws."""
    table, wanted = inputs["admissible_contacts"], params.draws
    found: list[pd.Series[Any]] = []
    for variant, count in wanted.variants.items():
        own = table[(table["case"] == wanted.case) & (table["variant"] == variant)]
        if own.empty:
            raise ValueError(f"admissible_contacts: no draw of {wanted.case}, {variant}")
        places = np.unique(np.linspace(0, len(own) - 1, count).astype(int))
        found += [own.iloc[place] for place in places]
    return found


def drawn_contact(inputs: Mapping[str, pd.DataFrame], row: pd.Series[Any]) -> Contact:
    """Return the contact of one draw, all of its numbers single ones."""
    numbers: dict[str, Any] = {field: float(row[column]) for column, field in DRAWN.items()}
    numbers["diameter"] *= 1e-6
    return admissible_contact(inputs, str(row["case"]), str(row["variant"]), **numbers)


def rows_of(
    params: Params, inputs: Mapping[str, pd.DataFrame], row: pd.Series[Any]
) -> Iterator[Row]:
    """Yield the numbers of all claims for one draw.

    Friction and its basis are those of the draw, all else as for the calibrated cases. A claim
    that cannot be computed with a draw has no row.
    """
    steel = replace(
        params.steel,
        friction=float(row["friction"]),
        friction_basis=row["friction_basis"],
    )
    context = Context(
        params=replace(params, steel=steel),
        inputs=inputs,
        case=steel.cases[0],
        drawn=drawn_contact(inputs, row),
    )
    for name in params.draws.claims:
        try:
            found = list(flat(CLAIMS[name].of(context), ""))
        except UNCOMPUTABLE:
            continue
        for alternative, quantity, number, _ in found:
            place = str(row["case"]), str(row["variant"]), int(row["draw"])
            yield name, *place, alternative, quantity, number.value
