"""Files of the report for programs: the ledger of claims with its schema, drafts, the tables.

Drafts are replication chains in the form of FORRT nanopublications, as JSON-LD. A chain goes from a
quote of the article over an AIDA sentence (atomic, independent, declarative, absolute) and a claim
to the replication study and its outcome. A draft holds the assertion of each step as a named graph;
provenance, repository, date and signature are added by those who publish it. The tables are
described as a Data Package (frictionless).
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any
from urllib.parse import quote_plus

import pandas as pd
from pydantic import BeforeValidator, TypeAdapter

from study.report.site.ledgers import Row

if TYPE_CHECKING:
    from study.report.site.build import Table

# Verdicts that a criterion does not decide.
OPEN = frozenset({"not identified", "undecided", "not testable", "not computed"})
# Standard errors from the bound beyond which a verdict is firm.
FIRM = 5.0

ARTICLE = {"@id": "https://doi.org/10.1080/00218460008034531"}
CONTEXT = {
    "cito": "http://purl.org/spar/cito/",
    "hycl": "http://purl.org/petapico/o/hycl#",
    "rdfs": "http://www.w3.org/2000/01/rdf-schema#",
    "skos": "http://www.w3.org/2004/02/skos/core#",
    "slt": "https://w3id.org/sciencelive/o/terms/",
}
# A number of the claim has set a parameter of a calibrated one: agreement is no evidence.
STATUS = {
    "reproduced": "Validated",
    "reproduced with a correction": "PartiallySupported",
    "calibrated": "Inconclusive",
    "not identified": "Inconclusive",
    "undecided": "Inconclusive",
    "not reproduced": "Contradicted",
}
UNTESTED = "NotTested"

# Units at the ends of names of columns; other columns are pure numbers or text.
UNIT = re.compile(
    r"_((?:rad_per_s|J_per_m2|N_per_m|m_per_s|s_per_m)|percent|kHz|GPa|deg|Pa|[num]m|[num]s|[un]N|px|m)$"
)
TYPES = {"b": "boolean", "i": "integer", "u": "integer", "f": "number"}

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
    quote: str  # Empty for a finding of this study
    statement: str
    kind: str
    article_value: str
    unit: str
    criterion: str
    reason: str  # Of the criterion
    numbers: list[Result]
    verdict: str
    confidence: str  # open, exact, firm or weak: by verdict and standard errors from the bound
    note: str
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


def chains_json(claims: Iterable[Row], commit: str | None) -> str:
    """Return the drafts as JSON-LD.

    Parameters
    ----------
    claims
        Rows of the table ``claims``, as text; those without a quote have no chain.
    commit
        Of the run's project, if it is known.
    """
    graphs = [graph for row in claims if row.get("quote") for graph in _chain(row, commit)]
    return _text({"@context": CONTEXT, "@graph": graphs})


def _chain(row: Row, commit: str | None) -> list[dict[str, Any]]:
    quoted, aida, claim, study, outcome = (
        f"#{row['id']}-{step}" for step in ("quote", "aida", "claim", "study", "outcome")
    )
    sentence = f"http://purl.org/aida/{quote_plus(row['statement'])}"
    kind = "model_performance" if row["kind"] == "model" else "descriptive_pattern"
    status = STATUS.get(row["verdict"], UNTESTED)
    sure = "LowConfidence" if confidence(row) == "weak" else "HighConfidence"
    code = f"{row['code']} at commit {commit}" if commit else row["code"]
    steps: dict[str, dict[str, Any]] = {
        quoted: ARTICLE
        | {"cito:hasQuotedText": row["quote"], "rdfs:comment": f"Section {row['where']}"},
        aida: {
            "@id": sentence,
            "@type": "hycl:AIDA-Sentence",
            "cito:obtainsSupportFrom": ARTICLE,
            "skos:related": {"@id": quoted},
        },
        claim: {
            "@type": ["slt:FORRT-Claim", f"slt:{kind}-FORRT-Claim"],
            "rdfs:label": f"{row['id']}: {row['statement']}",
            "slt:asAidaStatement": {"@id": sentence},
        },
        study: {
            "@type": ["slt:FORRT-Replication-Study", "slt:Replication-Study"],
            "slt:targetsClaim": {"@id": claim},
            "slt:hasScopeDescription": f"Holds if {row['criterion']}.",
            "slt:hasMethodologyDescription": f"Computed by {code}; kind of test: {row['kind']}.",
        },
        outcome: {
            "@type": "slt:FORRT-Replication-Outcome",
            "slt:isOutcomeOf": {"@id": study},
            "slt:hasValidationStatus": {"@id": f"slt:{status}"},
            "slt:hasConfidenceLevel": {
                "@id": f"slt:{'Moderate' if status == 'Inconclusive' else sure}"
            },
            "slt:hasConclusionDescription": f"{row['verdict']}: {row['note']}",
            "slt:hasEvidenceDescription": row["computed_value"],
            "slt:hasLimitationsDescription": row["reason"],
        },
    }
    return [{"@id": name, "@graph": [{"@id": name} | step]} for name, step in steps.items()]


def datapackage(results: Path, tables: Iterable[Table]) -> str:
    """Return the content of every table, and type and unit of each of its columns."""
    about = metadata("microimpact")
    package = {
        "profile": "tabular-data-package",
        "name": "microimpact-results",
        "title": "Results of the microimpact study",
        "version": about["Version"],
        "licenses": [{"name": about["License-Expression"]}],
        "resources": [
            {
                "profile": "tabular-data-resource",
                "name": table.file.removesuffix(".csv").replace("/", "-").replace("_", "-"),
                "path": table.file,
                "description": table.words,
                "schema": {"fields": _fields(results / table.file), "missingValues": [""]},
            }
            for table in tables
        ],
    }
    return _text(package)


def _fields(path: Path) -> list[dict[str, str]]:
    kinds = {str(name): kind.kind for name, kind in pd.read_csv(path).dtypes.items()}
    return [
        {"name": name, "type": TYPES.get(kind, "string")}
        | ({"unit": unit(name)} if kind in "iuf" else {})
        for name, kind in kinds.items()
    ]


def unit(column: str) -> str:
    """Return the unit at the end of a column's name, 1 for a pure number."""
    match = UNIT.search(f"_{column}")
    return match[1].replace("_per_", "/").replace("percent", "%") if match else "1"


CLAIMS = TypeAdapter(Claims)
