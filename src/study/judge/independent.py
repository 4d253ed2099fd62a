"""Facts found by others, beside the claims that they concern."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from microimpact.core.nearest import nearest
from study.claims.claim import Claim
from study.judge.criteria import ClaimsError

if TYPE_CHECKING:
    import pandas as pd

AGREES, DISAGREES = "agrees with independent data", "disagrees with independent data"
SPLIT = "agrees in part with independent data"
EVIDENCE_COLUMNS = ("id", "fact", "agreeing", "disagreeing")


def independent(claims: Mapping[str, Claim], external: pd.DataFrame | None) -> pd.DataFrame:
    """Return the contacts for which each fact that a claim names agrees with the model, or not.

    Parameters
    ----------
    claims
        By id.
    external
        Table ``external_evidence``: a row per fact and contact, with ``agreement``; None if it
        could not be computed.

    Returns
    -------
    pandas.DataFrame
        A row per claim and fact with `EVIDENCE_COLUMNS`; none for a fact without any computation.

    Raises
    ------
    ClaimsError
        If a claim names a fact that the table lacks.
    """
    import pandas as pd

    if external is None:
        return pd.DataFrame(columns=list(EVIDENCE_COLUMNS))
    known = list(dict.fromkeys(external["fact"]))
    named = [(name, fact) for name, claim in claims.items() for fact in claim.external]
    wrong = [
        f"{name}.external: {fact!r} is no fact of external_evidence{nearest(fact, known)}"
        for name, fact in named
        if fact not in known
    ]
    if wrong:
        raise ClaimsError("\n".join(wrong))
    sides = {
        fact: [
            " / ".join(rows.loc[rows["agreement"] == side, "contact"].astype(str))
            for side in (AGREES, DISAGREES)
        ]
        for fact, rows in external.groupby("fact", sort=False)
    }
    table = [(name, fact, *sides[fact]) for name, fact in named if any(sides[fact])]
    return pd.DataFrame(table, columns=list(EVIDENCE_COLUMNS))


def agreements(evidence: pd.DataFrame) -> dict[str, str]:
    """Return by claim whether it agrees with the facts of `independent`, wholly or in part."""
    classes = {(True, False): AGREES, (False, True): DISAGREES, (True, True): SPLIT}
    return {
        str(name): classes[any(rows["agreeing"]), any(rows["disagreeing"])]
        for name, rows in evidence.groupby("id", sort=False)
    }
