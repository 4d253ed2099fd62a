"""Shares of the drawn contacts that meet a claim's criteria, and the deciding parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.statistics.importance import drawn_size
from microimpact.statistics.intervals import wilson_interval
from study.claims.claim import Claim
from study.judge.judging import FEWEST, MOST, judged, margins

if TYPE_CHECKING:
    import pandas as pd

# Parameters of a drawn contact that can decide: numbers, and words.
NUMBERS = (
    "work_of_adhesion_J_per_m2",
    "hertz_damping_s_per_m",
    "adhesion_damping_s_per_m",
    "rate_exponent",
    "friction",
)
WORDS = ("friction_basis",)
# What a claim is judged for one by one, and what decides it if its class changes between them.
GROUPS = {
    "scenario": "capture velocity",
    "law": "law of contact",
    "alternative": "alternative",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Share:
    """A claim over the drawn contacts."""

    # Draws that meet its criteria, and all, by scenario, law and alternative of the claim; as many
    # as independent ones would be.
    counts: Mapping[tuple[str, ...], tuple[float, float]]
    # Between which of `GROUPS` its class changes; else the parameter whose distribution differs
    # most between draws that meet the criteria and those that do not, and by how much, from 0 to 1.
    decided_by: str
    # Laws with whose contacts its numbers cannot be computed.
    lacking: tuple[str, ...] = ()

    @property
    def intervals(self) -> list[tuple[float, float]]:
        """Intervals of 95 % of the shares, by their binomial error."""
        return [wilson_interval(*count) for count in self.counts.values()]

    def in_words(self) -> str:
        """Return the shares with their intervals, and the laws that have none."""
        parts = []
        for group, (met, drawn) in self.counts.items():
            low, high = (round(100 * end) for end in wilson_interval(met, drawn))
            name = ", ".join(filter(None, group))
            parts.append(f"{100 * met / drawn:.0f} % ({low} to {high}) {name}")
        parts += [f"none by {law}: the numbers are of the ring force" for law in self.lacking]
        return "; ".join(parts)


def shares(
    claims: Mapping[str, Claim], draws: pd.DataFrame, contacts: pd.DataFrame
) -> dict[str, Share]:
    """Return the shares of all claims that have numbers for drawn contacts.

    Parameters
    ----------
    claims
        By id.
    draws
        Table ``claim_draws``.
    contacts
        Table ``posterior_contacts``, with `NUMBERS`.
    """
    draws = draws.assign(alternative=draws["alternative"].astype(object).fillna(""))
    laws = list(dict.fromkeys(draws["law"]))
    return {
        str(name): _share(claims[str(name)], rows, contacts, laws)
        for name, rows in draws.groupby("claim", sort=True)
        if str(name) in claims
    }


def _share(claim: Claim, draws: pd.DataFrame, contacts: pd.DataFrame, laws: Sequence[str]) -> Share:
    keys = ["contact", "scenario", "law", "draw"]
    values = draws.pivot_table(
        index=[*keys, "alternative"], columns="quantity", values="value", sort=False
    )
    table = values.index.to_frame(index=False).assign(met=margins(claim.criteria, values) > 0.0)
    table = table.merge(contacts.rename(columns={"case": "contact"}), on=keys, how="left")
    counts = {}
    for name, group in table.groupby(list(GROUPS), sort=False):
        size = drawn_size(float(group["effective_size"].iloc[0]), len(group))
        counts[tuple(map(str, name))] = (size * float(group["met"].mean()), size)
    lacking = tuple(law for law in laws if law not in set(table["law"]))
    share = Share(counts=counts, decided_by="", lacking=lacking)
    if judged("reproduced", share.intervals) != "not identified":
        return share
    return replace(share, decided_by=_changes(counts) or _decided_by(table))


def _changes(counts: Mapping[tuple[str, ...], tuple[float, float]]) -> str:
    """Return the kinds of groups between which the class changes, empty if there are none."""
    classes = {}
    for group, (met, drawn) in counts.items():
        classes[group] = (met >= MOST * drawn) - (met <= FEWEST * drawn)
    changing = [
        words
        for i, words in enumerate(GROUPS.values())
        if any(
            classes[one] != classes[other]
            for one in classes
            for other in classes
            if one[:i] + one[i + 1 :] == other[:i] + other[i + 1 :]
        )
    ]
    return " and ".join(changing)


def _decided_by(table: pd.DataFrame) -> str:
    met = table["met"].to_numpy(bool)
    apart = {}
    for name in NUMBERS:  # of the laws that have it
        has = table[name].notna().to_numpy(bool)
        apart[name] = separation(table[name].to_numpy(float)[has], met[has])
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
