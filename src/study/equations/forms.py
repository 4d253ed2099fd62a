"""Formulas as text: read by SymPy, checked for dimensions by Pint, evaluated at numbers.

A formula is one line such as ``V_n = -e*v_n``; the line printed in the ledger is the line that is
checked. ``=``, ``>`` or ``!=`` is between its sides.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from fractions import Fraction
from functools import cache
from itertools import chain
from typing import Any, NamedTuple

import pint
import sympy

from microimpact.core.materials import declared_file
from study.declared.documents import load

FUNCTIONS = frozenset(
    {"sqrt", "sin", "cos", "tan", "cot", "atan", "sign", "Abs", "Max", "Integral", "beta", "pi"}
)
RELATIONS = (" = ", " > ", " != ")

# All relations with their symbols, and the slips of the text.
DECLARED: Mapping[str, Any] = load(declared_file("equations.yaml"))
SYMBOLS, ERRATA = "symbols", "errata"
_SYMBOLS = DECLARED[SYMBOLS]
_SIGNS = {
    name: {sign: True} for sign in ("negative", "positive") for name in _SYMBOLS[sign].split()
}

# Exponents without a value of their own: any number shows whether dimensions agree.
FREE_EXPONENTS = {"p": (7, 5), "q": (6, 5)}

# A residual of this size, at numbers of order one, is no rounding.
REFUTED = 1e-6

_NAME = re.compile(r"[A-Za-z]\w*")
# The units of the article alone: the file of all units takes Pint longer to read than all proofs.
_UNITS: pint.UnitRegistry[Any] = pint.UnitRegistry(None, non_int_type=Fraction)
for _definition in (
    "m = [length]",
    "kg = [mass]",
    "s = [time]",
    "rad = []",
    "N = kg*m/s**2",
    "Pa = N/m**2",
    "J = N*m",
):
    _UNITS.define(_definition)

Dimension = Any


class DimensionError(ValueError):
    """A formula whose parts do not agree in dimension, or with an undeclared symbol."""


class Form(NamedTuple):
    """A formula: its two sides and the relation between them."""

    left: Any
    relation: str
    right: Any

    @property
    def residual(self) -> Any:
        """Left side less right side."""
        return self.left - self.right


@cache
def symbol(name: str) -> Any:
    """Return the symbol of a name, with the sign it has throughout the article."""
    return sympy.Symbol(name, **_SIGNS.get(name, {"real": True}))


def symbols(names: str) -> tuple[Any, ...]:
    """Return the symbols of several names, separated by blanks."""
    return tuple(symbol(name) for name in names.split())


@cache
def units_of(section: str) -> dict[str, str]:
    """Return the unit of each symbol in a section."""
    symbols = chain(_SYMBOLS["units"].items(), _SYMBOLS["meanings"].get(section, {}).items())
    return {name: unit for unit, names in symbols for name in names.split()}


@cache
def parse(text: str) -> Form:
    """Read a formula.

    Raises ValueError if the text does not hold exactly one relation.
    """
    relations = [relation for relation in RELATIONS if relation in text]
    if len(relations) != 1 or text.count(relations[0]) != 1:
        raise ValueError(f"formula {text!r}: exactly one of{''.join(RELATIONS)}must occur in it")
    left, right = (_expression(side) for side in text.split(relations[0]))
    return Form(left, relations[0].strip(), right)


def _expression(text: str) -> Any:
    names = {name for name in _NAME.findall(text) if name not in FUNCTIONS}
    return sympy.parse_expr(text, local_dict={name: symbol(name) for name in names})


def check_dimensions(text: str, units: Mapping[str, str]) -> None:
    """Check that all parts of a formula agree in dimension.

    Parameters
    ----------
    text
        The formula.
    units
        Unit of every symbol.

    Raises
    ------
    DimensionError
        Saying what does not agree.
    """
    exponents = {
        symbol(name): sympy.Rational(*value)
        for name, value in FREE_EXPONENTS.items()
        if units.get(name) == ""
    }
    left, _, right = parse(text)
    _same([side.subs(exponents) for side in (left, right)], units)


def _dimension(node: Any, units: Mapping[str, str]) -> Dimension:
    if node.is_Symbol:
        if node.name not in units:
            raise DimensionError(f"{node.name} is not declared")
        return _UNITS.get_dimensionality(units[node.name])
    if node.is_Pow:
        return _power(_dimension(node.base, units), node.exp, units)
    if node.is_Add or node.func is sympy.Max:
        return _same(node.args, units)
    if node.func is sympy.sign:
        _dimension(node.args[0], units)
    elif node.is_Function and node.func is not sympy.Abs:
        _number(node.args[0], units)
    product = _UNITS.get_dimensionality("")
    for factor in _factors(node):
        product = product * _dimension(factor, units)
    return product


def _factors(node: Any) -> tuple[Any, ...]:
    """Return the parts whose dimensions multiply to the dimension of a node."""
    if node.is_Mul or node.func is sympy.Abs:
        return tuple(node.args)
    return (node.function, *node.variables) if isinstance(node, sympy.Integral) else ()


def _number(node: Any, units: Mapping[str, str]) -> None:
    if _dimension(node, units):
        raise DimensionError(f"{node} must be a number")


def _power(base: Dimension, exponent: Any, units: Mapping[str, str]) -> Dimension:
    _number(exponent, units)
    return base ** Fraction(int(exponent.p), int(exponent.q)) if base else base


def _same(parts: Any, units: Mapping[str, str]) -> Dimension:
    first, *others = [part for part in parts if part != 0]
    dimension = _dimension(first, units)
    for part in others:
        if _dimension(part, units) != dimension:
            raise DimensionError(f"{part} does not have the dimension of {first}")
    return dimension


def evaluate(text: str, numbers: Mapping[str, float]) -> float:
    """Return the right side of a formula at given SI numbers."""
    right = parse(text).right
    value = right.subs({symbol: numbers[symbol.name] for symbol in right.free_symbols})
    return float(value.evalf())


def vanishes(expression: Any) -> bool:
    """Tell whether an expression is zero, whatever its symbols are.

    One set of numbers at which it is not zero refutes that at once; else SymPy must prove it. A
    common denominator proves most; what is left, SymPy simplifies, which takes far longer.
    """
    unlike = sorted(expression.free_symbols, key=str)
    numbers = {
        name: (-1 if name.is_negative else 1) * (0.3 + 0.07 * index)
        for index, name in enumerate(unlike)
    }
    if abs(complex(expression.subs(numbers).evalf())) > REFUTED:
        return False
    if _cancels(expression):
        return True
    dense = sympy.powdenest(expression, force=True)
    return _cancels(dense) or bool(sympy.simplify(dense) == 0)


def _cancels(expression: Any) -> bool:
    """Tell whether nothing is left over a common denominator, with angles as powers of e."""
    numerator, _ = sympy.fraction(sympy.together(expression.rewrite(sympy.exp)))
    return bool(sympy.expand(numerator) == 0)
