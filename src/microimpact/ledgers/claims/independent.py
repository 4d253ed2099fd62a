"""What data found by others say of a claim: rows of the table of external evidence, in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from microimpact.core.nearest import nearest
from microimpact.ledgers.claims.criteria import Claim, ClaimsError

if TYPE_CHECKING:
    import pandas as pd

AGREES, DISAGREES = "agrees with independent data", "disagrees with independent data"
SPLIT = "agrees in part with independent data"


def independent(claims: Mapping[str, Claim], table: pd.DataFrame) -> dict[str, str]:
    """Return what independent data say of the claims that name some, by id.

    The class of agreement, and for each fact the contacts that agree and those that do not.
    `claims`: by id; `table`: ``external_evidence``: a row per fact and contact, with ``agreement``.
    Raises ClaimsError if a claim names a fact that the table lacks.
    """
    known = list(dict.fromkeys(table["fact"]))
    wrong = [
        f"{name}.external: {fact!r} is no fact of external_evidence{nearest(fact, known)}"
        for name, claim in claims.items()
        for fact in claim.external
        if fact not in known
    ]
    if wrong:
        raise ClaimsError("\n".join(wrong))
    named = {name: claim.external for name, claim in claims.items() if claim.external}
    return {
        name: _told(table[table["fact"].isin(facts) & table["agreement"].isin([AGREES, DISAGREES])])
        for name, facts in named.items()
    }


def _told(rows: pd.DataFrame) -> str:
    if rows.empty:
        return ""
    found = set(rows["agreement"])
    classed = SPLIT if len(found) > 1 else found.pop()
    parts = []
    for fact, own in rows.groupby("fact", sort=False):
        by = {
            word: " / ".join(own.loc[own["agreement"] == agreement, "contact"].astype(str))
            for word, agreement in (("yes", AGREES), ("no", DISAGREES))
        }
        parts.append(
            f"{fact}: " + "; ".join(f"{word} for {who}" for word, who in by.items() if who)
        )
    return f"{classed} | " + " | ".join(parts)
