"""Sections 3.1.3 and 3.1.4: energy, work of impulses, impulse ratio of the rigid body model."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import sympy

from microimpact.ledgers.equations.forms import Form, symbols, vanishes
from microimpact.ledgers.equations.impulses import INERTIA, adhesion, newton
from microimpact.ledgers.equations.records import (
    Case,
    Consequence,
    Derivation,
    Equation,
    Facts,
    Values,
    follows,
)
from microimpact.model.rigid_body import algebra

e, eta, m, omega, p, R, rho, v, V = symbols("e eta m omega p R rho v V")
v_n, v_t, V_n, V_t, Omega, P_n, P_t = symbols("v_n v_t V_n V_t Omega P_n P_t")
F, T_L, W_A, W_D, W_n, x = symbols("F T_L W_A W_D W_n x")
P_D_R = symbols("P_D_R")[0]


@cache
def losses(*, rotation: bool) -> Facts:
    """Energy lost by the state after impact, with the rotation or, without spin, less it."""
    after = newton()
    lost = m * (v_n**2 + v_t**2 - after[V_n] ** 2 - after[V_t] ** 2) / 2
    before = {v: sympy.sqrt(v_n**2 + v_t**2), eta: after[eta]}
    if rotation:
        return before | {T_L: lost + INERTIA * (omega**2 - after[Omega] ** 2) / 2}
    return {omega: 0, T_L: lost, **{name: value.subs(omega, 0) for name, value in before.items()}}


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
        W_n: gained,
        e: sympy.sqrt(sympy.factor(2 * gained / (m * v_n**2))),
    }


@cache
def balance() -> Facts:
    """Loss through adhesion: all that is lost less what the body alone would lose (Eq. 17)."""
    kept = works()[e] ** 2
    return {W_A: (R**2 - kept) * m * v_n**2 / 2}


def _power(form: Form, _: Case) -> bool:
    """Compare integrands per time: dx = v dtau, dp = F dtau."""
    rate = {x: v, p: F}
    left, right = (
        side.replace(sympy.Integral, lambda integrand, range_: integrand * rate[range_[0]])
        for side in (form.left, form.right)
    )
    return bool(left == right)


def _made_by_spin(form: Form, _: Case) -> bool:
    """At normal incidence: absent without spin, present with it."""
    free, rolling = symbols("mu mu_0")
    impulse = form.residual.subs(newton()).subs(free, newton()[rolling]).subs(v_t, 0)
    absent, present = vanishes(impulse.subs(omega, 0)), not vanishes(impulse)
    return form.relation == "!=" and absent and present


def _rolling_losses(e: float) -> tuple[float, float]:
    """Return translational and total loss of rolling at 60 degrees without spin."""
    v_n, v_t = -np.sin(np.pi / 3), np.cos(np.pi / 3)
    rolling = algebra.rolling_impulse_ratio(v_n, v_t, e)
    lost = algebra.energy_loss(v_n, v_t, 0.0, 1.0, e, rolling)
    return float(lost.translational), float(lost.total)


def _lost(x: Values, rho: float) -> Any:
    """Return the loss through adhesion, J."""
    return x["m"] * algebra.adhesion_work(x["v_n"], x["R"], rho)


EQUATIONS = (
    Equation(
        "14",
        "2*T_L/(m*v**2) = ((1 - e**2) + 2*mu*(1 + e)*eta - mu**2*(1 + e)**2)/(1 + eta**2)",
        derivation=follows("translational energy, no spin", lambda: losses(rotation=False)),
        reason="Exactly the translational loss of a sphere without initial spin.",
        function="microimpact.model.rigid_body.algebra.energy_loss",
    ),
    Equation(
        "14 total",
        "2*T_L/(m*v**2) = ((1 - e**2) + 2*mu*(1 + e)*eta - mu**2*(1 + e)**2)/(1 + eta**2)",
        used=(
            "article",
            "2*T_L/(m*v**2) = ((1 - e**2) + 2*mu*(1 + e)*eta - 7*mu**2*(1 + e)**2/2)"
            "/(1 + (v_t/v_n)**2)",
        ),
        derivation=follows("all kinetic energy, any spin", lambda: losses(rotation=True)),
        reason="The text announces the whole loss, which needs 7/2 and the velocities' own ratio.",
        function="microimpact.model.rigid_body.algebra.energy_loss",
        implementation=lambda x: (
            algebra.energy_loss(x["v_n"], x["v_t"], x["omega"], x["r"], x["e"], x["mu"]).total
        ),
        consequence=Consequence(
            "excess over the whole loss, rolling at 60 degrees without initial spin",
            lambda at: np.subtract(*_rolling_losses(at.values()["e"])),
        ),
    ),
    Equation(
        "14 notation",
        "2*T_L/(m*v**2) = (v**2 - V**2)/v**2",
        used=("article", "T_L = (v**2 - V**2)/v**2"),
        means={"T_L": ""},
        derivation=follows("Eq. (3)", lambda: {T_L: (v**2 - V**2) / v**2}),
        reason="T_L of Eq. (3) is already dimensionless; it must not be divided by m v^2/2 again.",
        function="microimpact.model.rigid_body.algebra.energy_loss",
    ),
    Equation(
        "15",
        "Integral(F, x) = Integral(v, p)",
        derivation=Derivation("symbolic: change of variable", _power),
        reason="dx = v dtau and dp = F dtau.",
    ),
    Equation(
        "3.1.3 rebound work",
        "W_n = R**2*(1 - rho)*m*v_n**2/2",
        used=("article", "W_D = R**2*(1 - rho)*m*v_n**2/2"),
        derivation=follows("integral of velocity over impulse", works),
        reason="The work of the deformation impulse; that of the whole normal impulse is less.",
        consequence=Consequence(
            "work over that of the whole normal impulse at rho = 0.5",
            lambda at: (
                at.printed(rho=0.5) / at.formula("W_n = R**2*(1 - rho)**2*m*v_n**2/2", rho=0.5)
            ),
        ),
    ),
    Equation(
        "3.1.3 adhesion work",
        "W_A = -R**2*rho*(1 - rho)*m*v_n**2/2",
        derivation=follows("integral of velocity over impulse", works),
        reason="Correct as the work of the impulse, but it differs from W_A of Eq. (17) in "
        "sign and value.",
        consequence=Consequence(
            "size of this W_A over that of Eq. (17) at rho = 0.01",
            lambda at: -at.printed(rho=0.01) / _lost(at.values(), 0.01),
        ),
    ),
    Equation(
        "16",
        "e**2 = R**2*(1 - rho)**2",
        derivation=follows("kinetic energy from work of impulses", works),
        reason="Follows from momentum as well; the root for 0 <= rho <= 1 is e = R (1 - rho).",
        function="microimpact.model.rigid_body.algebra.restitution_with_adhesion",
        implementation=lambda x: algebra.restitution_with_adhesion(x["R"], x["rho"]) ** 2,
    ),
    Equation(
        "17",
        "(1 - e**2)*m*v_n**2/2 = (1 - R**2)*m*v_n**2/2 + W_A",
        derivation=follows("balance of Eq. (16)", lambda: balance() | {e: works()[e]}),
        reason="Defines W_A again, now as a positive loss.",
        function="microimpact.model.rigid_body.algebra.adhesion_work",
    ),
    Equation(
        "18",
        "W_A = m*v_n**2*R**2*rho*(2 - rho)/z",
        used=("scan", "W_A = m*v_n**2*R**2*rho*(2 - rho)/2"),
        derivation=follows("balance of Eq. (17)", balance),
        reason="The letter z is a misread digit 2.",
        function="microimpact.model.rigid_body.algebra.adhesion_work",
        implementation=lambda x: _lost(x, x["rho"]),
    ),
    Equation(
        "3.1.3 capture work",
        "W_A = R**2*m*v_n**2/z",
        used=("scan", "W_A = R**2*m*v_n**2/2"),
        derivation=follows(
            "balance of Eq. (17) at rho = 1", lambda: {W_A: balance()[W_A].subs(rho, 1)}
        ),
        reason="The letter z is a misread digit 2.",
        function="microimpact.model.rigid_body.algebra.adhesion_work",
        implementation=lambda x: _lost(x, 1.0),
    ),
    Equation(
        "3.1.4 spin",
        "P_n != 0",
        used=("scan or article", "P_t != 0"),
        derivation=Derivation("symbolic: 90 degrees, with spin and without", _made_by_spin),
        reason="Spin causes a tangential impulse at 90 degrees; there is always a normal impulse.",
        function="microimpact.model.rigid_body.algebra.rigid_body_rebound",
    ),
)
