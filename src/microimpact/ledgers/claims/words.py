"""Numbers and names of the claims as a person writes them, for pages and the command line."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from microimpact.ledgers.claims.criteria import Claim, Criterion, holds
from microimpact.ledgers.claims.judging import described

# Smaller than this, in the units of the claims, a difference of numbers is rounding.
ROUNDING = 1e-9
# Of a number; one more where it fails a criterion, which may lie near it.
DIGITS = 3
MOST_DIGITS = 6

_NUMBER = re.compile(
    r"^(?P<quantity>\w+)(?: \((?P<case>[^)]*)\))? = (?P<value>\S+)(?: (?P<unit>.+))?$"
)
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """A number of a claim in words, and whether it meets the criteria about it."""

    text: str
    holds: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """The numbers of one quantity by case; the only case of a claim without alternatives is ""."""

    words: str
    criterion: str
    cells: Mapping[str, Cell]


def readable(value: float, unit: str = "-", rounding: float = 0.0, *, digits: int = DIGITS) -> str:
    """Return a number in three digits, or more, with its unit; what is below rounding is zero.

    A share that is nearly one keeps the digits that tell it from one.
    """
    while (
        0.9 < abs(value) < 1.0 and digits < MOST_DIGITS and float(f"{value:.{digits}g}") in {-1, 1}
    ):
        digits += 1
    if abs(value) <= rounding:
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


def article_value(claim: Claim) -> str:
    """Return what the article gives, with its unit if it is a number."""
    return with_unit(claim.article_value, claim.unit)


def with_unit(text: str, unit: str) -> str:
    """Return what the article gives with a unit, if it ends as a number."""
    if unit == "-" or not text[-1:].isdigit():
        return text
    return f"{text}°" if unit == "deg" else f"{text} {unit}"


def computed_numbers(text: str) -> list[tuple[str, str, float, str]]:
    """Return quantity, case, value and unit of the numbers in a cell of computed values."""
    matches = [(part, _NUMBER.match(part)) for part in text.split("; ")]
    for part, match in matches:
        if match is None:
            raise ValueError(
                f"computed value {part!r} must be of the form 'name (case) = 1.0 unit'"
            )
    return [
        (match["quantity"], match["case"] or "", float(match["value"]), match["unit"] or "-")
        for _, match in matches
        if match is not None
    ]


def by_quantity(computed: str, claim: Claim) -> list[Quantity]:
    """Return the numbers in a cell of computed values, quantity by quantity."""
    found: dict[str, dict[str, Cell]] = {}
    for quantity, case, value, unit in computed_numbers(computed):
        met = all(holds(criterion, value) for criterion in about(quantity, claim))
        found.setdefault(quantity, {})[case] = Cell(
            text=readable(value, unit, ROUNDING, digits=DIGITS + (not met)), holds=met
        )
    return [
        Quantity(
            words=in_words(name),
            criterion="; ".join(map(described, about(name, claim))),
            cells=cells,
        )
        for name, cells in found.items()
    ]


def about(quantity: str, claim: Claim) -> list[Criterion]:
    """Return the criteria about a quantity."""
    return [c for c in (*claim.criteria, *claim.identified_if) if c.quantity == quantity]
