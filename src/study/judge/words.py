"""Sentences on claims, made from rows of the ledger's tables: for pages and the command line."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

import numpy as np

# Smaller than this, in the units of the claims, a difference of numbers is rounding.
ROUNDING = 1e-9
# Of a number; one more where it fails a criterion, which may lie near it.
DIGITS = 3
MOST_DIGITS = 6

_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

# Columns of contacts that meet a fact found by others, and that do not.
SIDES = {"yes": "agreeing", "no": "disagreeing"}

# A row of one of the ledger's tables, as numbers or as the text of its file.
Row = Mapping[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """The numbers of one quantity of a claim in words, and the bounds that they must meet."""

    label: str
    bounds: str
    # Case, which of a claim without alternatives is "", number, and whether it fails a criterion.
    cells: tuple[tuple[str, str, bool], ...]


def readable(value: float, unit: str = "-", rounding: float = 0.0, *, digits: int = DIGITS) -> str:
    """Return a number in three digits, or more, with its unit; zero if below rounding.

    A share that is nearly one keeps the digits that tell it from one.
    """
    while (
        0.9 < abs(value) < 1.0 and digits < MOST_DIGITS and float(f"{value:.{digits}g}") in {-1, 1}
    ):
        digits += 1
    if not math.isfinite(value):
        text = f"{value:g}"
    elif abs(value) <= rounding:
        text = "0"
    elif 1e-3 <= abs(value) < 1e5:
        rounded = float(f"{value:.{digits}g}")
        text = np.format_float_positional(rounded, trim="-").replace("-", "−")
    else:
        mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
        power = str(int(exponent)).translate(_SUPERSCRIPTS)
        text = f"{mantissa.replace('-', '−')} × 10{power}"
    if unit in {"-", "1", ""}:
        return text
    return f"{text}°" if unit == "deg" else f"{text} {unit.replace('**', '^')}"


def in_words(quantity: str) -> str:
    """Return the name of a quantity of a claim in words: ``at_0p45_m_per_s`` is at 0.45 m/s."""
    decimal = re.sub(r"(?<=\d)p(?=\d)", ".", quantity)
    spoken = decimal.replace("_m_per_s", " m/s").replace("_", " ")
    return re.sub(r"(?<=\d) deg\b", "°", re.sub(r"(?<=\d) um\b", " µm", spoken))


def drawn_share(shares: Iterable[Row], decided_by: str) -> str:
    """Return in a sentence for how many of the drawn contacts a claim holds, over its scenarios.

    `shares`: its rows of ``claim_shares``; `decided_by`: its column of ``claims``.
    """
    percents = [100.0 * float(row["share"]) for row in shares]
    ends = dict.fromkeys(f"{end:.0f}" for end in (min(percents), max(percents)))
    by = decided_by.partition(" (")[0]
    on = f", depending on the {by}" if by else ""
    return f"Holds for {' to '.join(ends)} % of the drawn contacts{on}."


def with_unit(text: str, unit: str) -> str:
    """Append the unit to a printed value that ends as a number."""
    if unit == "-" or not text[-1:].isdigit():
        return text
    return f"{text}°" if unit == "deg" else f"{text} {unit}"


def bounds(result: Row) -> str:
    """Return the test of a result in words and numbers; empty without one."""
    test = result["test"]
    if not isinstance(test, str) or not test:
        return ""
    if test == "between":
        return f"between {float(result['low']):g} and {float(result['high']):g}"
    if test != "within":
        return (
            f"{test.replace('_', ' ')} {float(result['low' if test == 'at_least' else 'high']):g}"
        )
    # As decimals, so that 0.695 and 0.705 are 0.7 ± 0.005.
    low, high = (Decimal(repr(float(result[end]))) for end in ("low", "high"))
    return f"{float((low + high) / 2):g} ± {float((high - low) / 2):g}"


def fails(result: Row) -> bool:
    """Tell whether a number fails its test."""
    return str(result["passed"]) == "False"


def number(result: Row) -> str:
    """Return the value of a result in three digits with its unit, or in four if it fails."""
    return readable(float(result["value"]), result["unit"], ROUNDING, digits=DIGITS + fails(result))


def sentence(result: Row) -> str:
    """Return a result in words: its number, where it holds, and the bound it fails."""
    case = f" ({result['case']})" if result["case"] else ""
    required = f" (required: {bounds(result)})" if fails(result) else ""
    return f"{result['label']}{case} = {number(result)}{required}"


def computed_values(results: Iterable[Row]) -> str:
    """Return all numbers of a claim in words."""
    return "; ".join(dict.fromkeys(sentence({**row, "passed": None}) for row in results))


def quantities(results: Iterable[Row]) -> list[Quantity]:
    """Return the results of one claim by quantity, those first that are tested."""
    by_name: dict[str, list[Row]] = {}
    for row in results:
        by_name.setdefault(row["quantity"], []).append(row)
    table = [
        Quantity(
            label=rows[0]["label"],
            bounds=bounds(rows[0]),
            cells=tuple((row["case"], number(row), fails(row)) for row in rows),
        )
        for rows in by_name.values()
    ]
    return sorted(table, key=lambda quantity: not quantity.bounds)


def amended(amendment: Row) -> str:
    """Return the change of a claim after its first judgement, and the reason."""
    was, now = (amendment[key].rstrip(".") for key in ("was", "now"))
    changed = f"Changed after first judging, {amendment['part']}"
    return f"{changed}: was {was}; now {now}. {amendment['reason']}"


def agreement(fact: Row) -> str:
    """Return by which contacts a fact that others found is met, and by which not."""
    sides = (f"{word} for {fact[side]}" for word, side in SIDES.items() if fact[side])
    return f"{fact['fact']}: {'; '.join(sides)}"
