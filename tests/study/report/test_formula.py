"""Formulas as MathML, and symbols in sentences."""

from __future__ import annotations

import base64
import io
import re
from html import unescape

import pytest
from fontTools.ttLib import TTFont

from study.ledgers.equations import EQUATIONS
from study.report.site.formula import mathml, prose
from study.report.site.pages import ASSETS

FORMS = [form for entry in EQUATIONS.values() for form in (entry.printed, entry.form_used)]


def text(formula):
    return unescape(re.sub(r"<[^>]+>", "", mathml(formula)))


@pytest.mark.parametrize(
    ("formula", "shown"),
    [
        ("e = -V_n/v_n", "e=−Vnvn"),
        # What binds less strongly keeps its parentheses, and nothing else gets any.
        ("T_L = 1 - (a - b)", "TL=1−(a−b)"),
        ("T_L = (1 - a) - b", "TL=1−a−b"),
        ("R = (a/b)**2", "R=(ab)2"),
        ("R = (-a)**2", "R=(−a)2"),
        ("R = a*(-b)", "R=a(−b)"),
        ("V_Ct = r*theta_dot", "VCt=rθ˙"),
        ("K > Abs(v_n - v_c)", "K>|vn−vc|"),
        ("e = a*(2/7)", "e=a(2/7)"),
        ("mu = vp_t", "μ=vt′"),
        ("mu = tan(phi + alpha)", "μ=tan(φ+α)"),
    ],
)
def test_formulas_keep_their_form(formula, shown):
    assert text(formula) == shown


def test_the_font_has_the_signs_of_all_formulas():
    sheet = (ASSETS / "formula.css").read_text(encoding="utf-8")
    data = base64.b64decode(re.search(r"base64,([^)]*)", sheet)[1])
    known = set(map(chr, TTFont(io.BytesIO(data)).getBestCmap()))
    assert set("".join(map(text, FORMS))) <= known


@pytest.mark.parametrize("formula", ["e", "e = import os", "e = <script>", "e = a if b else c"])
def test_a_text_without_a_formula_is_refused(formula):
    with pytest.raises(ValueError, match="formula"):
        mathml(formula)


@pytest.mark.parametrize(
    ("sentence", "shown"),
    [
        ("at $\\alpha$ < 15", "at <i>α</i> &lt; 15"),
        ("v_c falls as v^-n", "<i>v</i><sub>c</sub> falls as <i>v</i><sup>−n</sup>"),
        ("v'_n at 10^3 1/s", "<i>v</i>′<sub>n</sub> at 10<sup>3</sup> 1/s"),
        (r"$-(V_t - r\Omega)$", "−(<i>V</i><sub>t</sub> − <i>r</i><i>Ω</i>)"),
        # Names of columns and words that begin like a letter stay.
        ("speed_m_per_s, mu-th, <b>", "speed_m_per_s, mu-th, &lt;b&gt;"),
    ],
)
def test_symbols_in_a_sentence(sentence, shown):
    assert prose(sentence) == shown
