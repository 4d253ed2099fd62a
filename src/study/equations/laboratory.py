"""Sections 2.1 to 2.4: measured velocities and the three parameters formed from them."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import sympy

from microimpact.core.constants import gravity
from microimpact.lab.pdpa.pairing import correct
from microimpact.model.rigid_body import algebra
from study.equations.forms import Form, symbols
from study.equations.impulses import _after, newton
from study.equations.records import (
    Derivation,
    Facts,
    Proof,
    ReferenceCase,
    Values,
    follows,
    where_one,
)

PROBE_HEIGHT = 1e-3  # m, Section 2.1

alpha, e, eta, g, h, m, mu, mu_0, omega, r = symbols("alpha e eta g h m mu mu_0 omega r")
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
    state = {name: value.subs(mu, newton()[mu_0]) for name, value in newton().items()}
    V_n, V_t = symbols("V_n V_t")
    arriving = {omega: 0, v_n: -v * sympy.sin(alpha), v_t: v * sympy.cos(alpha)}
    kept = (state[V_n] ** 2 + state[V_t] ** 2).subs(arriving)
    return 1 - kept / v**2


def normal_incidence() -> Facts:
    """Impact at 90 degrees without spin: no tangential impulse, loss by the limit."""
    return {T_L: rolling_loss().subs(alpha, sympy.pi / 2), omega: 0, Omega: 0, V: e * v}


def rolled_already() -> Facts:
    """Impulse ratio of rolling for a sphere whose contact point does not slip on arrival."""
    return {mu_0: newton()[mu_0].subs(omega, v_t / r)}


def _growth(form: Form, _: ReferenceCase) -> bool:
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
    speeds = np.asarray(correct(probe, PROBE_HEIGHT, "printed"))
    return float(-speeds[1] / speeds[0])


def _loss(x: Values) -> Any:
    values = (x[name] for name in ("v_n", "v_t", "omega", "r", "e", "mu"))
    return algebra.energy_loss(*values).translational


PROOFS = {
    "2.1 fall": Proof(follows("energy of free fall", lambda: {v: free_fall()[v].subs(v_probe, 0)})),
    "2.1 incident": Proof(
        follows("energy of free fall", free_fall),
        lambda x: -correct(-x["v_probe"], x["h"]),
        lambda _: _restitution(1.6, 0.70),
    ),
    "2.1 rebound": Proof(
        follows("energy of free fall", free_fall),
        lambda x: correct(x["V_probe"], x["h"]),
        lambda _: _restitution(0.5, 0.40),
    ),
    "1": Proof(computed=lambda x: -_after(x).V_n / x["v_n"]),
    "2": Proof(follows("impulse and momentum", newton)),
    "3": Proof(
        follows("kinetic energies", lambda: {T_L: (m * v**2 / 2 - m * V**2 / 2) / (m * v**2 / 2)}),
        _loss,
    ),
    "2.3.1 normal loss": Proof(
        follows("rolling loss at 90 degrees", normal_incidence),
        lambda x: algebra.energy_loss(-x["v"], 0, 0, x["r"], x["e"], 0).translational,
    ),
    "2.4.2 high angles": Proof(
        follows("rolling loss, limit of 90 degrees", normal_incidence),
        consequence=lambda at: (
            at.printed()
            - float(rolling_loss().subs({alpha: np.radians(50.0), e: at.values()["e"]}))
        ),
    ),
    "2.4.2 zero friction": Proof(
        follows("Eq. (12) at r omega = v_t", rolled_already),
        lambda x: algebra.rolling_impulse_ratio(x["v_n"], 0.0, x["e"]),
    ),
    "2.4.2 eta": Proof(
        follows("components of a velocity", lambda: {eta: -sympy.cos(alpha) / sympy.sin(alpha)}),
        consequence=lambda at: at.printed(alpha=np.pi / 6),
    ),
    "2.4.2 eta_s": Proof(Derivation("numeric: slopes below 45 degrees", _growth)),
}
