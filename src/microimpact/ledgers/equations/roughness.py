"""Section 4.1.2, Eqs. (39) to (41): normal incidence on a slope."""

from __future__ import annotations

from functools import cache

import numpy as np
import sympy

from microimpact.ledgers.equations import impulses
from microimpact.ledgers.equations.forms import Form, symbols, vanishes
from microimpact.ledgers.equations.records import (
    Case,
    Consequence,
    Derivation,
    Equation,
    Facts,
    expands,
    follows,
    leading,
)
from microimpact.model.rigid_body import algebra, roughness

alpha, e, e_m, f, mu, mu_0, mu_c = symbols("alpha e e_m f mu mu_0 mu_c")
mu_m, omega, phi, r, small = symbols("mu_m omega phi r small")
v, v_t, vp_n, vp_t, Vp_t, v_omega = symbols("v v_t vp_n vp_t Vp_t v_omega")

STEEP = np.radians(10.0)


@cache
def rotation() -> Facts:
    """Measured coefficients, and velocities along the local surface, of an impact on a slope.

    Components about the nominal normal are those about the local one, turned by the slope; the
    sphere arrives at the nominal angle alpha.
    """
    local = alpha + phi
    turn = sympy.Matrix([[sympy.cos(phi), -sympy.sin(phi)], [sympy.sin(phi), sympy.cos(phi)]])
    before = sympy.Matrix([v * sympy.cos(local), -v * sympy.sin(local)])
    arrived = sympy.Matrix([v * sympy.cos(alpha), -v * sympy.sin(alpha)])
    if not all(map(vanishes, turn * before - arrived)):
        raise AssertionError("the rotation does not give the nominal angle")
    after = turn * sympy.Matrix([Vp_t, -e * before[1]])
    impulse_t, impulse_n = turn * sympy.Matrix([mu, 1])
    return {
        vp_t: before[0],
        vp_n: before[1],
        v_t: arrived[0],
        e_m: -after[1] / arrived[1],
        mu_m: impulse_t / impulse_n,
    }


@cache
def rebound() -> Facts:
    """The same with the momentum of Eq. (7) about the local normal."""
    known = rotation()
    along = known[vp_t] - mu * (1 + e) * known[vp_n]
    return {**known, e_m: known[e_m].subs(Vp_t, along)}


def sliding() -> Facts:
    """Of a sphere that slides throughout, v_t > 0: mu = -f; its slope acts by `small`."""
    measured = rebound()[e_m].subs(mu, -f)
    return {e_m: measured, mu: -f}


@cache
def friction_share() -> Facts:
    """Next order of e_m at shallow angles, over the excess phi/alpha that Eq. (37) is about."""
    measured = sliding()[e_m]
    two, one = (leading(measured, "alpha phi", order) for order in (1, 0))
    return {small: sympy.cancel(-(two - one) / (phi / alpha))}


@cache
def normal_incidence() -> Facts:
    """Of a nominal angle of 90 degrees; mu_c is whatever impulse ratio the sphere has."""
    at = {name: value.subs(alpha, sympy.pi / 2) for name, value in rebound().items()}
    return {**at, e_m: at[e_m].subs(mu, mu_c)}


@cache
def rolling() -> Facts:
    """The same for a sphere that leaves rolling; v_omega is read as omega."""
    known = normal_incidence()
    spun = critical()[mu_0].subs({vp_n: known[vp_n], vp_t: known[vp_t]})
    return {
        e_m: known[e_m].subs(mu_c, spun),
        mu_m: known[mu_m].subs(mu, spun),
        mu_c: spun,
        vp_n: known[vp_n],
        v_omega: omega,
    }


def without_spin() -> Facts:
    """The same without initial spin."""
    return {name: value.subs(omega, 0) for name, value in rolling().items() if name != v_omega}


def critical() -> Facts:
    """Impulse ratio that just ends slip along the local surface."""
    local = {impulses.v_n: vp_n, impulses.v_t: vp_t}
    return {mu_0: impulses.newton()[impulses.mu_0].subs(local), v_omega: omega}


def _exceeds(form: Form, _: Case) -> bool:
    """Leading order at phi = alpha, for every e."""
    measured = leading(sliding()[e_m], "alpha phi", 0).subs(phi, alpha)
    gap = sympy.cancel(form.residual.subs(e_m, measured))
    return form.relation == ">" and bool(gap.is_positive)


EQUATIONS = (
    Equation(
        "35",
        "e_m = (e*cos(phi) - Vp_t*sin(phi)/vp_n)/(cos(phi) - vp_t*sin(phi)/vp_n)",
        used=(
            "scan or article",
            "e_m = (e*cos(phi) - Vp_t*sin(phi)/vp_n)/(cos(phi) + vp_t*sin(phi)/vp_n)",
        ),
        derivation=follows("rotation of velocities", rotation),
        reason="One rotation gives the numerator and Eq. (36); the same rotation gives a plus "
        "sign in the denominator.",
        function="microimpact.model.rigid_body.roughness.measured_restitution",
        implementation=lambda x: roughness.measured_restitution(
            *(x["alpha"], x["phi"], x["e"], (x["vp_t"] - x["Vp_t"]) / ((1.0 + x["e"]) * x["vp_n"]))
        ),
        consequence=Consequence(
            "e_m at phi = alpha = 10 degrees, e = 0.70, f = 0.15, in place of 2.21",
            lambda _: float(
                roughness.measured_restitution(STEEP, STEEP, 0.70, -0.15, printed=True)
            ),
        ),
    ),
    Equation(
        "36",
        "mu_m = (mu - tan(phi))/(1 + mu*tan(phi))",
        derivation=follows("rotation of impulses", rotation),
        reason="The impulse rotated by the slope.",
        function="microimpact.model.rigid_body.roughness.measured_impulse_ratio",
        implementation=lambda x: roughness.measured_impulse_ratio(x["phi"], x["mu"]),
    ),
    Equation(
        "37",
        "e_m = (1 + phi/alpha)*(e + phi/(phi + alpha))",
        derivation=expands("shallow angles, leading order", sliding, "alpha phi", 0),
        reason="Leading order of the exact form; friction enters at the next.",
        function="microimpact.model.rigid_body.roughness.shallow_restitution",
        implementation=lambda x: roughness.shallow_restitution(
            x["alpha"], x["phi"], x["e"], x["mu"], printed=True
        ),
        consequence=Consequence(
            "e_m at phi = alpha = 10 degrees, e = 0.70, where it is 2.21 with f = 0.15",
            lambda _: float(roughness.shallow_restitution(STEEP, STEEP, 0.70, -0.15, printed=True)),
        ),
    ),
    Equation(
        "4.1.1 condition",
        "small = f/alpha",
        used=("scan or article", "small = f*(1 + e)*(alpha + phi)"),
        derivation=follows("next order of Eq. (37)", friction_share),
        reason="This is what friction takes from the excess phi/alpha, so this must be small; a "
        "product read as a fraction would explain the printed form.",
        function="microimpact.model.rigid_body.roughness.shallow_restitution",
        consequence=Consequence(
            "parameter said to be small at f = 0.15, alpha = 0.1",
            lambda at: at.printed(f=0.15, alpha=0.1),
        ),
    ),
    Equation(
        "4.1.1 excess",
        "e_m > 2*e",
        derivation=Derivation("series: leading order at phi = alpha", _exceeds),
        reason="Eq. (37) gives 2 e + 1 at that slope.",
        function="microimpact.model.rigid_body.roughness.shallow_restitution",
    ),
    Equation(
        "38",
        "mu_m = mu - phi",
        derivation=expands("small slope and friction, first order", rotation, "mu phi", 1),
        reason="First order in slope and friction; for any friction it is mu - (1 + mu^2) phi. A "
        "slope that faces the sphere lowers mu = -f and so raises the plotted absolute value.",
        function="microimpact.model.rigid_body.roughness.sloped_impulse_ratio",
        implementation=lambda x: roughness.sloped_impulse_ratio(x["phi"], x["mu"], printed=True),
    ),
    Equation(
        "4.1.2 velocity",
        "v_r = 0",
        used=("scan", "v_t = 0"),
        derivation=follows("components at 90 degrees", normal_incidence),
        reason="The tangential velocity is meant; v_r is not defined.",
        function="microimpact.model.dynamics.impact.velocity_components",
    ),
    Equation(
        "39",
        "e_m = e - phi**2 + (1 + e)*mu_c*phi",
        used=("article", "e_m = e - (1 + e)*phi**2 + (1 + e)*mu_c*phi"),
        derivation=expands("normal incidence, second order", normal_incidence, "phi", 2),
        reason="The denominator of Eq. (35) brings another -e phi^2; mu_c is mu_0.",
        function="microimpact.model.rigid_body.roughness.normal_restitution",
        implementation=lambda x: roughness.normal_restitution(x["phi"], x["e"], x["mu_c"]),
        consequence=Consequence(
            "excess of e_m on a slope of 10 degrees, e = 0.70",
            lambda at: at.printed(phi=STEEP) - at.used(phi=STEEP),
        ),
    ),
    Equation(
        "40",
        "mu_0 = 2/(7*(1 + e))*(vp_t - r*v_omega)/vp_n",
        used=("scan", "mu_0 = 2/(7*(1 + e))*(vp_t - r*omega)/vp_n"),
        derivation=follows("Eq. (12) along the local surface", critical),
        reason="The letter v before omega is no symbol of the article.",
        function="microimpact.model.rigid_body.algebra.rolling_impulse_ratio",
        implementation=lambda x: algebra.rolling_impulse_ratio(
            x["vp_n"], x["vp_t"] - x["r"] * x["omega"], x["e"]
        ),
    ),
    Equation(
        "4.1.2 impulse ratio",
        "(1 + e)*mu_c = -2*phi/7",
        used=("article", "(1 + e)*mu_c = 2*phi/7"),
        derivation=expands("rolling without spin, first order", without_spin, "phi", 1),
        reason="v'_t/v'_n is +tan(phi) at normal incidence; Eq. (41) has it so.",
        function="microimpact.model.rigid_body.roughness.rolling_restitution",
        consequence=Consequence(
            "(1 + e) mu_0 on a slope of 10 degrees, in place of +0.0499",
            lambda at: at.printed(phi=STEEP),
        ),
    ),
    Equation(
        "4.1.2 restitution",
        "e_m = e - 9*phi**2/7",
        used=("article", "e_m = e - (e + 5/7)*phi**2"),
        derivation=expands("rolling without spin, second order", without_spin, "phi", 2),
        reason="Two slips, the sign of mu_c and the missing e phi^2, cancel only at e = 4/7.",
        function="microimpact.model.rigid_body.roughness.rolling_restitution",
        implementation=lambda x: roughness.rolling_restitution(x["phi"], x["e"]),
        consequence=Consequence(
            "excess of e_m on a slope of 10 degrees, e = 0.70",
            lambda at: at.printed(phi=STEEP) - at.used(phi=STEEP),
        ),
    ),
    Equation(
        "41",
        "mu_m = -phi*(1 - (2/7)/(1 + e)) + (2/7)/(1 + e)*r*v_omega/vp_n",
        used=("article", "mu_m = -phi*(1 - (2/7)/(1 + e)) - (2/7)/(1 + e)*r*omega/vp_n"),
        derivation=expands("rolling with spin, first order", rolling, "phi omega", 1),
        reason="v'_n < 0, so the spin term has a minus sign; a plus sign would need v'_n as a "
        "speed.",
        function="microimpact.model.rigid_body.roughness.rolling_impulse_ratio_measured",
        consequence=Consequence(
            "mu_m on a level surface by a spin of r omega/v = 0.2, in place of +0.0336",
            lambda _: float(roughness.rolling_impulse_ratio_measured(0.0, 0.70, 0.2, printed=True)),
        ),
    ),
)
