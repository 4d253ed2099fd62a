"""Section 3.2, Eqs. (19) to (25): normal contact, stiffness and damping of the simulation."""

from __future__ import annotations

from functools import cache, partial
from typing import Any

import sympy

from microimpact.model.contact import hertz_stiffness
from microimpact.model.dynamics.trajectory import Trajectory, trajectory
from study.equations.forms import symbols
from study.equations.records import Facts, Proof, Values, follows, where_one

# Moment of the traced impact at which forces are compared: rebound, still pressed together.
TRACED_POINTS, TRACED_MOMENT = 400, 240


a, c_A, c_H, f_0, K, m, n, r, R, r_S, R_S, v_n = symbols("a c_A c_H f_0 K m n r R r_S R_S v_n")
E_1, E_2, k_1, k_2, nu_1, nu_2 = symbols("E_1 E_2 k_1 k_2 nu_1 nu_2")
n_dot, n_ddot, T_H, zeta_A, zeta_H = symbols("n_dot n_ddot T_H zeta_A zeta_H")


@cache
def hertz() -> Facts:
    """Contact radius, and stiffness K = load / (r^(1/2) (-n)^(3/2)), from the pressure of Hertz.

    The semi-ellipsoidal pressure sinks the centre by (2/E*) times its integral over the radius,
    and the edge by half of that.
    """
    angle, peak, d = sympy.symbols("angle p_0 d", positive=True)
    compliance = (1 - nu_1**2) / E_1 + (1 - nu_2**2) / E_2
    at, pressure = sympy.sin(angle), peak * sympy.cos(angle)
    radius = where_one(a**2 / (2 * r) / (d - d / 2), a)
    whole = (angle, 0, sympy.pi / 2)
    sunk = 2 * compliance * radius * sympy.integrate(pressure * at.diff(angle), whole)
    load = 2 * sympy.pi * radius**2 * sympy.integrate(pressure * at * at.diff(angle), whole)
    load = load.subs(peak, where_one(sunk / d, peak))
    return {
        a: radius.subs(d, -n),
        K: load / (sympy.sqrt(r) * d ** sympy.Rational(3, 2)),
        k_1: (1 - nu_1**2) / (sympy.pi * E_1),
        k_2: (1 - nu_2**2) / (sympy.pi * E_2),
    }


def curvature() -> Facts:
    """Radius of the sphere that leaves the same gap to a plane as both surfaces leave."""
    x = sympy.Symbol("x", positive=True)
    gap = x**2 / (2 * R_S) + x**2 / (2 * r_S)
    return {r: x**2 / (2 * gap)}


@cache
def newton() -> Facts:
    """Acceleration under the forces of Hertz and ring, each damped so that it costs energy."""
    radius = hertz()[a]
    elastic = sympy.sqrt(r) * K * (-n) ** sympy.Rational(3, 2)
    attraction = 2 * sympy.pi * radius * f_0
    material, adhesive = -elastic * c_H * n_dot, -attraction * c_A * n_dot
    if not all((force * n_dot).is_nonpositive for force in (material, adhesive)):
        raise AssertionError("damping must not give energy")
    return {n_ddot: (elastic - attraction + material + adhesive) / m, a: radius}


@cache
def time_scale() -> sympy.Expr:
    """Time T at which inertia m (v T)/T^2 equals the Hertz force at the distance v T."""
    T = sympy.Symbol("T", positive=True)
    force = sympy.sqrt(r) * K * (-v_n * T) ** sympy.Rational(3, 2)
    return where_one(force / (m * -v_n * T / T**2), T)


def damping() -> Facts:
    """Damping as the radius over the way at the time scale, on a plane (R = r)."""
    return {R: r, zeta_H: r * c_H / time_scale(), zeta_A: r * c_A / time_scale()}


def scaled_newton() -> Facts:
    """Acceleration with the damping coefficients written by zeta."""
    by_zeta = {c_H: zeta_H * time_scale() / r, c_A: zeta_A * time_scale() / r}
    return {n_ddot: newton()[n_ddot].subs(by_zeta), R: r}


@cache
def period() -> sympy.Expr:
    """Period of contact by Hertz: twice the time to the depth that stops the sphere."""
    d = sympy.Symbol("d", positive=True)
    stored = sympy.Rational(2, 5) * sympy.sqrt(r) * K * d ** sympy.Rational(5, 2)
    deepest = where_one(stored / (m * v_n**2 / 2), d)
    # integral of (1 - y^(5/2))^(-1/2) from 0 to 1
    share = sympy.Rational(2, 5) * sympy.beta(sympy.Rational(2, 5), sympy.Rational(1, 2))
    return 2 * deepest / -v_n * share


def traced(x: Values) -> Trajectory:
    """Return the impact in time."""
    return trajectory(x["contact"], x["v"], x["angle"], points=TRACED_POINTS)


def _over_unit(name: str, x: Values) -> Any:
    return getattr(x["contact"], name) / x["contact"].damping_unit


PROOFS = {
    "19": Proof(
        follows("Hertz, ring force, damping that costs energy", newton),
        lambda x: traced(x).normal_force[TRACED_MOMENT],
        lambda at: at.values()["K"] ** -0.5,
    ),
    "3.2 contact radius": Proof(follows("pressure of Hertz", hertz)),
    "20": Proof(
        follows("pressure of Hertz", hertz),
        lambda x: hertz_stiffness(x["contact"].particle, x["contact"].surface),
        lambda at: at.printed() / at.used(),
    ),
    "22": Proof(
        follows("gap between two paraboloids", curvature),
        lambda x: x["contact"].replace(surface_radius=x["r_S"]).hertz_radius,
    ),
    **{
        number: Proof(
            follows("time scale of Hertz impact", damping),
            partial(_over_unit, name),
            lambda at: 1.0 / at.printed(c_H=1.0, c_A=1.0, v_n=at.values()["v"]),
        )
        for number, name in (("23", "hertz_damping"), ("24", "adhesion_damping"))
    },
    "23 period": Proof(
        follows("period of Hertz contact", lambda: {T_H: period()}),
        consequence=lambda _: sympy.powdenest(period() / time_scale(), force=True).evalf(),
    ),
    "25": Proof(
        follows("Eq. (19) with zeta of Eqs. (23), (24)", scaled_newton),
        lambda x: traced(x).normal_force[TRACED_MOMENT],
    ),
}
