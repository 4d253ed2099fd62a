"""In what share of the admissible contacts a claim meets its criteria, and what decides that."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from microimpact.ledgers.claims.criteria import Claim, Verdict, holds

if TYPE_CHECKING:
    import pandas as pd

# A claim is decided if its criteria hold in at least, or at most, these shares.
MOST, FEWEST = 0.95, 0.05
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
    draws: int  # Draws of the first variant with numbers
    # Parameter whose distribution differs most between draws of the first variant that meet the
    # criteria and those that do not, and by how much, from 0 to 1; empty if the share is not split.
    decided_by: str

    @property
    def share(self) -> float:
        """Share that decides."""
        return next(iter(self.variants.values()))

    def verdict(self, positive: Verdict) -> Verdict:
        """Return the verdict that follows."""
        if self.share >= MOST:
            return positive
        return "not reproduced" if self.share <= FEWEST else "not identified"

    def in_words(self) -> str:
        """Return both shares, and what decides, in a sentence."""
        shares = ", ".join(f"{100 * share:.0f} % {name}" for name, share in self.variants.items())
        by = f", decided by {self.decided_by}" if self.decided_by else ""
        return f"Met by {shares}, of the admissible contacts ({self.draws} draws){by}"


def shares(
    claims: Mapping[str, Claim], draws: pd.DataFrame, contacts: pd.DataFrame
) -> dict[str, Share]:
    """Return the shares of all claims that have numbers for admissible contacts.

    `claims`: by id; `draws`: table ``claim_draws``; `contacts`: table ``admissible_contacts``, with
    `NUMBERS`.
    """
    draws = draws.assign(alternative=draws["alternative"].astype(object).fillna(""))
    return {
        str(name): _share(claims[str(name)], own, contacts)
        for name, own in draws.groupby("claim", sort=True)
        if str(name) in claims
    }


def _share(claim: Claim, own: pd.DataFrame, contacts: pd.DataFrame) -> Share:
    keys = ["contact", "variant", "draw", "alternative"]
    wide = own.pivot_table(index=keys, columns="quantity", values="value", sort=False)
    met = [
        all(holds(criterion, float(row[criterion.quantity])) for criterion in claim.criteria)
        for _, row in wide.iterrows()
    ]
    table = wide.index.to_frame(index=False).assign(met=met)
    by_variant = table.groupby("variant", sort=False)["met"]
    found = {str(name): float(share) for name, share in by_variant.mean().items()}
    first = table[table["variant"] == next(iter(found))]
    split = FEWEST < next(iter(found.values())) < MOST
    known = first.merge(contacts.rename(columns={"case": "contact"}), on=keys[:3], how="left")
    return Share(
        variants=found,
        draws=int(first["draw"].nunique()),
        decided_by=_decided_by(known) if split else "",
    )


def _decided_by(table: pd.DataFrame) -> str:
    met = table["met"].to_numpy(bool)
    apart = {name: separation(table[name].to_numpy(float), met) for name in NUMBERS}
    for name in WORDS:
        words = table[name].astype(str).to_numpy()
        apart[name] = max(
            abs(float(np.mean(words[met] == one) - np.mean(words[~met] == one)))
            for one in set(words)
        )
    best = max(apart, key=lambda name: apart[name])
    return f"{_spoken(best)} ({apart[best]:.2f})"


def separation(values: Sequence[float] | np.ndarray, met: np.ndarray) -> float:
    """Return how far two samples are apart by their ranks: 0 if not at all, 1 if they are disjoint.

    Twice the distance of the statistic of Mann and Whitney, over its greatest value, from a half.
    """
    import pandas as pd

    ranks = pd.Series(values).rank().to_numpy()
    n, others = int(met.sum()), int((~met).sum())
    if n == 0 or others == 0:
        return 0.0
    statistic = ranks[met].sum() - 0.5 * n * (n + 1)
    return float(abs(2.0 * statistic / (n * others) - 1.0))


def _spoken(column: str) -> str:
    for unit in ("_J_per_m2", "_s_per_m"):
        column = column.removesuffix(unit)
    return column.replace("_", " ")
