"""Parts of the site: formulas as MathML, calls followed through the source, the graph of rules."""

from __future__ import annotations

import base64
import io
import re
from html import unescape
from types import SimpleNamespace

import pandas as pd
import pytest
from fontTools.ttLib import TTFont

from microimpact.ledgers.equations import EQUATIONS
from microimpact.report.site.code import modules, place
from microimpact.report.site.figures import departures, joined, studies_behind
from microimpact.report.site.formula import mathml, prose
from microimpact.report.site.graph import needs, picture, upstream
from microimpact.report.site.ledgers import counts
from microimpact.report.site.pages import ASSETS
from microimpact.report.site.reached import reached
from microimpact.report.site.record import Rule
from microimpact.studies.claims.claim_numbers import CLAIMS


def text(formula):
    return unescape(re.sub(r"<[^>]+>", "", mathml(formula)))


@pytest.mark.parametrize(
    ("formula", "shown"),
    [
        ("e = -V_n/v_n", "e=−Vnvn"),
        # What binds less strongly keeps its parentheses, and nothing else gets any.
        ("T_L = 1 - (a - b)", "TL=1−(a−b)"),
        ("T_L = (1 - a) - b", "TL=1−a−b"),
        ("R = (a + b)*c", "R=(a+b)c"),
        ("R = a**2*b", "R=a2b"),
        ("R = (a/b)**2", "R=(ab)2"),
        ("R = (-a)**2", "R=(−a)2"),
        ("R = a*(-b)", "R=a(−b)"),
        ("R = -(a + b)", "R=−(a+b)"),
        ("V_Ct = r*theta_dot", "VCt=rθ˙"),
        ("K > Abs(v_n - v_c)", "K>|vn−vc|"),
        ("P_n != 0", "Pn≠0"),
        ("f_0 = K**(1/3)", "f0=K1/3"),
        ("e = a*(2/7)", "e=a(2/7)"),
        ("e = (2/7)/a", "e=2/7a"),
        ("mu = vp_t", "μ=vt′"),
        ("mu = tan(phi)", "μ=tanφ"),
        ("mu = tan(phi + alpha)", "μ=tan(φ+α)"),
    ],
)
def test_formulas_keep_their_form(formula, shown):
    assert text(formula) == shown


def test_a_quotient_is_a_fraction_and_a_root_a_root():
    assert mathml("e = -V_n/v_n").count("<mfrac>") == 1
    assert "<msqrt><mrow><mrow><mn>2</mn>" in mathml("v = sqrt(2*g*h)")


def test_every_formula_of_the_ledger_is_set(results):
    ledger = pd.read_csv(results / "tables/equations.csv", dtype=str)
    for column in ("printed", "used"):
        for formula in ledger[column]:
            assert mathml(formula).startswith("<math>"), formula


@pytest.mark.parametrize("formula", ["e", "e = import os", "e = <script>", "e = a if b else c"])
def test_what_is_no_formula_is_refused(formula):
    with pytest.raises(ValueError, match="formula"):
        mathml(formula)


def test_calls_are_followed_and_not_imports():
    friction = reached("microimpact.studies.models.coulomb_friction.run")
    assert "microimpact.model.rigid_body.algebra.rigid_body_rebound" in friction
    # In the same module as that one, and not called.
    assert "microimpact.model.rigid_body.algebra.energy_loss" not in friction
    trends = reached("microimpact.studies.models.restitution_trends.run")
    assert "microimpact.model.empirical.equations.restitution" in trends
    assert "microimpact.model.rigid_body.algebra.rigid_body_rebound" not in trends


def test_methods_count_where_their_name_is_used():
    force = reached("microimpact.studies.models.force_history.run")
    assert "microimpact.model.contact.Contact.stiffness" in force
    assert "microimpact.model.contact.Contact" in force


def test_every_function_of_the_ledger_is_reached_by_some_study(results):
    from microimpact import studies

    ledger = pd.read_csv(results / "tables/equations.csv", dtype=str, keep_default_na=False)
    runs = [f"{home}.run" for home in studies.homes().values()]
    registered = [f"{one.of.__module__}.{one.of.__qualname__}" for one in CLAIMS.values()]
    called = reached(*runs, *registered)
    assert set(ledger["function"]) - {""} <= called


RULES = (
    Rule(name="a", outputs=("tables/a.csv",)),
    Rule(name="b", inputs=("tables/a.csv", "src/x.py"), outputs=("data/b.csv",)),
    Rule(name="fig01", inputs=("data/b.csv",), outputs=("figures/fig01.svg",)),
    Rule(name="alone", outputs=("tables/alone.csv",)),
)


def test_the_graph_of_rules():
    needed = needs(RULES)
    assert needed == {"a": (), "b": ("a",), "fig01": ("b",), "alone": ()}
    assert upstream("fig01", needed) == ("b", "a")


def test_in_the_picture_each_rule_stands_right_of_what_it_needs():
    shown = picture(needs(RULES), {"fig01": "Figure 1"})
    nodes = {node.name: node for node in shown.nodes}
    for edge in shown.edges:
        start, end = nodes[edge.start], nodes[edge.end]
        assert start.x + start.width < end.x
    assert nodes["fig01"].words == "Figure 1"
    assert nodes["fig01"].x == max(node.x for node in shown.nodes)
    assert shown.width == nodes["fig01"].x + nodes["fig01"].width
    places = {(node.x, node.y) for node in shown.nodes}
    assert len(places) == len(RULES)


def test_bars_fill_the_whole_width():
    rows = [{"verdict": v} for v in ("good", "bad", "good", "strange")]
    bars = counts(rows, {"good": "good", "never": "mute", "bad": "bad"})
    assert [(b.verdict, b.number, b.begin, b.share) for b in bars] == [
        ("good", 2, 0.0, 50.0),
        ("bad", 1, 50.0, 25.0),
        ("strange", 1, 75.0, 25.0),
    ]


@pytest.mark.parametrize(
    ("sentence", "shown"),
    [
        ("at $\\alpha$ < 15", "at <i>α</i> &lt; 15"),
        ("v_c falls as v^-n", "<i>v</i><sub>c</sub> falls as <i>v</i><sup>−n</sup>"),
        ("a spin r omega", "a spin r <i>ω</i>"),
        ("e phi^2, mu_c", "e <i>φ</i><sup>2</sup>, <i>μ</i><sub>c</sub>"),
        ("v'_n at 10^3 1/s", "<i>v</i>′<sub>n</sub> at 10<sup>3</sup> 1/s"),
        (r"$-(V_t - r\Omega)$", "−(<i>V</i><sub>t</sub> − <i>r</i><i>Ω</i>)"),
        # Names of columns and words that begin like a letter stay.
        ("speed_m_per_s, mu-th, <b>", "speed_m_per_s, mu-th, &lt;b&gt;"),
    ],
)
def test_symbols_in_a_sentence(sentence, shown):
    assert prose(sentence) == shown


def test_code_has_a_page_with_a_place_for_every_function():
    stiffness = "microimpact.model.contact.Contact.stiffness"
    assert place(stiffness) == "code/microimpact.model.contact.html#Contact.stiffness"
    assert place("microimpact.model.contact.nothing") == place("os.remove") == place("") == ""
    (module,) = modules([stiffness, "os.remove", "microimpact.model.contact.hertz_stiffness"])
    assert module.file == "src/microimpact/model/contact.py"
    begins = {name: i for i, line in enumerate(module.lines) for name in line.begins}
    # A property begins with its decorator, within its class.
    at = begins["Contact.stiffness"]
    assert "@" in module.lines[at].text
    assert "def stiffness" in module.lines[at + 1].text
    assert begins["Contact"] < at
    assert sum(line.ends for line in module.lines) == sum(len(x.begins) for x in module.lines)


def test_the_font_has_the_signs_of_all_formulas():
    sheet = (ASSETS / "formula.css").read_text(encoding="utf-8")
    data = base64.b64decode(re.search(r"base64,([^)]*)", sheet)[1])
    known = set(map(chr, TTFont(io.BytesIO(data)).getBestCmap()))
    forms = [form for each in EQUATIONS.values() for form in (each.printed, each.form_used)]
    assert set("".join(map(text, forms))) <= known


def test_a_claim_tells_the_departures_that_it_rests_on_alone():
    keys = ("force_history.diameter_um", "calibration.n", "doe.levels", "claim_numbers.speed")
    declared = [{"key": key, "overrides": "printed.x = 1"} for key in keys]
    needed = {"force_history": ("calibration",), "claim_numbers": ()}
    record = SimpleNamespace(figures={"fig25": {"study": "doe"}})

    def told(**claim):
        own = studies_behind({"figures": "", "inputs": "", **claim}, record)
        return [row["key"] for row in departures(declared, own, needed)]

    assert told() == ["claim_numbers.speed"]
    assert told(inputs="force_ratios materials") == [keys[0], keys[1], keys[3]]
    assert told(figures="fig25") == [keys[2], keys[3]]


def test_items_of_a_list_stand_in_one_row():
    def row(key, value, **changes):
        same = {"unit": "deg", "evidence": "chosen", "source": "s", "overrides": ""}
        return {"key": key, "value": value} | same | changes

    rows = [
        *(row("angles[0]", "1"), row("angles[1]", "2"), row("angles[2]", "3", source="t")),
        *(row("angles[3]", "5", source="t", overrides="4 (chosen: t)"), row("n", "4")),
    ]
    assert joined(rows) == [
        *(row("angles", "1, 2"), row("angles", "3", source="t")),
        *(row("angles", "5", source="t", overrides="4 (chosen: t)"), row("n", "4")),
    ]
