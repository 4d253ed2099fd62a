"""Drafts of replication chains in the form of FORRT nanopublications, as JSON-LD.

A chain goes from a quote of the article over an AIDA sentence (atomic, independent, declarative,
absolute) and a claim to the replication study and its outcome. A draft holds the assertion of each
step as a named graph; provenance, repository, date and signature are added by those who publish it.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any
from urllib.parse import quote_plus

from study.report.site.claims import confidence
from study.report.site.ledgers import Row

FILE = "files/replication_chains.jsonld"
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
    return json.dumps({"@context": CONTEXT, "@graph": graphs}, indent=1, ensure_ascii=False) + "\n"


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
