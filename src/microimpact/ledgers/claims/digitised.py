"""Whether digitised points of the article's figures agree, as rows of the claims ledger."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from microimpact.declared.documents import load
from microimpact.declared.parameters import Name, Positive, build, explain
from microimpact.ledgers.claims.criteria import (
    DIGITISED,
    ClaimsError,
    Criterion,
    FigureName,
    Finding,
)
from microimpact.ledgers.claims.judging import Numbers, described, judged, place

if TYPE_CHECKING:
    import pandas as pd

CODE = "microimpact.studies.analyses.digitised_comparison.run"
COMPARED = ("rms_difference", "normalised_rms", "bias")


@dataclass(frozen=True, slots=True, kw_only=True)
class DigitisedCriteria:
    """When digitised points agree with a computed curve; the key `DIGITISED` of the file."""

    # Greatest rms of the differences over their standard uncertainties, if all points have bars.
    normalised_rms: Positive
    # Else the greatest rms of the differences, by figure, in the unit of its ordinate.
    rms_difference: dict[FigureName, Positive]
    reason: Name  # Why these bounds decide


def read_digitised(path: Path | str) -> DigitisedCriteria:
    """Read the criteria of digitised points from a file of claims.

    Raises ClaimsError, naming the dotted key of every problem, one line each.
    """
    try:
        return build(DigitisedCriteria, load(path).get(DIGITISED, {}))
    except ValidationError as error:
        raise ClaimsError("\n".join(explain(error, DigitisedCriteria, DIGITISED))) from None


def digitised_rows(criteria: DigitisedCriteria, residuals: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the verdict on every series of digitised points.

    It is judged against the computed series of its panel that bears its name, alone or before a
    comma; if none does, all are cases: points that some meet and others do not identify none.

    A row per series of points, with the columns of the ledger. `criteria`: what counts as
    agreement; `residuals`: table of that name, a row per series of points and computed series; may
    be empty.
    """
    return list(_rows(criteria, residuals))


def _rows(criteria: DigitisedCriteria, residuals: pd.DataFrame) -> Iterator[dict[str, Any]]:
    for key, own in residuals.groupby(["figure", "panel", "points", "points_evidence"], sort=False):
        figure, panel, points, evidence = map(str, key)
        number = figure.removeprefix("fig")
        against = _against(own)
        criterion = _criterion(criteria, figure, against)
        verdict, note = _verdict(criteria, criterion, own, against)
        yield {
            "id": f"D{number}-{panel}-{points}",
            "where": f"Fig. {int(number)}, panel {panel}",
            "statement": f"Points {evidence}{' from' if evidence == 'digitised' else ', as in'}"
            f" Fig. {int(number)}, series {points}, agree with"
            " the computed curve within the criterion.",
            "kind": "digitised",
            "criterion": f"{criterion.quantity} {described(criterion)}",
            "article_value": f"{int(own[['n', 'beyond']].iloc[0].sum())} points",
            "computed_value": "; ".join(
                f"{place(case, name)} = {value:.6g}"
                for case, values in _numbers(against, COMPARED).items()
                for name, value in values.items()
                if not math.isnan(value)
            ),
            "unit": str(own["unit"].iloc[0]).replace("1", "-"),
            "verdict": verdict,
            "evidence": evidence,
            "figures": figure,
            "code": CODE,
            "reason": criteria.reason,
            "note": note,
        }


def _against(own: pd.DataFrame) -> pd.DataFrame:
    """Return the rows that decide: of series with points in their range, those named alike."""
    within = own[own["n"] > 0]
    named = within[within["named"].astype(bool)]
    return within if named.empty else named


def _criterion(criteria: DigitisedCriteria, figure: str, against: pd.DataFrame) -> Criterion:
    """Return that of points with error bars if all have one, else that of the figure."""
    if len(against) and (against["bars"] == against["n"]).all():
        return Criterion(quantity="normalised_rms", test="at_most", value=criteria.normalised_rms)
    if figure not in criteria.rms_difference:
        raise ValueError(f"digitised.rms_difference: {figure} has no bound")
    bound = criteria.rms_difference[figure]
    return Criterion(quantity="rms_difference", test="at_most", value=bound)


def _verdict(
    criteria: DigitisedCriteria, criterion: Criterion, own: pd.DataFrame, against: pd.DataFrame
) -> tuple[Finding, str]:
    if against.empty:
        return "not testable", "No point lies where a series is computed"
    verdict, failed = judged("reproduced", [criterion], _numbers(against, (criterion.quantity,)))
    beyond = int(own["beyond"].max())
    words = "; ".join(failed) or criteria.reason
    return verdict, f"{words} Not judged: {beyond} points beyond a curve." if beyond else words


def _numbers(rows: pd.DataFrame, names: tuple[str, ...]) -> Numbers:
    columns = list(names)
    return {
        str(series): dict(zip(names, values, strict=True))
        for series, values in zip(rows["series"], rows[columns].to_numpy(float), strict=True)
    }
