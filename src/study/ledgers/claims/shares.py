"""Share of the admissible contacts that meet a claim's criteria, and the deciding parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from microimpact.core.arrays import BoolArray, FloatArray
from study.ledgers.claims.criteria import Claim
from study.ledgers.claims.judging import FEWEST, MOST, margins

if TYPE_CHECKING:
    import pandas as pd

# Parameters of an admissible contact that can decide: numbers, and words.
NUMBERS = (
    "work_of_adhesion_J_per_m2",
    "hertz_damping_s_per_m",
    "adhesion_damping_s_per_m",
    "rate_exponent",
    "friction",
)
WORDS = ("friction_basis", "alternative")


@dataclass(frozen=True, slots=True, kw_only=True)
class Share:
    """A claim over the admissible contacts."""

    # Share of the draws that meet its criteria, by variant; the first decides. A claim with
    # alternatives of its own counts each of them for each draw.
    variants: Mapping[str, float]
    # Margins of the draws of the first variant: infinite, since a draw has no error.
    margin: FloatArray
    # Parameter whose distribution differs most between draws of the first variant that meet the
    # criteria and those that do not, and by how much, from 0 to 1; empty if the share is not split.
    decided_by: str

    @property
    def share(self) -> float:
        """Share that decides."""
        return next(iter(self.variants.values()))

    def in_words(self) -> str:
        """Return all shares, and the deciding parameter, in a sentence."""
        shares = ", ".join(f"{100 * share:.0f} % {name}" for name, share in self.variants.items())
        by = f", decided by {self.decided_by}" if self.decided_by else ""
        return f"Met by {shares}, of the admissible contacts{by}"


def shares(
    claims: Mapping[str, Claim], draws: pd.DataFrame, contacts: pd.DataFrame
) -> dict[str, Share]:
    """Return the shares of all claims that have numbers for admissible contacts.

    Parameters
    ----------
    claims
        By id.
    draws
        Table ``claim_draws``.
    contacts
        Table ``admissible_contacts``, with `NUMBERS`.
    """
    draws = draws.assign(alternative=draws["alternative"].astype(object).fillna(""))
    return {
        str(name): _share(claims[str(name)], rows, contacts)
        for name, rows in draws.groupby("claim", sort=True)
        if str(name) in claims
    }


def _share(claim: Claim, draws: pd.DataFrame, contacts: pd.DataFrame) -> Share:
    keys = ["contact", "variant", "draw", "alternative"]
    values = draws.pivot_table(index=keys, columns="quantity", values="value", sort=False)
    margin = margins(claim.criteria, values)
    table = values.index.to_frame(index=False).assign(met=margin > 0.0)
    by_variant = table.groupby("variant", sort=False)["met"].mean()
    first = table["variant"] == by_variant.index[0]
    known = table[first].merge(
        contacts.rename(columns={"case": "contact"}), on=keys[:3], how="left"
    )
    return Share(
        variants={str(name): float(share) for name, share in by_variant.items()},
        margin=margin[first],
        decided_by=_decided_by(known) if FEWEST < by_variant.iloc[0] < MOST else "",
    )


def _decided_by(table: pd.DataFrame) -> str:
    met = table["met"].to_numpy(bool)
    apart = {name: separation(table[name].to_numpy(float), met) for name in NUMBERS}
    for name in WORDS:
        words = table[name].astype(str).to_numpy()
        apart[name] = max(
            abs(float(np.mean(words[met] == word) - np.mean(words[~met] == word)))
            for word in set(words)
        )
    name = max(apart, key=lambda name: apart[name])
    spoken = name.removesuffix("_J_per_m2").removesuffix("_s_per_m").replace("_", " ")
    return f"{spoken} ({apart[name]:.2f})"


def separation(values: Sequence[float] | FloatArray, met: BoolArray) -> float:
    """Return how far two samples are apart by their ranks: 0 if not at all, 1 if they are disjoint.

    Twice the distance of the statistic of Mann and Whitney, over its greatest value, from a half.
    """
    import pandas as pd

    ranks = pd.Series(values).rank().to_numpy()
    n, rest = int(met.sum()), int((~met).sum())
    if n == 0 or rest == 0:
        return 0.0
    statistic = ranks[met].sum() - 0.5 * n * (n + 1)
    return float(abs(2.0 * statistic / (n * rest) - 1.0))
