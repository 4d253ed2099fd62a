"""Sentences on claims, made from rows of the ledger's tables: for pages and the command line."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
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

# Units in which a sentence tells a number, by those after its name: factor and words.
SCALES = {"%": (100.0, "%"), "mm": (1e3, "mm")}

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
    return in_unit(text, unit)


def in_words(quantity: str) -> str:
    """Return the name of a quantity of a claim in words: ``at_0p45_m_per_s`` is at 0.45 m/s."""
    decimal = re.sub(r"(?<=\d)p(?=\d)", ".", quantity)
    spoken = decimal.replace("_m_per_s", " m/s").replace("_", " ")
    return re.sub(r"(?<=\d) deg\b", "°", re.sub(r"(?<=\d) um\b", " µm", spoken))


def drawn_share(percents: Iterable[float], decided_by: str) -> str:
    """Return in a sentence for how many of the drawn contacts a claim holds, over its scenarios.

    `decided_by`: its column of ``claims``.
    """
    percents = list(percents)
    ends = dict.fromkeys(f"{end:.0f}" for end in (min(percents), max(percents)))
    by = decided_by.partition(" (")[0]
    on = f", depending on the {by}" if by else ""
    return f"The claim holds for {' to '.join(ends)} % of the drawn contacts{on}."


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


class Place:
    """The numbers of one quantity, over the cases, as a place in the sentence of a claim.

    ``{name}`` is the number, or its range, with the unit; ``{name:bound}`` the test. After the
    name or ``bound`` may stand another unit, one of `SCALES`.
    """

    def __init__(self, results: Sequence[Row]) -> None:
        self.results = results

    def __format__(self, spec: str) -> str:
        """Return the range of the numbers, or the test, in words."""
        suffix = spec.removeprefix("bound").strip()
        scale, unit = SCALES[suffix] if suffix else (1.0, self.results[0]["unit"])
        if spec.startswith("bound"):
            test = dict(self.results[0])
            test |= {end: _rounded(scale, test[end]) for end in ("low", "high") if test[end] != ""}
            return in_unit(bounds(test).replace("-", "−"), unit)
        values = [scale * float(row["value"]) for row in self.results]
        low, high = (
            # One digit more tells nearly all from all
            readable(end, rounding=ROUNDING, digits=DIGITS + (unit == "%" and 99.9 < end < 100.0))
            for end in (min(values), max(values))
        )
        return in_unit(low if low == high else f"{low} to {high}", unit)


def _rounded(scale: float, bound: str | float) -> float:
    return float(f"{scale * float(bound):.{DIGITS + 1}g}")


def in_unit(text: str, unit: str) -> str:
    """Return numbers in words with their unit."""
    if unit in {"-", "1", ""}:
        return text
    return f"{text}°" if unit == "deg" else f"{text} {unit.replace('**', '^')}"


def outcome(says: str, results: Sequence[Row], percents: Sequence[float], decided_by: str) -> str:
    """Return the outcome of a claim in words; empty without a number that is tested.

    Parameters
    ----------
    says
        Sentence of the claim, with a `Place` for each number; without one it is the number nearest
        to failing.
    results
        Rows of the claim in ``claim_results``.
    percents
        Shares of the drawn contacts for which it holds, if they decide, and what decides between
        them. The numbers are then of the calibrated contacts.
    """
    tested = sorted((row for row in results if bounds(row)), key=lambda row: not fails(row))
    if not tested:
        return ""
    if says:
        by_name: dict[str, list[Row]] = {}
        for row in results:
            by_name.setdefault(row["quantity"], []).append(row)
        said = says.format_map({name: Place(rows) for name, rows in by_name.items()})
    else:
        least = tested[0]
        case = f" for {least['case']}" if least["case"] else ""
        said = f"{least['label']} is {number(least)}{case} (required: {bounds(least)})."
    if percents:
        said = f"With the calibrated contacts, {said[:1].lower()}{said[1:]}"
        return f"{drawn_share(percents, decided_by)} {said}"
    return f"{said[:1].upper()}{said[1:]}"


def computed_values(results: Sequence[Row]) -> str:
    """Return all numbers of a claim in words, with their cases."""
    cases = [f" ({row['case']})" if row["case"] else "" for row in results]
    return "; ".join(
        dict.fromkeys(
            f"{row['label']}{case} = {readable(float(row['value']), row['unit'], ROUNDING)}"
            for row, case in zip(results, cases, strict=True)
        )
    )


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
