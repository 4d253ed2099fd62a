"""Sections 3.1.1 and 3.1.2: coefficients and solution equations of the rigid body model."""

from __future__ import annotations

from functools import cache

import sympy

from microimpact.model.rigid_body import algebra
from study.equations.forms import symbols
from study.equations.records import Facts, Proof, Values, follows, solve

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


PROOFS = {
    "5": Proof(
        follows("momentum of rebound R (1 - rho)", adhesion),
        consequence=lambda at: 0.9 + at.printed(rho=0.5, P_D_A=1.0),
    ),
    "6": Proof(follows("impulse and momentum", newton), lambda x: _after(x).V_n),
    "7": Proof(follows("impulse and momentum", newton), lambda x: _after(x).V_t),
    "8": Proof(
        follows("angular momentum", newton),
        lambda x: _after(x).Omega,
        lambda at: at.printed(omega=0.0) / at.used(omega=0.0),
    ),
    "9": Proof(
        follows("deformation impulses of approach and rebound", adhesion),
        lambda x: x["m"] * algebra.deformation_impulse(x["v_n"], x["R"]),
    ),
    "10": Proof(
        follows("momentum of rebound R (1 - rho)", adhesion),
        lambda x: x["m"] * algebra.adhesion_impulse(x["v_n"], x["R"], x["rho"]),
    ),
    "3.1.2 contact velocity": Proof(follows("kinematics of a rigid body", contact_velocity)),
    "11": Proof(
        follows("momentum and kinematics", newton),
        lambda x: _after(x).V_t - x["r"] * _after(x).Omega,
        lambda at: (at.printed(v_t=0.0, omega=0.0)) / at.used(v_t=0.0, omega=0.0),
    ),
    "12": Proof(
        follows("V_Ct = 0", newton),
        lambda x: algebra.rolling_impulse_ratio(x["v_n"], x["v_t"] - x["r"] * x["omega"], x["e"]),
        lambda at: (1.0 + at.values()["e"]) ** 2,
    ),
}
