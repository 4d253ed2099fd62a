"""Claims ledger: the verdict on every claim from the numbers that were computed for it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from microimpact.core.nearest import nearest
from microimpact.ledgers.claims.criteria import NOT_COMPUTED, Amendment, Claim, Finding, read_claims
from microimpact.ledgers.claims.digitised import digitised_rows, read_digitised
from microimpact.ledgers.claims.independent import independent
from microimpact.ledgers.claims.judging import (
    NO_ERRORS,
    Numbers,
    described,
    failures,
    judged,
    least_margin,
    place,
)
from microimpact.ledgers.claims.shares import Share, shares

# Loaded where a ledger is judged: the pages, which read it as text, do without.
if TYPE_CHECKING:
    import pandas as pd

# Begins what a note tells of a part that was changed.
CHANGED = "Changed after first judging"

COLUMNS = (
    *("id", "where", "statement", "kind", "criterion", "article_value", "computed_value"),
    *("unit", "verdict", "margin", "share", "decided_by", "independent", "evidence"),
    *("figures", "code", "inputs", "reason", "note"),
)

NO_SHARES: Mapping[str, Share] = {}


class LedgerError(ValueError):
    """Numbers that do not belong to the claims, or claims without numbers: one line each."""


def judge(
    tables: Mapping[str, pd.DataFrame],
    criteria: Path | str,
    values: Mapping[str, Any] | None = None,
) -> pd.DataFrame:
    """Return the verdict on every claim of a file, from tables of numbers.

    `tables`: ``claim_numbers``; ``claim_draws`` and ``admissible_contacts``, for the shares;
    ``external_evidence``; and ``digitised_residuals``, whose series of digitised points have rows
    after the claims. `criteria`, `values`: file of claims and values in its words, see
    `read_claims`.
    """
    import pandas as pd

    read = read_claims(criteria, values)
    drawn = shares(read, tables["claim_draws"], tables["admissible_contacts"])
    claims = verdicts(read, tables["claim_numbers"], drawn)
    told = independent(read, tables["external_evidence"])
    claims["independent"] = [told.get(name, "") for name in claims["id"]]
    rows = digitised_rows(read_digitised(criteria), tables["digitised_residuals"])
    if not rows:
        return claims
    return pd.concat([claims, pd.DataFrame(rows, columns=list(COLUMNS))], ignore_index=True)


def verdicts(
    claims: Mapping[str, Claim], numbers: pd.DataFrame, drawn: Mapping[str, Share] = NO_SHARES
) -> pd.DataFrame:
    """Return the verdict on every claim.

    Parameters
    ----------
    drawn
        Shares of the admissible contacts that meet the criteria. Where there is one, it decides,
        and the calibrated cases are examples.

    Returns
    -------
    pandas.DataFrame
        One row per claim with `COLUMNS`: the numbers behind the verdict and which criterion of
        which case failed, or why the claim could not be computed.

    Raises
    ------
    LedgerError
        If a number is missing, not finite, of an unknown claim, case or quantity, or of another
        unit than declared.
    """
    import pandas as pd

    # A column without any text has been read as one of missing numbers.
    names = ("case", "inputs", "problem")
    text = {name: numbers[name].astype(object).fillna("") for name in names}
    numbers = numbers.assign(**text)
    problems = [line for claim in claims.values() for line in _problems(claim, numbers)]
    strangers = [str(name) for name in dict.fromkeys(numbers["claim"]) if name not in claims]
    problems += [f"{name}: no such claim{nearest(name, claims)}" for name in strangers]
    if problems:
        raise LedgerError("\n".join(problems))
    found = [_row(claim, numbers, drawn.get(name)) for name, claim in claims.items()]
    return pd.DataFrame(found, columns=list(COLUMNS))


def verdict(
    claim: Claim, values: Numbers, errors: Numbers = NO_ERRORS
) -> tuple[Finding, list[str]]:
    """Return the verdict on one claim, and which criteria failed, in words.

    Parameters
    ----------
    values, errors
        Numbers by quantity, by case, and standard errors; the only case of a claim without
        alternatives is ``""``.
    """
    if not claim.testable:
        return "not testable", []
    unidentified = failures(claim.identified_if, values)
    if unidentified:
        return "not identified", unidentified
    return judged(claim.if_met, claim.criteria, values, errors)


def _problems(claim: Claim, numbers: pd.DataFrame) -> list[str]:
    own = numbers[(numbers["claim"] == claim.id) & (numbers["problem"] == "")]
    whole = len(own) == (numbers["claim"] == claim.id).sum()
    cases = claim.cases or ("",)
    names = claim.quantities if claim.testable else ()
    wanted = {(case, name) for case in cases for name in names}
    given = list(zip(own["case"], own["quantity"], strict=True))
    missing = sorted(wanted - set(given)) if whole else []
    lines = [f"{claim.id}: {place(*key)} is missing" for key in missing]
    for key, unit, value in zip(given, own["unit"], own["value"], strict=True):
        if key not in wanted:
            lines.append(f"{claim.id}: {place(*key)} is not declared")
        elif unit != claim.quantities[key[1]]:
            lines.append(f"{claim.id}: {place(*key)} in {unit}, not {claim.quantities[key[1]]}")
        elif not np.isfinite(value):
            lines.append(f"{claim.id}: {place(*key)} = {value} must be finite")
    if len(set(given)) != len(given):
        lines.append(f"{claim.id}: a number is given twice")
    return lines


def _row(claim: Claim, numbers: pd.DataFrame, share: Share | None) -> dict[str, object]:
    own = numbers[numbers["claim"] == claim.id]
    computed = own[own["problem"] == ""]
    values, errors = (
        {
            str(case): dict(zip(rows["quantity"], rows[column].astype(float), strict=True))
            for case, rows in computed.groupby("case", sort=False)
        }
        for column in ("value", "error")
    )
    found: Finding
    if len(computed) == len(own):
        found, failed = verdict(claim, values, errors)
        if share and claim.testable:
            found, failed = share.verdict(claim.if_met), [share.in_words(), *failed]
    else:
        lacking = own[own["problem"] != ""]
        found = NOT_COMPUTED
        failed = [
            f"{case}: {problem}" if case else str(problem)
            for case, problem in zip(lacking["case"], lacking["problem"], strict=True)
        ]
    told = "; ".join(
        f"{place(case, name)} = {value:.6g}"
        + ("" if claim.quantities[name] == "-" else f" {claim.quantities[name]}")
        for case, some in values.items()
        for name, value in some.items()
    )
    return {
        "id": claim.id,
        "where": claim.where,
        "statement": claim.statement,
        "kind": claim.kind,
        "criterion": "; ".join(f"{c.quantity} {described(c)}" for c in claim.criteria),
        "article_value": claim.article_value,
        "computed_value": told,
        "unit": claim.unit,
        "verdict": found,
        "share": share.share if share else math.nan,
        "decided_by": share.decided_by if share else "",
        "independent": "",
        "margin": least_margin((*claim.identified_if, *claim.criteria), values, errors),
        "evidence": "; ".join(dict.fromkeys(own["evidence"])),
        "figures": " ".join(claim.figures),
        "code": " ".join(dict.fromkeys(own["code"])),
        "inputs": " ".join(sorted({name for text in own["inputs"] for name in text.split()})),
        "reason": claim.reason,
        "note": " | ".join(["; ".join(failed) or claim.reason, *map(in_words, claim.amendments)]),
    }


def in_words(amendment: Amendment) -> str:
    """Return what was changed after a claim had first been judged, and why."""
    was, now = (text.rstrip(".") for text in (amendment.was, amendment.now))
    return f"{CHANGED}, {amendment.part}: was {was}; now {now}. {amendment.reason}"
