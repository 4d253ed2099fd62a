"""The ledgers as the pages show them: verdicts counted, rows with anchors, findings in order."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from markupsafe import Markup

from microimpact.ledgers.claims import CHANGED
from microimpact.ledgers.claims.criteria import UNCOUNTED
from microimpact.ledgers.claims.judging import REQUIRED
from microimpact.ledgers.claims.words import Computed, readable, tabled, with_unit
from microimpact.report.site.formula import mathml

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
}
EXTERNAL_VERDICTS = {
    "agrees with independent data": "good",
    "disagrees with independent data": "bad",
    "not computed": "mute",
}
EQUATION_VERDICTS = {
    "correct": "good",
    "definition": "fitted",
    "typographical slip": "corrected",
    "corrected": "bad",
    "undecidable": "open",
}
CONTRADICTION = "contradiction"

# Names of quantities; symbols such as v_c are none.
_KEY = re.compile(r"\b[A-Za-z]\w+_\w+\b")
_POINT = re.compile(r"(?<=\d)p(?=\d)")


class MissingColumnError(ValueError):
    """A ledger that lacks a column the site shows."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Count:
    """How many rows have a verdict, and where its bar begins and ends, in percent of all."""

    verdict: str
    colour: str
    number: int
    begin: float
    share: float


def read_rows(path: Path, columns: Sequence[str] = ()) -> list[Row]:
    """Return the rows of a table as text; none if there is no such file.

    Raises MissingColumnError if the table lacks one of the columns.
    """
    if not path.is_file():
        return []
    with path.open(encoding="utf-8", newline="") as stream:
        table = csv.DictReader(stream)
        if missing := [name for name in columns if name not in (table.fieldnames or ())]:
            raise MissingColumnError(f"{path}: has no column {', '.join(missing)}")
        return list(table)


def counts(rows: Sequence[Row], verdicts: Mapping[str, str]) -> tuple[Count, ...]:
    """Count the rows of each verdict that occurs; those that are not foreseen come last."""
    found = [row["verdict"] for row in rows]
    order = [v for v in dict.fromkeys((*verdicts, *sorted(found))) if v in found]
    counted, begin = [], 0.0
    for verdict in order:
        share = 100.0 * found.count(verdict) / len(found)
        counted.append(
            Count(
                verdict=verdict,
                colour=verdicts.get(verdict, "mute"),
                number=found.count(verdict),
                begin=round(begin, 3),
                share=round(share, 3),
            )
        )
        begin += share
    return tuple(counted)


def counted(claims: Sequence[Row]) -> list[Row]:
    """Return the claims that a computation can decide; others are listed and not counted."""
    return [row for row in claims if row["kind"] not in UNCOUNTED]


def not_reproduced(claims: Sequence[Row]) -> list[Row]:
    """Return the claims that did not hold: contradictions first, then by figures touched."""
    failed = [row for row in counted(claims) if row["verdict"] == "not reproduced"]
    return sorted(failed, key=lambda r: (r["kind"] != CONTRADICTION, -len(r["figures"].split())))


def failed(claim: Row) -> int:
    """Return how many criteria of a claim failed, over all cases."""
    return claim["note"].count(REQUIRED)


def computed(claim: Row) -> list[Computed]:
    """Return the numbers of a claim, those first that a criterion is about; else its text."""
    text = claim["computed_value"]
    criteria = dict(part.partition(" ")[::2] for part in claim["criterion"].split("; "))

    def fails(quantity: str, case: str, _: float) -> bool:
        return f"{f'{case}: ' if case else ''}{quantity} = " in claim["note"]

    try:
        found = tabled(text, lambda quantity: criteria.get(quantity, ""), fails) if text else []
    except ValueError:
        return [Computed(words=part, criterion="", cells=()) for part in parts(text)]
    return sorted(found, key=lambda one: not one.criterion)


def printed(claim: Row) -> str:
    """Return what the article gives, with its unit if it is a number."""
    return with_unit(claim["article_value"], claim["unit"])


def changed_later(claims: Sequence[Row]) -> int:
    """Return how many claims were changed after they had first been judged."""
    return sum(CHANGED in row["note"] for row in claims)


def changes(claim: Row) -> list[str]:
    """Return what of a claim was changed after first judging, and why, one text per change."""
    return [part for part in claim["note"].split(" | ") if part.startswith(CHANGED)]


def failures(claim: Row) -> list[str]:
    """Return which criteria failed, or why there are no numbers; nothing where all hold."""
    first = claim["note"].split(" | ")[0]
    return [] if first in {claim["reason"], ""} else parts(first)


def anchor(prefix: str, name: str) -> str:
    """Return an id for an element: ``14 total`` gives ``eq-14-total``."""
    return f"{prefix}-" + re.sub(r"[^A-Za-z0-9]+", "-", name).strip("-").lower()


def words(text: str) -> str:
    """Return a text with names of quantities as words: ``speed_at_0p45_m_per_s`` and the like."""
    spoken = _KEY.sub(lambda found: _POINT.sub(".", found[0]).replace("_", " "), text)
    return spoken.replace(" m per s", " m/s")


def parts(text: str) -> list[str]:
    """Return the statements of a cell, which semicolons separate, as words."""
    return [words(part.strip()) for part in text.split(";") if part.strip()]


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


def number(text: str) -> str:
    """Return a number to four digits; other text unchanged."""
    try:
        return f"{float(text):.4g}"
    except ValueError:
        return text
