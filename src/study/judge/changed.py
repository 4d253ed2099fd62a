"""Claims judged with other inputs than the shipped ones: marked, or not of this experiment."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from study import analyses

if TYPE_CHECKING:
    import pandas as pd

STUDY = "claim_numbers"
# Keys that say which impact a study, or a claim, is about.
IMPACT = frozenset({"particle", "surface", "diameter_um", "mean_diameter_um"})
IMPACT |= {"speed_m_per_s", "printed_speed_m_per_s"}
# Part of the calibration that is of the pair of Fig. 20, and the table that claims on it read.
OF_FLUORESCEIN, THEIR_TABLE = "force_ratios", "molybdenum_capture"
# Tables of the study of several mechanisms, and the parameters that each is made of.
PARTS = {
    "adhesion_or_roughness": "mechanisms.shallow.",
    "formica_mechanism": "mechanisms.slope.formica_",
    "loss_resolution": "mechanisms.loss.",
    "spin_needed": "mechanisms.spin.",
    "spore_comparison": "mechanisms.spore.",
    "spore_trends": "mechanisms.spore.",
    "surface_pairs": "mechanisms.slope.pairs.",
}
# What a claim gets whose numbers are of another impact than the article's.
OF_ANOTHER = "not of this experiment"

Changed = Mapping[str, Mapping[str, str]]


def with_inputs(row: Mapping[str, Any] | pd.Series[Any], changed: Changed) -> dict[str, Any]:
    """Return the row of a claim with the changed inputs it rests on.

    A study is of another impact if a key of its own, or of a mapping right below it, says so; one
    of several parts, if a key at any depth of the part that the claim has read does; a claim, if
    any setting of it alone does, or a shared one that it has read. Such a claim has no verdict.

    Parameters
    ----------
    row
        Of the ledger; ``inputs`` names the tables that the claim has read, and of the impact that
        claims share what it has, as ``steel.speed_m_per_s``.
    changed
        By study, changed keys of parameters and where each is declared.
    """
    row = dict(row)
    if not changed:
        return {**row, "changed_inputs": ""}
    makers = analyses.needs(STUDY)
    tables = {*str(row["inputs"]).split()}
    read = {makers[name] for name in tables if name in makers}
    settings = {
        key: place
        for key, place in changed.get(STUDY, {}).items()
        if key.startswith(f"{STUDY}.") and _is_of(str(row["id"]), key)
    }
    places = {**settings, **{k: p for study in sorted(read) for k, p in changed[study].items()}}
    alone = {key: {*key.split(".")} for key in settings}
    another = {
        settings[key]
        for key, parts in alone.items()
        if IMPACT & parts and (row["id"] in parts or key.removeprefix(f"{STUDY}.") in tables)
    }
    parts_read = tuple(PARTS[name] for name in tables if name in PARTS)
    for study in read:
        keys = {key: key.split(".") for key in changed[study]}
        impact = {
            key
            for key, parts in keys.items()
            if parts[0] == study
            and IMPACT & {*(parts if key.startswith(parts_read) else parts[1:3])}
            if parts[1] != OF_FLUORESCEIN or THEIR_TABLE in tables
        }
        another |= {changed[study][key] for key in impact}
    row = {**row, "changed_inputs": "; ".join(sorted({*places.values()}))}
    if another and row["verdict"] != "not testable":
        note = f"Of another impact than the article's: {', '.join(sorted(another))}."
        row |= {"verdict": OF_ANOTHER, "margin": None, "shares": "", "decided_by": ""}
        row["sentence"] = note
    return row


def _is_of(claim: str, key: str) -> bool:
    """Return whether a setting of the claims is of one of them, or of several."""
    part = key.split(".")[1]
    return part == claim or not (part[:1] == "C" and part[1:].isdigit())
