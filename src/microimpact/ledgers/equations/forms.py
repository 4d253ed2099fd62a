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

FUNCTIONS = frozenset(
    {"sqrt", "sin", "cos", "tan", "cot", "atan", "sign", "Abs", "Max", "Integral", "beta", "pi"}
)
RELATIONS = (" = ", " > ", " != ")

# Signs that proofs may use: the sphere approaches (v_n < 0) and is pressed in (n < 0),
# and the velocity that just captures it has the same sign.
NEGATIVE = frozenset({"v_n", "vp_n", "v_c", "n"})
_POSITIVE = (
    "a a_c alpha c_A c_H e E_1 E_2 f f_0 g h I k k_1 k_2 kappa kappa_1 kappa_2 K m p q r r_S R R_S "
    "rho T_H v V w_A zeta_A zeta_H"
)
POSITIVE = frozenset(_POSITIVE.split())

# The unit of each symbol, and in some sections another meaning of it.
UNITS = {
    "": "alpha e e_m eta eta_rate eta_squared_rate f mu mu_0 mu_c mu_m nu_1 nu_2 nu_i phi R rho "
    "small T_L zeta_A zeta_H",
    "m": "a a_c h k n r r_n r_S R_S x",
    "m/s": "n_dot t_dot v V v_c v_n V_n vp_n v_t V_t vp_t Vp_t V_Ct v_probe V_probe",
    "m/s**2": "g n_ddot t_ddot",
    "rad/s": "omega Omega theta_dot",
    "rad/s**2": "theta_ddot",
    "s": "s T_H",
    "1/s": "strain_rate",
    "s/m": "c_A c_H",
    "kg": "m",
    "kg*m**2": "I",
    "N": "F F_n F_t",
    "N/m": "f_0",
    "N*s": "p P_n P_t P_D P_D_A P_D_R P_A_R",
    "Pa": "E_1 E_2 E_i K K_H",
    "1/Pa": "k_1 k_2 k_i",
    "J": "W_A W_D W_n",
    "J/m**2": "w_A",
}
MEANINGS = {
    "3.1.3": {"J": "T_L"},
    **{section: {"m": "R"} for section in ("3.2", "3.2.1", "3.2.2")},
    "3.3": {"": "p q", "m/s": "k k_1 k_2 kappa kappa_1 kappa_2"},
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
    if name in NEGATIVE:
        return sympy.Symbol(name, negative=True)
    return sympy.Symbol(name, positive=True) if name in POSITIVE else sympy.Symbol(name, real=True)


def symbols(names: str) -> tuple[Any, ...]:
    """Return the symbols of several names, separated by blanks."""
    return tuple(symbol(name) for name in names.split())


@cache
def units_of(section: str) -> dict[str, str]:
    """Return the unit of each symbol in a section."""
    given = chain(UNITS.items(), MEANINGS.get(section, {}).items())
    return {name: unit for unit, names in given for name in names.split()}


@cache
def parse(text: str) -> Form:
    """Read a formula.

    Raises ValueError if the text does not hold exactly one relation.
    """
    found = [relation for relation in RELATIONS if relation in text]
    if len(found) != 1 or text.count(found[0]) != 1:
        raise ValueError(f"formula {text!r}: exactly one of{''.join(RELATIONS)}must occur in it")
    left, right = (_expression(side) for side in text.split(found[0]))
    return Form(left, found[0].strip(), right)


def _expression(text: str) -> Any:
    names = {name for name in _NAME.findall(text) if name not in FUNCTIONS}
    return sympy.parse_expr(text, local_dict={name: symbol(name) for name in names})


def check_dimensions(text: str, units: Mapping[str, str]) -> None:
    """Check that all parts of a formula agree in dimension.

    `text`: the formula; `units`: unit of every symbol. Raises DimensionError, saying what does not
    agree.
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
    """Return the parts whose dimensions make up that of a node."""
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
