"""The ledger of claims for programs, as JSON with its schema."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

from pydantic import BeforeValidator, TypeAdapter

from study.report.site.ledgers import Row

# Verdicts that a criterion does not decide.
OPEN = frozenset({"not identified", "undecided", "not testable", "not computed"})
# Standard errors from the bound beyond which a verdict is firm.
FIRM = 5.0

# Cells of the ledger, which are text.
EMPTY_IS_NONE = BeforeValidator(lambda text: text or None)
Number = Annotated[float | None, EMPTY_IS_NONE]
Names = Annotated[list[str], BeforeValidator(str.split)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """A number of a claim in a case, with the test that it must pass, if there is one."""

    case: str
    quantity: str
    label: str
    value: Number
    error: Number  # Standard error; none where it is exact or not known
    unit: str
    test: str
    low: Number
    high: Number
    passed: Annotated[bool | None, EMPTY_IS_NONE]


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
    quote: str
    statement: str
    kind: str
    article_value: str
    unit: str
    criterion: str
    reason: str  # Of the criterion
    numbers: list[Result]
    verdict: str
    confidence: str  # open, exact, firm or weak: by verdict and standard errors from the bound
    sentence: str  # The numbers in words, and why the verdict is open
    shares: list[Share]
    decided_by: str
    independent: str
    evidence: str
    figures: Names
    code: Names
    inputs: Names
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
            "numbers": results[row["id"]],
            "shares": shares[row["id"]],
            "changed_inputs": row["changed_inputs"].split("; ") if row["changed_inputs"] else [],
            "amendments": amendments[row["id"]],
        }
        for row in claims
    ]
    whole = CLAIMS.validate_python({"commit": commit, "claims": entries})
    return _text(CLAIMS.dump_python(whole))


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
    """Return the JSON schema of the ledger of claims."""
    return _text(CLAIMS.json_schema())


def _text(content: object) -> str:
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


CLAIMS = TypeAdapter(Claims)
