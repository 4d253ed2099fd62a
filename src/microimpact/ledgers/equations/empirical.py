"""Section 3.3, Eqs. (32) to (34): empirical coefficients as functions of the normal velocity."""

from __future__ import annotations

from itertools import pairwise

from microimpact.ledgers.equations.forms import Form, declared, symbols
from microimpact.ledgers.equations.records import (
    At,
    Case,
    Consequence,
    Derivation,
    Equation,
    Outcome,
    Values,
    passed,
)
from microimpact.model.empirical.equations import (
    adhesion_coefficient,
    body_restitution,
    restitution,
)

UNITS = declared({"": "e R rho p q", "m/s": "k k_1 k_2 kappa kappa_1 kappa_2 v_n v_c"})

e, R, rho, v_n, v_c = symbols("e R rho v_n v_c")

# Any constants, with those of a pair equal, and speeds as multiples of the capture velocity.
_CONSTANTS = dict(
    zip(
        symbols("k k_1 k_2 kappa kappa_1 kappa_2 p q v_c"),
        (30, 30, 30, 2, 2, 2, 1.4, 1.2, 1),
        strict=True,
    )
)


def _at(form: Form, speed: float) -> float:
    """Return the right side at a normal velocity of approach, which is negative."""
    return float(form.right.subs(_CONSTANTS).subs(v_n, -speed).evalf())


def _body(form: Form, _: Case) -> Outcome:
    """R must be 1 at rest and fall with speed, towards 0."""
    values = [_at(form, speed) for speed in (0.0, 0.5, 1.0, 30.0, 1e6)]
    falls = all(low < high for high, low in pairwise(values))
    return passed(form.left == R and values[0] == 1.0 and falls and values[-1] < 1e-3)


def _captures(form: Form, _: Case) -> Outcome:
    """No rebound up to the capture velocity, some above, nearly that of the body far above."""
    none, all_ = {rho: (1.0, 0.0), e: (0.0, _body_alone(1e3))}[form.left]
    stays = all(abs(_at(form, speed) - none) < 1e-12 for speed in (0.0, 0.5, 1.0))
    return passed(stays and _at(form, 1.01) != none and abs(_at(form, 1e3) - all_) < 1e-3)


def _body_alone(speed: float) -> float:
    k, p = (_CONSTANTS[name] for name in symbols("k p"))
    return float(body_restitution(speed, k, p))


def _adhesion(x: Values) -> float:
    return float(adhesion_coefficient(-x["v_n"], x["kappa_1"], x["q"], x["v_c"]))


def _restitution(x: Values) -> float:
    return float(restitution(-x["v_n"], x["k"], x["p"], x["kappa"], x["q"], x["v_c"]))


def _at_capture(at: At) -> float:
    capture = at.values()["v_c"]
    return at.printed(v_n=-capture, kappa=capture, kappa_1=capture,
                       kappa_2=capture, q=1.0)  # fmt: skip


EQUATIONS = (
    Equation(
        id="32",
        section="3.3",
        printed="R = k_1**p/(k_2**p + Abs(v_n)**p)",
        units=UNITS,
        derivation=Derivation(method="numeric: limits at rest and at high speed", check=_body),
        reason="With k_1 = k_2, as for Eq. (34); otherwise R would not be 1 at rest.",
        function="microimpact.model.empirical.equations.body_restitution",
        implementation=lambda x: float(body_restitution(-x["v_n"], x["k_1"], x["p"])),
    ),
    Equation(
        id="33",
        section="3.3",
        printed="rho = kappa_1**q/(kappa_2**q + Abs(v_n - v_c)**q)",
        used="rho = kappa_1**q/(kappa_2**q + Max(Abs(v_n) - v_c, 0)**q)",
        slip="article",
        units=UNITS,
        derivation=Derivation(method="numeric: capture up to v_c, rebound above", check=_captures),
        reason="v_n < 0 before impact, so its absolute value must be compared; below v_c rho "
        "stays 1.",
        function="microimpact.model.empirical.equations.adhesion_coefficient",
        implementation=_adhesion,
        consequence=Consequence(
            text="rho at the capture velocity, in place of 1, with kappa = v_c and q = 1",
            unit="1",
            value=_at_capture,
        ),
    ),
    Equation(
        id="34",
        section="3.3",
        printed="e = k**p/(k**p + Abs(v_n)**p)*(1 - kappa**q/(kappa**q + Abs(v_n - v_c)**q))",
        used="e = k**p/(k**p + Abs(v_n)**p)*(1 - kappa**q/(kappa**q + Max(Abs(v_n) - v_c, 0)**q))",
        slip="article",
        units=UNITS,
        derivation=Derivation(method="numeric: capture up to v_c, rebound above", check=_captures),
        reason="The product R (1 - rho), with rho as corrected in Eq. (33).",
        function="microimpact.model.empirical.equations.restitution",
        implementation=_restitution,
        consequence=Consequence(
            text="e at the capture velocity, in place of 0, with kappa = v_c and q = 1",
            unit="1",
            value=_at_capture,
        ),
    ),
)
