"""Formulas of the equations ledger as MathML, and symbols within sentences.

A formula is a line of Python's arithmetic with ``=``, ``>`` or ``!=`` between its sides. It is
shown as printed; nothing is simplified, so a misprint stays one.
"""

from __future__ import annotations

import re
from functools import cache
from keyword import kwlist

import sympy
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from markupsafe import Markup, escape

from study.equations.forms import FUNCTIONS, RELATIONS

SIGNS = {" = ": " = ", " > ": " > ", " != ": r" \neq "}
GREEK = "alpha|zeta|eta|theta|kappa|mu|nu|pi|rho|phi|sigma|xi|omega|Omega"
ACCENTS = ("dot", "ddot")
# In a sentence: a formula between dollar signs, a letter with an index or exponent, a Greek one.
_SYMBOL = re.compile(
    r"\$([^$]+)\$|(?<![\w.])((?:[A-Za-z]'?|10)(?:_\w(?:\^\w)?|\^-?\w))(?!\w)"
    rf"|(?<![\w-])((?:{GREEK})(?:[_^]\w)?)(?![\w-])"
)


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
    for relation in RELATIONS:
        if relation in text:
            try:
                return _math(SIGNS[relation].join(map(_latex, text.split(relation))))
            except (SyntaxError, TypeError, sympy.SympifyError) as error:
                raise ValueError(f"formula {text!r}: cannot be read: {error}") from None
    raise ValueError(f"formula {text!r}: it contains no relation")


def prose(text: str) -> Markup:
    """Return a sentence with its symbols set: ``v_c``, ``alpha``, LaTeX between dollars."""
    pieces, end = [], 0
    for match in _SYMBOL.finditer(text):
        latex = match[1] or match[2] or f"\\{match[3]}"
        # The prime comes after the index, and an exponent needs braces about its sign.
        latex = re.sub(r"\^(-\w)", r"^{\1}", re.sub(r"'(_\w)", r"\1^{\\prime}", latex))
        pieces += [escape(text[end : match.start()]), _math(latex)]
        end = match.end()
    return Markup().join([*pieces, escape(text[end:])])


@cache
def _math(latex: str) -> Markup:
    try:
        math = tex2mathml(latex.replace(r"\phi", r"\varphi"))
    except (MathError, AttributeError):  # No LaTeX
        return escape(latex)
    # The dot of the font.
    return Markup(re.sub(r">\s+<", "><", math).replace("⋅", "·"))


def _latex(side: str) -> str:
    """Return one side of a formula as LaTeX, in its order."""
    words = set(re.findall(r"[A-Za-z_]\w*", side))
    # SymPy evaluates the text as Python's: let through arithmetic alone.
    if not re.fullmatch(r"[\w ()+*/,-]+", side) or words & {*kwlist}:
        raise SyntaxError(side)
    names = {name: sympy.Symbol(name) for name in words - FUNCTIONS}
    # Unevaluated, a fraction would be a product.
    exact = re.sub(r"\((\d)/(\d)\)", r"(Rational(\1, \2))", side)
    form = sympy.parse_expr(exact, local_dict=names, evaluate=False)
    shown = {symbol: _symbol(name) for name, symbol in names.items()}
    latex: str = sympy.latex(form, order="none", fold_frac_powers=True, symbol_names=shown)
    return latex.replace(r"\left(-1\right) ", "-")


def _symbol(name: str) -> str:
    head, *marks = name.split("_")
    # A trailing p is the article's prime: the frame of the slope.
    prime = r"^{\prime}" if len(head) == 2 and head.endswith("p") else ""
    shown = _word(head[0] if prime else head)
    while marks and marks[0] in ACCENTS:
        shown = rf"\{marks.pop(0)}{{{shown}}}"
    below = r"\,".join(map(_word, marks))
    return f"{shown}_{{{below}}}{prime}" if below else shown


def _word(name: str) -> str:
    if re.fullmatch(GREEK, name):
        return f"\\{name}"
    return name if len(name) == 1 else rf"\mathrm{{{name}}}"
