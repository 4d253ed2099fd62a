"""A row of the equation ledger: a relation as printed and as used, its proof, what follows."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import count, islice
from typing import Any, Literal

import sympy

from microimpact.ledgers.equations.forms import Form, evaluate, symbol, vanishes
from microimpact.model.contact import Contact

Slip = Literal["scan", "article", "scan or article"]
Outcome = Literal["passed", "failed", "open", "none"]
Facts = dict[Any, Any]
Values = Mapping[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """The impact at which formulas are compared and consequences computed, in SI units.

    Attributes
    ----------
    contact
        Steel sphere on silicon, as declared.
    numbers
        Value of each symbol; of a symbol with two meanings under ``(name, unit)``.
    """

    contact: Contact
    numbers: Mapping[str | tuple[str, str], float]

    def values(self, units: Mapping[str, str]) -> dict[str, Any]:
        """Return the number of each symbol, in the meaning its unit gives it, and the contact."""
        found: dict[str, Any] = {"contact": self.contact}
        found |= {name: value for name, value in self.numbers.items() if isinstance(name, str)}
        meant = ((name, self.numbers.get((name, unit))) for name, unit in units.items())
        return found | {name: value for name, value in meant if value is not None}


@dataclass(frozen=True, slots=True, kw_only=True)
class Derivation:
    """How a relation is proved, and the proof: it takes a formula and can fail."""

    method: str
    check: Callable[[Form, Case], Outcome]


@dataclass(frozen=True, slots=True, kw_only=True)
class Consequence:
    """What the printed form leads to: words, and a number with its unit."""

    text: str
    unit: str
    value: Callable[[At], float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Equation:
    """One relation of the article.

    Attributes
    ----------
    id, section
        Number of the equation, or section and name of a relation within the text.
    printed
        As printed in the article; what follows a slash is its denominator.
    used
        The form used here, if another.
    slip
        Where the difference comes from, given with ``used``: the scan or typesetting, the article
        itself, or one of them.
    units
        Unit of every symbol.
    derivation
        Proof; none for a definition.
    reason
        Why the verdict, in one sentence.
    function
        Dotted path of what implements the relation; empty where nothing needs to.
    implementation
        The same, called with the values of a case: must agree with the used form.
    consequence
        Of using the printed form.
    """

    id: str
    section: str
    printed: str
    used: str = ""
    slip: Slip | None = None
    units: Mapping[str, str] = field(repr=False)
    derivation: Derivation | None = None
    reason: str
    function: str = ""
    implementation: Callable[[Values], float] | None = None
    consequence: Consequence | None = None

    def __post_init__(self) -> None:
        """Refuse a slip without another form, or another form without a slip."""
        if bool(self.used) != (self.slip is not None):
            raise ValueError(f"equation {self.id}: give both 'used' and 'slip', or neither")

    @property
    def form_used(self) -> str:
        """The form used here."""
        return self.used or self.printed


@dataclass(frozen=True, slots=True)
class At:
    """An equation at a case: numbers for its symbols, some of which may be changed."""

    equation: Equation
    case: Case

    def values(self, **changes: float) -> dict[str, Any]:
        """Return the values of all symbols by name."""
        return self.case.values(self.equation.units) | changes

    def formula(self, text: str, **changes: float) -> float:
        """Return the right side of a formula in the symbols of this equation."""
        return evaluate(text, self.values(**changes))

    def printed(self, **changes: float) -> float:
        """Return the right side as printed."""
        return self.formula(self.equation.printed, **changes)

    def used(self, **changes: float) -> float:
        """Return the right side as used."""
        return self.formula(self.equation.form_used, **changes)


def passed(holds: bool) -> Outcome:
    """Return the outcome of a check."""
    return "passed" if holds else "failed"


def follows(method: str, facts: Callable[[], Facts]) -> Derivation:
    """Proof that both sides are equal once what is known is put in for their symbols."""

    def check(form: Form, _: Case) -> Outcome:
        return passed(
            form.relation == "=" and vanishes(form.residual.subs(facts(), simultaneous=True))
        )

    return Derivation(method=f"symbolic: {method}", check=check)


def expands(method: str, facts: Callable[[], Facts], small: str, order: int) -> Derivation:
    """Proof that the sides agree up to an order in the symbols that are small together."""

    def check(form: Form, _: Case) -> Outcome:
        residual = form.residual.subs(facts(), simultaneous=True)
        return passed(form.relation == "=" and vanishes(leading(residual, small, order)))

    return Derivation(method=f"series: {method}", check=check)


def leading(expression: Any, small: str, order: int) -> Any:
    """Return an expression up to an order in the symbols that are small together.

    It is the quotient of two power series, as the denominator may be small too: phi/(alpha + phi).
    """
    scale = sympy.Symbol("epsilon", positive=True)
    scaled = expression.subs({symbol(name): scale * symbol(name) for name in small.split()})
    over, under = sympy.fraction(sympy.together(scaled))
    lowest = next(power for power, term in enumerate(_series(under, scale)) if not vanishes(term))
    below = list(islice(_series(under, scale), 2 * lowest + order + 1))
    found: list[Any] = []
    for power, term in enumerate(islice(_series(over, scale), lowest + order + 1)):
        rest = term - sum(found[k] * below[lowest + power - k] for k in range(power))
        found.append(rest / below[lowest])
    return sum(found)


def _series(expression: Any, variable: Any) -> Iterator[Any]:
    """Give the coefficients of the powers of a variable, from the lowest."""
    for power in count():
        yield expression.subs(variable, 0) / sympy.factorial(power)
        expression = expression.diff(variable)


def solve(laws: list[Any], *unknowns: Any) -> Facts:
    """Return the only solution of some linear laws."""
    (solution,) = sympy.linsolve(laws, *unknowns)
    return dict(zip(unknowns, solution, strict=True))


def where_one(ratio: Any, unknown: Any) -> Any:
    """Return the positive unknown at which a ratio, a power of it, is one."""
    factor, exponent = ratio.as_coeff_exponent(unknown)
    if factor.has(unknown):
        raise ValueError(f"{ratio} is no power of {unknown}")
    return factor ** (-1 / exponent)
