"""Deviations from the article as a page: what was corrected, not reproduced or changed.

All words and numbers come from the two ledgers and the file of claims; nothing is written by hand.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import jinja2
import pandas as pd

from microimpact.ledgers.claims.criteria import CLAIM_NAME, UNCOUNTED, read_claims
from microimpact.ledgers.claims.words import article_value, by_quantity, readable

TEMPLATE = Path(__file__).with_suffix(".md.jinja")

# Verdicts on claims that the page explains, in its order, and what each means.
CLAIM_VERDICTS: Mapping[str, str] = {
    "not reproduced": "A criterion fails in every case that the published facts leave open, or for"
    " 95 % or more of the contacts that they admit.",
    "not identified": "The published facts do not decide: some of the contacts that fit them meet"
    " the criteria and others do not, or the interval they leave is too wide.",
    "reproduced with a correction": "All criteria hold once an equation or relation is corrected.",
    "undecided": "The 95 % interval of a number covers the bound that decides.",
    "not testable": "Nothing is published that could be compared with a computation.",
    "not computed": "The settings of the run do not allow the numbers to be computed; the reason is"
    " the program's own message.",
}

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
    environment = jinja2.Environment(
        trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined, autoescape=False
    )
    environment.filters["readable"] = readable
    page = environment.from_string(TEMPLATE.read_text(encoding="utf-8")).render(
        settings=settings,
        equation_counts=equations["verdict"].value_counts().to_dict(),
        claim_counts=verdict_counts(claims),
        equations=equations.to_dict("records"),
        corrected=CORRECTED,
        slips=SLIPS,
        verdicts=CLAIM_VERDICTS,
        claims=claims.to_dict("records"),
        claim_verdicts=set(claims["verdict"]),
        declared=declared,
        amended=any(claim.amendments for claim in declared.values()),
        article_value=article_value,
        by_quantity=by_quantity,
    )
    return page.rstrip() + "\n"


def verdict_counts(claims: pd.DataFrame) -> dict[str, int]:
    """Return how many claims got each verdict; identities and own findings are not counted."""
    counted = claims[~claims["kind"].isin(UNCOUNTED)]
    return {str(name): int(count) for name, count in counted["verdict"].value_counts().items()}
