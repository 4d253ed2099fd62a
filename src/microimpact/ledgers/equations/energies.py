"""Sections 3.1.3 and 3.1.4: energy, work of impulses, impulse ratio of the rigid body model."""

from __future__ import annotations

from functools import cache

import numpy as np
import sympy

from microimpact.ledgers.equations.forms import Form, declared, symbols, vanishes
from microimpact.ledgers.equations.impulses import INERTIA, UNITS, adhesion, newton
from microimpact.ledgers.equations.records import (
    Case,
    Consequence,
    Derivation,
    Equation,
    Facts,
    Outcome,
    Values,
    follows,
    passed,
)
from microimpact.model.rigid_body.algebra import (
    adhesion_work,
    energy_loss,
    restitution_with_adhesion,
    rolling_impulse_ratio,
)

ENERGIES = UNITS | declared({"J": "T_L W_A W_n W_D", "N": "F", "m": "x", "N*s": "p"})

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


def loss_as_number() -> Facts:
    """Loss as Eq. (3) defines it."""
    return {T_L: (v**2 - V**2) / v**2}


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


def at_capture() -> Facts:
    """Loss through adhesion where nothing rebounds."""
    return {W_A: balance()[W_A].subs(rho, 1)}


def _power(form: Form, _: Case) -> Outcome:
    """Compare integrands per time: dx = v dtau, dp = F dtau."""
    rate = {x: v, p: F}
    left, right = (
        side.replace(sympy.Integral, lambda integrand, range_: integrand * rate[range_[0]])
        for side in (form.left, form.right)
    )
    return passed(left == right)


def _made_by_spin(form: Form, _: Case) -> Outcome:
    """At normal incidence: absent without spin, present with it."""
    free, rolling = symbols("mu mu_0")
    impulse = form.residual.subs(newton()).subs(free, newton()[rolling]).subs(v_t, 0)
    absent, present = vanishes(impulse.subs(omega, 0)), not vanishes(impulse)
    return passed(form.relation == "!=" and absent and present)


def _rolling_losses(e: float) -> tuple[float, float]:
    """Return translational and total loss of rolling at 60 degrees without spin."""
    v_n, v_t = -np.sin(np.pi / 3), np.cos(np.pi / 3)
    lost = energy_loss(v_n, v_t, 0.0, 1.0, e, rolling_impulse_ratio(v_n, v_t, e))
    return float(lost.translational), float(lost.total)


def _work(x: Values) -> float:
    return float(x["m"] * adhesion_work(x["v_n"], x["R"], x["rho"]))


def _total(x: Values) -> float:
    return float(energy_loss(x["v_n"], x["v_t"], x["omega"], x["r"], x["e"], x["mu"]).total)


EQUATIONS = (
    Equation(
        id="14",
        section="3.1.3",
        printed="2*T_L/(m*v**2) = ((1 - e**2) + 2*mu*(1 + e)*eta - mu**2*(1 + e)**2)/(1 + eta**2)",
        units=ENERGIES,
        derivation=follows("translational energy, no spin", lambda: losses(rotation=False)),
        reason="Exactly the translational loss of a sphere without initial spin.",
        function="microimpact.model.rigid_body.algebra.energy_loss",
    ),
    Equation(
        id="14 total",
        section="3.1.3",
        printed="2*T_L/(m*v**2) = ((1 - e**2) + 2*mu*(1 + e)*eta - mu**2*(1 + e)**2)/(1 + eta**2)",
        used="2*T_L/(m*v**2) = ((1 - e**2) + 2*mu*(1 + e)*eta - 7*mu**2*(1 + e)**2/2)"
        "/(1 + (v_t/v_n)**2)",
        slip="article",
        units=ENERGIES,
        derivation=follows("all kinetic energy, any spin", lambda: losses(rotation=True)),
        reason="The text announces the whole loss, which needs 7/2 and the velocities' own ratio.",
        function="microimpact.model.rigid_body.algebra.energy_loss",
        implementation=_total,
        consequence=Consequence(
            text="excess over the whole loss, rolling at 60 degrees without initial spin",
            unit="1",
            value=lambda at: float(np.subtract(*_rolling_losses(at.values()["e"]))),
        ),
    ),
    Equation(
        id="14 notation",
        section="3.1.3",
        printed="2*T_L/(m*v**2) = (v**2 - V**2)/v**2",
        used="T_L = (v**2 - V**2)/v**2",
        slip="article",
        units=UNITS,
        derivation=follows("Eq. (3)", loss_as_number),
        reason="T_L of Eq. (3) is already dimensionless; it must not be divided by m v^2/2 again.",
        function="microimpact.model.rigid_body.algebra.energy_loss",
    ),
    Equation(
        id="15",
        section="3.1.3",
        printed="Integral(F, x) = Integral(v, p)",
        units=ENERGIES,
        derivation=Derivation(method="symbolic: change of variable", check=_power),
        reason="dx = v dtau and dp = F dtau.",
    ),
    Equation(
        id="3.1.3 rebound work",
        section="3.1.3",
        printed="W_n = R**2*(1 - rho)*m*v_n**2/2",
        used="W_D = R**2*(1 - rho)*m*v_n**2/2",
        slip="article",
        units=ENERGIES,
        derivation=follows("integral of velocity over impulse", works),
        reason="The work of the deformation impulse; that of the whole normal impulse is less.",
        consequence=Consequence(
            text="work over that of the whole normal impulse at rho = 0.5",
            unit="1",
            value=lambda at: (
                at.printed(rho=0.5) / at.formula("W_n = R**2*(1 - rho)**2*m*v_n**2/2", rho=0.5)
            ),
        ),
    ),
    Equation(
        id="3.1.3 adhesion work",
        section="3.1.3",
        printed="W_A = -R**2*rho*(1 - rho)*m*v_n**2/2",
        units=ENERGIES,
        derivation=follows("integral of velocity over impulse", works),
        reason="Correct as the work of the impulse, but it differs from W_A of Eq. (17) in "
        "sign and value.",
        consequence=Consequence(
            text="size of this W_A over that of Eq. (17) at rho = 0.01",
            unit="1",
            value=lambda at: -at.printed(rho=0.01) / _work(at.values(rho=0.01)),
        ),
    ),
    Equation(
        id="16",
        section="3.1.3",
        printed="e**2 = R**2*(1 - rho)**2",
        units=ENERGIES,
        derivation=follows("kinetic energy from work of impulses", works),
        reason="Follows from momentum as well; the root for 0 <= rho <= 1 is e = R (1 - rho).",
        function="microimpact.model.rigid_body.algebra.restitution_with_adhesion",
        implementation=lambda x: float(restitution_with_adhesion(x["R"], x["rho"]) ** 2),
    ),
    Equation(
        id="17",
        section="3.1.3",
        printed="(1 - e**2)*m*v_n**2/2 = (1 - R**2)*m*v_n**2/2 + W_A",
        units=ENERGIES,
        derivation=follows("balance of Eq. (16)", lambda: balance() | {e: works()[e]}),
        reason="Defines W_A again, now as a positive loss.",
        function="microimpact.model.rigid_body.algebra.adhesion_work",
    ),
    Equation(
        id="18",
        section="3.1.3",
        printed="W_A = m*v_n**2*R**2*rho*(2 - rho)/z",
        used="W_A = m*v_n**2*R**2*rho*(2 - rho)/2",
        slip="scan",
        units=ENERGIES,
        derivation=follows("balance of Eq. (17)", balance),
        reason="The letter z is a misread digit 2.",
        function="microimpact.model.rigid_body.algebra.adhesion_work",
        implementation=_work,
    ),
    Equation(
        id="3.1.3 capture work",
        section="3.1.3",
        printed="W_A = R**2*m*v_n**2/z",
        used="W_A = R**2*m*v_n**2/2",
        slip="scan",
        units=ENERGIES,
        derivation=follows("balance of Eq. (17) at rho = 1", at_capture),
        reason="The letter z is a misread digit 2.",
        function="microimpact.model.rigid_body.algebra.adhesion_work",
        implementation=lambda x: _work({**x, "rho": 1.0}),
    ),
    Equation(
        id="3.1.4 spin",
        section="3.1.4",
        printed="P_n != 0",
        used="P_t != 0",
        slip="scan or article",
        units=UNITS,
        derivation=Derivation(
            method="symbolic: 90 degrees, with spin and without", check=_made_by_spin
        ),
        reason="Spin causes a tangential impulse at 90 degrees; there is always a normal impulse.",
        function="microimpact.model.rigid_body.algebra.rigid_body_rebound",
    ),
)
