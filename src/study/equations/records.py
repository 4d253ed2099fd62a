"""A row of the equation ledger: a relation as declared, and its proof."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import count, islice
from typing import Annotated, Any, Literal

import sympy
from pydantic import Field

from microimpact.model.contact import Contact
from study.declared.parameters import Name
from study.equations.forms import Form, evaluate, symbol, units_of, vanishes

# Number of an equation, or section, or number, and name of a relation within the text.
EQUATION_NAME = r"^\d+(\.\d+)*( \w[\w ]*)?$"

Slip = Literal["none", "scan", "article", "open"]
Checked = Literal["passed", "failed", "open", "none"]
Facts = dict[Any, Any]
Values = Mapping[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class ReferenceCase:
    """The impact at which formulas are compared and consequences computed, in SI units."""

    contact: Contact  # Steel sphere on silicon, as declared
    # Value of each symbol; of a symbol with two meanings under ``(name, unit)``.
    numbers: Mapping[str | tuple[str, str], float]

    def values(self, units: Mapping[str, str]) -> dict[str, Any]:
        """Return the number of each symbol, in the meaning its unit gives it, and the contact."""
        numbers: dict[str, Any] = {"contact": self.contact}
        numbers |= {name: value for name, value in self.numbers.items() if isinstance(name, str)}
        meant = ((name, self.numbers.get((name, unit))) for name, unit in units.items())
        return numbers | {name: value for name, value in meant if value is not None}


@dataclass(frozen=True, slots=True)
class Derivation:
    """How a relation is proved, and the proof: whether a formula holds; None leaves it open."""

    method: str
    proof: Callable[[Form, ReferenceCase], bool | None]

    def check(self, form: Form, case: ReferenceCase) -> Checked:
        """Return the outcome of the proof for a formula."""
        holds = self.proof(form, case)
        return "open" if holds is None else "passed" if holds else "failed"


@dataclass(frozen=True, slots=True)
class Proof:
    """Derivation of a relation, and the consequence of its printed form."""

    derivation: Derivation | None = None  # None for a definition
    # What implements the relation, called with the values of a case: must agree with the used form.
    computed: Callable[[Values], Any] | None = None
    consequence: Callable[[At], Any] | None = None  # Of using the printed form: a number


@dataclass(frozen=True, slots=True, kw_only=True)
class Equation:
    """One relation of the article, as ``config/equations.yaml`` declares it."""

    id: Annotated[str, Field(pattern=EQUATION_NAME)]
    section: Name  # In which it stands
    printed: Name  # As printed in the article
    used: str = ""  # Where the form used here is another: that form
    slip: Slip = "none"  # Whose the difference of both forms is
    error: str = ""  # Name of a slip that several relations share
    means: dict[str, str] = field(default_factory=dict)
    reason: Name  # Why the verdict, in one sentence
    function: str = ""  # Dotted path of what implements the relation; empty where nothing needs to
    consequence: str = ""  # What the printed form leads to, and the unit of its number
    unit: str = "1"

    def __post_init__(self) -> None:
        """Refuse a slip without another form, or another form of nobody's making."""
        if (self.slip == "none") != (not self.used):
            raise ValueError("slip goes with used, and used with slip")

    @property
    def form_used(self) -> str:
        """The form used here."""
        return self.used or self.printed

    @property
    def units(self) -> dict[str, str]:
        """Unit of every symbol."""
        return units_of(self.section) | self.means


@dataclass(frozen=True, slots=True)
class At:
    """An equation at a case: numbers for its symbols, some of which may be changed."""

    equation: Equation
    case: ReferenceCase

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


def follows(method: str, facts: Callable[[], Facts]) -> Derivation:
    """Proof that both sides are equal once known facts are substituted."""

    def proof(form: Form, _: ReferenceCase) -> bool:
        return form.relation == "=" and vanishes(form.residual.subs(facts(), simultaneous=True))

    return Derivation(f"symbolic: {method}", proof)


def expands(method: str, facts: Callable[[], Facts], small: str, order: int) -> Derivation:
    """Proof that the sides agree up to an order in the symbols that are small together."""

    def proof(form: Form, _: ReferenceCase) -> bool:
        residual = form.residual.subs(facts(), simultaneous=True)
        return form.relation == "=" and vanishes(leading(residual, small, order))

    return Derivation(f"series: {method}", proof)


def leading(expression: Any, small: str, order: int) -> Any:
    """Return an expression up to an order in the symbols that are small together.

    It is the quotient of two power series, as the denominator may be small too: phi/(alpha + phi).
    """
    scale = sympy.Symbol("epsilon", positive=True)
    scaled = expression.subs({symbol(name): scale * symbol(name) for name in small.split()})
    over, under = sympy.fraction(sympy.together(scaled))
    lowest = next(power for power, term in enumerate(_series(under, scale)) if not vanishes(term))
    below = list(islice(_series(under, scale), 2 * lowest + order + 1))
    coefficients: list[Any] = []
    for power, term in enumerate(islice(_series(over, scale), lowest + order + 1)):
        rest = term - sum(coefficients[k] * below[lowest + power - k] for k in range(power))
        coefficients.append(rest / below[lowest])
    return sum(coefficients)


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
