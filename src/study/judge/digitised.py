"""Whether digitised points of the article's figures agree, as rows of the claims ledger."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from study.claims.claim import Number
from study.judge.judging import margins, results, verdict
from study.judge.words import bounds, computed_values, fails, sentence
from study.tables import Row

if TYPE_CHECKING:
    import pandas as pd

CODE = "study.analyses.digitised_comparison.run"


# Greatest rms of the differences over their standard uncertainties, if all points have bars; else
# the greatest rms of the differences, by figure, in the unit of its ordinate.
NORMALISED_RMS = 2.0
RMS_DIFFERENCE = {"fig20": 4.0, "fig24": 0.2, "fig25": 0.2}
RMS_ELSEWHERE = 0.05
REASON = (
    "Points with error bars (taken as 95 % intervals) may differ by an rms of two standard "
    "uncertainties. For points without, the rms difference may be the width of the range that the "
    "article prints for the restitution of steel on silicon; in Fig. 20 a twentieth of the largest "
    "force, in Figs. 24 and 25 a twentieth of the ordinate."
)


def digitised_rows(residuals: pd.DataFrame) -> tuple[list[Row], list[Row]]:
    """Return the verdict on every series of digitised points, and the results behind it.

    It is judged against the computed series of its panel that bears its name, alone or before a
    comma; if none does, all are cases: points that some meet and others do not identify none.

    Parameters
    ----------
    residuals
        Table of that name, a row per series of points and computed series; may be empty.

    Returns
    -------
    ledger, results : list of dict
        A row per series of points with the columns of the ledger, and a row per number with those
        of the table of results.
    """
    keys = ["figure", "panel", "points", "points_evidence"]
    judged = [_judged(rows) for _, rows in residuals.groupby(keys, sort=False)]
    return [row for row, _ in judged], [row for _, rows in judged for row in rows]


def _judged(residuals: pd.DataFrame) -> tuple[Row, list[Row]]:
    """Judge one series of points."""
    keys = ("figure", "panel", "points", "points_evidence")
    figure, panel, points, evidence = (str(residuals[key].iloc[0]) for key in keys)
    number = figure.removeprefix("fig")
    name = f"D{number}-{panel}-{points}"
    deciding = _deciding(residuals)
    quantity, criterion = _criterion(figure, deciding)
    unit = str(residuals["unit"].iloc[0]).replace("1", "-")
    units = {"rms_difference": unit, "normalised_rms": "-", "bias": unit}
    labels = {quantity: quantity.replace("_", " ") for quantity in units}
    numbers = deciding.melt("series", [*units], "quantity").dropna(subset="value")
    numbers = numbers.rename(columns={"series": "case"}).assign(error=math.nan)
    rows = results(numbers, {quantity: criterion}, labels, units)
    if deciding.empty:
        finding, note = "not testable", "No point lies where a series is computed"
    else:
        finding = verdict("reproduced", margins({quantity: criterion}, deciding))
        note = "; ".join(sentence(row) for row in rows if fails(row)) or REASON
        if beyond := int(residuals["beyond"].max()):
            note += f" Not judged: {beyond} points beyond a curve."
    row: Row = {
        "id": name,
        "where": f"Fig. {int(number)}, panel {panel}",
        "statement": f"Points {evidence}{' from' if evidence == 'digitised' else ', as in'}"
        f" Fig. {int(number)}, series {points}, agree with"
        " the computed curve within the criterion.",
        "kind": "digitised",
        "criterion": f"{labels[quantity]} {bounds(criterion.row)}",
        "article_value": f"{int(residuals[['n', 'beyond']].iloc[0].sum())} points",
        "computed_value": computed_values(rows),
        "unit": unit,
        "verdict": finding,
        "independent": "",
        "evidence": evidence,
        "figures": figure,
        "code": CODE,
        "inputs": "digitised_residuals",
        "reason": REASON,
        "note": note,
    }
    return row, [{"id": name, **row} for row in rows]


def _deciding(residuals: pd.DataFrame) -> pd.DataFrame:
    """Return the series with points in their range: those named as the points, else all."""
    within = residuals[residuals["n"] > 0]
    named = within[within["named"].astype(bool)]
    return within if named.empty else named


def _criterion(figure: str, deciding: pd.DataFrame) -> tuple[str, Number]:
    """Return quantity and bound: of points with error bars if all have one, else the figure's."""
    if len(deciding) and (deciding["bars"] == deciding["n"]).all():
        return "normalised_rms", Number(at_most=NORMALISED_RMS)
    return "rms_difference", Number(at_most=RMS_DIFFERENCE.get(figure, RMS_ELSEWHERE))
