"""Numbers and names of the claims as a person writes them, for pages and the command line."""

from __future__ import annotations

import re
from collections.abc import Callable
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
class Computed:
    """The numbers of one quantity of a claim in words, and the criteria about it."""

    words: str
    criterion: str
    # Case, which of a claim without alternatives is "", number, and whether that fails a criterion.
    cells: tuple[tuple[str, str, bool], ...]


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


def tabled(
    computed: str, bound: Callable[[str], str], fails: Callable[[str, str, float], bool]
) -> list[Computed]:
    """Return the numbers in a cell of computed values, quantity by quantity.

    `bound`: gives the criteria about a quantity in words; `fails`: tells of quantity, case and
    value whether they fail one.
    """
    found: dict[str, list[tuple[str, str, bool]]] = {}
    for quantity, case, value, unit in computed_numbers(computed):
        failed = fails(quantity, case, value)
        text = readable(value, unit, ROUNDING, digits=DIGITS + failed)
        found.setdefault(quantity, []).append((case, text, failed))
    return [
        Computed(words=in_words(name), criterion=bound(name), cells=tuple(cells))
        for name, cells in found.items()
    ]


def by_quantity(computed: str, claim: Claim) -> list[Computed]:
    """Return the numbers in a cell of computed values beside the criteria of their claim."""

    def about(quantity: str) -> list[Criterion]:
        return [c for c in (*claim.criteria, *claim.identified_if) if c.quantity == quantity]

    return tabled(
        computed,
        lambda quantity: "; ".join(map(described, about(quantity))),
        lambda quantity, _, value: not all(holds(one, value) for one in about(quantity)),
    )
