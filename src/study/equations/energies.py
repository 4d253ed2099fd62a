"""Sections 3.1.3 and 3.1.4: energy, work of impulses, impulse ratio of the rigid body model."""

from __future__ import annotations

from functools import cache
from typing import Any

import sympy

from microimpact.model.rigid_body import algebra
from study.equations.forms import Form, symbols, vanishes
from study.equations.impulses import adhesion, newton
from study.equations.records import Derivation, Facts, Proof, ReferenceCase, Values, follows

e, eta, m, omega, p, R, rho, v, V = symbols("e eta m omega p R rho v V")
v_n, v_t, V_n, V_t, P_t = symbols("v_n v_t V_n V_t P_t")
F, T_L, W_A, W_D, x = symbols("F T_L W_A W_D x")
P_D_R = symbols("P_D_R")[0]


@cache
def losses() -> Facts:
    """Energy of translation lost by the state after impact, without initial spin."""
    after = newton()
    lost = m * (v_n**2 + v_t**2 - after[V_n] ** 2 - after[V_t] ** 2) / 2
    facts = {v: sympy.sqrt(v_n**2 + v_t**2), eta: after[eta], T_L: lost}
    return {omega: 0} | {name: value.subs(omega, 0) for name, value in facts.items()}


@cache
def works() -> Facts:
    """Work of each impulse of rebound, the integral of velocity over impulse.

    The sphere starts from rest, and adhesion takes back a fixed share rho of each increment.
    """
    reached = adhesion()[P_D_R]
    velocity = (1 - rho) * p / m
    deformation = sympy.integrate(velocity, (p, 0, reached))
    adhesive = -rho * deformation
    gained = deformation + adhesive
    return {
        W_D: deformation,
        W_A: adhesive,
        e: sympy.sqrt(sympy.factor(2 * gained / (m * v_n**2))),
    }


@cache
def balance() -> Facts:
    """Loss through adhesion: total loss less the loss of the body alone (Eq. 17)."""
    kept = works()[e] ** 2
    return {W_A: (R**2 - kept) * m * v_n**2 / 2}


def _power(form: Form, _: ReferenceCase) -> bool:
    """Compare integrands per time: dx = v dtau, dp = F dtau."""
    rate = {x: v, p: F}
    left, right = (
        side.replace(sympy.Integral, lambda integrand, range_: integrand * rate[range_[0]])
        for side in (form.left, form.right)
    )
    return bool(left == right)


def _made_by_spin(form: Form, _: ReferenceCase) -> bool:
    """At normal incidence: absent without spin, present with it."""
    free, rolling = symbols("mu mu_0")
    impulse = form.residual.subs(newton()).subs(free, newton()[rolling]).subs(v_t, 0)
    absent, present = vanishes(impulse.subs(omega, 0)), not vanishes(impulse)
    return form.relation == "!=" and absent and present


def _lost(x: Values, rho: float) -> Any:
    """Return the loss through adhesion, J."""
    return x["m"] * algebra.adhesion_work(x["v_n"], x["R"], rho)


PROOFS = {
    "14": Proof(follows("translational energy, no spin", losses)),
    "14 notation": Proof(follows("Eq. (3)", lambda: {T_L: (v**2 - V**2) / v**2})),
    "15": Proof(Derivation("symbolic: change of variable", _power)),
    "3.1.3 adhesion work": Proof(
        follows("integral of velocity over impulse", works),
        consequence=lambda at: -at.printed(rho=0.01) / _lost(at.values(), 0.01),
    ),
    "16": Proof(
        follows("kinetic energy from work of impulses", works),
        lambda x: algebra.restitution_with_adhesion(x["R"], x["rho"]) ** 2,
    ),
    "17": Proof(follows("balance of Eq. (16)", lambda: balance() | {e: works()[e]})),
    "18": Proof(follows("balance of Eq. (17)", balance), lambda x: _lost(x, x["rho"])),
    "3.1.3 capture work": Proof(
        follows("balance of Eq. (17) at rho = 1", lambda: {W_A: balance()[W_A].subs(rho, 1)}),
        lambda x: _lost(x, 1.0),
    ),
    "3.1.4 vanishing friction": Proof(
        follows("impulse and momentum at v_n = 0", lambda: {P_t: newton()[P_t].subs(v_n, 0)})
    ),
    "3.1.4 spin": Proof(Derivation("symbolic: 90 degrees, with spin and without", _made_by_spin)),
}
