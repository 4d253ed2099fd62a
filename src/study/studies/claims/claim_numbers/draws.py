"""Numbers of claims over the contacts of steel on silicon that the printed statements admit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from microimpact.model.contact import Contact
from study.studies.claims.claim_numbers.claim import CLAIMS, flat
from study.studies.claims.claim_numbers.context import Context
from study.studies.claims.claim_numbers.params import Params
from study.studies.contacts import admissible_contact
from study.tables import UNCOMPUTABLE

COLUMNS = ("claim", "contact", "variant", "draw", "alternative", "quantity", "value")
Row = tuple[str, str, str, int, str, str, float]


def chosen(params: Params, inputs: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Return the draws that are taken of every variant, evenly over all of its draws."""
    table, wanted = inputs["admissible_contacts"], params.draws
    parts = []
    for variant, count in wanted.variants.items():
        draws = table[(table["case"] == wanted.case) & (table["variant"] == variant)]
        if draws.empty:
            raise ValueError(f"admissible_contacts: no draw of {wanted.case}, {variant}")
        parts.append(draws.iloc[np.unique(np.linspace(0, len(draws) - 1, count).astype(int))])
    return pd.concat(parts)


def drawn_contact(inputs: Mapping[str, pd.DataFrame], rows: pd.DataFrame) -> Contact:
    """Return the contact of all draws, its numbers arrays (draws,)."""
    renamed = rows.assign(variant=rows["variant"].iloc[0])
    case, variant = str(renamed["case"].iloc[0]), str(renamed["variant"].iloc[0])
    return admissible_contact({**inputs, "admissible_contacts": renamed}, case, variant)


def rows_of(
    params: Params, inputs: Mapping[str, pd.DataFrame], rows: pd.DataFrame
) -> Iterator[list[Row]]:
    """Yield the numbers of all claims for every draw.

    Friction and its basis are those of the draw, all else as for the calibrated cases. A claim
    that cannot be computed with a draw has no row.
    """
    # Those of one basis of friction together.
    results: dict[str, dict[tuple[object, ...], Any]] = {}
    drawn = {basis: drawn_contact(inputs, draws) for basis, draws in rows.groupby("friction_basis")}
    places = rows.groupby("friction_basis").cumcount()
    for index, (_, row) in zip(places, rows.iterrows(), strict=True):
        steel = replace(
            params.steel, friction=float(row["friction"]), friction_basis=row["friction_basis"]
        )
        context = Context(
            params=replace(params, steel=steel),
            inputs=inputs,
            case=steel.cases[0],
            drawn=drawn[row["friction_basis"]],
            draw=index,
            found_of_draws=results.setdefault(row["friction_basis"], {}),
        )
        yield list(_of_draw(context, row))


def _of_draw(context: Context, row: pd.Series[Any]) -> Iterator[Row]:
    for name in context.params.draws.claims:
        try:
            numbers = list(flat(CLAIMS[name].function(context), ""))
        except UNCOMPUTABLE:
            continue
        for alternative, quantity, number, _ in numbers:
            draw = str(row["case"]), str(row["variant"]), int(row["draw"])
            yield name, *draw, alternative, quantity, float(number.value)
