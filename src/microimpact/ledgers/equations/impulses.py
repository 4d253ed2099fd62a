"""Sections 3.1.1 and 3.1.2: coefficients and solution equations of the rigid body model."""

from __future__ import annotations

from functools import cache

import sympy

from microimpact.ledgers.equations.forms import symbols
from microimpact.ledgers.equations.records import (
    Consequence,
    Equation,
    Facts,
    Values,
    follows,
    solve,
)
from microimpact.model.rigid_body import algebra

e, eta, k, m, mu, mu_0, omega, Omega, r, R, rho = symbols("e eta k m mu mu_0 omega Omega r R rho")
v_n, v_t, V_n, V_t, V_Ct = symbols("v_n v_t V_n V_t V_Ct")
P_n, P_t, P_D, P_D_A, P_D_R, P_A_R = symbols("P_n P_t P_D P_D_A P_D_R P_A_R")

INERTIA = sympy.Rational(2, 5) * m * r**2


def turning(arm: sympy.Matrix, along: sympy.Expr, away: sympy.Expr) -> sympy.Expr:
    """Moment of a vector in the plane, in the sense of a spin that rolls along +t."""
    return -arm.cross(sympy.Matrix([along, away, 0]))[2]


@cache
def newton() -> Facts:
    """State of a solid sphere after impact: linear and angular momentum, given e and mu.

    Axes are (t, n); the contact point is at -r n from the centre.
    """
    arm = sympy.Matrix([0, -r, 0])
    after = solve(
        [
            m * (V_n - v_n) - P_n,
            m * (V_t - v_t) - P_t,
            INERTIA * (Omega - omega) - turning(arm, P_t, P_n),
            V_n + e * v_n,
            P_t - mu * P_n,
        ],
        V_n,
        V_t,
        Omega,
        P_n,
        P_t,
    )
    slip = contact_velocity()[V_Ct].subs(after)
    slip_0 = slip.subs(mu, 0)
    rolling = solve([slip], mu)[mu]
    gyration = sympy.sqrt(INERTIA / m)
    return after | {V_Ct: slip, mu_0: rolling, eta: slip_0 / v_n, k: gyration}


@cache
def contact_velocity() -> Facts:
    """Velocity of the contact point along the surface, by the kinematics of a rigid body."""
    arm, spin = sympy.Matrix([0, -r, 0]), sympy.Matrix([0, 0, -Omega])
    return {V_Ct: V_t + spin.cross(arm)[0]}


@cache
def adhesion() -> Facts:
    """Impulses of deformation and adhesion that make up the momentum of rebound, R (1 - rho)."""
    approach, rebound = -m * v_n, -m * R * v_n
    return {
        P_D_A: approach,
        P_D_R: rebound,
        P_D: approach + rebound,
        P_A_R: m * -R * (1 - rho) * v_n - rebound,
    }


def _after(x: Values) -> algebra.RigidBodyRebound:
    return algebra.rigid_body_rebound(x["v_n"], x["v_t"], x["omega"], x["r"], x["e"], x["f"])


EQUATIONS = (
    Equation(
        "4",
        "mu = P_t/P_n",
        reason="Defines the impulse ratio; Eq. (2) follows from it.",
        function="microimpact.model.rigid_body.algebra.rigid_body_rebound",
    ),
    Equation(
        "5",
        "P_A_R = -rho*P_D_A",
        used=("article", "P_A_R = -rho*P_D_R"),
        derivation=follows("momentum of rebound R (1 - rho)", adhesion),
        reason="Eqs. (10), (16) and (34) need the deformation impulse of rebound, not of approach.",
        function="microimpact.model.rigid_body.algebra.adhesion_impulse",
        consequence=Consequence(
            "restitution at R = 0.9, rho = 0.5, in place of 0.45",
            lambda at: 0.9 + at.printed(rho=0.5, P_D_A=1.0),
        ),
    ),
    Equation(
        "6",
        "V_n = -e*v_n",
        derivation=follows("impulse and momentum", newton),
        reason="Eq. (1) solved for the final velocity.",
        function="microimpact.model.rigid_body.algebra.rigid_body_rebound",
        implementation=lambda x: _after(x).V_n,
    ),
    Equation(
        "7",
        "V_t = v_t - mu*(1 + e)*v_n",
        derivation=follows("impulse and momentum", newton),
        reason="Tangential momentum with the impulse mu P_n.",
        function="microimpact.model.rigid_body.algebra.rigid_body_rebound",
        implementation=lambda x: _after(x).V_t,
    ),
    Equation(
        "8",
        "Omega = omega + 5*mu*(1 + e)*v_n/(2*k**2)",
        used=("scan or article", "Omega = omega + 5*mu*(1 + e)*v_n/(2*r)"),
        derivation=follows("angular momentum", newton),
        reason="5/2 already contains the inertia of a solid sphere, so only one radius may divide.",
        function="microimpact.model.rigid_body.algebra.rigid_body_rebound",
        implementation=lambda x: _after(x).Omega,
        consequence=Consequence(
            "factor on the change of spin of a 62 um sphere, which has a dimension",
            lambda at: at.printed(omega=0.0) / at.used(omega=0.0),
            "1/m",
        ),
    ),
    Equation(
        "9",
        "P_D = -m*(1 + R)*v_n",
        derivation=follows("deformation impulses of approach and rebound", adhesion),
        reason="Sum over approach and rebound.",
        function="microimpact.model.rigid_body.algebra.deformation_impulse",
        implementation=lambda x: x["m"] * algebra.deformation_impulse(x["v_n"], x["R"]),
    ),
    Equation(
        "10",
        "P_A_R = rho*R*m*v_n",
        derivation=follows("momentum of rebound R (1 - rho)", adhesion),
        reason="Agrees with Eqs. (6), (9) and (16), unlike Eq. (5); it defines rho here.",
        function="microimpact.model.rigid_body.algebra.adhesion_impulse",
        implementation=lambda x: x["m"] * algebra.adhesion_impulse(x["v_n"], x["R"], x["rho"]),
    ),
    Equation(
        "3.1.2 contact velocity",
        "V_Ct = V_t - r*Omega",
        derivation=follows("kinematics of a rigid body", contact_velocity),
        reason="Spin is positive in the sense of rolling along +t.",
        function="microimpact.model.dynamics.trajectory.trajectory",
    ),
    Equation(
        "11",
        "V_Ct = v_t - r*omega - 7*mu*(1 + e)/(2*v_n)",
        used=("scan", "V_Ct = v_t - r*omega - 7*mu*(1 + e)*v_n/2"),
        derivation=follows("momentum and kinematics", newton),
        reason="The velocity belongs to the numerator: the sum of the changes in Eqs. (7) and (8).",
        function="microimpact.model.rigid_body.algebra.rigid_body_rebound",
        implementation=lambda x: _after(x).V_t - x["r"] * _after(x).Omega,
        consequence=Consequence(
            "change of slip as read literally over the right one, sliding at 30 degrees",
            lambda at: (at.printed(v_t=0.0, omega=0.0)) / at.used(v_t=0.0, omega=0.0),
            "s**2/m**2",
        ),
    ),
    Equation(
        "12",
        "mu_0 = 2*eta/(7*(1 + e))",
        derivation=follows("V_Ct = 0", newton),
        reason="Sliding ends if |mu_0| is below f; its sign is that of eta.",
        function="microimpact.model.rigid_body.algebra.rolling_impulse_ratio",
        implementation=lambda x: algebra.rolling_impulse_ratio(
            x["v_n"], x["v_t"] - x["r"] * x["omega"], x["e"]
        ),
        consequence=Consequence(
            "read as (2/7) eta (1 + e): factor on mu_0 at e = 0.70",
            lambda at: (1.0 + at.values()["e"]) ** 2,
        ),
    ),
    Equation(
        "13",
        "eta = (v_t - r*omega)/v_n",
        reason="Defines the ratio of slip to normal velocity before impact.",
        function="microimpact.model.rigid_body.algebra.rolling_impulse_ratio",
    ),
)
