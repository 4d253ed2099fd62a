"""The claims of the article with values in their words, and the verdicts that they can get."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from study.claims.claim import CLAIMS, Claim, ascending
from study.claims.sections import SECTIONS

Verdict = Literal[
    "reproduced",
    "reproduced with a correction",
    "calibrated",
    "not reproduced",
    "not identified",
    "not testable",
]
# What a claim gets if the error of a number covers the bound that decides; none can declare it, nor
# that it was not computed.
UNDECIDED: Literal["undecided"] = "undecided"
Finding = Literal[Verdict, "not computed", "undecided"]


class ClaimsError(ValueError):
    """Claims with problems: one line each, beginning with the dotted key."""


def declared_claims(values: Mapping[str, Any] | None = None) -> dict[str, Claim]:
    """Return all claims by id, in their order.

    Parameters
    ----------
    values
        Parameters of ``claim_numbers``, to be put into the words, a claim's own by their names
        alone; without them the words keep the names.

    Raises
    ------
    ConfigError
        If the words name a parameter that there is not.
    """
    assert SECTIONS  # their import declares the claims
    named = {name: CLAIMS[name] for name in ascending(testable=False)}
    return {n: claim.filled(values) for n, claim in named.items()} if values else named
