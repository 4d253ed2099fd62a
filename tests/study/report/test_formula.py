"""Formulas as MathML, and symbols in sentences."""

from __future__ import annotations

import base64
import io
import re
from html import unescape

import pytest
from fontTools.ttLib import TTFont

from study.equations import EQUATIONS
from study.report.site.formula import mathml, prose
from study.report.site.pages import ASSETS

FORMS = [form for entry in EQUATIONS.values() for form in (entry.printed, entry.form_used)]


def text(formula):
    return unescape(re.sub(r"<[^>]+>", "", mathml(formula)))


@pytest.mark.parametrize(
    ("formula", "shown"),
    [
        ("e = -V_n/v_n", "e=−Vnvn"),
        # What binds less strongly keeps its parentheses.
        ("T_L = 1 - (a - b)", "TL=1−(a−b)"),
        ("R = (a/b)**2", "R=(ab)2"),
        ("R = (-a)**2", "R=(−a)2"),
        ("R = a*(-b)", "R=a(−b)"),
        ("V_Ct = r*theta_dot", "VCt=rθ˙"),
        ("K > Abs(v_n - v_c)", "K>|vn−vc|"),
        ("mu = vp_t", "μ=vt′"),
        # Nothing is simplified, and the order stays: a misprint is shown.
        ("T_L = R**2*m*R/R", "TL=R2mRR"),
        ("mu = b + a - b", "μ=b+a−b"),
    ],
)
def test_formulas_keep_their_form(formula, shown):
    assert text(formula) == shown


def test_the_font_has_the_signs_of_all_formulas():
    sheet = (ASSETS / "formula.css").read_text(encoding="utf-8")
    data = base64.b64decode(re.search(r"base64,([^)]*)", sheet)[1])
    known = set(map(chr, TTFont(io.BytesIO(data)).getBestCmap()))
    invisible = {"\N{FUNCTION APPLICATION}"}
    assert set("".join(map(text, FORMS))) - invisible <= known


@pytest.mark.parametrize(
    "formula",
    ["e", "e = import os", "e = <script>", "e = a if b else c", "e = __import__(os)", "e = a.b"],
)
def test_a_text_without_a_formula_is_refused(formula):
    with pytest.raises(ValueError, match="formula"):
        mathml(formula)


@pytest.mark.parametrize(
    ("sentence", "shown"),
    [
        ("at $\\alpha$ < 15", "at α &lt; 15"),
        ("v_c falls as v^-n", "vc falls as v−n"),
        ("v'_n at 10^3 1/s", "vn′ at 103 1/s"),
        (r"$-(V_t - r\Omega)$", "−(Vt−rΩ)"),
        # Names of columns and words that begin like a letter stay.
        ("speed_m_per_s, mu-th, <b>", "speed_m_per_s, mu-th, &lt;b&gt;"),
        ("$a & b$", "a &amp; b"),
    ],
)
def test_symbols_in_a_sentence(sentence, shown):
    assert re.sub(r"<[^>]+>", "", prose(sentence)) == shown
