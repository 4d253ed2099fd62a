"""Counts of the ledgers: the only place where verdicts and revisions are counted."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

Row = Mapping[str, Any]


class Revisions(NamedTuple):
    """Claims that were changed after they had first been judged."""

    claims: int
    criteria: int  # Those of them whose criteria were changed; of the others words, cases, control

    @property
    def others(self) -> int:
        """Those whose criteria stand as they were."""
        return self.claims - self.criteria


def verdicts(column: Iterable[str]) -> dict[str, int]:
    """Return how often each verdict of a ledger was given, the most frequent first."""
    return dict(Counter(column).most_common())


def revisions(amendments: Iterable[Row]) -> Revisions:
    """Count the claims among the rows of the table ``claim_amendments``."""
    parts = defaultdict[str, set[str]](set)
    for row in amendments:
        parts[row["id"]].add(row["part"])
    return Revisions(len(parts), sum("criteria" in changed for changed in parts.values()))


def errors(equations: Iterable[Row]) -> dict[str, int]:
    """Count distinct errors, not rows, by whose they are: ``article``, ``open``, ``scan``."""
    kinds = {row["error"]: row["kind_of_slip"] for row in equations if row["error"]}
    number = Counter(kinds.values())
    return {kind: number[kind] for kind in ("article", "open", "scan")}
