"""Claims ledger: the verdict on every claim from the numbers that were computed for it."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from itertools import compress, product
from typing import TYPE_CHECKING, Any

import numpy as np

from microimpact.core.materials import declared_file
from study.claims.claim import Claim
from study.judge.changed import Changed, with_inputs
from study.judge.criteria import UNDECIDED, declared_claims
from study.judge.independent import agreements, independent
from study.judge.judging import (
    RESULT_COLUMNS,
    judged,
    margins,
    nearest_margin,
    results,
    verdict,
)
from study.judge.shares import GROUPS, Share, shares
from study.judge.words import bounds, computed_values, outcome
from study.tables import NOT_COMPUTED, NotComputedError, Row, text_rows

# Loaded where a ledger is judged: the pages, which read it as text, do without.
if TYPE_CHECKING:
    import pandas as pd

COLUMNS = (
    *("id", "where", "quote", "statement", "kind", "criterion", "article_value"),
    *("sentence", "computed_value", "unit", "verdict", "margin"),
    *("shares", "decided_by", "independent"),
    *("evidence", "figures", "code", "inputs", "changed_inputs", "reason"),
)
SHARE_COLUMNS = ("id", *GROUPS, "share", "low", "high", "effective_size")

NO_SHARES: Mapping[str, Share] = {}
AS_SHIPPED: Changed = {}


class LedgerError(ValueError):
    """Numbers that do not belong to the claims, or claims without numbers: one line each."""


def judge(
    tables: Mapping[str, pd.DataFrame],
    values: Mapping[str, Any] | None = None,
    changed: Changed = AS_SHIPPED,
) -> dict[str, pd.DataFrame]:
    """Return the verdict on every claim, from tables of numbers.

    Parameters
    ----------
    tables
        ``claim_numbers``; ``claim_draws`` and ``posterior_contacts``, for the shares; and
        ``external_evidence``.
    criteria, values
        File of claims and values in its words, see `read_claims`.
    changed
        Inputs of the studies that are not as shipped, see `changed.with_inputs`.

    Returns
    -------
    dict of pandas.DataFrame
        ``claims``, a row per claim; ``claim_results``, a row per number and its test;
        ``claim_shares``, a row per scenario, law and alternative; ``claim_evidence``, a row per
        fact found by others; ``claim_amendments``.
    """
    import pandas as pd

    claims = declared_claims(values)
    numbers, drawn = tables["claim_numbers"], NO_SHARES
    try:
        draws = tables["claim_draws"]
        drawn = shares(claims, draws, tables["posterior_contacts"]) if len(draws) else NO_SHARES
    except NotComputedError as why:  # these claims are not judged by their calibrated cases instead
        row = {"quantity": NOT_COMPUTED, "problem": str(why)}
        without = [{"claim": name, **row} for name, claim in claims.items() if claim.by_contact]
        numbers = pd.concat([numbers, pd.DataFrame(without)], ignore_index=True)
    ledger, tested = verdicts(claims, numbers, drawn)
    evidence = independent(claims, tables.get("external_evidence"))
    agreeing = agreements(evidence)
    ledger["independent"] = [agreeing.get(name, "") for name in ledger["id"]]
    marked = [with_inputs(row, changed) for _, row in ledger.iterrows()]
    counts = [
        (name, *group, met / size, *interval, size)
        for name, share in drawn.items()
        for (group, (met, size)), interval in zip(
            share.counts.items(), share.intervals, strict=True
        )
    ]
    return {
        "claims": pd.DataFrame(marked, columns=list(COLUMNS)),
        "claim_shares": pd.DataFrame(counts, columns=list(SHARE_COLUMNS)),
        "claim_results": pd.DataFrame(tested, columns=list(RESULT_COLUMNS)),
        "claim_evidence": evidence,
        "claim_amendments": pd.DataFrame(amendments()),
    }


def amendments() -> list[dict[str, str]]:
    """Return the changes of claims after their first judgement: rows of the declared file."""
    return text_rows(declared_file("amendments.csv"))


def verdicts(
    claims: Mapping[str, Claim], numbers: pd.DataFrame, drawn: Mapping[str, Share] = NO_SHARES
) -> tuple[pd.DataFrame, list[Row]]:
    """Return the verdict on every claim, and the results from which it follows.

    Parameters
    ----------
    drawn
        Shares of the drawn contacts that meet the criteria. Where there are some, they decide,
        and the calibrated cases are examples.

    Returns
    -------
    ledger : pandas.DataFrame
        One row per claim with `COLUMNS`.
    results : list of dict
        One row per number and its test with `RESULT_COLUMNS`.

    Raises
    ------
    LedgerError
        If a number is missing, not finite, or of an unknown case or quantity.
    """
    import pandas as pd

    # A column without any text has been read as one of missing numbers.
    names = ("case", "inputs", "problem", "code")
    text = {name: numbers[name].astype(object).fillna("") for name in names}
    numbers = numbers.assign(**text)
    problems = [line for claim in claims.values() for line in _problems(claim, numbers)]
    if problems:
        raise LedgerError("\n".join(problems))
    entries = [
        _judged(claim, numbers[numbers["claim"] == name], drawn.get(name))
        for name, claim in claims.items()
    ]
    ledger = pd.DataFrame([row for row, _ in entries], columns=list(COLUMNS))
    return ledger, [row for _, rows in entries for row in rows]


def _problems(claim: Claim, numbers: pd.DataFrame) -> list[str]:
    rows = numbers[numbers["claim"] == claim.id]
    computed = rows[rows["problem"] == ""]
    wanted = set(product(claim.cases or ("",), claim.numbers if claim.testable else ()))
    keys = list(zip(computed["case"], computed["quantity"], strict=True))
    finite = np.isfinite(computed["value"].to_numpy(float))
    problems = {
        "is missing": sorted(wanted - set(keys)) if len(computed) == len(rows) else [],
        "is not declared": [key for key in keys if key not in wanted],
        "must be finite": list(compress(keys, ~finite)),
        "is there twice": [key for key, count in Counter(keys).items() if count > 1],
    }
    return [
        f"{claim.id}: {quantity}{f' ({case})' if case else ''} {problem}"
        for problem, wrong in problems.items()
        for case, quantity in wrong
    ]


def _judged(claim: Claim, numbers: pd.DataFrame, share: Share | None) -> tuple[Row, list[Row]]:
    computed = numbers[numbers["problem"] == ""]
    lacking = numbers[numbers["problem"] != ""]
    labels = claim.labels
    rows = results(computed, claim.tests, labels, claim.units)
    because = ""
    if not claim.testable:
        decision, margin = "not testable", math.nan
    elif len(lacking):
        decision, margin = NOT_COMPUTED, math.nan
        because = "; ".join(
            f"{case}: {problem}" if case else str(problem)
            for case, problem in zip(lacking["case"], lacking["problem"], strict=True)
        )
    else:
        decision, margin = _decision(claim, computed)
        if share:
            decision = judged(claim.if_met, share.intervals)
    if claim.assumed and decision == "not reproduced":
        decision = "not identified"
        because = f"Inputs that decide are assumed: {claim.assumed}."
    if decision == UNDECIDED:
        because = "The sampling error covers what would decide."
    decided_by = share.decided_by if share else claim.assumed
    percents = [100.0 * met / drawn for met, drawn in share.counts.values()] if share else []
    said = "" if len(lacking) else outcome(claim.says, rows, percents, decided_by)
    row = {
        "id": claim.id,
        "where": claim.where,
        "quote": claim.quote,
        "statement": claim.statement,
        "kind": claim.kind,
        "criterion": "; ".join(f"{labels[n]} {bounds(c.row)}" for n, c in claim.criteria.items()),
        "article_value": claim.article,
        "sentence": " ".join(filter(None, [said, because])) or claim.reason,
        "computed_value": computed_values(rows),
        "unit": claim.unit,
        "verdict": decision,
        "shares": share.in_words() if share else "",
        "decided_by": decided_by,
        "independent": "",
        "margin": margin,
        "evidence": claim.evidence,
        "figures": claim.figures,
        "code": " ".join(filter(None, dict.fromkeys(numbers["code"]))),
        "inputs": " ".join(sorted({name for text in numbers["inputs"] for name in text.split()})),
        "changed_inputs": "",
        "reason": claim.reason,
    }
    return row, [{"id": claim.id, **row} for row in rows]


def _decision(claim: Claim, numbers: pd.DataFrame) -> tuple[str, float]:
    """Return the verdict by the cases of a claim, and the margin that decides it."""
    values, errors = (
        numbers.pivot(index="case", columns="quantity", values=column)
        for column in ("value", "error")
    )
    margin = margins(claim.tests, values, errors)
    if claim.identified_if and np.any(margins(claim.identified_if, values) < 0.0):
        return "not identified", nearest_margin(margin)
    return verdict(claim.if_met, margins(claim.criteria, values, errors)), nearest_margin(margin)
