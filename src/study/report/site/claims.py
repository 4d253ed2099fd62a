"""The ledger of claims in one file for programs, and the schema of that file."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

from pydantic import TypeAdapter

from study.report.site.ledgers import Row

FILE, SCHEMA = "files/claims.json", "files/claims.schema.json"
# Verdicts that a criterion does not decide.
OPEN = frozenset({"not identified", "undecided", "not testable", "not computed"})
# Standard errors from the bound beyond which a verdict is firm.
FIRM = 5.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Number:
    """A number of a claim in a case, with the test that it must pass, if there is one."""

    case: str
    quantity: str
    label: str
    value: float | None
    error: float | None  # Standard error; none where it is exact or not known
    unit: str
    test: str
    low: float | None
    high: float | None
    passed: bool | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Share:
    """Share of the drawn contacts that meet a claim's criteria in a scenario, 95 % interval."""

    scenario: str
    law: str
    alternative: str
    share: float
    low: float
    high: float
    effective_size: float  # Independent contacts that the draws are worth


@dataclass(frozen=True, slots=True, kw_only=True)
class Amendment:
    """A change of a claim after its first judgement."""

    part: str
    was: str
    now: str
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """A statement of the article in our words, its place there, and the verdict on it."""

    id: str
    where: str  # Sections and figures, first the one of the quote
    quote: str  # Empty for a finding of this study
    statement: str
    kind: str
    article_value: str
    unit: str
    criterion: str
    reason: str  # Of the criterion
    numbers: list[Number]
    verdict: str
    confidence: str  # open, exact, firm or weak: by verdict and standard errors from the bound
    note: str
    shares: list[Share]
    decided_by: str
    independent: str
    evidence: str
    figures: list[str]
    code: list[str]
    inputs: list[str]
    changed_inputs: list[str]
    amendments: list[Amendment]


@dataclass(frozen=True, slots=True, kw_only=True)
class Claims:
    """All claims of a run, and the commit of the project that made it."""

    commit: str | None
    claims: list[Claim]


def claims_json(
    claims: Sequence[Row],
    results: Mapping[str, Sequence[Row]],
    shares: Mapping[str, Sequence[Row]],
    amendments: Mapping[str, Sequence[Row]],
    commit: str | None,
) -> str:
    """Return the ledger of claims as JSON.

    Parameters
    ----------
    claims
        Rows of the table ``claims``, as text.
    results, shares, amendments
        Rows of ``claim_results``, ``claim_shares`` and ``claim_amendments`` by claim.
    commit
        Of the run's project, if it is known.
    """
    entries = [
        {
            **row,
            "confidence": confidence(row),
            "numbers": [_known(each) for each in results.get(row["id"], ())],
            "shares": [_part(Share, each) for each in shares.get(row["id"], ())],
            "changed_inputs": row["changed_inputs"].split("; ") if row["changed_inputs"] else [],
            **{name: row[name].split() for name in ("figures", "code", "inputs")},
            "amendments": list(amendments.get(row["id"], ())),
        }
        for row in claims
    ]
    whole = adapter.validate_python(
        {"commit": commit, "claims": [_part(Claim, entry) for entry in entries]}
    )
    return json.dumps(adapter.dump_python(whole), indent=1, ensure_ascii=False) + "\n"


def confidence(row: Row) -> str:
    """Return how far a verdict is from another: open, exact, firm or weak."""
    if row["verdict"] in OPEN:
        return "open"
    if row["shares"]:  # decided beyond their intervals
        return "firm"
    if not row["margin"]:
        return "exact"
    return "firm" if abs(float(row["margin"])) >= FIRM else "weak"


def schema_json() -> str:
    """Return the JSON schema of the file."""
    return json.dumps(adapter.json_schema(), indent=1, ensure_ascii=False) + "\n"


def _part(kind: type, entry: Mapping[str, Any]) -> dict[str, Any]:
    """Return the entries that a dataclass has; text that is missing is empty."""
    return {field.name: entry.get(field.name, "") for field in fields(kind)}


def _known(row: Row) -> dict[str, Any]:
    """Return a row whose missing numbers are none."""
    numbers = ("value", "error", "low", "high", "passed")
    return {**_part(Number, row), **{name: row.get(name) or None for name in numbers}}


adapter = TypeAdapter(Claims)
