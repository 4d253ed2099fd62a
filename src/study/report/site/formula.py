"""Formulas of the equations ledger as MathML, and symbols within sentences.

A formula is a line of Python's arithmetic with ``=``, ``>`` or ``!=`` between its sides. It is
shown as printed; nothing is simplified, so a misprint stays one.
"""

from __future__ import annotations

import ast
import re
from unicodedata import lookup

from markupsafe import Markup, escape

RELATIONS = {" = ": "=", " > ": ">", " != ": "≠"}
GREEK = {
    name: lookup(f"GREEK {'SMALL' if name.islower() else 'CAPITAL'} LETTER {name.upper()}")
    for name in (
        *("alpha", "zeta", "eta", "theta", "kappa", "mu", "nu", "pi", "rho", "phi", "sigma"),
        *("xi", "omega", "Omega"),
    )
}
SPACE = Markup('<mspace width="0.13em"></mspace>')
ACCENTS = {"dot": "˙", "ddot": "¨"}
# In a sentence: a formula between dollar signs, a letter with an index or exponent, a Greek one.
_SYMBOL = re.compile(
    r"\$([^$]+)\$|(?<![\w.])((?:[A-Za-z]'?|10)(?:_\w(?:\^\w)?|\^-?\w))(?!\w)"
    rf"|(?<![\w-])((?:{'|'.join(GREEK)})(?:[_^]\w)?)(?![\w-])"
)
_PIECE = re.compile(
    r"\\(?P<command>[A-Za-z]+|,) ?|(?P<place>[_^])(?:\{(?P<group>[^}]*)\}|(?P<one>-?.))"
    r"|(?P<letter>[A-Za-z])|(?P<prime>')|(?P<other>.)"
)
# How strongly an operator binds; the fraction bar needs no parentheses.
_SUM, _PRODUCT, _SIGN, _POWER, _ATOM = range(5)


def mathml(text: str) -> Markup:
    """Return a formula as a ``<math>`` element.

    Parameters
    ----------
    text
        The formula, as ``e = -V_n/v_n``.

    Raises
    ------
    ValueError
        If the text is no formula.
    """
    for relation, sign in RELATIONS.items():
        if relation in text:
            sides = [_side(side, text) for side in text.split(relation)]
            return _tag("math", _operator(sign).join(sides))
    raise ValueError(f"formula {text!r}: it contains no relation")


def prose(text: str) -> Markup:
    """Return a sentence with its symbols set: ``v_c``, ``alpha``, LaTeX between dollars."""
    pieces, end = [], 0
    for match in _SYMBOL.finditer(text):
        pieces += [
            escape(text[end : match.start()]),
            _inline(match[1] or match[2] or f"\\{match[3]}"),
        ]
        end = match.end()
    return Markup().join([*pieces, escape(text[end:])])


def _inline(formula: str) -> Markup:
    return Markup().join(_piece(match) for match in _PIECE.finditer(formula))


def _piece(match: re.Match[str]) -> Markup:
    if match["command"]:
        name = match["command"]
        return (
            _italic(GREEK[name])
            if name in GREEK
            else escape("\u2009" if name == "," else f"{name} ")
        )
    if match["place"]:
        return _tag(
            {"_": "sub", "^": "sup"}[match["place"]], _index(match["group"] or match["one"])
        )
    if match["prime"]:
        return escape("′")
    return _italic(match["letter"]) if match["letter"] else escape(match["other"].replace("-", "−"))


def _index(text: str) -> Markup:
    name = text.removeprefix("\\")
    return _italic(GREEK[name]) if name in GREEK else escape(text.replace("-", "−"))


def _italic(letter: str) -> Markup:
    return Markup("<i>{}</i>").format(letter)


def _side(side: str, whole: str) -> Markup:
    try:
        return _set(ast.parse(side.strip(), mode="eval").body)[0]
    except (SyntaxError, KeyError) as error:
        raise ValueError(f"formula {whole!r}: cannot be read: {error}") from None


def _tag(name: str, *parts: Markup) -> Markup:
    return Markup("<{0}>{1}</{0}>").format(name, Markup().join(parts))


def _operator(sign: str) -> Markup:
    return Markup("<mo>{}</mo>").format(sign)


def _row(*parts: Markup) -> Markup:
    return _tag("mrow", *parts)


def _set(node: ast.expr) -> tuple[Markup, int]:
    """Return a part of a formula and how strongly its outermost operator binds."""
    match node:
        case ast.Name(id=name):
            return _symbol(name), _ATOM
        case ast.Constant(value=int() | float() as value):
            return Markup("<mn>{}</mn>").format(value), _ATOM
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return _row(_operator("−"), _within(operand, _PRODUCT)), _SIGN
        case ast.BinOp(left=left, op=operation, right=right):
            return _binary(left, operation, right)
        case ast.Call(func=ast.Name(id=name), args=arguments):
            return _call(name, arguments), _ATOM
    raise KeyError(ast.unparse(node))


def _binary(left: ast.expr, operation: ast.operator, right: ast.expr) -> tuple[Markup, int]:
    match operation, left, right:
        case ast.Add(), _, _:
            return _row(_within(left, _SUM), _operator("+"), _within(right, _SUM)), _SUM
        case ast.Sub(), _, _:
            return _row(_within(left, _SUM), _operator("−"), _within(right, _PRODUCT)), _SUM
        case ast.Mult(), _, _:
            second = _within(right, _POWER if isinstance(right, ast.UnaryOp) else _PRODUCT)
            between = _operator("·") if isinstance(right, ast.Constant) else SPACE
            return _row(_within(left, _PRODUCT), between, second), _PRODUCT
        case ast.Div(), ast.Constant(), ast.Constant():
            # On one line, and in parentheses beside a factor: 2/7 a could be read as 2/(7a).
            return _row(_set(left)[0], _operator("/"), _set(right)[0]), _SUM
        case ast.Div(), _, _:
            return _tag("mfrac", _set(left)[0], _set(right)[0]), _ATOM
    if not isinstance(operation, ast.Pow):
        raise KeyError(type(operation).__name__)
    # A fraction binds like a product below an exponent.
    base = _fenced(_set(left)[0]) if isinstance(left, ast.BinOp) else _within(left, _ATOM)
    return _tag("msup", base, _flat(right)), _POWER


def _within(node: ast.expr, least: int) -> Markup:
    """Return a part, in parentheses if it binds less strongly than asked for."""
    shown, strength = _set(node)
    return shown if strength >= least else _fenced(shown)


def _fenced(shown: Markup, left: str = "(", right: str = ")") -> Markup:
    return _row(_operator(left), shown, _operator(right))


def _flat(node: ast.expr) -> Markup:
    """Return an exponent, its fraction on one line."""
    match node:
        case ast.BinOp(left=left, op=ast.Div(), right=right):
            return _row(_within(left, _ATOM), _operator("/"), _within(right, _ATOM))
    return _set(node)[0]


def _call(name: str, arguments: list[ast.expr]) -> Markup:
    parts = [_set(argument)[0] for argument in arguments]
    if name == "sqrt":
        return _tag("msqrt", *parts)
    if name == "Abs":
        return _fenced(parts[0], "|", "|")
    if name == "Integral":
        return _row(_operator("∫"), parts[0], SPACE, _name("d"), parts[1])
    listed = _operator(",").join(parts)
    function = {"Max": "max", "atan": "arctan"}.get(name, name)
    if len(arguments) == 1 and isinstance(arguments[0], ast.Name):
        return _row(_name(function), SPACE, listed)
    return _row(_name(function), _fenced(listed))


def _name(text: str) -> Markup:
    return Markup("<mi>{}</mi>").format(text)


def _symbol(name: str) -> Markup:
    head, *marks = name.split("_")
    # A trailing p is the article's prime: the frame of the slope.
    prime = _operator("′") if len(head) == 2 and head.endswith("p") else None
    head = head[0] if prime else head
    shown = _name(GREEK.get(head, head))
    while marks and marks[0] in ACCENTS:
        accent = _operator(ACCENTS[marks.pop(0)])
        shown = Markup('<mover accent="true">{}{}</mover>').format(shown, accent)
    below = _row(*(_name(GREEK.get(mark, mark)) for mark in marks))
    if prime:
        return _tag("msubsup", shown, below, prime)
    return _tag("msub", shown, below) if marks else shown
