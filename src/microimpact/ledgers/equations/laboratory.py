"""Sections 2.1 to 2.4: measured velocities and the three parameters formed from them."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import sympy

from microimpact.core.constants import gravity
from microimpact.lab.pdpa.pairing import correct
from microimpact.ledgers.equations.forms import Form, symbols
from microimpact.ledgers.equations.impulses import _after, newton
from microimpact.ledgers.equations.records import (
    Case,
    Consequence,
    Derivation,
    Equation,
    Facts,
    Values,
    follows,
    where_one,
)
from microimpact.model.rigid_body import algebra

PROBE_HEIGHT = 1e-3  # m, Section 2.1

alpha, e, eta, g, h, m, mu, omega, r = symbols("alpha e eta g h m mu omega r")
v, V, v_n, v_t, v_probe, V_probe, Omega, T_L = symbols("v V v_n v_t v_probe V_probe Omega T_L")
eta_rate, eta_s_rate, eta_squared_rate = symbols("eta_rate eta_s_rate eta_squared_rate")


@cache
def free_fall() -> Facts:
    """Speeds at the surface, from those in the probe or from rest, by conservation of energy."""
    return {
        at_surface: where_one((m * at_surface**2 / 2) / (m * probe**2 / 2 + m * g * h), at_surface)
        for at_surface, probe in ((v, v_probe), (V, V_probe))
    }


@cache
def rolling_loss() -> sympy.Expr:
    """Translational loss of a sphere that arrives at an angle without spin and leaves rolling."""
    state = {name: value.subs(mu, newton()[symbols("mu_0")[0]]) for name, value in newton().items()}
    V_n, V_t = symbols("V_n V_t")
    arriving = {omega: 0, v_n: -v * sympy.sin(alpha), v_t: v * sympy.cos(alpha)}
    kept = (state[V_n] ** 2 + state[V_t] ** 2).subs(arriving)
    return 1 - kept / v**2


def normal_incidence() -> Facts:
    """What happens at 90 degrees without spin: no tangential impulse, loss by the limit."""
    return {T_L: rolling_loss().subs(alpha, sympy.pi / 2), omega: 0, Omega: 0, V: e * v}


def _growth(form: Form, _: Case) -> bool:
    """Compare how fast |eta| and its square grow as the angle falls, everywhere below 45 deg."""
    size = sympy.cot(alpha)
    rates = {eta_rate: -size.diff(alpha), eta_squared_rate: -(size**2).diff(alpha)}
    gap = form.residual.subs(rates | {eta_s_rate: rates[eta_squared_rate]})
    at = np.linspace(0.01, np.pi / 4, 50)
    return form.relation == ">" and bool(np.all(sympy.lambdify(alpha, gap)(at) > 0.0))


def _restitution(speed: float, e: float) -> float:
    """Return the restitution found from probe velocities by the constant correction."""
    surface = np.array([-speed, e * speed])
    probe = np.sign(surface) * np.sqrt(surface**2 - 2.0 * gravity * PROBE_HEIGHT)
    found = np.asarray(correct(probe, PROBE_HEIGHT, "printed"))
    return float(-found[1] / found[0])


def _loss(x: Values) -> Any:
    given = (x[name] for name in ("v_n", "v_t", "omega", "r", "e", "mu"))
    return algebra.energy_loss(*given).translational


EQUATIONS = (
    Equation(
        "2.1 fall",
        "v = sqrt(2*g*h)",
        derivation=follows("energy of free fall", lambda: {v: free_fall()[v].subs(v_probe, 0)}),
        reason="Heights of 0.01 to 1.0 m give 0.44 to 4.4 m/s, as the text says.",
        function="microimpact.lab.dispenser.drop_height",
    ),
    Equation(
        "2.1 incident",
        "v = v_probe + sqrt(2*g*h)",
        used=("article", "v = sqrt(v_probe**2 + 2*g*h)"),
        derivation=follows("energy of free fall", free_fall),
        reason="Gravity adds a constant to the square of a velocity, not to the velocity.",
        function="microimpact.lab.pdpa.pairing.correct",
        implementation=lambda x: -correct(-x["v_probe"], x["h"]),
        consequence=Consequence(
            "restitution found for 0.70 at 1.6 m/s, probe 1 mm above the surface",
            lambda _: _restitution(1.6, 0.70),
        ),
    ),
    Equation(
        "2.1 rebound",
        "V = V_probe + sqrt(2*g*h)",
        used=("article", "V = sqrt(V_probe**2 + 2*g*h)"),
        derivation=follows("energy of free fall", free_fall),
        reason="Gravity adds a constant to the square of the rebound velocity, too; rebounds "
        "slower than sqrt(2gh) never reach the probe.",
        function="microimpact.lab.pdpa.pairing.correct",
        implementation=lambda x: correct(x["V_probe"], x["h"]),
        consequence=Consequence(
            "restitution found for 0.40 at 0.5 m/s, probe 1 mm above the surface",
            lambda _: _restitution(0.5, 0.40),
        ),
    ),
    Equation(
        "1",
        "e = -V_n/v_n",
        reason="Defines the kinematic coefficient of restitution.",
        function="microimpact.model.rigid_body.algebra.rigid_body_rebound",
        implementation=lambda x: -_after(x).V_n / x["v_n"],
    ),
    Equation(
        "2",
        "mu = (V_t - v_t)/(V_n - v_n)",
        derivation=follows("impulse and momentum", newton),
        reason="Equals Eq. (4). It is negative where friction opposes v_t > 0; the plots show "
        "its absolute value.",
        function="microimpact.model.dynamics.impact.planar",
    ),
    Equation(
        "3",
        "T_L = (v**2 - V**2)/v**2",
        derivation=follows(
            "kinetic energies", lambda: {T_L: (m * v**2 / 2 - m * V**2 / 2) / (m * v**2 / 2)}
        ),
        reason="Dimensionless, and translational only; Eqs. (14) and (17) use the symbol for "
        "an energy in joules.",
        function="microimpact.model.rigid_body.algebra.energy_loss",
        implementation=_loss,
    ),
    Equation(
        "2.3.1 normal loss",
        "T_L = 1 - e**2",
        derivation=follows("rolling loss at 90 degrees", normal_incidence),
        reason="Eq. (3) with V = e v.",
        function="microimpact.model.rigid_body.algebra.energy_loss",
        implementation=lambda x: (
            algebra.energy_loss(-x["v"], 0, 0, x["r"], x["e"], 0).translational
        ),
    ),
    Equation(
        "2.4.2 rotational loss",
        "T_L = I*(omega**2 - Omega**2)/(m*v**2)",
        used=("article", "T_L = (v**2 - V**2)/v**2"),
        derivation=follows("loss 1 - e^2 at 90 degrees", normal_incidence),
        reason="The text calls it rotational, but its limit 1 - e^2 at high angles and the "
        "caption belong to Eq. (3).",
        function="microimpact.model.rigid_body.algebra.energy_loss",
        implementation=_loss,
        consequence=Consequence(
            "rotational loss, a gain, of a sphere without initial spin that slides",
            lambda at: at.printed(omega=0.0),
        ),
    ),
    Equation(
        "2.4.2 high angles",
        "T_L = 1 - e**2",
        derivation=follows("rolling loss, limit of 90 degrees", normal_incidence),
        reason="The limit of rolling without spin, (1 - e^2) sin^2 + (24/49) cos^2 of the angle.",
        function="microimpact.model.rigid_body.algebra.energy_loss",
        consequence=Consequence(
            "excess over the loss of a rolling sphere at 50 degrees",
            lambda at: (
                at.printed()
                - float(rolling_loss().subs({alpha: np.radians(50.0), e: at.values()["e"]}))
            ),
        ),
    ),
    Equation(
        "2.4.2 eta",
        "eta = atan(alpha)",
        used=("scan or article", "eta = -cot(alpha)"),
        derivation=follows(
            "components of a velocity", lambda: {eta: -sympy.cos(alpha) / sympy.sin(alpha)}
        ),
        reason="The raised -1 means 1/tan here, and the minus sign follows from v_n < 0.",
        function="microimpact.model.dynamics.impact.velocity_components",
        consequence=Consequence(
            "in place of -1.73 at 30 degrees", lambda at: at.printed(alpha=np.pi / 6)
        ),
    ),
    Equation(
        "2.4.2 eta_s",
        "eta_rate > eta_s_rate",
        used=("scan or article", "eta_squared_rate > eta_rate"),
        derivation=Derivation("numeric: slopes below 45 degrees", _growth),
        reason="eta_s is not defined. Read as the square of eta, it grows faster than eta, as "
        "the text says.",
    ),
)
