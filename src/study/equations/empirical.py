"""Section 3.3, Eqs. (32) to (34): empirical coefficients as functions of the normal velocity.

The capture velocity v_c has the sign of v_n here, negative, a convention that the text leaves open:
with it Eqs. (33) and (34) hold as printed from the capture velocity upwards.
"""

from __future__ import annotations

from itertools import pairwise

from microimpact.model.empirical.equations import (
    adhesion_coefficient,
    body_restitution,
    restitution,
)
from study.equations.forms import Form, symbols
from study.equations.records import At, Derivation, Proof, ReferenceCase

e, R, rho, v_n = symbols("e R rho v_n")

# Any constants, with those of a pair equal, and speeds as multiples of the capture velocity.
_CONSTANTS = dict(
    zip(
        symbols("k k_1 k_2 kappa kappa_1 kappa_2 p q v_c"),
        (30, 30, 30, 2, 2, 2, 1.4, 1.2, -1),
        strict=True,
    )
)


def _at(form: Form, speed: float) -> float:
    """Return the right side at a normal velocity of approach, which is negative."""
    return float(form.right.subs(_CONSTANTS).subs(v_n, -speed).evalf())


def _body(form: Form, _: ReferenceCase) -> bool:
    """R must be 1 at rest and fall with speed, towards 0."""
    values = [_at(form, speed) for speed in (0.0, 0.5, 1.0, 30.0, 1e6)]
    falls = all(low < high for high, low in pairwise(values))
    return bool(form.left == R and values[0] == 1.0 and falls and values[-1] < 1e-3)


def _captures(form: Form, _: ReferenceCase) -> bool:
    """No rebound at the capture velocity, a rising one above, the body's in the limit."""
    k, p = (_CONSTANTS[name] for name in symbols("k p"))
    none, all_ = {rho: (1.0, 0.0), e: (0.0, float(body_restitution(1e3, k, p)))}[form.left]
    values = [_at(form, speed) for speed in (1.0, 1.01, 1.1, 2.0)]
    leaves = all(abs(b - none) > abs(a - none) for a, b in pairwise(values))
    return values[0] == none and leaves and abs(_at(form, 1e3) - all_) < 1e-3


def _by_speed(at: At) -> float:
    """Return the capture velocity that a positive v_c would give."""
    speed = -at.values()["v_c"]
    constants = dict.fromkeys(("v_c", "kappa", "kappa_1", "kappa_2"), speed)
    return at.printed(v_n=-speed, q=1.0, **constants)


PROOFS = {
    "32": Proof(
        Derivation("numeric: limits at rest and at high speed", _body),
        lambda x: body_restitution(-x["v_n"], x["k_1"], x["p"]),
    ),
    "33": Proof(
        Derivation("numeric: capture at v_c, rebound above", _captures),
        lambda x: adhesion_coefficient(-x["v_n"], x["kappa_1"], x["q"], -x["v_c"]),
        _by_speed,
    ),
    "34": Proof(
        Derivation("numeric: capture at v_c, rebound above", _captures),
        lambda x: restitution(*(-x["v_n"], x["k"], x["p"], x["kappa"], x["q"], -x["v_c"])),
        _by_speed,
    ),
}
