"""Section 3.2, Eqs. (26) to (31): friction, rotation, adhesion, and the numbers of 3.2.2."""

from __future__ import annotations

from functools import cache

import numpy as np
import sympy

from microimpact.model.contact import ring_force_from_work
from microimpact.model.dynamics.impact import planar, simulate
from microimpact.model.dynamics.normal import normal_impact
from study.equations import impulses
from study.equations.contact import TRACED_MOMENT, traced
from study.equations.forms import Form, symbols, vanishes
from study.equations.records import (
    At,
    Derivation,
    Facts,
    Proof,
    ReferenceCase,
    follows,
    solve,
    where_one,
)

# Section 3.2.2: the impact behind the printed spin; its diameter is not stated, so 5 % is allowed.
SPIN_SPEED, SPIN_ANGLE, SPIN_TOLERANCE = 1.6, 50.0, 0.05

a_c, f, f_0, F_n, F_t, inertia, K, K_H, m, r, R, s, w_A = symbols(
    "a_c f f_0 F_n F_t I K K_H m r R s w_A"
)
t_ddot, theta_ddot, Omega, V_t = symbols("t_ddot theta_ddot Omega V_t")


def newton() -> Facts:
    """Accelerations under a force at the contact point, -R n from the centre; axes (t, n)."""
    moment = impulses.turning(sympy.Matrix([0, -R, 0]), F_t, F_n)
    return {t_ddot: F_t / m, theta_ddot: moment / inertia}


def rolling_force() -> Facts:
    """Tangential force at which slip, once zero, stays zero."""
    known = newton()
    return solve([known[t_ddot] - R * known[theta_ddot]], F_t)


def rolling() -> Facts:
    """State of a sphere that leaves with the impulse ratio mu_0."""
    mu, mu_0 = symbols("mu mu_0")
    state = impulses.newton()
    return {name: state[name].subs(mu, state[mu_0]) for name in (V_t, Omega)}


@cache
def equilibrium() -> Facts:
    """Ring force that holds a sphere at the contact radius of JKR at zero load."""
    a = sympy.Symbol("a", positive=True)
    radius = where_one((K * a**3 / r) / sympy.sqrt(6 * sympy.pi * w_A * K * a**3), a)
    return solve([(K * a**3 / r - 2 * sympy.pi * a * f_0).subs(a, radius)], f_0)


@cache
def attachment() -> tuple[sympy.Expr, sympy.Symbol, sympy.Expr]:
    """Reduced stiffness: energy of a contact as of Hertz with another stiffness.

    K_H for the radius of a share of the squared equilibrium radius, that share, and its value for a
    sphere that attaches from rest in the potential of Eq. (19).
    """
    b, d, share = sympy.symbols("b d s_e", positive=True)
    hertz = sympy.Rational(2, 5) * b**5 / R**2
    reduced = solve([hertz * K_H - hertz * K + sympy.pi * w_A * b**2], K_H)[K_H]
    root = sympy.sqrt(r)
    stored = sympy.Rational(2, 5) * root * K * d ** sympy.Rational(5, 2)
    freed = sympy.Rational(4, 3) * sympy.pi * root * f_0 * d ** sympy.Rational(3, 2)
    turning, resting = where_one(stored / freed, d), where_one(stored.diff(d) / freed.diff(d), d)
    return reduced.subs(b, a_c * sympy.sqrt(share)), share, turning / resting


def _reduced(form: Form, _: ReferenceCase) -> bool | None:
    """Compare structure, then the one number that the text leaves open."""
    reduced, share, ratio = attachment()
    number = sympy.cancel((K - form.right) / (K - reduced.subs(share, 1)))
    if form.left != K_H or not (number.is_number and number > 0):
        return False
    return vanishes(number ** sympy.Rational(-2, 3) - ratio) or None


def _softer(form: Form, _: ReferenceCase) -> bool:
    reduced, share, _ = attachment()
    gap = sympy.expand(form.residual.subs(K_H, reduced.subs(share, 1)))
    return form.relation == ">" and bool(gap.is_positive)


def _resists(form: Form, _: ReferenceCase) -> bool:
    """Friction must take f F_n of power from unit slip, and never give any."""
    way = sympy.Symbol("way", real=True)
    power = way * form.right.replace(sympy.sign, lambda slip: way)  # noqa: ARG005
    at = [power.subs({f: 1, F_n: force, way: d}) for force in (1, -1) for d in (1, -1)]
    return bool(form.left == F_t and max(at) <= 0 and at[:2] == [-1, -1])


def _printed_spin(form: Form, case: ReferenceCase) -> bool:
    """Compare with the simulated impact."""
    simulated = float(simulate(case.contact, SPIN_SPEED, SPIN_ANGLE).spin)
    stated = float(form.right.subs(s, 1))
    return form.left == Omega and abs(simulated - stated) < SPIN_TOLERANCE * stated


def _strain_rate(form: Form, case: ReferenceCase) -> bool:
    """Contact radius over radius, in half the contact time, must be of the order stated."""
    impact = normal_impact(case.contact, case.numbers["v"])
    radius = np.sqrt(case.contact.hertz_radius * impact.maximum_compression)
    rate = radius / case.contact.radius / (0.5 * impact.contact_time)
    return 1.0 <= float(rate) / float(form.right.subs(s, 1)) < 10.0


def _slip_left(at: At) -> float:
    """Return final over initial slip of a sphere that slides, with the moment as printed."""
    x = at.values()
    impulse = -x["m"] * x["mu"] * (1.0 + x["e"]) * x["v_n"]
    spun = at.printed(F_t=impulse) / (0.4 * x["m"] * x["r"] ** 2)
    change: float = (impulse / x["m"] - x["r"] * spun) / x["v_t"]
    return 1.0 + change


PROOFS = {
    "26": Proof(follows("linear momentum", newton)),
    "27": Proof(
        Derivation("symbolic: friction takes energy from slip", _resists),
        lambda x: traced(x).friction_force[TRACED_MOMENT],
        lambda at: (
            simulate(at.case.contact, at.values()["v"], 10.0, friction_basis="net").impulse_ratio
            / at.case.contact.friction
        ),
    ),
    "28": Proof(follows("slip stays zero", rolling_force)),
    "29": Proof(
        follows("angular momentum", newton),
        lambda x: x["I"] * (planar(x["contact"], x["v_n"], x["v_t"], x["omega"]).spin - x["omega"]),
        _slip_left,
    ),
    "30": Proof(
        follows("contact radius of JKR at zero load", equilibrium),
        lambda x: ring_force_from_work(x["w_A"], x["r"], x["K"]),
    ),
    "31": Proof(
        Derivation("symbolic: energy of attachment", _reduced),
        lambda x: x["contact"].replace(stiffness_model="reduced").stiffness,
        lambda at: at.printed() / at.values()["K"],
    ),
    "3.2.1 softer": Proof(Derivation("symbolic: energy of attachment", _softer)),
    "3.2.2 spin": Proof(
        follows("impulse that just ends slip", rolling),
        consequence=lambda at: at.printed(V_t=5.0 / 7.0 * 1.6 * np.cos(np.radians(50.0)), r=1e-5),
    ),
    "3.2.2 spin value": Proof(
        Derivation("numeric: simulated impact, within 5 %", _printed_spin),
        consequence=lambda at: float(simulate(at.case.contact, SPIN_SPEED, SPIN_ANGLE).spin),
    ),
    "3.2.2 strain rate": Proof(Derivation("numeric: a/r in half the contact time", _strain_rate)),
}
