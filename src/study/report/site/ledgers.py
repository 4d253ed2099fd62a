"""The ledgers as the pages show them: verdicts counted, rows with anchors, findings in order."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from functools import cache

from markupsafe import Markup

from study.judge.changed import OF_ANOTHER
from study.judge.counts import verdicts
from study.judge.words import in_words, readable, with_unit
from study.report.site.formula import mathml

Row = dict[str, str]

# Each verdict with the colour of its class in the style sheet, from the best to the least known.
CLAIM_VERDICTS = {
    "reproduced": "good",
    "reproduced with a correction": "corrected",
    "calibrated": "fitted",
    "not reproduced": "bad",
    "not identified": "open",
    "undecided": "halved",
    "not testable": "mute",
    "not computed": "mute",
    OF_ANOTHER: "mute",
}
EQUATION_VERDICTS = {
    "correct": "good",
    "definition": "fitted",
    "typographical slip": "corrected",
    "corrected": "bad",
    "undecidable": "open",
}
CONTRADICTION = "contradiction"
# Standard errors beyond which their number says no more.
FAR = 100.0


def tally(rows: Sequence[Row], order: Mapping[str, str]) -> dict[str, int]:
    """Count the rows of each verdict that occurs; those that are not foreseen come last."""
    judged = verdicts(row["verdict"] for row in rows)
    return {v: judged[v] for v in dict.fromkeys((*order, *sorted(judged))) if v in judged}


def not_reproduced(claims: Sequence[Row]) -> list[Row]:
    """Return the claims that did not hold: contradictions first, then by figures touched."""
    failed = [row for row in claims if row["verdict"] == "not reproduced"]
    return sorted(failed, key=lambda r: (r["kind"] != CONTRADICTION, -len(r["figures"].split())))


def by_claim(rows: Sequence[Row]) -> defaultdict[str, list[Row]]:
    """Group the rows of a table of the ledger by claim; a claim without rows has none."""
    groups = defaultdict[str, list[Row]](list)
    for row in rows:
        groups[row["id"]].append(row)
    return groups


def printed(claim: Row) -> str:
    """Return the article's value, with its unit if it is a number."""
    return with_unit(claim["article_value"], claim["unit"])


def margin(text: str) -> str:
    """Return in words how far the number that decides is from its bound."""
    distance = float(text)
    side = "beyond" if distance < 0 else "within"
    far = "More than " if abs(distance) > FAR else ""
    return f"{far}{readable(min(abs(distance), FAR))} standard errors {side} the bound."


def anchor(prefix: str, name: str) -> str:
    """Return an id for an element: ``14 total`` gives ``eq-14-total``."""
    return f"{prefix}-" + re.sub(r"[^A-Za-z0-9]+", "-", name).strip("-").lower()


@cache
def formula(text: str) -> Markup | str:
    """Return a formula as MathML, or unchanged if it is none."""
    try:
        return mathml(text)
    except ValueError:
        return text


def measure(low: str, unit: str, high: str = "") -> str:
    """Return a number, or a range of two, in three digits with its unit; other text unchanged."""
    try:
        least, most = float(low), float(high or low)
    except ValueError:
        return low
    return (
        readable(least, unit) if least == most else f"{readable(least)} to {readable(most, unit)}"
    )


def cell(row: Row, low: str, high: str = "") -> str:
    """Return the number or text of a row under a key, or the range under two, in words."""
    text = measure(row[low], row.get("unit", ""), row.get(high, ""))
    return {"True": "yes", "False": "no"}.get(text, in_words(text))
