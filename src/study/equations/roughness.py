"""Section 4.1.2, Eqs. (39) to (41): normal incidence on a slope."""

from __future__ import annotations

from functools import cache

import numpy as np
import sympy

from microimpact.model.rigid_body import algebra, roughness
from study.equations import impulses
from study.equations.forms import Form, symbols, vanishes
from study.equations.records import (
    Derivation,
    Facts,
    Proof,
    ReferenceCase,
    expands,
    follows,
    leading,
)

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
    second, first = (leading(measured, "alpha phi", order) for order in (1, 0))
    return {small: sympy.cancel(-(second - first) / (phi / alpha))}


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


def _exceeds(form: Form, _: ReferenceCase) -> bool:
    """Leading order at phi = alpha, for every e."""
    measured = leading(sliding()[e_m], "alpha phi", 0).subs(phi, alpha)
    gap = sympy.cancel(form.residual.subs(e_m, measured))
    return form.relation == ">" and bool(gap.is_positive)


PROOFS = {
    "35": Proof(
        follows("rotation of velocities", rotation),
        lambda x: roughness.measured_restitution(
            *(x["alpha"], x["phi"], x["e"], (x["vp_t"] - x["Vp_t"]) / ((1.0 + x["e"]) * x["vp_n"]))
        ),
        lambda _: float(roughness.measured_restitution(STEEP, STEEP, 0.70, -0.15, printed=True)),
    ),
    "36": Proof(
        follows("rotation of impulses", rotation),
        lambda x: roughness.measured_impulse_ratio(x["phi"], x["mu"]),
    ),
    "37": Proof(
        expands("shallow angles, leading order", sliding, "alpha phi", 0),
        lambda x: roughness.shallow_restitution(
            x["alpha"], x["phi"], x["e"], x["mu"], printed=True
        ),
        lambda _: float(roughness.shallow_restitution(STEEP, STEEP, 0.70, -0.15, printed=True)),
    ),
    "4.1.1 condition": Proof(
        follows("next order of Eq. (37)", friction_share),
        consequence=lambda at: at.printed(f=0.15, alpha=0.1),
    ),
    "4.1.1 excess": Proof(Derivation("series: leading order at phi = alpha", _exceeds)),
    "38": Proof(
        expands("small slope and friction, first order", rotation, "mu phi", 1),
        lambda x: roughness.sloped_impulse_ratio(x["phi"], x["mu"], printed=True),
    ),
    "4.1.2 velocity": Proof(follows("components at 90 degrees", normal_incidence)),
    "39": Proof(
        expands("normal incidence, second order", normal_incidence, "phi", 2),
        lambda x: roughness.normal_restitution(x["phi"], x["e"], x["mu_c"]),
        lambda at: at.printed(phi=STEEP) - at.used(phi=STEEP),
    ),
    "40": Proof(
        follows("Eq. (12) along the local surface", critical),
        lambda x: algebra.rolling_impulse_ratio(x["vp_n"], x["vp_t"] - x["r"] * x["omega"], x["e"]),
    ),
    "4.1.2 impulse ratio": Proof(
        expands("rolling without spin, first order", without_spin, "phi", 1),
        consequence=lambda at: at.printed(phi=STEEP),
    ),
    "4.1.2 restitution": Proof(
        expands("rolling without spin, second order", without_spin, "phi", 2),
        lambda x: roughness.rolling_restitution(x["phi"], x["e"]),
        lambda at: at.printed(phi=STEEP) - at.used(phi=STEEP),
    ),
    "41": Proof(
        expands("rolling with spin, first order", rolling, "phi omega", 1),
        consequence=lambda _: float(
            roughness.rolling_impulse_ratio_measured(0.0, 0.70, 0.2, printed=True)
        ),
    ),
}
