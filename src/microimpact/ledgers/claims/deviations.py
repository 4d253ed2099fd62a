"""Deviations from the article as a page: what was corrected, not reproduced or changed.

All words and numbers come from the two ledgers and the file of claims; nothing is written by hand.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, cast

import pandas as pd

from microimpact.ledgers.claims.criteria import (
    CLAIM_NAME,
    UNCOUNTED,
    Amendment,
    Claim,
    read_claims,
)
from microimpact.ledgers.claims.words import Cell, article_value, by_quantity, readable

# Verdicts on claims that the page explains, in its order, and what each means.
CLAIM_VERDICTS: Mapping[str, str] = {
    "not reproduced": "A criterion fails in every case that the published facts leave open.",
    "not identified": "The published facts do not decide: some of the contacts that fit them meet"
    " the criteria and others do not, or the interval they leave is too wide.",
    "reproduced with a correction": "All criteria hold once an equation or relation is corrected.",
    "undecided": "The 95 % interval of a number covers the bound that decides.",
    "not testable": "Nothing is published that could be compared with a computation.",
    "not computed": "The settings of the run do not allow the numbers to be computed; the reason is"
    " the program's own message.",
}

Row = Mapping[str, Any]

CORRECTED = ("corrected", "typographical slip")
SLIPS: Mapping[str, str] = {
    "scan": "a misreading by the scanner or a misprint",
    "article": "an error of the article",
    "scan or article": "a fault of the scan or an error of the article",
}


def deviations(results: Path, criteria: Path, settings: str) -> str:
    """Return the page, in Markdown.

    Parameters
    ----------
    results
        Folder with ``tables/claims.csv`` and ``tables/equations.csv``.
    criteria
        The file of claims, see `criteria.read_claims`.
    settings
        The file of the run's settings, to be named at the top.

    Raises
    ------
    ValueError
        If the table and the file do not hold the same claims.
    """
    tables = results / "tables"
    claims, equations = (
        pd.read_csv(tables / name, keep_default_na=False)
        for name in ("claims.csv", "equations.csv")
    )
    # Rows after the claims are about digitised points of the user's own.
    claims = claims[claims["id"].str.match(CLAIM_NAME)]
    declared = read_claims(criteria)
    strangers = set(claims["id"]) ^ set(declared)
    if strangers:
        raise ValueError(
            f"{tables / 'claims.csv'} and {criteria} do not hold the same claims:"
            f" {', '.join(sorted(strangers))} in one of them only; run the study again"
        )
    return (
        "\n\n".join(
            [
                *_opening(claims, equations, settings),
                *_equation_part(equations),
                *_claim_part(claims, declared),
                *_amendment_part(declared),
            ]
        ).rstrip()
        + "\n"
    )


def verdict_counts(claims: pd.DataFrame) -> dict[str, int]:
    """Return how many claims got each verdict; identities and own findings are not counted."""
    counted = claims[~claims["kind"].isin(UNCOUNTED)]
    return {str(name): int(count) for name, count in counted["verdict"].value_counts().items()}


def _opening(claims: pd.DataFrame, equations: pd.DataFrame, settings: str) -> list[str]:
    return [
        "# Deviations from the article",
        "Every equation that had to be corrected, every statement that is not reproduced as"
        " printed, and every criterion that was changed after first judging. This page is made by"
        " `microimpact deviations` from the tables `equations` and `claims` and from"
        " `config/claims.yaml`; do not edit it. Statements and reasons are in our words.",
        f"The numbers are those of the settings in `{settings}`.",
        _table(
            ("equations and relations", "number"),
            [
                (str(name), str(count))
                for name, count in equations["verdict"].value_counts().items()
            ],
        ),
        _table(
            ("statements, without identities and findings of this study", "number"),
            [(name, str(count)) for name, count in verdict_counts(claims).items()],
        ),
    ]


def _equation_part(equations: pd.DataFrame) -> list[str]:
    wrong = equations[equations["verdict"].isin(CORRECTED)]
    choices = equations[equations["verdict"] == "undecidable"]
    return [
        "## Equations that were corrected",
        "Formulas are written as in code; `vp` and `Vp` are velocities in the frame of a facet."
        " Each was checked for its dimension and derived anew, as the column `evidence` of"
        " `tables/equations.csv` describes. Numbers are those of a steel sphere of 62 µm on silicon"
        " at 1.66 m/s, unless said otherwise.",
        *(_equation(row) for row in _rows(wrong)),
        "## Choices that the text leaves open",
        *(_equation(row) for row in _rows(choices)),
    ]


def _equation(row: Row) -> str:
    identity, section = str(row["equation"]), str(row["section"])
    # An unnumbered relation is named by its section and a word.
    heading = (
        f"{section}: {identity.removeprefix(section).strip()}"
        if identity.startswith(f"{section} ")
        else f"Eq. {identity} ({section})"
    )
    lines = [f"### {heading}", f"- as printed: `{row['printed']}`"]
    if row["used"] != row["printed"]:
        lines.append(f"- as used: `{row['used']}`")
    slip = SLIPS.get(str(row["kind_of_slip"]))
    lines.append(f"- why: {row['reason']}" + (f" Taken as {slip}." if slip else ""))
    if row["consequence"]:
        value = readable(float(str(row["consequence_value"])), str(row["consequence_unit"]))
        lines.append(f"- consequence: {row['consequence']}: **{value}**")
    if row["function"]:
        lines.append(f"- code: `{row['function']}`")
    return lines[0] + "\n\n" + "\n".join(lines[1:])


def _claim_part(claims: pd.DataFrame, declared: Mapping[str, Claim]) -> list[str]:
    changed = sum(bool(claim.amendments) for claim in declared.values())
    parts = [
        "## Statements",
        f"Criteria were fixed first; {changed} were changed later, listed at the end. Numbers that"
        " fail a criterion are bold; a number without a criterion is given because it helps to"
        " understand the others.",
    ]
    for verdict, meaning in CLAIM_VERDICTS.items():
        rows = _rows(claims[claims["verdict"] == verdict])
        if rows:
            parts += [f"## Statements {verdict}", meaning]
            parts += [_claim(row, declared[str(row["id"])]) for row in rows]
    return parts


def _claim(row: Row, claim: Claim) -> str:
    parts = [f"### {claim.id} ({claim.where})", claim.statement]
    if computed := str(row["computed_value"]):
        parts += [f"The article: {article_value(claim)}.", _numbers(computed, claim)]
    parts.append(f"Reason: {claim.reason}")
    if claim.equations:
        parts.append(f"It depends on Eq. {', '.join(claim.equations)}.")
    if code := str(row.get("code", "")):
        parts.append("Code: " + ", ".join(f"`{path}`" for path in code.split()) + ".")
    return "\n\n".join(parts)


def _numbers(computed: str, claim: Claim) -> str:
    """Return the numbers of a claim as a table: one row per quantity, one column per case."""
    found = by_quantity(computed, claim)
    return _table(
        ("quantity", "criterion", *(case or "computed" for case in found[0].cells)),
        [
            (one.words, one.criterion, *(_cell(cell) for cell in one.cells.values()))
            for one in found
        ],
    )


def _cell(cell: Cell) -> str:
    return cell.text if cell.holds else f"**{cell.text}**"


def _amendment_part(declared: Mapping[str, Claim]) -> list[str]:
    changed = [(claim, one) for claim in declared.values() for one in claim.amendments]
    return [
        "## Criteria changed after judging",
        "A criterion may be changed later only for a reason that does not depend on the verdict,"
        " and the change is declared in `config/claims.yaml` beside the claim.",
        *([_amendment(claim, one) for claim, one in changed] or ["None was changed."]),
    ]


def _amendment(claim: Claim, amendment: Amendment) -> str:
    return "\n".join(
        (
            f"### {claim.id}, {amendment.part} ({claim.where})\n",
            f"- was: {amendment.was}",
            f"- now: {amendment.now}",
            f"- why: {amendment.reason}",
        )
    )


def _rows(table: pd.DataFrame) -> list[Row]:
    return cast("list[Row]", table.to_dict("records"))


def _table(header: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    head = list(header)
    lines = [head, ["---"] * len(head), *map(list, rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
